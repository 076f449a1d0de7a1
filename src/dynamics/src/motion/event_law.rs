//! Events of a run, as named by laws.

use robovec_model::Model;
use serde::Deserialize;

/// A quantity of a state that events are about.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EventQuantity {
    /// The position of a joint, m or rad.
    #[default]
    Position,
    /// The velocity of a joint, m/s or rad/s.
    Velocity,
    /// Height of a contact above its plane, m.
    Gap,
}

impl EventQuantity {
    /// Its word in files.
    pub fn name(self) -> &'static str {
        match self {
            EventQuantity::Position => "position",
            EventQuantity::Velocity => "velocity",
            EventQuantity::Gap => "gap",
        }
    }
}

/// Direction in which a quantity must pass its value.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EventDirection {
    /// In either direction.
    #[default]
    Both,
    /// From below.
    Rising,
    /// From above.
    Falling,
}

impl EventDirection {
    /// Its word in files.
    pub fn name(self) -> &'static str {
        match self {
            EventDirection::Both => "both",
            EventDirection::Rising => "rising",
            EventDirection::Falling => "falling",
        }
    }
}

/// Event that a run watches for.
#[derive(Clone, Copy, PartialEq, Default, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EventLaw {
    /// Watched quantity.
    pub quantity: EventQuantity,
    /// The index of the joint, or of the external force of the contact.
    #[serde(skip)]
    pub subject: usize,
    /// The value it passes.
    pub value: f64,
    /// In which direction.
    pub direction: EventDirection,
    /// The run ends at the event.
    pub stop: bool,
}

impl EventLaw {
    /// The name of the joint or external force that it is about.
    pub fn subject<'m>(&self, model: &'m Model) -> &'m str {
        match self.quantity {
            EventQuantity::Gap => &model.forces[self.subject].name,
            EventQuantity::Position | EventQuantity::Velocity => &model.joints[self.subject].name,
        }
    }
}
