//! Models in motion: physical laws that a simulation must obey.

mod command;
mod conservation;
mod contact;
mod equations;
mod examples;
mod failures;
mod fmu;
mod forces;
mod models;
mod runs;
mod tyre;
mod whole_step;
