//! Tree balancing (thesis 2.4.3).

use crate::analysis::critical_path::{Weights, critical_path};
use crate::declare_pass;
use crate::pass::{Context, Gives, Pass, PassError};
use crate::reassociate::{Reach, Shape, reassociate};
use robovec_ir::Function;

declare_pass! {
    /// Combines the two earliest operands of every sum and product first.
    ///
    /// Sums and products are taken as large as they are: across the
    /// parentheses of an equation, across equations whose value is used only
    /// once, and with their signs, so that no `0 - x` is needed inside. Of
    /// several trees with the same finish, and where there is time also of
    /// later ones, the one is taken that shares sub-sums and sub-products
    /// with other equations. The longest path never grows and there are never
    /// more operations: a function that cannot be improved stays as it is.
    pub struct Balance("balance") {}
    takes: [Equations, Atomic],
    gives: Gives::Same,
    class: Real,
    requires: [],
    sets: [],
    destroys: [Timed],
}

impl Pass for Balance {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let weights = Weights::cycles(context.machine);
        let new = reassociate(
            function,
            context.tables,
            &weights,
            Reach::Maximal,
            Shape::Earliest,
        );
        let before = critical_path(function, context.machine).asap_cycle;
        let after = critical_path(&new, context.machine).asap_cycle;
        if after <= before {
            *function = new;
        } else {
            context
                .remarks
                .push("nothing gained, left as it was".to_owned());
        }
        context.statistics.push((
            "cycles taken off the longest path",
            before.saturating_sub(after).into(),
        ));
        Ok(())
    }
}
