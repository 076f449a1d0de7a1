//! Fewer operations by algebra over the reals.
//!
//! A function is read into a `network` of n-ary sums and products in which no
//! two values are equal or opposite, as their `fingerprint`s tell; `extract`
//! takes common factors and shared parts out, `times` keeps the longest path,
//! and `write` makes trees of operations again. `factor` and `factor-trig` are
//! this engine with two notions of equality.

mod extract;
pub(crate) mod network;
pub(crate) mod read;
mod times;
pub(crate) mod write;

use network::FactorNetwork;
use robovec_analysis::critical_path::Weights;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::{declare_pass, option_words};
use robovec_ir::Function;
use robovec_num::limits::NumberLimit;
use times::NodeTimes;

option_words! {
    /// What may happen to the longest path.
    pub enum PathChoice {
        /// It does not grow.
        Keep = "keep",
        /// It may grow where that saves operations.
        Free = "free",
    }
}

declare_pass! {
    /// Computes equal values once, takes common factors out, shares parts.
    ///
    /// Values are known by what they are at random points of two prime fields,
    /// so equal ones meet however they are written; what is zero, or the
    /// negation or a copy of another value, is not computed. Then pairs of terms
    /// or factors that several sums or products have in common become values of
    /// their own, and `a*b + a*c` becomes `a*(b + c)`, where that saves
    /// operations: the pairs that save most first (Hosangadi, Fallah and
    /// Kastner, 2006), in rounds until nothing is gained.
    ///
    /// Fused operations are taken apart; `fma` makes them again.
    pub struct Factor("factor") {
        /// With `keep` nothing is rewritten that would lengthen the longest
        /// path of the balanced function.
        pub path: PathChoice = PathChoice::Keep,
        /// Largest number of rounds; a round that gains nothing is the last.
        pub rounds: u32 = 8 => NumberLimit::whole(
            0, 64, "every round looks for factors in the whole function"),
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Real,
    requires: [],
    sets: [],
    destroys: [Timed, ZeroFree],
}

declare_pass! {
    /// As `factor`, and values are equal also by sin^2 + cos^2 = 1.
    ///
    /// What `factor` does, with every sine and cosine on the unit circle.
    pub struct FactorTrig("factor-trig") {
        /// With `keep` nothing is rewritten that would lengthen the longest
        /// path of the balanced function.
        pub path: PathChoice = PathChoice::Keep,
        /// Largest number of rounds; a round that gains nothing is the last.
        pub rounds: u32 = 8 => NumberLimit::whole(
            0, 64, "every round looks for factors in the whole function"),
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: RealTrig,
    requires: [],
    sets: [],
    destroys: [Timed, ZeroFree],
}

impl Pass for Factor {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        rewrite(function, context, false, self.path, self.rounds);
        Ok(())
    }
}

impl Pass for FactorTrig {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        rewrite(function, context, true, self.path, self.rounds);
        Ok(())
    }
}

fn rewrite(
    function: &mut Function,
    context: &mut Context<'_>,
    circle: bool,
    path: PathChoice,
    rounds: u32,
) {
    let weights = Weights::cycles(context.machine);
    let before = function.nodes().len();
    let mut network = read::read(function, context.tables, circle);
    extract_all(&mut network, weights, path, rounds);
    let new = write::write(function, network, &weights, context.tables, context.notes);
    let saved = before.saturating_sub(new.nodes().len());
    *function = new;
    context.statistics.push(("operations saved", saved as u64));
}

fn extract_all(network: &mut FactorNetwork, weights: Weights, path: PathChoice, rounds: u32) {
    let mut limit = None;
    for _ in 0..rounds {
        let order = network.order();
        network.regroup(&order);
        let order = network.renumber();
        let times =
            (path == PathChoice::Keep).then(|| NodeTimes::find(network, &order, weights, limit));
        let Some(times) = times else {
            if extract::extract(network, &order, None) == 0 {
                return;
            }
            continue;
        };
        let allowed = *limit.get_or_insert(times.longest(network));
        let snapshot = network.clone();
        if extract::extract(network, &order, Some(times)) == 0 {
            return;
        }
        // Within a round the times of what lies far above a rewritten value
        // are those of before; should that have been wrong, the round is off.
        let order = network.order();
        if NodeTimes::find(network, &order, weights, None).longest(network) > allowed {
            *network = snapshot;
            return;
        }
    }
    let order = network.order();
    network.regroup(&order);
    network.renumber();
}
