//! Stopping a pipeline half way, with a report of the point reached.
//!
//! A pipeline is deterministic, so the first `n` passes and rewrites of a run
//! are the same for any continuation: a run with a limit reproduces the state
//! before the failing pass or rewrite.

use crate::pipeline::PassStep;
use robovec_num::limits::NumberLimit;
use std::str::FromStr;

/// The end of a run: passes are counted over all functions, in the order they
/// run, from 1.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Limit {
    /// Passes after this one are skipped.
    pub passes: u64,
    /// Of the last pass, this many rewrites are done; all of them when
    /// absent.
    pub rewrites: Option<u64>,
}

/// Numbers of passes and rewrites.
pub const LIMIT: NumberLimit = NumberLimit::whole(0, u64::MAX, "a later stop costs nothing more");

/// `P` or `P:N`.
impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Limit, String> {
        let number = |text: &str| LIMIT.read_whole(text);
        let (passes, rewrites) = match text.split_once(':') {
            None => (text, None),
            Some((passes, rewrites)) => (passes, Some(number(rewrites)?)),
        };
        Ok(Limit {
            passes: number(passes)?,
            rewrites,
        })
    }
}

impl Limit {
    /// Tests whether the pass of an ordinal runs, and gives its number of
    /// rewrites.
    pub(super) fn of(limit: Option<Limit>, ordinal: u64) -> Option<Option<u64>> {
        let Some(limit) = limit else {
            return Some(None);
        };
        match ordinal.cmp(&limit.passes) {
            std::cmp::Ordering::Less => Some(None),
            std::cmp::Ordering::Equal => Some(limit.rewrites),
            std::cmp::Ordering::Greater => None,
        }
    }
}

/// A pass that was started, completed or not.
#[derive(Clone, Debug)]
pub struct Executed {
    /// Index of the function in the module.
    pub function: usize,
    /// The pass and its options.
    pub step: PassStep,
    /// The number of rewrites it requested.
    pub rewrites: u64,
    /// The rewrite at the limit, when there was one and it was reached: the
    /// value's name, and the rule.
    pub last: Option<(robovec_ir::Name, String)>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_and_say_what_runs() {
        let limit: Limit = "3:17".parse().expect("well formed");
        assert_eq!((limit.passes, limit.rewrites), (3, Some(17)));
        let all: Limit = "3".parse().expect("well formed");
        assert_eq!(all.rewrites, None);
        for wrong in ["", "x", "3:", ":2", "-1", "1:2:3"] {
            assert!(wrong.parse::<Limit>().is_err(), "{wrong}");
        }
        let ran: Vec<_> = (2..5).map(|pass| Limit::of(Some(limit), pass)).collect();
        assert_eq!(ran, [Some(None), Some(Some(17)), None]);
        assert_eq!(Limit::of(None, 100), Some(None));
    }
}
