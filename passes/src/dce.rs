//! What no output needs is not computed.

use crate::declare_pass;
use crate::pass::{Context, Gives, Pass, PassError};
use crate::rewrite::Rewriter;
use crate::rewrites::Rewrites;
use robovec_ir::{Function, Node, Operand};

declare_pass! {
    /// Removes operations that no output depends on.
    pub struct Dce("dce") {}
    takes: [Equations, Atomic],
    gives: Gives::Same,
    class: Exact,
    requires: [],
    sets: [Live],
    destroys: [Timed],
}

/// For every node whether an output depends on it.
pub fn live(function: &Function) -> Vec<bool> {
    needed(function, &Rewrites::default())
}

/// As [`live`]; what must not be removed is needed too.
fn needed(function: &Function, rewrites: &Rewrites) -> Vec<bool> {
    let mut live = vec![false; function.nodes().len()];
    for assignment in &function.assignments {
        if let Some(value) = assignment.operand.value() {
            live[value.index()] = true;
        }
    }
    for (value, node) in function.values().rev() {
        let refused = || !node.name.is_none() && !rewrites.allow(node.name, "dead");
        if live[value.index()] || refused() {
            live[value.index()] = true;
            for operand in node.operands().iter().filter_map(|operand| operand.value()) {
                live[operand.index()] = true;
            }
        }
    }
    live
}

/// The function without the operations no output depends on, and how many
/// there were; `None` when there are none.
pub fn remove_dead(function: &Function) -> Option<(Function, u64)> {
    remove_dead_asking(function, &Rewrites::default())
}

/// As [`remove_dead`], asking before each removal.
pub fn remove_dead_asking(function: &Function, rewrites: &Rewrites) -> Option<(Function, u64)> {
    let live = needed(function, rewrites);
    let dead = live.iter().filter(|&&live| !live).count();
    if dead == 0 {
        return None;
    }
    let mut rewriter = Rewriter::with_formats(function, function.level);
    for (value, node) in function.values() {
        if live[value.index()] {
            let operands = rewriter.translate_operands(node);
            rewriter.keep(Node { operands, ..*node });
        } else {
            rewriter.record(Operand::NONE);
        }
    }
    Some((rewriter.finish(), dead as u64))
}

impl Pass for Dce {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let mut count = 0;
        if let Some((new, dead)) = remove_dead_asking(function, context.rewrites) {
            *function = new;
            count = dead;
        }
        context.statistics.push(("operations removed", count));
        Ok(())
    }
}
