//! The mass matrix at states of our own choosing.
//!
//! The function is evaluated in binary64 at states that a system would hardly
//! meet: without the mass of all bodies but one, with all frames aligned, with
//! a single attachment point. Each shows one thing about the tree of joints
//! and nothing else. Rounding is harmless: whatever is concluded is proved
//! afterwards, element by element, in the images of the network.

use super::bodies::{RigidBody, Ring, Stand};
use super::matrix::BodySystem;
use super::model::ModelInputs;
use super::tree::JointPlacement;
use robovec_ir::Function;
use robovec_ir::plan::EvaluationPlan;
use robovec_num::arithmetic::Binary64;
use robovec_num::random::mix;

/// An input element of the system, with what it belongs to; everything is
/// counted from 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum SystemInput {
    /// The coordinate of a joint.
    Coordinate(usize),
    /// The mass of a body.
    Mass(usize),
    /// A component of the centre of mass of a body.
    Centre(usize, usize),
    /// An entry of the inertia of a body: row and column.
    Inertia(usize, [usize; 2]),
    /// A component of an attachment point.
    Point(usize, usize),
}

impl SystemInput {
    /// The body it is a parameter of.
    pub(super) fn body(self) -> Option<usize> {
        match self {
            SystemInput::Mass(body)
            | SystemInput::Centre(body, _)
            | SystemInput::Inertia(body, _) => Some(body),
            SystemInput::Coordinate(_) | SystemInput::Point(..) => None,
        }
    }

    /// A number for it that stands in no relation to those of others, as a
    /// system might have it: masses and diagonal inertias are positive, the
    /// two products of inertia of a pair of axes are equal, and no angle is
    /// near a multiple of a right one.
    pub(super) fn usual(self) -> f64 {
        let (kind, first, second) = match self {
            SystemInput::Coordinate(joint) => (0, joint, 0),
            SystemInput::Mass(body) => (1, body, 0),
            SystemInput::Centre(body, axis) => (2, body, axis),
            SystemInput::Inertia(body, [r, c]) => (3, body, 3 * r.min(c) + r.max(c)),
            SystemInput::Point(point, axis) => (4, point, axis),
        };
        let bits = mix(mix(first as u64) ^ (kind << 8 | second as u64));
        let unit = (bits >> 12) as f64 / (1u64 << 52) as f64;
        let sign = if bits & 1 == 1 { -1.0 } else { 1.0 };
        match self {
            SystemInput::Coordinate(_) => sign * (0.3 + 0.9 * unit),
            SystemInput::Mass(_) => 1.0 + unit,
            SystemInput::Inertia(_, [r, c]) if r == c => 3.0 + 4.0 * unit,
            SystemInput::Inertia(..) => sign * (0.2 + 0.5 * unit),
            SystemInput::Centre(..) | SystemInput::Point(..) => sign * (0.5 + unit),
        }
    }
}

/// A mass matrix in numbers.
pub(super) struct ProbedMatrix {
    count: usize,
    values: Vec<f64>,
    largest: f64,
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

    /// True when a row is zero but for rounding.
    pub(super) fn is_row_zero(&self, row: usize) -> bool {
        (0..self.count).all(|column| self.is_zero(row, column))
    }

    /// True for an element that is zero but for rounding.
    pub(super) fn is_zero(&self, row: usize, column: usize) -> bool {
        self.at(row, column).abs() <= 1e-11 * self.largest
    }
}

/// Tests whether two numbers of a given size are one but for rounding.
pub(super) fn near(a: f64, b: f64, size: f64) -> bool {
    (a - b).abs() <= 1e-8 * size
}

/// Evaluates the mass matrix.
pub(super) struct MatrixProbe<'a> {
    model: &'a ModelInputs,
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
        let mut wanted: Vec<usize> = model.elements.iter().copied().flatten().collect();
        wanted.sort_unstable();
        let count = model.len();
        let place = |index: usize| {
            // An element that is not set may be so above the diagonal alone.
            let mirrored = index % count * count + index / count;
            let assignment = model.elements[index].or(model.elements[mirrored])?;
            wanted.binary_search(&assignment).ok()
        };
        MatrixProbe {
            model,
            places: (0..count * count).map(place).collect(),
            plan: EvaluationPlan::of(function, |place| wanted.binary_search(&place).is_ok()),
            inputs: function.input_len(),
            memory: Vec::new(),
        }
    }

    /// Operations of one evaluation.
    pub(super) fn work(&self) -> usize {
        self.plan.len()
    }

    /// The matrix at a state. Inputs that are none of the system's are one.
    pub(super) fn matrix(&mut self, number: impl Fn(SystemInput) -> f64) -> ProbedMatrix {
        let mut inputs = vec![1.0; self.inputs];
        self.model
            .visit(|place, input| inputs[input.0 as usize] = number(place));
        let outputs = self.plan.run(&Binary64, &inputs, &mut self.memory);
        let places = self.places.iter();
        let values: Vec<f64> = places
            .map(|place| place.map_or(0.0, |place| outputs[place]))
            .collect();
        ProbedMatrix {
            count: self.model.len(),
            largest: values
                .iter()
                .fold(0.0, |largest, value| value.abs().max(largest)),
            values,
        }
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
