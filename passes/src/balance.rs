//! Tree balancing (thesis 2.4.3).

use crate::cse::merge_equal;
use crate::reassociate::{TreeShape, reassociate};
use crate::sums::groups::GroupReach;
use robovec_analysis::critical_path::{Weights, arrivals, longest};
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::remove_dead;
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_framework::trail::Notes;
use robovec_ir::{Function, Level, Tables};
use robovec_num::limits::NumberLimit;

declare_pass! {
    /// Combines the two earliest operands of every sum and product first.
    ///
    /// Sums and products are made as large as possible: across the parentheses
    /// of an equation, across equations whose value is used only once, and with
    /// their signs, so that no `0 - x` is needed inside. Of several trees with
    /// the same finish, and where there is time also of later ones, the one is
    /// taken that shares sub-sums and sub-products with other equations. The
    /// longest path never grows, and with an equal path the result has fewer
    /// operations: a function that cannot be improved is unchanged.
    pub struct Balance("balance") {
        /// Largest number of rounds; a round that gains nothing is the last,
        /// and functions of more than 200,000 operations have one.
        pub rounds: u32 = 2 => NumberLimit::whole(
            0, 64, "every round balances the whole function again"),
    }
    takes: [Equations, Atomic],
    gives: Gives::Same,
    class: Real,
    destroys: [Timed],
}

/// The largest function that is balanced more than once, in operations.
const LARGEST_REPEATED: usize = 200_000;

/// A function at the atomic level after one round of balancing: equal
/// operations merged, dead ones removed.
pub(crate) fn balanced(function: &Function, tables: &mut Tables, weights: &Weights) -> Function {
    Balance::round(function, tables, weights, &RewriteLimit::default())
}

impl Balance {
    /// One round: equal operations are merged and dead ones removed first,
    /// since both hide that a value is used only once.
    fn round(
        function: &Function,
        tables: &mut Tables,
        weights: &Weights,
        rewrites: &RewriteLimit,
    ) -> Function {
        let merged = match function.level {
            Level::Atomic => {
                let notes = &mut Notes::unwanted();
                merge_equal(function, tables, rewrites, notes).map(|(function, _)| function)
            }
            _ => None,
        };
        let function = merged.as_ref().unwrap_or(function);
        let live = remove_dead(function, rewrites).map(|(function, _)| function);
        let function = live.as_ref().unwrap_or(function);
        let (reach, shape) = (GroupReach::Maximal, TreeShape::Earliest);
        reassociate(function, tables, weights, reach, shape, rewrites)
    }
}

impl Pass for Balance {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let weights = Weights::cycles(context.machine);
        let size = |function: &Function| {
            let path = longest(&arrivals(function, &weights));
            (path, function.nodes().len())
        };
        let before = size(function);
        let mut best = before;
        let rounds = if before.1 > LARGEST_REPEATED {
            1
        } else {
            self.rounds
        };
        for _ in 0..rounds {
            let new = Self::round(function, context.tables, &weights, context.rewrites);
            let reached = size(&new);
            if reached >= best && !context.rewrites.has_refused() {
                break;
            }
            best = reached;
            *function = new;
            if context.rewrites.has_refused() {
                break;
            }
        }
        assert!(
            best.0 <= before.0 || context.rewrites.has_refused(),
            "the longest path never grows"
        );
        context.count(
            "cycles taken off the longest path",
            before.0.saturating_sub(best.0).into(),
        );
        let fewer = before.1.saturating_sub(best.1);
        context.count("operations saved", fewer as u64);
        Ok(())
    }
}
