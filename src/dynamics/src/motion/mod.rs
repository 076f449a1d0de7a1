//! A model in motion: its equations evaluated, solved and integrated in time.
//!
//! This module tests from end to end that a model, its generated equations and
//! the passes over them agree: the motion follows from the equations alone,
//! while energies and the work of forces are computed from the model. Where one
//! of them is wrong, energy is lost or a loop opens.

pub mod contact;
mod energy;
mod equations;
mod equilibrium;
mod error;
pub mod events;
mod free;
mod generated_loops;
pub mod integrate;
pub mod laws;
mod linearise;
mod loads;
mod modes;
pub mod plot;
mod read_laws;
mod simulation;
mod solving;
mod system;
mod tyre;
mod tyre_entry;
mod varied;

pub use contact::Contact;
pub use equations::{EquationSetting, MotionEquations};
pub use equilibrium::Equilibrium;
pub use error::MotionError;
pub use events::{EVENT_TOLERANCE, EventDirection, EventLaw, EventQuantity, EventRecord};
pub use free::{Calculus, Drift, FreeMotion, Stepping};
pub use generated_loops::LoopKeeping;
pub use laws::{Drive, Laws, Spring, Support};
pub use linearise::SmallMotions;
pub use loads::Energy;
pub use modes::{ComplexNumber, Mode, modes};
pub use simulation::{
    IntegrationMethod, MotionSample, SimulationPlan, SimulationRun, mean_position, simulate,
};
pub use system::{EvaluationWork, MultibodySystem};
pub use tyre::{MagicFormula, ROLLING_VELOCITY, SlipLaw, Tyre};
pub use varied::PointMotion;

#[cfg(test)]
mod tests;
