//! Answer of a search: speed relative to the input, error, and proof.

use super::text::SHOWN;
use super::{OptimisationPoint, OptimisationQuestion, OptimisationTarget, Optimised};
use crate::pareto;
use robovec_error::yardstick::account::measure_text;
use robovec_fpga::hardware;
use robovec_ir::Machine;
use robovec_present::number::{exponential, percent};
use robovec_present::text::thinned;
use serde::Serialize;

/// Label of the line with other choices.
pub const OTHERS: &str = "or choose";

/// Label of the errors that any state in the ranges can have.
pub const ANY_STATE: &str = "any state";

/// Label of the numbers of operations.
pub const OPERATIONS: &str = "operations";

/// Label of the schedule beside its bound.
pub const SCHEDULE: &str = "schedule";

robovec_num::named! {
    /// Quantity by which programs are compared.
    #[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum SpeedMeasure {
        /// Cycles of the schedule.
        Cycles = "cycles",
        /// Time of one call in C, ns.
        NanosecondsOfACall = "ns a call",
        /// Time per state in C that evaluates several, ns.
        NanosecondsOfAState = "ns a state",
        /// Operations, where nothing is timed.
        Operations = "operations",
    }
}

/// The program that was taken beside the function as it came.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct OptimisationAnswer {
    /// Unit of the speeds.
    pub measure: SpeedMeasure,
    /// Speed of the input; `None` where it could not be measured.
    pub before: Option<f64>,
    /// Speed of the program.
    pub after: f64,
    /// The one over the other.
    pub times_faster: Option<f64>,
    /// Times of both at the machine's clock, us.
    pub microseconds: [Option<f64>; 2],
    /// Machine, or compiler and flags.
    pub target: String,
    /// Form in which the input was measured, or the reason why it was not.
    pub input: String,
    /// Worst errors of both, relative to the largest element of an array.
    pub worst_errors: [Option<f64>; 2],
    /// Operations of both.
    pub operations: [usize; 2],
    /// Largest error of the program that a directed search found.
    pub found_error: Option<f64>,
    /// Bound of its error for every state in the ranges.
    pub proved_error: Option<f64>,
    /// Median error of the program.
    pub median_error: Option<f64>,
    /// Number format of the target.
    pub format: String,
    /// States at which errors were measured.
    pub states: String,
    /// Outcome of the check against the input.
    pub proof: String,
    /// Length of the schedule beside its proved bound.
    pub schedule: Option<String>,
    /// Programs that others would take: faster, or more exact.
    pub others: Vec<String>,
}

impl OptimisationAnswer {
    /// The answer of a search.
    pub fn of(found: &Optimised, question: &OptimisationQuestion<'_>) -> OptimisationAnswer {
        let (input, best) = (&found.points[0], &found.points[found.best]);
        let measure = found.measure(question);
        let speed = |point: &OptimisationPoint| measure.of(point);
        let after = speed(best).expect("what is taken was measured");
        let before = speed(input);
        OptimisationAnswer {
            measure,
            before,
            after,
            times_faster: before.map(|before| before / after),
            microseconds: [input.microseconds, best.microseconds],
            target: target(question, best),
            input: input.remark.clone(),
            worst_errors: [input, best].map(|point| point.errors.map(|errors| errors[1])),
            operations: [input, best].map(|point| point.operations),
            found_error: best.found,
            proved_error: best.proved,
            median_error: best.errors.map(|errors| errors[0]),
            format: found.errors.format.to_string(),
            states: found.errors.states.clone(),
            proof: found.proof.clone(),
            schedule: best.cycles.zip(best.bound).map(|(cycles, bound)| {
                let above = f64::from(cycles - bound) / f64::from(bound);
                if cycles == bound {
                    "as short as proved possible for these operations on this machine".to_owned()
                } else {
                    format!(
                        "{} above the proved bound of {bound} cycles",
                        percent(above)
                    )
                }
            }),
            others: others(found, measure),
        }
    }

    /// The gain in one line.
    pub fn headline(&self) -> String {
        let after = self.measure.text(self.after);
        let unit = self.measure.name();
        let (Some(before), Some(ratio)) = (self.before, self.times_faster) else {
            return format!("{after} {unit}; the input was not measured: {}", self.input);
        };
        let before = self.measure.text(before);
        let gain = match (ratio, self.measure) {
            (ratio, measure) if (ratio - 1.0).abs() < measure.noise() => "no faster".to_owned(),
            (ratio, _) if ratio < 1.0 => "slower than the input".to_owned(),
            (ratio, SpeedMeasure::Operations) => format!("{} times shorter", times(ratio)),
            (ratio, _) => format!("{} times faster", times(ratio)),
        };
        let time = match self.microseconds {
            [Some(before), Some(after)] => format!(", {before:.2} -> {after:.2} us"),
            _ => String::new(),
        };
        format!("{gain}: {before} -> {after} {unit}{time}")
    }

    /// True where the input is faster by more than the noise.
    pub fn is_slower(&self) -> bool {
        (self.times_faster).is_some_and(|ratio| ratio <= 1.0 - self.measure.noise())
    }

    /// Lines after the headline, with their labels.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        match self.measure {
            SpeedMeasure::Cycles => lines.push(("machine", self.target.clone())),
            SpeedMeasure::Operations => {}
            _ => lines.push((
                "compiler",
                format!("{}; input: {}", self.target, self.input),
            )),
        }
        if self.measure != SpeedMeasure::Operations {
            let [before, after] = self.operations;
            lines.push((OPERATIONS, format!("{before} -> {after}")));
        }
        let [before, after] = self.worst_errors.map(error_text);
        lines.push((
            "worst error",
            format!(
                "{before} -> {after} in {}, median {}, {}",
                self.format,
                error_text(self.median_error),
                measure_text(&self.states)
            ),
        ));
        lines.extend(self.found_error.map(|found| {
            let bound = match self.proved_error {
                Some(bound) => format!("never above {}, proved", exponential(bound)),
                None => "no bound was proved".to_owned(),
            };
            let found = exponential(found);
            let text = format!("up to {found}, found by a search; {bound}");
            (ANY_STATE, text)
        }));
        lines.push(("proved", self.proof.clone()));
        lines.extend(self.schedule.clone().map(|text| (SCHEDULE, text)));
        if !self.others.is_empty() {
            lines.push((OTHERS, self.others.join("; ")));
        }
        lines
    }
}

impl SpeedMeasure {
    /// The speed of a point, where it was measured.
    pub(super) fn of(self, point: &OptimisationPoint) -> Option<f64> {
        match self {
            SpeedMeasure::Cycles => point.cycles.map(f64::from),
            SpeedMeasure::NanosecondsOfACall | SpeedMeasure::NanosecondsOfAState => {
                point.nanoseconds
            }
            SpeedMeasure::Operations => Some(point.operations as f64),
        }
    }

    /// Relative noise of a measurement; smaller differences are none.
    fn noise(self) -> f64 {
        match self {
            SpeedMeasure::Cycles | SpeedMeasure::Operations => 0.0005,
            SpeedMeasure::NanosecondsOfACall | SpeedMeasure::NanosecondsOfAState => 0.03,
        }
    }

    /// A speed without its unit.
    pub(super) fn text(self, speed: f64) -> String {
        match self {
            SpeedMeasure::Cycles | SpeedMeasure::Operations => format!("{speed}"),
            _ => nanoseconds(speed),
        }
    }
}

impl Optimised {
    /// Quantity by which its programs are compared.
    pub(super) fn measure(&self, question: &OptimisationQuestion<'_>) -> SpeedMeasure {
        let is_timed = self.points[self.best].nanoseconds.is_some();
        match question.target {
            OptimisationTarget::Fpga => SpeedMeasure::Cycles,
            _ if !is_timed => SpeedMeasure::Operations,
            OptimisationTarget::Cpu => SpeedMeasure::NanosecondsOfACall,
            OptimisationTarget::Batch => SpeedMeasure::NanosecondsOfAState,
        }
    }

    /// Points that no other beats in speed and worst error, the fastest first.
    pub(super) fn front(&self, measure: SpeedMeasure) -> Vec<usize> {
        let points = self.points.iter().enumerate();
        pareto::steps(
            points
                .filter_map(|(index, point)| Some((index, [measure.of(point)?, point.errors?[1]]))),
        )
    }

    /// Places of the rows: the thinned front, the input and the taken program.
    pub(super) fn shown(&self, measure: SpeedMeasure, most: usize) -> Vec<usize> {
        let front = self.front(measure);
        let mut rows: Vec<usize> = vec![0, self.best];
        let others: Vec<usize> = front
            .into_iter()
            .filter(|index| !rows.contains(index))
            .collect();
        // The first and the last stay, the fastest and the most exact; fewer rows
        // are some of those that were searched for large errors.
        let searched = thinned(&others, SHOWN - rows.len());
        rows.extend(thinned(&searched, most - rows.len()));
        let speed = |index: &usize| measure.of(&self.points[*index]).unwrap_or(f64::INFINITY);
        rows.sort_by(|a, b| speed(a).total_cmp(&speed(b)).then(a.cmp(b)));
        rows.dedup();
        rows
    }
}

/// A time with three digits or less.
pub(super) fn nanoseconds(time: f64) -> String {
    match time {
        _ if time < 1.0 => format!("{time:.2}"),
        _ if time < 100.0 => format!("{time:.1}"),
        _ => format!("{time:.0}"),
    }
}

fn error_text(error: Option<f64>) -> String {
    match error {
        Some(error) => exponential(error),
        None => "not measured".to_owned(),
    }
}

/// A ratio with three digits.
fn times(ratio: f64) -> String {
    if ratio < 10.0 {
        format!("{ratio:.2}")
    } else {
        format!("{ratio:.1}")
    }
}

/// Machine with elements, clock and share of the device, or compiler and flags.
fn target(question: &OptimisationQuestion<'_>, best: &OptimisationPoint) -> String {
    if question.target != OptimisationTarget::Fpga {
        let command = question.compiler.map(|compiler| compiler.command.as_str());
        return format!("{} {}", command.unwrap_or("none"), question.flags);
    }
    let machine = question.machine;
    let clock = hardware::clock(machine).text();
    let share = best.share.map(|share| {
        let device = &machine.device.device().name;
        format!(", {} of {device} (estimated)", percent(share))
    });
    format!(
        "{}, {clock}{}",
        elements(machine),
        share.unwrap_or_default()
    )
}

/// The machine with its numbers of elements.
fn elements(machine: &Machine) -> String {
    let kinds = machine.elements.iter();
    let kinds: Vec<String> = kinds
        .map(|kind| format!("{} {}", kind.count, kind.kind))
        .collect();
    format!("{} ({})", machine.name, kinds.join(", "))
}

/// Neighbours of the chosen program on the front: fastest, and more exact.
fn others(found: &Optimised, measure: SpeedMeasure) -> Vec<String> {
    let taken = &found.points[found.best];
    let front = found.front(measure);
    let speed = |point: &OptimisationPoint| measure.of(point).expect("the front is measured");
    let worst = |point: &OptimisationPoint| point.errors.map_or(f64::INFINITY, |errors| errors[1]);
    let text = |point: &OptimisationPoint| {
        let (speed, error) = (measure.text(speed(point)), exponential(worst(point)));
        format!("{speed} {} at {error} ({})", measure.name(), point.name)
    };
    let points = || {
        let points = front.iter().map(|&index| &found.points[index]);
        points.filter(|point| !point.is_input)
    };
    let limit = speed(taken) * (1.0 - measure.noise());
    let faster = points().next().filter(|point| speed(point) < limit);
    let exact = points().find(|point| speed(point) > speed(taken) && worst(point) < worst(taken));
    faster.into_iter().chain(exact).map(text).collect()
}
