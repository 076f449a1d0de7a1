//! `robovec fit`: the cheapest program and machine for a scene, its meaning
//! (`--explain`), and what it need not model (`--reduce`).

mod explanation;
mod neglect;

use super::flags::{SEED, states, whole};
use super::output::result_files;
use super::{CommandFailure, input, output, progress};
use clap::Args;
use indicatif::ProgressBar;
use robovec_analysis::rounding::usual_states;
use robovec_dynamics::generate::{Formulation, MomentOrigin, PrefixNetwork};
use robovec_explore::fit::confirm::{self, Confirmation};
use robovec_explore::fit::{
    self, CostMeasure, FitError, FitOutcome, FitTask, MotionTolerance, SinePlace,
};
use robovec_explore::optimise::start::FORMULATIONS;
use robovec_explore::program::view;
use robovec_explore::scene::{SceneFile, SceneSubject};
use robovec_framework::scene::ArraySizes;
use robovec_io::files::Replace;
use robovec_ir::{Machine, Module, print};
use robovec_present::json::json_text;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Questions that search for no program.
const SEARCHLESS: [&str; 2] = ["explain", "reduce"];

/// Find the cheapest program, number format and machine that meet a scene
#[derive(Args, Debug)]
pub(super) struct FitArguments {
    /// The scene (.scene.toml)
    scene: PathBuf,
    /// Check the scene and print its joints, outputs, inputs and the gain of each, without a search
    #[arg(long, conflicts_with_all = ["reduce", "output"])]
    explain: bool,
    /// Instead of a program, find the joints, bodies, forces and terms that the
    /// scene does not need; the scene must have a section [motion]
    #[arg(long)]
    reduce: bool,
    /// Machine whose elements, memories and clock are used; by default the scene's, else thesis, or solver
    /// for equations that divide
    #[arg(long)]
    machine: Option<String>,
    /// Formulations to try; by default the scene's, or all that may be the best
    #[arg(long, conflicts_with_all = SEARCHLESS, value_delimiter = ',', value_parser = super::generation::formulations())]
    formulation: Vec<String>,
    /// Place where sines and cosines are computed; by default as in the
    /// scene, or on the host
    #[arg(long, conflicts_with_all = SEARCHLESS, value_enum)]
    trigonometry: Option<SinePlace>,
    /// Cost to minimise
    #[arg(long, conflicts_with_all = SEARCHLESS, value_enum, default_value_t)]
    cost: CostMeasure,
    /// Number of random states of the scene; by default more for smaller
    /// functions
    #[arg(long, conflicts_with_all = SEARCHLESS, default_value_t = 0, hide_default_value = true,
          add = states(0, 100_000))]
    states: u32,
    /// Seed of the states
    #[arg(long, conflicts_with_all = SEARCHLESS, default_value_t = 1, add = SEED)]
    seed: u64,
    /// Multiple of the usual number of states at which a choice is tested
    /// before it is accepted
    #[arg(long, conflicts_with_all = SEARCHLESS, default_value_t = 1,
          add = whole(1, 16, "the time grows with it, but the guaranteed share of states hardly"))]
    effort: u32,
    /// Folder for the choice (program.rvir, machine.toml) and fit.html, fit.csv, fit.json, fit.svg;
    /// with --reduce for the reduced scene, its model and laws, and reduce.html, reduce.csv, reduce.json,
    /// reduce.svg
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

pub(super) fn run(arguments: &FitArguments) -> Result<String, CommandFailure> {
    if arguments.explain {
        return explanation::run(arguments);
    }
    if arguments.reduce {
        return neglect::run(arguments);
    }
    let folder = arguments.output.as_deref();
    output::refuse_foreign(folder, &["program.rvir", "machine.toml"], Replace::Results)?;
    let file = input::scene(&arguments.scene)?;
    let fail =
        |error: String| CommandFailure::plain(format!("{}: {error}", arguments.scene.display()));
    let general = file.module().map_err(|error| fail(error.to_string()))?;
    let machine = machine(arguments, &file, &general)?;
    let operations = robovec_ir::count::Counts::of(&general.functions[0]).operations;
    let states = match arguments.states {
        0 => usual_states(operations),
        count => count,
    };
    let bar = progress::spinner();
    let motion = motion(&file, arguments, &machine, &bar)?;
    let task = FitTask {
        scene: &file.scene,
        general: &general,
        formulations: formulations(arguments, &file, &general),
        machine: &machine,
        trigonometry: place(arguments, &file),
        cost: arguments.cost,
        sizes: ArraySizes::of(view(&general), Some(&file.scene)),
        states,
        seed: arguments.seed,
        effort: arguments.effort,
        motion: motion.as_ref(),
    };
    let progress = |what: &str| bar.set_message(what.to_owned());
    let outcome = fit::fit(&task, &progress).map_err(|error| {
        let message = format!("{}: {error}", arguments.scene.display());
        let notes = match error {
            FitError::Placement(_) => input::other_machine(),
            FitError::Measure(_) | FitError::NoProgram(_) => Vec::new(),
        };
        CommandFailure::advised(message, notes)
    })?;
    let confirmation = match outcome.chosen.zip(outcome.challenge.as_ref()) {
        Some((chosen, challenge)) => {
            bar.set_message("running the choice cycle by cycle");
            let candidate = &outcome.candidates[chosen];
            let choice = (&outcome.programs[candidate.program], candidate);
            let confirmation = confirm::confirm(&task, choice, challenge);
            Some(confirmation.map_err(|error| fail(error.to_string()))?)
        }
        None => None,
    };
    bar.finish_and_clear();
    if let Some(folder) = &arguments.output {
        write(folder, &task, &outcome, confirmation.as_ref())?;
    }
    let text = fit::text::text(
        &task,
        &outcome,
        confirmation.as_ref(),
        progress::is_verbose(),
    );
    if confirmation.is_some_and(|confirmation| confirmation.holds()) {
        return Ok(text);
    }
    // What was found is told all the same, but a script must not go on with it.
    output::write_stdout(|stdout| stdout.write_all(text.as_bytes()))?;
    let message = match outcome.chosen {
        None => "no program meets the scene",
        Some(_) => "the choice did not hold cycle by cycle",
    };
    let advice = "allow a larger error or a later deadline, or choose a machine with more elements";
    Err(CommandFailure::advised(message, vec![advice.to_owned()]))
}

/// The motion whose error the scene limits.
fn motion<'a>(
    file: &'a SceneFile,
    arguments: &FitArguments,
    machine: &'a Machine,
    bar: &ProgressBar,
) -> Result<Option<MotionTolerance<'a>>, CommandFailure> {
    if file.motion.is_none() {
        return Ok(None);
    }
    bar.set_message("the motion in binary64");
    let folder = input::folder(&arguments.scene);
    let laws = input::laws_of(file, folder)?;
    MotionTolerance::new(file, laws, machine).map_err(|error| {
        let notes = error.advice().map(str::to_owned).into_iter().collect();
        CommandFailure::advised(format!("{}: {error}", arguments.scene.display()), notes)
    })
}

fn place(arguments: &FitArguments, file: &SceneFile) -> SinePlace {
    let usual = if file.scene.series {
        SinePlace::Elements
    } else {
        SinePlace::Host
    };
    arguments.trigonometry.unwrap_or(usual)
}

/// The machine requested, else the scene's, else one that the function needs.
fn machine(
    arguments: &FitArguments,
    file: &SceneFile,
    general: &Module,
) -> Result<Machine, CommandFailure> {
    let asked = arguments.machine.as_ref().or(file.scene.machine.as_ref());
    match asked {
        Some(name) => input::machine(name),
        None => input::machine(input::usual_machine(&general.functions[0])?),
    }
}

/// The formulations that are tried: those requested, else the scene's, else all
/// that can be the best, without those that the generator refuses.
fn formulations(
    arguments: &FitArguments,
    file: &SceneFile,
    general: &Module,
) -> Vec<(Formulation, Module)> {
    let own = (file.formulation(), general.clone());
    let SceneSubject::Model(subject) = &file.subject else {
        return vec![own];
    };
    let asked = arguments.formulation.iter();
    let mut wanted: Vec<Formulation> = asked
        .filter_map(|name| Formulation::from_name(name))
        .collect();
    if wanted.is_empty() && file.scene.formulation.is_some() {
        return vec![own];
    }
    if wanted.is_empty() {
        wanted = tried().collect();
    }
    let made = wanted.into_iter();
    made.filter_map(|one| Some((one, subject.equations(one).ok()?)))
        .collect()
}

/// Formulations that can be the best of a scene: the input, the starts of every
/// search, of the two networks only the one with the shorter paths, and those
/// that give only accelerations of long chains.
fn tried() -> impl Iterator<Item = Formulation> {
    let shared = FORMULATIONS.into_iter();
    let shared = shared
        .filter(|&one| one != Formulation::prefix(PrefixNetwork::BrentKung, MomentOrigin::Body));
    [Formulation::Recursive]
        .into_iter()
        .chain(shared)
        .chain([Formulation::Articulated])
}

fn write(
    folder: &Path,
    task: &FitTask<'_>,
    outcome: &FitOutcome,
    confirmation: Option<&Confirmation>,
) -> Result<(), CommandFailure> {
    let json = json!({
        "scene": task.scene.name,
        "machine": task.machine.name,
        "machine_hash": task.machine.content_hash().text(),
        "states": task.states,
        "seed": task.seed,
        "chosen": outcome.chosen,
        "challenge": outcome.challenge,
        "bound": outcome.bound,
        "sources": outcome.sources,
        "motion": outcome.motion,
        "broken": outcome.broken,
        "drifted": outcome.drifted,
        "untried": outcome.untried,
        "cost": task.cost,
        "confirmation": confirmation,
        "front": outcome.front(),
        "programs": outcome.programs.iter().map(|program| json!({
            "name": program.name,
            "pipeline": program.pipeline,
            "formulation": program.formulation.name(),
            "trigonometry": program.treatment.to_string(),
            "mixture": program.mixture.as_ref().map(|mixture| &mixture.text),
            "share_of_tolerance": program.model_share,
        })).collect::<Vec<_>>(),
        "candidates": outcome.candidates,
    });
    let table = fit::text::candidates_table(outcome);
    let mut files = result_files(&table, json_text(&json), &fit::text::figure(task, outcome));
    let page = fit::text::page(task, outcome, confirmation);
    files.push(("fit.html".to_owned(), page));
    if let Some(chosen) = outcome.chosen {
        let candidate = &outcome.candidates[chosen];
        let program = &outcome.programs[candidate.program];
        let ready = confirm::ready(task, program, candidate)
            .map_err(|error| CommandFailure::plain(error.to_string()))?;
        let machine = toml::to_string(&ready.machine)
            .expect("a machine that was read is one that can be written");
        files.push((
            "program.rvir".to_owned(),
            print::print_module(&ready.module),
        ));
        files.push((
            "machine.toml".to_owned(),
            format!("# Written by robovec.\n{machine}"),
        ));
    }
    output::write_files(folder, &files)
}
