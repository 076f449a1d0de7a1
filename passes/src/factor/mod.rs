//! Fewer operations by algebra over the reals.

mod extract;
pub(crate) mod fingerprint;
pub(crate) mod network;
pub(crate) mod read;
pub(crate) mod write;

use crate::analysis::critical_path::Weights;
use crate::declare_pass;
use crate::pass::{Context, Gives, Pass, PassError};
use robovec_ir::Function;

declare_pass! {
    /// Computes less: equal values once, common factors outside, shared parts shared.
    pub struct Factor("factor") {
        /// Largest number of rounds; a round that gains nothing is the last.
        pub rounds: u32 = 8,
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Real,
    requires: [],
    sets: [],
    destroys: [Timed, ZeroFree],
}

impl Pass for Factor {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let weights = Weights::cycles(context.machine);
        let mut network = read::read(function, context.tables, false);
        let before = function.nodes().len();
        for _ in 0..self.rounds {
            let order = network.order();
            network.regroup(&order);
            let order = network.renumber();
            if extract::extract(&mut network, &order) == 0 {
                break;
            }
        }
        *function = write::write(function, network, &weights, context.tables, context.notes);
        let saved = before.saturating_sub(function.nodes().len());
        context.statistics.push(("operations saved", saved as u64));
        Ok(())
    }
}
