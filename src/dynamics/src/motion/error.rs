//! Errors of simulations.

use crate::generate::GenerateError;
use crate::kinematics::{StateError, named_joints};
use robovec_present::number::or_nothing;
use thiserror::Error;

/// Reason why a simulation cannot start or continue.
#[derive(Clone, PartialEq, Debug, Error)]
pub enum MotionError {
    /// The model gives no equations.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// A pass over the equations failed.
    #[error("the passes failed: {0}")]
    Passes(String),
    /// A state cannot be reached, or the equations are undefined there.
    #[error(transparent)]
    State(#[from] StateError),
    /// Forces cannot move joints in a determined way.
    #[error(
        "at {time:?} s the mass matrix is singular at {}: \
         what {} no mass or inertia in that direction",
        named_joints(joints),
        if joints.len() == 1 { "it moves has" } else { "they move has" }
    )]
    Singular {
        /// Names of the joints.
        joints: Vec<String>,
        /// Time, s.
        time: f64,
    },
    /// The generated functions of the whole step cannot close a loop with the
    /// joints they move, or have gone past the point where they could.
    #[error(
        "at {time:?} s the generated functions have reached a dead point of the cut '{cut}': the \
         joint that the loops determine least is '{joint}' (its pivot is {pivot:.1e} \
         of that of the best choice), and the ends stay {gap:.1e} apart"
    )]
    DeadPoint {
        /// Name of the joint with the smallest pivot.
        joint: String,
        /// Name of the cut of the row.
        cut: String,
        /// The pivot, as a fraction of the smallest one of the best choice.
        pivot: f64,
        /// The largest residual of the constraints.
        gap: f64,
        /// Time, s.
        time: f64,
    },
    /// The adaptive integrator cannot meet its tolerances.
    #[error("at {time:?} s a step of {step:.1e} s still misses the tolerance")]
    StepTooSmall {
        /// Time, s.
        time: f64,
        /// The step tried last, s.
        step: f64,
    },
    /// The limit of work.
    #[error("{0} steps did not reach the end")]
    TooManySteps(u64),
    /// There is no state of rest, or none was found.
    #[error(
        "no equilibrium was found near the initial state{}",
        or_nothing(free.as_ref(), |joint| format!(
            ": nothing holds the joint '{joint}', and a force moves it"
        ))
    )]
    NoEquilibrium {
        /// The name of a joint with a force but no stiffness.
        free: Option<String>,
    },
    /// The small motions of a state have no modes in finite numbers.
    #[error("the modes cannot be computed: {0}")]
    Modes(String),
    /// A joint whose motion is measured does not move.
    #[error("the watched joint '{0}' does not move")]
    Still(String),
}

impl MotionError {
    /// The error of something that has become infinite or undefined.
    pub(super) fn not_finite(what: &str, time: f64) -> MotionError {
        MotionError::State(StateError::NotFinite {
            what: what.to_owned(),
            time,
        })
    }
}

impl MotionError {
    /// Advice for the user.
    pub fn advice(&self) -> Option<&'static str> {
        match self {
            MotionError::Singular { joints, .. } if joints.len() > 1 => Some(
                "give the bodies beyond them mass and inertia, hold them (--hold) or drive them \
                 (--laws); constraints that a project computes are not part of the simulation",
            ),
            MotionError::Singular { .. } => Some(
                "give the bodies beyond it mass and inertia, hold it (--hold) or drive it (--laws); \
                 constraints that a project computes are not part of the simulation",
            ),
            MotionError::DeadPoint { .. } => Some(
                "which joints depend is fixed when the functions are generated: make that joint \
                 independent and another one of its loop dependent, or simulate without \
                 --whole-step, which exchanges them on the way",
            ),
            MotionError::State(error) => error.advice(),
            MotionError::StepTooSmall { .. } => {
                Some("loosen the tolerance, or soften the laws of forces")
            }
            MotionError::Still(_) => Some(
                "give it another initial position (start = { NAME = … }) or a law that moves it",
            ),
            MotionError::NoEquilibrium { free: Some(_) } => {
                Some("give the joint a spring (--laws) or hold it (--hold)")
            }
            MotionError::NoEquilibrium { free: None } => {
                Some("start nearer to it: give the model other initial positions")
            }
            MotionError::Modes(_) => Some("give every body mass and inertia"),
            MotionError::TooManySteps(_) => Some("take a larger step or a shorter time"),
            MotionError::Generate(_) | MotionError::Passes(_) => None,
        }
    }
}
