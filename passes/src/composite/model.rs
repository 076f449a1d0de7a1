//! The mass matrix that a function computes, and the inputs of its system.

use crate::factor::network::{Edge, FactorKind, FactorNetwork};
use hashbrown::{HashMap, HashSet};
use robovec_framework::fingerprint::Fingerprint;
use robovec_ir::{Array, Function, Input, Operation, Shape, Tables};

use super::bodies::RigidBody;

/// Names of input elements, as the network numbers them; `None` for an
/// element that is zero in the model and so never read.
pub(super) struct ModelInputs {
    /// Coordinates, by joint.
    pub(super) coordinates: Vec<Option<Input>>,
    /// Whether the sine or cosine of the coordinate is read, by joint.
    pub(super) turns: Vec<bool>,
    /// Bodies, by joint.
    pub(super) bodies: Vec<RigidBody<Option<Input>>>,
    /// Attachment points.
    pub(super) points: Vec<[Option<Input>; 3]>,
    /// For every element of the mass matrix, row by row, the place of its
    /// assignment; `None` where it is zero.
    pub(super) elements: Vec<Option<usize>>,
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
            read.contains_key(&input.0).then_some(input)
        };
        let [q, m, l, inertia, dpt] = ["q", "m", "l", "In", "dpt"].map(|name| named(inputs, name));
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
        let coordinates: Vec<Option<Input>> =
            (1..=joints).map(|joint| element(q, &[joint])).collect();
        let angles = angles(network);
        let turns = |input: &Option<Input>| input.is_some_and(|input| angles.contains(&input.0));
        Some(ModelInputs {
            turns: coordinates.iter().map(turns).collect(),
            coordinates,
            bodies: bodies.collect(),
            points,
            elements,
        })
    }

    /// The value of an element of the mass matrix, counted from 0.
    pub(super) fn element(
        &self,
        network: &FactorNetwork,
        row: usize,
        column: usize,
    ) -> Fingerprint {
        self.elements[row * self.len() + column].map_or(network.values.images.zero(), |place| {
            network.value(network.outputs[place])
        })
    }
}

/// The input elements that live nodes read, with their edges.
fn read_inputs(network: &FactorNetwork) -> HashMap<u32, Edge> {
    let mut read = HashMap::new();
    for (index, node) in network.nodes.iter().enumerate() {
        if let FactorKind::Input(operand) = node.kind
            && node.uses > 0
            && let Some(input) = operand.input()
        {
            read.insert(input.0, Edge::new(index as u32, false));
        }
    }
    read
}

/// The input elements whose sine or cosine is read.
fn angles(network: &FactorNetwork) -> HashSet<u32> {
    let functions = network.nodes.iter().filter(|node| {
        matches!(
            node.kind,
            FactorKind::Other(Operation::Sin | Operation::Cos)
        ) && node.uses > 0
    });
    functions
        .filter_map(|node| match network.nodes[node.operands[0].node()].kind {
            FactorKind::Input(operand) => operand.input().map(|input| input.0),
            _ => None,
        })
        .collect()
}
