//! Errors of bringing a model into a state.

use thiserror::Error;

/// Reason why a model cannot be brought into a state, or its equations are
/// undefined there.
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
    #[error("at {time:?} s the cut '{cut}' cannot be closed: its ends stay {gap:.3e} apart")]
    OpenLoop {
        /// Name of the cut.
        cut: String,
        /// The largest residual of its rows.
        gap: f64,
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
            StateError::NotFinite { .. } => {
                Some("take a smaller step, or the adaptive integrator; laws may be too stiff")
            }
            StateError::Element { .. } => None,
        }
    }
}
