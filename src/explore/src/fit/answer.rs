//! Answer of a search: the cheapest choice, its cost, error and tested states.

use super::confirm::Confirmation;
use super::text::percent;
use super::{
    Challenge, CostMeasure, FitCandidate, FitOutcome, FitTask, MotionShare, VALIDATION_FACTOR,
};
use robovec_error::yardstick::account::measure_text;
use robovec_framework::scene::{Measure, OutputTolerance};
use robovec_ir::diagnostic::counted;
use robovec_present::number::{exponential, round, share_percent};
use robovec_present::text::cut;

type Line = (&'static str, String);

/// The cheapest candidate in binary32 that meets the scene.
pub(super) fn baseline(task: &FitTask<'_>, outcome: &FitOutcome) -> Option<usize> {
    let plain = (0..outcome.candidates.len()).filter(|&index| {
        let candidate = &outcome.candidates[index];
        let is_mixed = outcome.programs[candidate.program].mixture.is_some();
        candidate.meets && !is_mixed && candidate.format == "f32"
    });
    let cost = |index: &usize| task.cost_of(&outcome.candidates[*index]);
    plain.min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

/// The cost of the choice beside that of binary32, in one line.
pub(super) fn headline(task: &FitTask<'_>, outcome: &FitOutcome) -> String {
    let Some(chosen) = outcome.chosen.map(|chosen| &outcome.candidates[chosen]) else {
        return "no program meets this scene".to_owned();
    };
    let text = |candidate: &FitCandidate| match task.cost {
        CostMeasure::Device => share_percent(candidate.share),
        CostMeasure::Cells => format!("{:.0}", candidate.cells),
    };
    let unit = match task.cost {
        CostMeasure::Device => "of the device",
        CostMeasure::Cells => "cells",
    };
    let own = text(chosen);
    let Some(plain) = baseline(task, outcome).map(|plain| &outcome.candidates[plain]) else {
        return format!("{own} {unit}; no program in binary32 meets the scene");
    };
    let ratio = task.cost_of(plain) / task.cost_of(chosen);
    if chosen.format == "f32" {
        return format!("{own} {unit}, in binary32");
    }
    if ratio < 1.005 {
        return format!("{own} {unit}, as much as in binary32");
    }
    let before = text(plain);
    format!("{ratio:.2} times cheaper than binary32: {before} -> {own} {unit}")
}

/// Maximum number of characters of a line that is folded on the terminal.
const LONG: usize = 200;

/// Lines for the terminal: choice, error and states, or why there is none.
pub(super) fn brief(
    task: &FitTask<'_>,
    outcome: &FitOutcome,
    confirmation: Option<&Confirmation>,
) -> Vec<Line> {
    let mut brief = lines(task, outcome, confirmation);
    if let (Some(chosen), Some(challenge)) = (outcome.chosen, &outcome.challenge) {
        let kept = ["program", "sin, cos", "schedule", "worst error"];
        brief.retain(|(label, _)| kept.contains(label));
        let is_limited = (task.scene.outputs.iter()).any(|need| need.tolerance.is_some());
        if is_limited {
            let used = outcome.candidates[chosen].used;
            brief.push(("tolerance", allowed(task, used)));
            brief.push(("sources", sources(outcome)));
        }
        let proved = outcome.bound.filter(|bound| bound.holds());
        let held = match proved {
            _ if !is_limited => "no error of a state is limited".to_owned(),
            Some(bound) => format!(
                "at every state in the ranges (proved), at most {} of it",
                percent(bound.used)
            ),
            None => format!(
                "at {} states (searched), at most {} of it; not proved for all",
                challenge.fresh + challenge.directed,
                percent(challenge.used.max(challenge.fresh_used))
            ),
        };
        brief.push(("held", held));
        brief.extend(outcome.motion.as_ref().map(|motion| {
            let ratio = |[found, allowed]: [f64; 2]| {
                format!("{} of {} allowed", exponential(found), exponential(allowed))
            };
            let energy = motion.energy;
            let energy = energy.map(|energy| ratio([energy.drift, energy.allowed]));
            let energy = energy.map(|text| format!("; energy {text}"));
            let error = ratio([motion.error, motion.allowed]);
            let text = format!("{error} in {} s{}", motion.time, energy.unwrap_or_default());
            ("over time", text)
        }));
        brief.extend(confirmation.map(|confirmation| {
            let runs = counted(confirmation.simulated, "run");
            let cycles = counted(confirmation.cycles, "cycle");
            let text = if confirmation.holds() {
                format!("{runs} of {cycles} from memory images, all bit for bit equal")
            } else {
                run(confirmation)
            };
            ("simulated", text)
        }));
    }
    for (_, text) in &mut brief {
        *text = cut(text, LONG);
    }
    brief
}

/// Lines after the headline, with their labels.
pub(super) fn lines(
    task: &FitTask<'_>,
    outcome: &FitOutcome,
    confirmation: Option<&Confirmation>,
) -> Vec<Line> {
    let mut lines = match outcome.chosen {
        Some(chosen) => choice(task, outcome, chosen),
        None => refusal(task, outcome),
    };
    if let Some(challenge) = &outcome.challenge {
        lines.extend(held(task, outcome, challenge));
        if let Some(motion) = &outcome.motion {
            lines.push(("over time", over_time(outcome, motion)));
        }
    }
    lines.extend(confirmation.map(|confirmation| ("simulated", run(confirmation))));
    let tried = format!(
        "{}, {} measured at {} of the scene",
        counted(outcome.programs.len(), "program"),
        counted(outcome.candidates.len(), "candidate"),
        counted(task.states, "state")
    );
    lines.push(("tried", tried));
    if let Some(first) = outcome.untried.first() {
        let others = match outcome.untried.len() - 1 {
            0 => String::new(),
            others => format!("; {} with -v", counted(others, "other")),
        };
        lines.push(("not tried", format!("{first}{others}")));
    }
    lines
}

fn choice(task: &FitTask<'_>, outcome: &FitOutcome, chosen: usize) -> Vec<Line> {
    let validated = task.states * VALIDATION_FACTOR;
    let candidate = &outcome.candidates[chosen];
    let program = &outcome.programs[candidate.program];
    let [add, multi] = candidate.elements;
    let mixture = program.mixture.as_ref();
    let mixture = mixture.map(|mixture| format!(" for inputs; {}", mixture.text));
    let deadline = task.scene.deadline;
    let deadline = deadline.map(|deadline| format!(", deadline {deadline} us"));
    let resources = &candidate.resources;
    vec![
        (
            "program",
            format!(
                "{}, {}, in {}{}",
                program.name,
                counted(candidate.operations, "operation"),
                candidate.format,
                mixture.unwrap_or_default()
            ),
        ),
        (
            "sin, cos",
            format!(
                "{}, alone {} of the tolerance",
                program.treatment,
                percent(program.model_share)
            ),
        ),
        (
            "schedule",
            format!(
                "{} on {add}+{multi} elements, {:.3} us{}",
                counted(candidate.cycles, "cycle"),
                candidate.microseconds,
                deadline.unwrap_or_default()
            ),
        ),
        (
            "worst error",
            format!(
                "{}, median {}, {}",
                exponential(candidate.normwise.worst),
                exponential(candidate.normwise.median),
                measure_text(&format!("at least {validated} states of the scene")),
            ),
        ),
        ("tolerance", allowed(task, candidate.used)),
        (
            "device",
            format!(
                "{} of {}: look-up tables {:.0}, memory blocks {:.0}, multiplier blocks {} \
                 (estimated); {:.0} cells",
                share_percent(candidate.share),
                task.machine.device.device().name,
                resources.look_up_tables,
                resources.memory_blocks,
                round(resources.multiplier_blocks, 2),
                candidate.cells
            ),
        ),
    ]
}

/// The used part of a scene's tolerances, each with its own measure.
fn allowed(task: &FitTask<'_>, used: f64) -> String {
    let needs = task.scene.outputs.iter();
    let allowed: Vec<String> = needs
        .filter_map(|need| Some(format!("{} {}", need.pattern, need.tolerance?)))
        .collect();
    if allowed.is_empty() {
        "none".to_owned()
    } else {
        format!(
            "{} of it at the worst output: {}",
            percent(used),
            allowed.join("; ")
        )
    }
}

/// Reason why no program meets the scene: the nearest ones.
fn refusal(task: &FitTask<'_>, outcome: &FitOutcome) -> Vec<Line> {
    let candidates = || outcome.candidates.iter();
    let fastest = candidates().min_by_key(|candidate| candidate.cycles);
    let exact = candidates().filter(|candidate| candidate.used.is_finite());
    let exact = exact.min_by(|a, b| a.used.total_cmp(&b.used));
    let mut lines = Vec::new();
    if let (Some(fastest), Some(deadline)) = (fastest, task.scene.deadline) {
        let time = fastest.microseconds;
        lines.push(("fastest", format!("{time:.3} us of {deadline} us")));
    }
    if let Some(exact) = exact {
        let used = percent(exact.used);
        let accepted = percent(task.accepted());
        let text = format!("{used} of the tolerance; up to {accepted} are accepted");
        lines.push(("most exact", text));
    }
    lines
}

/// Facts about the choice: the states it was tried at, and the results.
fn held(task: &FitTask<'_>, outcome: &FitOutcome, challenge: &Challenge) -> Vec<Line> {
    let fresh = counted(challenge.fresh, "fresh state");
    let seed = challenge.seed;
    let mut needs = task.scene.outputs.iter();
    if !needs.any(|need| need.tolerance.is_some()) {
        let text =
            format!("every error is allowed; all results are numbers at {fresh} (seed {seed})");
        return vec![("held", text)];
    }
    let broken = match outcome.broken {
        0 => String::new(),
        broken => format!(
            "; {} came above {}",
            counted(broken, "other choice"),
            percent(task.accepted())
        ),
    };
    let mut lines = vec![
        (
            "held",
            format!(
                "at {fresh} (seed {seed}), at most {} of the tolerance: with a confidence of \
                 95 %, at {:.4} % of the states in the ranges, or more",
                percent(challenge.fresh_used),
                (challenge.share() * 1e6).floor() / 1e4,
            ),
        ),
        (
            "searched",
            format!(
                "{}, at corners and in climbs from the worst: at most {} of the tolerance{broken}",
                counted(challenge.directed, "more state"),
                percent(challenge.used),
            ),
        ),
        ("sources", sources(outcome)),
        match outcome.bound {
            Some(bound) if bound.holds() => (
                "proved",
                format!(
                    "for every state in the ranges: bounds of the rounding of all {} outputs, at \
                     most {} of the tolerance",
                    bound.outputs,
                    percent(bound.used)
                ),
            ),
            Some(bound) => {
                let largest = if bound.used.is_finite() {
                    format!("{} of it", percent(bound.used))
                } else {
                    "without end".to_owned()
                };
                let text = format!(
                    "for every state: bounds of the rounding are within the tolerance for {} of \
                     {} outputs, the largest is {largest}",
                    bound.proved, bound.outputs,
                );
                ("not proved", text)
            }
            None => (
                "not proved",
                "for every state: no bound was computed (the program is large, has series or a \
                 format for every value, or reads inputs without a range)"
                    .to_owned(),
            ),
        },
    ];
    let sizes = scales(task);
    if !sizes.is_empty() {
        let text = format!("or of its usual size where that is larger: {sizes}");
        lines.push(("parts", format!("of an array's largest element, {text}")));
    }
    let mut tolerances = task.scene.outputs.iter().filter_map(|need| need.tolerance);
    if tolerances.any(|one| one.measure == Measure::Relative && one.scale.is_none()) {
        let text = "of the element, or of a thousandth of its usual size where that is larger";
        lines.push(("parts", text.to_owned()));
    }
    lines
}

fn sources(outcome: &FitOutcome) -> String {
    let Some(sources) = outcome.sources else {
        return "not separated: values have their own formats".to_owned();
    };
    let [data, series, operations] =
        [sources.data, sources.series, sources.operations].map(percent);
    format!("data {data}, series {series}, operations {operations}, at the worst states")
}

/// Result of the scene's motion.
fn over_time(outcome: &FitOutcome, motion: &MotionShare) -> String {
    let energy = motion.energy.map(|energy| {
        format!(
            "; energy drifts by {} of the largest kinetic energy, {} allowed",
            exponential(energy.drift),
            exponential(energy.allowed)
        )
    });
    format!(
        "{} s of the scene's motion in {}: {} of the largest displacement of a watched joint, {} \
         allowed{}; {} erred more",
        motion.time,
        counted(motion.steps, "step"),
        exponential(motion.error),
        exponential(motion.allowed),
        energy.unwrap_or_default(),
        counted(outcome.drifted, "cheaper choice")
    )
}

/// The least sizes that errors of arrays are relative to.
fn scales(task: &FitTask<'_>) -> String {
    let mut sizes: Vec<String> = Vec::new();
    for need in &task.scene.outputs {
        let array = &need.pattern.array;
        let is_normwise = |tolerance: &OutputTolerance| tolerance.measure == Measure::Norm;
        let Some(tolerance) = need.tolerance.filter(is_normwise) else {
            continue;
        };
        let size = match tolerance.scale {
            Some(scale) => format!("{} {scale} (the scene's)", need.pattern),
            None => format!("{array} {:.3e}", task.sizes.get(array)),
        };
        if !sizes.contains(&size) {
            sizes.push(size);
        }
    }
    sizes.join(", ")
}

/// Result of the runs on the machine.
fn run(confirmation: &Confirmation) -> String {
    if !confirmation.remark.is_empty() {
        return format!("not: {}", confirmation.remark);
    }
    format!(
        "cycle by cycle, {} of {} from memory images at the worst states, {} the evaluator's bit \
         for bit; {} of the tolerance",
        counted(confirmation.simulated, "run"),
        counted(confirmation.cycles, "cycle"),
        if confirmation.equal { "all" } else { "NOT" },
        percent(confirmation.simulated_used),
    )
}
