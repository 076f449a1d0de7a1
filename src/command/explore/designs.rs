//! Explorations of designs of machines: resources against time.

use super::{ExploreArguments, Explored, ExploredFunction, ResultFiles, each};
use crate::command::flags::{FlagLimit, whole};
use crate::command::{CommandFailure, input, progress};
use clap::{Args, ValueEnum};
use robovec_dynamics::generate::Formulation;
use robovec_error::yardstick::Yardstick;
use robovec_error::yardstick::account::random_states;
use robovec_explore::operators::{Couple, couples};
use robovec_explore::optimise::found::found;
use robovec_explore::optimise::start::starts;
use robovec_explore::program::{ExplorationError, transformed_by, view};
use robovec_explore::share::SharedWork;
use robovec_explore::sweep::design::{DesignSpace, interconnect_names};
use robovec_explore::sweep::energy::{PowerFigures, WATTS};
use robovec_explore::sweep::placement::place_share;
use robovec_explore::sweep::{SweptProgram, check_work, page, sweep, text};
use robovec_ir::diagnostic::counted;
use robovec_ir::machine::{DeviceFamily, Interconnect, MemoryStyle};
use robovec_ir::states::States;
use robovec_ir::{Machine, Module};
use robovec_passes::optimise::steps;
use robovec_present::json::json_text;
use std::sync::Arc;

/// Axes of machines, and what designs are compared by.
#[derive(Args, Debug)]
pub(super) struct DesignArguments {
    /// Explore designs of machines; any axis of machines does as well
    #[arg(long)]
    designs: bool,
    /// Numbers of adders
    #[arg(long, value_delimiter = ',', default_value = "1,2,4,8,16",
          add = whole(1, 1024, "a program is placed for every number of elements"))]
    adders: Vec<u32>,
    /// Numbers of multipliers
    #[arg(long, value_delimiter = ',', default_value = "1,2,4,8,16",
          add = whole(1, 1024, "a program is placed for every number of elements"))]
    multipliers: Vec<u32>,
    /// The largest quotient of the numbers of adders and multipliers
    #[arg(long, default_value_t = 2,
          add = whole(1, 1024, "there are at most as many elements of a kind"))]
    ratio: u32,
    /// Stages of adders and multipliers, as ADD-MULTI of the thesis' Table 1.3; all by default
    #[arg(long, value_delimiter = ',', value_name = "ADD-MULTI")]
    couples: Vec<String>,
    /// Styles of memories
    #[arg(long, value_delimiter = ',', default_value = "unified,side-split")]
    memories: Vec<MemoryWord>,
    /// Words of buffers, or 0 for none
    #[arg(long, value_delimiter = ',', default_value = "16,0",
          add = whole(0, 65_536, "buffers are memories of the device; 0 leaves them out"))]
    buffers: Vec<u32>,
    /// Instances evaluated at once
    #[arg(long, value_delimiter = ',', default_value = "1,4",
          add = whole(1, 64, "the program becomes so many times as large"))]
    instances: Vec<u32>,
    /// Interconnects: crossbar, bus, mesh, torus, omega, hypercube
    #[arg(long, value_delimiter = ',', default_value = "crossbar")]
    interconnects: Vec<String>,
    /// Family of devices the machines are built on: cyclone-v or ecp5
    #[arg(long, default_value_t, value_name = "FAMILY")]
    device: DeviceFamily,
    /// Power of the device with nothing running, W, from its vendor's estimator or a meter
    #[arg(long, value_name = "W", requires = "full_watts", add = FlagLimit(WATTS))]
    idle_watts: Option<f64>,
    /// Power of the device with all of its cells in use, W: designs draw the idle power and their
    /// share of the difference
    #[arg(long, value_name = "W", requires = "idle_watts", add = FlagLimit(WATTS))]
    full_watts: Option<f64>,
    /// Power of one busy core of this computer, W
    #[arg(long, value_name = "W", requires_all = ["cpu", "idle_watts"], add = FlagLimit(WATTS))]
    cpu_watts: Option<f64>,
}

/// A style of memories on the command line.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
enum MemoryWord {
    Unified,
    SideSplit,
    FourPort,
}

pub(super) fn run(
    arguments: &ExploreArguments,
    axes: &DesignArguments,
) -> Result<String, CommandFailure> {
    let space = space(axes)?;
    let thesis = input::machine("thesis")?;
    let explore = |function: ExploredFunction, work: SharedWork<'_>| {
        let ExploredFunction {
            name,
            module,
            others,
            ranges,
            states,
            seed,
        } = function;
        let has_ranges = !ranges.is_empty();
        let source = States::new(seed).within(Arc::new(ranges));
        let failure = |error: String| CommandFailure::plain(format!("{name}: {error}"));
        let yardstick = Yardstick::new(view(&module), &source, states);
        let made = |passes: &str| transformed_by(&module, passes, &thesis, None);
        let named = |passes: &String| SweptProgram::new(passes.clone(), made(passes)?, &yardstick);
        let swept = match arguments.passes.as_slice() {
            [] => searched(&module, others, (&thesis, &space), work, &yardstick),
            passes => passes.iter().map(named).collect(),
        };
        let swept = swept.map_err(|error| failure(error.to_string()))?;
        if arguments.shares.shard.is_some() {
            let placed = check_work(&swept, &space)
                .and_then(|()| place_share(&swept, &space, work))
                .map_err(|error| failure(error.to_string()))?;
            let designs = counted(placed.designs.len(), "placement");
            return Ok(Explored::Share(designs, placed.found));
        }
        let compiled = arguments.cpu.then(|| made("$cpu")).transpose();
        let compiled = compiled.map_err(|error| failure(error.to_string()))?;
        let compiled = compiled.as_ref().map(view);
        let drawn = random_states(yardstick.len(), seed, has_ranges);
        let mut result = sweep(&name, swept, &drawn, &space, work, compiled)
            .map_err(|error| failure(error.to_string()))?;
        if let (true, Some((_, reason))) = (result.points.is_empty(), result.failures.first()) {
            return Err(failure(format!(
                "none of {} could be placed, the first because {reason}",
                counted(result.failures.len(), "design")
            )));
        }
        if let Some((idle_watts, full_watts)) = axes.idle_watts.zip(axes.full_watts) {
            result.add_energy(PowerFigures {
                idle_watts,
                full_watts,
                core_watts: axes.cpu_watts,
            });
        }
        let text = text::text(&result);
        Ok(Explored::Whole(result, text))
    };
    each(arguments, explore, |sweeps| ResultFiles {
        table: text::points_table(sweeps),
        data: json_text(sweeps),
        figure: text::figure(sweeps),
        page: page::page(sweeps),
    })
}

/// The programs that the search finds for the fewest elements of a space, the
/// most, and between.
fn searched(
    module: &Module,
    others: Vec<(Formulation, Module)>,
    (machine, space): (&Machine, &DesignSpace),
    work: SharedWork<'_>,
    yardstick: &Yardstick,
) -> Result<Vec<SweptProgram>, ExplorationError> {
    let starts = starts(module.clone(), others);
    let mut pairs: Vec<[u32; 2]> = space.pairs().map(|(add, multi)| [add, multi]).collect();
    pairs.sort_by_key(|&[add, multi]| (u64::from(add) + u64::from(multi), add));
    let wanted: Vec<[u32; 2]> = match pairs.len() {
        0..=3 => pairs,
        count => vec![pairs[0], pairs[count / 2], pairs[count - 1]],
    };
    let bar = progress::spinner();
    let told = |what: &str| bar.set_message(what.to_owned());
    let found = found(&starts, machine, &wanted, work, &told);
    bar.finish_and_clear();
    let programs = found?.into_iter();
    let programs = programs.map(|found| {
        let module = Arc::unwrap_or_clone(found.program);
        SweptProgram::new(found.name, module, yardstick)
    });
    let mut programs = programs.collect::<Result<Vec<SweptProgram>, ExplorationError>>()?;
    if programs.is_empty() {
        // The machine can place none: the sweep says why for each design.
        let passes = format!("atomise,{}", steps::REASSOCIATED);
        let program = transformed_by(module, &passes, machine, None)?;
        programs.push(SweptProgram::new(passes, program, yardstick)?);
    }
    Ok(programs)
}

fn space(arguments: &DesignArguments) -> Result<DesignSpace, CommandFailure> {
    let sorted = |numbers: &[u32]| {
        let mut numbers = numbers.to_vec();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    };
    let mut known = couples();
    for wanted in &arguments.couples {
        let is_it = |couple: &Couple| {
            let [add, multi] = couple.stages();
            *wanted == format!("{add}-{multi}")
        };
        if !known.iter().any(is_it) {
            let names = known.iter().map(|couple| {
                let [add, multi] = couple.stages();
                format!("{add}-{multi}")
            });
            let names: Vec<String> = names.collect();
            let message = format!("there is no couple '{wanted}'");
            let help = format!("couples of Table 1.3: {}", names.join(", "));
            return Err(CommandFailure::advised(message, vec![help]));
        }
    }
    if !arguments.couples.is_empty() {
        known.retain(|couple| {
            let [add, multi] = couple.stages();
            arguments.couples.contains(&format!("{add}-{multi}"))
        });
    }
    let mut interconnects = Vec::new();
    for name in &arguments.interconnects {
        let Some(interconnect) = Interconnect::named(name) else {
            let message = format!("there is no interconnect '{name}'");
            let help = format!("interconnects: {}", interconnect_names().join(", "));
            return Err(CommandFailure::advised(message, vec![help]));
        };
        if !interconnects.contains(&interconnect) {
            interconnects.push(interconnect);
        }
    }
    let memory = |word: &MemoryWord| match word {
        MemoryWord::Unified => MemoryStyle::Unified,
        MemoryWord::SideSplit => MemoryStyle::SideSplit,
        MemoryWord::FourPort => MemoryStyle::FourPort,
    };
    let mut memories: Vec<MemoryStyle> = Vec::new();
    for style in arguments.memories.iter().map(memory) {
        if !memories.contains(&style) {
            memories.push(style);
        }
    }
    let buffers = sorted(&arguments.buffers);
    Ok(DesignSpace {
        adders: sorted(&arguments.adders),
        multipliers: sorted(&arguments.multipliers),
        ratio: arguments.ratio,
        couples: known,
        memories,
        buffers: buffers
            .into_iter()
            .map(|words| (words > 0).then_some(words))
            .collect(),
        instances: sorted(&arguments.instances),
        interconnects,
        device: arguments.device,
    })
}
