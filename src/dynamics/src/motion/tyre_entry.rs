//! A tyre as a file of laws gives it.

use super::contact::Contact;
use super::tyre::{MagicFormula, SlipLaw, Tyre};
use serde::Deserialize;
use thiserror::Error;
use toml::{Table, Value};

#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum SlipLawChoice {
    /// In proportion to slip.
    Linear,
    /// The magic formula.
    Bakker,
}

/// Entry of a file. The forms of `longitudinal` and `lateral` depend on the law.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TyreEntry {
    #[serde(default)]
    place: [f64; 3],
    #[serde(default = "upwards")]
    normal: [f64; 3],
    radius: f64,
    #[serde(default = "across")]
    axis: [f64; 3],
    stiffness: f64,
    #[serde(default)]
    damping: f64,
    law: SlipLawChoice,
    friction: Option<f64>,
    longitudinal: Value,
    lateral: Value,
    slip: Option<f64>,
}

fn upwards() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn across() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

#[derive(Clone, PartialEq, Debug, Error)]
pub(super) enum TyreEntryError {
    /// The law has no parameter `friction`.
    #[error("the law 'bakker' has no `friction`: its peaks are the numbers `D`")]
    Friction,
    /// The law needs a limit of its force.
    #[error("the law 'linear' needs `friction`, the largest force as a share of the pressure")]
    NoFriction,
    /// A slope is no number.
    #[error("with the law 'linear' `{0}` is a number: force per slip, N")]
    Slope(&'static str),
    /// Coefficients are incomplete or no numbers.
    #[error("with the law 'bakker' `{name}` is {{ B = …, C = …, D = …, E = … }}: {reason}")]
    Curve { name: &'static str, reason: String },
}

fn slope(name: &'static str, value: &Value) -> Result<f64, TyreEntryError> {
    let number = value.clone().try_into();
    number.map_err(|_| TyreEntryError::Slope(name))
}

fn curve(name: &'static str, value: &Value) -> Result<MagicFormula, TyreEntryError> {
    let read = value.clone().try_into();
    read.map_err(|error: toml::de::Error| TyreEntryError::Curve {
        name,
        reason: error.message().to_owned(),
    })
}

impl TryFrom<TyreEntry> for Tyre {
    type Error = TyreEntryError;

    fn try_from(entry: TyreEntry) -> Result<Tyre, TyreEntryError> {
        let slips = [
            ("longitudinal", &entry.longitudinal),
            ("lateral", &entry.lateral),
        ];
        let [(along, longitudinal), (across, lateral)] = slips;
        let law = match (entry.law, entry.friction) {
            (SlipLawChoice::Linear, None) => return Err(TyreEntryError::NoFriction),
            (SlipLawChoice::Bakker, Some(_)) => return Err(TyreEntryError::Friction),
            (SlipLawChoice::Linear, Some(friction)) => SlipLaw::Linear {
                friction,
                longitudinal: slope(along, longitudinal)?,
                lateral: slope(across, lateral)?,
            },
            (SlipLawChoice::Bakker, None) => SlipLaw::Bakker {
                longitudinal: curve(along, longitudinal)?,
                lateral: curve(across, lateral)?,
            },
        };
        Ok(Tyre {
            contact: Contact {
                place: entry.place,
                normal: entry.normal,
                stiffness: entry.stiffness,
                damping: entry.damping,
                ..Contact::default()
            },
            radius: entry.radius,
            axis: entry.axis,
            law,
            slip: entry.slip,
        })
    }
}

impl Tyre {
    /// The entry without its name.
    pub(super) fn to_table(self) -> Table {
        let list = |vector: [f64; 3]| Value::Array(vector.map(Value::Float).to_vec());
        let curve = |curve: MagicFormula| Value::try_from(curve).expect("numbers can be written");
        let (law, slips, friction) = match self.law {
            SlipLaw::Linear {
                friction,
                longitudinal,
                lateral,
            } => (
                "linear",
                [longitudinal, lateral].map(Value::Float),
                Some(friction),
            ),
            SlipLaw::Bakker {
                longitudinal,
                lateral,
            } => ("bakker", [longitudinal, lateral].map(curve), None),
        };
        let [longitudinal, lateral] = slips;
        let entries = [
            ("place", Some(list(self.contact.place))),
            ("normal", Some(list(self.contact.normal))),
            ("radius", Some(Value::Float(self.radius))),
            ("axis", Some(list(self.axis))),
            ("stiffness", Some(Value::Float(self.contact.stiffness))),
            ("damping", Some(Value::Float(self.contact.damping))),
            ("law", Some(Value::String(law.to_owned()))),
            ("friction", friction.map(Value::Float)),
            ("longitudinal", Some(longitudinal)),
            ("lateral", Some(lateral)),
            ("slip", self.slip.map(Value::Float)),
        ];
        let given = entries.into_iter();
        given
            .filter_map(|(key, value)| Some((key.to_owned(), value?)))
            .collect()
    }
}
