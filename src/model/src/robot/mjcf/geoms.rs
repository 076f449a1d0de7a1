//! Masses of geoms: their shape, size and density.

use super::{Inner, MjcfReader};
use crate::robot::attributes::place_of;
use crate::robot::inertia::LinkInertial;
use crate::rotation::{FramePose, add, scaled, unit, upright};
use crate::xml::place;
use robovec_ir::diagnostic::clip;
use std::f64::consts::PI;

/// The density of geoms that give none, kg/m^3.
const DENSITY: f64 = 1000.0;

/// A shape with a volume.
#[derive(Clone, Copy, Debug)]
enum GeomShape {
    /// Half axes; a sphere has three equal ones.
    Ellipsoid([f64; 3]),
    /// Half lengths of the edges.
    Box([f64; 3]),
    /// Radius and half length, along the third axis.
    Cylinder(f64, f64),
    /// Radius, and half length between the half spheres.
    Capsule(f64, f64),
}

impl GeomShape {
    fn volume(self) -> f64 {
        match self {
            GeomShape::Ellipsoid([a, b, c]) => 4.0 / 3.0 * PI * a * b * c,
            GeomShape::Box([a, b, c]) => 8.0 * a * b * c,
            GeomShape::Cylinder(r, h) => 2.0 * PI * r * r * h,
            GeomShape::Capsule(r, h) => PI * r * r * (2.0 * h + 4.0 / 3.0 * r),
        }
    }

    /// The principal moments for a mass.
    fn moments(self, mass: f64) -> [f64; 3] {
        let of_squares = |[a, b, c]: [f64; 3], factor: f64| {
            let pair = |x: f64, y: f64| factor * mass * (x * x + y * y);
            [pair(b, c), pair(a, c), pair(a, b)]
        };
        match self {
            GeomShape::Ellipsoid(axes) => of_squares(axes, 0.2),
            GeomShape::Box(edges) => of_squares(edges, 1.0 / 3.0),
            GeomShape::Cylinder(r, h) => {
                let across = mass * (3.0 * r * r + 4.0 * h * h) / 12.0;
                [across, across, mass * r * r / 2.0]
            }
            GeomShape::Capsule(r, h) => {
                let ends = mass * (4.0 / 3.0 * r) / (2.0 * h + 4.0 / 3.0 * r);
                let [across, _, along] = GeomShape::Cylinder(r, h).moments(mass - ends);
                let sphere = 0.4 * ends * r * r;
                let across = across + sphere + ends * (h * h + 0.75 * h * r);
                [across, across, along + sphere]
            }
        }
    }
}

impl<'a> MjcfReader<'a, '_> {
    /// The mass of a geom, in the frame of its body; `None` for one without.
    pub(super) fn geom(&mut self, geom: &Inner<'a>) -> Option<LinkInertial> {
        let node = geom.node;
        let class = self
            .defaults
            .class(node, "class", geom.class, self.messages);
        let group = self.number(node, class, "group").unwrap_or(0.0);
        let [low, high] = self.settings.groups;
        let mass = self.number(node, class, "mass");
        let density = self.number(node, class, "density").unwrap_or(DENSITY);
        if group < low || group > high || mass.unwrap_or(density) == 0.0 {
            return None;
        }
        let text = |attribute: &str| {
            let holder = self.defaults.holder(node, class, attribute);
            holder
                .and_then(|node| node.attribute(attribute))
                .map(str::trim)
        };
        let (kind, has_mesh) = (text("type").unwrap_or("sphere"), text("mesh").is_some());
        let is_shell = text("shellinertia") == Some("true");
        if matches!(kind, "plane" | "hfield") {
            return None;
        }
        let known = ["sphere", "capsule", "cylinder", "box", "ellipsoid"];
        if has_mesh || is_shell || !known.contains(&kind) {
            let kind = if has_mesh { "mesh" } else { kind };
            self.messages.error(
                place(node),
                &format!(
                    "the mass of a body depends on a geom of type {}",
                    clip(kind)
                ),
                "only solid spheres, capsules, cylinders, boxes and ellipsoids are weighed",
                "give the body an `inertial`: `mj_saveLastXML` of MuJoCo writes it",
            );
            return None;
        }
        let size = self.numbers(node, class, "size").unwrap_or_default();
        let mut pose = geom.frame.then(&self.pose(node, geom.class));
        let mut half = None;
        if let Some(ends) = self.numbers(node, class, "fromto") {
            let &[a, b, c, d, e, f] = ends.as_slice() else {
                self.miscounted(node, "fromto", ends.len(), 6);
                return None;
            };
            let (from, to) = ([a, b, c], [d, e, f]);
            let way = add(from, scaled(to, -1.0));
            let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
            half = Some(length / 2.0);
            pose = geom.frame.then(&FramePose {
                rotation: upright(unit(way)?),
                origin: scaled(add(from, to), 0.5),
            });
        }
        let at = |index: usize| size.get(index).copied();
        let shape = match kind {
            "sphere" => at(0).map(|r| GeomShape::Ellipsoid([r; 3])),
            "capsule" => at(0)
                .zip(half.or(at(1)))
                .map(|(r, h)| GeomShape::Capsule(r, h)),
            "cylinder" => at(0)
                .zip(half.or(at(1)))
                .map(|(r, h)| GeomShape::Cylinder(r, h)),
            _ => {
                let edges = match half {
                    Some(half) => at(0).map(|x| [x, at(1).unwrap_or(x), half]),
                    None => size[..].try_into().ok(),
                };
                edges.map(|edges| match kind {
                    "box" => GeomShape::Box(edges),
                    _ => GeomShape::Ellipsoid(edges),
                })
            }
        };
        let Some(shape) = shape.filter(|shape| shape.volume() > 0.0) else {
            self.messages.error(
                place_of(node, "size"),
                &format!("a geom of type {kind} has no size"),
                "its mass depends on it",
                "write all of its sizes, which are positive",
            );
            return None;
        };
        let mass = mass.unwrap_or(density * shape.volume());
        let [xx, yy, zz] = shape.moments(mass);
        Some(LinkInertial {
            mass,
            origin: pose,
            inertia: [xx, 0.0, 0.0, yy, 0.0, zz],
            place: place(node),
        })
    }
}
