//! Laws of forces and driven motions, as a user gives them beside a model.
//!
//! A model contains no forces: its loads and driven motions, besides gravity,
//! are in a small TOML file.
//!
//! ```toml
//! [[joint]]
//! name = "knee"        # or "*": every joint without an entry; in
//!                      # place of damping and friction that a robot's file has
//! stiffness = 200.0    # N/m or N m/rad
//! damping = 2.0        # N s/m or N m s/rad
//! neutral = 0.1        # where the spring is slack; default: initial position
//! force = 0.0          # constant, N or N m
//! friction = 0.0       # dry friction, N or N m, turned over at velocities
//! slip = 0.01          # around this one, m/s or rad/s; links alike
//!
//! [[link]]
//! name = "strut"       # or "*"
//! stiffness = 2e4
//! damping = 1e3
//! neutral = 0.35       # free length, m; default: initial length
//! force = 0.0          # constant pull, N
//!
//! [[force]]
//! name = "tyre"        # an external force of the model, or "*"; all along the
//! force = [0, 0, 3e3]  # axes of the base: constant, N
//! torque = [0, 0, 0]   # constant, N m
//! stiffness = [0, 0, 2e5]  # against the way from the initial place, N/m
//! damping = [0, 0, 5e2]    # against the velocity, N s/m
//! place = [1.2, 0, 0.3]    # where the springs hold it; default: initial place
//! amplitude = [0, 0, 0.01] # that place moves: amplitude sin(frequency t + phase), m
//! frequency = 6.28         # rad/s
//! phase = 0.0              # rad
//!
//! [[contact]]
//! name = "tyre"        # the point of an external force, or "*", and a plane:
//! place = [0, 0, 0]    # a point of it, m
//! normal = [0, 0, 1]   # out of the ground, of any length
//! stiffness = 2e5      # against the way into the ground, N/m
//! damping = 5e2        # against the velocity there, N s/m; it never pulls
//! friction = 0.7       # share of the pressure that acts against slip
//! slip = 0.01          # velocity around which friction turns over, m/s
//!
//! [[event]]
//! name = "knee"        # a joint, or an external force with a contact
//! quantity = "position"    # "velocity", or "gap" of the contact
//! value = 0.0          # that it passes
//! direction = "both"   # "rising" or "falling"
//! stop = false         # true: the run ends there
//!
//! [[driven]]
//! name = "steering"    # position = offset + amplitude sin(frequency t + phase)
//! offset = 0.0         # default: initial position
//! amplitude = 0.05
//! frequency = 6.28     # rad/s
//! phase = 0.0          # rad
//! ```

use super::contact::{Contact, friction_share, turning_velocity};
use super::event_law::{EventLaw, EventQuantity};
use robovec_ir::diagnostic::{Diagnostic, Label, clip, did_you_mean};
use robovec_ir::document::{self, DocumentError};
use robovec_model::{Model, Nature};
use robovec_num::limits::{Amount, NumberLimit};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;

/// Numbers of laws, in SI units.
const LAW: NumberLimit = NumberLimit::real(
    -1e15,
    1e15,
    "binary64 has no digits left for such stiff motions",
);

/// Amounts of friction: it takes energy and gives none.
const FRICTION: NumberLimit = NumberLimit::real(
    0.0,
    1e15,
    "binary64 has no digits left for such stiff motions, and friction gives no energy",
);
/// Velocities around which friction turns over.
const SLIP: NumberLimit = NumberLimit::real(
    1e-9,
    1e6,
    "friction that changes sign faster is a jump for an integrator",
);

/// The limits of the numbers of laws: name, limit, and the default.
pub const FIELDS: &[(&str, NumberLimit, &str)] = &[
    ("stiffness", LAW, "0"),
    ("damping", LAW, "0"),
    ("neutral", LAW, "initial"),
    ("force", LAW, "0"),
    ("friction", FRICTION, "0"),
    ("slip", SLIP, "0.01"),
    ("normal", LAW, "[0, 0, 1]"),
    ("value", LAW, "0"),
    ("torque", LAW, "0"),
    ("place", LAW, "initial"),
    ("offset", LAW, "initial"),
    ("amplitude", LAW, "0"),
    ("frequency", LAW, "0"),
    ("phase", LAW, "0"),
];

/// A linear spring and damper with a constant force. On a joint it acts
/// against displacement and velocity; on a link it pulls the ends together.
#[derive(Clone, Copy, PartialEq, Default, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Spring {
    /// Force per displacement.
    pub stiffness: f64,
    /// Force per velocity.
    pub damping: f64,
    /// Position, or length, without force of the spring; `None`: the initial
    /// one.
    pub neutral: Option<f64>,
    /// A constant force: in the direction of the joint, or as a pull.
    pub force: f64,
    /// Dry friction: its largest force.
    pub friction: f64,
    /// The velocity around which friction turns over; `None`:
    /// [`SLIP_VELOCITY`](super::contact::SLIP_VELOCITY).
    pub slip: Option<f64>,
}

/// An external force on a point, along the axes of the base: constant, and
/// springs and dampers between the point and a place, at rest or moving.
#[derive(Clone, Copy, PartialEq, Default, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Support {
    /// Support force, N.
    pub force: [f64; 3],
    /// Support torque, N m.
    pub torque: [f64; 3],
    /// Force per displacement, N/m.
    pub stiffness: [f64; 3],
    /// Force per velocity, N s/m.
    pub damping: [f64; 3],
    /// Position at which the springs hold the point, m; `None`: its initial
    /// position.
    pub place: Option<[f64; 3]>,
    /// Amplitude of the place's motion to both sides, m: a road, a rail, a
    /// shaker.
    pub amplitude: [f64; 3],
    /// The angular frequency of its motion, rad/s.
    pub frequency: f64,
    /// Its phase, rad.
    pub phase: f64,
    /// Of the point with a plane; its own section in a file.
    #[serde(skip)]
    pub contact: Contact,
}

impl Spring {
    /// True where it can give a force.
    pub fn acts(&self) -> bool {
        let parts = [self.stiffness, self.damping, self.force, self.friction];
        parts.iter().any(|&part| part != 0.0)
    }

    /// Position, or length, without force of a spring that starts somewhere.
    pub(super) fn neutral_or(&self, start: f64) -> f64 {
        self.neutral.unwrap_or(start)
    }

    /// The derivative of the dry friction by the velocity.
    pub fn dry_slope(&self, velocity: f64) -> f64 {
        let slip = turning_velocity(self.slip);
        let speed = velocity.hypot(slip);
        self.friction * (slip / speed) * (slip / speed) / speed
    }

    /// The dry friction at a velocity, against it.
    pub fn dry(&self, velocity: f64) -> f64 {
        self.friction * friction_share(velocity, self.slip)
    }
}

impl Support {
    /// True where it can give a force or a torque.
    pub fn acts(&self) -> bool {
        let parts = [self.force, self.torque, self.stiffness, self.damping];
        self.contact.acts() || parts.concat().iter().any(|&number| number != 0.0)
    }

    /// Distance of the place from its mean at a time, m, and its velocity, m/s.
    pub fn ground(&self, time: f64) -> [[f64; 3]; 2] {
        let (sine, cosine) = (self.frequency * time + self.phase).sin_cos();
        let rate = self.frequency * cosine;
        [
            self.amplitude.map(|length| length * sine),
            self.amplitude.map(|length| length * rate),
        ]
    }
}

/// The motion of a driven joint.
#[derive(Clone, Copy, PartialEq, Default, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Drive {
    /// Mean position; `None`: the initial one.
    pub offset: Option<f64>,
    /// Amplitude.
    pub amplitude: f64,
    /// Angular frequency, rad/s.
    pub frequency: f64,
    /// Phase, rad.
    pub phase: f64,
}

impl Drive {
    /// Position, velocity and acceleration at a time, around an initial
    /// position.
    pub fn at(&self, time: f64, initial: f64) -> [f64; 3] {
        let (sine, cosine) = (self.frequency * time + self.phase).sin_cos();
        let (a, w) = (self.amplitude, self.frequency);
        [
            self.offset.unwrap_or(initial) + a * sine,
            a * w * cosine,
            -a * w * w * sine,
        ]
    }
}

/// The laws of a model's joints and links.
#[derive(Clone, PartialEq, Debug)]
pub struct Laws {
    /// One for each joint.
    pub joints: Vec<Spring>,
    /// One for each link.
    pub links: Vec<Spring>,
    /// One for each external force.
    pub forces: Vec<Support>,
    /// One for each joint; only those of driven joints count.
    pub drives: Vec<Drive>,
    /// Events that a run watches for.
    pub events: Vec<EventLaw>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct LawsFile {
    joint: Vec<toml::Table>,
    link: Vec<toml::Table>,
    force: Vec<toml::Table>,
    contact: Vec<toml::Table>,
    event: Vec<toml::Table>,
    driven: Vec<toml::Table>,
}

/// The same file once more, for the places of names.
#[derive(Deserialize, Default)]
#[serde(default)]
struct LawNames {
    joint: Vec<Named>,
    link: Vec<Named>,
    force: Vec<Named>,
    contact: Vec<Named>,
    event: Vec<Named>,
    driven: Vec<Named>,
}

#[derive(Deserialize)]
struct Named {
    name: Spanned<String>,
}

impl Laws {
    /// Laws of the model itself: the losses of its joints, and driven joints at
    /// rest. An entry of a file for a joint replaces its losses.
    pub fn of_model(model: &Model) -> Laws {
        let losses = model.joints.iter().map(|joint| Spring {
            damping: joint.losses.damping,
            friction: joint.losses.friction,
            ..Spring::default()
        });
        Laws {
            joints: losses.collect(),
            links: vec![Spring::default(); model.links.len()],
            forces: vec![Support::default(); model.forces.len()],
            drives: vec![Drive::default(); model.joints.len()],
            events: Vec::new(),
        }
    }

    /// The laws with all places and joints that they move fixed at their means,
    /// as for an equilibrium.
    pub fn at_rest(mut self) -> Laws {
        for law in &mut self.forces {
            law.amplitude = [0.0; 3];
        }
        for law in &mut self.drives {
            law.amplitude = 0.0;
        }
        self
    }

    /// Reads the laws of a model.
    ///
    /// # Errors
    ///
    /// Messages that point into the text (file 0): text that is no TOML or no
    /// law, a name that the model does not have or that occurs twice, a number
    /// beyond its limit, a driven motion of a joint that is not driven or whose
    /// equations contain no velocity.
    pub fn parse(model: &Model, text: &str) -> Result<Laws, Vec<Diagnostic>> {
        let file: LawsFile = document::read(text).map_err(|error| vec![syntax(error)])?;
        let names: LawNames = document::read(text).map_err(|error| vec![syntax(error)])?;
        let mut laws = Laws::of_model(model);
        let mut errors = Vec::new();
        let joints: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
        let links: Vec<&str> = model.links.iter().map(|l| l.name.as_str()).collect();
        let forces: Vec<&str> = model.forces.iter().map(|f| f.name.as_str()).collect();
        let mut read = LawReader {
            errors: &mut errors,
        };
        read.section(
            "joint",
            &file.joint,
            &names.joint,
            &joints,
            &mut laws.joints,
        );
        read.section("link", &file.link, &names.link, &links, &mut laws.links);
        read.section(
            "external force",
            &file.force,
            &names.force,
            &forces,
            &mut laws.forces,
        );
        let mut contacts = vec![Contact::default(); model.forces.len()];
        read.section(
            "external force",
            &file.contact,
            &names.contact,
            &forces,
            &mut contacts,
        );
        for (law, contact) in laws.forces.iter_mut().zip(contacts) {
            law.contact = contact;
        }
        for (entry, Named { name }) in file.contact.iter().zip(&names.contact) {
            let normal = entry.get("normal").and_then(toml::Value::as_array);
            if normal.is_some_and(|normal| is_zero(normal)) {
                let message = "the normal of a plane has a direction";
                read.errors.push(wrong(name.span(), message, None));
            }
        }
        laws.events = read.events(&file.event, &names.event, [&joints, &forces]);
        let driven = read.section(
            "joint",
            &file.driven,
            &names.driven,
            &joints,
            &mut laws.drives,
        );
        for (joint, span) in driven {
            let joint = &model.joints[joint];
            let reason = if joint.nature != Nature::Driven {
                format!("the joint '{}' is not driven", clip(&joint.name))
            } else if !joint.has_velocity || !joint.has_acceleration {
                format!(
                    "the equations of '{}' keep it at rest: the model gives its velocity no symbol",
                    clip(&joint.name)
                )
            } else {
                continue;
            };
            errors.push(wrong(span, &reason, None));
        }
        if errors.is_empty() {
            Ok(laws)
        } else {
            errors.truncate(20);
            Err(errors)
        }
    }
}

/// Tests whether all numbers of a list are zero.
fn is_zero(list: &[toml::Value]) -> bool {
    let amount = |value: &toml::Value| {
        value
            .as_float()
            .or(value.as_integer().map(|number| number as f64))
    };
    list.iter().all(|value| amount(value) == Some(0.0))
}

struct LawReader<'e> {
    errors: &'e mut Vec<Diagnostic>,
}

type NameRange = std::ops::Range<usize>;

impl LawReader<'_> {
    /// Reads the entries of a section into the laws of the named items; returns
    /// the indices with their places in the text.
    fn section<T: DeserializeOwned + Copy>(
        &mut self,
        what: &str,
        entries: &[toml::Table],
        names: &[Named],
        known: &[&str],
        laws: &mut [T],
    ) -> Vec<(usize, NameRange)> {
        let mut general = None;
        let mut found: Vec<(usize, NameRange)> = Vec::new();
        for (entry, Named { name }) in entries.iter().zip(names) {
            let span = name.span();
            let Some(law) = self.entry::<T>(entry, &span) else {
                continue;
            };
            if name.get_ref() == "*" {
                general = Some(law);
                continue;
            }
            let Some(index) = self.index(what, name, known) else {
                continue;
            };
            let name = name.get_ref().as_str();
            if found.iter().any(|&(other, _)| other == index) {
                let message = format!("'{}' has a law already", clip(name));
                self.errors.push(wrong(span, &message, None));
                continue;
            }
            laws[index] = law;
            found.push((index, span));
        }
        if let Some(general) = general {
            for (index, law) in laws.iter_mut().enumerate() {
                if !found.iter().any(|&(named, _)| named == index) {
                    *law = general;
                }
            }
        }
        found
    }

    /// The law of an entry, without its name.
    fn entry<T: DeserializeOwned>(&mut self, entry: &toml::Table, span: &NameRange) -> Option<T> {
        let mut entry = entry.clone();
        entry.remove("name");
        if let Some(reason) = refused(&entry) {
            self.errors.push(wrong(span.clone(), &reason, None));
        }
        match entry.try_into() {
            Ok(law) => Some(law),
            Err(error) => {
                let error: toml::de::Error = error;
                self.errors.push(wrong(span.clone(), error.message(), None));
                None
            }
        }
    }

    /// The place of a name among those that are known.
    fn index(&mut self, what: &str, name: &Spanned<String>, known: &[&str]) -> Option<usize> {
        let text = name.get_ref().as_str();
        let found = known.iter().position(|known| *known == text);
        if found.is_none() {
            let note = did_you_mean(text, known.iter().copied())
                .map(|near| format!("did you mean '{near}'?"));
            let message = format!("the model has no {what} '{}'", clip(text));
            self.errors.push(wrong(name.span(), &message, note));
        }
        found
    }

    /// Reads events of joints and of external forces.
    fn events(
        &mut self,
        entries: &[toml::Table],
        names: &[Named],
        [joints, forces]: [&[&str]; 2],
    ) -> Vec<EventLaw> {
        let mut events = Vec::new();
        for (entry, Named { name }) in entries.iter().zip(names) {
            let Some(mut event) = self.entry::<EventLaw>(entry, &name.span()) else {
                continue;
            };
            let subject = match event.quantity {
                EventQuantity::Gap => self.index("external force", name, forces),
                EventQuantity::Position | EventQuantity::Velocity => {
                    self.index("joint", name, joints)
                }
            };
            if let Some(subject) = subject {
                event.subject = subject;
                events.push(event);
            }
        }
        events
    }
}

/// The fault in a number of an entry, if any.
fn refused(entry: &toml::Table) -> Option<String> {
    entry.iter().find_map(|(key, value)| {
        let numbers = match value {
            toml::Value::Array(list) => list.as_slice(),
            _ => std::slice::from_ref(value),
        };
        let amounts = numbers.iter().filter_map(|value| match value {
            toml::Value::Integer(number) => Some(*number as f64),
            toml::Value::Float(number) => Some(*number),
            _ => None,
        });
        let field = FIELDS.iter().find(|(name, ..)| name == key);
        let limit = field.map_or(LAW, |(_, limit, _)| *limit);
        let mut refusals = amounts.filter_map(|number| limit.check(Amount::Real(number)).err());
        refusals
            .next()
            .map(|reason| format!("'{}': {reason}", clip(key)))
    })
}

fn syntax(error: DocumentError) -> Diagnostic {
    let span = error.span.unwrap_or(0..0);
    let note = "see the manual of `robovec sim` for the sections [[joint]], [[link]], [[force]], [[contact]], [[driven]] and [[event]]";
    wrong(span, &error.message, Some(note.to_owned()))
}

fn wrong(span: NameRange, message: &str, note: Option<String>) -> Diagnostic {
    Diagnostic::error()
        .with_message(message)
        .with_labels(vec![Label::primary(0, span)])
        .with_notes(note.into_iter().collect())
}
