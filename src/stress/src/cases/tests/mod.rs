//! The figures of cases, computed by other methods.

mod contact;
mod drift;
mod far;
mod springs;
