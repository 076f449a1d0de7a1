//! Explorations of designs of machines: resources against time.

use super::{ExploreArguments, each};
use crate::command::CommandFailure;
use crate::command::flags::{FlagLimit, whole};
use clap::{Args, ValueEnum};
use robovec_explore::operators::{Couple, couples};
use robovec_explore::sweep::{
    DesignSpace, PowerFigures, SweepQuestion, WATTS, interconnect_names, sweep,
};
use robovec_ir::machine::{DeviceFamily, Interconnect, MemoryStyle};

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
    let watts = axes.idle_watts.zip(axes.full_watts);
    each(arguments, None, |function, work, progress| {
        let question = SweepQuestion {
            space: &space,
            passes: &arguments.passes,
            cpu: arguments.cpu,
            power: watts.map(|(idle_watts, full_watts)| PowerFigures {
                idle_watts,
                full_watts,
                core_watts: axes.cpu_watts,
            }),
            work,
        };
        Ok(sweep(&function, &question, progress))
    })
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
