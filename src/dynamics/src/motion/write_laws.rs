//! Laws as the text of a file.

use super::contact::Contact;
use super::event_law::EventLaw;
use super::laws::{Drive, Laws, Spring, Support};
use super::tyre::Tyre;
use robovec_model::Model;
use toml::{Table, Value};

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
        let joints = model.joints.iter().map(|joint| &*joint.name);
        let links = model.links.iter().map(|link| &*link.name);
        let forces = model.forces.iter().map(|force| &*force.name);
        section("joint", springs(joints.clone(), &self.joints));
        section("link", springs(links, &self.links));
        let acting = forces
            .clone()
            .zip(&self.forces)
            .filter(|(_, law)| law.acts());
        section(
            "force",
            acting.map(|(name, law)| support(name, law)).collect(),
        );
        let planes = forces.clone().zip(&self.forces);
        let planes = planes.filter(|(_, law)| law.contact != Contact::default());
        section(
            "contact",
            planes
                .map(|(name, law)| contact(name, &law.contact))
                .collect(),
        );
        let tyres = forces.zip(&self.forces);
        let tyres = tyres.filter_map(|(name, law)| Some(tyre(name, law.tyre?)));
        section("tyre", tyres.collect());
        let events = self.events.iter().map(|law| event(model, law));
        section("event", events.collect());
        let moved = model
            .joints
            .iter()
            .zip(&self.drives)
            .filter(|(joint, law)| {
                let elsewhere = law.offset.is_some_and(|offset| offset != joint.initial[0]);
                law.amplitude != 0.0 || elsewhere
            });
        let moved = moved.map(|(joint, law)| drive(&joint.name, law));
        section("driven", moved.collect());
        toml::to_string(&file).expect("numbers and names can be written")
    }
}

/// An entry with its numbers, those that are zero left out.
fn entry(name: &str, numbers: &[(&str, f64)]) -> Table {
    let mut entry = Table::new();
    entry.insert("name".to_owned(), Value::String(name.to_owned()));
    for &(key, number) in numbers.iter().filter(|(_, number)| *number != 0.0) {
        entry.insert(key.to_owned(), Value::Float(number));
    }
    entry
}

fn springs<'a>(names: impl Iterator<Item = &'a str>, laws: &[Spring]) -> Vec<Table> {
    let acting = names.zip(laws).filter(|(_, law)| law.acts());
    acting
        .map(|(name, law)| {
            let numbers = [
                ("stiffness", law.stiffness),
                ("damping", law.damping),
                ("force", law.force),
                ("friction", law.friction),
                ("slip", law.slip.unwrap_or(0.0)),
            ];
            let mut spring = entry(name, &numbers);
            if let Some(neutral) = law.neutral {
                spring.insert("neutral".to_owned(), Value::Float(neutral));
            }
            spring
        })
        .collect()
}

fn support(name: &str, law: &Support) -> Table {
    let numbers = [("frequency", law.frequency), ("phase", law.phase)];
    let mut support = entry(name, &numbers);
    let vectors = [
        ("force", Some(law.force)),
        ("torque", Some(law.torque)),
        ("stiffness", Some(law.stiffness)),
        ("damping", Some(law.damping)),
        ("amplitude", Some(law.amplitude)),
    ];
    let written = vectors
        .into_iter()
        .filter(|(_, vector)| *vector != Some([0.0; 3]));
    for (key, vector) in written.chain([("place", law.place)]) {
        if let Some(vector) = vector {
            support.insert(key.to_owned(), list(vector));
        }
    }
    support
}

fn list(vector: [f64; 3]) -> Value {
    Value::Array(vector.into_iter().map(Value::Float).collect())
}

fn contact(name: &str, law: &Contact) -> Table {
    let numbers = [
        ("stiffness", law.stiffness),
        ("damping", law.damping),
        ("friction", law.friction),
        ("slip", law.slip.unwrap_or(0.0)),
    ];
    let mut contact = entry(name, &numbers);
    for (key, vector) in [("place", law.place), ("normal", law.normal)] {
        contact.insert(key.to_owned(), list(vector));
    }
    contact
}

fn tyre(name: &str, law: Tyre) -> Table {
    let mut tyre = entry(name, &[]);
    tyre.extend(law.to_table());
    tyre
}

fn event(model: &Model, law: &EventLaw) -> Table {
    let mut event = entry(law.subject(model), &[("value", law.value)]);
    let words = [
        ("quantity", law.quantity.name()),
        ("direction", law.direction.name()),
    ];
    for (key, word) in words {
        event.insert(key.to_owned(), Value::String(word.to_owned()));
    }
    event.insert("stop".to_owned(), Value::Boolean(law.stop));
    event
}

fn drive(name: &str, law: &Drive) -> Table {
    let numbers = [
        ("amplitude", law.amplitude),
        ("frequency", law.frequency),
        ("phase", law.phase),
    ];
    let mut drive = entry(name, &numbers);
    if let Some(offset) = law.offset {
        drive.insert("offset".to_owned(), Value::Float(offset));
    }
    drive
}
