//! `robovec sim`: a model in motion, at rest (`equilibrium`), around a state
//! (`modal`), and as a unit for other tools (`fmu`).

mod fmu;
mod standing;

use super::flags::{real, whole};
use super::{CommandFailure, input, output, progress};
use clap::{Args, Subcommand, ValueEnum};
use robovec_dynamics::generate::Formulation;
use robovec_dynamics::motion::{
    EVENT_TOLERANCE, EquationSetting, IntegrationMethod, Laws, LoopKeeping, MotionError,
    MultibodySystem, SimulationPlan, SimulationRun, plot, simulate,
};
use robovec_ir::Format;
use robovec_ir::diagnostic::{Diagnostic, Report, Severity, counted};
use robovec_model::mbs::ReadModel;
use robovec_model::{Model, Nature};
use std::fmt::Write as _;
use std::io::{IsTerminal as _, Write as _};
use std::path::PathBuf;
use std::time::Instant;

/// Maximum joints of an open model that is solved with its mass matrix.
const LONG: usize = 60;

/// Steps of the progress bar.
const BAR_LENGTH: f64 = 1000.0;

/// Advice for a link that is not simulated.
const LINK3D_ADVICE: &str = "help: make it a `link` with a law if it only pulls its ends \
                             together, or remove it from the model to run without it";

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Debug)]
enum IntegratorChoice {
    /// Runge-Kutta of fourth order with a fixed step
    Rk4,
    /// Dormand-Prince 5(4) with steps that meet a tolerance
    Dopri,
}

/// Method that keeps loops closed.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Debug)]
enum KeepingChoice {
    /// Dependent joints are computed from the constraints in every evaluation
    Project,
    /// All joints are integrated; accelerations of dependent ones pull them
    /// back
    Baumgarte,
    /// All joints are integrated, and nothing pulls them back
    None,
}

/// Integrate a model in time, or find its equilibrium or its modes
#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(super) struct SimCommand {
    #[command(subcommand)]
    standing: Option<StandingCommand>,
    #[command(flatten)]
    motion: SimArguments,
}

#[derive(Subcommand, Debug)]
enum StandingCommand {
    /// Find the positions at which a model is at rest under its laws
    Equilibrium(standing::EquilibriumArguments),
    /// Find the modes of a model under its laws: frequencies, damping, shapes
    Modal(standing::ModalArguments),
    /// Write an FMU (FMI 3.0) that other simulation tools import
    Fmu(fmu::FmuArguments),
}

/// A model with its laws, as named by the user.
#[derive(Args, Debug)]
struct MovedModel {
    /// Model (.mbs, .urdf, .xml)
    #[arg(required = true)]
    model: Option<PathBuf>,
    /// Laws of springs, dampers, forces and driven joints (TOML)
    #[arg(long, value_name = "FILE")]
    laws: Option<PathBuf>,
    /// Joints held where they start, whatever the model calls them
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    hold: Vec<String>,
}

impl MovedModel {
    fn read(&self) -> Result<(Model, Laws), CommandFailure> {
        // Absent only where a subcommand has its own.
        let path = self.model.as_ref().expect("the command line requires it");
        let mut read = input::model(path)?;
        refuse_left_out(&read)?;
        input::drive(&mut read.model, &self.hold)?;
        let laws = match &self.laws {
            None => Laws::of_model(&read.model),
            Some(path) => input::laws(&read.model, path)?,
        };
        super::emit(&of_laws(&read.model, &laws));
        Ok((read.model, laws))
    }
}

/// Arguments of a run.
#[derive(Args, Debug)]
struct SimArguments {
    #[command(flatten)]
    subject: MovedModel,
    /// Simulated time, s
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0,
          add = real(1e-12, 1e6, "the run is stopped after --max-steps"))]
    time: f64,
    /// Number of rows of the result after the first, at equal intervals
    #[arg(long, value_name = "N", default_value_t = 200,
          add = whole(1, 100_000, "each is a row of the result"))]
    samples: u32,
    /// Integrator
    #[arg(long, value_enum, default_value_t = IntegratorChoice::Dopri)]
    method: IntegratorChoice,
    /// Step of rk4, s
    #[arg(long, value_name = "SECONDS", default_value_t = 1e-3,
          add = real(1e-9, 1e3, "the run is stopped after --max-steps"))]
    step: f64,
    /// Tolerance of dopri per step, absolute and relative
    #[arg(long, value_name = "NUMBER", default_value_t = 1e-8,
          add = real(1e-15, 1.0, "binary64 has no more digits, and a tolerance above 1 is useless"))]
    tolerance: f64,
    /// Maximum number of steps, after which the run stops with an error
    #[arg(long, value_name = "N", default_value_t = 10_000_000,
          add = whole(1, 1_000_000_000, "every step evaluates the model several times"))]
    max_steps: u64,
    /// Format the equations are evaluated in: f16, bf16, f32, f64,
    /// float(EXPONENT,MANTISSA) or fixed(INTEGER,FRACTION)
    #[arg(long, value_name = "FORMAT", default_value_t = Format::BINARY64)]
    number: Format,
    /// Recursion the equations come from [default: recursive; articulated for
    /// more than 60 joints without loops]
    #[arg(long, value_parser = super::generation::formulations())]
    formulation: Option<String>,
    /// Take accelerations from the generated function accelred instead of
    /// solving M qdd + c = Qq
    #[arg(long)]
    accelred: bool,
    /// Take positions and velocities of dependent joints and all accelerations
    /// from the generated functions of the whole step (loop_positions,
    /// loop_velocities, accelred)
    #[arg(long)]
    whole_step: bool,
    /// Method that keeps loops closed
    #[arg(long, value_enum, default_value_t = KeepingChoice::Project)]
    loops: KeepingChoice,
    /// Rate at which --loops=baumgarte pulls loops closed, 1/s
    #[arg(long, value_name = "RATE", default_value_t = 20.0,
          add = real(1e-6, 1e6, "a faster correction is a stiff spring for the integrator"))]
    baumgarte_rate: f64,
    /// Precision of the times of events, s
    #[arg(long, value_name = "SECONDS", default_value_t = EVENT_TOLERANCE,
          add = real(1e-15, 1.0, "times have no more digits in binary64"))]
    event_tolerance: f64,
    /// CSV file to write the events to
    #[arg(long, value_name = "FILE")]
    events: Option<PathBuf>,
    /// Pipeline to run on the equations before they are evaluated
    #[arg(long, value_name = "PIPELINE")]
    passes: Option<String>,
    /// Machine to compile for
    #[arg(long, default_value = "thesis")]
    machine: String,
    /// CSV file to write instead of the standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// SVG file for a drawing of positions and energies
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

pub(super) fn run(command: &SimCommand) -> Result<String, CommandFailure> {
    match &command.standing {
        Some(StandingCommand::Equilibrium(arguments)) => standing::equilibrium(arguments),
        Some(StandingCommand::Modal(arguments)) => standing::modal(arguments),
        Some(StandingCommand::Fmu(arguments)) => fmu::run(arguments),
        None => motion(&command.motion),
    }
}

fn motion(arguments: &SimArguments) -> Result<String, CommandFailure> {
    // Everything the user wrote is read before any work is done.
    let pipeline = input::passes_or_empty(arguments.passes.as_deref())?;
    let machine = input::machine(&arguments.machine)?;
    let (model, laws) = arguments.subject.read()?;
    let model = &model;
    let setting = EquationSetting {
        formulation: formulation(arguments, model),
        passes: arguments.passes.is_some().then_some((&pipeline, &machine)),
        format: arguments.number,
        accelerations: arguments.accelred,
        whole_step: arguments.whole_step,
        scene: None,
        program: None,
    };
    let (mut system, initial) = MultibodySystem::new(model, laws, &setting).map_err(failure)?;
    system.keep_loops(keeping(arguments));
    let remark = roles(model, &system);
    let start = Instant::now();
    let bar = progress::bar(BAR_LENGTH as usize, "{msg}, {elapsed}, {eta} left");
    let run = simulate(&mut system, &initial, &plan(arguments), &mut |time| {
        bar.set_position((time / arguments.time * BAR_LENGTH) as u64);
        bar.set_message(format!("{time:.4} s of {} s", arguments.time));
    });
    bar.finish_and_clear();
    let run = run.map_err(failure)?;
    let seconds = start.elapsed().as_secs_f64();
    if let Some(path) = &arguments.plot {
        let svg = robovec_present::plot::draw(&plot::figure(model, &run));
        output::write_file(path, |writer| writer.write_all(svg.as_bytes()))?;
    }
    // When the standard error is closed there is nobody left to tell.
    let mut text = remark + &summary(arguments, &run);
    text += &happened(model, system.laws(), &run);
    text += &near_dead_point(&system);
    if std::io::stderr().is_terminal() {
        text += &speed(&run, seconds);
    }
    let _ = std::io::stderr().write_all(text.as_bytes());
    if let Some(path) = &arguments.events {
        let events = event_table(model, system.laws(), &run);
        output::write_file(path, |writer| writer.write_all(events.as_bytes()))?;
    }
    let table = csv(model, &run);
    match &arguments.output {
        None => Ok(table),
        Some(path) => {
            output::write_file(path, |writer| writer.write_all(table.as_bytes()))?;
            Ok(String::new())
        }
    }
}

/// Refuses a model with links in no equation; omitted forces are warnings.
fn refuse_left_out(read: &ReadModel) -> Result<(), CommandFailure> {
    if read.model.links3d.is_empty() {
        super::emit(&read.left_out);
        return Ok(());
    }
    let (false, Some(file)) = (read.left_out.is_empty(), read.left_out.files().first()) else {
        return Ok(());
    };
    let refused = read.left_out.diagnostics().iter().cloned();
    let refused = refused.map(|mut diagnostic| {
        if diagnostic.severity == Severity::Warning {
            diagnostic.severity = Severity::Error;
            diagnostic.notes = vec![LINK3D_ADVICE.to_owned()];
        }
        diagnostic
    });
    let refused = refused.collect();
    Err(CommandFailure(Report::of(
        file.name(),
        file.text(),
        refused,
    )))
}

/// The formulation requested, or the one that suits the model: solving for
/// accelerations grows with the cube of joints, articulated bodies with them.
fn formulation(arguments: &SimArguments, model: &Model) -> Formulation {
    match &arguments.formulation {
        Some(name) => super::generation::formulation(name),
        None if model.cuts.is_empty() && model.joints.len() > LONG => Formulation::Articulated,
        None => Formulation::default(),
    }
}

fn plan(arguments: &SimArguments) -> SimulationPlan {
    SimulationPlan {
        duration: arguments.time,
        samples: arguments.samples,
        method: match arguments.method {
            IntegratorChoice::Rk4 => IntegrationMethod::RungeKutta {
                step: arguments.step,
            },
            IntegratorChoice::Dopri => IntegrationMethod::DormandPrince {
                relative: arguments.tolerance,
                absolute: arguments.tolerance,
            },
        },
        step_limit: arguments.max_steps,
        event_tolerance: arguments.event_tolerance,
    }
}

fn keeping(arguments: &SimArguments) -> LoopKeeping {
    match arguments.loops {
        KeepingChoice::Project => LoopKeeping::Project,
        KeepingChoice::Baumgarte => LoopKeeping::Stabilise {
            rate: arguments.baumgarte_rate,
        },
        KeepingChoice::None => LoopKeeping::Free,
    }
}

fn failure(error: MotionError) -> CommandFailure {
    let notes = error.advice().map(str::to_owned).into_iter().collect();
    CommandFailure::advised(error.to_string(), notes)
}

/// Independent and dependent joints.
fn roles(model: &Model, system: &MultibodySystem<'_>) -> String {
    let partition = system.partition();
    let mut text = format!(
        "{}: {} independent, {} dependent, {} driven joints\n",
        model.name,
        partition.independent.len(),
        partition.dependent.len(),
        partition.driven.len(),
    );
    if partition.chosen {
        let named = |joint: &usize| model.joints[*joint].nature == Nature::Dependent;
        let names = partition
            .dependent
            .iter()
            .map(|&joint| model.joints[joint].name.as_str());
        let names = match names.collect::<Vec<&str>>().join(", ") {
            none if none.is_empty() => "none".to_owned(),
            names => names,
        };
        let remark = if partition.dependent.iter().all(named) {
            "of the joints that the model calls dependent its loops determine"
        } else {
            "the joints that the model calls dependent do not determine its loops; taken instead"
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{remark}: {names}");
    }
    text
}

fn summary(arguments: &SimArguments, run: &SimulationRun) -> String {
    let more = |count: u64, what: &str| match count {
        0 => String::new(),
        count => format!(", {count} {what}"),
    };
    format!(
        "{:?} s in {}{}{}; {}{}\n\
         energy less work kept within {:.2e} J; kinetic energy reached {:.3e} J\n\
         constraints kept within {:.2e}\n",
        run.stopped.unwrap_or(arguments.time),
        counted(run.steps, "step"),
        more(run.rejected, "repeated"),
        more(run.searched, "to find events"),
        counted(run.work.slopes, "evaluation"),
        more(run.work.rounds, "rounds of Newton's method"),
        run.energy_drift(),
        run.energy_scale(),
        run.largest_gap(),
    )
}

/// Events shown in the summary; the file has all.
const SHOWN_EVENTS: usize = 10;

/// Events that were watched and happened.
fn happened(model: &Model, laws: &Laws, run: &SimulationRun) -> String {
    let mut text = String::new();
    for record in run.events.iter().take(SHOWN_EVENTS) {
        let law = &laws.events[record.event];
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{} s: {} of {} {} through {:?}",
            seconds(record.time),
            law.quantity.name(),
            law.subject(model),
            if record.rising { "rises" } else { "falls" },
            law.value,
        );
    }
    if run.events.len() > SHOWN_EVENTS {
        let _ = writeln!(text, "{} events in all", run.events.len());
    }
    if run.contacts > 0 {
        let _ = writeln!(text, "contacts opened or closed {} times", run.contacts);
    }
    if let Some(time) = run.stopped {
        let _ = writeln!(text, "stopped by an event at {} s", seconds(time));
    }
    text
}

/// A time in the digits that an event is known to by default.
fn seconds(time: f64) -> String {
    format!("{time:.9}")
}

/// Warning where the partition of generated functions came near a dead point.
fn near_dead_point(system: &MultibodySystem<'_>) -> String {
    match system.weak_since() {
        None => String::new(),
        Some(time) => format!(
            "warning: from {time:?} s on the loops hardly determine the joints that the \
             generated functions \
             compute: near a dead point digits are lost, and the partition is fixed\n"
        ),
    }
}

fn speed(run: &SimulationRun, seconds: f64) -> String {
    let rate = |count: u64| count as f64 / seconds.max(1e-9);
    format!(
        "{:.3} s: {:.0} steps and {:.0} evaluations per second\n",
        seconds,
        rate(run.steps),
        rate(run.work.slopes)
    )
}

fn event_table(model: &Model, laws: &Laws, run: &SimulationRun) -> String {
    let mut text = String::from("time,quantity,name,value,direction\n");
    for record in &run.events {
        let law = &laws.events[record.event];
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:?},{},{},{:?},{}",
            record.time,
            law.quantity.name(),
            field(law.subject(model)),
            law.value,
            if record.rising { "rising" } else { "falling" },
        );
    }
    text
}

/// One line per sample.
fn csv(model: &Model, run: &SimulationRun) -> String {
    let mut text = String::from("time");
    for kind in ["q", "qd"] {
        for joint in &model.joints {
            text.push(',');
            text += &field(&format!("{kind}.{}", joint.name));
        }
    }
    text += ",kinetic,gravity,springs,work,residual\n";
    for sample in &run.samples {
        let energy = &sample.energy;
        let ends = [
            energy.kinetic,
            energy.gravity,
            energy.springs,
            sample.work,
            sample.gap,
        ];
        // Writing to a string cannot fail.
        let _ = write!(text, "{:?}", sample.state.time);
        let numbers = sample.state.q.iter().chain(&sample.state.qd);
        for number in numbers.chain(&ends) {
            let _ = write!(text, ",{number:?}");
        }
        text.push('\n');
    }
    text
}

/// A name as a field of CSV.
fn field(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

/// Maximum number of names of a kind in a warning.
const SHOWN_NAMES: usize = 8;

/// The first names of a kind, as words; `None` where there are none.
fn listed(kind: &str, names: &[&str]) -> Option<String> {
    let rest = names.len().saturating_sub(SHOWN_NAMES);
    let shown = names[..names.len() - rest].join(", ");
    match (names.is_empty(), rest) {
        (true, _) => None,
        (false, 0) => Some(format!("{kind} {shown}")),
        (false, rest) => Some(format!("{kind} {shown} and {rest} more")),
    }
}

/// Warnings of forces without a law, and of tyres that are no wheels.
fn of_laws(model: &Model, laws: &Laws) -> Report {
    let mut report = Report::new();
    let mut warn = |message: String, note: &str| {
        let warning = Diagnostic::warning().with_message(message);
        report.push(warning.with_notes(vec![note.to_owned()]));
    };
    let links = model.links.iter().zip(&laws.links);
    let links = links.filter(|(_, law)| !law.acts());
    let links: Vec<&str> = links.map(|(link, _)| link.name.as_str()).collect();
    let (mut zero, mut locked): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
    for (index, (force, law)) in model.forces.iter().zip(&laws.forces).enumerate() {
        if !law.acts() {
            zero.push(&force.name);
        }
        let tyre = law.tyre.as_ref();
        if tyre.is_some_and(|tyre| !tyre.turns(model, index)) {
            locked.push(&force.name);
        }
    }
    let both = [listed("links", &links), listed("external forces", &zero)];
    let both: Vec<String> = both.into_iter().flatten().collect();
    if !both.is_empty() {
        warn(
            format!("zero, since no law acts on them: {}", both.join("; ")),
            "help: give laws with --laws: [[link]], [[force]], [[contact]], [[tyre]]",
        );
    }
    if let Some(list) = listed("tyres", &locked) {
        warn(
            format!("no joint turns their bodies about the axes of these wheels: {list}"),
            "help: the external force of a tyre belongs to the body that spins; these wheels \
             slide as if they were locked",
        );
    }
    report
}
