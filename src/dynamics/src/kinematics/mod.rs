//! Models in a state: the inputs of their equations there, and loops closed.
//!
//! This module takes equations as input, so that their generator chooses
//! dependent joints and pivots by it, and simulations use the same steps.

mod closing;
mod compiled;
pub(crate) mod inputs;
pub mod linear;
mod partition;

pub use closing::{ClosingLimits, LoopClosure, LoopConstraints};
pub use compiled::{CompiledFunction, EvaluatedOutputs};
pub use inputs::{InputSources, MotionState, closed_states, element_name, parameter};
pub use partition::{Partition, stack};

use thiserror::Error;

/// Reason why a model cannot get into a state, or has no equations there.
#[derive(Clone, PartialEq, Debug, Error)]
pub enum StateError {
    /// The equations read an element that the model does not have.
    #[error("the function '{function}' reads {element}, which the model does not have")]
    Element {
        /// The function.
        function: String,
        /// The input element.
        element: String,
    },
    /// A loop does not close.
    #[error(
        "at {time:?} s the cut '{cut}' cannot be closed: its ends {} {gap:.3e}{}",
        if *rod { "miss the length of the rod by" } else { "stay" },
        if *rod { "" } else { " apart" }
    )]
    OpenLoop {
        /// Name of the cut.
        cut: String,
        /// The largest residual of its rows; of a rod, distance less length, m.
        gap: f64,
        /// True when the cut is a rod.
        rod: bool,
        /// Time, s.
        time: f64,
    },
    /// A constraint that followed from others does so no longer.
    #[error(
        "at {time:?} s the cut '{cut}' opens: one of its constraints followed from the others \
         where the joints were divided, and no longer does"
    )]
    Overdetermined {
        /// Name of the cut.
        cut: String,
        /// Time, s.
        time: f64,
    },
    /// Something became infinite or undefined.
    #[error("at {time:?} s {what} is not a finite number")]
    NotFinite {
        /// Quantity that is missing.
        what: String,
        /// Time, s.
        time: f64,
    },
}

impl StateError {
    /// Advice for the user.
    pub fn advice(&self) -> Option<&'static str> {
        match self {
            StateError::OpenLoop { .. } => Some(
                "correct the initial positions or the points of the cut; a loop that opens \
                 during the run has reached a dead point",
            ),
            StateError::Overdetermined { .. } => Some(
                "its loops have more constraints than joints that could follow: remove a cut, or \
                 give the bodies between its ends more joints",
            ),
            StateError::NotFinite { .. } => {
                Some("take a smaller step, or the adaptive integrator; laws may be too stiff")
            }
            StateError::Element { .. } => None,
        }
    }
}

/// Joints in a sentence: the joint 'a', or the joints 'a', 'b'.
pub(crate) fn named_joints(joints: &[String]) -> String {
    let names: Vec<String> = joints.iter().map(|joint| format!("'{joint}'")).collect();
    let noun = if joints.len() == 1 { "joint" } else { "joints" };
    format!("the {noun} {}", names.join(", "))
}
