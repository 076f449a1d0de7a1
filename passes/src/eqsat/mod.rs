//! Equality saturation on the critical slice.

mod alternatives;
pub mod derive;
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

use pattern::BagRule;
use robovec_analysis::class::NumericClass;
use robovec_analysis::critical_path::{Weights, arrivals, longest};
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_ir::{Function, Machine, Operation};
use robovec_num::limits::NumberLimit;
use robovec_rules::{DEFAULT, Rule, RuleSet};
use round::{RoundBudget, Settings};
use saturate::{STRUCTURE, SaturationLimits};

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
    /// Windows are processed in sequence along the function, so that each
    /// benefits from the gains of those before it. A round that makes the
    /// longest path no shorter, and with the same path saves no operation, is
    /// undone. Rules are left out whose results the machine cannot place:
    /// quotients and roots without an element for them, sines of sums of
    /// angles.
    pub struct Eqsat("eqsat") {
        /// Operations per window.
        pub window: u32 = 12 => NumberLimit::whole(
            1, 256, "rules are matched against all of a window at once"),
        /// Forms in the e-graph of one window.
        pub nodes: u32 = 600 => NumberLimit::whole(
            1, 100_000, "the e-graph of a window holds all its forms"),
        /// Rounds of rules per window.
        pub iterations: u32 = 3 => NumberLimit::whole(
            0, 64, "every round of rules matches each rule against every form"),
        /// Steps of matching, per rule and round.
        pub steps: u32 = 1000 => NumberLimit::whole(
            0, 1_000_000, "every rule may take them in every round of every window"),
        /// Rounds over the function.
        pub rounds: u32 = 12 => NumberLimit::whole(
            0, 64, "every round visits all windows of the function"),
        /// Operations the function may grow by, in percent.
        pub growth: u32 = 10 => NumberLimit::whole(
            0, 10_000, "the number of operations grows up to a hundred times"),
        /// Use the rules of class real-trig too: sines and cosines then lie on
        /// the circle, and the pass is of that class itself.
        pub trig: bool = false,
        /// Associativity and commutativity by rule instead of bags, on windows
        /// of plain operations: for small windows, and to compare.
        pub ac: bool = false,
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Real,
    destroys: [Timed],
}

/// Maximum number of forms made in all windows of a function: this number, and
/// the next per operation. Time grows with them, and so with the function.
const FIRST_NODES: usize = 600_000;
/// See [`FIRST_NODES`].
const NODES_PER_OPERATION: usize = 2;

/// The statistic of all windows, over all rounds.
pub const WINDOWS: &str = "windows tested";
/// The statistic of windows that the limit of forms ended.
pub const OUT_OF_NODES: &str = "windows without room for more forms";
/// The statistic of windows that the limit of rounds of rules ended.
pub const OUT_OF_ITERATIONS: &str = "windows with no rounds of rules left";
/// The statistic of forms in all windows.
pub const FORMS: &str = "forms in all windows";

/// Rules that are equal in this pass, and rules without use in it.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct Kinds {
    /// Names of rules that are the same between signed bags, in order.
    pub used: Vec<Vec<String>>,
    /// Names of rules that bags satisfy by themselves, that would match
    /// everything, or whose class is too weak.
    pub unused: Vec<String>,
}

/// Sorts the rules of a set by their use in this pass.
pub fn kinds(rules: &RuleSet, trig: bool) -> Kinds {
    let class = if trig {
        NumericClass::RealTrig
    } else {
        NumericClass::Real
    };
    let mut kinds = Kinds::default();
    let mut known = Vec::new();
    for rule in &rules.rules {
        let alone = RuleSet {
            rules: vec![rule.clone()],
            files: Vec::new(),
        };
        let made = BagRule::all(&alone, class);
        let sides: Vec<_> = made
            .iter()
            .map(|made| (made.sides(), made.conditions.clone()))
            .collect();
        match known.iter().position(|other| *other == sides) {
            _ if sides.is_empty() => kinds.unused.push(rule.name.clone()),
            Some(place) => kinds.used[place].push(rule.name.clone()),
            None => {
                known.push(sides);
                kinds.used.push(vec![rule.name.clone()]);
            }
        }
    }
    kinds
}

fn maker_name(rules: &[BagRule], maker: u32) -> &str {
    let maker = maker as usize;
    match rules.get(maker) {
        Some(rule) => &rule.name,
        None => STRUCTURE[maker - rules.len()],
    }
}

/// The rules of a set, in one direction each, without those whose results the
/// machine cannot place, and the names of the user's rules among these: a
/// quotient or root without an element for it, or the sine or cosine of a value
/// other than an angle, since a host prepares those of inputs alone.
fn placeable(rules: &RuleSet, machine: &Machine) -> (RuleSet, Vec<String>) {
    let is_placeable = |rule: &Rule| {
        let made = rule
            .right
            .operations()
            .filter(|&made| !rule.left.uses(|known| known == made));
        let elements = made
            .filter(|made| matches!(made, Operation::Div | Operation::Sqrt))
            .all(|made| machine.kind_of(made).is_some());
        let angles = rule.left.angles();
        elements
            && rule
                .right
                .angles()
                .iter()
                .all(|angle| angles.contains(angle))
    };
    let directed = rules.rules.iter().flat_map(Rule::directed);
    let (used, left_out): (Vec<Rule>, Vec<Rule>) = directed.partition(is_placeable);
    // Of those that ship only ways back make what cannot be placed.
    let own = left_out.into_iter();
    let own = own.filter(|rule| !DEFAULT.contains(&rule.group.as_str()));
    let names = own.map(|rule| rule.name).collect();
    let placeable = RuleSet {
        rules: used,
        files: rules.files.clone(),
    };
    (placeable, names)
}

impl Pass for Eqsat {
    fn class(&self, declared: NumericClass) -> NumericClass {
        if self.trig {
            NumericClass::RealTrig
        } else {
            declared
        }
    }

    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let weights = Weights::cycles(context.machine);
        let (placeable, left_out) = placeable(context.rules, context.machine);
        if !left_out.is_empty() {
            context.remark(format!(
                "left out, since the machine {} cannot place what they make: {}",
                context.machine.name,
                left_out.join(", ")
            ));
        }
        let rules = BagRule::all(&placeable, self.class(NumericClass::Real));
        let plain = if self.ac {
            plain::all(&placeable, self.class(NumericClass::Real))
        } else {
            Vec::new()
        };
        let settings = Settings {
            rules: &rules,
            plain: self.ac.then_some(&plain),
            weights: &weights,
            size: self.window as usize,
            limits: SaturationLimits {
                nodes: self.nodes as usize,
                iterations: self.iterations,
                steps: self.steps,
            },
            trig: self.trig,
            trail: context.notes.are_wanted(),
        };
        let size = |function: &Function| {
            let path = longest(&arrivals(function, &weights));
            (path, function.nodes().len())
        };
        let before = size(function);
        let mut best = before;
        let most = before.1 + before.1 * self.growth as usize / 100;
        let mut nodes = FIRST_NODES + before.1 * NODES_PER_OPERATION;
        let mut step = (best.0 / 16).max(12);
        let mut windows = 0;
        let [mut out_of_nodes, mut out_of_iterations, mut forms] = [0; 3];
        let mut rewritten = 0;
        for _ in 0..self.rounds {
            let mut budget = RoundBudget {
                nodes: nodes / 2,
                operations: most as i64 - best.1 as i64,
            };
            let given = budget.nodes;
            let round = round::run(
                function,
                &settings,
                best.0.saturating_sub(step),
                &mut budget,
            );
            nodes -= given - budget.nodes;
            windows += round.windows;
            out_of_nodes += round.out_of_nodes;
            out_of_iterations += round.out_of_iterations;
            forms += round.nodes as u64;
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
        context.count(WINDOWS, windows);
        context.count(OUT_OF_NODES, out_of_nodes);
        context.count(OUT_OF_ITERATIONS, out_of_iterations);
        context.count(FORMS, forms);
        context.count("windows rewritten", rewritten);
        context.count(
            "cycles taken off the longest path",
            (before.0 - best.0).into(),
        );
        Ok(())
    }
}
