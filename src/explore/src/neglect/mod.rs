//! Parts of a model that a scene does not need: joints, bodies, forces and
//! terms whose absence changes the motion by less than it allows.
//!
//! A full model and laws of its forces make a motion, from several starts.
//! Everything that could be left out ([`Omission`]) is left out alone, the
//! operations this saves are counted and the motion is compared; then things
//! are left out together, the least harmful first, as long as the watched
//! joints stay within the error the scene allows of their largest displacement.
//! The result must hold at corners of the ranges of starts, at draws inside and
//! at the states that a directed search from the worst of them adds
//! ([`StartSearch`]); the integration is repeated with a finer tolerance.
//!
//! **Invariants.** The measured scene is read back from its file: the file that
//! is written is the one that was judged. Results do not depend on threads or
//! clocks.

mod document;
mod judge;
mod omission;
mod search;
mod starts;
mod text;

pub use document::files;
pub use judge::SceneOperations;
pub use omission::Omission;
pub use search::{
    NeglectFinding, NeglectFindings, NeglectTask, SceneFigures, WatchedCurve, neglect,
};
pub use starts::StartSearch;
pub use text::{report, text};

use crate::program::ExplorationError;
use robovec_dynamics::generate::GenerateError;
use robovec_dynamics::motion::MotionError;

/// Reason why nothing could be judged.
#[derive(Debug, thiserror::Error)]
pub enum NeglectError {
    /// The scene has no section `[motion]`.
    #[error("the scene has no section [motion]")]
    NoMotion,
    /// No joint is watched.
    #[error("no joint is watched: the scene needs no acceleration 'qdd[…]'")]
    NothingWatched,
    /// The scene contradicts an omission.
    #[error("{0}")]
    Scene(String),
    /// The equations could not be made.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// A pass gave up, or a program could not be measured.
    #[error(transparent)]
    Passes(#[from] ExplorationError),
    /// The model does not move.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

impl NeglectError {
    /// Advice for the user, if there is any.
    pub fn advice(&self) -> Option<&'static str> {
        match self {
            NeglectError::NoMotion => {
                Some("write [motion] with laws, time and error; see docs/scenes.md")
            }
            NeglectError::NothingWatched => {
                Some("name joints: watch = [\"…\"], in the section [motion]")
            }
            NeglectError::Motion(error) => error.advice(),
            _ => None,
        }
    }
}
