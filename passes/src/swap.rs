//! Tree swapping (thesis 2.4.2).

use crate::reassociate::{TreeShape, reassociate};
use crate::sums::groups::GroupReach;
use robovec_analysis::critical_path::{Weights, critical_path};
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_ir::Function;

declare_pass! {
    /// Moves the latest operand of every cascade to its end.
    ///
    /// A cascade is a run of additions and subtractions, or of multiplications,
    /// down the left operands; its operands are sorted by the time they are
    /// available. Sub-sums in parentheses are unchanged. A function whose
    /// longest path would grow is unchanged.
    pub struct Swap("swap") {}
    takes: [Equations, Atomic],
    gives: Gives::Same,
    class: Real,
    destroys: [Timed],
}

impl Pass for Swap {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let weights = Weights::cycles(context.machine);
        let new = reassociate(
            function,
            context.tables,
            &weights,
            GroupReach::Cascade,
            TreeShape::Cascade,
            context.rewrites,
        );
        let before = critical_path(function, context.machine).asap_cycle;
        let after = critical_path(&new, context.machine).asap_cycle;
        if after <= before || context.rewrites.has_refused() {
            *function = new;
        } else {
            context.remark("unchanged, because nothing was gained".to_owned());
        }
        context.count(
            "cycles taken off the longest path",
            before.saturating_sub(after).into(),
        );
        Ok(())
    }
}
