//! `robovec rtl synthesise`: hardware mapped to the cells of a Cyclone V.

use crate::command::CommandFailure;
use crate::command::flags::whole;
use clap::Args;
use robovec_error::yardstick::account::{measure_text, share_cell};
use robovec_explore::device;
use robovec_explore::operators::{ADDERS, MULTIPLIERS, Operator};
use robovec_fpga::hardware::{MachineShape, estimate_of};
use robovec_fpga::rtl::cores::OperatorCore;
use robovec_hardware::synthesis::cores::{self, Mapped, operator_error};
use robovec_hardware::synthesis::timing::Path;
use robovec_hardware::synthesis::{SynthesisError, Yosys, machine, page, place};
use robovec_io::process::ToolError;
use robovec_ir::machine::DeviceFamily;
use robovec_ir::{Format, Machine};
use robovec_present::number::or_nothing;
use robovec_present::number::{exponential, percent};
use robovec_present::text_table;
use std::fmt::Write;

/// Arguments of `synthesise`.
#[derive(Args, Debug)]
pub(super) struct SynthesiseArguments {
    /// Stages of the adders
    #[arg(long, value_name = "STAGES", value_delimiter = ',',
          default_value = "1,2,3,4,5,6,7,9,10,14",
          add = whole(1, 64, "adders with more stages are not faster"))]
    add: Vec<u32>,
    /// Stages of the multipliers
    #[arg(long, value_name = "STAGES", value_delimiter = ',', default_value = "2,3,4,5,8,9",
          add = whole(1, 64, "multipliers with more stages are not faster"))]
    multiply: Vec<u32>,
    /// Number format: f32, float(8,17,flush) ...
    #[arg(long, value_name = "FORMAT", default_value = "f32")]
    number: Format,
    /// Print the cells of every longest path
    #[arg(long)]
    paths: bool,
}

pub(super) fn run(arguments: &SynthesiseArguments) -> Result<String, CommandFailure> {
    let Format::Float(format) = arguments.number else {
        return Err(CommandFailure::plain(format!(
            "there are no operators of {} in hardware; choose a format such as f32",
            arguments.number
        )));
    };
    let tool = Yosys::find().map_err(failure)?;
    let wanted = (arguments
        .add
        .iter()
        .map(|stages| (OperatorCore::Add, *stages)))
    .chain(
        arguments
            .multiply
            .iter()
            .map(|stages| (OperatorCore::Multiply, *stages)),
    );
    let mapped: Vec<Mapped> = wanted
        .map(|(core, stages)| cores::map(&tool, core, format, stages))
        .collect::<Result<_, _>>()
        .map_err(failure)?;
    let mut text = format!(
        "{} {}, synth_intel_alm for Cyclone V, operators of {}.\n\
         MHz: with 900, 700 and 500 ps per net, an estimate from published cell delays, \
         not placed, not routed, not calibrated against Quartus.\n\n",
        tool.program, tool.version, arguments.number
    );
    text += &operators(&mapped, arguments.number)?;
    if arguments.paths {
        for one in &mapped {
            let _ = writeln!(text, "\n{} of {} stages:", one.core.name(), one.stages);
            text += &one.path.iter().map(page::steps).collect::<String>();
        }
    }
    Ok(text)
}

/// An error when yosys, or a program that places and routes, is not installed.
pub(super) fn require_tools(routes: bool) -> Result<(), CommandFailure> {
    Yosys::find().map_err(failure)?;
    if routes {
        place::find().map_err(failure)?;
    }
    Ok(())
}

/// A page about a machine mapped by parts, with the time of some cycles.
pub(super) fn machine(
    shape: &MachineShape,
    files: &[(String, String)],
    cycles: u32,
) -> Result<String, CommandFailure> {
    let tool = Yosys::find().map_err(failure)?;
    let mapped = machine::map(&tool, shape, files).map_err(failure)?;
    let share = device::taken_in_all(&mapped.total(), shape.device).share(shape.device);
    let mut text = format!("\n{}", page::page(&mapped, &tool));
    if let (Some(quick), Some(slow)) = (&mapped.quick, &mapped.slow) {
        let clocks = f64::from(cycles) * f64::from(mapped.phases);
        let time = |path: &Path| clocks / path.megahertz();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "\n{cycles} cycles take {:.3} to {:.3} us at this clock; {} of the device (as mapped)",
            time(quick),
            time(slow),
            percent(share)
        );
    }
    Ok(text)
}

/// The clock of a machine, placed and routed, beside its estimate.
pub(super) fn routed(
    (machine, shape): (&Machine, &MachineShape),
    files: &[(String, String)],
    seeds: &[u32],
    cycles: u32,
) -> Result<String, CommandFailure> {
    if machine.device != DeviceFamily::Ecp5 {
        return Err(CommandFailure::advised(
            format!("open tools do not place and route a {}", shape.device.name),
            vec!["set in the machine file: device = \"ecp5\"".to_owned()],
        ));
    }
    let tool = Yosys::find().map_err(failure)?;
    let routed = place::place_and_route(&tool, files, seeds).map_err(failure)?;
    let estimate = estimate_of(shape);
    let mut text = format!(
        "\n{} {}, {}, {}\n",
        tool.program,
        tool.version,
        routed.version,
        place::OPTIONS.join(" ")
    );
    for (seed, clock) in &routed.clocks {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "seed {seed}: {clock:.1} MHz (measured by place and route)"
        );
    }
    let median = routed.median();
    let _ = writeln!(
        text,
        "median {median:.1} MHz (measured by place and route); {:.1} MHz (estimated, {:.1} to \
         {:.1}), {:+.0} %",
        estimate.mid,
        estimate.low,
        estimate.high,
        100.0 * (estimate.mid / median - 1.0)
    );
    let _ = writeln!(
        text,
        "{cycles} cycles take {:.3} us at the median clock",
        f64::from(cycles) / median
    );
    let used = routed.used.iter();
    let used: Vec<String> = used
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    let _ = writeln!(text, "used: {}", used.join(", "));
    Ok(text)
}

pub(super) fn failure(error: SynthesisError) -> CommandFailure {
    let notes = match &error {
        SynthesisError::Tool(ToolError::Time { .. }) => {
            vec![crate::command::tool::TIME_ADVICE.to_owned()]
        }
        _ => Vec::new(),
    };
    CommandFailure::advised(error.to_string(), notes)
}

/// One row per operator and latency.
fn operators(mapped: &[Mapped], number: Format) -> Result<String, CommandFailure> {
    let mut rows = Vec::new();
    let mut states = String::new();
    let device = DeviceFamily::CycloneV.device();
    for one in mapped {
        let error = operator_error(one.core, number);
        let error = error.map_err(|error| CommandFailure::plain(error.to_string()))?;
        let share = device::taken_in_all(&one.counted, device).share(device);
        let printed = printed(one);
        let (counted, estimated) = (&one.counted, &one.estimated);
        let megahertz = |period: u32| format!("{:.0}", 1e6 / f64::from(period.max(1)));
        let middle = (one.quick.enclosed + one.slow.enclosed) / 2;
        rows.push(vec![
            one.core.name().to_owned(),
            one.stages.to_string(),
            format!("{:.0}", counted.aluts),
            format!("{:.0}", estimated.aluts),
            format!("{:.0}", counted.registers),
            format!("{:.0}", estimated.registers),
            format!("{:.1}", counted.multiplier_blocks),
            share_cell(Some(share)),
            exponential(error.normwise.median),
            exponential(error.normwise.worst),
            format!("{:.1}", 1e-3 * f64::from(one.stages * middle)),
            megahertz(one.slow.enclosed),
            megahertz(middle),
            megahertz(one.quick.enclosed),
            or_nothing(printed, |operator| operator.mhz.to_string()),
            or_nothing(printed, |operator| operator.luts.to_string()),
        ]);
        states = error.states;
    }
    let head = "operator | >stages | >ALUT | >formula | >registers | >formula | >DSP | \
                >of device | >median error | >worst error | >ns | >MHz low | >mid | >high | \
                >thesis MHz | >thesis LUT";
    Ok(format!(
        "{}\nns: from operands to result, at the clock between\nerrors of one operation in \
         {number}, in parts {}\n",
        text_table(head, &rows),
        measure_text(&states)
    ))
}

/// The row of Tables 1.1 and 1.2.
fn printed(one: &Mapped) -> Option<Operator> {
    let known: &[Operator] = match one.core {
        OperatorCore::Add => &ADDERS,
        OperatorCore::Multiply => &MULTIPLIERS,
        OperatorCore::Divide | OperatorCore::Root | OperatorCore::Fused => &[],
    };
    known
        .iter()
        .copied()
        .find(|operator| operator.stages == one.stages)
}
