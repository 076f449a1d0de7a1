//! The best of the variants.

use super::Goal;
use super::trial::VariantTrial;
use robovec_ir::Machine;
use robovec_schedule::{PlaceError, PlaceOptions, place};

/// The index of the variant to take; makes the schedules that are needed to
/// tell.
///
/// # Errors
///
/// When the machine can place no variant: the first one and its reason.
pub(super) fn choose(
    trials: &mut [VariantTrial],
    machine: &Machine,
    goal: Goal,
) -> Result<usize, (usize, PlaceError)> {
    let made = (0..trials.len()).filter(|&index| trials[index].is_made());
    match goal {
        Goal::Cycles => by_schedule(trials, machine),
        Goal::Operations => {
            let key = |&index: &usize| (trials[index].operations, trials[index].path);
            Ok(made.min_by_key(key).unwrap_or(0))
        }
        Goal::Path => {
            let key = |&index: &usize| (trials[index].path, trials[index].operations);
            Ok(made.min_by_key(key).unwrap_or(0))
        }
    }
}

/// Places the variants in order of their bounds, until the bounds say that
/// no other can be better.
fn by_schedule(
    trials: &mut [VariantTrial],
    machine: &Machine,
) -> Result<usize, (usize, PlaceError)> {
    let mut order: Vec<(u32, usize, usize)> = Vec::new();
    let mut failure: Option<(usize, PlaceError)> = None;
    for (index, trial) in trials
        .iter_mut()
        .enumerate()
        .filter(|(_, trial)| trial.is_made())
    {
        match &trial.bound {
            Ok(bound) => order.push((*bound, trial.operations, index)),
            Err(error) => {
                trial.remark = "cannot be placed";
                failure.get_or_insert_with(|| (index, error.clone()));
            }
        }
    }
    order.sort_unstable();
    let mut best: Option<(u32, usize, usize)> = None;
    for (bound, operations, index) in order {
        if best.is_some_and(|best| (best.0, best.1) <= (bound, operations)) {
            trials[index].remark = "cannot be better";
            continue;
        }
        let mut function = trials[index].function.clone();
        match place(&mut function, machine, PlaceOptions::default()) {
            Ok(summary) => {
                trials[index].cycles = Some(summary.cycles);
                let reached = (summary.cycles, operations, index);
                best = Some(best.map_or(reached, |best| best.min(reached)));
            }
            Err(error) => {
                trials[index].remark = "cannot be placed";
                failure.get_or_insert((index, error));
            }
        }
    }
    match (best, failure) {
        (Some((_, _, index)), _) => Ok(index),
        (None, Some(failure)) => Err(failure),
        // The first variant is always made, so that it is one or the other.
        (None, None) => Ok(0),
    }
}
