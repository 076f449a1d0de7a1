//! The allowed errors of outputs: those of a scene, or one bound.
//!
//! An error that is allowed relative to an array's largest element would have
//! to vanish where the whole array does, while rounding errors do not: the
//! torque of gravity is zero in a pendulum that hangs, the numbers that cancel
//! to zero there are not. Such an error is therefore allowed relative to the
//! largest element *or of the array's usual size*, whichever is larger, and an
//! error relative to the element itself relative to at least a thousandth of
//! the element's usual size.

use super::{Measure, OutputTolerance, Scene};
use robovec_ir::evaluate::evaluate_nodes;
use robovec_ir::print::print_output;
use robovec_ir::states::States;
use robovec_ir::{Function, Operand, OperandKind, Output, View};
use robovec_num::arithmetic::Binary64;
use std::collections::BTreeMap;

/// Number of states from which usual sizes are computed. An odd number has a
/// median.
const SIZED: u32 = 255;

/// The seed of these states: every part of the program takes the same sizes.
const SIZE_SEED: u64 = 1;

/// The part of the cancelling numbers in an array below which it counts as
/// zero: the rest after cancellation in binary64, with a margin of a few
/// digits.
const CANCELLED: f64 = 1.0 / (1u64 << 44) as f64;

/// The part of its usual size below which an element counts as passing through
/// zero, where a relative error has no meaning.
const PASSING_ZERO: f64 = 1e-3;

/// The usual size of every output array: the median of its largest element at
/// random states, of those elements that are needed. An array that is always
/// zero (`a*b - b*a`) has the size of its cancelling numbers.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct ArraySizes {
    sizes: BTreeMap<String, f64>,
    /// The same of elements whose errors are measured by themselves.
    elements: BTreeMap<String, f64>,
}

impl ArraySizes {
    /// The sizes at the states of a scene, of the outputs that it needs;
    /// without one at states with physical scales.
    pub fn of(view: View<'_>, scene: Option<&Scene>) -> ArraySizes {
        let states = match scene {
            Some(scene) => scene.states(SIZE_SEED),
            None => States::new(SIZE_SEED),
        };
        let function = view.function;
        let arrays = arrays(function);
        let needed = function.assignments.iter().zip(&arrays);
        let needed: Vec<(Operand, usize)> = needed
            .filter(|(one, _)| scene.is_none_or(|scene| scene.needs(view, one.output)))
            .map(|(one, &array)| (one.operand, array))
            .collect();
        let count = function.outputs().len();
        let elements = elements_alone(view, scene);
        let mut single = vec![Vec::new(); elements.len()];
        let (mut largest, mut cancelling) = (vec![Vec::new(); count], vec![Vec::new(); count]);
        for number in 0..SIZED {
            let inputs = states.draw(view, number);
            let values = evaluate_nodes(function, &Binary64, &inputs);
            let read = |operand: Operand| match operand.kind() {
                OperandKind::Value(value) => values[value.index()],
                OperandKind::Input(input) => inputs[input.index()],
                OperandKind::Constant(constant) => function.constant_number(constant),
                OperandKind::None => 0.0,
            };
            for (sizes, (_, operand)) in single.iter_mut().zip(&elements) {
                sizes.push(read(*operand).abs());
            }
            let results = needed
                .iter()
                .map(|&(operand, array)| (read(operand), array));
            let terms = needed.iter().flat_map(|&(operand, array)| {
                let operands = match operand.kind() {
                    OperandKind::Value(value) => function.nodes()[value.index()].operands(),
                    _ => &[],
                };
                operands.iter().map(move |&term| (read(term), array))
            });
            for (sizes, norm) in largest.iter_mut().zip(norms(results, count)) {
                sizes.push(norm);
            }
            for (sizes, norm) in cancelling.iter_mut().zip(norms(terms, count)) {
                sizes.push(norm);
            }
        }
        let sizes = largest.into_iter().zip(cancelling).map(|(sizes, terms)| {
            let (size, terms) = (median(sizes), median(terms));
            if size <= terms * CANCELLED {
                terms
            } else {
                size
            }
        });
        let names = function.outputs().iter();
        let names = names.map(|array| view.tables.symbols.text(array.name).to_owned());
        ArraySizes {
            sizes: names.zip(sizes).collect(),
            elements: elements
                .into_iter()
                .map(|(name, _)| name)
                .zip(single.into_iter().map(median))
                .collect(),
        }
    }

    /// Least size by which the relative error of an output is measured, by its
    /// name (`qdd[3]`), in its unit.
    pub fn least(&self, output: &str) -> f64 {
        self.elements
            .get(output)
            .map_or(0.0, |size| size * PASSING_ZERO)
    }

    /// The size of an array, in the unit of its elements; 0 for one that is
    /// not known.
    pub fn get(&self, array: &str) -> f64 {
        // What a program computes beside the function it came from has no size
        // of its own, and its errors are measured by what it is.
        self.sizes.get(array).copied().unwrap_or(0.0)
    }
}

/// The output array of every assignment, as its place among the outputs.
fn arrays(function: &Function) -> Vec<usize> {
    let assignments = function.assignments.iter();
    assignments
        .map(|one| function.output_array(one.output))
        .collect()
}

/// The outputs, by name, that a scene allows an error relative to themselves.
fn elements_alone(view: View<'_>, scene: Option<&Scene>) -> Vec<(String, Operand)> {
    let Some(scene) = scene else {
        return Vec::new();
    };
    let is_relative = |output: Output| {
        let tolerances = scene.tolerances(view, output).into_iter();
        let mut relative = tolerances.filter(|one| one.measure == Measure::Relative);
        relative.next().is_some()
    };
    let assignments = view.function.assignments.iter();
    let alone = assignments.filter(|one| is_relative(one.output));
    alone
        .map(|one| (print_output(view, one.output), one.operand))
        .collect()
}

fn median(mut sizes: Vec<f64>) -> f64 {
    sizes.sort_unstable_by(f64::total_cmp);
    sizes[sizes.len() / 2]
}

/// The largest element of every array, of values with their arrays.
fn norms(rows: impl Iterator<Item = (f64, usize)>, count: usize) -> Vec<f64> {
    let mut norms = vec![0.0f64; count];
    for (value, array) in rows.filter(|(value, _)| value.is_finite()) {
        norms[array] = norms[array].max(value.abs());
    }
    norms
}

/// The allowed errors of outputs.
#[derive(Clone, Debug)]
pub struct Allowed {
    /// By assignment: measures, bounds and the sizes the errors are measured
    /// by at least; all of them hold.
    bounds: Vec<Vec<(Measure, f64, f64)>>,
    /// The output array of every assignment, and the number of arrays.
    arrays: Vec<usize>,
    count: usize,
}

impl Allowed {
    /// The allowed errors: those of a scene, and for all other outputs this
    /// part of the largest element of the array. `sizes` are those of the
    /// arrays.
    pub fn new(view: View<'_>, scene: Option<&Scene>, error: f64, sizes: &ArraySizes) -> Allowed {
        let usual = |tolerance: &OutputTolerance, output: Output| {
            let (array, _, _) = view.function.output_element(output);
            let name = view.tables.symbols.text(array.name);
            let element = || sizes.least(&print_output(view, output));
            let least = match tolerance.measure {
                Measure::Norm => tolerance.scale.unwrap_or_else(|| sizes.get(name)),
                Measure::Relative => tolerance.scale.unwrap_or_else(element),
                Measure::Absolute => 0.0,
            };
            (tolerance.measure, tolerance.bound, least)
        };
        let everywhere = OutputTolerance {
            measure: Measure::Norm,
            bound: error,
            scale: None,
        };
        let assignments = &view.function.assignments;
        let bounds = assignments.iter().map(|assignment| {
            let output = assignment.output;
            let known = scene.map(|scene| scene.tolerances(view, output));
            let known = known.unwrap_or_default();
            if known.is_empty() {
                vec![usual(&everywhere, output)]
            } else {
                known.iter().map(|one| usual(one, output)).collect()
            }
        });
        Allowed {
            bounds: bounds.collect(),
            arrays: arrays(view.function),
            count: view.function.outputs().len(),
        }
    }

    /// The errors allowed of outputs with these values.
    pub fn of(&self, exact: &[f64]) -> Vec<f64> {
        assert_eq!(exact.len(), self.bounds.len(), "one value per output");
        let norms = norms(
            exact.iter().copied().zip(self.arrays.iter().copied()),
            self.count,
        );
        let rows = self.bounds.iter().zip(exact).zip(&self.arrays);
        rows.map(|((bounds, value), &array)| {
            let allowed = bounds.iter().map(|&(measure, bound, least)| match measure {
                Measure::Norm => bound * norms[array].max(least),
                Measure::Relative => bound * value.abs().max(least),
                Measure::Absolute => bound,
            });
            allowed.fold(f64::INFINITY, f64::min)
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::parse;

    /// The usual sizes of the arrays of a function in text form.
    fn sizes(text: &str) -> ArraySizes {
        let module = parse::parse_module("sizes.rvir", text).expect("it is a module");
        let view = module.tables.view(&module.functions[0]);
        ArraySizes::of(view, None)
    }

    #[test]
    fn arrays_that_are_always_zero_have_the_size_of_what_cancels_in_them() {
        let sizes = sizes(
            "// robovec 1\nfunction f equations {\n  in a\n  in b\n  in c\n  out y\n  out z\n  out n\n\
             \x20 y = a*b*c - c*b*a\n  z = a + 3\n  n = 0\n}\n",
        );
        assert!((0.01..1.0).contains(&sizes.get("y")), "{}", sizes.get("y"));
        assert!((2.5..3.5).contains(&sizes.get("z")), "{}", sizes.get("z"));
        assert_eq!(sizes.get("n"), 0.0);
    }
}
