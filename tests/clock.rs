//! One machine on one device has one clock in the output of every command.

use crate::support::programs::{opt_in, robovec_in, said};
use robovec_fpga::hardware;
use robovec_ir::Machine;
use serde_json::Value;
use std::fs;
use std::path::Path;

const PASSES: &str = "atomise,cse,dce,place";

/// The machine that ships with memories per side, on a device, with two
/// elements of each kind.
pub(crate) fn machine(folder: &Path, device: &str) -> Machine {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/side-split.toml");
    let text = fs::read_to_string(shipped).expect("it ships");
    let text = text.replace("count = 4", "count = 2");
    let text = text.replace("[number]", &format!("device = \"{device}\"\n\n[number]"));
    fs::write(folder.join("machine.toml"), &text).expect("a folder of our own");
    Machine::parse(&text).expect("it is a machine")
}

/// A JSON file of a folder.
fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("it was written")).expect("JSON")
}

#[test]
fn report_sweep_and_rtl_tell_the_same_clock() {
    for device in ["cyclone-v", "ecp5"] {
        let folder = tempfile::tempdir().expect("a folder can be made");
        let folder = folder.path();
        let machine = machine(folder, device);
        let clock = hardware::clock(&machine);
        assert_eq!(clock.origin.name(), "estimated");
        let input = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/examples/suspension/mbs_dirdyna_suspension.m"
        );
        let words = [
            "rtl",
            input,
            "--machine",
            "machine.toml",
            "--passes",
            PASSES,
        ];
        let told = said(&robovec_in(
            folder,
            &[&words[..], &["-o", "hardware"]].concat(),
        ));
        let line = format!("clock: {} on ", clock.text());
        assert!(told.contains(&line), "{line}: {told}");

        let pipeline = format!("-passes={PASSES}");
        let words = [input, "--machine", "machine.toml", &pipeline];
        let report = ["--report", "report.json", "-o", "placed.rvir"];
        said(&opt_in(folder, &[&words[..], &report].concat()));
        let report = json(&folder.join("report.json"));
        let found = &report["functions"][0]["schedule"];
        assert_eq!(found["clock"]["mhz"].as_f64(), Some(clock.mhz), "{found}");
        assert_eq!(found["clock"]["origin"], "estimated");

        let swept = format!(
            "explore {input} --passes atomise,cse,dce --adders 2 --multipliers 2 --couples 10-5 \
             --memories side-split --buffers 16 --instances 1 --device {device} -o swept"
        );
        let swept: Vec<&str> = swept.split(' ').filter(|word| !word.is_empty()).collect();
        said(&robovec_in(folder, &swept));
        let swept = json(&folder.join("swept/explore.json"));
        let found = find(&swept, "clock").expect("a point has a clock");
        assert_eq!(found["mhz"].as_f64(), Some(clock.mhz), "{found}");
        assert_eq!(found["origin"], "estimated");
    }
}

/// The first field of a name, at any depth.
fn find<'a>(value: &'a Value, name: &str) -> Option<&'a Value> {
    match value {
        Value::Object(fields) => fields
            .get(name)
            .or_else(|| fields.values().find_map(|inner| find(inner, name))),
        Value::Array(values) => values.iter().find_map(|inner| find(inner, name)),
        _ => None,
    }
}

#[test]
fn a_fit_counts_with_the_clock_of_the_machine_it_writes() {
    let fitted = crate::front::loose();
    let candidate = &fitted.candidate;
    let machine = Machine::parse(&fitted.machine).expect("a machine");
    let clock = hardware::clock(&machine);
    assert_eq!(candidate["clock"]["mhz"].as_f64(), Some(clock.mhz));
    let cycles = candidate["cycles"].as_u64().expect("a number") as u32;
    assert_eq!(
        candidate["microseconds"].as_f64(),
        Some(clock.microseconds(cycles))
    );
}

#[test]
fn published_clocks_are_those_of_studies_alone() {
    let thesis = Machine::built_in("thesis").expect("it ships");
    let [own, published] = [hardware::clock(&thesis), hardware::published_clock(&thesis)];
    assert_eq!(
        (published.mhz, published.origin.name()),
        (178.0, "published")
    );
    assert_eq!(own.origin.name(), "estimated");
    assert_ne!(own.mhz, published.mhz);
    let mut measured = thesis.clone();
    measured.clock_origin = robovec_ir::machine::ClockOrigin::Measured;
    for clock in [
        hardware::clock(&measured),
        hardware::published_clock(&measured),
    ] {
        assert_eq!(clock.text(), "178 MHz (measured)");
    }
}
