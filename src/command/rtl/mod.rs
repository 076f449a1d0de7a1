//! `robovec rtl`: hardware for a placed program, programs for hardware, images
//! run without any (`simulate`), cells of operators (`synthesise`).

mod bench;
mod images;
mod synthesise;

use super::flags::{FlagChoice, choice, whole};
use super::opt::select;
use super::{CommandFailure, input, output, progress, simulation};
use bench::RtlBenchArguments;
use clap::{Args, Subcommand};
use robovec_analysis::rounding::usual_states;
use robovec_error::yardstick::Yardstick;
use robovec_error::yardstick::account::{ErrorAccount, random_states};
use robovec_explore::device;
use robovec_fpga::hardware::{self, MachineShape};
use robovec_fpga::manifest::FileHash;
use robovec_fpga::rtl::{
    self, Crossbar, CrossbarChoice, DESCRIPTION, Hardware, HardwareFit, RtlError,
};
use robovec_fpga::{Artifacts, FileContent, quartus};
use robovec_framework::manager::{self, Config};
use robovec_framework::scene::Scene;
use robovec_io::files::sealed::check_folder;
use robovec_io::files::{Replace, limited};
use robovec_ir::diagnostic::counted;
use robovec_ir::{Format, Function, Machine, Module, View};
use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

/// Write hardware in Verilog and its memory images, check whether a program
/// fits existing hardware, simulate images, or map operators
#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(super) struct RtlCommand {
    #[command(subcommand)]
    other: Option<HardwareCommand>,
    #[command(flatten)]
    hardware: RtlArguments,
}

#[derive(Subcommand, Debug)]
enum HardwareCommand {
    /// Run memory images cycle by cycle on given inputs
    Simulate(images::ImageArguments),
    /// Map operators to a Cyclone V with yosys: cells and speed
    Synthesise(synthesise::SynthesiseArguments),
}

/// Arguments of a build.
#[derive(Args, Debug)]
struct RtlArguments {
    /// Placed program (.rvir), or equations with '--passes'
    #[arg(required = true)]
    input: Option<PathBuf>,
    /// Machine to build: a name or a .toml file; by default the one the program is placed on
    #[arg(long)]
    machine: Option<String>,
    /// Folder for the hardware (rtl/) and the images (img/)
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Extent of the crossbar that is built
    #[arg(long, value_parser = choice(&EXTENTS), default_value = "full")]
    crossbar: CrossbarChoice,
    /// Only this function of the input
    #[arg(long, value_name = "NAME")]
    function: Option<String>,
    /// Passes to run first, as in robovec-opt; the last one must be 'place'
    #[arg(long, value_name = "PIPELINE")]
    passes: Option<String>,
    /// Existing hardware (its folder, or its machine.json): check whether the
    /// program fits, and with '-o' write only its images
    #[arg(long, value_name = "HARDWARE", conflicts_with_all = ["machine", "crossbar"])]
    fits: Option<PathBuf>,
    #[command(flatten)]
    bench: RtlBenchArguments,
    /// Map the hardware to a Cyclone V with yosys, and compare its resources
    /// and speed with the formulas and the thesis
    #[arg(long, conflicts_with = "fits")]
    synthesise: bool,
    /// Place and route the hardware on an ECP5 with yosys and nextpnr, once for
    /// each of these seeds, and compare the clock with the estimate; takes
    /// minutes
    #[arg(long, conflicts_with = "fits", value_name = "SEEDS", value_delimiter = ',',
          num_args = 0..=1, default_missing_value = "1,2,3",
          add = whole(0, 1_000_000, "a seed only distinguishes placements"))]
    place_and_route: Option<Vec<u32>>,
}

/// Extents of the crossbar that is built.
const EXTENTS: [FlagChoice<CrossbarChoice>; 2] = [
    (
        &["full"],
        "Every pair of source and write port: any program fits",
        CrossbarChoice::Full,
    ),
    (
        &["pruned"],
        "The pairs that the program uses",
        CrossbarChoice::Pruned,
    ),
];

pub(super) fn run(command: &RtlCommand) -> Result<String, CommandFailure> {
    match &command.other {
        Some(HardwareCommand::Simulate(arguments)) => images::run(arguments),
        Some(HardwareCommand::Synthesise(arguments)) => synthesise::run(arguments),
        None => program_or_hardware(&command.hardware),
    }
}

fn program_or_hardware(arguments: &RtlArguments) -> Result<String, CommandFailure> {
    bench::require_simulator(&arguments.bench)?;
    if arguments.synthesise || arguments.place_and_route.is_some() {
        synthesise::require_tools(arguments.place_and_route.is_some())?;
    }
    match &arguments.fits {
        Some(path) => fits(arguments, &hardware(path)?),
        None => build(arguments),
    }
}

fn build(arguments: &RtlArguments) -> Result<String, CommandFailure> {
    let Some(folder) = &arguments.output else {
        return Err(CommandFailure::plain(
            "name a folder for the hardware: -o FOLDER",
        ));
    };
    let asked = arguments.machine.as_deref();
    let (module, machine, scene) = program(arguments, asked.map(input::machine).transpose()?)?;
    let function = only_function(&module)?;
    let view = module.tables.view(function);
    let mut files = CollectedFiles::default();
    let hardware = rtl::write_rtl(view, &machine, arguments.crossbar, &mut files)
        .map_err(|error| failure(&error))?;
    let shape = MachineShape::built(&hardware);
    files.add_project(&hardware, &shape)?;
    let benches = bench::benches(&arguments.bench, view, &machine, scene.as_ref(), &files.0)?;
    files.0.extend(benches);
    files.write(folder)?;
    let mut text = summary(&hardware, &shape, view, scene.as_ref());
    let _ = writeln!(text, "written to {}", folder.display());
    text += "quartus/ has a project for the DE10-Nano; Quartus has not been run on it\n";
    text += &bench::checked(&arguments.bench, folder, folder)?;
    if arguments.synthesise {
        text += &synthesise::machine(&shape, &files.verilog(), cycles(function))?;
    }
    if let Some(seeds) = &arguments.place_and_route {
        text += &synthesise::routed(
            (&hardware.machine, &shape),
            &files.verilog(),
            seeds,
            cycles(function),
        )?;
    }
    Ok(text)
}

fn fits(arguments: &RtlArguments, hardware: &Hardware) -> Result<String, CommandFailure> {
    let (module, _, scene) = program(arguments, Some(hardware.machine.clone()))?;
    let function = only_function(&module)?;
    let view = module.tables.view(function);
    let fit = rtl::fits(view, hardware).map_err(|error| failure(&error))?;
    if !fit.reasons.is_empty() {
        return Err(CommandFailure::advised(
            format!(
                "'{}' does not fit the hardware with hash {}",
                function.name,
                hardware.hash()
            ),
            notes(&fit),
        ));
    }
    let mut text = format!(
        "'{}' fits the hardware with hash {}\n",
        function.name,
        hardware.hash()
    );
    for demand in &fit.demands {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {demand}");
    }
    if let Some(folder) = &arguments.output {
        let mut files = CollectedFiles::default();
        rtl::write_program(view, hardware, &mut files).map_err(|error| failure(&error))?;
        let machine = &hardware.machine;
        let benches = bench::benches(&arguments.bench, view, machine, scene.as_ref(), &files.0)?;
        files.0.extend(benches);
        files.write(folder)?;
        let _ = writeln!(text, "its images are in {}", folder.join("img").display());
        if let Some(there) = &arguments.fits {
            text += &bench::checked(&arguments.bench, folder, there)?;
        }
    }
    Ok(text)
}

/// Reason why a program does not fit, and the remedy.
fn notes(fit: &HardwareFit) -> Vec<String> {
    let mut notes = fit.reasons.clone();
    notes.push("hardware built for this program takes 'robovec rtl' without '--fits'".to_owned());
    notes
}

fn hardware(path: &Path) -> Result<Hardware, CommandFailure> {
    let candidates = [path.join("rtl").join(DESCRIPTION), path.join(DESCRIPTION)];
    let found = candidates.into_iter().find(|file| file.is_file());
    if found.is_none() && path.is_dir() {
        return Err(CommandFailure::advised(
            format!(
                "{} has no complete hardware: there is no {DESCRIPTION}, which is written last",
                path.display()
            ),
            vec!["build it again: robovec rtl PROGRAM -o FOLDER".to_owned()],
        ));
    }
    let is_folder = found.is_some();
    let file = found.unwrap_or_else(|| path.to_owned());
    let text = input::text(&file, &limited::HARDWARE)?;
    let hardware = Hardware::parse(&text).map_err(|error| {
        let notes = vec![format!(
            "'robovec rtl' writes one: FOLDER/rtl/{DESCRIPTION}"
        )];
        CommandFailure::advised(format!("{}: {error}", file.display()), notes)
    })?;
    let beside = input::folder(&file);
    let is_there = |one: &FileHash| beside.join(&one.file).exists();
    // A description may be kept alone; with any of its files it is hardware.
    if is_folder || hardware.files.iter().any(is_there) {
        check_folder(beside, &hardware.files).map_err(|error| {
            CommandFailure::advised(
                format!(
                    "{} does not have the hardware that {DESCRIPTION} describes: {error}",
                    beside.display()
                ),
                vec!["build it again: robovec rtl PROGRAM -o FOLDER".to_owned()],
            )
        })?;
    }
    Ok(hardware)
}

fn program(
    arguments: &RtlArguments,
    machine: Option<Machine>,
) -> Result<(Module, Machine, Option<Scene>), CommandFailure> {
    let pipeline = input::passes_or_empty(arguments.passes.as_deref())?;
    let function = arguments.function.as_deref();
    // Absent only where a subcommand has its own.
    let path = arguments
        .input
        .as_ref()
        .expect("the command line requires it");
    let mut input = input::equations_or_model(path, None, function)?;
    if let Some(name) = function {
        select(&mut input.module, name)?;
    }
    let scene = input::scene_of(&input, None);
    let module = &input.module;
    let equations = |function: &Function| function.placement.is_none();
    if arguments.passes.is_none() && module.functions.iter().any(equations) {
        return Err(CommandFailure::advised(
            format!("{}: hardware runs placed programs", path.display()),
            vec![
                "place it here: --passes atomise,zero-removal,balance,cse,dce,place".to_owned(),
                "or run robovec-opt with these passes, and give its output".to_owned(),
            ],
        ));
    }
    let machine = match machine {
        Some(machine) => machine,
        None => own_machine(module)?,
    };
    match arguments.passes {
        None => simulation::check(&input, &machine)?,
        Some(_) => {
            let mut log = progress::remarks();
            let config = Config {
                scene: scene.as_ref(),
                ..Config::new(&machine, &mut log)
            };
            manager::run(&mut input.module, &pipeline, config)
                .map_err(|error| CommandFailure::plain(error.to_string()))?;
        }
    }
    Ok((input.module, machine, scene))
}

/// The machine that a placed program names; else that of the thesis.
fn own_machine(module: &Module) -> Result<Machine, CommandFailure> {
    let schedules = module.functions.iter().filter_map(|f| f.schedule.as_ref());
    let mut names: Vec<&str> = schedules
        .map(|schedule| schedule.machine.as_str())
        .collect();
    names.dedup();
    match names[..] {
        [] => input::machine("thesis"),
        [name] => Machine::built_in(name).ok_or_else(|| {
            CommandFailure::advised(
                format!("the program is placed on '{name}', a machine that does not ship"),
                vec!["name its file: --machine FILE.toml".to_owned()],
            )
        }),
        _ => Err(CommandFailure::advised(
            "the functions are placed on different machines",
            vec!["choose one of them: --function NAME".to_owned()],
        )),
    }
}

fn only_function(module: &Module) -> Result<&Function, CommandFailure> {
    match &module.functions[..] {
        [function] => Ok(function),
        functions => {
            let names: Vec<&str> = functions.iter().map(|f| f.name.as_str()).collect();
            Err(CommandFailure::advised(
                format!(
                    "hardware is built for one function, and there are {}",
                    functions.len()
                ),
                vec![
                    format!("functions: {}", names.join(", ")),
                    "choose one with '--function'; '--fits' lists the others".to_owned(),
                ],
            ))
        }
    }
}

fn failure(error: &RtlError) -> CommandFailure {
    let notes = match error {
        RtlError::Misfit { reasons, function } => {
            let message = format!("'{function}' does not fit");
            return CommandFailure::advised(message, reasons.clone());
        }
        other => rtl::advice(other).into_iter().collect(),
    };
    CommandFailure::advised(error.to_string(), notes)
}

/// Files that are written when all of them are complete.
#[derive(Default)]
struct CollectedFiles(Vec<(String, String)>);

impl Artifacts for CollectedFiles {
    fn file(&mut self, name: &str, content: FileContent<'_>) -> io::Result<()> {
        self.0.file(name, content)
    }
}

impl CollectedFiles {
    /// The Verilog files of the machine: name and text.
    fn verilog(&self) -> Vec<(String, String)> {
        let files = self.0.iter();
        files
            .filter_map(|(name, text)| Some((name.strip_prefix("rtl/")?.to_owned(), text.clone())))
            .filter(|(name, _)| name.ends_with(".v"))
            .collect()
    }

    fn add_project(
        &mut self,
        hardware: &Hardware,
        shape: &MachineShape,
    ) -> Result<(), CommandFailure> {
        let in_folder = |folder: &str, ending: &str| -> Vec<String> {
            let names = self
                .0
                .iter()
                .filter_map(|(name, _)| name.strip_prefix(folder));
            names
                .filter(|name| name.ends_with(ending))
                .map(str::to_owned)
                .collect()
        };
        let (sources, images) = (in_folder("rtl/", ".v"), in_folder("img/", ".mif"));
        let manifest = self
            .0
            .iter()
            .find(|(name, _)| name.ends_with(".manifest.json"));
        let (_, manifest) = manifest.expect("hardware is written with its manifest");
        let manifest = serde_json::from_str(manifest).expect("a manifest that was written reads");
        let project = quartus::project(&hardware.machine, shape, &manifest, &sources, &images);
        let project = project.into_iter();
        self.0
            .extend(project.map(|(name, text)| (format!("quartus/{name}"), text)));
        Ok(())
    }

    fn write(&self, folder: &Path) -> Result<(), CommandFailure> {
        let files: Vec<(&str, &str)> = self
            .0
            .iter()
            .map(|(name, text)| (&**name, &**text))
            .collect();
        output::write_folder(folder, &files, Replace::Anything)
    }
}

fn summary(
    hardware: &Hardware,
    shape: &MachineShape,
    view: View<'_>,
    scene: Option<&Scene>,
) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let groups: Vec<String> = (hardware.elements.iter())
        .map(|group| format!("{} {}", group.count, group.kind))
        .collect();
    let clocks = counted(hardware.phases(), "clock");
    let _ = writeln!(
        text,
        "{}: elements {}, {clocks} per cycle, {}",
        hardware.machine.name,
        groups.join(" + "),
        hardware.machine.number
    );
    let _ = writeln!(
        text,
        "  memories: {}, {} per memory",
        counted(hardware.instruction_words, "instruction"),
        counted(hardware.words, "operand word")
    );
    let (built, all) = hardware.crossbar_pairs();
    let kind = match hardware.crossbar {
        Crossbar::Full => "full",
        Crossbar::Pruned(_) => "pruned",
    };
    let _ = writeln!(text, "  crossbar: {kind}, {built} of {all} pairs");
    let _ = writeln!(text, "  machine hash {}", hardware.hash());
    let groups = hardware.elements.iter();
    let counts = groups.map(|group| (group.kind.as_str(), group.count));
    let clock = hardware::clock_with_elements(&hardware.machine, counts);
    let device = hardware.machine.device.device();
    let _ = writeln!(
        text,
        "  clock: {} on {}: {}",
        clock.text(),
        device.name,
        device.origin
    );
    let function = view.function;
    let cycles = cycles(function);
    let time = clock.microseconds(cycles);
    let share = 100.0 * device::taken_by(shape, device).share(device);
    let _ = writeln!(
        text,
        "{}: {}, {time:.3} us; {share:.2} % of {} (estimated)",
        function.name,
        counted(cycles, "cycle"),
        device.name
    );
    text + &errors(view, hardware.machine.number, scene)
}

fn cycles(function: &Function) -> u32 {
    let schedule = function.schedule.as_ref();
    schedule.expect("hardware runs placed programs").cycles
}

/// The rounding errors of a program in the format of its machine.
fn errors(view: View<'_>, number: Format, scene: Option<&Scene>) -> String {
    let count = usual_states(view.function.nodes().len());
    let yardstick = Yardstick::new(view, &input::states(scene, STATE_SEED), count);
    let states = random_states(yardstick.len(), STATE_SEED, scene.is_some());
    let account = ErrorAccount::measured(view, &yardstick, number, states);
    let account = account.expect("a program is measured against its own values");
    format!("  {}\n", account.text())
}

/// The seed of the states that errors are measured at.
const STATE_SEED: u64 = 1;
