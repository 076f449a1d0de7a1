//! `robovec bench --robots`: functions of robots beside other libraries.

use super::bench::{BenchArguments, FORMULATIONS, LoadedSubject, drawn, outcomes, usual_equations};
use super::{CommandFailure, generation, input, subjects};
use indicatif::ProgressBar;
use robovec_bench::BenchOutcome;
use robovec_bench::contestant::ContestantFamily;
use robovec_bench::task::BenchTask;
use robovec_dynamics::generate::{Options, contenders};
use robovec_explore::placing::placed;
use robovec_model::Model;
use robovec_model::robot::{RobotBase, read_robot};
use robovec_present::number::or_dash;
use robovec_present::text_table;
use robovec_schedule::PlaceOptions;
use std::path::Path;

/// The robots that ship, with the motion of their bases.
const OWN: [(&str, &[u8], RobotBase); 4] = [
    (
        "arm",
        include_bytes!("../../examples/robots/arm.urdf"),
        RobotBase::Fixed,
    ),
    (
        "gripper",
        include_bytes!("../../examples/robots/gripper.urdf"),
        RobotBase::Fixed,
    ),
    (
        "oblique",
        include_bytes!("../../examples/robots/oblique.urdf"),
        RobotBase::Fixed,
    ),
    (
        "quadruped",
        include_bytes!("../../examples/robots/quadruped.urdf"),
        RobotBase::Floating,
    ),
];

/// Name of the C for many states in binary32.
pub(super) const SINGLE: &str = "batch f32";

/// The passes before a program is placed.
const ARRAY: &str = "atomise,zero-removal,balance,cse,dce";

/// The libraries of the table.
const OTHERS: [&str; 3] = ["Pinocchio", "CasADi", "MuJoCo"];

/// The table of all robots and functions; outcomes are added to the results.
pub(super) fn run(
    arguments: &BenchArguments,
    folder: &Path,
    bar: &ProgressBar,
    results: &mut Vec<(String, Vec<BenchOutcome>)>,
) -> Result<String, CommandFailure> {
    let wanted = |task: &BenchTask| {
        let name = arguments.function.as_deref();
        name.is_none_or(|name| name == task.name())
    };
    let (mut rows, mut reasons) = (Vec::new(), Vec::new());
    for (robot, model) in robots(arguments)? {
        for task in BenchTask::ALL.into_iter().filter(wanted) {
            let (module, replaced) = usual_equations(&model, task, arguments.largest)?;
            let loaded = LoadedSubject {
                name: format!("{robot}-{}", task.name()),
                file: None,
                module,
                model: Some(model.clone()),
                task: Some(task),
                replaced,
            };
            let outcomes = outcomes(&loaded, arguments, folder, bar)?;
            bar.set_message(format!("{}: placing", loaded.name));
            let placed = cycles(&model, task)?;
            rows.push(row(&robot, &model, task, &outcomes, placed));
            for outcome in &outcomes {
                let why = outcome.failure.as_ref();
                reasons.extend(why.map(|why| format!("{}, {}: {why}", loaded.name, outcome.name)));
            }
            results.push((loaded.name, outcomes));
        }
    }
    let head = "robot | >joints | function | >operations | >C | >batch | >batch f32 | >Pinocchio \
                | >CasADi | >MuJoCo | >faster | >cycles";
    let mut text = text_table(head, &rows);
    text += &format!(
        "\n\nns per state, results compared first ({}); faster: C against the best library; \
         cycles: balanced and placed, machines {} and, where there are divisions, {}\n",
        drawn(arguments),
        input::USUAL_MACHINE,
        input::WITH_DIVIDER
    );
    for reason in reasons {
        text += &format!("no time for {reason}\n");
    }
    Ok(text)
}

fn robots(arguments: &BenchArguments) -> Result<Vec<(String, Model)>, CommandFailure> {
    if arguments.subjects.is_empty() {
        let read = OWN.iter().map(|(name, bytes, base)| {
            let read = read_robot(name, bytes, *base).expect("what ships is read");
            ((*name).to_owned(), read.model)
        });
        return Ok(read.collect());
    }
    let mut robots = Vec::new();
    for subject in &arguments.subjects {
        let (name, model) = subjects::named_model(subject)?;
        let Some(model) = model else {
            return Err(CommandFailure::plain(format!(
                "{subject} is not a model: --robots takes .urdf and .mbs files"
            )));
        };
        robots.push((name, model));
    }
    Ok(robots)
}

/// The fewest cycles of the formulations that take part.
fn cycles(model: &Model, task: BenchTask) -> Result<Option<u32>, CommandFailure> {
    let options = Options {
        external_forces: false,
        ..Options::default()
    };
    let found = contenders(model, task.kind(), task.formulations(), &options);
    let mut possible = found.possible;
    possible.sort_by_key(|contender| contender.operations);
    let mut least = None;
    for contender in possible.into_iter().take(FORMULATIONS) {
        let mut module = contender.module;
        let passes = input::passes(ARRAY)?;
        generation::transform_remarking(&mut module, &passes, &mut std::io::sink())?;
        let machine = input::machine(input::usual_machine(&module.functions[0])?)?;
        // What a machine cannot hold has no cycles on it.
        let placed = placed(&module, &machine, PlaceOptions::default()).ok();
        let own = placed.map(|placed| placed.summary.cycles);
        least = least.into_iter().chain(own).min();
    }
    Ok(least)
}

/// The smallest time of those that are meant.
fn fastest(outcomes: &[BenchOutcome], is_meant: impl Fn(&BenchOutcome) -> bool) -> Option<f64> {
    let meant = outcomes.iter().filter(|outcome| is_meant(outcome));
    let times = meant.filter_map(|outcome| outcome.nanoseconds);
    times.min_by(f64::total_cmp)
}

fn row(
    robot: &str,
    model: &Model,
    task: BenchTask,
    outcomes: &[BenchOutcome],
    cycles: Option<u32>,
) -> Vec<String> {
    let own = |way: &str| {
        fastest(outcomes, |outcome| {
            outcome.family == ContestantFamily::Model && outcome.name.ends_with(&format!(", {way}"))
        })
    };
    let others = OTHERS.map(|name| fastest(outcomes, |outcome| outcome.name == name));
    let scalar = own("straight-line");
    let best = others.into_iter().flatten().min_by(f64::total_cmp);
    let operations = outcomes.iter().filter_map(|outcome| outcome.operations);
    let time = |time: Option<f64>| or_dash(time, |time| format!("{time:.1}"));
    let mut row = vec![
        robot.to_owned(),
        model.joints.len().to_string(),
        task.title().to_owned(),
        or_dash(operations.min(), |count| count.to_string()),
        time(scalar),
        time(own("batch")),
        time(own(SINGLE)),
    ];
    row.extend(others.map(time));
    row.push(or_dash(best.zip(scalar), |(best, own)| {
        format!("{:.2}", best / own)
    }));
    row.push(or_dash(cycles, |cycles| cycles.to_string()));
    row
}
