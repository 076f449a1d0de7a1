//! The sections `compiler` and `option`.

use super::children;
use crate::robot::attributes::{number, numbers, place_of, triple};
use crate::rotation::to_right_angle;
use crate::xml::Messages;
use roxmltree::Node;

/// Source of the inertias of bodies.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum InertiaSource {
    /// The element `inertial`, or else the geoms.
    Either,
    Geoms,
    Inertial,
}

pub(super) struct MjcfSettings {
    pub(super) gravity: [f64; 3],
    /// Radians of a unit of angle.
    unit: f64,
    right_angle: f64,
    /// A range limits a joint without `limited`.
    pub(super) autolimits: bool,
    /// The axes of `euler`, in capitals where they do not move.
    pub(super) sequence: Vec<char>,
    pub(super) inertia_source: InertiaSource,
    /// The groups of geoms that have mass.
    pub(super) groups: [f64; 2],
    /// The least mass of a body that moves.
    pub(super) least_mass: f64,
    /// The mass of the whole model.
    pub(super) total_mass: Option<f64>,
}

impl MjcfSettings {
    pub(super) fn read(root: Node<'_, '_>, right_angle: f64, messages: &mut Messages) -> Self {
        let mut settings = MjcfSettings {
            gravity: [0.0, 0.0, -9.81],
            unit: std::f64::consts::PI / 180.0,
            right_angle,
            autolimits: true,
            sequence: vec!['x', 'y', 'z'],
            inertia_source: InertiaSource::Either,
            groups: [0.0, 5.0],
            least_mass: 0.0,
            total_mass: None,
        };
        for compiler in children(root, "compiler") {
            settings.compiler(compiler, messages);
        }
        for option in children(root, "option") {
            settings.gravity = triple(option, "gravity", "the options", settings.gravity, messages);
            for attribute in ["density", "viscosity"] {
                if number(option, attribute, "the options", messages).is_some_and(|x| x != 0.0) {
                    messages.leave_out(
                        place_of(option, attribute),
                        "forces of a fluid are in no equation",
                        "passed over",
                        "add them to the forces of the joints",
                    );
                }
            }
            let flags = children(option, "flag");
            if flags.last().and_then(|flag| flag.attribute("gravity")) == Some("disable") {
                settings.gravity = [0.0; 3];
            }
        }
        settings
    }

    fn compiler(&mut self, node: Node<'_, '_>, messages: &mut Messages) {
        let owner = "the compiler";
        match node.attribute("angle").map(str::trim) {
            Some("radian") => self.unit = 1.0,
            Some("degree") | None => {}
            Some(_) => messages.error(
                place_of(node, "angle"),
                "an unknown unit of angles",
                "this unit",
                "write degree or radian",
            ),
        }
        if node
            .attribute("coordinate")
            .is_some_and(|text| text.trim() == "global")
        {
            messages.error(
                place_of(node, "coordinate"),
                "global coordinates are not supported",
                "in this model",
                "save the model with a newer MuJoCo, whose coordinates are local",
            );
        }
        if let Some(text) = node.attribute("autolimits") {
            self.autolimits = text.trim() == "true";
        }
        if let Some(text) = node.attribute("eulerseq") {
            let letters: Vec<char> = text.trim().chars().collect();
            if letters.len() == 3 && letters.iter().all(|letter| "xyzXYZ".contains(*letter)) {
                self.sequence = letters;
            } else {
                messages.error(
                    place_of(node, "eulerseq"),
                    "this is no sequence of axes",
                    "three letters are wanted",
                    "write three of x, y and z, in capitals for axes that do not move",
                );
            }
        }
        self.inertia_source = match node.attribute("inertiafromgeom").map(str::trim) {
            Some("true") => InertiaSource::Geoms,
            Some("false") => InertiaSource::Inertial,
            Some("auto") => InertiaSource::Either,
            _ => self.inertia_source,
        };
        if let Some(&[low, high]) = numbers(node, "inertiagrouprange", owner, messages).as_deref() {
            self.groups = [low, high];
        }
        if let Some(least) = number(node, "boundmass", owner, messages) {
            self.least_mass = least;
        }
        if let Some(total) = number(node, "settotalmass", owner, messages) {
            self.total_mass = (total > 0.0).then_some(total);
        }
        let is_bound = number(node, "boundinertia", owner, messages).is_some_and(|x| x > 0.0);
        let is_balanced = node.attribute("balanceinertia") == Some("true");
        for (is_set, attribute) in [(is_bound, "boundinertia"), (is_balanced, "balanceinertia")] {
            if is_set {
                messages.warn(
                    place_of(node, attribute),
                    &format!("`{attribute}` is passed over: inertias are those of the file"),
                    "this setting",
                    "save the model with MuJoCo, which writes the inertias it changed",
                );
            }
        }
    }

    /// An angle of the file, rad.
    pub(super) fn angle(&self, given: f64) -> f64 {
        to_right_angle(given * self.unit, self.right_angle)
    }
}
