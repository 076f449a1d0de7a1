//! `robovec rtl`: the benches beside the hardware, and `--check`.

use crate::command::flags::{NUMBER, SEED, whole};
use crate::command::{CommandFailure, input};
use clap::Args;
use robovec_framework::scene::Scene;
use robovec_hardware::rtl::{CheckFailure, Checked, Door, HardwareSimulator, bench_files, check};
use robovec_io::process::ToolError;
use robovec_ir::{Machine, View};
use std::fmt::Write as _;
use std::path::Path;

/// Arguments of the benches.
#[derive(Args, Debug)]
pub(super) struct RtlBenchArguments {
    /// Build the test benches and run them with this simulator
    #[arg(long, value_enum, value_name = "TOOL")]
    check: Option<HardwareSimulator>,
    /// Interfaces of the machine to test; by default all that the simulator
    /// supports
    #[arg(long, value_enum, value_name = "WAYS", value_delimiter = ',')]
    through: Vec<Door>,
    /// Number of states on which the test benches run the program
    #[arg(long, value_name = "COUNT", default_value_t = 3, add = whole(1, 1000, "test test \
     benches hold all states, and run the program on each"))]
    runs: u32,
    /// Seed of the random states
    #[arg(long, value_name = "NUMBER", default_value_t = 1, add = SEED)]
    seed: u64,
    /// The first state: one number per input element, in order of declaration
    #[arg(
        long,
        value_name = "NUMBERS",
        value_delimiter = ',',
        allow_hyphen_values = true,
        add = NUMBER
    )]
    inputs: Vec<f64>,
}

/// The files of `tb/` for the images of a program, each with its folder.
pub(super) fn benches(
    arguments: &RtlBenchArguments,
    view: View<'_>,
    machine: &Machine,
    scene: Option<&Scene>,
    files: &[(String, String)],
) -> Result<Vec<(String, String)>, CommandFailure> {
    let images: Vec<(String, String)> = files
        .iter()
        .filter(|(name, _)| name.starts_with("img/"))
        .cloned()
        .collect();
    let states = input::states(scene, arguments.seed);
    let mut inputs: Vec<Vec<f64>> = (0..arguments.runs)
        .map(|index| states.draw(view, index))
        .collect();
    if !arguments.inputs.is_empty() {
        inputs[0].clone_from(&arguments.inputs);
    }
    let benches = bench_files(view, machine, &images, &inputs);
    let benches = benches.map_err(|error| {
        CommandFailure::plain(format!("no bench for '{}': {error}", view.function.name))
    })?;
    Ok(benches
        .into_iter()
        .map(|(name, text)| (format!("tb/{name}"), text))
        .collect())
}

/// An error when the simulator that is requested is not installed.
pub(super) fn require_simulator(arguments: &RtlBenchArguments) -> Result<(), CommandFailure> {
    match arguments.check.and_then(HardwareSimulator::missing) {
        Some(program) => Err(failure(&CheckFailure::Missing(program))),
        None => Ok(()),
    }
}

/// Runs the benches of a folder when that was requested; gives their messages.
///
/// The hardware is in `rtl/` of the folder `hardware`, or is that folder.
pub(super) fn checked(
    arguments: &RtlBenchArguments,
    folder: &Path,
    hardware: &Path,
) -> Result<String, CommandFailure> {
    let Some(tool) = arguments.check else {
        return Ok(String::new());
    };
    // What '--fits' names may also be the description among the files.
    let below = hardware.join("rtl");
    let rtl = match (below.is_dir(), hardware.is_dir()) {
        (true, _) => below,
        (false, true) => hardware.to_owned(),
        (false, false) => input::folder(hardware).to_owned(),
    };
    let mut doors = arguments.through.clone();
    // The configuration of hardware that was there has its own images.
    let is_configured = folder.join("rtl").is_dir();
    if doors.is_empty() {
        doors = tool.doors().to_vec();
        doors.retain(|&door| is_configured || door != Door::Configured);
    }
    if doors.contains(&Door::Configured) && !is_configured {
        return Err(CommandFailure::advised(
            "existing hardware was not configured with these images",
            vec!["check how they are loaded: --through bus,avalon,axi4lite".to_owned()],
        ));
    }
    if let Some(door) = doors.iter().find(|door| !tool.doors().contains(door)) {
        return Err(CommandFailure::advised(
            format!(
                "this simulator has no test bench for the interface '{}'",
                door.name()
            ),
            vec!["'--check iverilog' has".to_owned()],
        ));
    }
    let Checked { verdicts, time } =
        check(&folder.join("tb"), &rtl, tool, &doors).map_err(|error| failure(&error))?;
    let mut text = String::new();
    for verdict in verdicts {
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(text, "{verdict}");
    }
    let _ = writeln!(text, "checked in {:.1} s", time.as_secs_f64());
    Ok(text)
}

fn failure(error: &CheckFailure) -> CommandFailure {
    let notes = match error {
        CheckFailure::Missing(program) => vec![format!(
            "install it (Debian: apt install {}), or leave out '--check' and run the benches \
             elsewhere",
            if *program == "vvp" {
                "iverilog"
            } else {
                program
            }
        )],
        CheckFailure::Mismatch(_) => vec![
            "the first mismatch counts, the others may be its consequences".to_owned(),
            "the files are kept: run the benches again with the scripts in tb/".to_owned(),
        ],
        CheckFailure::Tool(ToolError::Time { .. }) => {
            vec![crate::command::tool::TIME_ADVICE.to_owned()]
        }
        CheckFailure::Tool(_) | CheckFailure::Hardware(..) | CheckFailure::Build(_) => Vec::new(),
    };
    CommandFailure::advised(error.to_string(), notes)
}
