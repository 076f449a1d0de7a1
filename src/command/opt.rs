//! `robovec-opt`.

use super::arguments::{self, OptimiserArguments, TableFormat};
use super::dump::DumpFolder;
use super::listing::{self, MeasuredStage};
use super::summary::RunSummary;
use super::{
    CommandFailure, explain, input, output, progress, reduction, reproducer, rules, simulation,
};
use clap::FromArgMatches;
use clap_complete::env::{CompleteEnv, Shells};
use robovec_fpga::rtl::DESCRIPTION;
use robovec_framework::manager::{
    self, Config, PassFilter, PrintChanged, RunError, RunOutcome, usage,
};
use robovec_framework::pass::TargetFolder;
use robovec_framework::pipeline::Pipeline;
use robovec_framework::scene::Scene;
use robovec_framework::trail::Trail;
use robovec_io::files::{Replace, limited, set_force};
use robovec_io::sources::ReadEquations;
use robovec_ir::diagnostic::{Diagnostic, Label, Report, counted};
use robovec_ir::states::States;
use robovec_ir::{Function, Machine, Module, SourceSet, print};
use robovec_rules::RuleSet;
use robovec_view::report::{self, ReadCounts};
use std::ffi::OsString;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

/// Runs the program.
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    keep_freed();
    CompleteEnv::with_factory(arguments::command).complete();
    let words = arguments::normalise(arguments);
    let matches = arguments::command().get_matches_from(&words);
    let arguments = match OptimiserArguments::from_arg_matches(&matches) {
        Ok(arguments) => arguments,
        Err(error) => error.exit(),
    };
    progress::set(arguments.telling);
    set_force(arguments.force);
    let result = if arguments.run_reproducer {
        reproduced(&arguments, &words).and_then(|arguments| run(&arguments))
    } else {
        run(&arguments)
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.emit();
            ExitCode::FAILURE
        }
    }
}

/// Arguments of the command in a reproducer; those given here override them.
fn reproduced(
    arguments: &OptimiserArguments,
    words: &[OsString],
) -> Result<OptimiserArguments, CommandFailure> {
    let Some(path) = &arguments.input else {
        return Err(CommandFailure::plain("no reproducer to run"));
    };
    let command = reproducer::command(path, &input::text(path, &limited::EQUATIONS)?)?;
    let program = words.iter().take(1).cloned();
    let given = words
        .iter()
        .skip(1)
        .filter(|word| *word != "--run-reproducer");
    let all = program
        .chain(command.into_iter().map(OsString::from))
        .chain(given.cloned());
    let parsed = arguments::command()
        .args_override_self(true)
        .try_get_matches_from(all)
        .and_then(|matches| OptimiserArguments::from_arg_matches(&matches));
    parsed.map_err(|error| {
        CommandFailure::plain(format!(
            "{}: the command in its header: {error}",
            path.display()
        ))
    })
}

const NO_PASSES: &str = "no passes were named: these are the equations as read\n  \
    -passes='$shorten,place'  places them on the elements of a machine\n  \
    -passes='$cpu,codegen{target=c}' -o FOLDER  writes C\n  \
    --list-passes  lists all, --report - prints what the equations cost\n";

/// Inputs of the user, read.
struct GivenInputs {
    pipeline: Pipeline,
    rules: RuleSet,
    scene: Option<Scene>,
    target: Option<TargetFolder>,
    machine: Machine,
    input: ReadEquations,
    /// The reading of equations, scene and machine.
    stage: MeasuredStage,
}

/// Reads everything the user wrote, before any work is done.
fn read_inputs(arguments: &OptimiserArguments) -> Result<GivenInputs, CommandFailure> {
    let pipeline = input::passes_or_empty(arguments.passes.as_deref())?;
    if let Some(path) = &arguments.output
        && !pipeline.passes().any(|pass| pass.info.name == "codegen")
    {
        output::refuse_wrong(path, true)?;
    }
    let asked = arguments.machine.as_deref();
    let asked = asked.map(input::machine).transpose()?;
    let rules = rules::sound(&arguments.rules, !arguments.no_default_rules)?;
    if arguments.target.is_some() && !reproducer::uses_target(&pipeline) {
        return Err(CommandFailure::advised(
            "no pass uses the target of '--target'".to_owned(),
            vec!["end the pipeline with codegen{target=template}".to_owned()],
        ));
    }
    let target = arguments.target.as_deref().map(input::target).transpose()?;
    let Some(path) = &arguments.input else {
        return Err(CommandFailure::plain("no input file"));
    };
    if arguments.print_pipeline {
        // The standard error may be closed; the pipeline still runs.
        let _ = writeln!(io::stderr(), "-passes={pipeline}");
    }
    let start = usage().0;
    let (scene, input) = scene_and_input(arguments, path)?;
    let machine = match asked {
        Some(machine) => machine,
        None => input::machine_for(None, scene.as_ref())?,
    };
    Ok(GivenInputs {
        pipeline,
        rules,
        scene,
        target,
        machine,
        input,
        stage: stage_since("(read)", start),
    })
}

/// The stage that began at a processor time, in seconds, and ends now.
fn stage_since(name: &'static str, start: f64) -> MeasuredStage {
    let (now, peak_mb) = usage();
    MeasuredStage {
        name,
        cpu_s: now - start,
        peak_mb,
    }
}

fn run(arguments: &OptimiserArguments) -> Result<(), CommandFailure> {
    if let Some(text) = information(arguments)? {
        return output::write_stdout(|stdout| stdout.write_all(text.as_bytes()));
    }
    output::refuse_foreign(arguments.output.as_deref(), &[""], Replace::Own)?;
    let GivenInputs {
        pipeline,
        rules,
        scene,
        target,
        machine,
        mut input,
        stage,
    } = read_inputs(arguments)?;
    let scene = scene.as_ref();
    if let Some(name) = &arguments.function {
        select(&mut input.module, name)?;
    }
    if pipeline.steps.is_empty() && arguments.simulate.is_some() {
        simulation::check(&input, &machine)?;
    }
    let is_reported = arguments.report.is_some();
    let read = if is_reported {
        ReadCounts::of(&input.module)
    } else {
        Vec::new()
    };
    let mut trail = arguments.explain.is_some().then(Trail::new);
    let target = (&machine, &rules, scene, target.as_ref());
    let drawn = (input::states(scene, arguments.seed), scene.is_some());
    let summary = RunSummary::begin(arguments, &pipeline, &input.module, &machine, drawn);
    let kept = reduction::keep(arguments, &input.module);
    let outcome = transform(arguments, &pipeline, target, &mut input, trail.as_mut());
    let outcome = outcome.map_err(|failure| {
        reduction::follow_up(failure, kept.as_ref(), &pipeline, target, arguments)
    })?;
    let told = measured(arguments, scene, &machine, (&input.module, &outcome), read)?;
    let start = usage().0;
    if let (Some(asked), Some(trail)) = (&arguments.explain, &trail) {
        let account =
            explain::explain(asked, &input, trail, &machine, &States::new(arguments.seed))?;
        output::write_stdout(|stdout| stdout.write_all(account.as_bytes()))?;
    }
    if arguments.explain.is_none() || arguments.output.is_some() {
        let path = arguments.output.as_deref();
        write_result(path, &input.module, &outcome)?;
    }
    let stages = [stage, stage_since("(write)", start)];
    let mut text = told;
    if pipeline.steps.is_empty() && arguments.simulate.is_none() && arguments.report.is_none() {
        text += NO_PASSES;
    }
    if let Some(summary) = summary {
        text += &summary.text(&input.module);
    }
    if let Some(format) = arguments.stats {
        text += &listing::statistics(&outcome.records, format);
    }
    let is_timed = arguments.telling.verbose.then_some(TableFormat::Table);
    if let Some(format) = arguments.time_passes.or(is_timed) {
        text += &listing::times(&outcome.records, &stages, format);
    }
    // Nobody is left to tell when the standard error is closed.
    let _ = io::stderr().write_all(text.as_bytes());
    Ok(())
}

/// Report and simulation that were requested.
fn measured(
    arguments: &OptimiserArguments,
    scene: Option<&Scene>,
    machine: &Machine,
    results: (&Module, &RunOutcome),
    read: Vec<ReadCounts>,
) -> Result<String, CommandFailure> {
    let simulated = match arguments.simulate {
        Some(count) => simulation::simulate(
            results.0,
            machine,
            count,
            &input::states(scene, arguments.seed),
        )?,
        None => String::new(),
    };
    let report = match &arguments.report {
        Some(path) => {
            let options = report::ReportOptions {
                states: input::states(scene, arguments.seed),
                read,
                ..report::ReportOptions::default()
            };
            write_report(path, results, machine, &options)?
        }
        None => String::new(),
    };
    Ok(report + &simulated)
}

/// The scene, if there is one, and the equations, perhaps the scene's.
fn scene_and_input(
    arguments: &OptimiserArguments,
    path: &Path,
) -> Result<(Option<Scene>, ReadEquations), CommandFailure> {
    if path.to_string_lossy().ends_with(".scene.toml") && arguments.scene.is_none() {
        let file = input::scene(path)?;
        let module = file
            .module()
            .map_err(|error| CommandFailure::plain(format!("{}: {error}", path.display())))?;
        return Ok((Some(file.scene), ReadEquations::of(path, module)));
    }
    let scene = match &arguments.scene {
        None => None,
        Some(scene) => Some(input::scene(scene)?.scene),
    };
    let wished = scene.as_ref().and_then(|scene| scene.function.as_deref());
    let function = arguments.function.as_deref().or(wished);
    let input = input::equations_or_model(path, arguments.language, function)?;
    Ok((input::scene_of(&input, scene), input))
}

/// Answers that need no input.
fn information(arguments: &OptimiserArguments) -> Result<Option<String>, CommandFailure> {
    if arguments.list_passes {
        return Ok(Some(listing::passes()));
    }
    if arguments.list_machines {
        return Ok(Some(listing::machines()));
    }
    if let Some(name) = &arguments.help_pass {
        return listing::pass(name).map(Some);
    }
    if let Some(shell) = &arguments.completion {
        return completion("robovec-opt", shell).map(Some);
    }
    Ok(None)
}

/// The script that makes a shell complete a program's command line.
pub(super) fn completion(program: &str, shell: &str) -> Result<String, CommandFailure> {
    let shells = Shells::builtins();
    let Some(completer) = shells.completer(shell) else {
        return Err(CommandFailure::plain(format!(
            "no completion for the shell '{shell}'"
        )));
    };
    let mut script = Vec::new();
    completer
        .write_registration("COMPLETE", program, program, program, &mut script)
        .map_err(|error| CommandFailure::plain(format!("cannot write the completion: {error}")))?;
    Ok(String::from_utf8_lossy(&script).into_owned())
}

/// Keeps the requested function of a module, else direct dynamics or the only.
pub(super) fn select_one(
    module: &mut Module,
    input: &str,
    function: Option<&str>,
) -> Result<(), CommandFailure> {
    let wanted = function.unwrap_or("dirdyna");
    let is_there = module.functions.iter().any(|known| known.name == wanted);
    if module.functions.len() != 1 && (function.is_some() || is_there) {
        select(module, wanted)?;
    }
    if module.functions.len() == 1 {
        return Ok(());
    }
    let names: Vec<&str> = module.functions.iter().map(|f| f.name.as_str()).collect();
    Err(CommandFailure::advised(
        format!("{input} holds {}", counted(names.len(), "function")),
        vec![format!("choose one with --function: {}", names.join(", "))],
    ))
}

pub(super) fn select(module: &mut Module, name: &str) -> Result<(), CommandFailure> {
    select_all(module, &[name.to_owned()])
}

pub(super) fn select_all(module: &mut Module, wanted: &[String]) -> Result<(), CommandFailure> {
    let names: Vec<String> = module.functions.iter().map(|f| f.name.clone()).collect();
    // The name of a kind stands for all its cases: `sensor` for `sensor_1` ….
    let is = |function: &Function, name: &String| {
        let case = function.name.strip_prefix(name.as_str());
        let case = case.and_then(|rest| rest.strip_prefix('_'));
        function.name == *name || case.is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
    };
    let missing = |name: &&String| !module.functions.iter().any(|function| is(function, name));
    if let Some(name) = wanted.iter().find(missing) {
        let notes = if names.is_empty() {
            vec!["the model has nothing of this kind".to_owned()]
        } else {
            vec![format!("functions: {}", names.join(", "))]
        };
        return Err(CommandFailure::advised(
            format!("there is no function '{name}'"),
            notes,
        ));
    }
    let kept = |function: &Function| wanted.iter().any(|name| is(function, name));
    module.functions.retain(kept);
    Ok(())
}

fn filter(names: Option<&str>) -> PassFilter {
    match names {
        None => PassFilter::None,
        Some("*") => PassFilter::All,
        Some(names) => PassFilter::Named(names.split(',').map(str::to_owned).collect()),
    }
}

/// Tests whether any output shows the effect of each pass.
fn tells_of_passes(arguments: &OptimiserArguments) -> bool {
    arguments.report.is_some()
        || arguments.stats.is_some()
        || arguments.time_passes.is_some()
        || arguments.telling.verbose
}

fn transform(
    arguments: &OptimiserArguments,
    pipeline: &Pipeline,
    (machine, rules, scene, target): (&Machine, &RuleSet, Option<&Scene>, Option<&TargetFolder>),
    input: &mut ReadEquations,
    trail: Option<&mut Trail>,
) -> Result<RunOutcome, CommandFailure> {
    let mut dump = arguments
        .dump_dir
        .as_deref()
        .map(DumpFolder::create)
        .transpose()?;
    let bar = progress::plain();
    let mut progress = |done: usize, total: usize, name: &str| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
        bar.set_message(name.to_owned());
    };
    let print_after = if arguments.print_after_all {
        Some("*")
    } else {
        arguments.print_after.as_deref()
    };
    let result = manager::run(
        &mut input.module,
        pipeline,
        Config {
            machine,
            rules: Some(rules),
            verify_each: arguments.verify_each,
            check_each: arguments.check_each.or_else(|| {
                arguments
                    .auto_reduce
                    .as_ref()
                    .map(|_| reproducer::points(arguments))
            }),
            rounding: arguments.report.is_some().then_some(0),
            states: input::states(scene, arguments.seed),
            scene,
            target,
            print_before: filter(arguments.print_before.as_deref()),
            print_after: filter(print_after),
            print_changed: arguments.print_changed.as_deref().map(|how| match how {
                "diff" => PrintChanged::Diff,
                _ => PrintChanged::Full,
            }),
            dump: dump.as_mut().map(|dump| dump as &mut dyn manager::Dump),
            histories: arguments.print_history,
            trail,
            log: &mut io::stderr().lock(),
            progress: Some(&mut progress),
            limit: arguments.bisect_limit,
            executed: None,
            remarks: !arguments.telling.quiet,
            records: tells_of_passes(arguments),
        },
    );
    bar.finish_and_clear();
    if let Some(dump) = dump {
        dump.finish()?;
    }
    result.map_err(|error| describe(error, arguments, input, machine))
}

/// Turns the manager's error into messages that point into the user's texts.
fn describe(
    error: RunError,
    arguments: &OptimiserArguments,
    input: &ReadEquations,
    machine: &Machine,
) -> CommandFailure {
    match error {
        RunError::Plan(error) => {
            let text = match &arguments.passes {
                Some(text) if !text.starts_with('@') => text.clone(),
                Some(_) | None => String::new(),
            };
            let label = Label::primary(0, error.span.clone());
            let diagnostic = Diagnostic::error()
                .with_message(error.message)
                .with_notes(vec![error.help]);
            let diagnostic = if text.is_empty() {
                diagnostic
            } else {
                diagnostic.with_labels(vec![label])
            };
            CommandFailure(Report::of("<-passes>", text, vec![diagnostic]))
        }
        RunError::Pass {
            pass,
            function,
            error,
        } => {
            let message = format!("{pass}, function '{function}': {}", error.message);
            located(message, error.sources, error.help, input)
        }
        RunError::Given { ref help, .. } => {
            simulation::refusal(&error.to_string(), help, input, machine)
        }
        RunError::Panic { .. } | RunError::Verify { .. } | RunError::Check { .. } => {
            let mut notes = Vec::new();
            if arguments.auto_reduce.is_none() {
                notes.push(
                    "'--auto-reduce' finds the smallest program and the rewrite that show it"
                        .to_owned(),
                );
            }
            CommandFailure::advised(error.to_string(), notes)
        }
        RunError::Io(_) => CommandFailure::plain(error.to_string()),
    }
}

/// A message about equations: in the text read, else with their place named.
fn located(
    message: String,
    sources: SourceSet,
    help: Option<String>,
    input: &ReadEquations,
) -> CommandFailure {
    let mut report = Report::new();
    let mut diagnostic = Diagnostic::error().with_message(message);
    diagnostic.notes.extend(help);
    if let Some(place) = input.module.tables.sources.first(sources) {
        let file = &input.module.tables.sources.files[place.file as usize];
        if *file == input.name
            && let Some(text) = input.text()
        {
            let id = report.add_file(&input.name, text);
            diagnostic
                .labels
                .push(Label::primary(id, report.range_of(id, place)));
        } else {
            diagnostic
                .notes
                .push(format!("the equation is in {file}, line {}", place.line));
        }
    }
    report.push(diagnostic);
    CommandFailure(report)
}

/// Writes the report to its file; returns one for the standard error.
fn write_report(
    path: &Path,
    (module, outcome): (&Module, &RunOutcome),
    machine: &Machine,
    options: &report::ReportOptions,
) -> Result<String, CommandFailure> {
    let records = report::PassRunRecord::of(outcome);
    let report = report::ModuleReport::collect(module, machine, &records, options);
    if path == Path::new("-") {
        return Ok(report.to_text());
    }
    let json = path
        .extension()
        .is_some_and(|extension| extension == "json");
    let text = if json {
        report.to_json()
    } else {
        report.to_text()
    };
    output::write_file(path, |writer| writer.write_all(text.as_bytes()))?;
    Ok(String::new())
}

fn write_result(
    path: Option<&Path>,
    module: &Module,
    outcome: &RunOutcome,
) -> Result<(), CommandFailure> {
    let text = |writer: &mut dyn Write| match &outcome.artifacts[..] {
        [] => print::write_module(module, writer),
        files => files
            .iter()
            .try_for_each(|file| writer.write_all(file.text.as_bytes())),
    };
    match (path, outcome.artifacts.len()) {
        (None, 0 | 1) => output::write_stdout(text),
        (Some(path), 0 | 1) if path == Path::new("-") => output::write_stdout(text),
        (Some(path), count @ (0 | 1)) => {
            output::refuse_wrong(path, count == 0)?;
            output::write_over(path, Replace::Own, text)
        }
        (Some(folder), count) => {
            output::refuse_for_several(folder, count)?;
            let files: Vec<(&str, &str)> = outcome
                .artifacts
                .iter()
                .map(|file| (&*file.name, &*file.text))
                .collect();
            // Most files of hardware are the same for every machine and bear
            // no mark.
            let usual = if files.iter().any(|(name, _)| name.ends_with(DESCRIPTION)) {
                Replace::Anything
            } else {
                Replace::Results
            };
            output::write_folder(folder, &files, usual)
        }
        (None, count) => Err(CommandFailure::advised(
            format!("the pipeline made {count} files"),
            vec!["name a folder for them: -o FOLDER".to_owned()],
        )),
    }
}

/// The largest vector whose release raises glibc's threshold for mapping memory
/// for one vector alone; the threshold is 32 MiB with the header.
const LARGEST_RAISING: usize = 31 << 20;

/// Makes the allocator keep freed memory for later allocations.
///
/// glibc maps the memory of large vectors for each of them and gives it back to
/// the system when they go, which clears the pages of the next one again: two
/// thirds more page faults on a function of 600,000 operations. It stops when
/// such a vector is freed. This one is never written, so it costs nothing.
pub(super) fn keep_freed() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(
        LARGEST_RAISING,
    )));
}
