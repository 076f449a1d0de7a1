//! The mass matrix at chosen states.
//!
//! The function is evaluated in binary64 at states that a system would hardly
//! meet: without the mass of all bodies but one, with all frames aligned, with
//! a single attachment point. Each isolates one property of the tree of joints.
//! Rounding is harmless: every conclusion is proved afterwards, element by
//! element, in the images of the network.

use super::bodies::{RigidBody, Ring, Stand};
use super::matrix::{BodySystem, JointPlacement};
use super::model::{ModelInputs, SystemInput};
use super::solved::SolvedMatrix;
use robovec_ir::Function;
use robovec_ir::plan::EvaluationPlan;
use robovec_num::arithmetic::Binary64;

/// Part of the largest element of a matrix below which an element is zero.
pub(super) const ZERO: f64 = 1e-11;

/// A mass matrix in numbers.
pub(super) struct ProbedMatrix {
    count: usize,
    values: Vec<f64>,
    largest: f64,
    /// Part of it below which an element is zero.
    zero: f64,
}

impl ProbedMatrix {
    /// An element; rows and columns are counted from 0.
    pub(super) fn at(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.count + column]
    }

    /// The size of the largest element.
    pub(super) fn largest(&self) -> f64 {
        self.largest
    }

    /// True when a row is zero except for rounding.
    pub(super) fn is_row_zero(&self, row: usize) -> bool {
        (0..self.count).all(|column| self.is_zero(row, column))
    }

    /// True for an element that is zero except for rounding.
    pub(super) fn is_zero(&self, row: usize, column: usize) -> bool {
        self.at(row, column).abs() <= self.zero * self.largest
    }
}

/// Tests whether two numbers of a given size are one except for rounding.
pub(super) fn near(a: f64, b: f64, size: f64) -> bool {
    (a - b).abs() <= 1e-8 * size
}

/// Evaluates the mass matrix.
pub(super) struct MatrixProbe<'a> {
    model: &'a ModelInputs,
    source: MatrixSource<'a>,
}

/// Origin of the mass matrix.
enum MatrixSource<'a> {
    /// The outputs of the function.
    Outputs(OutputMatrix),
    /// Accelerations that the function computes.
    Solved(SolvedMatrix<'a>),
}

/// A mass matrix among the outputs of a function.
struct OutputMatrix {
    plan: EvaluationPlan,
    /// For each element of the matrix, row by row, its place among the
    /// outputs of the plan.
    places: Vec<Option<usize>>,
    inputs: usize,
    memory: Vec<f64>,
}

impl<'a> MatrixProbe<'a> {
    /// Makes a function ready.
    pub(super) fn new(function: &Function, model: &'a ModelInputs) -> MatrixProbe<'a> {
        let source = match &model.solved {
            Some(solved) => MatrixSource::Solved(SolvedMatrix::new(function, model, solved)),
            None => MatrixSource::Outputs(OutputMatrix::new(function, model)),
        };
        MatrixProbe { model, source }
    }

    /// Operations of one evaluation.
    pub(super) fn work(&self) -> usize {
        match &self.source {
            MatrixSource::Outputs(matrix) => matrix.plan.len(),
            MatrixSource::Solved(matrix) => matrix.work(),
        }
    }

    /// Tests whether accelerations follow from others.
    pub(super) fn is_bound(&self) -> bool {
        match &self.source {
            MatrixSource::Outputs(_) => false,
            MatrixSource::Solved(matrix) => matrix.is_bound(),
        }
    }

    /// The matrix at a state. Inputs that are none of the system's are one.
    pub(super) fn matrix(&mut self, number: impl Fn(SystemInput) -> f64) -> ProbedMatrix {
        let (values, zero) = match &mut self.source {
            MatrixSource::Outputs(matrix) => (matrix.values(self.model, number), ZERO),
            MatrixSource::Solved(matrix) => matrix.values(number),
        };
        ProbedMatrix {
            count: self.model.len(),
            largest: values
                .iter()
                .fold(0.0, |largest, value| value.abs().max(largest)),
            values,
            zero,
        }
    }
}

impl OutputMatrix {
    fn new(function: &Function, model: &ModelInputs) -> OutputMatrix {
        let mut wanted: Vec<usize> = model.elements.iter().copied().flatten().collect();
        wanted.sort_unstable();
        let count = model.len();
        let place = |index: usize| {
            // An element that is not set may be so above the diagonal alone.
            let mirrored = index % count * count + index / count;
            let assignment = model.elements[index].or(model.elements[mirrored])?;
            wanted.binary_search(&assignment).ok()
        };
        OutputMatrix {
            places: (0..count * count).map(place).collect(),
            plan: EvaluationPlan::of(function, |place| wanted.binary_search(&place).is_ok()),
            inputs: function.input_len(),
            memory: Vec::new(),
        }
    }

    fn values(&mut self, model: &ModelInputs, number: impl Fn(SystemInput) -> f64) -> Vec<f64> {
        let mut inputs = vec![1.0; self.inputs];
        model.visit(|place, input| inputs[input.0 as usize] = number(place));
        let outputs = self.plan.run(&Binary64, &inputs, &mut self.memory);
        let places = self.places.iter();
        places
            .map(|place| place.map_or(0.0, |place| outputs[place]))
            .collect()
    }
}

/// The system in its usual state, in the numbers that probes are compared
/// with.
pub(super) struct UsualState<'a> {
    pub(super) model: &'a ModelInputs,
}

impl Ring for UsualState<'_> {
    type Number = f64;
    fn zero(&mut self) -> f64 {
        0.0
    }
    fn add(&mut self, a: f64, b: f64) -> f64 {
        a + b
    }
    fn sub(&mut self, a: f64, b: f64) -> f64 {
        a - b
    }
    fn mul(&mut self, a: f64, b: f64) -> f64 {
        a * b
    }
    fn same(&self, _: f64, _: f64) -> bool {
        // Rounded numbers tell nothing for sure.
        false
    }
}

impl BodySystem for UsualState<'_> {
    fn enter(&mut self, _: usize) {}

    fn body(&mut self, joint: usize, place: &JointPlacement) -> RigidBody<f64> {
        let body = self.model.body(joint).mirrored(place.symmetric);
        body.map(|place| place.map_or(0.0, SystemInput::usual))
    }

    fn stand(&mut self, joint: usize, place: &JointPlacement) -> Stand<f64> {
        let given = |input: SystemInput, is_read: bool| if is_read { input.usual() } else { 0.0 };
        let is_read = self.model.coordinates[joint].is_some();
        let coordinate = given(SystemInput::Coordinate(joint), is_read);
        let offset = [0, 1, 2].map(|axis| {
            let points = place.points.iter();
            let parts = points.map(|&point| {
                let is_read = self.model.points[point][axis].is_some();
                given(SystemInput::Point(point, axis), is_read)
            });
            parts.sum()
        });
        Stand {
            joint: place.joint,
            offset,
            coordinate,
            cosine: coordinate.cos(),
            sine: coordinate.sin(),
        }
    }
}
