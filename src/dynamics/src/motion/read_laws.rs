//! Laws from the text of a file, and as such text.

use super::contact::Contact;
use super::energy;
use super::events::{EventLaw, EventQuantity};
use super::laws::{FIELDS, LAW, Laws, Support};
use super::tyre::Tyre;
use crate::kinematics::MotionState;
use robovec_ir::diagnostic::{Diagnostic, Label, clip, did_you_mean};
use robovec_ir::document::{self, DocumentError};
use robovec_model::{Model, Nature};
use robovec_num::limits::Amount;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use toml::{Spanned, Table, Value};

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct LawsFile {
    joint: Vec<LawEntry>,
    link: Vec<LawEntry>,
    force: Vec<LawEntry>,
    contact: Vec<LawEntry>,
    tyre: Vec<LawEntry>,
    event: Vec<LawEntry>,
    driven: Vec<LawEntry>,
}

#[derive(Deserialize)]
#[serde(expecting = "a map")]
struct LawEntry {
    name: Spanned<String>,
    #[serde(flatten)]
    law: toml::Table,
}

impl Laws {
    /// Reads the laws of a model.
    ///
    /// # Errors
    ///
    /// Messages that point into the text (file 0): text that is no TOML or no
    /// law, a name that the model does not have or that occurs twice, a number
    /// beyond its limit, a driven motion of other joints or without velocity.
    pub fn parse(model: &Model, text: &str) -> Result<Laws, Vec<Diagnostic>> {
        let file: LawsFile = document::read(text).map_err(|error| vec![syntax(error)])?;
        let mut laws = Laws::of_model(model);
        let mut errors = Vec::new();
        let joints: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
        let links: Vec<&str> = model.links.iter().map(|l| l.name.as_str()).collect();
        let forces: Vec<&str> = model.forces.iter().map(|f| f.name.as_str()).collect();
        let mut read = LawReader {
            errors: &mut errors,
        };
        read.section("joint", &file.joint, &joints, &mut laws.joints);
        read.section("link", &file.link, &links, &mut laws.links);
        read.section("external force", &file.force, &forces, &mut laws.forces);
        read.ground(model, &forces, &file, &mut laws.forces);
        laws.events = read.events(&file.event, [&joints, &forces]);
        let driven = read.section("joint", &file.driven, &joints, &mut laws.drives);
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

struct LawReader<'e> {
    errors: &'e mut Vec<Diagnostic>,
}

type NameRange = std::ops::Range<usize>;

impl LawReader<'_> {
    /// Reads the entries of a section into `laws`, `"*"` into those without an
    /// own one; returns index and place in the text of every name.
    fn section<T: DeserializeOwned + Copy>(
        &mut self,
        what: &str,
        entries: &[LawEntry],
        known: &[&str],
        laws: &mut [T],
    ) -> Vec<(usize, NameRange)> {
        let mut general = None;
        let mut found: Vec<(usize, NameRange)> = Vec::new();
        for entry in entries {
            let (name, span) = (&entry.name, entry.name.span());
            let Some(law) = self.entry::<T>(entry) else {
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

    fn entry<T: DeserializeOwned>(&mut self, entry: &LawEntry) -> Option<T> {
        let mut add = |reason: &str| self.errors.push(wrong(entry.name.span(), reason, None));
        if let Some(reason) = refused(&entry.law) {
            add(&reason);
        }
        let law = entry.law.clone().try_into();
        law.map_err(|error: toml::de::Error| add(error.message()))
            .ok()
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

    /// Reads the contacts and tyres of external forces. An entry with a name
    /// has priority over `"*"` of the other kind.
    fn ground(&mut self, model: &Model, forces: &[&str], file: &LawsFile, laws: &mut [Support]) {
        let what = "external force";
        let mut contacts: Vec<Option<Contact>> = vec![None; forces.len()];
        let mut tyres: Vec<Option<Tyre>> = vec![None; forces.len()];
        self.section(what, &file.contact, forces, &mut contacts);
        self.section(what, &file.tyre, forces, &mut tyres);
        self.directions("normal", "the normal of a plane", &file.contact);
        self.directions("normal", "the normal of a plane", &file.tyre);
        self.directions("axis", "the axis of a wheel", &file.tyre);
        if !self.errors.is_empty() {
            return;
        }
        for (index, law) in laws.iter_mut().enumerate() {
            let name = forces[index];
            let named = [&file.contact, &file.tyre]
                .map(|entries| entries.iter().any(|one| one.name.get_ref() == name));
            let (mut contact, mut tyre) = (contacts[index], tyres[index]);
            if contact.is_some() && tyre.is_some() {
                match named {
                    [true, false] => tyre = None,
                    [false, true] => contact = None,
                    _ => {
                        let message = format!("'{}' has a contact already", clip(name));
                        let note = "a tyre includes the contact of its wheel".to_owned();
                        let span = span_of(&file.tyre, name);
                        self.errors.push(wrong(span, &message, Some(note)));
                    }
                }
            }
            law.contact = contact.unwrap_or_default();
            law.tyre = tyre;
        }
        self.upright(model, &file.tyre, laws);
    }

    /// Refuses directions of no length.
    fn directions(&mut self, key: &str, what: &str, entries: &[LawEntry]) {
        for entry in entries {
            let direction = entry.law.get(key);
            if direction.is_some_and(|value| value.is_array() && is_zero(value)) {
                let message = format!("{what} is zero: it has no direction");
                self.errors.push(wrong(entry.name.span(), &message, None));
            }
        }
    }

    /// Refuses tyres of wheels that lie flat at the initial positions.
    fn upright(&mut self, model: &Model, entries: &[LawEntry], laws: &[Support]) {
        if laws.iter().all(|law| law.tyre.is_none()) {
            return;
        }
        let motions = energy::point_motions(model, &MotionState::initial(model));
        for (index, (law, motion)) in laws.iter().zip(&motions).enumerate() {
            if law.tyre.is_some_and(|tyre| tyre.lies_flat(motion)) {
                let name = &model.forces[index].name;
                let message = format!(
                    "the wheel of '{}' lies flat: its axis is parallel to the normal",
                    clip(name)
                );
                let note = "`axis` is in the frame of the body of the force".to_owned();
                let span = span_of(entries, name);
                self.errors.push(wrong(span, &message, Some(note)));
            }
        }
    }

    /// Reads events of joints and of external forces.
    fn events(&mut self, entries: &[LawEntry], [joints, forces]: [&[&str]; 2]) -> Vec<EventLaw> {
        let mut events = Vec::new();
        for entry in entries {
            let Some(mut event) = self.entry::<EventLaw>(entry) else {
                continue;
            };
            let subject = match event.quantity {
                EventQuantity::Gap => self.index("external force", &entry.name, forces),
                EventQuantity::Position | EventQuantity::Velocity => {
                    self.index("joint", &entry.name, joints)
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

/// The place of the entry for a name: its own, or that of all.
fn span_of(entries: &[LawEntry], name: &str) -> NameRange {
    let entry = |wanted: &str| entries.iter().find(|one| one.name.get_ref() == wanted);
    let entry = entry(name).or_else(|| entry("*"));
    entry.map_or(0..0, |entry| entry.name.span())
}

/// The fault in a number of an entry, if any.
fn refused(entry: &toml::Table) -> Option<String> {
    entry.iter().find_map(|(key, value)| {
        if let toml::Value::Table(inside) = value {
            let fault = refused(inside);
            return fault.map(|fault| format!("'{}': {fault}", clip(key)));
        }
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
    let note = "see the manual of `robovec sim` for the sections [[joint]], [[link]], [[force]], [[contact]], [[tyre]], [[driven]] and [[event]]";
    wrong(span, &error.message, Some(note.to_owned()))
}

fn wrong(span: NameRange, message: &str, note: Option<String>) -> Diagnostic {
    Diagnostic::error()
        .with_message(message)
        .with_labels(vec![Label::primary(0, span)])
        .with_notes(note.into_iter().collect())
}

/// Keys that are written even where they are zero, which is not their default.
const WRITTEN: [&str; 4] = ["neutral", "normal", "offset", "place"];

impl Laws {
    /// The laws as a file that [`Laws::parse`] reads back for the same model;
    /// entries without force or motion are left out.
    pub fn to_text(&self, model: &Model) -> String {
        let mut file = Table::new();
        let mut section = |name: &str, entries: Vec<Table>| {
            let entries: Vec<Value> = entries.into_iter().map(Value::Table).collect();
            if !entries.is_empty() {
                file.insert(name.to_owned(), Value::Array(entries));
            }
        };
        let joints = || model.joints.iter().map(|joint| &*joint.name);
        let links = model.links.iter().map(|link| &*link.name);
        let forces = || {
            model
                .forces
                .iter()
                .map(|force| &*force.name)
                .zip(&self.forces)
        };
        let acting = joints().zip(&self.joints).filter(|(_, law)| law.acts());
        section("joint", acting.map(entry).collect());
        let acting = links.zip(&self.links).filter(|(_, law)| law.acts());
        section("link", acting.map(entry).collect());
        let acting = forces().filter(|(_, law)| law.acts());
        section("force", acting.map(entry).collect());
        let planes = forces().map(|(name, law)| (name, &law.contact));
        let planes = planes.filter(|(_, contact)| **contact != Contact::default());
        section("contact", planes.map(entry).collect());
        let tyres = forces().filter_map(|(name, law)| Some(named(name, law.tyre?.to_table())));
        section("tyre", tyres.collect());
        let events = self
            .events
            .iter()
            .map(|law| entry((law.subject(model), law)));
        section("event", events.collect());
        let moved = model.joints.iter().zip(&self.drives);
        let moved = moved.filter(|(joint, law)| {
            let elsewhere = law.offset.is_some_and(|offset| offset != joint.initial[0]);
            law.amplitude != 0.0 || elsewhere
        });
        let moved = moved.map(|(joint, law)| entry((&joint.name, law)));
        section("driven", moved.collect());
        toml::to_string(&file).expect("numbers and names can be written")
    }
}

/// An entry with the numbers of a law, those that are zero left out.
fn entry((name, law): (&str, &impl Serialize)) -> Table {
    let mut entry = Table::try_from(law).expect("a law has numbers and words");
    entry.retain(|key, value| WRITTEN.contains(&key) || !is_zero(value));
    named(name, entry)
}

fn named(name: &str, mut entry: Table) -> Table {
    entry.insert("name".to_owned(), Value::String(name.to_owned()));
    entry
}

fn is_zero(value: &Value) -> bool {
    match value {
        Value::Float(number) => *number == 0.0,
        Value::Integer(number) => *number == 0,
        Value::Array(numbers) => numbers.iter().all(is_zero),
        _ => false,
    }
}
