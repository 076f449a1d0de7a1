//! Equality saturation on the critical slice.

mod alternatives;
mod exact;
mod extract;
mod form;
mod graph;
mod matching;
mod pattern;
mod plain;
mod round;
mod saturate;
#[cfg(test)]
mod tests;
mod window;
mod write;

use crate::analysis::critical_path::{Weights, arrivals};
use crate::declare_pass;
use crate::pass::{Context, Gives, Pass, PassError};
use pattern::{BagRule, Signed};
use robovec_ir::{Function, Operation};
use round::{Budget, Settings};
use saturate::{Limits, STRUCTURE};

declare_pass! {
    /// Rewrites the critical slice by equality saturation.
    ///
    /// Around every result that comes too late a window of a few operations is
    /// entered into an e-graph, sums and products as signed bags, with the real
    /// arrival times of its surroundings. Rules add equal forms: products are
    /// distributed over sums, common factors taken out, sums of sums seen as
    /// one, parts that two sums or products have in common computed once. The
    /// forms chosen are those with which the result is in time, and of these
    /// the ones with the fewest operations.
    ///
    /// Windows are taken one after the other along the function, so that each
    /// sees what those before it have gained. A round that makes the longest
    /// path no shorter, and with the same path saves no operation, is undone.
    pub struct Eqsat("eqsat") {
        /// Operations per window.
        pub window: u32 = 12,
        /// Forms in the e-graph of one window.
        pub nodes: u32 = 1500,
        /// Rounds of rules per window.
        pub iterations: u32 = 4,
        /// Steps of matching, per rule and round.
        pub steps: u32 = 4000,
        /// Rounds over the function.
        pub rounds: u32 = 12,
        /// Operations the function may grow by, in percent.
        pub growth: u32 = 10,
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Real,
    requires: [],
    sets: [],
    destroys: [Timed],
}

/// Distribution and factoring.
fn own_rules() -> Vec<BagRule> {
    let variable = Signed::variable;
    let two = |operation, a, b| Signed::operation(operation, vec![a, b]);
    let factored = two(
        Operation::Mul,
        variable(0),
        two(Operation::Add, variable(1), variable(2)),
    );
    let distributed = two(
        Operation::Add,
        two(Operation::Mul, variable(0), variable(1)),
        two(Operation::Mul, variable(0), variable(2)),
    );
    let rule = |name: &str, left: &Signed, right: &Signed| BagRule {
        name: name.to_owned(),
        left: left.clone(),
        right: right.clone(),
        variables: 3,
    };
    vec![
        rule("distribute", &factored, &distributed),
        rule("factor", &distributed, &factored),
    ]
}

fn maker_name(rules: &[BagRule], maker: u32) -> &str {
    let maker = maker as usize;
    match rules.get(maker) {
        Some(rule) => &rule.name,
        None => STRUCTURE[maker - rules.len()],
    }
}

impl Pass for Eqsat {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let weights = Weights::cycles(context.machine);
        let rules = own_rules();
        let settings = Settings {
            rules: &rules,
            weights: &weights,
            size: self.window as usize,
            limits: Limits {
                nodes: self.nodes as usize,
                iterations: self.iterations,
                steps: self.steps,
            },
            trig: false,
            trail: context.notes.are_wanted(),
        };
        let size = |function: &Function| {
            let path = arrivals(function, &weights).into_iter().max().unwrap_or(0);
            (path, function.nodes().len())
        };
        let before = size(function);
        let mut best = before;
        let most = before.1 + before.1 * self.growth as usize / 100;
        let mut nodes = 200_000 + before.1 * 4;
        let mut step = (best.0 / 10).max(12);
        let mut windows = 0;
        let mut rewritten = 0;
        for _ in 0..self.rounds {
            let mut budget = Budget {
                nodes,
                operations: most as i64 - best.1 as i64,
            };
            let round = round::run(
                function,
                &settings,
                best.0.saturating_sub(step),
                &mut budget,
            );
            nodes = budget.nodes;
            windows += round.windows;
            let (new, notes) = write::write(function, context.tables, &weights, &round.rewritings);
            let reached = size(&new);
            if reached < best && reached.1 <= most.max(best.1) {
                best = reached;
                *function = new;
                for (name, maker) in notes {
                    context.note(name, maker_name(&rules, maker));
                }
                rewritten += round.rewritings.len() as u64;
            } else {
                step /= 2;
                if step < 4 {
                    break;
                }
            }
        }
        context.statistics.push(("windows looked at", windows));
        context.statistics.push(("windows rewritten", rewritten));
        context.statistics.push((
            "cycles taken off the longest path",
            (before.0 - best.0).into(),
        ));
        Ok(())
    }
}
