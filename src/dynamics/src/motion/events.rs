//! Events of a run: quantities that pass a value, contacts that open or close.
//!
//! Signs at both ends of a step show that something was passed; where the rate
//! of a quantity turns round between them, a cubic through values and rates
//! shows whether the value was passed twice. Steps of other lengths from the
//! same start find the time as exactly as the integrator.

use super::energy;
use super::laws::Laws;
use crate::kinematics::MotionState;
use robovec_model::Model;
use serde::{Deserialize, Serialize};

/// Default precision of the times of events, s.
pub const EVENT_TOLERANCE: f64 = 1e-9;

/// Something that was looked out for and happened.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct EventRecord {
    /// The index of the event among those of the laws.
    pub event: usize,
    /// Time of the event, s.
    pub time: f64,
    /// From below, and not from above.
    pub rising: bool,
}

/// A monitored quantity of a run: an event, or a contact that cuts the step.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Watched {
    law: EventLaw,
    /// The event's index; `None` for a contact without an event.
    event: Option<usize>,
    /// Its last side of the value; `None` before it left it.
    above: Option<bool>,
}

/// A quantity less the value it may pass, and its rate, if known.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Signal {
    pub(super) value: f64,
    rate: Option<f64>,
}

/// Events that a run watches for.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct EventWatch {
    watched: Vec<Watched>,
}

impl EventWatch {
    /// The events of the laws, and every contact that acts.
    pub(super) fn new(laws: &Laws) -> EventWatch {
        let asked = laws.events.iter().enumerate();
        let asked = asked.map(|(index, &law)| Watched {
            law,
            event: Some(index),
            above: None,
        });
        let contacts = laws.forces.iter().enumerate();
        let contacts = contacts.filter(|(_, law)| law.meets_ground());
        let contacts = contacts.map(|(subject, _)| Watched {
            law: EventLaw {
                quantity: EventQuantity::Gap,
                subject,
                ..EventLaw::default()
            },
            event: None,
            above: None,
        });
        EventWatch {
            watched: asked.chain(contacts).collect(),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.watched.is_empty()
    }

    pub(super) fn signals(&self, model: &Model, laws: &Laws, state: &MotionState) -> Vec<Signal> {
        let gaps = self
            .watched
            .iter()
            .any(|one| one.law.quantity == EventQuantity::Gap);
        let points = if gaps {
            energy::point_motions(model, state)
        } else {
            Vec::new()
        };
        let signal = |one: &Watched| {
            let subject = one.law.subject;
            let (value, rate) = match one.law.quantity {
                EventQuantity::Position => (state.q[subject], Some(state.qd[subject])),
                EventQuantity::Velocity => (state.qd[subject], None),
                EventQuantity::Gap => {
                    let [gap, rate] = laws.forces[subject].gap(&points[subject].fixed());
                    (gap.value, Some(rate.value))
                }
            };
            Signal {
                value: value - one.law.value,
                rate,
            }
        };
        self.watched.iter().map(signal).collect()
    }

    /// Those whose side changed, in the requested direction.
    pub(super) fn passed(&self, signals: &[Signal]) -> Vec<usize> {
        assert_eq!(
            signals.len(),
            self.watched.len(),
            "one signal per watched quantity"
        );
        let places = self.watched.iter().zip(signals).enumerate();
        let passed = places.filter(|(_, (one, signal))| {
            let now = side(signal.value);
            let crossed = one.above.is_some() && now.is_some() && one.above != now;
            crossed
                && match one.law.direction {
                    EventDirection::Both => true,
                    EventDirection::Rising => now == Some(true),
                    EventDirection::Falling => now == Some(false),
                }
        });
        passed.map(|(place, _)| place).collect()
    }

    /// Records the sides at a state at `time`: events, and if the run ends.
    pub(super) fn reach(&mut self, time: f64, signals: &[Signal]) -> ReachedEvents {
        let mut reached = ReachedEvents::default();
        for place in self.passed(signals) {
            let one = &self.watched[place];
            match one.event {
                Some(event) => reached.records.push(EventRecord {
                    event,
                    time,
                    rising: signals[place].value > 0.0,
                }),
                None => reached.contacts += 1,
            }
            reached.stop |= one.law.stop;
        }
        for (one, signal) in self.watched.iter_mut().zip(signals) {
            one.above = side(signal.value).or(one.above);
        }
        reached
    }

    /// The part of a step after which a quantity may have passed its value and
    /// come back, by the cubic through values and rates at both ends.
    pub(super) fn dip(&self, step: f64, before: &[Signal], after: &[Signal]) -> Option<f64> {
        assert_eq!(
            (before.len(), after.len()),
            (self.watched.len(), self.watched.len()),
            "one signal per watched quantity"
        );
        let pairs = self.watched.iter().zip(before.iter().zip(after));
        let dips = pairs.filter_map(|(one, (before, after))| {
            let above = one.above?;
            let sign = if above { 1.0 } else { -1.0 };
            let [from, to] = [before, after].map(|signal| sign * signal.value);
            let [down, up] = [before.rate?, after.rate?].map(|rate| sign * rate * step);
            if from < 0.0 || to < 0.0 || down >= 0.0 || up <= 0.0 {
                return None;
            }
            let (part, least) = least_of_cubic([from, to], [down, up]);
            (least < 0.0).then_some(part)
        });
        dips.reduce(f64::min)
    }
}

/// Events that a state brought.
#[derive(Clone, PartialEq, Default, Debug)]
pub(super) struct ReachedEvents {
    pub(super) records: Vec<EventRecord>,
    /// Contacts that opened or closed.
    pub(super) contacts: u64,
    pub(super) stop: bool,
}

/// The sign of a number: true above zero, false below; `None` otherwise.
fn side(value: f64) -> Option<bool> {
    (value != 0.0).then_some(value > 0.0)
}

/// Place in 0 to 1 of the least of a cubic, and that value; it falls first.
fn least_of_cubic([from, to]: [f64; 2], [down, up]: [f64; 2]) -> (f64, f64) {
    let cubic = 2.0 * (from - to) + down + up;
    let square = 3.0 * (to - from) - 2.0 * down - up;
    let at = |x: f64| from + x * (down + x * (square + x * cubic));
    // The zero of the slope between 0 and 1, in the form that does not cancel.
    let root = (square * square - 3.0 * cubic * down).max(0.0).sqrt();
    let part = (-down / (square + root)).clamp(0.0, 1.0);
    (part, at(part))
}

/// Narrows down the time of an event between two times, of which only the later
/// is after it. Every third time the interval is halved; the others aim at the
/// zero of a straight line through both ends, and a little beyond it as seen
/// from the nearer end.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct EventBracket {
    pub(super) from: f64,
    pub(super) to: f64,
    turns: u32,
}

impl EventBracket {
    /// Between the start of a step and `to` after it.
    pub(super) fn new(to: f64) -> EventBracket {
        EventBracket {
            from: 0.0,
            to,
            turns: 0,
        }
    }

    /// True when the time is known to `tolerance`, or as well as numbers can.
    pub(super) fn is_narrow(&self, tolerance: f64) -> bool {
        let middle = 0.5 * (self.from + self.to);
        self.to - self.from <= tolerance || middle <= self.from || middle >= self.to
    }

    /// Next place to evaluate; `ends` are the values at both ends.
    pub(super) fn next(&mut self, tolerance: f64, ends: Option<[f64; 2]>) -> f64 {
        self.turns += 1;
        let width = self.to - self.from;
        let middle = self.from + 0.5 * width;
        let Some([a, b]) = ends.filter(|[a, b]| a - b != 0.0) else {
            return middle;
        };
        if self.turns.is_multiple_of(3) {
            return middle;
        }
        let zero = self.from + width * (a / (a - b));
        let beyond = if zero < middle { 0.4 } else { -0.4 } * tolerance;
        let aimed = zero + beyond;
        if aimed > self.from && aimed < self.to {
            aimed
        } else {
            middle
        }
    }
}

/// A quantity of a state that events are about.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Deserialize, Serialize)]
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
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Deserialize, Serialize)]
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

/// Event that a run watches for.
#[derive(Clone, Copy, PartialEq, Default, Debug, Deserialize, Serialize)]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_of_a_cubic_is_found() {
        // (x - 1/3)^2 (x + 2) - 1/10, least at 1/3.
        let value = |x: f64| (x - 1.0 / 3.0).powi(2) * (x + 2.0) - 0.1;
        let slope = |x: f64| 2.0 * (x - 1.0 / 3.0) * (x + 2.0) + (x - 1.0 / 3.0).powi(2);
        let (part, least) = least_of_cubic([value(0.0), value(1.0)], [slope(0.0), slope(1.0)]);
        assert!((part - 1.0 / 3.0).abs() < 1e-12, "{part}");
        assert!((least + 0.1).abs() < 1e-12, "{least}");
    }

    #[test]
    fn a_bracket_finds_a_zero_in_few_turns() {
        let value = |time: f64| (2.0 * time).cos() - 0.3;
        let mut bracket = EventBracket::new(1.5);
        let mut turns = 0;
        while !bracket.is_narrow(1e-12) {
            let ends = [value(bracket.from), value(bracket.to)];
            let time = bracket.next(1e-12, Some(ends));
            if value(time) < 0.0 {
                bracket.to = time;
            } else {
                bracket.from = time;
            }
            turns += 1;
        }
        assert!((bracket.to - 0.5 * 0.3f64.acos()).abs() < 2e-12);
        assert!(turns < 20, "{turns}");
    }
}
