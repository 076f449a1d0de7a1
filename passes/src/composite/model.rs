//! The mass matrix that a function computes, and the inputs of its system.

use super::bodies::RigidBody;
use super::probe::SystemInput;
use crate::factor::network::{FactorKind, FactorNetwork};
use hashbrown::HashSet;
use robovec_ir::{Array, Function, Input, Shape, Tables};

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
    /// Other inputs that the forces depend on.
    pub(super) motion: MotionInputs,
}

/// The input elements that forces depend on and the mass matrix does not, by
/// joint; and where the forces are set.
pub(super) struct MotionInputs {
    /// Velocities.
    pub(super) rates: Vec<Option<Input>>,
    /// Accelerations, of joints that are driven.
    pub(super) accelerations: Vec<Option<Input>>,
    /// Gravity.
    pub(super) gravity: [Option<Input>; 3],
    /// Forces on bodies from outside, at their centres of mass.
    pub(super) forces: Vec<[Option<Input>; 3]>,
    /// Torques.
    pub(super) torques: Vec<[Option<Input>; 3]>,
    /// The place of the assignment of each force `c`; `None` where it is zero.
    pub(super) biases: Vec<Option<usize>>,
}

/// Systems with more joints are left alone: everything here is quadratic in
/// their number.
const MAX_JOINTS: usize = 1000;

impl ModelInputs {
    /// The number of joints.
    pub(super) fn len(&self) -> usize {
        self.coordinates.len()
    }

    /// Looks for Robotran's arrays; `None` when the function has no mass
    /// matrix over them.
    pub(super) fn find(
        function: &Function,
        network: &FactorNetwork,
        tables: &Tables,
    ) -> Option<ModelInputs> {
        let named = |arrays: &[Array], name: &str| {
            let symbol = tables.symbols.find(name)?;
            arrays.iter().find(|array| array.name == symbol).copied()
        };
        let matrix = named(function.outputs(), "M")?;
        let Shape::Matrix(joints, columns) = matrix.shape else {
            return None;
        };
        let count = joints as usize;
        if joints != columns || count == 0 || count > MAX_JOINTS {
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
        let mut elements = vec![None; count * count];
        for (place, assignment) in function.assignments.iter().enumerate() {
            let index = (assignment.output.0 as usize).wrapping_sub(matrix.offset as usize);
            let zero = function.number(assignment.operand) == Some(0.0);
            if index < elements.len() && !zero {
                elements[index] = Some(place);
            }
        }
        let mut biases = vec![None; count];
        let forces = named(function.outputs(), "c");
        if let Some(array) = forces.filter(|array| array.shape == Shape::Vector(joints)) {
            for (place, assignment) in function.assignments.iter().enumerate() {
                let index = (assignment.output.0 as usize).wrapping_sub(array.offset as usize);
                if index < count && function.number(assignment.operand) != Some(0.0) {
                    biases[index] = Some(place);
                }
            }
        }
        Some(ModelInputs {
            coordinates: by_joint(q).collect(),
            motion: MotionInputs {
                rates: by_joint(qd).collect(),
                accelerations: by_joint(qdd).collect(),
                gravity: [1, 2, 3].map(|axis| element(g, &[axis])),
                forces: by_body(frc).collect(),
                torques: by_body(trq).collect(),
                biases,
            },
            bodies: bodies.collect(),
            points,
            elements,
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
