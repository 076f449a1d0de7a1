//! Meaning of the study, in plain words, computed from its points.

use super::knee::{BUSY, SATURATED};
use super::knee::{Knee, Split, knee};
use super::program::ProgramFacts;
use super::results;
use super::results::{Results, StudiedProgram};
use robovec_error::yardstick::account::measure_text;
use robovec_fpga::hardware::MachineClock;
use robovec_ir::diagnostic::counted;
use robovec_present::number::{exponential, percent};
use serde::Serialize;

/// The verdict about one program.
#[derive(Clone, Debug, Serialize)]
pub(super) struct StudyVerdict {
    pub model: String,
    /// The system, which models with other equations share.
    pub system: String,
    /// Label that distinguishes its equations from others of the system.
    pub formulation: String,
    pub pipeline: String,
    pub answer: String,
    /// Share of the device and error.
    pub cost: String,
    /// Reasons, sentence by sentence.
    pub reasons: Vec<String>,
    /// The three zones: name, range of elements, limiting factor.
    pub zones: Vec<[String; 3]>,
    /// The numbers from which the verdict follows.
    pub knee: Knee,
}

/// Verdicts about programs on the ordinary machine, the headline model first.
pub(super) fn verdicts(results: &Results) -> Vec<StudyVerdict> {
    let mut programs: Vec<StudiedProgram<'_>> = results.ordinary().collect();
    programs.sort_by_key(|program| program.place[0] != results.plan.headline);
    programs.iter().filter_map(verdict).collect()
}

/// The verdicts about the headline model.
pub(super) fn of_headline(results: &Results) -> Vec<StudyVerdict> {
    let programs = results.of_headline();
    programs.filter_map(|program| verdict(&program)).collect()
}

/// The fastest of some pipelines beside the first, each at its knee, in a line.
pub(super) fn headline(verdicts: &[StudyVerdict]) -> String {
    let split = |verdict: &StudyVerdict| verdict.knee.cheapest.or(verdict.knee.fastest);
    let placed = verdicts.iter().filter_map(|one| Some((one, split(one)?)));
    let placed: Vec<(&StudyVerdict, Split)> = placed.collect();
    let best = placed.iter().min_by_key(|(_, split)| split.cycles);
    let (Some((first, before)), Some((best, after))) = (placed.first(), best) else {
        return "nothing could be placed".to_owned();
    };
    let elements = after.elements();
    if before.cycles == after.cycles {
        let elements = counted(elements, "element");
        return format!(
            "{} on {elements} ({})",
            counted(after.cycles, "cycle"),
            first.pipeline
        );
    }
    format!(
        "{:.2} times faster: {} -> {} cycles, {} -> {elements} elements ({} -> {})",
        f64::from(before.cycles) / f64::from(after.cycles),
        before.cycles,
        after.cycles,
        before.elements(),
        first.pipeline,
        best.pipeline,
    )
}

/// The verdicts after the names of their pipelines.
pub(super) fn lines(verdicts: &[StudyVerdict]) -> Vec<(&str, String)> {
    let line = |verdict: &StudyVerdict| format!("{} {}", verdict.answer, verdict.cost);
    let lines = verdicts.iter();
    lines
        .map(|verdict| (verdict.pipeline.as_str(), line(verdict)))
        .collect()
}

pub(super) fn verdict(program: &StudiedProgram<'_>) -> Option<StudyVerdict> {
    let (facts, clock) = (program.facts, program.clock());
    let knee = knee(program)?;
    let subject = program.subject();
    Some(StudyVerdict {
        model: facts.model.clone(),
        system: subject.source.clone(),
        formulation: results::label(subject),
        pipeline: facts.pipeline.clone(),
        answer: answer(facts, &knee, clock),
        cost: cost(facts, &knee),
        reasons: reasons(facts, &knee, clock),
        zones: zones(facts, &knee),
        knee,
    })
}

fn microseconds(cycles: u32, clock: MachineClock) -> String {
    format!("{:.2} µs", clock.microseconds(cycles))
}

fn elements(split: &Split) -> String {
    format!(
        "{} and {}",
        counted(split.n_add, "adder"),
        counted(split.n_multi, "multiplier")
    )
}

fn answer(facts: &ProgramFacts, knee: &Knee, clock: MachineClock) -> String {
    let model = &facts.model;
    match (&knee.cheapest, &knee.fastest) {
        (Some(best), _) => {
            let gain = 100.0 * (f64::from(best.cycles) / f64::from(knee.chain.max(1)) - 1.0);
            let beyond = if gain <= 0.0 {
                "no number of elements is faster".to_owned()
            } else {
                format!(
                    "no number of elements is more than {:.1} % faster",
                    gain.max(0.1)
                )
            };
            // Between two numbers that were tried the knee may lie anywhere.
            let worth = match &knee.below {
                Some(below) if !knee.is_exact => format!(
                    "more than {} and at most {} processing elements (of those tried)",
                    below.elements(),
                    best.elements()
                ),
                _ => counted(best.elements(), "processing element"),
            };
            format!(
                "{model} can use {worth}: {}. They compute it in {}, {} \
                 at {}; {beyond}.",
                elements(best),
                counted(best.cycles, "cycle"),
                microseconds(best.cycles, clock),
                clock.text(),
            )
        }
        (None, Some(fastest)) => format!(
            "{model} can use more than the {} processing elements that were tried ({}): they \
             take {}, {} at {}, and the longest chain of operations takes {}.",
            fastest.elements(),
            elements(fastest),
            counted(fastest.cycles, "cycle"),
            microseconds(fastest.cycles, clock),
            clock.text(),
            knee.chain,
        ),
        (None, None) => format!("{model} could not be placed."),
    }
}

/// The share of the device and the errors of the recommended design.
fn cost(facts: &ProgramFacts, knee: &Knee) -> String {
    let Some(best) = knee.cheapest.or(knee.fastest) else {
        return String::new();
    };
    let [median, worst] = facts.errors();
    format!(
        "They take {} of the device (estimated). Errors in binary32: median {}, worst {} {}.",
        percent(best.share),
        exponential(median),
        exponential(worst),
        measure_text(&facts.states()),
    )
}

fn reasons(facts: &ProgramFacts, knee: &Knee, clock: MachineClock) -> Vec<String> {
    let share = 100.0 * facts.mul as f64 / facts.operations.max(1) as f64;
    let mut reasons = vec![
        format!(
            "It has {}, {share:.0} % of them multiplications. The longest chain of \
             operations that wait for one another has {} and takes {}, {}: nothing computes it faster, however many elements there are.",
            counted(facts.operations, "operation"),
            counted(facts.asap, "operation"),
            counted(facts.asap_cycle, "cycle"),
            microseconds(facts.asap_cycle, clock),
        ),
        format!(
            "Shared evenly, the operations would keep {:.1} elements busy for that long (the \
             thesis' number Y). That is where more elements begin to be idle.",
            facts.number_y(),
        ),
    ];
    if let (Some(cheapest), Some(equal)) = (&knee.cheapest, &knee.equal)
        && cheapest.elements() < equal.elements()
    {
        reasons.push(format!(
            "With as many adders as multipliers it takes {} elements instead of {}, because the \
             two kinds of operations are not equally many.",
            equal.elements(),
            cheapest.elements(),
        ));
    }
    if let (Some(single), Some(best)) = (&knee.single, knee.cheapest.or(knee.fastest)) {
        reasons.push(format!(
            "One adder and one multiplier take {} ({}). {} elements are {:.1} times as \
             fast, and busy {:.0} % of the time instead of {:.0} %.",
            counted(single.cycles, "cycle"),
            microseconds(single.cycles, clock),
            best.elements(),
            f64::from(single.cycles) / f64::from(best.cycles.max(1)),
            100.0 * best.rate,
            100.0 * single.rate,
        ));
    }
    reasons
}

/// The three zones in equal numbers of adders and multipliers.
fn zones(facts: &ProgramFacts, knee: &Knee) -> Vec<[String; 3]> {
    let scarce = if facts.mul >= facts.add_sub {
        "multipliers"
    } else {
        "adders"
    };
    let range = |from: u32, to: u32| {
        if from >= to {
            counted(to, "element")
        } else {
            format!("{from} to {to} elements")
        }
    };
    let busy = knee.busiest.map_or(0, |split| split.elements());
    let saturated = knee.equal.map(|split| split.elements());
    let parallel = match busy {
        0 => "none of those tried".to_owned(),
        busy => range(knee.single.map_or(busy, |_| 2), busy),
    };
    let between = match saturated {
        // Equal numbers come in steps of two.
        Some(saturated) if knee.is_exact && saturated <= busy + 2 => "none".to_owned(),
        Some(saturated) if knee.is_exact => range(busy + 2, saturated - 2),
        Some(saturated) => format!("between {busy} and {saturated} elements"),
        None => format!("more than {busy} elements"),
    };
    let transition = match saturated {
        Some(saturated) if between == "none" => format!(
            "the step from {busy} to {saturated} elements passes over this zone: the placer \
             keeps elements busy until the longest chain decides"
        ),
        _ => "limited by both: in some cycles elements wait for operands, in others operands \
              wait for elements"
            .to_owned(),
    };
    let full = match saturated {
        Some(saturated) => format!("{saturated} elements and more"),
        None => "none of those tried".to_owned(),
    };
    let zone = |name: &str, range: String, why: String| [name.to_owned(), range, why];
    vec![
        zone(
            "Parallelisation",
            parallel,
            format!(
                "limited by the {scarce}: they start an operation in at least {:.0} % of all \
                 cycles, so every additional one shortens the run",
                100.0 / BUSY
            ),
        ),
        zone("Transition", between, transition),
        zone(
            "Saturation",
            full,
            format!(
                "limited by the longest chain: the schedule is within {:.0} % of its {} cycles, \
                 and additional elements stay idle",
                100.0 * (SATURATED - 1.0),
                knee.chain
            ),
        ),
    ]
}
