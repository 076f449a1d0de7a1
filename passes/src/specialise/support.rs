//! Exact support: the inputs that outputs depend on as functions.
//!
//! An input that is read need not count: `x*y - y*x + z` depends on `z` alone.
//! Every input is drawn anew while all others keep their values, at two points
//! of two prime fields: an output that depends on it stays the same with a
//! probability below its degree over 2^60 (Schwartz and Zippel). The semantic
//! check of the pass proves the result again, at other points.

use super::slice::read_inputs;
use robovec_framework::scene::Scene;
use robovec_ir::diagnostic::counted;
use robovec_ir::evaluate::evaluate;
use robovec_ir::print::print_operand;
use robovec_ir::{Function, Input, Operation, View};
use robovec_num::batch::Batch;
use robovec_num::field::{Field, FieldPoint, Prime, PrimeField, RootField};
use robovec_num::random::mix;
use std::array;

/// Maximum number of operations evaluated, a second of work.
const WORK: usize = 1 << 26;
/// Maximum number of inputs named in a remark.
const NAMED: usize = 6;
/// Selects points and primes; the semantic check draws others.
const SEED: u64 = 0x5099;
/// Fields evaluated at a time: two points in both fields.
const LANES: usize = 4;

/// The remark where inputs were not tested.
pub(super) const TOO_LARGE: &str =
    "too large to test which inputs the outputs depend on: only the scene binds inputs";

/// The inputs without influence, for users.
pub(super) fn remark(view: View<'_>, idle: &[(usize, f64)]) -> Option<String> {
    let name = |&(place, _): &(usize, f64)| print_operand(view, Input(place as u32).into());
    let names: Vec<String> = idle.iter().take(NAMED).map(name).collect();
    let more = match idle.len() - names.len() {
        0 => String::new(),
        more => format!(" and {}", counted(more, "more input")),
    };
    let names = names.join(", ");
    (!idle.is_empty()).then(|| format!("no output depends on {names}{more}, which become numbers"))
}

/// Inputs without influence on the outputs, by their places, each with a
/// number at which the outputs are defined; `None` for a function too large to
/// be tested.
pub(super) fn without_influence(
    view: View<'_>,
    bound: &[Option<f64>],
    scene: &Scene,
) -> Option<Vec<(usize, f64)>> {
    let function = view.function;
    let inputs = tested(view, bound);
    if inputs.len().saturating_mul(function.nodes().len()) > WORK {
        return None;
    }
    let numbers = inputs.iter().map(|&input| inside(view, input, scene));
    let numbers = numbers.collect();
    Some(if takes_roots(function) {
        // A root of a square has a sign, which the range decides.
        SupportTest::<RootField>::new(function, bound).idle(&inputs, &[numbers])
    } else {
        let numbers = [vec![0.0; inputs.len()], numbers];
        SupportTest::<PrimeField>::new(function, bound).idle(&inputs, &numbers)
    })
}

/// For every assignment the input elements that its value depends on, by their
/// places; `None` for a function too large to be tested.
pub fn dependences(view: View<'_>) -> Option<Vec<Vec<usize>>> {
    let function = view.function;
    let bound = vec![None; function.input_len()];
    let inputs = tested(view, &bound);
    if inputs.len().saturating_mul(function.nodes().len()) > WORK {
        return None;
    }
    Some(if takes_roots(function) {
        SupportTest::<RootField>::new(function, &bound).dependences(&inputs)
    } else {
        SupportTest::<PrimeField>::new(function, &bound).dependences(&inputs)
    })
}

fn takes_roots(function: &Function) -> bool {
    let mut nodes = function.nodes().iter();
    nodes.any(|node| node.operation == Operation::Sqrt)
}

/// Inputs that are read, not bound and not given by a user's function.
fn tested(view: View<'_>, bound: &[Option<f64>]) -> Vec<usize> {
    let function = view.function;
    let is_read = read_inputs(function);
    let is_result = |place: usize| {
        let (array, ..) = function.input_element(Input(place as u32));
        let name = view.tables.symbols.text(array.name);
        let mut calls = function.boundaries.iter();
        calls.any(|call| call.result.as_deref() == Some(name))
    };
    (0..function.input_len())
        .filter(|&place| is_read[place] && bound[place].is_none() && !is_result(place))
        .collect()
}

/// Zero if the range of an input contains it, else the middle of the range.
fn inside(view: View<'_>, place: usize, scene: &Scene) -> f64 {
    let (array, indices, _) = view.function.input_element(Input(place as u32));
    let range = (scene.ranges).get(view.tables.symbols.text(array.name), indices);
    match range {
        Some([low, high]) if low > 0.0 || high < 0.0 => low.midpoint(high),
        _ => 0.0,
    }
}

/// A function at points of two fields.
struct SupportTest<'a, F: Field> {
    function: &'a Function,
    fields: Batch<F, LANES>,
    inputs: Vec<[F::Number; LANES]>,
    outputs: Vec<[F::Number; LANES]>,
}

impl<'a, F: Field> SupportTest<'a, F> {
    fn new(function: &'a Function, bound: &[Option<f64>]) -> SupportTest<'a, F> {
        let primes = Prime::pair(SEED);
        let fields: [F; LANES] = array::from_fn(|lane| {
            let seed = mix(SEED + (lane / 2) as u64);
            F::at(primes[lane % 2], FieldPoint { seed })
        });
        let points = fields.each_ref().map(|field| {
            let points = field.point(function.input_len()).into_iter().zip(bound);
            let point = points.map(|(point, bound)| bound.map_or(point, |one| field.literal(one)));
            point.collect()
        });
        let fields = Batch(fields);
        let inputs = Batch::<F, LANES>::gather(&points);
        SupportTest {
            function,
            outputs: evaluate(function, &fields, &inputs),
            fields,
            inputs,
        }
    }

    /// For every assignment whether its value is undefined or another than at
    /// the first inputs.
    fn changes(&self, inputs: &[[F::Number; LANES]]) -> Vec<bool> {
        let outputs = evaluate(self.function, &self.fields, inputs);
        let pairs = outputs.iter().zip(&self.outputs);
        let is_other = |(one, other): (&[F::Number; LANES], &[F::Number; LANES])| {
            one != other || one.iter().any(|&lane| F::is_undefined(lane))
        };
        pairs.map(is_other).collect()
    }

    /// The same with one input drawn anew.
    fn changes_with(&self, place: usize) -> Vec<bool> {
        let index = (self.inputs.len() + place) as u64;
        let mut inputs = self.inputs.clone();
        inputs[place] = self.fields.0.each_ref().map(|field| field.input(index));
        self.changes(&inputs)
    }

    fn dependences(&self, tested: &[usize]) -> Vec<Vec<usize>> {
        let mut found = vec![Vec::new(); self.outputs.len()];
        for &place in tested {
            for (inputs, changes) in found.iter_mut().zip(self.changes_with(place)) {
                if changes {
                    inputs.push(place);
                }
            }
        }
        found
    }

    /// The inputs that can be changed without a change of an output, with the
    /// first of several lists of numbers that can take their place together.
    fn idle(&self, tested: &[usize], numbers: &[Vec<f64>]) -> Vec<(usize, f64)> {
        let fields = &self.fields.0;
        let is_same = |changes: Vec<bool>| !changes.contains(&true);
        let idle: Vec<bool> = tested
            .iter()
            .map(|&place| is_same(self.changes_with(place)))
            .collect();
        let with = |numbers: &Vec<f64>| {
            let all = tested.iter().zip(&idle).zip(numbers);
            let idle = all.filter(|((_, idle), _)| **idle);
            let numbers: Vec<(usize, f64)> = idle.map(|((&place, _), &one)| (place, one)).collect();
            let mut inputs = self.inputs.clone();
            for &(place, number) in &numbers {
                inputs[place] = fields.each_ref().map(|field| field.literal(number));
            }
            is_same(self.changes(&inputs)).then_some(numbers)
        };
        numbers.iter().find_map(with).unwrap_or_default()
    }
}
