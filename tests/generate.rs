//! Generated equations against an independent account of the dynamics.

mod reference;
