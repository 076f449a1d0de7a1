//! The equations of composite bodies.

use super::bodies::{CompositeInertia, JointAxis, RigidBody, Ring, Stand, UnitWrench};
use super::model::ModelInputs;
use super::tree::JointPlacement;
use crate::factor::network::{Edge, FactorKind, FactorNetwork, NodeOrigin, ZERO};
use robovec_framework::rewrite::output_symbol;
use robovec_ir::{Function, Input, Name, Operand, Operation, Tables};
use robovec_num::arithmetic::Arithmetic;

/// Writes equations as values of a network.
struct EquationWriter<'n> {
    network: &'n mut FactorNetwork,
    /// Whose equations the values stand for.
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
}

impl EquationWriter<'_> {
    fn input(&mut self, input: Option<Input>) -> Edge {
        let Some(input) = input else {
            return self.zero();
        };
        let value = self.network.values.images.input(input);
        self.network.find(value).unwrap_or_else(|| {
            let kind = FactorKind::Input(Operand::from(input));
            self.network.push(kind, Vec::new(), value, NodeOrigin::NONE)
        })
    }

    fn turn(&mut self, operation: Operation, angle: Edge) -> Edge {
        let value = self
            .network
            .values
            .images
            .apply(operation, [self.network.value(angle); 3]);
        self.network.find(value).unwrap_or_else(|| {
            let kind = FactorKind::Other(operation);
            self.network.push(kind, vec![angle], value, self.origin)
        })
    }

    fn stand(&mut self, model: &ModelInputs, joint: usize, place: JointPlacement) -> Stand<Edge> {
        let coordinate = self.input(model.coordinates[joint]);
        let zero = self.zero();
        let (cosine, sine) = match place.joint {
            JointAxis::Revolute(_) => (
                self.turn(Operation::Cos, coordinate),
                self.turn(Operation::Sin, coordinate),
            ),
            JointAxis::Prismatic(_) => (zero, zero),
        };
        Stand {
            joint: place.joint,
            offset: place.point.map_or([zero; 3], |point| {
                model.points[point].map(|part| self.input(part))
            }),
            coordinate,
            cosine,
            sine,
        }
    }

    fn body(&mut self, body: RigidBody<Option<Input>>) -> RigidBody<Edge> {
        RigidBody {
            mass: self.input(body.mass),
            centre: body.centre.map(|part| self.input(part)),
            inertia: body.inertia.map(|row| row.map(|part| self.input(part))),
        }
    }
}

/// Computes the mass matrix of a network from composite bodies instead.
pub(super) fn rebuild(
    network: &mut FactorNetwork,
    model: &ModelInputs,
    places: &[JointPlacement],
    function: &Function,
    tables: &mut Tables,
) {
    let count = model.len();
    // What only the old equations need must not be found again by its value.
    let targets: Vec<(usize, Edge)> = model
        .elements
        .iter()
        .enumerate()
        .filter_map(|(index, place)| place.map(|place| (index, network.outputs[place])))
        .collect();
    let origins = origins(network, model, function, tables);
    for &(_, edge) in &targets {
        network.release(edge);
    }
    network.renumber();
    let mut made = vec![Edge::new(ZERO as u32, false); count * count];
    let mut inertias: Vec<Option<CompositeInertia<Edge>>> = vec![None; count];
    for joint in (0..count).rev() {
        let mut writer = EquationWriter {
            network: &mut *network,
            origin: origins[joint],
        };
        let body = writer.body(model.bodies[joint].mirrored(places[joint].symmetric));
        let own = CompositeInertia::of(&mut writer, &body);
        let inertia = match &inertias[joint] {
            Some(behind) => own.plus(&mut writer, behind),
            None => own,
        };
        let mut wrench: UnitWrench<Edge> = inertia.wrench(places[joint].joint);
        let mut at = joint;
        made[joint * count + joint] = wrench.along(places[joint].joint);
        while let Some(parent) = places[at].parent {
            let stand = writer.stand(model, at, places[at]);
            wrench = stand.wrench(&mut writer, wrench);
            made[joint * count + parent] = wrench.along(places[parent].joint);
            made[parent * count + joint] = made[joint * count + parent];
            at = parent;
        }
        if let Some(parent) = places[joint].parent {
            let stand = writer.stand(model, joint, places[joint]);
            let moved = stand.inertia(&mut writer, &inertia);
            inertias[parent] = Some(match &inertias[parent] {
                Some(others) => others.plus(&mut writer, &moved),
                None => moved,
            });
        }
    }
    for (index, old) in targets {
        // The old equations stay where the tree does not explain them.
        let equal = network.value(made[index]) == network.value(old);
        let chosen = if equal { made[index] } else { old };
        if let Some(place) = model.elements[index] {
            network.outputs[place] = chosen;
        }
        network.acquire(chosen);
    }
}

/// For each joint what its equations stand for: those of the diagonal element
/// of the matrix, or, if that is zero, of the first element in its row.
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
        let place = row[joint]
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
