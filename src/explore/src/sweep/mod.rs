//! Machines for one function: what each takes of a device, how long it needs
//! for an evaluation, and which of them no other one beats.
//!
//! A *design* is a machine and a way to use it: numbers of adders and of
//! multipliers, their stages with the clock these allow (thesis, Table 1.3),
//! a style of memories, buffers or none, instances at once, an interconnect.
//! Every design is placed, not estimated; what it takes is estimated by the
//! formulas of the hardware, and its clock is that of the tables, cut to what
//! double-pumped memories follow (thesis 1.3).
//!
//! **Invariant.** Nothing but the time on the processor, which is measured
//! only on request, depends on clocks, threads or the order of work.

pub mod design;
pub mod energy;
pub mod page;
pub mod placement;
pub mod text;

use crate::device::{self, DeviceShare};
use crate::pareto::{self, EqualPoints};
use crate::processor;
use crate::program::{ExplorationError, transformed_by, view};
use crate::share::SharedWork;
use design::{DesignSpace, MachineDesign};
use energy::PowerFigures;
use placement::DesignPlacement;
use robovec_analysis::critical_path::critical_path;
use robovec_error::yardstick::{ErrorSpread, Yardstick};
use robovec_fpga::hardware::{self, MachineClock};
use robovec_ir::count::Counts;
use robovec_ir::{Machine, Module, View};
use serde::Serialize;

/// The most operations times designs that are placed at once.
pub const MAX_WORK: u64 = 6_000_000_000;
/// Most designs of a sweep.
pub const MAX_DESIGNS: u64 = 1_000_000;

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

/// A design with what came of it.
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
    /// Resources that the machine takes.
    pub resources: DeviceShare,
    /// The largest of its shares of the device; above 1 it does not
    /// fit.
    pub share: f64,
    /// No other point takes less and is as fast, or is faster and takes no
    /// more.
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
    /// Time of one evaluation in binary64 by the fastest generated C on one
    /// core of this computer, µs.
    pub cpu_us: Option<f64>,
    /// The same per evaluation when eight are made at once.
    pub cpu_batch_us: Option<f64>,
    /// Time by which one evaluation in a thousand takes longer there than the
    /// median one, µs. A design takes the same cycles every time.
    pub cpu_jitter_us: Option<f64>,
    /// Energy of one evaluation there, µJ, where the power of a core is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cpu_energy_uj: Option<f64>,
    /// The power that energies stand on, as the user gave it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<PowerFigures>,
    /// Reason why there is no such time, if it was asked for.
    pub cpu_remark: String,
}

/// Reason why a sweep cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A pass gave up on the function.
    #[error(transparent)]
    Program(#[from] ExplorationError),
    /// Too much work.
    #[error(
        "{designs} designs of {operations} operations are more than is placed at once; ask for \
         fewer elements, couples or instances"
    )]
    TooMuch {
        /// Designs asked for.
        designs: u64,
        /// Operations of all programs.
        operations: usize,
    },
    /// A placement could not be written.
    #[error("cannot keep a placement: {0}")]
    NotKept(std::io::Error),
}

impl SweptProgram {
    /// A program, one function at the level atomic, with its errors against
    /// the function it was made from.
    ///
    /// # Errors
    ///
    /// Fails when it reads or computes something that the yardstick's function
    /// does not.
    pub fn new(
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

/// Places programs of one function, whose errors were measured at these
/// states (in words), on every design of a space, of which each
/// takes the one with the shortest schedule, and times what a processor would
/// run in its place.
///
/// # Errors
///
/// Fails when the designs are too many for the programs' size, interleaving
/// fails, or a placement cannot be kept.
pub fn sweep(
    name: &str,
    programs: Vec<SweptProgram>,
    states: &str,
    space: &DesignSpace,
    work: SharedWork<'_>,
    processor: Option<View<'_>>,
) -> Result<FunctionSweep, SweepError> {
    check_work(&programs, space)?;
    let placed = placement::place_share(&programs, space, work)?;
    let mut points = Vec::new();
    let mut failures = Vec::new();
    for (design, result) in placed.designs {
        match result {
            Ok(placement) => points.push(point(design, placement)),
            Err(reason) => failures.push((design, reason)),
        }
    }
    mark_front(&mut points);
    let cpu = processor.map(|view| {
        if Counts::of(view.function).operations > processor::LARGEST {
            Err("it is too large for a C compiler".to_owned())
        } else {
            processor::contest(view, view)
        }
    });
    let times = cpu.clone().and_then(Result::ok).unwrap_or_default();
    Ok(FunctionSweep {
        name: name.to_owned(),
        device: space.device.device().name.clone(),
        programs,
        number: thesis().number.to_string(),
        states: states.to_owned(),
        points,
        failures,
        cpu_us: times.single().map(|time| time * 1e-3),
        cpu_batch_us: times.batch.map(|time| time * 1e-3),
        cpu_jitter_us: times.jitter.map(|time| time * 1e-3),
        cpu_energy_uj: None,
        power: None,
        cpu_remark: cpu.and_then(Result::err).unwrap_or_default(),
    })
}

/// Refuses more work than is done at once.
///
/// # Errors
///
/// Fails when the designs are too many for the programs' size.
pub fn check_work(programs: &[SweptProgram], space: &DesignSpace) -> Result<(), SweepError> {
    let operations: usize = programs.iter().map(|program| program.operations).sum();
    let (designs, instances) = space.count();
    if designs > MAX_DESIGNS || instances.saturating_mul(operations as u64) > MAX_WORK {
        return Err(SweepError::TooMuch {
            designs,
            operations,
        });
    }
    Ok(())
}

/// All programs for every number of instances.
fn interleaved(
    programs: &[SweptProgram],
    space: &DesignSpace,
) -> Result<Vec<Vec<Module>>, SweepError> {
    let machine = thesis();
    let one = |program: &SweptProgram, count: u32| match count {
        1 => Ok(program.module.clone()),
        _ => {
            let interleave = format!("interleave{{instances={count}}}");
            Ok(transformed_by(
                &program.module,
                &interleave,
                &machine,
                None,
            )?)
        }
    };
    let counts = space.instances.iter();
    counts
        .map(|&count| programs.iter().map(|program| one(program, count)).collect())
        .collect()
}

/// The machine that designs are variants of.
fn thesis() -> Machine {
    Machine::built_in("thesis").expect("it ships, and a test parses it")
}

/// Resources of a design, and its time for an evaluation.
fn point(design: MachineDesign, placement: DesignPlacement) -> SweepPoint {
    let machine = design.machine();
    let cycles = placement.cycles;
    let taken = device::taken(&machine, machine.number, cycles, placement.words);
    let clock = hardware::clock(&machine);
    let latency_us = clock.microseconds(cycles);
    SweepPoint {
        design,
        program: placement.program,
        clock,
        cycles,
        lower_bound: placement.lower_bound,
        latency_us,
        us_per_evaluation: latency_us / f64::from(design.instances),
        energy_uj: None,
        resources: taken,
        share: taken.share(machine.device.device()),
        on_front: false,
    }
}

/// Marks the points that no other one beats in share and time per
/// evaluation; of equal points the first.
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
    use robovec_ir::parse;
    use robovec_ir::states::States;

    /// Products of pairs, and their sum.
    fn programs() -> Vec<SweptProgram> {
        let mut text = "function f atomic {\n  in q[1..16]\n  out c\n".to_owned();
        for index in 1..=8 {
            text += &format!("  %p{index} = q[{index}]*q[{}]\n", index + 8);
        }
        text += "  %s1 = %p1 + %p2\n";
        for index in 2..8 {
            text += &format!("  %s{index} = %s{} + %p{}\n", index - 1, index + 1);
        }
        text += "  c = %s7\n}\n";
        let printed = parse::parse_module("f.rvir", &text).expect("well formed");
        let short = transformed_by(&printed, "balance", &thesis(), None).expect("sums");
        let yardstick = Yardstick::new(view(&printed), &States::new(1), 8);
        let program = |name: &str, module: Module| {
            SweptProgram::new(name.to_owned(), module, &yardstick).expect("the same function")
        };
        vec![program("printed", printed.clone()), program("short", short)]
    }

    /// A few machines, with so many instances at once, and all points of them.
    pub(super) fn small_sweep(instances: &[u32]) -> (DesignSpace, FunctionSweep) {
        let space = DesignSpace {
            adders: vec![1, 2],
            multipliers: vec![1, 2],
            instances: instances.to_vec(),
            ..DesignSpace::default()
        };
        let sweep = sweep(
            "f",
            programs(),
            "8 random states",
            &space,
            SharedWork::ALONE,
            None,
        );
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
            let alone = vec![programs().swap_remove(index)];
            let alone = super::sweep(
                "f",
                alone,
                "8 random states",
                &space,
                SharedWork::ALONE,
                None,
            )
            .expect("it is small");
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
            ..DesignSpace::default()
        };
        let error = sweep(
            "f",
            programs(),
            "8 random states",
            &space,
            SharedWork::ALONE,
            None,
        )
        .expect_err("it is too much");
        assert!(matches!(error, SweepError::TooMuch { .. }), "{error}");
    }
}
