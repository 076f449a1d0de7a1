//! The sizes of the values of a function, and the effect of a rounding of each
//! on the outputs.
//!
//! To first order a rounding `d` of a value moves output `o` by `g(o) d`,
//! where `g(o)` is the derivative of the output with respect to the value
//! (Wilkinson's backward analysis; Linnainmaa, *BIT* 16, 1976, for the sweep
//! that finds all derivatives of one output at once). Functions of
//! multibody systems have thousands of outputs, and only one number is needed
//! per value: the sum over all outputs of `(w(o) g(o))^2`. One sweep finds an
//! unbiased estimate of it for all values together: the outputs are given
//! random signs and the derivative of their signed sum is taken, whose square
//! has this expectation (Hutchinson, *Communications in Statistics* 19, 1990).
//! Every lane of a profile is a state with its own signs.
//!
//! The weight of an output is `1 / sqrt(e m)`, `e` being its expected error and
//! `m` the largest such error in its array: half-way, in logarithms, between
//! weights that improve every output and weights that improve every array by
//! the same factor. Expected errors come from a sweep forward that takes all
//! errors as independent, which is good enough for a scale. So neither a state
//! nor an output with large errors decides alone.
//!
//! A lane with a number that is not finite has no meaning there and counts as
//! zero.

use robovec_analysis::adjoint::{tangent, third};
use robovec_ir::evaluate::evaluate_nodes;
use robovec_ir::states::States;
use robovec_ir::{Function, Node, Operand, OperandKind, Operation, View};
use robovec_num::arithmetic::Binary64;
use robovec_num::batch::Batch;
use robovec_num::random::bits_at;
use std::array;

/// States that are considered together.
pub(crate) const LANES: usize = 8;

/// One number per state.
pub(crate) type StateLanes = [f64; LANES];

/// Sizes and derivatives of the values of a function in a few states.
pub(crate) struct SensitivityProfile {
    /// The inputs, element by element.
    inputs: Vec<StateLanes>,
    /// The values of each node.
    values: Vec<StateLanes>,
    /// The derivative of the weighted outputs, each with a random sign, with
    /// respect to each node.
    adjoints: Vec<StateLanes>,
    /// The same of every assignment itself.
    seeds: Vec<StateLanes>,
}

impl SensitivityProfile {
    /// Evaluates the function in binary64 at states `first..first + LANES`
    /// and sweeps back once, with weights that make every output better by
    /// the same factor.
    pub(crate) fn new(view: View<'_>, states: &States, first: u32) -> SensitivityProfile {
        let function = view.function;
        SensitivityProfile::with_seeds(view, states, first, |profile| profile.balanced(function))
    }

    /// As [`SensitivityProfile::new`], with these weights of every assignment, lane by
    /// lane.
    pub(crate) fn with_seeds(
        view: View<'_>,
        states: &States,
        first: u32,
        weights: impl FnOnce(&SensitivityProfile) -> Vec<StateLanes>,
    ) -> SensitivityProfile {
        let function = view.function;
        let drawn: [Vec<f64>; LANES] =
            array::from_fn(|lane| states.draw(view, first + lane as u32));
        let inputs = Batch::<Binary64, LANES>::gather(&drawn);
        let values = evaluate_nodes(function, &Batch([Binary64; LANES]), &inputs);
        let mut profile = SensitivityProfile {
            inputs,
            values,
            adjoints: Vec::new(),
            seeds: Vec::new(),
        };
        let mut seeds = weights(&profile);
        for (place, seed) in seeds.iter_mut().enumerate() {
            for (lane, weight) in seed.iter_mut().enumerate() {
                let state = u64::from(first) + lane as u64;
                *weight = finite(*weight) * sign((place as u64) << 32 | state);
            }
        }
        profile.seeds = seeds;
        profile.adjoints = profile.sweep(function);
        profile
    }

    /// The values of a node.
    pub(crate) fn value(&self, index: usize) -> &StateLanes {
        &self.values[index]
    }

    /// The values of an operand.
    pub(crate) fn operand(&self, function: &Function, operand: Operand) -> StateLanes {
        match operand.kind() {
            OperandKind::Value(value) => self.values[value.index()],
            OperandKind::Input(input) => self.inputs[input.index()],
            OperandKind::Constant(constant) => [function.constant_number(constant); LANES],
            OperandKind::None => [0.0; LANES],
        }
    }

    /// The signed derivative with respect to a node.
    pub(crate) fn adjoint(&self, index: usize) -> &StateLanes {
        &self.adjoints[index]
    }

    /// The signed weights of an assignment.
    pub(crate) fn seed(&self, assignment: usize) -> &StateLanes {
        &self.seeds[assignment]
    }

    /// The part of the squared error of the outputs that the rounding of a node
    /// adds, in units of the squared roundoff.
    pub(crate) fn blame(&self, index: usize) -> f64 {
        squares(&self.adjoints[index], &self.values[index])
    }

    /// The derivatives of an operation with respect to its operands, lane by
    /// lane; zero where they are not finite.
    pub(crate) fn partials(
        &self,
        function: &Function,
        index: usize,
    ) -> [StateLanes; Operand::MAX_COUNT] {
        let node = &function.nodes()[index];
        let [a, b, _] = node.operands.map(|operand| self.operand(function, operand));
        let result = &self.values[index];
        let all: [[f64; Operand::MAX_COUNT]; LANES] = array::from_fn(|lane| {
            let [first, second] = tangent(node.operation, [a[lane], b[lane], 0.0], result[lane]);
            [first, second, third(node.operation)].map(finite)
        });
        array::from_fn(|side| array::from_fn(|lane| all[lane][side]))
    }

    /// Weights that make every output better by the same factor.
    fn balanced(&self, function: &Function) -> Vec<StateLanes> {
        let outputs = function.outputs();
        let array =
            |assignment: usize| function.output_array(function.assignments[assignment].output);
        let variances = self.variances(function);
        let zero = [0.0; LANES];
        let expected: Vec<&StateLanes> = function
            .assignments
            .iter()
            .map(|assignment| match assignment.operand.value() {
                Some(value) => &variances[value.index()],
                None => &zero,
            })
            .collect();
        let mut largest = vec![[0.0f64; LANES]; outputs.len()];
        let mut counts = vec![0u32; outputs.len()];
        for (assignment, expected) in expected.iter().enumerate() {
            counts[array(assignment)] += 1;
            for (largest, expected) in largest[array(assignment)].iter_mut().zip(*expected) {
                *largest = largest.max(*expected);
            }
        }
        let seed = |(assignment, expected): (usize, &&StateLanes)| -> StateLanes {
            let (largest, count) = (&largest[array(assignment)], counts[array(assignment)]);
            array::from_fn(|lane| {
                let product = expected[lane].sqrt() * largest[lane].sqrt();
                1.0 / (product * f64::from(count)).sqrt()
            })
        };
        expected.iter().enumerate().map(seed).collect()
    }

    /// The squared error to be expected of every node if all errors were
    /// independent, in units of the squared roundoff.
    fn variances(&self, function: &Function) -> Vec<StateLanes> {
        let mut variances: Vec<StateLanes> = Vec::with_capacity(function.nodes().len());
        for (value, node) in function.values() {
            let index = value.index();
            let mut variance = if is_exact(function, node) {
                [0.0; LANES]
            } else {
                self.values[index].map(|number| finite(number * number))
            };
            let partials = self.partials(function, index);
            for (operand, partial) in node.operands().iter().zip(&partials) {
                if let Some(operand) = operand.value() {
                    let part = product(&product(partial, partial), &variances[operand.index()]);
                    add(&mut variance, &part);
                }
            }
            variances.push(variance.map(finite));
        }
        variances
    }

    fn sweep(&self, function: &Function) -> Vec<StateLanes> {
        let mut adjoints = vec![[0.0; LANES]; function.nodes().len()];
        for (assignment, seed) in function.assignments.iter().zip(&self.seeds) {
            if let Some(value) = assignment.operand.value() {
                add(&mut adjoints[value.index()], seed);
            }
        }
        for (value, node) in function.values().rev() {
            let adjoint = adjoints[value.index()];
            if adjoint == [0.0; LANES] {
                continue;
            }
            let partials = self.partials(function, value.index());
            for (operand, partial) in node.operands().iter().zip(&partials) {
                if let Some(operand) = operand.value() {
                    add(&mut adjoints[operand.index()], &product(&adjoint, partial));
                }
            }
        }
        adjoints
    }
}

/// True for operations that never round: a copy, a minus, a product with a
/// power of two.
pub(crate) fn is_exact(function: &Function, node: &Node) -> bool {
    let mut numbers = node
        .operands()
        .iter()
        .filter_map(|&operand| function.number(operand));
    match node.operation {
        Operation::Copy | Operation::Neg => true,
        Operation::Add | Operation::Sub => numbers.any(|number| number == 0.0),
        Operation::Mul => numbers.any(|number| number.to_bits() << 12 == 0),
        _ => false,
    }
}

/// One or minus one, by the upper of a counter's random bits.
fn sign(counter: u64) -> f64 {
    if bits_at(counter) >> 63 == 0 {
        1.0
    } else {
        -1.0
    }
}

/// Zero for infinities and NaN.
fn finite(number: f64) -> f64 {
    if number.is_finite() { number } else { 0.0 }
}

pub(crate) fn add(sum: &mut StateLanes, term: &StateLanes) {
    for (sum, term) in sum.iter_mut().zip(term) {
        *sum += term;
    }
}

/// Multiplies lane by lane; zero where the product is not finite.
pub(crate) fn product(a: &StateLanes, b: &StateLanes) -> StateLanes {
    array::from_fn(|lane| finite(a[lane] * b[lane]))
}

/// The sum over the lanes of the squared products, without those that are not
/// finite.
pub(crate) fn squares(a: &StateLanes, b: &StateLanes) -> f64 {
    let products = a.iter().zip(b).map(|(a, b)| a * b);
    products.map(|product| finite(product * product)).sum()
}
