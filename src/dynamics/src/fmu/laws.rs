//! Laws of forces as parameters of an FMU, in the order of `laws.c`.

use super::variables::{AXES, FmuVariables, VariableRole, quoted};
use crate::motion::{
    Contact, Drive, Laws, ROLLING_VELOCITY, SlipLaw, Spring, Support, contact::SLIP_VELOCITY,
};

/// First places of the parameters of each law; zero where there is none.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub(super) struct LawParameters {
    pub(super) joints: Vec<u32>,
    pub(super) links: Vec<u32>,
    pub(super) forces: Vec<u32>,
    pub(super) ground: Vec<u32>,
    pub(super) tyres: Vec<u32>,
    pub(super) drives: Vec<u32>,
}

/// A number or a vector of a law: its name, values and unit.
type LawField<'a> = (&'a str, &'a [f64], &'static str);

impl FmuVariables<'_> {
    /// Adds the parameters of laws whose places are all given
    /// ([`crate::motion::MultibodySystem::settled_laws`]). `prescribed` are the
    /// driven joints that a law moves, from 0, ascending.
    pub(super) fn add_laws(&mut self, laws: &Laws, prescribed: &[usize]) {
        let model = self.model;
        for (joint, law) in model.joints.iter().zip(&laws.joints) {
            let name = format!("joint.{}", quoted(&joint.name));
            let slot = self.spring(&name, law, joint.kind.is_revolute());
            self.laws.joints.push(slot);
        }
        for (link, law) in model.links.iter().zip(&laws.links) {
            let slot = self.spring(&format!("link.{}", quoted(&link.name)), law, false);
            self.laws.links.push(slot);
        }
        for (force, law) in model.forces.iter().zip(&laws.forces) {
            self.support(&quoted(&force.name), law);
        }
        for (index, (joint, law)) in model.joints.iter().zip(&laws.drives).enumerate() {
            let slot = match prescribed.binary_search(&index) {
                Ok(_) => self.drive(&quoted(&joint.name), law, joint.kind.is_revolute()),
                Err(_) => 0,
            };
            self.laws.drives.push(slot);
        }
    }

    fn law(&mut self, name: &str, fields: &[LawField<'_>]) -> u32 {
        let first = self.list.len() as u32;
        for &(field, numbers, unit) in fields {
            for (place, &number) in numbers.iter().enumerate() {
                let component = match numbers.len() {
                    1 => String::new(),
                    _ => format!(".{}", AXES[place]),
                };
                let name = format!("law.{name}.{field}{component}");
                self.add(&name, VariableRole::Parameter, unit, number);
            }
        }
        first
    }

    fn spring(&mut self, name: &str, law: &Spring, turns: bool) -> u32 {
        if !law.acts() {
            return 0;
        }
        let [stiffness, damping, place, force, rate] = if turns {
            ["N.m/rad", "N.m.s/rad", "rad", "N.m", "rad/s"]
        } else {
            ["N/m", "N.s/m", "m", "N", "m/s"]
        };
        let neutral = law.neutral.expect("the laws are settled");
        let fields: [LawField<'_>; 6] = [
            ("stiffness", &[law.stiffness], stiffness),
            ("damping", &[law.damping], damping),
            ("neutral", &[neutral], place),
            ("force", &[law.force], force),
            ("friction", &[law.friction], force),
            ("slip", &[law.slip.unwrap_or(SLIP_VELOCITY)], rate),
        ];
        self.law(name, &fields)
    }

    fn support(&mut self, name: &str, law: &Support) {
        let mut slots = [0; 3];
        let alone = Support {
            contact: Contact::default(),
            tyre: None,
            ..*law
        };
        if alone.acts() {
            let place = law.place.expect("the laws are settled");
            let fields: [LawField<'_>; 8] = [
                ("force", &law.force, "N"),
                ("torque", &law.torque, "N.m"),
                ("stiffness", &law.stiffness, "N/m"),
                ("damping", &law.damping, "N.s/m"),
                ("place", &place, "m"),
                ("amplitude", &law.amplitude, "m"),
                ("frequency", &[law.frequency], "rad/s"),
                ("phase", &[law.phase], "rad"),
            ];
            slots[0] = self.law(&format!("force.{name}"), &fields);
        }
        if law.meets_ground() {
            self.show_gap(self.laws.ground.len(), &format!("gap.{name}"));
            let contact = law.tyre.map_or(law.contact, |tyre| tyre.contact);
            let section = if law.tyre.is_some() {
                "tyre"
            } else {
                "contact"
            };
            let fields: [LawField<'_>; 6] = [
                ("place", &contact.place, "m"),
                ("normal", &contact.normal, "1"),
                ("stiffness", &[contact.stiffness], "N/m"),
                ("damping", &[contact.damping], "N.s/m"),
                ("friction", &[contact.friction], "1"),
                ("slip", &[contact.slip.unwrap_or(SLIP_VELOCITY)], "m/s"),
            ];
            // A tyre has one friction and one slip, below.
            slots[1] = self.law(&format!("{section}.{name}"), &fields[..4]);
            if law.tyre.is_none() {
                self.law(&format!("{section}.{name}"), &fields[4..]);
            }
        }
        if let Some(tyre) = &law.tyre {
            let name = format!("tyre.{name}");
            let fields: [LawField<'_>; 3] = [
                ("radius", &[tyre.radius], "m"),
                ("axis", &tyre.axis, "1"),
                ("slip", &[tyre.slip.unwrap_or(ROLLING_VELOCITY)], "m/s"),
            ];
            slots[2] = self.law(&name, &fields);
            self.slip_law(&name, &tyre.law);
        }
        self.laws.forces.push(slots[0]);
        self.laws.ground.push(slots[1]);
        self.laws.tyres.push(slots[2]);
    }

    /// The kind of a law of slip, then its numbers.
    fn slip_law(&mut self, name: &str, law: &SlipLaw) {
        match law {
            SlipLaw::Linear {
                friction,
                longitudinal,
                lateral,
            } => {
                self.add("", VariableRole::Hidden, "", 0.0);
                let fields: [LawField<'_>; 3] = [
                    ("friction", &[*friction], "1"),
                    ("longitudinal", &[*longitudinal], "N"),
                    ("lateral", &[*lateral], "N"),
                ];
                self.law(name, &fields);
            }
            SlipLaw::Bakker {
                longitudinal,
                lateral,
            } => {
                self.add("", VariableRole::Hidden, "", 1.0);
                for (word, curve) in [("longitudinal", longitudinal), ("lateral", lateral)] {
                    let fields: [LawField<'_>; 4] = [
                        ("B", &[curve.stiffness], "1"),
                        ("C", &[curve.shape], "1"),
                        ("D", &[curve.peak], "1"),
                        ("E", &[curve.curvature], "1"),
                    ];
                    self.law(&format!("{name}.{word}"), &fields);
                }
            }
        }
    }

    fn drive(&mut self, name: &str, law: &Drive, turns: bool) -> u32 {
        let unit = if turns { "rad" } else { "m" };
        let fields: [LawField<'_>; 4] = [
            ("offset", &[law.offset.expect("the laws are settled")], unit),
            ("amplitude", &[law.amplitude], unit),
            ("frequency", &[law.frequency], "rad/s"),
            ("phase", &[law.phase], "rad"),
        ];
        self.law(&format!("driven.{name}"), &fields)
    }
}
