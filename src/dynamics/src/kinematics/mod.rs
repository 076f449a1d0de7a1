//! Models in a state: the inputs that their equations read there, and their
//! loops closed.
//!
//! This module takes equations as input, so that their generator can use it to
//! choose dependent joints and pivots, and simulations in time use the same
//! Newton steps.

mod closing;
mod compiled;
mod constraints;
mod error;
pub(crate) mod inputs;
pub mod linear;
mod partition;
mod states;

pub use closing::{ClosingLimits, LoopClosure};
pub use compiled::{CompiledFunction, EvaluatedOutputs};
pub use constraints::LoopConstraints;
pub use error::StateError;
pub(crate) use error::named_joints;
pub use inputs::{InputSources, MotionState, element_name, parameter};
pub use partition::{Partition, stack};
pub use states::closed_states;
