//! Explorations of designs of machines: resources against time.

use super::{ExploreArguments, each};
use crate::command::CommandFailure;
use crate::command::flags::{FlagLimit, whole};
use clap::Args;
use robovec_explore::operators::{Couple, couples};
use robovec_explore::sweep::{
    DesignSpace, PowerFigures, SweepQuestion, WATTS, interconnects, sweep,
};
use robovec_ir::machine::{DeviceFamily, Interconnect, MemoryStyle};
use std::collections::BTreeSet;

/// Axes of machines, and criteria for designs.
#[derive(Args, Debug)]
pub(super) struct DesignArguments {
    /// Explore designs of machines; implied by the other options of this
    /// section
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
    /// Largest ratio between the numbers of adders and multipliers
    #[arg(long, default_value_t = 2,
          add = whole(1, 1024, "there are at most as many elements of a kind"))]
    ratio: u32,
    /// Stages of adders and multipliers, as ADD-MULTI of the thesis' Table 1.3; all by default
    #[arg(long, value_delimiter = ',', value_name = "ADD-MULTI",
          value_parser = |name: &str| named(name, couples(), Couple::name))]
    couples: Vec<Couple>,
    /// Styles of memories: unified, side-split, four-port
    #[arg(long, value_delimiter = ',', default_value = "unified,side-split",
          value_parser = |name: &str| named(name, MemoryStyle::ALL, |style| style.name()))]
    memories: Vec<MemoryStyle>,
    /// Words of buffers, or 0 for none
    #[arg(long, value_delimiter = ',', default_value = "16,0",
          add = whole(0, 65_536, "buffers are memories of the device; 0 leaves them out"))]
    buffers: Vec<u32>,
    /// Instances evaluated at once
    #[arg(long, value_delimiter = ',', default_value = "1,4",
          add = whole(1, 64, "the program becomes this number of times larger"))]
    instances: Vec<u32>,
    /// Interconnects: crossbar, bus, mesh, torus, omega, hypercube
    #[arg(long, value_delimiter = ',', default_value = "crossbar",
          value_parser = |name: &str| named(name, interconnects(), |one| one.name()))]
    interconnects: Vec<Interconnect>,
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

/// The value of a name.
fn named<T, N: Into<String>>(
    name: &str,
    all: impl IntoIterator<Item = T>,
    name_of: impl Fn(&T) -> N,
) -> Result<T, String> {
    let all: Vec<(String, T)> = (all.into_iter())
        .map(|one| (name_of(&one).into(), one))
        .collect();
    let names: Vec<&str> = all.iter().map(|(known, _)| known.as_str()).collect();
    let expected = format!("expected {}", names.join(", "));
    let found = all.into_iter().find(|(known, _)| known == name);
    found.map(|(_, one)| one).ok_or(expected)
}

pub(super) fn run(
    arguments: &ExploreArguments,
    axes: &DesignArguments,
) -> Result<String, CommandFailure> {
    let space = space(axes);
    let watts = axes.idle_watts.zip(axes.full_watts);
    if let Some((idle, full)) = watts.filter(|(idle, full)| full < idle) {
        return Err(CommandFailure::plain(format!(
            "--full-watts {full} is below --idle-watts {idle}: expected the power with all cells \
             in use, which is no less than that with nothing running"
        )));
    }
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

fn space(arguments: &DesignArguments) -> DesignSpace {
    let sorted = |numbers: &[u32]| {
        let numbers: BTreeSet<u32> = numbers.iter().copied().collect();
        numbers.into_iter().collect::<Vec<u32>>()
    };
    let mut known = couples();
    known.retain(|couple| arguments.couples.is_empty() || arguments.couples.contains(couple));
    let buffers = sorted(&arguments.buffers).into_iter();
    DesignSpace {
        adders: sorted(&arguments.adders),
        multipliers: sorted(&arguments.multipliers),
        ratio: arguments.ratio,
        couples: known,
        memories: each_once(&arguments.memories),
        buffers: buffers.map(|words| (words > 0).then_some(words)).collect(),
        instances: sorted(&arguments.instances),
        interconnects: each_once(&arguments.interconnects),
        device: arguments.device,
    }
}

/// The values in their order, each once.
fn each_once<T: PartialEq + Copy>(values: &[T]) -> Vec<T> {
    let first = |(place, value): &(usize, &T)| !values[..*place].contains(value);
    let kept = values.iter().enumerate().filter(first);
    kept.map(|(_, value)| *value).collect()
}
