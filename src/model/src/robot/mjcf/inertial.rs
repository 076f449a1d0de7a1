//! Masses of bodies: of their element `inertial`, or of their geoms.

use super::defaults::MAIN;
use super::settings::InertiaSource;
use super::{Inner, MjcfReader};
use crate::robot::attributes::{number, numbers, place_of};
use crate::robot::inertia::{BodyInertia, LinkInertial};
use crate::rotation::FramePose;
use crate::xml::place;
use roxmltree::Node;

impl<'a> MjcfReader<'a, '_> {
    /// Sets the mass of a link; `inner` are the elements of its body.
    pub(super) fn weigh(&mut self, link: usize, body: Node<'a, 'a>, inner: &[Inner<'a>]) {
        let named = |name: &'static str| {
            let all = inner.iter();
            all.filter(move |inner| inner.node.tag_name().name() == name)
        };
        let inertial = named("inertial").next().copied();
        let source = self.settings.inertia_source;
        let found = match inertial {
            Some(inertial) if source != InertiaSource::Geoms => self.inertial(&inertial),
            _ if source == InertiaSource::Inertial => None,
            _ => {
                let mut sum = BodyInertia::NONE;
                for geom in named("geom") {
                    if let Some(part) = self.geom(geom) {
                        sum = sum.with(&BodyInertia::of_link(&part, &FramePose::HERE));
                    }
                }
                (sum.mass != 0.0).then(|| LinkInertial {
                    mass: sum.mass,
                    origin: FramePose::at(sum.center),
                    inertia: sum.inertia,
                    place: place_of(body, "name"),
                })
            }
        };
        self.robot.links[link].inertial = found.map(|mut inertial| {
            inertial.mass = inertial.mass.max(self.settings.least_mass);
            inertial
        });
    }

    fn inertial(&mut self, inertial: &Inner<'a>) -> Option<LinkInertial> {
        let node = inertial.node;
        let owner = "the `inertial`";
        let pose = inertial.frame.then(&self.pose(node, MAIN));
        let mass = number(node, "mass", owner, self.messages);
        if mass.is_none_or(|mass| mass < 0.0) {
            self.messages.error(
                place_of(node, "mass"),
                "the `inertial` has no mass that is zero or positive",
                "in this element",
                "write `mass=\"…\"`, in kilograms",
            );
        }
        let diagonal = numbers(node, "diaginertia", owner, self.messages);
        let full = numbers(node, "fullinertia", owner, self.messages);
        let inertia = match (diagonal.as_deref(), full.as_deref()) {
            (Some(&[xx, yy, zz]), None) => [xx, 0.0, 0.0, yy, 0.0, zz],
            (None, Some(&[xx, yy, zz, xy, xz, yz])) => [xx, xy, xz, yy, yz, zz],
            (None, None) => [0.0; 6],
            _ => {
                self.messages.error(
                    place(node),
                    "the `inertial` has a wrong number of moments of inertia",
                    "in this element",
                    "write `diaginertia` with three numbers, or `fullinertia` with six: xx yy zz xy \
                     xz yz",
                );
                return None;
            }
        };
        Some(LinkInertial {
            mass: mass?,
            origin: pose,
            inertia,
            place: place(node),
        })
    }

    /// Scales the masses to their total.
    pub(super) fn finish_masses(&mut self) {
        let Some(total) = self.settings.total_mass else {
            return;
        };
        let inertials = self.robot.links.iter_mut();
        let mut all: Vec<&mut LinkInertial> = inertials
            .filter_map(|link| link.inertial.as_mut())
            .collect();
        let sum: f64 = all.iter().map(|inertial| inertial.mass).sum();
        if sum == 0.0 {
            return;
        }
        for inertial in &mut all {
            inertial.mass *= total / sum;
            inertial.inertia = inertial.inertia.map(|moment| moment * (total / sum));
        }
    }
}
