//! The mass matrix of accelerations that a function computes.
//!
//! Accelerations are `M^-1 (Qq - c)`: one evaluation per joint, each with one
//! force alone, gives the columns of the inverse. The states that show a tree
//! have bodies without mass, at which `M` is singular. Since `M` is linear in
//! masses and inertias, it is the difference of two matrices that are regular:
//! those of the same bodies with usual masses added, and of these alone. All
//! numbers are double-double ones, so that the differences are exact enough for
//! the comparisons of probes.
//!
//! Where loops or constraints bind joints, the accelerations of some follow
//! from those of others, and the columns are not an inverse. Their rank shows
//! this at one state, before the search for a tree.

use super::model::{ModelInputs, SolvedMotion, SystemInput};
use super::probe::ZERO;
use robovec_ir::plan::EvaluationPlan;
use robovec_ir::{Function, Input};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDoubleLanes, DoubleLanes};
use robovec_num::field::{Field, PrimeField};

/// Columns of one evaluation.
const LANES: usize = 8;

/// Shift of a state at which the system is singular with usual masses too, as
/// one of point masses with aligned frames, relative to its usual numbers. The
/// inverse then has elements up to the square of the reciprocal, of which
/// double-double numbers keep twelve digits.
const SHIFT: f64 = 1e-10;

/// Size of an element of the inverse that shows a singular system.
const SINGULAR: f64 = 1e12;

/// Part of the largest element below which one is zero at a shifted state.
const SHIFTED_ZERO: f64 = 1e-8;

/// Evaluates a mass matrix through accelerations.
pub(super) struct SolvedMatrix<'a> {
    model: &'a ModelInputs,
    solved: &'a SolvedMotion,
    plan: EvaluationPlan,
    /// Place among the outputs of the plan, by joint.
    places: Vec<usize>,
    inputs: usize,
    memory: Vec<DoubleLanes<LANES>>,
    /// The inputs of the last matrix of usual masses, and that matrix.
    usual: (Vec<f64>, Option<Vec<Double>>),
}

impl<'a> SolvedMatrix<'a> {
    /// Makes a function ready.
    pub(super) fn new(
        function: &Function,
        model: &'a ModelInputs,
        solved: &'a SolvedMotion,
    ) -> SolvedMatrix<'a> {
        let mut wanted: Vec<usize> = solved.places.iter().copied().flatten().collect();
        wanted.sort_unstable();
        let place = |place: &Option<usize>| {
            let place = place.expect("every joint has an acceleration");
            wanted.partition_point(|&other| other < place)
        };
        SolvedMatrix {
            model,
            solved,
            places: solved.places.iter().map(place).collect(),
            plan: EvaluationPlan::of(function, |place| wanted.binary_search(&place).is_ok()),
            inputs: function.input_len(),
            memory: Vec::new(),
            usual: (Vec::new(), None),
        }
    }

    /// Operations of one matrix.
    pub(super) fn work(&self) -> usize {
        2 * self.plan.len() * self.model.len().next_multiple_of(LANES)
    }

    /// Tests whether some accelerations follow from others: the rank of their
    /// derivatives by forces at a random point of a prime field, where no
    /// rounding hides it. False where this point has no value.
    pub(super) fn is_bound(&self) -> bool {
        let [field, _] = PrimeField::pair(0, true);
        let mut inputs = field.point(self.inputs);
        let mut memory = Vec::new();
        let start = self.plan.run(&field, &inputs, &mut memory);
        let one = field.literal(1.0);
        let mut columns: Vec<Vec<u64>> = Vec::with_capacity(self.model.len());
        for effort in self.solved.efforts.iter().flatten() {
            let place = effort.0 as usize;
            let before = inputs[place];
            inputs[place] = field.add(before, one);
            let moved = self.plan.run(&field, &inputs, &mut memory);
            inputs[place] = before;
            let pairs = moved.into_iter().zip(&start);
            columns.push(
                pairs
                    .map(|(moved, &start)| field.sub(moved, start))
                    .collect(),
            );
        }
        let mut numbers = columns.iter().flatten();
        !numbers.any(|&number| PrimeField::is_undefined(number)) && is_singular(columns, &field)
    }

    /// The elements at a state, row by row, and the part of the largest below
    /// which an element is zero; no numbers where the system is singular.
    pub(super) fn values(&mut self, number: impl Fn(SystemInput) -> f64) -> (Vec<f64>, f64) {
        for (shift, limit, zero) in [(0.0, SINGULAR, ZERO), (SHIFT, f64::MAX, SHIFTED_ZERO)] {
            if let Some(values) = self.at(&number, shift, limit) {
                return (values, zero);
            }
        }
        (vec![f64::NAN; self.model.len().pow(2)], ZERO)
    }

    /// The elements at a state that is shifted by a part of the usual numbers,
    /// if the inverse has none beyond the limit.
    fn at(
        &mut self,
        number: impl Fn(SystemInput) -> f64,
        shift: f64,
        limit: f64,
    ) -> Option<Vec<f64>> {
        let is_inert =
            |input: SystemInput| matches!(input, SystemInput::Mass(_) | SystemInput::Inertia(..));
        let shifted = |input: SystemInput| {
            let part = if is_inert(input) { 1.0 } else { shift };
            number(input) + part * input.usual()
        };
        let usual = self.inputs_of(|input| {
            if is_inert(input) {
                input.usual()
            } else {
                shifted(input)
            }
        });
        let more = self.inputs_of(shifted);
        if self.usual.0 != usual {
            let matrix = self.regular(&usual, limit);
            self.usual = (usual, matrix);
        }
        let whole = self.regular(&more, limit)?;
        let pairs = whole.iter().zip(self.usual.1.as_ref()?);
        Some(pairs.map(|(&whole, &usual)| (whole - usual).high).collect())
    }

    /// Inputs at a state: those of motion and loads are zero, those that are
    /// none of the system's one.
    fn inputs_of(&self, number: impl Fn(SystemInput) -> f64) -> Vec<f64> {
        let mut inputs = vec![1.0; self.inputs];
        let motion = &self.model.motion;
        let loads = motion.forces.iter().chain(&motion.torques).flatten();
        let motion = motion.rates.iter().chain(&motion.gravity).chain(loads);
        for &Input(input) in motion.chain(&self.solved.efforts).flatten() {
            inputs[input as usize] = 0.0;
        }
        self.model
            .visit(|place, input| inputs[input.0 as usize] = number(place));
        inputs
    }

    /// The matrix at a state, row by row; `None` where an element of its inverse
    /// is beyond the limit.
    fn regular(&mut self, state: &[f64], limit: f64) -> Option<Vec<Double>> {
        let count = self.model.len();
        let mut inverse = vec![Double::from(0.0); count * count];
        for first in (0..count).step_by(LANES) {
            let mut inputs: Vec<DoubleLanes<LANES>> = state
                .iter()
                .map(|&number| DoubleLanes::new([number; LANES]))
                .collect();
            for column in first..count.min(first + LANES) {
                let input = self.solved.efforts[column].expect("every joint has a force");
                inputs[input.0 as usize].high[column - first] = 1.0;
            }
            let arithmetic = DoubleDoubleLanes::<LANES>;
            let outputs = self.plan.run(&arithmetic, &inputs, &mut self.memory);
            for (row, &place) in self.places.iter().enumerate() {
                for column in first..count.min(first + LANES) {
                    inverse[row * count + column] = outputs[place].lane(column - first);
                }
            }
        }
        let is_regular = inverse.iter().all(|number| number.high.abs() <= limit);
        is_regular.then(|| inverted(inverse, count))
    }
}

/// Tests whether the columns of a square matrix depend on one another.
fn is_singular(mut columns: Vec<Vec<u64>>, field: &PrimeField) -> bool {
    let zero = field.literal(0.0);
    for row in 0..columns.len() {
        let Some(pivot) = columns.iter().position(|column| column[row] != zero) else {
            return true;
        };
        let pivot = columns.swap_remove(pivot);
        for column in &mut columns {
            let factor = field.div(column[row], pivot[row]);
            for (number, &part) in column.iter_mut().zip(&pivot).skip(row) {
                *number = field.sub(*number, field.mul(factor, part));
            }
        }
    }
    false
}

/// The inverse of a matrix, row by row, by elimination with the largest pivots
/// of columns; no numbers where it is singular.
fn inverted(mut matrix: Vec<Double>, count: usize) -> Vec<Double> {
    let one = Double::from(1.0);
    let mut inverse = vec![Double::from(0.0); count * count];
    (0..count).for_each(|joint| inverse[joint * count + joint] = one);
    for pivot in 0..count {
        let size = |row: &usize| matrix[row * count + pivot].high.abs();
        let largest = (pivot..count).max_by(|a, b| size(a).total_cmp(&size(b)));
        let largest = largest.expect("there is a row");
        for column in 0..count {
            matrix.swap(pivot * count + column, largest * count + column);
            inverse.swap(pivot * count + column, largest * count + column);
        }
        let scale = one / matrix[pivot * count + pivot];
        for row in (0..count).filter(|&row| row != pivot) {
            let factor = matrix[row * count + pivot] * scale;
            for column in 0..count {
                let [from, to] = [pivot, row].map(|row| row * count + column);
                matrix[to] = matrix[to] - factor * matrix[from];
                inverse[to] = inverse[to] - factor * inverse[from];
            }
        }
        for column in 0..count {
            let at = pivot * count + column;
            matrix[at] = matrix[at] * scale;
            inverse[at] = inverse[at] * scale;
        }
    }
    inverse
}
