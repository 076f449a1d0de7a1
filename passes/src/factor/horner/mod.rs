//! Horner's schemes for all polynomials of a function at once.
//!
//! The pairs that `extract` finds depend on the grouping of sums and products,
//! and an expanded polynomial has no grouping. `polynomials` reads the network
//! as polynomials, `schemes` counts the operations for an order of the
//! variables, `search` looks for good orders, and `rebuild` makes a network of
//! one; `extract` then shares common parts in each, and the network with the
//! fewest operations is kept, which is the original when no scheme is better.

mod polynomials;
mod rebuild;
mod schemes;
mod search;
#[cfg(test)]
mod tests;
mod tree;

use super::network::FactorNetwork;
use super::{FactorGoal, extract_all, longest};
use polynomials::NetworkPolynomials;
use robovec_framework::rewrite_limit::RewriteLimit;
use schemes::SchemeSet;

/// Limits and random numbers of a search.
#[derive(Clone, Copy)]
pub(super) struct HornerSearch {
    /// Terms to be considered.
    pub(super) work: u64,
    /// Number of orders for which factors are taken out.
    pub(super) orders: usize,
    pub(super) seed: u64,
}

/// Maximum number of rounds in which polynomials are rewritten: taking factors
/// out leaves other sums and products.
const ROUNDS: u32 = 4;

/// Writes the polynomials of a network again where that saves operations.
///
/// `network` is the input, without common parts taken out; the result has them
/// taken out.
pub(super) fn improve(
    network: &mut FactorNetwork,
    search: HornerSearch,
    rewrites: &RewriteLimit,
    goal: &FactorGoal,
) {
    let mut given = network.clone();
    extract_all(network, goal);
    for round in 0..ROUNDS {
        let search = HornerSearch {
            work: search.work >> (round + 1),
            ..search
        };
        let usual = HornerSearch {
            work: 0,
            orders: 1,
            ..search
        };
        let mut found = candidates(&given, (true, search), rewrites, goal);
        found.extend(candidates(&given, (false, usual), rewrites, goal));
        let best = found.into_iter().min_by_key(|candidate| candidate.cost);
        // While the rewrite that breaks a function is looked for, what was
        // rewritten is not judged.
        match best {
            Some(best) if rewrites.has_refused() => {
                *network = best;
                return;
            }
            Some(best) if best.cost < network.cost => *network = best,
            _ if round > 0 => return,
            _ => {}
        }
        given = network.clone();
    }
}

/// The network with its polynomials written by the schemes that a search
/// finds, products with several readers dissolved or not, and with factors
/// taken out of each.
///
/// Networks with a longer path than the goal allows are left out.
fn candidates(
    network: &FactorNetwork,
    (dissolving, search): (bool, HornerSearch),
    rewrites: &RewriteLimit,
    goal: &FactorGoal,
) -> Vec<FactorNetwork> {
    let mut network = network.clone();
    let order = network.order();
    network.regroup(&order);
    let order = network.renumber();
    let polynomials = NetworkPolynomials::read(&network, &order, dissolving, rewrites);
    let set = SchemeSet::new(&polynomials, &order);
    let orders = search::orders(&set, search.work, search.orders, search.seed);
    let mut candidates = Vec::new();
    for rated in orders {
        let mut candidate = rebuild::rebuild(&network, &order, &polynomials, &set, &rated.ranks);
        let late = |limit| longest(&mut candidate, goal.weights) > limit;
        if goal.limit.is_some_and(late) {
            continue;
        }
        extract_all(&mut candidate, goal);
        candidates.push(candidate);
    }
    candidates
}
