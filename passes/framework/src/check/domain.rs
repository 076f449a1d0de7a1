//! The domains of the versions: an output is defined where none of the
//! divisors it depends on is zero and no number under its roots is negative.
//!
//! A condition of the version after holds wherever the version before is
//! defined when it follows from ranges of the operations (`1 + x*x`), or when
//! it is a condition of the same output before: the same function up to a
//! constant factor by its values in a prime field, in which roots, sines and
//! cosines are unrelated elements. A divisor is split into its factors, a
//! number under a root into terms and factors that must not be negative.
//! An open condition is given to the prover of rules where the output is small
//! ([`super::small`]) and to a search along lines ([`super::poles`]).

use super::nth_seed;
use super::pairing::Pairs;
use robovec_analysis::range::Range;
use robovec_analysis::slice::live;
use robovec_ir::evaluate::evaluate_nodes;
use robovec_ir::print::print_operand;
use robovec_ir::states::States;
use robovec_ir::{Function, Operand, OperandKind, Operation, View};
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::field::{Field, FieldPoint};
use rustc_hash::FxHashMap;
use std::array;
use std::cell::OnceCell;

/// A requirement on an operand.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(super) enum DomainRequirement {
    /// A divisor.
    Nonzero,
    /// A number under a root.
    NotNegative,
}

/// A requirement on an operand without which the function is not defined.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct DomainCondition {
    pub(super) requirement: DomainRequirement,
    pub(super) operand: Operand,
}

/// A condition of one version that does not follow from the other one's.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct OpenCondition {
    /// Index into [`Pairs::list`]: the first output that depends on it.
    pub(super) pair: usize,
    pub(super) condition: DomainCondition,
}

/// Points of the field at which values are compared.
const POINTS: usize = 3;
/// States at which the sign of a constant factor is read.
const SIGNS: u32 = 4;
/// Operations of all walks for dependences together.
const WORK: usize = 4_000_000_000;
/// Factors and terms that one condition is split into.
const MAX_PARTS: usize = 64;

/// A value up to a constant factor: the quotients of its residues.
type ValueKey = [u64; POINTS - 1];

/// The key of values that are zero everywhere; no other value has it.
const ZERO: ValueKey = [0; POINTS - 1];

/// The condition of a value up to a constant factor, by number.
type ConditionClass = u32;

/// A version with the residues of its inputs and nodes at the points.
struct VersionValues<'a, F: Field> {
    version: usize,
    function: &'a Function,
    conditions: Vec<DomainCondition>,
    inputs: [Vec<F::Number>; POINTS],
    nodes: [Vec<F::Number>; POINTS],
}

/// The conditions of a version (0 before, 1 after) that do not follow from
/// those of the other one, at most one for each output.
pub(super) fn open<F: Field>(
    pairs: &Pairs<'_>,
    version: usize,
    states: &States,
    seed: u64,
) -> Vec<OpenCondition> {
    let functions = [pairs.before.function, pairs.after.function];
    if conditions(functions[version]).is_empty() {
        return Vec::new();
    }
    let prime = pairs.primes(seed)[0];
    let fields: [F; POINTS] = array::from_fn(|point| {
        let seed = nth_seed(seed, point as u32);
        F::at(prime, FieldPoint { seed })
    });
    let points = fields.each_ref().map(|field| pairs.point(field));
    let side = |version: usize| VersionValues {
        version,
        function: functions[version],
        conditions: conditions(functions[version]),
        inputs: points.each_ref().map(|point| point[version].clone()),
        nodes: array::from_fn(|point| {
            evaluate_nodes(functions[version], &fields[point], &points[point][version])
        }),
    };
    let view = [pairs.before, pairs.after][version];
    let matching = ConditionMatching {
        pairs,
        states,
        ranges: ranges(view, states),
        own: side(version),
        other: side(1 - version),
        field: &fields[0],
        numbers: [OnceCell::new(), OnceCell::new()],
    };
    matching.open()
}

/// The conditions of all nodes on which outputs depend, each once.
fn conditions(function: &Function) -> Vec<DomainCondition> {
    let live = live(function);
    let mut found: Vec<DomainCondition> = function
        .values()
        .filter(|(value, _)| live[value.index()])
        .filter_map(|(_, node)| DomainCondition::of(node.operation, node.operands))
        .filter(|condition| {
            let number = function.number(condition.operand);
            number.is_none_or(|number| !condition.requirement.holds_for(number))
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// The ranges of all nodes; inputs lie within the ranges of the scene.
fn ranges(view: View<'_>, states: &States) -> Vec<Range> {
    let function = view.function;
    let mut inputs = Vec::with_capacity(function.input_len());
    for array in function.inputs() {
        let name = view.tables.symbols.text(array.name);
        for offset in 0..array.shape.len() as u32 {
            let (indices, _) = array.shape.indices(offset);
            let range = states.ranges().get(name, indices);
            inputs.push(range.map_or(Range::ALL, |[low, high]| Range::between(low, high)));
        }
    }
    let mut ranges: Vec<Range> = Vec::with_capacity(function.nodes().len());
    for node in function.nodes() {
        let operands = node.operands.map(|operand| match operand.kind() {
            OperandKind::Value(value) => ranges[value.index()],
            OperandKind::Input(input) => inputs[input.index()],
            OperandKind::Constant(constant) => {
                let number = function.constant_number(constant);
                if number.is_nan() {
                    Range::ALL
                } else {
                    Range::between(number, number)
                }
            }
            OperandKind::None => Range::ALL,
        });
        let [a, b, _] = node.operands;
        ranges.push(Range::of(node.operation, operands, a == b));
    }
    ranges
}

impl DomainRequirement {
    fn holds_for(self, number: f64) -> bool {
        match self {
            DomainRequirement::Nonzero => number != 0.0,
            DomainRequirement::NotNegative => number >= 0.0,
        }
    }

    fn holds_within(self, range: Range) -> bool {
        match self {
            DomainRequirement::Nonzero => range.nonzero,
            DomainRequirement::NotNegative => range.low >= 0.0,
        }
    }
}

impl OpenCondition {
    /// The condition, for users.
    pub(super) fn text(self, view: View<'_>) -> String {
        let DomainCondition {
            requirement,
            operand,
        } = self.condition;
        let what = match requirement {
            DomainRequirement::Nonzero => "not zero",
            DomainRequirement::NotNegative => "not negative",
        };
        format!("{} is {what}", print_operand(view, operand))
    }
}

impl DomainCondition {
    /// The condition that an operation sets.
    pub(super) fn of(operation: Operation, [a, b, _]: [Operand; 3]) -> Option<DomainCondition> {
        let (requirement, operand) = match operation {
            Operation::Div => (DomainRequirement::Nonzero, b),
            Operation::Sqrt => (DomainRequirement::NotNegative, a),
            _ => return None,
        };
        Some(DomainCondition {
            requirement,
            operand,
        })
    }

    /// The conditions on the operands of a node that follow from this one on
    /// the node.
    fn implied(self, function: &Function) -> Vec<DomainCondition> {
        let Some(value) = self.operand.value() else {
            return Vec::new();
        };
        let node = function.node(value);
        let [a, b, _] = node.operands;
        let operands: &[Operand] = match (self.requirement, node.operation) {
            (DomainRequirement::Nonzero, Operation::Mul) => &[a, b],
            (DomainRequirement::Nonzero, Operation::Neg | Operation::Div | Operation::Sqrt)
            | (_, Operation::Copy) => &[a],
            _ => &[],
        };
        self.on(operands)
    }

    /// Conditions on the operands of a node that imply this one.
    fn sufficient(self, function: &Function) -> Vec<DomainCondition> {
        let Some(value) = self.operand.value() else {
            return Vec::new();
        };
        let node = function.node(value);
        let [a, b, _] = node.operands;
        match (self.requirement, node.operation) {
            (DomainRequirement::NotNegative, Operation::Add | Operation::Mul | Operation::Div) => {
                self.on(&[a, b])
            }
            _ => self.implied(function),
        }
    }

    fn on(self, operands: &[Operand]) -> Vec<DomainCondition> {
        let on = |&operand| DomainCondition { operand, ..self };
        operands.iter().map(on).collect()
    }
}

impl<F: Field> VersionValues<'_, F> {
    /// The numbers of a value or input at the points.
    fn numbers(&self, operand: Operand) -> Option<[F::Number; POINTS]> {
        let of = |numbers: &[Vec<F::Number>; POINTS], index: usize| {
            Some(array::from_fn(|point| numbers[point][index]))
        };
        match operand.kind() {
            OperandKind::Value(value) => of(&self.nodes, value.index()),
            OperandKind::Input(input) => of(&self.inputs, input.index()),
            OperandKind::Constant(_) | OperandKind::None => None,
        }
    }

    /// The key of an operand; `None` for one without a value, or one that
    /// vanishes by accident.
    fn key(&self, operand: Operand, field: &F) -> Option<ValueKey> {
        if let Some(number) = self.function.number(operand) {
            return (number == 0.0).then_some(ZERO);
        }
        let numbers = self.numbers(operand)?;
        if numbers.iter().all(|&number| F::value(number) == 0) {
            return Some(ZERO);
        }
        let vanishes = |&number: &F::Number| F::is_undefined(number) || F::value(number) == 0;
        if numbers.iter().any(vanishes) {
            return None;
        }
        Some(array::from_fn(|point| {
            F::value(field.div(numbers[point + 1], numbers[0]))
        }))
    }
}

/// The conditions of one version, searched among those of the other.
struct ConditionMatching<'a, F: Field> {
    pairs: &'a Pairs<'a>,
    states: &'a States,
    own: VersionValues<'a, F>,
    other: VersionValues<'a, F>,
    /// The ranges of the nodes of the own version.
    ranges: Vec<Range>,
    field: &'a F,
    /// The nodes of both versions at some states, once they are needed.
    numbers: [OnceCell<Vec<[Vec<Double>; 2]>>; 2],
}

/// The conditions of the other version and their consequences.
#[derive(Default)]
struct KnownConditions {
    classes: FxHashMap<(DomainRequirement, ValueKey), (ConditionClass, Operand)>,
    /// For every condition of the other version the classes that it implies.
    implied: Vec<Vec<ConditionClass>>,
}

impl<F: Field> ConditionMatching<'_, F> {
    fn open(&self) -> Vec<OpenCondition> {
        let known = self.known();
        // What follows from no class of the other version gets its own.
        let mut count = known.classes.len() as ConditionClass;
        let mut needed: Vec<Vec<ConditionClass>> = Vec::with_capacity(self.own.conditions.len());
        for &condition in &self.own.conditions {
            needed.push(self.needed(condition, &known).unwrap_or_else(|| {
                count += 1;
                vec![count - 1]
            }));
        }
        let mut used: Vec<ConditionClass> = needed.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let nodes = self.own.function.nodes().len() + self.other.function.nodes().len();
        if used.len().div_ceil(64) * nodes > WORK {
            return vec![OpenCondition {
                pair: 0,
                condition: self.own.conditions[0],
            }];
        }
        let mut open = vec![None; self.pairs.list.len()];
        for block in used.chunks(64) {
            let own = self.own.dependence(self.pairs, block, &needed);
            let other = self.other.dependence(self.pairs, block, &known.implied);
            for (pair, (own, other)) in own.into_iter().zip(other).enumerate() {
                let missing = own & !other;
                if missing != 0 && open[pair].is_none() {
                    let class = block[missing.trailing_zeros() as usize];
                    let place = needed.iter().position(|needed| needed.contains(&class));
                    open[pair] = place.map(|place| self.own.conditions[place]);
                }
            }
        }
        let open = open.into_iter().enumerate();
        open.filter_map(|(pair, condition)| {
            condition.map(|condition| OpenCondition { pair, condition })
        })
        .collect()
    }

    /// The classes of the other version.
    fn known(&self) -> KnownConditions {
        let mut known = KnownConditions::default();
        for &condition in &self.other.conditions {
            let mut parts = vec![condition];
            let mut next = 0;
            while next < parts.len().min(MAX_PARTS) {
                let implied = parts[next].implied(self.other.function);
                parts.extend(
                    implied
                        .into_iter()
                        .filter(|part| !parts.contains(part))
                        .collect::<Vec<_>>(),
                );
                next += 1;
            }
            let mut classes: Vec<ConditionClass> = Vec::new();
            for part in parts {
                if let Some(key) = self.other.key(part.operand, self.field) {
                    let count = known.classes.len() as ConditionClass;
                    let entry = known.classes.entry((part.requirement, key));
                    let (class, operand) = *entry.or_insert((count, part.operand));
                    // The second of two that differ in sign is not kept.
                    if part.requirement == DomainRequirement::Nonzero
                        || self.has_sign([self.other.version; 2], [part.operand, operand])
                    {
                        classes.push(class);
                    }
                }
            }
            known.implied.push(classes);
        }
        known
    }

    /// The classes of the other version from which a condition follows; `None`
    /// where no such classes are found.
    fn needed(
        &self,
        condition: DomainCondition,
        known: &KnownConditions,
    ) -> Option<Vec<ConditionClass>> {
        let function = self.own.function;
        let (mut classes, mut parts) = (Vec::new(), vec![condition]);
        let mut next = 0;
        while let Some(&part) = parts.get(next) {
            next += 1;
            let DomainCondition {
                requirement,
                operand,
            } = part;
            let holds = match operand.kind() {
                OperandKind::Value(value) => requirement.holds_within(self.ranges[value.index()]),
                OperandKind::Constant(constant) => {
                    requirement.holds_for(function.constant_number(constant))
                }
                OperandKind::Input(_) | OperandKind::None => false,
            };
            let key = self.own.key(operand, self.field);
            if holds || requirement == DomainRequirement::NotNegative && key == Some(ZERO) {
                continue;
            }
            let found = key.and_then(|key| known.classes.get(&(requirement, key)));
            let versions = [self.own.version, self.other.version];
            match found {
                Some(&(class, other))
                    if requirement == DomainRequirement::Nonzero
                        || self.has_sign(versions, [operand, other]) =>
                {
                    classes.push(class);
                }
                _ => {
                    let more = part.sufficient(function);
                    if more.is_empty() || parts.len() > MAX_PARTS {
                        return None;
                    }
                    parts.extend(
                        more.into_iter()
                            .filter(|part| !parts.contains(part))
                            .collect::<Vec<_>>(),
                    );
                }
            }
        }
        Some(classes)
    }

    /// True when two operands that differ by a constant factor have one sign.
    fn has_sign(&self, versions: [usize; 2], operands: [Operand; 2]) -> bool {
        // Equal values have one, also where no state gives them a number.
        let [a, b] = [0, 1].map(|side| {
            let sides = [&self.own, &self.other];
            let side_of = sides.into_iter().find(|own| own.version == versions[side]);
            side_of.and_then(|own| own.numbers(operands[side]))
        });
        if a.is_some() && a == b {
            return true;
        }
        let signs = (0..SIGNS as usize).map(|state| {
            let [a, b] = [0, 1].map(|side| self.number(versions[side], state, operands[side]));
            if a.is_finite() && b.is_finite() {
                a.signum() * b.signum() * f64::from(a != 0.0 && b != 0.0)
            } else {
                0.0
            }
        });
        let signs: Vec<f64> = signs.filter(|&sign| sign != 0.0).collect();
        !signs.is_empty() && signs.iter().all(|&sign| sign > 0.0)
    }

    /// The number of an operand of a version at a state.
    fn number(&self, version: usize, state: usize, operand: Operand) -> f64 {
        let functions = [self.pairs.before.function, self.pairs.after.function];
        let states = self.numbers[version].get_or_init(|| {
            let at = |state| {
                let inputs = self.pairs.state(self.states, state)[version].clone();
                let inputs: Vec<Double> = inputs.into_iter().map(Double::from).collect();
                let nodes = evaluate_nodes(functions[version], &DoubleDouble, &inputs);
                [inputs, nodes]
            };
            (0..SIGNS).map(at).collect()
        });
        let [inputs, nodes] = &states[state];
        match operand.kind() {
            OperandKind::Value(value) => nodes[value.index()].high,
            OperandKind::Input(input) => inputs[input.index()].high,
            OperandKind::Constant(constant) => functions[version].constant_number(constant),
            OperandKind::None => f64::NAN,
        }
    }
}

impl<F: Field> VersionValues<'_, F> {
    /// For every pair of outputs the classes of a block, as bits, on which it
    /// depends; `classes` are those of every condition.
    fn dependence(
        &self,
        pairs: &Pairs<'_>,
        block: &[ConditionClass],
        classes: &[Vec<ConditionClass>],
    ) -> Vec<u64> {
        let bits: Vec<u64> = classes
            .iter()
            .map(|classes| {
                let places = classes
                    .iter()
                    .filter_map(|class| block.binary_search(class).ok());
                places.fold(0, |bits, place| bits | 1 << place)
            })
            .collect();
        let mut reached: Vec<u64> = Vec::with_capacity(self.function.nodes().len());
        for node in self.function.nodes() {
            let condition = DomainCondition::of(node.operation, node.operands);
            let place =
                condition.and_then(|condition| self.conditions.binary_search(&condition).ok());
            let own = place.map_or(0, |place| bits[place]);
            reached.push(
                node.values()
                    .fold(own, |bits, value| bits | reached[value.index()]),
            );
        }
        let output = |place: usize| {
            let operand = self.function.assignments[place].operand;
            operand.entry_or_default(&reached)
        };
        let pairs = pairs.list.iter();
        pairs
            .map(|pair| output([pair.before, pair.after][self.version]))
            .collect()
    }
}
