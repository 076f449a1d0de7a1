//! Writes every sum in the order, and with the factored differences, of the
//! least rounding error within the time limit.
//!
//! Every value has a time at which it is required, from the longest path
//! allowed and from the chain after the value in the original function. A sum
//! that keeps its time does not change those of all others, so sums can be
//! treated in sequence, each with the actual times of its terms. The tree a sum
//! has always meets its time, since its terms meet theirs.
//!
//! A sum becomes later than before only where that saves more than a small part
//! of the error of the whole function.

use super::profile::{SensitivityProfile, StateLanes, squares};
use super::terms::{self, StepSource, SumPlan, SumSetting, SumTerm, TermFactor};
use crate::sums::groups::{GroupFamily, GroupLeaf, GroupReach, OperandGroups, single_product};
use crate::sums::writer::{ArrivalTimes, ValueNaming};
use robovec_analysis::critical_path::{Weights, tails};
use robovec_analysis::slice::live;
use robovec_framework::pass::Context;
use robovec_framework::rewrite::{Rewriter, owners};
use robovec_ir::{FreshNames, Function, Name, Node, Operand, Operation, Symbol, Value};

/// The part of the function's error that a sum must save to take time.
const WORTH_TIME: f64 = 1e-5;

/// A plan must cost less than this part of the present cost: gains within the
/// noise of the estimate change nothing.
const CLEARLY_LESS: f64 = 0.999;

/// The result of regrouping.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct Regrouped {
    pub(super) reordered: u64,
    pub(super) factored: u64,
}

/// The function with its sums rewritten, and with unused products.
pub(super) fn regroup(
    function: &Function,
    profile: &SensitivityProfile,
    limit: u32,
    context: &mut Context<'_>,
) -> (Function, Regrouped) {
    let weights = Weights::cycles(context.machine);
    let alive = live(function);
    let total: f64 = (0..alive.len())
        .filter(|&index| alive[index])
        .map(|index| profile.blame(index))
        .sum();
    let tails = tails(function, &weights);
    let required = tails
        .iter()
        .map(|tail| limit.saturating_sub(*tail))
        .collect();
    let groups = OperandGroups::find(function, GroupReach::Maximal);
    let mut writer = RegroupingWriter {
        rewriter: Rewriter::new(function, function.level),
        names: function.fresh_names(),
        owners: owners(context.tables, function),
        uses: function.use_counts(),
        times: ArrivalTimes::new(weights, function.nodes().len()),
        worth: total * WORTH_TIME,
        done: Regrouped::default(),
        function,
        profile,
        required,
        groups,
    };
    for (value, node) in function.values() {
        if writer.groups.is_absorbed(value) && writer.is_sum(value) {
            // Written with its group, which alone reads it.
            writer.rewriter.record(Operand::NONE);
            continue;
        }
        match writer.choose(value) {
            Some((plan, factoring)) if context.allow_rewrite(node.name, "order of terms") => {
                writer.write(value, &plan, factoring, context);
            }
            _ => writer.keep(value),
        }
    }
    let done = writer.done;
    (writer.rewriter.finish(), done)
}

struct RegroupingWriter<'a> {
    function: &'a Function,
    profile: &'a SensitivityProfile,
    groups: OperandGroups,
    rewriter: Rewriter<'a>,
    names: FreshNames,
    owners: Vec<Symbol>,
    uses: Vec<u32>,
    /// Time at which each value of the old function is required.
    required: Vec<u32>,
    /// Arrival times of the values of the new function.
    times: ArrivalTimes,
    worth: f64,
    done: Regrouped,
}

impl RegroupingWriter<'_> {
    fn is_sum(&self, value: Value) -> bool {
        GroupFamily::of(self.function.node(value).operation) == Some(GroupFamily::Sum)
    }

    fn push(&mut self, node: Node) -> Value {
        self.times.push(&mut self.rewriter.new, node)
    }

    /// Writes a value and the values absorbed into it, unchanged.
    fn keep(&mut self, root: Value) {
        let mut absorbed = if self.is_sum(root) {
            self.groups.inner(root).to_vec()
        } else {
            Vec::new()
        };
        absorbed.sort_unstable();
        for value in absorbed {
            let written = self.copy(value);
            self.rewriter.amend(value, written.into());
        }
        let written = self.copy(root);
        self.rewriter.record(written.into());
    }

    fn copy(&mut self, value: Value) -> Value {
        let node = *self.function.node(value);
        let operands = self.rewriter.translate_operands(&node);
        self.push(Node { operands, ..node })
    }

    /// A better computation of the sum of a value, and a flag: true when it
    /// factors differences.
    fn choose(&mut self, root: Value) -> Option<(SumPlan, bool)> {
        if !self.is_sum(root) {
            return None;
        }
        let leaves = self.groups.leaves(root);
        let count = leaves.len();
        let products = leaves.iter().filter(|leaf| self.product(leaf).is_some());
        let products = products.count();
        // Two terms have one order; they can still be two products.
        if count > terms::MAX_TERMS || !(count > 2 || products == 2) || is_error_term(leaves) {
            return None;
        }
        let terms: Vec<SumTerm> = leaves.to_vec().iter().map(|leaf| self.term(leaf)).collect();
        let present = self.present(root, &terms);
        let index = root.index();
        let setting = |deadline| SumSetting {
            adjoint: *self.profile.adjoint(index),
            deadline,
            add: self.times.weights.with_equal_sums().of(Operation::Add),
            multiply: self.times.weights.of(Operation::Mul),
        };
        let best = |deadline: u32| -> Option<(SumPlan, bool)> {
            let factored = (products >= 2)
                .then(|| terms::plan(&setting(deadline), &terms, true))
                .flatten();
            let plain = if count > 2 {
                terms::plan(&setting(deadline), &terms, false)
            } else {
                None
            };
            match (factored, plain) {
                (Some(factored), Some(plain)) if plain.cost < factored.cost => Some((plain, false)),
                (Some(factored), _) => Some((factored, true)),
                (None, plain) => plain.map(|plan| (plan, false)),
            }
        };
        let required = self.required[index];
        let prompt = best(present.1.min(required));
        let patient = if required > present.1 {
            best(required)
        } else {
            None
        };
        let cost =
            |plan: &Option<(SumPlan, bool)>| plan.as_ref().map_or(present.0, |(plan, _)| plan.cost);
        let chosen = if cost(&prompt) - cost(&patient) > self.worth {
            patient
        } else {
            prompt
        };
        chosen.filter(|(plan, _)| plan.cost < CLEARLY_LESS * present.0)
    }

    /// The cost of the present sum, and its arrival time.
    fn present(&self, root: Value, terms: &[SumTerm]) -> (f64, u32) {
        let adjoint = self.profile.adjoint(root.index());
        let products = terms.iter().filter(|term| term.factors.is_some());
        let mut cost: f64 = products.map(|term| squares(adjoint, &term.lanes)).sum();
        let mut nodes = self.groups.inner(root).to_vec();
        nodes.sort_unstable();
        nodes.push(root);
        let mut finished: Vec<(Value, u32)> = Vec::with_capacity(nodes.len());
        for &value in &nodes {
            let node = self.function.node(value);
            let lanes = |operand| self.profile.operand(self.function, operand);
            let [a, b] = [lanes(node.operands[0]), lanes(node.operands[1])];
            cost += match node.operation {
                Operation::Add => addition(adjoint, &a, &b),
                Operation::Sub => addition(adjoint, &a, &b.map(|number| -number)),
                _ => 0.0,
            };
            let ready = node.operands().iter().map(|&operand| {
                let inside = operand
                    .value()
                    .and_then(|value| finished.binary_search_by_key(&value, |&(at, _)| at).ok());
                match inside {
                    Some(place) => finished[place].1,
                    None => self.old_arrival(operand),
                }
            });
            let ready = ready.fold(0, u32::max);
            finished.push((
                value,
                ready.saturating_add(self.times.weights.of(node.operation)),
            ));
        }
        (cost, finished.last().map_or(0, |&(_, at)| at))
    }

    /// Arrival time of the successor of an old operand.
    fn old_arrival(&self, operand: Operand) -> u32 {
        match operand.value() {
            Some(value) => self.times.of(self.rewriter.known(value)),
            None => 0,
        }
    }

    /// The product that a leaf is, when it has no other reader.
    fn product(&self, leaf: &GroupLeaf) -> Option<Value> {
        single_product(self.function, &self.uses, leaf.operand)
    }

    fn term(&mut self, leaf: &GroupLeaf) -> SumTerm {
        let lanes = self.profile.operand(self.function, leaf.operand);
        let source = self.rewriter.translate(leaf.operand);
        let factors = self.product(leaf).map(|product| {
            let [a, b, _] = self.function.node(product).operands;
            [a, b].map(|operand| {
                let source = self.rewriter.translate(operand);
                TermFactor {
                    source: StepSource::Operand(source),
                    lanes: self.profile.operand(self.function, operand),
                    arrival: self.times.of(source),
                }
            })
        });
        SumTerm {
            source: StepSource::Operand(source),
            negative: leaf.negative,
            lanes: if leaf.negative {
                lanes.map(|number| -number)
            } else {
                lanes
            },
            arrival: self.times.of(source),
            factors,
        }
    }

    /// Writes the operations of a plan instead of a group.
    fn write(&mut self, root: Value, plan: &SumPlan, factoring: bool, context: &mut Context<'_>) {
        let node = *self.function.node(root);
        let inner = self.groups.inner(root).to_vec();
        let parts = inner.iter().map(|&value| self.function.node(value));
        let mut parts: Vec<_> = parts.map(|node| (node.name, node.sources)).collect();
        if factoring {
            let leaves = self.groups.leaves(root).iter();
            let products = leaves.filter_map(|leaf| self.product(leaf));
            parts.extend(products.map(|value| (Name::NONE, self.function.node(value).sources)));
        }
        let naming = ValueNaming::new(node.name, self.owners[root.index()], node.sources);
        let mut naming = naming.with_parts(parts.into_iter(), context.tables);
        let needed = needed(plan);
        let mut results: Vec<Operand> = Vec::with_capacity(plan.steps.len());
        for (place, step) in plan.steps.iter().enumerate() {
            if !needed[place] {
                results.push(Operand::NONE);
                continue;
            }
            let last = plan.result == StepSource::Step(place);
            let name = naming.next(last, &mut self.names);
            let operands = step.operands.map(|source| self.resolve(source, &results));
            let result = self.push(Node {
                name,
                sources: naming.sources,
                operands: Operand::list(operands),
                operation: step.operation,
            });
            results.push(result.into());
            context.note(name, if factoring { "factor" } else { "order" });
        }
        let result = self.resolve(plan.result, &results);
        self.rewriter.record(result);
        if factoring {
            self.done.factored += 1
        } else {
            self.done.reordered += 1
        }
    }

    /// The operand of a source; the absent one represents zero.
    fn resolve(&mut self, source: StepSource, results: &[Operand]) -> Operand {
        match source {
            StepSource::Operand(operand) if operand.is_none() => {
                self.rewriter.new.constant(0.0).into()
            }
            StepSource::Operand(operand) => operand,
            StepSource::Step(place) => results[place],
        }
    }
}

/// The steps that the result needs.
fn needed(plan: &SumPlan) -> Vec<bool> {
    let mut needed = vec![false; plan.steps.len()];
    let mark = |needed: &mut Vec<bool>, source: StepSource| {
        if let StepSource::Step(place) = source {
            needed[place] = true;
        }
    };
    mark(&mut needed, plan.result);
    for place in (0..plan.steps.len()).rev() {
        if needed[place] {
            for source in plan.steps[place].operands {
                mark(&mut needed, source);
            }
        }
    }
    needed
}

/// The cost of adding two numbers.
fn addition(adjoint: &StateLanes, a: &StateLanes, b: &StateLanes) -> f64 {
    let setting = SumSetting {
        adjoint: *adjoint,
        deadline: 0,
        add: 0,
        multiply: 0,
    };
    setting.addition(a, b)
}

/// True when a term occurs with both signs. Over the real numbers such terms
/// would vanish; they are there for the rounding errors between them
/// (`super::compensate`).
fn is_error_term(leaves: &[GroupLeaf]) -> bool {
    let opposite = |leaf: &GroupLeaf| GroupLeaf {
        negative: !leaf.negative,
        ..*leaf
    };
    if leaves.len() <= 16 {
        return leaves.iter().any(|leaf| leaves.contains(&opposite(leaf)));
    }
    let mut sorted: Vec<Operand> = leaves.iter().map(|leaf| leaf.operand).collect();
    sorted.sort_unstable();
    sorted.windows(2).any(|pair| pair[0] == pair[1])
}
