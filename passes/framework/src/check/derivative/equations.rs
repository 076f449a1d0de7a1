//! Equations between a function and a program for its derivative.

use super::super::pairing::{Unpaired, by_output};
use crate::differentiation::{DerivativeArrays, DerivativeResult};
use robovec_ir::print::print_output;
use robovec_ir::{Output, View};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::dual::Dual;

/// The number that a term of an equation is multiplied by.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Factor {
    One,
    /// An element of the direction, by its column.
    Direction(usize),
    /// A weight, by its row.
    Weight(usize),
}

/// Equation between derivatives before and outputs after.
pub(super) struct DerivativeEquation {
    /// True if it is about the values before, and not their derivatives.
    pub(super) is_value: bool,
    /// Assignments before, with their factors.
    pub(super) before: Vec<(Factor, usize)>,
    /// Assignments after, with their factors.
    pub(super) after: Vec<(Factor, usize)>,
    /// The output element after that represents the equation.
    pub(super) element: u32,
    /// For every column the next output element of the same equation, if there
    /// is one.
    pub(super) elements: Vec<u32>,
    /// Outputs whose sizes belong together.
    pub(super) array: usize,
}

/// Point at which a derivative is evaluated.
pub(super) struct DerivativePoint<N> {
    pub(super) inputs: Vec<N>,
    pub(super) direction: Vec<N>,
    pub(super) weights: Vec<N>,
}

impl DerivativeEquation {
    /// Both sides at a sample.
    pub(super) fn sides<A: Arithmetic>(
        &self,
        arithmetic: &A,
        before: &[Dual<A::Number>],
        after: &[A::Number],
        sample: &DerivativePoint<A::Number>,
    ) -> [A::Number; 2] {
        let terms = self.after.iter();
        let terms = terms.map(|&(factor, place)| sample.term(arithmetic, factor, after[place]));
        let right = sum(arithmetic, terms);
        [self.left(arithmetic, before, sample), right]
    }

    /// The side before: values, or their derivatives.
    pub(super) fn left<A: Arithmetic>(
        &self,
        arithmetic: &A,
        before: &[Dual<A::Number>],
        sample: &DerivativePoint<A::Number>,
    ) -> A::Number {
        let terms = self.before.iter().filter_map(|&(factor, place)| {
            let dual = before[place];
            let number = if self.is_value {
                Some(dual.value)
            } else {
                dual.slope
            };
            Some(sample.term(arithmetic, factor, number?))
        });
        sum(arithmetic, terms)
    }
}

impl<N: Copy> DerivativePoint<N> {
    fn term<A: Arithmetic<Number = N>>(&self, arithmetic: &A, factor: Factor, number: N) -> N {
        match factor {
            Factor::One => number,
            Factor::Direction(column) => arithmetic.mul(self.direction[column], number),
            Factor::Weight(row) => arithmetic.mul(self.weights[row], number),
        }
    }
}

fn sum<A: Arithmetic>(arithmetic: &A, terms: impl Iterator<Item = A::Number>) -> A::Number {
    let sum = terms.reduce(|sum, next| arithmetic.add(sum, next));
    sum.unwrap_or_else(|| arithmetic.literal(0.0))
}

/// Equations between the assignments of both.
pub(super) fn equations(
    before: View<'_>,
    after: View<'_>,
    result: DerivativeResult,
    arrays: &DerivativeArrays,
) -> Result<Vec<DerivativeEquation>, Unpaired> {
    let sides = (by_output(before)?, by_output(after)?);
    let mut equations = kept_equations(before, arrays, (&sides.0, &sides.1))?;
    equations.extend(derivative_equations(before, result, arrays, sides));
    Ok(equations)
}

/// The place of an assignment, times a factor.
fn at(factor: Factor, set: Option<usize>) -> Option<(Factor, usize)> {
    set.map(|place| (factor, place))
}

/// Equations of the outputs that the function had before.
fn kept_equations(
    before: View<'_>,
    arrays: &DerivativeArrays,
    (old, new): (&[Option<usize>], &[Option<usize>]),
) -> Result<Vec<DerivativeEquation>, Unpaired> {
    let mut equations = Vec::new();
    let kept = arrays.kept.iter().flat_map(|array| {
        let first = array.offset as usize;
        first..first + array.shape.len()
    });
    for (element, output) in kept.enumerate() {
        if old[output].is_some() != new[element].is_some() {
            return Err(Unpaired {
                output: Some(Output(element as u32)),
                reason: format!(
                    "{} is set on one side only",
                    print_output(before, Output(output as u32))
                ),
            });
        }
        equations.push(DerivativeEquation {
            is_value: true,
            before: at(Factor::One, old[output]).into_iter().collect(),
            after: at(Factor::One, new[element]).into_iter().collect(),
            element: element as u32,
            elements: Vec::new(),
            array: before.function.output_array(Output(output as u32)),
        });
    }
    Ok(equations)
}

fn derivative_equations(
    before: View<'_>,
    result: DerivativeResult,
    arrays: &DerivativeArrays,
    (old, new): (Vec<Option<usize>>, Vec<Option<usize>>),
) -> Vec<DerivativeEquation> {
    let array = |output: u32| before.function.output_array(Output(output));
    let mut equations = Vec::new();
    let first = arrays.kept_len();
    let rows = arrays.rows();
    let along = |places: &[u32]| -> Vec<(Factor, usize)> {
        let places = places.iter().enumerate();
        places
            .filter_map(|(column, &place)| at(Factor::Direction(column), new[place as usize]))
            .collect()
    };
    match result {
        DerivativeResult::Jacobian => {
            for (&row, places) in rows.iter().zip(arrays.jacobian()) {
                let elements: Vec<u32> = places.collect();
                equations.push(DerivativeEquation {
                    is_value: false,
                    before: at(Factor::One, old[row as usize]).into_iter().collect(),
                    after: along(&elements),
                    element: elements[0],
                    elements,
                    array: array(row),
                });
            }
        }
        DerivativeResult::Direction => {
            for (place, &row) in rows.iter().enumerate() {
                let element = (first + place) as u32;
                equations.push(DerivativeEquation {
                    is_value: false,
                    before: at(Factor::One, old[row as usize]).into_iter().collect(),
                    after: at(Factor::One, new[element as usize]).into_iter().collect(),
                    element,
                    elements: Vec::new(),
                    array: array(row),
                });
            }
        }
        DerivativeResult::Gradient => {
            let columns = arrays.columns().len() as u32;
            let elements: Vec<u32> = (first as u32..first as u32 + columns).collect();
            let weighted = rows.iter().enumerate();
            equations.push(DerivativeEquation {
                is_value: false,
                before: weighted
                    .filter_map(|(row, &output)| at(Factor::Weight(row), old[output as usize]))
                    .collect(),
                after: along(&elements),
                element: elements[0],
                elements,
                array: array(rows[0]),
            });
        }
    }
    equations
}
