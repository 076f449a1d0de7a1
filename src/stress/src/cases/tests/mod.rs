//! The figures of cases by other means.

mod contact;
mod drift;
mod far;
mod springs;
