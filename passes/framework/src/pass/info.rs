//! Attributes of a pass without running it: its entry in the registry.

use super::Pass;
use crate::options::{OptionError, OptionInfo};
use robovec_analysis::class::NumericClass;
use robovec_ir::Level;

robovec_num::named! {
    /// A fact about a function that a pass can establish or destroy and another can
    /// require.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
    pub enum Property {
        /// Every node carries its earliest and latest times.
        Timed = "timed",
        /// No `0 - x` is left that no output forces.
        ZeroFree = "zero-free",
        /// No two nodes compute the same.
        Shared = "shared",
        /// Every node is needed by an output.
        Live = "live",
    }
}

/// The level a pass leaves its function at.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Gives {
    /// The level it found.
    Same,
    /// This level.
    Level(Level),
}

/// Makes a pass from options: names and values as text.
pub type BuildPass = fn(&[(String, String)]) -> Result<Box<dyn Pass>, OptionError>;

/// A pass's entry in the registry; [`declare_pass!`](crate::declare_pass)
/// makes it.
#[derive(Clone, Copy, Debug)]
pub struct PassInfo {
    /// Name in pipelines.
    pub name: &'static str,
    /// Page in the manual; its first line is the one-line description.
    pub documentation: &'static str,
    /// Options.
    pub options: &'static [OptionInfo],
    /// Levels it takes.
    pub takes: &'static [Level],
    /// Level it gives.
    pub gives: Gives,
    /// Numeric class.
    pub class: NumericClass,
    /// Properties it needs.
    pub requires: &'static [Property],
    /// Properties it establishes.
    pub sets: &'static [Property],
    /// Properties it may destroy.
    pub destroys: &'static [Property],
    /// Makes the pass from the options of a pipeline.
    pub build: BuildPass,
}

impl PassInfo {
    /// The one-line description.
    pub fn summary(&self) -> &'static str {
        first_line(self.documentation)
    }
}

pub(crate) fn first_line(documentation: &str) -> &str {
    documentation.lines().next().unwrap_or("").trim()
}
