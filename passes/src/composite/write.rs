//! The equations of composite bodies.

use super::bodies::{Body, Inertia, Joint, Ring, Stand, Wrench};
use super::model::Model;
use super::tree::Place;
use crate::factor::network::{Edge, Kind, Network, Origin, ZERO};
use robovec_framework::rewrite::output_symbol;
use robovec_ir::{Function, Input, Name, Operand, Operation, Tables};
use robovec_num::arithmetic::Arithmetic;

/// Writes equations as values of a network.
struct Writer<'n> {
    network: &'n mut Network,
    /// Whose equations the values stand for.
    origin: Origin,
}

impl Ring for Writer<'_> {
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

impl Writer<'_> {
    fn input(&mut self, input: Option<Input>) -> Edge {
        let Some(input) = input else {
            return self.zero();
        };
        let value = self.network.images.input(input);
        self.network.find(value).unwrap_or_else(|| {
            let kind = Kind::Input(Operand::from(input));
            self.network.push(kind, Vec::new(), value, Origin::NONE)
        })
    }

    fn turn(&mut self, operation: Operation, angle: Edge) -> Edge {
        let value = self
            .network
            .images
            .apply(operation, [self.network.value(angle); 3]);
        self.network.find(value).unwrap_or_else(|| {
            let kind = Kind::Other(operation);
            self.network.push(kind, vec![angle], value, self.origin)
        })
    }

    fn stand(&mut self, model: &Model, joint: usize, place: Place) -> Stand<Edge> {
        let coordinate = self.input(model.coordinates[joint]);
        let zero = self.zero();
        let (cosine, sine) = match place.joint {
            Joint::Revolute(_) => (
                self.turn(Operation::Cos, coordinate),
                self.turn(Operation::Sin, coordinate),
            ),
            Joint::Prismatic(_) => (zero, zero),
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

    fn body(&mut self, body: Body<Option<Input>>) -> Body<Edge> {
        Body {
            mass: self.input(body.mass),
            centre: body.centre.map(|part| self.input(part)),
            inertia: body.inertia.map(|row| row.map(|part| self.input(part))),
        }
    }
}

/// Computes the mass matrix of a network from composite bodies instead.
pub(super) fn rebuild(
    network: &mut Network,
    model: &Model,
    places: &[Place],
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
    let mut inertias: Vec<Option<Inertia<Edge>>> = vec![None; count];
    for joint in (0..count).rev() {
        let mut writer = Writer {
            network: &mut *network,
            origin: origins[joint],
        };
        let body = writer.body(model.bodies[joint].mirrored(places[joint].symmetric));
        let own = Inertia::of(&mut writer, &body);
        let inertia = match &inertias[joint] {
            Some(behind) => own.plus(&mut writer, behind),
            None => own,
        };
        let mut wrench: Wrench<Edge> = inertia.wrench(places[joint].joint);
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
    network: &Network,
    model: &Model,
    function: &Function,
    tables: &mut Tables,
) -> Vec<Origin> {
    let count = model.len();
    let mut origins = Vec::with_capacity(count);
    for joint in 0..count {
        let row = &model.elements[joint * count..(joint + 1) * count];
        let place = row[joint]
            .or_else(|| row.iter().find_map(|&place| place))
            .or_else(|| model.elements.iter().find_map(|&place| place));
        let Some(place) = place else {
            // Without a single element there is nothing to write.
            origins.push(Origin::NONE);
            continue;
        };
        let assignment = &function.assignments[place];
        let node = &network.nodes[network.outputs[place].node()];
        let symbol = output_symbol(tables, function, assignment.output);
        origins.push(Origin {
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
