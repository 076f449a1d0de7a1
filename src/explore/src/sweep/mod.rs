//! Machines for one function: the resources and the time per evaluation of
//! each, and the set of those that no other dominates.
//!
//! A *design* is a machine and its use: numbers of adders and of multipliers,
//! their stages with the clock these allow (thesis, Table 1.3), a style of
//! memories, buffers or none, instances at once, an interconnect. Every design
//! is placed, not estimated; its resources are estimated by the formulas of the
//! hardware, and its clock is that of the tables, limited by that of
//! double-pumped memories (thesis 1.3).
//!
//! **Invariant.** Nothing but the time on the processor, which is measured
//! only on request, depends on clocks, threads or the order of work.

mod design;
mod energy;
mod placement;
mod text;

pub use design::{DesignSpace, MachineDesign, interconnects};
pub use energy::{PowerFigures, WATTS};

use crate::ExplorationProgress;
use crate::device::{self, DeviceShare};
use crate::exploration::{Explored, ExploredFunction};
use crate::pareto::{self, EqualPoints};
use crate::processor::{self, ProcessorTimes};
use crate::program::{ExplorationError, transformed_by, view};
use crate::share::{SharedWork, WorkShare};
use placement::DesignPlacement;
use robovec_analysis::critical_path::critical_path;
use robovec_error::yardstick::{ErrorSpread, Yardstick};
use robovec_fpga::hardware::MachineClock;
use robovec_ir::count::Counts;
use robovec_ir::diagnostic::counted;
use robovec_ir::{Machine, Module};
use robovec_passes::optimise::steps;
use serde::Serialize;
use std::sync::Arc;

/// The maximum number of operations times designs placed in one sweep.
const MAX_WORK: u64 = 6_000_000_000;
const MAX_DESIGNS: u64 = 1_000_000;

/// A program that may be placed on designs.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct SweptProgram {
    /// Name in words.
    pub name: String,
    /// Its operations.
    pub operations: usize,
    /// Its longest chain on the thesis' machine, cycles.
    pub path: u32,
    /// Errors in the number format of the designs, relative to each element,
    /// at random states against double-double arithmetic.
    pub relative: ErrorSpread,
    /// The same errors over the largest element of the array.
    pub normwise: ErrorSpread,
    /// One function at the level atomic.
    #[serde(skip)]
    pub module: Module,
}

/// A design with its result.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct SweepPoint {
    /// The design.
    pub design: MachineDesign,
    /// Index of the program with the shortest schedule on it, from 0.
    pub program: usize,
    /// Clock of the elements, with its origin.
    pub clock: MachineClock,
    /// Length of the schedule of all instances, cycles.
    pub cycles: u32,
    /// No schedule of the same operations is shorter.
    pub lower_bound: u32,
    /// From the start to the last result of the last instance, µs.
    pub latency_us: f64,
    /// Time per evaluation when all instances are used, µs.
    pub us_per_evaluation: f64,
    /// Energy of an evaluation, µJ, where the power of the device is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_uj: Option<f64>,
    /// Resources of the machine.
    pub resources: DeviceShare,
    /// Largest of its shares of the device; above 1 it does not fit.
    pub share: f64,
    /// No other point takes less and is as fast, or is faster for no more.
    pub on_front: bool,
}

/// Results of all designs for one function.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct FunctionSweep {
    /// The model or file.
    pub name: String,
    /// The device that all designs are built on.
    pub device: String,
    /// The programs that were placed.
    pub programs: Vec<SweptProgram>,
    /// The number format of their errors.
    pub number: String,
    /// The states of their errors, in words.
    pub states: String,
    /// The points, by design.
    pub points: Vec<SweepPoint>,
    /// Designs the program could not be placed on, and why.
    pub failures: Vec<(MachineDesign, String)>,
    /// Time of an evaluation in binary64 by the fastest C, on one core, µs.
    pub cpu_us: Option<f64>,
    /// The same per evaluation in batches of eight.
    pub cpu_batch_us: Option<f64>,
    /// Time by which one evaluation in a thousand takes longer there than the
    /// median one, µs. A design takes the same cycles every time.
    pub cpu_jitter_us: Option<f64>,
    /// Energy of one evaluation there, µJ, where the power of a core is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cpu_energy_uj: Option<f64>,
    /// The power from which energies are computed, from the user.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<PowerFigures>,
    /// Reason why there is no such time, if it was requested.
    pub cpu_remark: String,
}

/// Question.
#[derive(Clone, Copy, Debug)]
pub struct SweepQuestion<'a> {
    /// The designs.
    pub space: &'a DesignSpace,
    /// Pipelines that make the programs to be placed; empty for a search.
    pub passes: &'a [String],
    /// Also time the function on a processor.
    pub cpu: bool,
    /// Power of the device, where it is known.
    pub power: Option<PowerFigures>,
    /// Store of the placements, and the share of the designs that is placed.
    pub work: SharedWork<'a>,
}

impl SweptProgram {
    /// An atomic program of one function, with its errors against the original.
    fn new(
        name: String,
        module: Module,
        yardstick: &Yardstick,
    ) -> Result<SweptProgram, ExplorationError> {
        let function = &module.functions[0];
        let errors = yardstick.errors(view(&module), thesis().number)?;
        Ok(SweptProgram {
            name,
            operations: Counts::of(function).operations,
            path: critical_path(function, &thesis()).asap_cycle,
            relative: errors.relative,
            normwise: errors.normwise,
            module,
        })
    }
}

/// Places programs on every design of a space, or of a share, keeps the
/// shortest for each design, and times a processor for comparison.
///
/// # Errors
///
/// Fails when a pass gives up, no design is large enough for the function,
/// designs are too many for the programs' size, or a placement is not stored.
pub fn sweep(
    function: &ExploredFunction,
    question: &SweepQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<Explored<FunctionSweep>, ExplorationError> {
    let space = question.space;
    let programs = programs(function, question, progress)?;
    check_work(&programs, space)?;
    let (placed, found) = placement::place(&programs, space, question.work)?;
    if question.work.share != WorkShare::ALL {
        return Ok(Explored::Share(counted(placed.len(), "placement"), found));
    }
    let mut points = Vec::new();
    let mut failures = Vec::new();
    for (design, result) in placed {
        match result {
            Ok(placement) => points.push(point(design, placement)),
            Err(reason) => failures.push((design, reason)),
        }
    }
    if let (true, Some((_, reason))) = (points.is_empty(), failures.first()) {
        let designs = counted(failures.len(), "design");
        return Err(ExplorationError::NothingPlaced(designs, reason.clone()));
    }
    mark_front(&mut points);
    let cpu = question.cpu.then(|| timed(&function.module)).transpose()?;
    let times = cpu.clone().and_then(Result::ok).unwrap_or_default();
    let mut sweep = FunctionSweep {
        name: function.name.clone(),
        device: space.device.device().name.clone(),
        programs,
        number: thesis().number.to_string(),
        states: function.drawn(),
        points,
        failures,
        cpu_us: times.single().map(|time| time * 1e-3),
        cpu_batch_us: times.batch.map(|time| time * 1e-3),
        cpu_jitter_us: times.jitter.map(|time| time * 1e-3),
        cpu_energy_uj: None,
        power: None,
        cpu_remark: cpu.and_then(Result::err).unwrap_or_default(),
    };
    if let Some(power) = question.power {
        sweep.add_energy(power);
    }
    Ok(Explored::Whole(sweep))
}

/// Times of the C that is generated for a processor, or why there are none.
fn timed(module: &Module) -> Result<Result<ProcessorTimes, String>, ExplorationError> {
    let program = transformed_by(module, "$cpu", &thesis(), None)?;
    let view = view(&program);
    Ok(match Counts::of(view.function).operations {
        0..=processor::LARGEST => processor::contest(view, view),
        _ => Err("it is too large for a C compiler".to_owned()),
    })
}

/// The programs of pipelines, or those searched for the space's elements.
fn programs(
    function: &ExploredFunction,
    question: &SweepQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<Vec<SweptProgram>, ExplorationError> {
    let yardstick = function.yardstick();
    let made = |passes: &str| {
        let program = transformed_by(&function.module, passes, &thesis(), None)?;
        SweptProgram::new(passes.to_owned(), program, &yardstick)
    };
    if !question.passes.is_empty() {
        return question.passes.iter().map(|passes| made(passes)).collect();
    }
    let mut pairs: Vec<[u32; 2]> = question.space.pairs().collect();
    pairs.sort_by_key(|&[add, multi]| (u64::from(add) + u64::from(multi), add));
    if let count @ 4.. = pairs.len() {
        pairs = vec![pairs[0], pairs[count / 2], pairs[count - 1]];
    }
    let found = function.searched(&thesis(), &pairs, question.work, progress)?;
    if found.is_empty() {
        // The machine can place none: the sweep says why for each design.
        return Ok(vec![made(&format!("atomise,{}", steps::REASSOCIATED))?]);
    }
    let programs = found.into_iter().map(|found| {
        let module = Arc::unwrap_or_clone(found.program);
        SweptProgram::new(found.name, module, &yardstick)
    });
    programs.collect()
}

/// Refuses more work than the limit.
fn check_work(programs: &[SweptProgram], space: &DesignSpace) -> Result<(), ExplorationError> {
    let operations: usize = programs.iter().map(|program| program.operations).sum();
    let (designs, instances) = space.count();
    if designs > MAX_DESIGNS || instances.saturating_mul(operations as u64) > MAX_WORK {
        return Err(ExplorationError::TooMuch {
            designs,
            operations,
        });
    }
    Ok(())
}

/// The machine that designs are variants of.
fn thesis() -> Machine {
    Machine::built_in("thesis").expect("it ships, and a test parses it")
}

/// Resources of a design, and its time for an evaluation.
fn point(design: MachineDesign, placement: DesignPlacement) -> SweepPoint {
    let machine = design.machine();
    let cycles = placement.cycles;
    let figures = device::figures(&machine, machine.number, cycles, placement.words);
    SweepPoint {
        design,
        program: placement.program,
        clock: figures.clock,
        cycles,
        lower_bound: placement.lower_bound,
        latency_us: figures.microseconds,
        us_per_evaluation: figures.microseconds / f64::from(design.instances),
        energy_uj: None,
        resources: figures.resources,
        share: figures.share,
        on_front: false,
    }
}

/// Marks the points that none beats in share and time; of equal ones one.
fn mark_front(points: &mut [SweepPoint]) {
    let measures = |point: &SweepPoint| [point.share, point.us_per_evaluation];
    let all: Vec<[f64; 2]> = points.iter().map(measures).collect();
    for index in pareto::front(&all, EqualPoints::First) {
        points[index].on_front = true;
    }
}

impl FunctionSweep {
    /// The points of the front, from the smallest on.
    pub fn front(&self) -> Vec<&SweepPoint> {
        let mut front: Vec<&SweepPoint> =
            self.points.iter().filter(|point| point.on_front).collect();
        front.sort_by(|a, b| a.share.total_cmp(&b.share));
        front
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operators::couples;
    use robovec_ir::machine::{DeviceFamily, Interconnect, MemoryStyle};
    use robovec_ir::parse;
    use robovec_ir::states::States;

    /// Products of pairs, and their sum.
    fn function() -> ExploredFunction {
        let mut text = "function f atomic {\n  in q[1..16]\n  out c\n".to_owned();
        for index in 1..=8 {
            text += &format!("  %p{index} = q[{index}]*q[{}]\n", index + 8);
        }
        text += "  %s1 = %p1 + %p2\n";
        for index in 2..8 {
            text += &format!("  %s{index} = %s{} + %p{}\n", index - 1, index + 1);
        }
        text += "  c = %s7\n}\n";
        ExploredFunction {
            name: "f".to_owned(),
            module: parse::parse_module("f.rvir", &text).expect("well formed"),
            others: Vec::new(),
            states: States::new(1),
            count: 8,
        }
    }

    /// As printed, and a shorter sum.
    const PASSES: [&str; 2] = ["cse", "balance"];

    fn swept(space: &DesignSpace, passes: &[&str]) -> Result<FunctionSweep, ExplorationError> {
        let passes: Vec<String> = passes.iter().map(|&passes| passes.to_owned()).collect();
        let question = SweepQuestion {
            space,
            passes: &passes,
            cpu: false,
            power: None,
            work: SharedWork::ALONE,
        };
        match sweep(&function(), &question, &|_| ())? {
            Explored::Whole(sweep) => Ok(sweep),
            Explored::Share(..) => unreachable!("all of the work was asked for"),
        }
    }

    fn usual_space() -> DesignSpace {
        DesignSpace {
            adders: vec![1, 2],
            multipliers: vec![1, 2],
            ratio: 2,
            couples: couples(),
            memories: vec![MemoryStyle::Unified, MemoryStyle::SideSplit],
            buffers: vec![Some(16), None],
            instances: vec![1, 4],
            interconnects: vec![Interconnect::Crossbar],
            device: DeviceFamily::default(),
        }
    }

    /// A few machines, with this number of interleaved instances, and all
    /// points of them.
    pub(super) fn small_sweep(instances: &[u32]) -> (DesignSpace, FunctionSweep) {
        let space = DesignSpace {
            instances: instances.to_vec(),
            ..usual_space()
        };
        let sweep = swept(&space, &PASSES);
        (space, sweep.expect("it is small"))
    }

    #[test]
    fn a_front_has_no_point_that_another_one_beats() {
        let (space, sweep) = small_sweep(&[1, 4]);
        assert_eq!(sweep.failures, []);
        assert_eq!(sweep.points.len(), space.designs().len());
        let front = sweep.front();
        assert!(!front.is_empty() && front.len() < sweep.points.len());
        let values = |point: &SweepPoint| [point.share, point.us_per_evaluation];
        let beats = |a: &SweepPoint, b: &SweepPoint| pareto::dominates(&values(a), &values(b));
        for point in &sweep.points {
            let beaten = sweep.points.iter().any(|other| beats(other, point));
            assert!(!(point.on_front && beaten));
            assert!(point.cycles >= point.lower_bound);
        }
        // Every design takes the program with the shortest schedule.
        let mut is_short_taken = false;
        for index in 0..2 {
            let alone = swept(&space, &PASSES[index..=index]).expect("it is small");
            for (point, own) in sweep.points.iter().zip(&alone.points) {
                assert!(point.cycles <= own.cycles);
                is_short_taken |= point.program == 1;
            }
        }
        assert!(is_short_taken, "the shorter sum is of use somewhere");
        // Four instances at once wait for the chain once.
        let fastest = front.iter().map(|point| point.design.instances).max();
        assert_eq!(fastest, Some(4));
    }

    #[test]
    fn too_much_work_is_refused_before_it_starts() {
        let space = DesignSpace {
            adders: (1..=4096).collect(),
            multipliers: (1..=4096).collect(),
            ..usual_space()
        };
        let error = swept(&space, &PASSES).expect_err("it is too much");
        assert!(matches!(error, ExplorationError::TooMuch { .. }), "{error}");
    }
}
