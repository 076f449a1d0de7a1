//! The operators alone: the resources and speed of each, by latency.
//!
//! Every operator is mapped between registers, as for Tables 1.1 and 1.2.

use super::timing::{FAST_NET, NetlistTiming, Path, PathSelection, SLOW_NET};
use super::{SynthesisDesign, SynthesisError, Yosys, count};
use robovec_error::yardstick::account::{ErrorAccount, random_states};
use robovec_error::yardstick::{Unmeasurable, Yardstick};
use robovec_fpga::hardware::{ResourceUse, operator};
use robovec_fpga::rtl::cores::{OperatorCore, SOURCES, cuts};
use robovec_ir::Format;
use robovec_ir::machine::DeviceFamily;
use robovec_ir::parse::parse_module;
use robovec_ir::states::States;
use robovec_num::NumberFormat;

/// An operator of one latency, as mapped.
#[derive(Clone, PartialEq, Debug)]
pub struct Mapped {
    /// Operator.
    pub core: OperatorCore,
    /// Pipeline stages.
    pub stages: u32,
    /// Resources counted by yosys.
    pub counted: ResourceUse,
    /// Resources by the formulas.
    pub estimated: ResourceUse,
    /// Longest paths with quick and with slow nets, ps.
    pub quick: Delays,
    /// The same with slow nets.
    pub slow: Delays,
    /// The longest path between registers outside, with fast nets.
    pub path: Option<Path>,
}

/// The longest paths of an operator, ps.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Delays {
    /// From an operand to a register, without the driver of the operand.
    pub first: u32,
    /// From register to register.
    pub inner: u32,
    /// With a register before every operand and after the result.
    pub enclosed: u32,
}

/// The Verilog of an operator.
pub fn design(core: OperatorCore, format: NumberFormat, stages: u32) -> SynthesisDesign {
    let device = DeviceFamily::CycloneV.device();
    let cuts = cuts(core, format, stages, device);
    let parameters = [
        ("EXPONENT", format.exponent.to_string()),
        ("MANTISSA", format.mantissa.to_string()),
        ("SUBNORMALS", u32::from(format.subnormals).to_string()),
        ("CUTS", cuts.mask.to_string()),
        ("EXTRA", cuts.extra.to_string()),
    ];
    let files = SOURCES.iter();
    SynthesisDesign {
        top: core.name().to_owned(),
        parameters: parameters
            .map(|(name, value)| (name.to_owned(), value))
            .to_vec(),
        sources: files
            .map(|(name, text)| ((*name).to_owned(), (*text).to_owned()))
            .collect(),
        closed: Vec::new(),
        others: Vec::new(),
        kept: Vec::new(),
    }
}

/// Maps an operator.
pub fn map(
    tool: &Yosys,
    core: OperatorCore,
    format: NumberFormat,
    stages: u32,
) -> Result<Mapped, SynthesisError> {
    let netlist = tool.map(&design(core, format, stages))?;
    let top = netlist.top()?.to_owned();
    let counts = count::count(&netlist, &top)?;
    let counted = counts.last().expect("the top is counted last").total;
    let timing = NetlistTiming::new(&netlist, &top)?;
    Ok(Mapped {
        core,
        stages,
        counted,
        estimated: operator(
            core,
            Format::Float(format),
            stages,
            DeviceFamily::CycloneV.device(),
        ),
        quick: delays(&timing, FAST_NET),
        slow: delays(&timing, SLOW_NET),
        path: timing.longest(FAST_NET, PathSelection::ENCLOSED),
    })
}

fn delays(timing: &NetlistTiming<'_>, net: u32) -> Delays {
    let longest = |paths| timing.longest(net, paths).map_or(0, |path| path.delay);
    Delays {
        first: longest(PathSelection {
            from_registers: false,
            from_inputs: Some(0),
            to_registers: true,
            to_outputs: false,
        }),
        inner: longest(PathSelection::INSIDE),
        enclosed: longest(PathSelection::ENCLOSED),
    }
}

/// The seed of the states, and their number.
const SEED: u64 = 1;
const STATES: u32 = 1024;

/// The error of one operation in a format, on masses as random states have
/// them: positive, from 1/8 to 128, each octave as likely as the others. One
/// rounding is at most 2^-24 in binary32; narrow formats round operands too.
///
/// # Errors
///
/// See [`Unmeasurable`], for parts that cannot be measured alone.
pub fn operator_error(core: OperatorCore, format: Format) -> Result<ErrorAccount, Unmeasurable> {
    let value = match core {
        OperatorCore::Add => "m[1] + m[2]",
        OperatorCore::Multiply => "m[1]*m[2]",
        OperatorCore::Divide => "m[1]/m[2]",
        OperatorCore::Root => "sqrt(m[1])",
        OperatorCore::Fused => "fma(m[1], m[2], m[3])",
    };
    let text =
        format!("function f atomic {{\n  in m[1..3]\n  out y\n  %y1 = {value}\n  y = %y1\n}}\n");
    let module = parse_module("operator", &text).expect("one operation is a function");
    let view = module.tables.view(&module.functions[0]);
    let yardstick = Yardstick::new(view, &States::new(SEED), STATES);
    let states = random_states(yardstick.len(), SEED, false);
    ErrorAccount::measured(view, &yardstick, format, states)
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_fpga::hardware::operator_period;

    /// Needs an installed yosys; some seconds per operator.
    #[test]
    #[ignore = "needs yosys; cargo test -- --ignored model_of_an_operator"]
    fn the_model_of_an_operator_is_that_of_its_mapping() {
        let tool = Yosys::find().expect("yosys is installed");
        let device = DeviceFamily::CycloneV.device();
        for (core, stages) in [
            (OperatorCore::Add, 1),
            (OperatorCore::Add, 3),
            (OperatorCore::Add, 10),
            (OperatorCore::Multiply, 2),
            (OperatorCore::Multiply, 5),
        ] {
            let mapped =
                map(&tool, core, NumberFormat::BINARY32, stages).expect("it can be mapped");
            let memory = device.cells.memory;
            for (delays, net) in [(mapped.quick, FAST_NET), (mapped.slow, SLOW_NET)] {
                let found = (memory + delays.first).max(delays.inner);
                let own = operator_period(core, NumberFormat::BINARY32, stages, device, net);
                println!("{core:?} {stages} {net}: mapped {found}, model {own}");
                assert!(
                    own.abs_diff(found) <= found / 5,
                    "{core:?} {stages}: {found} {own}"
                );
            }
        }
    }

    #[test]
    fn every_operator_rounds_once() {
        let unit = 2f64.powi(-24);
        for core in [
            OperatorCore::Add,
            OperatorCore::Multiply,
            OperatorCore::Divide,
            OperatorCore::Root,
            OperatorCore::Fused,
        ] {
            let account = operator_error(core, Format::BINARY32).expect("it is one operation");
            let errors = account.normwise;
            assert!(errors.median > unit / 16.0, "{core:?}: {errors:?}");
            assert!(errors.worst <= unit, "{core:?}: {errors:?}");
        }
    }
}
