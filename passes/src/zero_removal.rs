//! Zero removal (thesis 2.4.1).

use crate::reassociate::{TreeShape, reassociate};
use crate::sums::groups::GroupReach;
use robovec_analysis::critical_path::Weights;
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_ir::{Function, Operation};

declare_pass! {
    /// Removes the `0 - x` that a minus became.
    ///
    /// Where a sum has a positive term, that term leads and the negative one is
    /// subtracted from it; else the value is stored negated and the sign
    /// travels to its users, which subtract instead of adding or pass it on. A
    /// `0 - x` stays only where an output needs it. No term is reassociated,
    /// and as rounding is symmetric no bit changes.
    pub struct ZeroRemoval("zero-removal") {}
    takes: [Atomic],
    gives: Gives::Same,
    class: Exact,
    sets: [ZeroFree],
    destroys: [Timed],
}

/// The number of operations that are a `0 - x`.
pub fn minuses(function: &Function) -> usize {
    function
        .nodes()
        .iter()
        .filter(|node| {
            node.operation == Operation::Sub && function.number(node.operands[0]) == Some(0.0)
        })
        .count()
}

impl Pass for ZeroRemoval {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let weights = Weights::cycles(context.machine);
        let new = reassociate(
            function,
            context.tables,
            &weights,
            GroupReach::Operation,
            TreeShape::Written,
            context.rewrites,
        );
        let before = minuses(function);
        if new.nodes().len() <= function.nodes().len() || context.rewrites.has_refused() {
            *function = new;
        } else {
            context.remark("unchanged, because nothing was gained".to_owned());
        }
        let after = minuses(function);
        context.count("0 - x removed", before.saturating_sub(after) as u64);
        context.count("0 - x left for outputs", after as u64);
        Ok(())
    }
}
