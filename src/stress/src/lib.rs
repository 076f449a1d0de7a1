//! Hard cases of floating point: models and equations, measured and cured.
//!
//! A [`StressCase`] is built, computed in binary32 without treatment and
//! compared with a reference in double-double numbers. The error is compared
//! with the condition of the problem and with the error that rounding the data
//! once would make; from these follows the [`StressVerdict`], the cause of the
//! error. Then candidates for remedies are tried (other recursions, passes,
//! coordinates, units, formats of all values or of each, refinement,
//! compensated sums, steps, loops kept closed), and the cheapest that comes
//! close to binary64 is reported. `docs/stress.md` has the cases.
//!
//! **Invariant.** Nothing depends on clocks, threads or the order of work.

mod case;
mod cases;
mod cure;
mod drift;
mod dynamics;
mod equations;
mod forms;
mod given;
mod linear;
mod long;
mod loops;
mod numbers;
mod page;
mod program;
mod series;
mod steps;
mod treatment;
pub mod units;
mod view;
mod whole_step;

pub use case::{ALLOWANCE, CaseClass, Measured, StressCase, StressVerdict, verdict};
pub use cases::cases;
pub use cure::{Findings, TreatmentTrial, examine, judge};
pub use given::{of_function, of_model};
pub use page::{figure, page};
pub use treatment::{LoopStabilisation, ProgramTreatment};
pub use view::{CaseFinding, gaps, headline, lines, steps, table, text, worst};

use robovec_dynamics::generate::GenerateError;
use robovec_dynamics::motion::MotionError;
use thiserror::Error;

/// Reason why a case cannot be measured.
#[derive(Clone, PartialEq, Debug, Error)]
pub enum StressError {
    /// The model gives no equations.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// The model does not move.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A pass failed.
    #[error("the passes failed: {0}")]
    Passes(String),
}
