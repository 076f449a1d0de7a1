//! The removal of operations that no output needs.

use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::remove_dead_asking;
use robovec_ir::Function;

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
