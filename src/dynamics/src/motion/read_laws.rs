//! Laws from the text of a file.

use super::contact::Contact;
use super::energy;
use super::event_law::{EventLaw, EventQuantity};
use super::laws::{FIELDS, LAW, Laws, Support};
use super::tyre::Tyre;
use crate::kinematics::MotionState;
use robovec_ir::diagnostic::{Diagnostic, Label, clip, did_you_mean};
use robovec_ir::document::{self, DocumentError};
use robovec_model::{Model, Nature};
use robovec_num::limits::Amount;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct LawsFile {
    joint: Vec<toml::Table>,
    link: Vec<toml::Table>,
    force: Vec<toml::Table>,
    contact: Vec<toml::Table>,
    tyre: Vec<toml::Table>,
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
    tyre: Vec<Named>,
    event: Vec<Named>,
    driven: Vec<Named>,
}

#[derive(Deserialize)]
struct Named {
    name: Spanned<String>,
}

impl Laws {
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
        read.ground(model, &file, &names, &mut laws.forces);
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

    /// Reads the contacts and tyres of external forces. An entry with a name
    /// has priority over `"*"` of the other kind.
    fn ground(&mut self, model: &Model, file: &LawsFile, names: &LawNames, laws: &mut [Support]) {
        let forces: Vec<&str> = model.forces.iter().map(|f| f.name.as_str()).collect();
        let what = "external force";
        let mut contacts: Vec<Option<Contact>> = vec![None; forces.len()];
        let mut tyres: Vec<Option<Tyre>> = vec![None; forces.len()];
        self.section(what, &file.contact, &names.contact, &forces, &mut contacts);
        self.section(what, &file.tyre, &names.tyre, &forces, &mut tyres);
        self.directions(
            "normal",
            "the normal of a plane",
            &file.contact,
            &names.contact,
        );
        self.directions("normal", "the normal of a plane", &file.tyre, &names.tyre);
        self.directions("axis", "the axis of a wheel", &file.tyre, &names.tyre);
        if !self.errors.is_empty() {
            return;
        }
        for (index, law) in laws.iter_mut().enumerate() {
            let name = forces[index];
            let named = [&names.contact, &names.tyre]
                .map(|names| names.iter().any(|one| one.name.get_ref() == name));
            let (mut contact, mut tyre) = (contacts[index], tyres[index]);
            if contact.is_some() && tyre.is_some() {
                match named {
                    [true, false] => tyre = None,
                    [false, true] => contact = None,
                    _ => {
                        let message = format!("'{}' has a contact already", clip(name));
                        let note = "a tyre includes the contact of its wheel".to_owned();
                        let span = span_of(&names.tyre, name);
                        self.errors.push(wrong(span, &message, Some(note)));
                    }
                }
            }
            law.contact = contact.unwrap_or_default();
            law.tyre = tyre;
        }
        self.upright(model, &names.tyre, laws);
    }

    /// Refuses directions of no length.
    fn directions(&mut self, key: &str, what: &str, entries: &[toml::Table], names: &[Named]) {
        for (entry, Named { name }) in entries.iter().zip(names) {
            let direction = entry.get(key).and_then(toml::Value::as_array);
            if direction.is_some_and(|direction| is_zero(direction)) {
                let message = format!("{what} has a direction");
                self.errors.push(wrong(name.span(), &message, None));
            }
        }
    }

    /// Refuses tyres of wheels that lie flat at the initial positions.
    fn upright(&mut self, model: &Model, names: &[Named], laws: &[Support]) {
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
                let span = span_of(names, name);
                self.errors.push(wrong(span, &message, Some(note)));
            }
        }
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

/// The place of the entry for a name: its own, or that of all.
fn span_of(names: &[Named], name: &str) -> NameRange {
    let entry = |wanted: &str| names.iter().find(|one| one.name.get_ref() == wanted);
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
