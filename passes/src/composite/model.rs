//! The mass matrix or the accelerations that a function computes, and the
//! inputs of its system.

use super::bodies::RigidBody;
use crate::factor::network::{FactorKind, FactorNetwork};
use hashbrown::HashSet;
use robovec_ir::{Array, Function, Input, Shape, Tables};
use robovec_num::random::mix;

/// An input element of the system, with its joint or body; all indices are from 0.
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
    /// The body of the parameter.
    pub(super) fn body(self) -> Option<usize> {
        match self {
            SystemInput::Mass(body)
            | SystemInput::Centre(body, _)
            | SystemInput::Inertia(body, _) => Some(body),
            SystemInput::Coordinate(_) | SystemInput::Point(..) => None,
        }
    }

    /// A number for it that is in no relation to those of others, as a
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

/// The input elements of the system; `None` for an element that is zero in the
/// model and so never read.
pub(super) struct ModelInputs {
    /// Coordinates, by joint.
    pub(super) coordinates: Vec<Option<Input>>,
    /// Bodies, by joint.
    pub(super) bodies: Vec<RigidBody<Option<Input>>>,
    /// Attachment points.
    pub(super) points: Vec<[Option<Input>; 3]>,
    /// For every element of the mass matrix, row by row, the place of its
    /// assignment; `None` where it is zero.
    pub(super) elements: Vec<Option<usize>>,
    /// Other inputs on which the forces depend.
    pub(super) motion: MotionInputs,
    /// The accelerations that are computed instead of the mass matrix.
    pub(super) solved: Option<SolvedMotion>,
}

/// Accelerations of all joints for given forces.
pub(super) struct SolvedMotion {
    /// The place of the assignment of each acceleration, by joint.
    pub(super) places: Vec<Option<usize>>,
    /// The force of each joint.
    pub(super) efforts: Vec<Option<Input>>,
}

/// The input elements that forces depend on and the mass matrix does not, by
/// joint; and where the forces are set.
pub(super) struct MotionInputs {
    /// Velocities.
    pub(super) rates: Vec<Option<Input>>,
    /// Accelerations, of joints that are driven.
    pub(super) accelerations: Vec<Option<Input>>,
    pub(super) gravity: [Option<Input>; 3],
    /// Forces on bodies from outside, at their centres of mass.
    pub(super) forces: Vec<[Option<Input>; 3]>,
    pub(super) torques: Vec<[Option<Input>; 3]>,
    /// The place of the assignment of each force `c`; `None` where it is zero.
    pub(super) biases: Vec<Option<usize>>,
}

/// Systems with more joints are unchanged: the time of this code is quadratic
/// in their number.
const MAX_JOINTS: usize = 1000;

/// The same where accelerations are computed, whose mass matrix takes an
/// evaluation for each of its columns.
const MAX_SOLVED: usize = 130;

impl ModelInputs {
    /// The number of joints.
    pub(super) fn len(&self) -> usize {
        self.coordinates.len()
    }

    /// Looks for Robotran's arrays; `None` when the function computes neither a
    /// mass matrix nor accelerations of all joints over them.
    pub(super) fn find(
        function: &Function,
        network: &FactorNetwork,
        tables: &Tables,
    ) -> Option<ModelInputs> {
        let named = |arrays: &[Array], name: &str| {
            let symbol = tables.symbols.find(name)?;
            arrays.iter().find(|array| array.name == symbol).copied()
        };
        let matrix = named(function.outputs(), "M");
        let accelerations = named(function.outputs(), "qdd");
        let of = |array: Option<Array>| array.map(|array| array.shape);
        let (joints, most) = match (of(matrix), of(accelerations)) {
            (Some(Shape::Matrix(rows, columns)), _) if rows == columns => (rows, MAX_JOINTS),
            (None, Some(Shape::Vector(joints))) => (joints, MAX_SOLVED),
            _ => return None,
        };
        let count = joints as usize;
        if count == 0 || count > most {
            return None;
        }
        let read = read_inputs(network);
        let inputs = function.inputs();
        let element = |array: Option<Array>, indices: &[u32]| {
            let array = array?;
            let input = Input(array.offset + array.shape.offset(indices)?);
            read.contains(&input).then_some(input)
        };
        let [q, m, l, inertia, dpt] = ["q", "m", "l", "In", "dpt"].map(|name| named(inputs, name));
        let motion = ["qd", "qdd", "g", "frc", "trq"].map(|name| named(inputs, name));
        let [qd, qdd, g, frc, trq] = motion;
        let by_joint =
            |array: Option<Array>| (1..=joints).map(move |joint| element(array, &[joint]));
        let by_body = |array: Option<Array>| {
            (1..=joints).map(move |joint| [1, 2, 3].map(|row| element(array, &[row, joint])))
        };
        let bodies = (1..=joints).map(|joint| RigidBody {
            mass: element(m, &[joint]),
            centre: [1, 2, 3].map(|row| element(l, &[row, joint])),
            inertia: [0, 1, 2]
                .map(|r| [0, 1, 2].map(|c| element(inertia, &[3 * r + c + 1, joint]))),
        });
        let points = match dpt.map(|array| array.shape) {
            Some(Shape::Matrix(3, columns)) => (1..=columns)
                .map(|point| [1, 2, 3].map(|row| element(dpt, &[row, point])))
                .filter(|point| point.iter().any(Option::is_some))
                .collect(),
            _ => Vec::new(),
        };
        // The places of the assignments of an array, if they are not zero.
        let places = |array: Option<Array>, length: usize| {
            let mut places = vec![None; length];
            let Some(array) = array.filter(|array| array.shape.len() == length) else {
                return places;
            };
            for (place, assignment) in function.assignments.iter().enumerate() {
                let index = (assignment.output.0 as usize).wrapping_sub(array.offset as usize);
                if index < length && function.number(assignment.operand) != Some(0.0) {
                    places[index] = Some(place);
                }
            }
            places
        };
        let solved = match matrix {
            Some(_) => None,
            None => Some(SolvedMotion {
                places: places(accelerations, count),
                efforts: by_joint(named(inputs, "Qq")).collect(),
            }),
        };
        let is_free = |solved: &SolvedMotion| {
            solved.places.iter().all(Option::is_some) && solved.efforts.iter().all(Option::is_some)
        };
        if !solved.as_ref().is_none_or(is_free) {
            return None;
        }
        Some(ModelInputs {
            coordinates: by_joint(q).collect(),
            motion: MotionInputs {
                rates: by_joint(qd).collect(),
                accelerations: by_joint(qdd).collect(),
                gravity: [1, 2, 3].map(|axis| element(g, &[axis])),
                forces: by_body(frc).collect(),
                torques: by_body(trq).collect(),
                biases: places(named(function.outputs(), "c"), count),
            },
            bodies: bodies.collect(),
            points,
            elements: places(matrix, count * count),
            solved,
        })
    }

    /// A body by the places of its parameters.
    pub(super) fn body(&self, body: usize) -> RigidBody<Option<SystemInput>> {
        let given = &self.bodies[body];
        let place = |place: SystemInput, input: Option<Input>| input.map(|_| place);
        RigidBody {
            mass: place(SystemInput::Mass(body), given.mass),
            centre: [0, 1, 2].map(|i| place(SystemInput::Centre(body, i), given.centre[i])),
            inertia: [0, 1, 2].map(|r| {
                [0, 1, 2].map(|c| place(SystemInput::Inertia(body, [r, c]), given.inertia[r][c]))
            }),
        }
    }

    /// Calls a function with every input of the system that is read.
    pub(super) fn visit(&self, mut visit: impl FnMut(SystemInput, Input)) {
        let mut each = |place: SystemInput, input: Option<Input>| {
            if let Some(input) = input {
                visit(place, input);
            }
        };
        for (joint, &input) in self.coordinates.iter().enumerate() {
            each(SystemInput::Coordinate(joint), input);
        }
        for (body, given) in self.bodies.iter().enumerate() {
            each(SystemInput::Mass(body), given.mass);
            for i in 0..3 {
                each(SystemInput::Centre(body, i), given.centre[i]);
                for c in 0..3 {
                    each(SystemInput::Inertia(body, [i, c]), given.inertia[i][c]);
                }
            }
        }
        for (point, parts) in self.points.iter().enumerate() {
            for (axis, &input) in parts.iter().enumerate() {
                each(SystemInput::Point(point, axis), input);
            }
        }
    }
}

/// The input elements that live nodes read.
fn read_inputs(network: &FactorNetwork) -> HashSet<Input> {
    let live = network.nodes.iter().filter(|node| node.uses > 0);
    let inputs = live.filter_map(|node| match node.kind {
        FactorKind::Input(operand) => operand.input(),
        _ => None,
    });
    inputs.collect()
}

/// Tree of the joints: the parent of each.
pub(super) struct AncestorTree {
    /// The joint before each, counted from 0.
    pub(super) parents: Vec<Option<usize>>,
    /// The bodies beyond each joint, counted from 0 as the joint that moves
    /// them last.
    pub(super) behind: Vec<Vec<usize>>,
    /// True for each joint that is prismatic.
    pub(super) slides: Vec<bool>,
}

impl AncestorTree {
    /// A joint and those before it, the nearest first.
    pub(super) fn chain(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(joint), |&joint| self.parents[joint])
    }

    /// The sum of the masses beyond a joint in their usual state.
    pub(super) fn mass(&self, joint: usize, model: &ModelInputs) -> f64 {
        let bodies = self.behind[joint].iter();
        let heavy = bodies.filter(|&&body| model.bodies[body].mass.is_some());
        heavy.map(|&body| SystemInput::Mass(body).usual()).sum()
    }
}
