//! Fewer operations by algebra over the reals.
//!
//! A function is read into a `network` of n-ary sums and products in which no
//! two values are equal or opposite, as their `fingerprint`s show; `horner`
//! writes polynomials by Horner's schemes on request, `extract` takes common
//! factors and shared parts out, `times` keeps the longest path, and `write`
//! makes trees of operations again. `factor` and `factor-trig` are this engine
//! with two notions of equality.

mod extract;
mod horner;
pub(crate) mod network;
pub(crate) mod read;
mod times;
pub(crate) mod write;

use horner::HornerSearch;
use network::FactorNetwork;
use robovec_analysis::critical_path::Weights;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::{declare_pass, option_words};
use robovec_ir::Function;
use robovec_num::limits::NumberLimit;
use times::NodeTimes;

option_words! {
    /// Limit of the longest path.
    pub enum PathChoice {
        /// It does not grow.
        Keep = "keep",
        /// It may grow where that saves operations.
        Free = "free",
    }
}

option_words! {
    /// Method of writing polynomials again.
    pub enum HornerChoice {
        /// They are unchanged.
        None = "none",
        /// The variables that most terms have come first.
        Occurrences = "occurrences",
        /// Orders of the variables are searched for.
        Search = "search",
    }
}

/// Limit of the option `work`.
const WORK: NumberLimit = NumberLimit::whole(
    0,
    10_000,
    "a search that reads a thousand million terms takes ten seconds",
);
/// Limit of the option `orders`.
const ORDERS: NumberLimit = NumberLimit::whole(
    1,
    256,
    "for each order all factors are taken out of a network",
);
/// Limit of the option `seed`.
const SEED: NumberLimit = NumberLimit::whole(0, u32::MAX as u64, "a seed costs nothing");
/// Limit of the option `cycles`.
const CYCLES: NumberLimit = NumberLimit::whole(0, 1_000_000_000, "no function takes more cycles");

/// The options of both passes.
struct FactorOptions {
    circle: bool,
    path: PathChoice,
    cycles: u32,
    rounds: u32,
    /// `None` when polynomials are not rewritten.
    search: Option<HornerSearch>,
}

macro_rules! factor_pass {
    ($(#[doc = $documentation:expr])* $pass:ident($name:literal), $class:ident, $circle:expr) => {
        declare_pass! {
            $(#[doc = $documentation])*
            pub struct $pass($name) {
                /// With `keep` nothing is rewritten that would lengthen the longest
                /// path of the balanced function.
                pub path: PathChoice = PathChoice::Keep,
                /// Largest number of rounds; a round that gains nothing is the last.
                pub rounds: u32 = 8 => NumberLimit::whole(
                    0, 64, "every round looks for factors in the whole function"),
                /// Sums and products are read as polynomials, and all of them together
                /// are written by Horner's scheme with a common order of variables,
                /// before factors are taken out; what came in stays where that does
                /// not save operations.
                pub horner: HornerChoice = HornerChoice::None,
                /// Millions of terms that the search reads.
                pub work: u32 = 50 => WORK,
                /// Orders of which the factors are taken out; the best one stays.
                pub orders: u32 = 8 => ORDERS,
                /// The seed of the search.
                pub seed: u32 = 1 => SEED,
                /// The longest path allowed, in cycles, instead of `path`; 0 leaves it
                /// to `path`.
                pub cycles: u32 = 0 => CYCLES,
            }
            takes: [Atomic],
            gives: Gives::Same,
            class: $class,
            destroys: [Timed, ZeroFree],
        }

        impl Pass for $pass {
            fn run(
                &self,
                function: &mut Function,
                context: &mut Context<'_>,
            ) -> Result<(), PassError> {
                let (work, orders) = match self.horner {
                    HornerChoice::Search => (self.work, self.orders),
                    _ => (0, 1),
                };
                let search = HornerSearch {
                    work: u64::from(work) * 1_000_000,
                    orders: orders as usize,
                    seed: u64::from(self.seed),
                };
                let options = FactorOptions {
                    circle: $circle,
                    path: self.path,
                    cycles: self.cycles,
                    rounds: self.rounds,
                    search: (self.horner != HornerChoice::None).then_some(search),
                };
                rewrite(function, context, &options);
                Ok(())
            }
        }
    };
}

factor_pass! {
    /// Computes equal values once, takes common factors out, shares parts.
    ///
    /// Values are identified by their residues at random points of two prime
    /// fields, so equal values are found in any form. A value that is zero, or
    /// the negation or a copy of another value, is not computed. Then pairs of
    /// terms or factors that several sums or products have in common become
    /// separate values, and `a*b + a*c` becomes `a*(b + c)`, where that saves
    /// operations: the pairs that save most first (Hosangadi, Fallah and
    /// Kastner, 2006), in rounds until there is no gain.
    ///
    /// Fused operations are taken apart; `fma` makes them again.
    Factor("factor"), Real, false
}

factor_pass! {
    /// As `factor`, but also uses sin^2 + cos^2 = 1.
    ///
    /// The pass does the same as `factor`, with every sine and cosine on the
    /// unit circle.
    FactorTrig("factor-trig"), RealTrig, true
}

fn rewrite(function: &mut Function, context: &mut Context<'_>, options: &FactorOptions) {
    let weights = Weights::cycles(context.machine);
    let before = function.nodes().len();
    let mut network = read::read(function, context.tables, options.circle);
    let limit = match (options.cycles, options.path) {
        (0, PathChoice::Free) => None,
        (0, PathChoice::Keep) => Some(longest(&mut network, weights)),
        (cycles, _) => Some(cycles),
    };
    let goal = FactorGoal {
        weights,
        limit,
        rounds: options.rounds,
    };
    match options.search {
        Some(search) => horner::improve(&mut network, search, context.rewrites, &goal),
        None => extract_all(&mut network, &goal),
    }
    let new = write::write(function, network, &weights, context.tables, context.notes);
    let saved = before.saturating_sub(new.nodes().len());
    *function = new;
    context.count("operations saved", saved as u64);
}

/// Goal for common factors.
struct FactorGoal {
    weights: Weights,
    /// The longest path allowed.
    limit: Option<u32>,
    rounds: u32,
}

/// The longest path of a network whose sums and products are balanced.
fn longest(network: &mut FactorNetwork, weights: Weights) -> u32 {
    let order = network.order();
    network.regroup(&order);
    let order = network.renumber();
    NodeTimes::find(network, &order, weights, None).longest(network)
}

fn extract_all(network: &mut FactorNetwork, goal: &FactorGoal) {
    for _ in 0..goal.rounds {
        let order = network.order();
        network.regroup(&order);
        let order = network.renumber();
        let Some(limit) = goal.limit else {
            if extract::extract(network, &order, None) == 0 {
                return;
            }
            continue;
        };
        let times = NodeTimes::find(network, &order, goal.weights, Some(limit));
        let snapshot = network.clone();
        if extract::extract(network, &order, Some(times)) == 0 {
            return;
        }
        // Within a round the times of what lies far above a rewritten value
        // are those of before; should that have been wrong, the round is off.
        let order = network.order();
        if NodeTimes::find(network, &order, goal.weights, None).longest(network) > limit {
            *network = snapshot;
            return;
        }
    }
    let order = network.order();
    network.regroup(&order);
    network.renumber();
}
