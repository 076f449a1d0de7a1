//! The effects of a rule on errors, cycles, operations and graphs.

mod cost;
mod error;
mod family;
mod fit;
mod grow;
#[cfg(test)]
mod tests;

pub use cost::CostChange;
pub(super) use cost::{earliest_of, operations};
pub use error::{SideErrors, Transfer};
pub use fit::Growth;
pub use grow::{Growing, PairGrowth, alone, pairs, partner};

use super::rule::Rule;
use robovec_ir::Machine;

/// Random points for errors.
pub const POINTS: usize = 20_000;

/// The profile of a rule alone.
#[derive(Clone, PartialEq, Debug)]
pub struct RuleProfile {
    /// Rounding errors of both sides.
    pub transfer: Transfer,
    /// Operations and cycles.
    pub change: CostChange,
    /// The growth of a graph under the rule and those that are always on.
    pub growing: Growing,
    /// Rule with which it grows exponentially or without end, itself or one
    /// that is always active; `None` when it takes more than one.
    pub partner: Option<String>,
}

/// Profiles a rule for a machine.
pub fn profile(rule: &Rule, machine: &Machine, points: usize) -> RuleProfile {
    let growing = alone(rule);
    let explodes = matches!(growing.growth, Growth::Exponential(_) | Growth::Endless);
    RuleProfile {
        partner: explodes.then(|| partner(rule)).flatten(),
        transfer: error::transfer(rule, points),
        change: cost::change(rule, machine),
        growing,
    }
}
