//! The equations of composite bodies.

use super::bodies::{CompositeInertia, JointAxis, RigidBody, Ring, RingVector, Stand, UnitWrench};
use super::forces::{MovingSystem, bias_forces};
use super::matrix::{BodySystem, JointPlacement, mass_matrix};
use super::model::{ModelInputs, SolvedMotion};
use super::quotients;
use super::solve::{SolvingSystem, articulated, factorised};
use crate::factor::network::{Edge, FactorKind, FactorNetwork, NodeOrigin, ONE, ZERO};
use robovec_framework::rewrite::output_symbol;
use robovec_ir::{Function, Input, Name, Operand, Operation, Tables};
use robovec_num::arithmetic::Arithmetic;

/// Writes equations as values of a network.
struct EquationWriter<'n> {
    network: &'n mut FactorNetwork,
    model: &'n ModelInputs,
    /// By joint: whose equations the values made for it represent.
    origins: &'n [NodeOrigin],
    /// Whose equations the values represent that are made now.
    origin: NodeOrigin,
}

impl Ring for EquationWriter<'_> {
    type Number = Edge;
    fn zero(&mut self) -> Edge {
        Edge::new(ZERO as u32, false)
    }
    fn add(&mut self, a: Edge, b: Edge) -> Edge {
        self.network.sum(&[a, b], self.origin)
    }
    fn sub(&mut self, a: Edge, b: Edge) -> Edge {
        self.network.sum(&[a, b.flip(true)], self.origin)
    }
    fn mul(&mut self, a: Edge, b: Edge) -> Edge {
        self.network.product(&[a, b], self.origin)
    }
    fn same(&self, a: Edge, b: Edge) -> bool {
        self.network.value(a) == self.network.value(b)
    }
}

impl<'n> EquationWriter<'n> {
    fn new(
        network: &'n mut FactorNetwork,
        model: &'n ModelInputs,
        origins: &'n [NodeOrigin],
    ) -> EquationWriter<'n> {
        EquationWriter {
            network,
            model,
            origins,
            origin: NodeOrigin::NONE,
        }
    }

    fn input(&mut self, input: Option<Input>) -> Edge {
        let Some(input) = input else {
            return self.zero();
        };
        let value = self.network.values.images.input(input);
        let kind = FactorKind::Input(Operand::from(input));
        self.network
            .find_or_push(kind, Vec::new(), value, NodeOrigin::NONE)
    }

    /// An operation other than a sum or a product.
    fn operation(&mut self, operation: Operation, operands: &[Edge]) -> Edge {
        let [first, last] = [operands[0], operands[operands.len() - 1]];
        let [first, last] = [first, last].map(|edge| self.network.value(edge));
        let images = &self.network.values.images;
        let value = images.apply(operation, [first, last, last]);
        let kind = FactorKind::Other(operation);
        self.network
            .find_or_push(kind, operands.to_vec(), value, self.origin)
    }
}

impl BodySystem for EquationWriter<'_> {
    fn enter(&mut self, joint: usize) {
        self.origin = self.origins[joint];
    }

    fn body(&mut self, joint: usize, place: &JointPlacement) -> RigidBody<Edge> {
        let body = self.model.bodies[joint].mirrored(place.symmetric);
        body.map(|part| self.input(part))
    }

    fn stand(&mut self, joint: usize, place: &JointPlacement) -> Stand<Edge> {
        let coordinate = self.input(self.model.coordinates[joint]);
        let zero = self.zero();
        let (cosine, sine) = match (place.joint, self.model.coordinates[joint]) {
            (JointAxis::Revolute(_), Some(_)) => (
                self.operation(Operation::Cos, &[coordinate]),
                self.operation(Operation::Sin, &[coordinate]),
            ),
            _ => (Edge::new(ONE as u32, false), zero),
        };
        let mut offset = [zero; 3];
        for &point in &place.points {
            let parts = self.model.points[point].map(|part| self.input(part));
            offset = [0, 1, 2].map(|axis| self.add(offset[axis], parts[axis]));
        }
        Stand {
            joint: place.joint,
            offset,
            coordinate,
            cosine,
            sine,
        }
    }
}

impl MovingSystem for EquationWriter<'_> {
    fn rate(&mut self, joint: usize) -> Edge {
        self.input(self.model.motion.rates[joint])
    }

    fn acceleration(&mut self, joint: usize) -> Edge {
        self.input(self.model.motion.accelerations[joint])
    }

    fn gravity(&mut self) -> RingVector<Edge> {
        self.model.motion.gravity.map(|part| self.input(part))
    }

    fn loads(&mut self, joint: usize) -> UnitWrench<Edge> {
        UnitWrench {
            force: self.model.motion.forces[joint].map(|part| self.input(part)),
            torque: self.model.motion.torques[joint].map(|part| self.input(part)),
        }
    }
}

impl SolvingSystem for EquationWriter<'_> {
    fn one(&mut self) -> Edge {
        Edge::new(ONE as u32, false)
    }

    fn div(&mut self, a: Edge, b: Edge) -> Edge {
        self.operation(Operation::Div, &[a, b])
    }
}

/// Tree of bodies found in a function.
pub(super) struct RebuiltEquations {
    /// The elements of the mass matrix, row by row and counted from 0, that
    /// differ from those of the tree and are unchanged.
    pub(super) unexplained: Vec<usize>,
    /// Number of forces computed from composite bodies now.
    pub(super) forces: usize,
}

/// Computes the mass matrix of a network from composite bodies instead, and
/// the forces, where that takes fewer operations.
pub(super) fn rebuild(
    network: &mut FactorNetwork,
    model: &ModelInputs,
    places: &[JointPlacement],
    function: &Function,
    tables: &mut Tables,
) -> RebuiltEquations {
    let origins = origins(network, model, function, tables);
    if let Some(solved) = &model.solved {
        return resolve(network, (model, solved), places, &origins);
    }
    let mut composites = Vec::new();
    let unexplained = exchange(network, &model.elements, same_values, |network| {
        let mut writer = EquationWriter::new(network, model, &origins);
        let (matrix, bodies) = mass_matrix(&mut writer, places);
        composites = bodies;
        matrix
    });
    let before = network.cost;
    let old: Vec<Edge> = network.outputs.clone();
    // What the matrix alone does not need must not go before the forces are
    // made of it.
    let held: Vec<Edge> = composites
        .iter()
        .flat_map(CompositeInertia::parts)
        .collect();
    held.iter().for_each(|&edge| network.acquire(edge));
    let kept = exchange(network, &model.motion.biases, same_values, |network| {
        let mut writer = EquationWriter::new(network, model, &origins);
        bias_forces(&mut writer, places, &composites)
    });
    held.iter().for_each(|&edge| network.release(edge));
    let given = model.motion.biases.iter().flatten().count();
    let mut forces = given - kept.len();
    if network.cost >= before {
        restore(network, &model.motion.biases, &old);
        forces = 0;
    }
    RebuiltEquations {
        unexplained,
        forces,
    }
}

/// Gives outputs their former equations.
fn restore(network: &mut FactorNetwork, places: &[Option<usize>], old: &[Edge]) {
    for &place in places.iter().flatten() {
        network.acquire(old[place]);
        network.release(network.outputs[place]);
        network.outputs[place] = old[place];
    }
}

/// Computes the accelerations of a network from the tree of bodies instead: by
/// articulated bodies or the factorised mass matrix, whichever takes fewer
/// operations.
fn resolve(
    network: &mut FactorNetwork,
    (model, solved): (&ModelInputs, &SolvedMotion),
    places: &[JointPlacement],
    origins: &[NodeOrigin],
) -> RebuiltEquations {
    let write = |network: &mut FactorNetwork, is_articulated: bool| {
        exchange(network, &solved.places, quotients::equal, |network| {
            let mut writer = EquationWriter::new(network, model, origins);
            let (matrix, composites) = mass_matrix(&mut writer, places);
            let biases = bias_forces(&mut writer, places, &composites);
            let efforts = solved.efforts.iter().zip(biases);
            let forces = efforts.map(|(&effort, bias)| {
                let effort = writer.input(effort);
                writer.sub(effort, bias)
            });
            let forces: Vec<Edge> = forces.collect();
            if is_articulated {
                articulated(&mut writer, places, &forces)
            } else {
                factorised(&mut writer, places, matrix, forces)
            }
        })
    };
    let mut unexplained = write(network, true);
    let (before, old) = (network.cost, network.outputs.clone());
    let others = write(network, false);
    if (others.len(), network.cost) < (unexplained.len(), before) {
        unexplained = others;
    } else {
        restore(network, &solved.places, &old);
    }
    RebuiltEquations {
        unexplained,
        forces: 0,
    }
}

/// Puts other equations instead of those of some outputs, given by their places
/// among the assignments. Elements with another value are unchanged and
/// returned by their indices.
fn exchange(
    network: &mut FactorNetwork,
    places: &[Option<usize>],
    equal: impl FnOnce(&FactorNetwork, &[[Edge; 2]]) -> Vec<bool>,
    make: impl FnOnce(&mut FactorNetwork) -> Vec<Edge>,
) -> Vec<usize> {
    let targets: Vec<(usize, usize, Edge)> = places
        .iter()
        .enumerate()
        .filter_map(|(index, place)| place.map(|place| (index, place, network.outputs[place])))
        .collect();
    // Before the old equations go, which some elements may want back.
    network.renumber();
    for &(_, _, edge) in &targets {
        network.release(edge);
    }
    // What only the old equations need must not be found again by its value.
    network.forget_unused(&network.order());
    let made = make(network);
    let pairs = targets.iter().map(|&(index, _, old)| [made[index], old]);
    let pairs: Vec<[Edge; 2]> = pairs.collect();
    let equal = equal(network, &pairs);
    let mut kept = Vec::new();
    for ((index, place, old), equal) in targets.into_iter().zip(equal) {
        let chosen = if equal { made[index] } else { old };
        if !equal {
            kept.push(index);
        }
        network.outputs[place] = chosen;
        network.acquire(chosen);
    }
    kept
}

/// Tests pairs of edges for the same value.
fn same_values(network: &FactorNetwork, pairs: &[[Edge; 2]]) -> Vec<bool> {
    let pairs = pairs.iter();
    pairs
        .map(|&[made, old]| network.value(made) == network.value(old))
        .collect()
}

/// For each joint the origin of its equations: the diagonal element of the
/// matrix, or, if that is zero, the first element in its row.
fn origins(
    network: &FactorNetwork,
    model: &ModelInputs,
    function: &Function,
    tables: &mut Tables,
) -> Vec<NodeOrigin> {
    let count = model.len();
    let mut origins = Vec::with_capacity(count);
    for joint in 0..count {
        let row = &model.elements[joint * count..(joint + 1) * count];
        let solved = model.solved.as_ref();
        let place = row[joint]
            .or_else(|| solved.and_then(|solved| solved.places[joint]))
            .or_else(|| row.iter().find_map(|&place| place))
            .or_else(|| model.elements.iter().find_map(|&place| place));
        let Some(place) = place else {
            // Without a single element there is nothing to write.
            origins.push(NodeOrigin::NONE);
            continue;
        };
        let assignment = &function.assignments[place];
        let node = &network.nodes[network.outputs[place].node()];
        let symbol = output_symbol(tables, function, assignment.output);
        origins.push(NodeOrigin {
            name: Name::NONE,
            owner: if node.name.is_none() {
                symbol
            } else {
                node.owner
            },
            sources: tables.sources.union(&[assignment.sources, node.sources]),
        });
    }
    origins
}
