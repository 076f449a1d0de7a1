//! The removal of operations that no output needs, and the order of those that
//! one needs.

mod order;

use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::remove_dead;
use robovec_framework::{declare_pass, option_words};
use robovec_ir::Function;

option_words! {
    /// The order of values.
    #[derive(Default)]
    pub enum ValueOrder {
        /// As they came.
        #[default]
        Kept = "kept",
        /// Each at its first use by the outputs, for any original order.
        Outputs = "outputs",
    }
}

declare_pass! {
    /// Removes operations that no output depends on.
    ///
    /// With `order=outputs` the others come into an order that does not depend
    /// on the one they came in: each comes where the outputs first need it,
    /// the last output and the longest chain first. Passes break ties by the
    /// order of values; after this one the same equations in another order
    /// make the same program.
    pub struct Dce("dce") {
        /// The order of the values that stay.
        pub order: ValueOrder = ValueOrder::default(),
    }
    takes: [Equations, Atomic],
    gives: Gives::Same,
    class: Exact,
    sets: [Live],
    destroys: [Timed],
}

impl Pass for Dce {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let mut count = 0;
        if let Some((new, dead)) = remove_dead(function, context.rewrites) {
            *function = new;
            count = dead;
        }
        if self.order == ValueOrder::Outputs {
            *function = order::by_outputs(function);
        }
        context.count("operations removed", count);
        Ok(())
    }
}
