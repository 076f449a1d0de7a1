//! Products and sums in one operation.
//!
//! A fused multiply-add is shorter than a product and a sum in a row, but
//! longer than the sum alone: on a chain that runs through the factors it saves
//! cycles, on one that runs through the addend it costs some. It saves an
//! operation only if the product has no other reader. So both are decided by
//! arrival times: first each sum gets the form with the earliest arrival, which
//! gives the shortest path (each form uses its operands as early as possible,
//! and no choice delays another); then, within the slack of that path, each sum
//! gets the form that makes a product unnecessary, or is unchanged.
//!
//! A contraction never adds an operation: a product that is read elsewhere
//! too stays, and the sum that took it in is one operation as before.

use crate::sums::fused::contraction;
use crate::sums::writer::ArrivalTimes;
use robovec_analysis::critical_path::{Weights, critical_path};
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::Rewriter;
use robovec_ir::{Function, Machine, Node, Operand, Operation};

declare_pass! {
    /// Contracts products and sums into fused multiply-adds.
    ///
    /// `a*b + c` becomes `fma(a, b, c)`, `a*b - c` becomes `fms(a, b, c)` and
    /// `c - a*b` becomes `fnma(a, b, c)`, each with one rounding, where the
    /// machine has elements that perform them (`machines/fused.toml`); on
    /// other machines nothing is contracted, as a remark reports.
    ///
    /// The longest path becomes as short as contraction can make it, in
    /// cycles of the machine, and never longer. Within it every product goes
    /// that can: those all of whose readers are sums with time for it. The
    /// number of operations never grows.
    ///
    /// With few elements the schedule is as long as the operations of the
    /// busiest kind take. `share` then leaves some products and sums as they
    /// are, evenly through the program, so that no kind has more to do than
    /// the numbers of elements in the machine file warrant.
    ///
    /// Best after `balance`, `cse` and `dce`, and before `place`.
    pub struct Fma("fma") {
        /// Contracts wherever a product vanishes, whatever the machine and
        /// the path: for C on a processor that has the instruction.
        pub always: bool = false,
        /// Shares the work among all kinds of elements instead of leaving as
        /// few operations as possible.
        pub share: bool = false,
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Real,
    destroys: [Timed],
}

impl Pass for Fma {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let machine = context.machine;
        let performs = |operation| self.always || machine.kind_of(operation).is_some();
        let mut fused = Operation::ALL.into_iter().filter(|known| known.is_fused());
        if !fused.any(performs) {
            let name = &machine.name;
            context.remark(format!(
                "nothing is contracted: the machine '{name}' has no elements that perform fma, \
                 fms or fnma; the machine 'fused' has, and fma{{always}} is for C"
            ));
            return Ok(());
        }
        let weights = Weights::cycles(machine);
        let contraction = Contraction::new(function, &performs, weights, !self.always);
        let mut forms = contraction.decide(self.share.then_some(machine));
        for (form, node) in forms.iter_mut().zip(function.nodes()) {
            if *form != ContractionForm::Plain && !context.allow_rewrite(node.name, "contract") {
                *form = ContractionForm::Plain;
            }
        }
        let before = critical_path(function, machine).asap_cycle;
        let sums = function.nodes().len();
        let fused = forms
            .iter()
            .filter(|&&form| form != ContractionForm::Plain)
            .count();
        *function = contracted(function, &forms, context);
        let after = critical_path(function, machine).asap_cycle;
        let saved = sums - function.nodes().len();
        context.count("sums fused", fused as u64);
        context.count("operations saved", saved as u64);
        if !self.always {
            let cycles = before.saturating_sub(after);
            let cycles = ("cycles taken off the longest path", cycles.into());
            context.statistics.push(cycles);
        }
        Ok(())
    }
}

/// Sweeps after which a product that has kept a reader stays contracted for
/// the others; more are needed only where sums compete for products in rows.
const MAX_SWEEPS: usize = 4;

/// All of a part: parts are counted in steps of this fraction.
const WHOLE: u32 = 64;

/// Rating of a form, the smallest the best: whether it is late, then its gain.
type Rating = (bool, (u32, u32));

/// The product that is fused with a sum.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum ContractionForm {
    /// No contraction.
    Plain,
    /// The product that is its operand of this number, from 0.
    Fused(usize),
}

const FORMS: [ContractionForm; 3] = [
    ContractionForm::Plain,
    ContractionForm::Fused(0),
    ContractionForm::Fused(1),
];

/// The gain of a form, the best first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum ContractionGain {
    /// The product is removed, since it has no other reader.
    Vanishes,
    /// The product is removed if its other readers absorb it as well.
    MayVanish,
    /// No product is fused.
    Nothing,
    /// The product stays.
    Stays,
}

/// The choice of forms.
struct Contraction<'a> {
    function: &'a Function,
    weights: Weights,
    /// Operations that may be made.
    performs: &'a dyn Fn(Operation) -> bool,
    /// True if the path must stay as short as it can be.
    timed: bool,
    uses: Vec<u32>,
    /// Products that stay: read by an operation that does not absorb them.
    stays: Vec<bool>,
}

impl<'a> Contraction<'a> {
    fn new(
        function: &'a Function,
        performs: &'a dyn Fn(Operation) -> bool,
        weights: Weights,
        timed: bool,
    ) -> Contraction<'a> {
        let mut stays = vec![false; function.nodes().len()];
        for node in function.nodes() {
            let [left, right, _] = node.operands;
            if !is_sum(node) || left == right {
                for value in node.operands().iter().filter_map(|operand| operand.value()) {
                    stays[value.index()] = true;
                }
            }
        }
        for assignment in &function.assignments {
            if let Some(value) = assignment.operand.value() {
                stays[value.index()] = true;
            }
        }
        Contraction {
            function,
            weights,
            performs,
            timed,
            uses: function.use_counts(),
            stays,
        }
    }

    /// The form of every node; where the work is shared, for this machine.
    fn decide(mut self, shared: Option<&Machine>) -> Vec<ContractionForm> {
        let limits = self.timed.then(|| self.limits());
        let limits = limits.as_deref();
        let key = |gain, arrival| (gain as u32, arrival);
        let mut forms = Vec::new();
        for _ in 0..MAX_SWEEPS {
            forms = self.sweep(limits, WHOLE, key);
            if !self.note_stays(&forms) {
                break;
            }
        }
        if let Some(machine) = shared {
            let least = self.sweep(limits, 0, key);
            let part = self.part(machine, &least, &forms);
            forms = self.sweep(limits, part, key);
        }
        forms
    }

    /// The part of the contractions without effect on a path that gives the
    /// busiest kind of element the least work, from the work with none and with
    /// all.
    fn part(&self, machine: &Machine, none: &[ContractionForm], all: &[ContractionForm]) -> u32 {
        let [none, all] = [none, all].map(|forms| self.loads(machine, forms));
        let busiest = |part: &u32| {
            let loads = none.iter().zip(&all).zip(&machine.elements);
            let loads = loads.map(|((&none, &all), element)| {
                let operations = none * u64::from(WHOLE - part) + all * u64::from(*part);
                operations.div_ceil(u64::from(element.count))
            });
            loads.fold(0, u64::max)
        };
        // Of equals the largest: the fewest operations.
        let best = (0..=WHOLE).rev().min_by_key(busiest);
        best.expect("there are parts to choose from")
    }

    /// Operations of every kind of element.
    fn loads(&self, machine: &Machine, forms: &[ContractionForm]) -> Vec<u64> {
        let taken = taken(self.function, forms);
        let mut loads = vec![0; machine.elements.len()];
        for (index, node) in self.function.nodes().iter().enumerate() {
            let stays = taken[index] == 0 || taken[index] < self.uses[index];
            let (operation, _) = self.shape(node, forms[index]);
            if let Some(kind) = machine.kind_of(operation).filter(|_| stays) {
                loads[kind] += 1;
            }
        }
        loads
    }

    /// For every node the latest time of its result for the shortest path: that
    /// of the earliest forms.
    fn limits(&self) -> Vec<u32> {
        let forms = self.sweep(None, WHOLE, |gain, arrival| (arrival, gain as u32));
        let path = self.times(&forms).longest();
        let mut limits = vec![path; self.function.nodes().len()];
        for (value, node) in self.function.values().rev() {
            let (operation, operands) = self.shape(node, forms[value.index()]);
            let start = limits[value.index()].saturating_sub(self.weights.of(operation));
            for operand in operands.iter().filter_map(|operand| operand.value()) {
                let limit = &mut limits[operand.index()];
                *limit = (*limit).min(start);
            }
        }
        limits
    }

    /// Gives every node, in program order, the form that `key` likes best of
    /// those that are there within the limit; one always is, since operands
    /// keep to theirs. Of the nodes that would make a product vanish only a
    /// part (of [`WHOLE`]), evenly spread, does so for its own sake.
    fn sweep(
        &self,
        limits: Option<&[u32]>,
        part: u32,
        key: impl Fn(ContractionGain, u32) -> (u32, u32),
    ) -> Vec<ContractionForm> {
        let mut times = ArrivalTimes::new(self.weights, self.function.nodes().len());
        let mut forms = Vec::with_capacity(self.function.nodes().len());
        let mut due = 0;
        for (value, node) in self.function.values() {
            let limit = limits.map_or(u32::MAX, |limits| limits[value.index()]);
            let mut best: Option<(Rating, ContractionForm, u32)> = None;
            let gains = FORMS.map(|form| self.gain(node, form));
            let saves = |gain: &Option<ContractionGain>| {
                gain.is_some_and(|gain| gain < ContractionGain::Nothing)
            };
            due += if gains.iter().any(saves) { part } else { 0 };
            let saving = due >= WHOLE;
            due -= if saving { WHOLE } else { 0 };
            for (form, gain) in FORMS.into_iter().zip(gains) {
                let Some(gain) = gain else { continue };
                let gain = if saving || gain >= ContractionGain::Nothing {
                    gain
                } else {
                    ContractionGain::Stays
                };
                let (operation, operands) = self.shape(node, form);
                let arrival = times.finish(operation, &operands);
                let key = (arrival > limit, key(gain, arrival));
                if best.is_none_or(|(least, _, _)| key < least) {
                    best = Some((key, form, arrival));
                }
            }
            let (_, form, arrival) = best.expect("an operation can stay as it is");
            times.note(arrival);
            forms.push(form);
        }
        forms
    }

    /// Products that some reader takes in and another does not stay; true
    /// when there are new ones.
    fn note_stays(&mut self, forms: &[ContractionForm]) -> bool {
        let taken = taken(self.function, forms);
        let mut new = false;
        for (index, &taken) in taken.iter().enumerate() {
            if taken > 0 && taken < self.uses[index] && !self.stays[index] {
                self.stays[index] = true;
                new = true;
            }
        }
        new
    }

    /// Time at which every value is available.
    fn times(&self, forms: &[ContractionForm]) -> ArrivalTimes {
        let mut times = ArrivalTimes::new(self.weights, forms.len());
        for (node, &form) in self.function.nodes().iter().zip(forms) {
            let (operation, operands) = self.shape(node, form);
            times.note(times.finish(operation, &operands));
        }
        times
    }

    /// The gain of a form; `None` when it is not possible for the node.
    fn gain(&self, node: &Node, form: ContractionForm) -> Option<ContractionGain> {
        let ContractionForm::Fused(side) = form else {
            return Some(ContractionGain::Nothing);
        };
        if !is_sum(node) {
            return None;
        }
        let product = node.operands[side].value()?;
        let is_product = self.function.node(product).operation == Operation::Mul;
        let (operation, _) = contraction(self.function, node, side);
        if !is_product || !(self.performs)(operation) {
            return None;
        }
        Some(
            match (self.stays[product.index()], self.uses[product.index()]) {
                (true, _) => ContractionGain::Stays,
                (false, 1) => ContractionGain::Vanishes,
                (false, _) => ContractionGain::MayVanish,
            },
        )
    }

    fn shape(
        &self,
        node: &Node,
        form: ContractionForm,
    ) -> (Operation, [Operand; Operand::MAX_COUNT]) {
        match form {
            ContractionForm::Plain => (node.operation, node.operands),
            ContractionForm::Fused(side) => contraction(self.function, node, side),
        }
    }
}

fn is_sum(node: &Node) -> bool {
    matches!(node.operation, Operation::Add | Operation::Sub)
}

/// The number of readers that take in each node.
fn taken(function: &Function, forms: &[ContractionForm]) -> Vec<u32> {
    let mut taken = vec![0; forms.len()];
    for (node, &form) in function.nodes().iter().zip(forms) {
        if let ContractionForm::Fused(side) = form
            && let Some(product) = node.operands[side].value()
        {
            taken[product.index()] += 1;
        }
    }
    taken
}

/// The function with sums in their forms, without the products that all
/// their readers took in.
fn contracted(
    function: &Function,
    forms: &[ContractionForm],
    context: &mut Context<'_>,
) -> Function {
    let taken = taken(function, forms);
    let uses = function.use_counts();
    let mut rewriter = Rewriter::new(function, function.level);
    for (value, node) in function.values() {
        let index = value.index();
        if taken[index] > 0 && taken[index] == uses[index] {
            rewriter.record(Operand::NONE);
            continue;
        }
        let ContractionForm::Fused(side) = forms[index] else {
            let operands = rewriter.translate_operands(node);
            rewriter.keep(Node { operands, ..*node });
            continue;
        };
        let (operation, operands) = contraction(function, node, side);
        let operands = operands.map(|operand| rewriter.translate(operand));
        let mut sources = node.sources;
        if let Some(product) = node.operands[side].value() {
            let sets = [node.sources, function.node(product).sources];
            sources = context.tables.sources.union(&sets);
        }
        rewriter.keep(Node {
            operation,
            operands,
            sources,
            ..*node
        });
        context.note(node.name, "contract");
    }
    rewriter.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::Value;
    use robovec_ir::parse::parse_module;
    use robovec_num::random::Random;

    /// Fewest cycles, then fewest operations, over all forms of all sums.
    fn best_of_all(contraction: &Contraction<'_>) -> (u32, usize) {
        let function = contraction.function;
        let mut best = (u32::MAX, usize::MAX);
        let sums: Vec<usize> = (0..function.nodes().len())
            .filter(|&index| is_sum(&function.nodes()[index]))
            .collect();
        for code in 0..3_usize.pow(sums.len() as u32) {
            let mut forms = vec![ContractionForm::Plain; function.nodes().len()];
            let mut rest = code;
            for &index in &sums {
                forms[index] = FORMS[rest % 3];
                rest /= 3;
            }
            let mut pairs = function.nodes().iter().zip(&forms);
            if pairs.all(|(node, &form)| contraction.gain(node, form).is_some()) {
                best = best.min(measure(contraction, &forms));
            }
        }
        best
    }

    /// Path and operations of a choice.
    fn measure(contraction: &Contraction<'_>, forms: &[ContractionForm]) -> (u32, usize) {
        let function = contraction.function;
        let taken = taken(function, forms);
        let stays = (0..forms.len())
            .filter(|&index| taken[index] == 0 || taken[index] < contraction.uses[index]);
        let times = contraction.times(forms);
        let path = stays
            .clone()
            .map(|index| times.of(Value(index as u32).into()))
            .max();
        (path.unwrap_or(0), stays.count())
    }

    /// A random program of sums and products, each read at least once.
    fn random(seed: u64) -> Function {
        let mut random = Random::new(seed);
        let mut below = |limit: usize| random.below(limit);
        let mut text = "function f atomic {\n in x[1..4]\n out o[1..9]\n".to_owned();
        let mut unread: Vec<usize> = Vec::new();
        for node in 0..9 {
            let mut pick = |unread: &mut Vec<usize>| {
                if !unread.is_empty() && below(3) > 0 {
                    return format!("%v.{}", unread.remove(below(unread.len())));
                }
                match (node > 0, below(2)) {
                    (true, 0) => {
                        let other = 1 + below(node);
                        unread.retain(|&known| known != other);
                        format!("%v.{other}")
                    }
                    _ => format!("x[{}]", 1 + below(4)),
                }
            };
            let (a, b) = (pick(&mut unread), pick(&mut unread));
            let sign = ["*", "*", "+", "-"][below(4)];
            text += &format!("%v.{} = {a} {sign} {b}\n", node + 1);
            unread.push(node + 1);
        }
        for (place, value) in unread.iter().enumerate() {
            text += &format!("o[{}] = %v.{value}\n", place + 1);
        }
        let mut module = parse_module("random", &(text + "}\n")).expect("a well-formed program");
        module.functions.remove(0)
    }

    #[test]
    fn paths_are_the_shortest_and_operations_nearly_the_fewest() {
        let machine = Machine::built_in("fused").expect("it ships");
        let (mut cases, mut fewest) = (0, 0);
        for seed in 0..400 {
            let function = random(seed);
            let new = || Contraction::new(&function, &|_| true, Weights::cycles(&machine), true);
            let (contraction, all) = (new(), best_of_all(&new()));
            let reached = measure(&contraction, &new().decide(None));
            assert_eq!(reached.0, all.0, "seed {seed}");
            assert!(reached.1 >= all.1 && reached.1 <= function.nodes().len());
            cases += 1;
            fewest += u32::from(reached.1 == all.1);
        }
        assert!(fewest * 100 >= cases * 95, "fewest in {fewest} of {cases}");
    }
}
