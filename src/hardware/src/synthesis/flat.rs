//! A design without modules: nets and primitives only.
//!
//! Timing paths cross modules, so instances are expanded, each with separate
//! nets; a port joins the net inside with the net outside (a port may also join
//! two nets outside, or a net and a constant, so nets are classes of a
//! union-find). Instances are expanded from a stack, not by recursion.

use super::SynthesisError;
use super::netlist::{Bit, Netlist, NetlistCell, NetlistModule, PortDirection};
use std::collections::BTreeMap;

/// The maximum number of primitives after flattening.
const MAX_CELLS: usize = 8_000_000;

/// A net of the flat design; `None` for a constant or an open end.
pub(super) type Net = Option<u32>;

#[derive(Debug)]
pub(super) struct Primitive<'a> {
    pub(super) cell: &'a NetlistCell,
    /// Its name in its module.
    pub(super) name: &'a str,
    /// The instance it is in, an index into [`Flat::instances`].
    pub(super) instance: u32,
    /// Nets of its ports, in order of their names.
    pub(super) connections: Vec<(&'a str, Vec<Net>)>,
}

impl Primitive<'_> {
    pub(super) fn port(&self, name: &str) -> &[Net] {
        let found = self.connections.iter().find(|(port, _)| *port == name);
        found.map_or(&[], |(_, nets)| nets)
    }
}

#[derive(Debug)]
pub(super) struct Instance<'a> {
    /// Its path below the top, parts separated by dots; empty for the top.
    pub(super) path: String,
    /// The module's name in the netlist.
    pub(super) module: &'a str,
}

#[derive(Debug)]
pub(super) struct Flat<'a> {
    pub(super) primitives: Vec<Primitive<'a>>,
    /// The opened instances, the top first.
    pub(super) instances: Vec<Instance<'a>>,
    pub(super) nets: u32,
    /// Nets of the top's inputs, with the port and bit.
    pub(super) inputs: Vec<(String, u32)>,
    /// Nets of the top's outputs, with the port and bit.
    pub(super) outputs: Vec<(String, u32)>,
}

/// Classes of nets that are joined; class 0 is that of all constants.
struct Classes(Vec<u32>);

impl Classes {
    fn fresh(&mut self) -> u32 {
        let next = self.0.len() as u32;
        self.0.push(next);
        next
    }

    fn find(&mut self, mut net: u32) -> u32 {
        while self.0[net as usize] != net {
            let parent = self.0[net as usize];
            self.0[net as usize] = self.0[parent as usize];
            net = parent;
        }
        net
    }

    /// The lower number represents both, so a constant stays one.
    fn join(&mut self, left: u32, right: u32) {
        let (left, right) = (self.find(left), self.find(right));
        let (low, high) = (left.min(right), left.max(right));
        self.0[high as usize] = low;
        debug_assert_eq!(self.0[0], 0, "class 0 stays that of the constants");
    }
}

/// The nets of one instance, by the numbers of its module.
#[derive(Default)]
struct InstanceNets(BTreeMap<u32, u32>);

impl InstanceNets {
    fn net(&mut self, bit: &Bit, classes: &mut Classes) -> u32 {
        match bit {
            Bit::Net(number) => *self.0.entry(*number).or_insert_with(|| classes.fresh()),
            Bit::Constant(_) => 0,
        }
    }
}

/// Opens all instances below a module, fewer than millions of primitives.
pub(super) fn flatten<'a>(netlist: &'a Netlist, top: &'a str) -> Result<Flat<'a>, SynthesisError> {
    // Refuses designs that contain themselves, so that the stack empties.
    netlist.bottom_up(top)?;
    let mut classes = Classes(vec![0]);
    let mut flat = Flat {
        primitives: Vec::new(),
        instances: Vec::new(),
        nets: 0,
        inputs: Vec::new(),
        outputs: Vec::new(),
    };
    let module = netlist
        .modules
        .get(top)
        .ok_or_else(|| SynthesisError::Netlist(format!("there is no module {top}")))?;
    let mut scope = InstanceNets::default();
    ports(module, &mut scope, &mut classes, &mut flat);
    let mut open = vec![(top, String::new(), scope)];
    while let Some((name, path, mut scope)) = open.pop() {
        let Some(module) = netlist.modules.get(name) else {
            continue;
        };
        let instance = flat.instances.len() as u32;
        let below = if path.is_empty() {
            String::new()
        } else {
            format!("{path}.")
        };
        flat.instances.push(Instance { path, module: name });
        for (cell_name, cell) in &module.cells {
            let mut nets = |bits: &[Bit], classes: &mut Classes| -> Vec<u32> {
                bits.iter().map(|bit| scope.net(bit, classes)).collect()
            };
            if let Some(inside) = netlist.module_of(cell) {
                let mut inner = InstanceNets::default();
                for (port, bits) in &cell.connections {
                    let outside = nets(bits, &mut classes);
                    let Some(declared) = inside.ports.get(port) else {
                        continue;
                    };
                    for (bit, net) in declared.bits.iter().zip(outside) {
                        let within = inner.net(bit, &mut classes);
                        classes.join(within, net);
                    }
                }
                open.push((&cell.kind, format!("{below}{cell_name}"), inner));
                continue;
            }
            if flat.primitives.len() >= MAX_CELLS {
                return Err(SynthesisError::Netlist(format!(
                    "it has more than {MAX_CELLS} primitives"
                )));
            }
            let connections = cell.connections.iter();
            let connections = connections
                .map(|(port, bits)| {
                    let nets = nets(bits, &mut classes);
                    (port.as_str(), nets.into_iter().map(Some).collect())
                })
                .collect();
            flat.primitives.push(Primitive {
                cell,
                name: cell_name,
                instance,
                connections,
            });
        }
    }
    settle(&mut flat, &mut classes);
    Ok(flat)
}

fn ports(
    module: &NetlistModule,
    scope: &mut InstanceNets,
    classes: &mut Classes,
    flat: &mut Flat<'_>,
) {
    for (name, port) in &module.ports {
        for (place, bit) in port.bits.iter().enumerate() {
            let net = scope.net(bit, classes);
            let name = match port.bits.len() {
                1 => name.clone(),
                _ => format!("{name}[{place}]"),
            };
            match port.direction {
                PortDirection::Input => flat.inputs.push((name, net)),
                PortDirection::Output => flat.outputs.push((name, net)),
                PortDirection::Inout => {}
            }
        }
    }
}

/// Numbers the classes one after the other.
fn settle(flat: &mut Flat<'_>, classes: &mut Classes) {
    let mut numbers = vec![u32::MAX; classes.0.len()];
    let mut next = 0;
    let mut settled = |net: u32| -> Net {
        let class = classes.find(net);
        if class == 0 {
            return None;
        }
        let number = &mut numbers[class as usize];
        if *number == u32::MAX {
            *number = next;
            next += 1;
        }
        Some(*number)
    };
    for primitive in &mut flat.primitives {
        for (_, nets) in &mut primitive.connections {
            for net in nets {
                *net = net.and_then(&mut settled);
            }
        }
    }
    for ports in [&mut flat.inputs, &mut flat.outputs] {
        let known = std::mem::take(ports).into_iter();
        *ports = known
            .filter_map(|(name, net)| settled(net).map(|net| (name, net)))
            .collect();
    }
    flat.nets = next;
}
