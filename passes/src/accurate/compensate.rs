//! Rounding errors that are computed and taken off.
//!
//! The rounding error of a sum or of a product is itself a number of the format
//! and can be computed: that of a sum by five additions more (Knuth, *The Art
//! of Computer Programming* 2, 4.2.2), that of a product by one fused
//! operation, or by sixteen others (Dekker, *Numerische Mathematik* 18, 1971).
//! A value whose error is computed is *tracked*; a *correction* is stored with
//! it. Sums and products that read a tracked value propagate the correction, to
//! first order (Langlois, *Automatic linear correction of rounding errors*, BIT
//! 41, 2001), and where another operation reads the value, value and correction
//! are added: one rounding for all the errors before it. Within one sum this is
//! the compensated sum of Ogita, Rump and Oishi (*SIAM J. Sci. Comput.* 26,
//! 2005), but it does not end at the equation.
//!
//! Over the real numbers every correction is zero.

use super::profile::{LANES, SensitivityProfile, StateLanes, add, is_exact, product, squares};
use crate::sums::groups::GroupFamily;
use crate::sums::writer::{ArrivalTimes, joining};
use robovec_analysis::critical_path::{Weights, tails};
use robovec_framework::pass::Context;
use robovec_framework::rewrite::{Rewriter, owners, without_dead};
use robovec_ir::{
    Format, FreshNames, Function, Name, Node, Operand, Operation, SourceSet, Symbol, Value,
};

/// Attempts to keep within the allowed operations, each with fewer values.
const ATTEMPTS: usize = 10;

/// The limits of compensation.
pub(super) struct CompensationBudget {
    /// The longest path, in cycles.
    pub(super) limit: u32,
    pub(super) operations: usize,
    /// The format, whose significand is split where nothing is fused.
    pub(super) format: Format,
}

/// A compensated version of a function.
pub(super) struct Compensated {
    pub(super) function: Function,
    /// The number of values that are tracked.
    pub(super) tracked: usize,
    /// The squared error of all outputs that is to be expected, in units of
    /// the squared roundoff.
    pub(super) predicted: f64,
}

/// The versions that track the most harmful values: the number that the budget
/// allows, a half of them, a quarter, and so on; the best first.
pub(super) fn compensated(
    function: &Function,
    profile: &SensitivityProfile,
    budget: &CompensationBudget,
    context: &mut Context<'_>,
) -> Vec<Compensated> {
    let fused = context.machine.kind_of(Operation::Fms).is_some();
    let ranked = ranked(function, profile, fused);
    let count = function.nodes().len();
    let spare = budget.operations.saturating_sub(count);
    // A tracked sum adds at least five operations, a fused product one.
    let mut most = ranked.len().min(spare);
    let mut found: Vec<Compensated> = Vec::new();
    for _ in 0..ATTEMPTS {
        if most == 0 {
            break;
        }
        let version = write(function, profile, budget, &ranked[..most], context);
        let size = version.function.nodes().len();
        let fits = size <= budget.operations;
        most = match fits {
            true => most / 2,
            // Proportionally fewer, and some more to be sure.
            false => (most * spare / (size - count) * 9 / 10).min(most - 1),
        };
        if fits {
            found.push(version);
        }
    }
    found.sort_by(|a, b| a.predicted.total_cmp(&b.predicted));
    found
}

/// The values whose rounding can be computed, the one first that saves most
/// per operation.
fn ranked(function: &Function, profile: &SensitivityProfile, fused: bool) -> Vec<Value> {
    let mut ranked: Vec<(f64, Value)> = Vec::new();
    for (value, node) in function.values() {
        let cost = match node.operation {
            Operation::Add | Operation::Sub => 7.0,
            Operation::Mul if fused => 3.0,
            Operation::Mul => 18.0,
            _ => continue,
        };
        let harm = profile.blame(value.index());
        if harm > 0.0 && !is_exact(function, node) {
            ranked.push((harm / cost, value));
        }
    }
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    ranked.into_iter().map(|(_, value)| value).collect()
}

/// True for operations that can carry corrections on.
fn carries(operation: Operation) -> bool {
    matches!(operation, Operation::Add | Operation::Sub | Operation::Mul)
}

/// A correction: to be added, or subtracted when negative.
#[derive(Clone, Copy)]
struct Correction {
    operand: Operand,
    negative: bool,
}

/// The translation of an old value.
#[derive(Clone, Copy)]
struct CompensatedValue {
    /// The rounded value.
    main: Operand,
    correction: Option<Correction>,
    /// For readers that do not take corrections.
    absorbed: Operand,
    /// The parts of the correction that exist: its own, and those that come
    /// with the operands.
    kept: [bool; 3],
}

/// A correction with the part it was before others were added.
type CorrectionParts = Vec<(usize, Correction)>;

struct CompensationWriter<'a> {
    function: &'a Function,
    budget: &'a CompensationBudget,
    fused: bool,
    required: Vec<u32>,
    tracked: Vec<bool>,
    /// True for tracked values, and for readers of tracked values.
    raised: Vec<bool>,
    rewriter: Rewriter<'a>,
    times: ArrivalTimes,
    states: Vec<CompensatedValue>,
    /// High and low halves of old values and other operands, once made.
    halves: hashbrown::HashMap<Operand, [Operand; 2], rustc_hash::FxBuildHasher>,
    names: FreshNames,
    owners: Vec<Symbol>,
}

fn write(
    function: &Function,
    profile: &SensitivityProfile,
    budget: &CompensationBudget,
    chosen: &[Value],
    context: &mut Context<'_>,
) -> Compensated {
    let weights = Weights::cycles(context.machine);
    let mut tracked = vec![false; function.nodes().len()];
    for value in chosen {
        let name = function.node(*value).name;
        tracked[value.index()] = context.allow_rewrite(name, "compensate");
    }
    let raised = raised(function, &tracked);
    let tails = tails(function, &weights).into_iter();
    let mut writer = CompensationWriter {
        rewriter: Rewriter::new(function, function.level),
        times: ArrivalTimes::new(weights, function.nodes().len()),
        states: Vec::with_capacity(function.nodes().len()),
        halves: hashbrown::HashMap::default(),
        names: function.fresh_names(),
        owners: owners(context.tables, function),
        required: tails
            .map(|tail| budget.limit.saturating_sub(tail))
            .collect(),
        fused: context.machine.kind_of(Operation::Fms).is_some(),
        function,
        budget,
        tracked,
        raised,
    };
    for (value, node) in function.values() {
        let state = if writer.raised[value.index()] {
            writer.raise(value, node, context)
        } else {
            writer.plain(node)
        };
        writer.states.push(state);
        writer.rewriter.record(state.absorbed);
    }
    let predicted = writer.predicted(profile);
    let CompensationWriter { rewriter, .. } = writer;
    Compensated {
        function: without_dead(rewriter.finish()),
        tracked: chosen.len(),
        predicted,
    }
}

/// For each value whether it is tracked, or reads a tracked one and carries its
/// correction.
fn raised(function: &Function, tracked: &[bool]) -> Vec<bool> {
    let mut raised = tracked.to_vec();
    for (value, node) in function.values() {
        let mut read = node.operands().iter().filter_map(|operand| operand.value());
        if carries(node.operation) && read.any(|operand| tracked[operand.index()]) {
            raised[value.index()] = true;
        }
    }
    raised
}

impl CompensationWriter<'_> {
    fn push(&mut self, node: Node) -> Operand {
        self.times.push(&mut self.rewriter.new, node).into()
    }

    /// A value that takes no corrections.
    fn plain(&mut self, node: &Node) -> CompensatedValue {
        let operands = self.rewriter.translate_operands(node);
        let main = self.push(Node { operands, ..*node });
        CompensatedValue {
            main,
            correction: None,
            absorbed: main,
            kept: [false; 3],
        }
    }

    /// A rounded value, and its correction.
    fn known(&mut self, operand: Operand) -> (Operand, Option<Correction>) {
        match operand.value() {
            Some(value) => {
                let state = self.states[value.index()];
                (state.main, state.correction)
            }
            None => (self.rewriter.translate(operand), None),
        }
    }

    fn raise(&mut self, value: Value, node: &Node, context: &mut Context<'_>) -> CompensatedValue {
        let [(a, of_a), (b, of_b)] = [self.known(node.operands[0]), self.known(node.operands[1])];
        let main = self.push(Node {
            operands: Operand::list([a, b]),
            ..*node
        });
        let mut make = CorrectionMaker {
            owner: self.owners[value.index()],
            sources: node.sources,
            writer: self,
        };
        let mut parts = CorrectionParts::new();
        if make.writer.tracked[value.index()] {
            let operand = match node.operation {
                Operation::Mul => make.error_of_product(a, b, main),
                operation => make.error_of_sum(operation, a, b, main),
            };
            let negative = false;
            parts.push((0, Correction { operand, negative }));
        }
        for (place, correction, other) in [(1, of_a, b), (2, of_b, a)] {
            let Some(correction) = correction else {
                continue;
            };
            let carried = match node.operation {
                Operation::Mul => Correction {
                    operand: make.emit(Operation::Mul, [correction.operand, other]),
                    ..correction
                },
                operation => Correction {
                    negative: correction.negative ^ (operation == Operation::Sub && place == 2),
                    ..correction
                },
            };
            parts.push((place, carried));
        }
        parts.sort_by_key(|(_, part)| make.writer.times.of(part.operand));
        let (correction, absorbed, kept) = make.collect(value, main, &parts);
        if let Some(absorbed) = absorbed.and_then(Operand::value) {
            // Who asks for the value by its name gets the better one.
            let name = std::mem::replace(&mut self.rewriter.new.node_mut(absorbed).name, node.name);
            if let Some(rounded) = main.value() {
                self.rewriter.new.node_mut(rounded).name = name;
            }
        }
        context.note(node.name, "compensate");
        CompensatedValue {
            main,
            correction,
            absorbed: absorbed.unwrap_or(main),
            kept,
        }
    }

    /// The squared error to be expected of the outputs.
    fn predicted(&self, profile: &SensitivityProfile) -> f64 {
        let function = self.function;
        let count = function.nodes().len();
        // What reaches the outputs of a rounding although it is tracked, and
        // what reaches them through readers that take no correction.
        let mut lost = vec![[0.0; LANES]; count];
        let mut plain = vec![[0.0; LANES]; count];
        for (place, assignment) in function.assignments.iter().enumerate() {
            if let Some(value) = assignment.operand.value() {
                add(&mut plain[value.index()], profile.seed(place));
            }
        }
        let mut error = 0.0;
        for (value, node) in function.values().rev() {
            let index = value.index();
            let state = &self.states[index];
            if state.absorbed != state.main {
                error += squares(&plain[index], profile.value(index));
            }
            // By part: what reaches the outputs although it was computed.
            let reached = state.kept.map(|kept| {
                let mut reached = lost[index];
                if !kept {
                    add(&mut reached, &plain[index]);
                }
                reached
            });
            error += match self.tracked[index] {
                true => squares(&reached[0], profile.value(index)),
                false if is_exact(function, node) => 0.0,
                false => profile.blame(index),
            };
            let partials = profile.partials(function, index);
            for (side, operand) in node.operands().iter().enumerate() {
                let Some(read) = operand.value().map(Value::index) else {
                    continue;
                };
                let through = |adjoint: &StateLanes| product(adjoint, &partials[side]);
                if self.raised[index] {
                    add(&mut lost[read], &through(&reached[side + 1]))
                } else {
                    add(&mut plain[read], &through(profile.adjoint(index)))
                }
            }
        }
        error
    }
}

/// Makes the operations beside a value.
struct CorrectionMaker<'w, 'a> {
    writer: &'w mut CompensationWriter<'a>,
    owner: Symbol,
    sources: SourceSet,
}

impl CorrectionMaker<'_, '_> {
    fn emit<const COUNT: usize>(
        &mut self,
        operation: Operation,
        operands: [Operand; COUNT],
    ) -> Operand {
        let name: Name = self.writer.names.fresh(self.owner);
        self.writer.push(Node {
            name,
            sources: self.sources,
            operands: Operand::list(operands),
            operation,
        })
    }

    /// The rounding error of `sum = a + b` or `a - b`.
    fn error_of_sum(
        &mut self,
        operation: Operation,
        a: Operand,
        b: Operand,
        sum: Operand,
    ) -> Operand {
        let other = self.emit(Operation::Sub, [sum, a]);
        let first = self.emit(Operation::Sub, [sum, other]);
        let of_a = self.emit(Operation::Sub, [a, first]);
        match operation {
            Operation::Add => {
                let of_b = self.emit(Operation::Sub, [b, other]);
                self.emit(Operation::Add, [of_a, of_b])
            }
            _ => {
                let of_b = self.emit(Operation::Add, [b, other]);
                self.emit(Operation::Sub, [of_a, of_b])
            }
        }
    }

    /// The rounding error of `product = a * b`.
    fn error_of_product(&mut self, a: Operand, b: Operand, product: Operand) -> Operand {
        if self.writer.fused {
            return self.emit(Operation::Fms, [a, b, product]);
        }
        let [a_high, a_low] = self.halves(a);
        let [b_high, b_low] = self.halves(b);
        let parts = [[a_high, b_low], [a_low, b_high], [a_low, b_low]];
        let high = self.emit(Operation::Mul, [a_high, b_high]);
        let mut error = self.emit(Operation::Sub, [high, product]);
        for pair in parts {
            let part = self.emit(Operation::Mul, pair);
            error = self.emit(Operation::Add, [error, part]);
        }
        error
    }

    /// The upper and the lower half of a number's significand.
    fn halves(&mut self, operand: Operand) -> [Operand; 2] {
        if let Some(&known) = self.writer.halves.get(&operand) {
            return known;
        }
        let lower = self.writer.budget.format.significand().div_ceil(2);
        let factor = f64::from(1u32 << lower.min(31)) + 1.0;
        let factor = Operand::from(self.writer.rewriter.new.constant(factor));
        let scaled = self.emit(Operation::Mul, [factor, operand]);
        let rest = self.emit(Operation::Sub, [scaled, operand]);
        let high = self.emit(Operation::Sub, [scaled, rest]);
        let low = self.emit(Operation::Sub, [operand, high]);
        self.writer.halves.insert(operand, [high, low]);
        [high, low]
    }

    /// The sum of the parts, the earliest first; the value with as many of them
    /// as the time permits, and the list of these.
    fn collect(
        &mut self,
        value: Value,
        main: Operand,
        parts: &[(usize, Correction)],
    ) -> (Option<Correction>, Option<Operand>, [bool; 3]) {
        let mut sums: Vec<Correction> = Vec::with_capacity(parts.len());
        for &(_, part) in parts {
            let sum = match sums.last() {
                Some(&sum) => self.add(sum, part),
                None => part,
            };
            sums.push(sum);
        }
        let mut kept = [false; 3];
        for count in (1..=sums.len()).rev() {
            if let Some(absorbed) = self.absorb(value, main, sums[count - 1]) {
                for (place, _) in &parts[..count] {
                    kept[*place] = true;
                }
                return (sums.last().copied(), Some(absorbed), kept);
            }
        }
        (sums.last().copied(), None, kept)
    }

    fn add(&mut self, a: Correction, b: Correction) -> Correction {
        let pair = [a, b].map(|part| (part.operand, part.negative));
        let (operation, operands, negative) = joining(GroupFamily::Sum, pair, false);
        Correction {
            operand: self.emit(operation, operands),
            negative,
        }
    }

    /// Value and correction in one number, when there is time.
    fn absorb(&mut self, value: Value, main: Operand, correction: Correction) -> Option<Operand> {
        let operation = if correction.negative {
            Operation::Sub
        } else {
            Operation::Add
        };
        let operands = [main, correction.operand];
        let finish = self.writer.times.finish(operation, &operands);
        let in_time = finish <= self.writer.required[value.index()];
        in_time.then(|| self.emit(operation, operands))
    }
}
