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
pub mod page;
pub mod text;
pub mod time;

use crate::fit::cost::{Resources, resources};
use crate::study::cpu;
use design::{Design, Space};
use rayon::prelude::*;
use robovec_ir::{Machine, Module, View, verify};
use robovec_passes::manager::{self, Config};
use robovec_passes::pipeline;
use robovec_passes::place::{PlaceOptions, place, placement_statistics};
use serde::Serialize;

/// The most operations times designs that are placed at once.
pub const MOST_WORK: u64 = 6_000_000_000;
/// Most designs of a sweep.
pub const MOST_DESIGNS: u64 = 1_000_000;

/// A design with what came of it.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Point {
    /// The design.
    pub design: Design,
    /// Clock of the elements, MHz.
    pub clock_mhz: f64,
    /// Length of the schedule of all instances, cycles.
    pub cycles: u32,
    /// No schedule is shorter.
    pub lower_bound: u32,
    /// From the start to the last result of the last instance, µs.
    pub latency_us: f64,
    /// Time per evaluation when all instances are used, µs.
    pub us_per_evaluation: f64,
    /// What the machine takes.
    pub resources: Resources,
    /// The largest of its shares of the thesis' device; above 1 it does not
    /// fit.
    pub share: f64,
    /// No other point takes less and is as fast, or is faster and takes no
    /// more.
    pub on_front: bool,
}

/// What came of all designs for one function.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Sweep {
    /// The model or file.
    pub name: String,
    /// Operations of the program that was placed.
    pub operations: usize,
    /// Its longest chain on the thesis' machine, cycles.
    pub path: u32,
    /// The points, by design.
    pub points: Vec<Point>,
    /// Designs the program could not be placed on, and why.
    pub failures: Vec<(Design, String)>,
    /// Time of one evaluation in binary64 by the fastest generated C on one
    /// core of this computer, µs.
    pub cpu_us: Option<f64>,
    /// The same per evaluation when eight are made at once.
    pub cpu_batch_us: Option<f64>,
    /// Why there is no such time, if it was asked for.
    pub cpu_remark: String,
}

/// Why a sweep cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A pass gave up on the function.
    #[error("{0}")]
    Pass(String),
    /// Too much work.
    #[error(
        "{designs} designs of {operations} operations are more than is placed at once; ask for \
         fewer elements, couples or instances"
    )]
    TooMuch {
        /// Designs asked for.
        designs: u64,
        /// Operations of the function.
        operations: usize,
    },
}

/// Places a function, alone in its module and atomic, on every design of a
/// space, and times what a processor would run in its place.
///
/// # Errors
///
/// When the designs are too many for its size, or interleaving fails.
pub fn sweep(
    name: &str,
    module: &Module,
    space: &Space,
    processor: Option<View<'_>>,
) -> Result<Sweep, SweepError> {
    let function = &module.functions[0];
    let operations = robovec_ir::count::Counts::of(function).operations;
    let (designs, instances) = space.count();
    if designs > MOST_DESIGNS || instances.saturating_mul(operations as u64) > MOST_WORK {
        return Err(SweepError::TooMuch {
            designs,
            operations,
        });
    }
    let designs = space.designs();
    let programs = programs(module, space)?;
    let program = |design: &Design| {
        let place = space.instances.iter().position(|&k| k == design.instances);
        &programs[place.unwrap_or(0)]
    };
    let results: Vec<Result<Point, String>> = designs
        .par_iter()
        .map(|design| measure(program(design), design))
        .collect();
    let mut points = Vec::new();
    let mut failures = Vec::new();
    for (design, result) in designs.into_iter().zip(results) {
        match result {
            Ok(point) => points.push(point),
            Err(reason) => failures.push((design, reason)),
        }
    }
    mark_front(&mut points);
    let cpu = processor.map(|view| match operations > cpu::LARGEST {
        true => Err("it is too large for a C compiler".to_owned()),
        false => cpu::contest(view, view),
    });
    let times = cpu.clone().and_then(Result::ok).unwrap_or_default();
    let thesis = Machine::built_in("thesis");
    let path = thesis.map_or(0, |machine| {
        robovec_analysis::critical_path::critical_path(function, &machine).asap_cycle
    });
    Ok(Sweep {
        name: name.to_owned(),
        operations,
        path,
        points,
        failures,
        cpu_us: times.single().map(|time| time * 1e-3),
        cpu_batch_us: times.batch.map(|time| time * 1e-3),
        cpu_remark: cpu.and_then(Result::err).unwrap_or_default(),
    })
}

/// The program for every number of instances.
fn programs(module: &Module, space: &Space) -> Result<Vec<Module>, SweepError> {
    let one = |count: u32| {
        let mut module = module.clone();
        if count > 1 {
            run(&mut module, &format!("interleave{{instances={count}}}"))?;
        }
        Ok(module)
    };
    space.instances.iter().map(|&count| one(count)).collect()
}

/// Runs a pipeline over a module for the thesis' machine.
fn run(module: &mut Module, text: &str) -> Result<(), SweepError> {
    let fail = |error: String| SweepError::Pass(error);
    let pipeline = pipeline::parse(text).map_err(|error| fail(error.to_string()))?;
    let machine = Machine::built_in("thesis")
        .ok_or_else(|| fail("the thesis' machine is missing".to_owned()))?;
    let mut log = Vec::new();
    let config = Config::new(&machine, &mut log);
    let outcome = manager::run(module, &pipeline, config);
    outcome.map(|_| ()).map_err(|error| fail(error.to_string()))
}

/// Places a program for one design.
fn measure(program: &Module, design: &Design) -> Result<Point, String> {
    let machine = design.machine();
    let mut function = program.functions[0].clone();
    let summary = place(&mut function, &machine, PlaceOptions::default())
        .map_err(|error| error.to_string())?;
    let view = View {
        tables: &program.tables,
        function: &function,
    };
    if let Some(violation) = verify::verify_placement(view, &machine).first() {
        let message = &violation.message;
        return Err(format!("the verifier refuses the placement: {message}"));
    }
    let statistics = placement_statistics(&function, &machine);
    let kinds = statistics.iter().flat_map(|statistics| &statistics.kinds);
    let words = kinds.map(|kind| kind.memory.max).max().unwrap_or(0);
    // What the statistics count together lies in as many memories.
    let words = words.div_ceil(machine.memory.style.banks() as u32);
    let taken = resources(&machine, machine.number, summary.cycles, words);
    let latency_us = f64::from(summary.cycles) / machine.clock_mhz;
    Ok(Point {
        design: *design,
        clock_mhz: machine.clock_mhz,
        cycles: summary.cycles,
        lower_bound: summary.lower_bound,
        latency_us,
        us_per_evaluation: latency_us / f64::from(design.instances),
        resources: taken,
        share: taken.share(),
        on_front: false,
    })
}

/// Marks the points that no other one beats in share and time per
/// evaluation; of equal points the first.
fn mark_front(points: &mut [Point]) {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (&points[a], &points[b]);
        let smaller = a.share.total_cmp(&b.share);
        smaller.then(a.us_per_evaluation.total_cmp(&b.us_per_evaluation))
    });
    let mut fastest = f64::INFINITY;
    for index in order {
        let point = &mut points[index];
        point.on_front = point.us_per_evaluation < fastest;
        fastest = fastest.min(point.us_per_evaluation);
    }
}

impl Sweep {
    /// The points of the front, from the smallest on.
    pub fn front(&self) -> Vec<&Point> {
        let mut front: Vec<&Point> = self.points.iter().filter(|point| point.on_front).collect();
        front.sort_by(|a, b| a.share.total_cmp(&b.share));
        front
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::parse;

    /// Products of pairs, and their sum.
    fn program() -> Module {
        let mut text = "function f atomic {\n  in q[1..16]\n  out c\n".to_owned();
        for index in 1..=8 {
            text += &format!("  %p{index} = q[{index}]*q[{}]\n", index + 8);
        }
        text += "  %s1 = %p1 + %p2\n";
        for index in 2..8 {
            text += &format!("  %s{index} = %s{} + %p{}\n", index - 1, index + 1);
        }
        text += "  c = %s7\n}\n";
        parse::parse_module("f.rvir", &text).expect("well formed")
    }

    #[test]
    fn a_front_has_no_point_that_another_one_beats() {
        let space = Space {
            adders: vec![1, 2],
            multipliers: vec![1, 2],
            instances: vec![1, 4],
            ..Space::default()
        };
        let sweep = sweep("f", &program(), &space, None).expect("it is small");
        assert_eq!(sweep.failures, []);
        assert_eq!(sweep.points.len(), space.designs().len());
        let front = sweep.front();
        assert!(!front.is_empty() && front.len() < sweep.points.len());
        let beats = |a: &Point, b: &Point| {
            let values = |point: &Point| [point.share, point.us_per_evaluation];
            let (a, b) = (values(a), values(b));
            (0..2).all(|i| a[i] <= b[i]) && a != b
        };
        for point in &sweep.points {
            let beaten = sweep.points.iter().any(|other| beats(other, point));
            assert!(!(point.on_front && beaten));
            assert!(point.cycles >= point.lower_bound);
        }
        // Four instances at once wait for the chain once.
        let fastest = front.iter().map(|point| point.design.instances).max();
        assert_eq!(fastest, Some(4));
    }

    #[test]
    fn too_much_work_is_refused_before_it_starts() {
        let space = Space {
            adders: (1..=4096).collect(),
            multipliers: (1..=4096).collect(),
            ..Space::default()
        };
        let error = sweep("f", &program(), &space, None).expect_err("it is too much");
        assert!(matches!(error, SweepError::TooMuch { .. }), "{error}");
    }
}
