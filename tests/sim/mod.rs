//! Models in motion: what physics demands of a simulation from end to end.

mod command;
mod conservation;
mod contact;
mod equations;
mod examples;
mod failures;
mod forces;
mod models;
mod runs;
mod whole_step;
