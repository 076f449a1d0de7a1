//! Speed against error: ways to compute a function, and the best of them.
//!
//! A point has a time (cycles on a machine with this number of elements), an
//! error (everything included: series, rounding, data that the format cannot
//! hold) and a cost (its share of the device). One point *dominates* another
//! that is nowhere better and somewhere worse: in time, in the median and in
//! the worst case, in cost. The front is the set of designs that are not
//! dominated, the only ones worth a choice.

mod answer;
mod choice;
mod measure;
mod text;

pub use measure::FrontPoint;
pub(crate) use text::{STEPS, front_curve};

use crate::exploration::{Explored, ExploredFunction};
use crate::pareto::{self, EqualPoints};
use crate::program::{ExplorationError, ProgramWorkshop, view};
use crate::share::{SharedWork, WorkShare};
use crate::store::PointKey;
use crate::worst::worst;
use crate::{ExplorationProgress, processor};
use choice::FrontChoice;
use measure::measure;
use robovec_dynamics::generate::Formulation;
use robovec_error::yardstick::Yardstick;
use robovec_ir::diagnostic::counted;
use robovec_ir::{Machine, Module};
use serde::Serialize;

/// Question.
#[derive(Clone, Copy, Debug)]
pub struct FrontQuestion<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Numbers of elements per kind.
    pub elements: &'a [u32],
    /// The largest position of the states, rad.
    pub angle: f64,
    /// Also compile every program with the C compiler and time it here.
    pub cpu: bool,
    /// Store of the points, and the share of the choices that is measured.
    pub work: SharedWork<'a>,
}

/// The front of one function.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Front {
    /// The model or file.
    pub name: String,
    /// The machine of the measurements.
    #[serde(skip)]
    pub machine: Machine,
    /// Operations of the equations as they came.
    pub operations: usize,
    /// Numbers of elements per kind.
    pub elements: Vec<u32>,
    /// States measured at.
    pub states: u32,
    /// The seed they come from.
    pub seed: u64,
    /// True when ranges of inputs are known.
    pub has_ranges: bool,
    /// Formulations that were left out, with the reason.
    pub left: Vec<(String, String)>,
    /// All points.
    pub points: Vec<FrontPoint>,
    /// For every choice of the thesis and every number of elements the best
    /// choice of robovec that dominates it.
    pub verdicts: Vec<FrontVerdict>,
}

/// Verdict on a choice of the thesis.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct FrontVerdict {
    /// Index of the thesis' point.
    pub point: usize,
    /// Index of the number of elements.
    pub elements: usize,
    /// Index of the point of ours that dominates it: the fastest, the most
    /// accurate among the fastest. `None` when there is none.
    pub by: Option<usize>,
    /// The same among ours in the format of the thesis' choice.
    pub in_its_format: Option<usize>,
}

/// Measures all choices for a function, or those of a share; results kept are
/// read, new ones kept. Each choice is reported to `progress` first.
///
/// # Errors
///
/// Fails when a pass gives up on it, a formulation computes a different
/// function, or a point cannot be stored.
pub fn front(
    mut function: ExploredFunction,
    question: &FrontQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<Explored<Front>, ExplorationError> {
    let (machine, work) = (question.machine, question.work);
    let operations = function.operations();
    let yardstick = function.yardstick();
    let left = leave_out(&yardstick, &mut function.others);
    let choices = choices(&function, question, progress)?;
    let keys = keys(&function, question, &choices);
    let module = function.module.clone();
    let mut workshop = ProgramWorkshop::new(machine, function.module, function.others);
    let mut points: Vec<FrontPoint> = Vec::new();
    let mut numbers: Vec<usize> = Vec::new();
    let (mut count, mut found) = (0, 0);
    let numbered = choices.iter().zip(keys).enumerate();
    for (number, (choice, key)) in numbered.filter(|&(number, _)| work.share.holds(number)) {
        progress(&choice.name);
        let kept: Option<Vec<FrontPoint>> = work.load(key);
        count += 1;
        found += usize::from(kept.is_some());
        let mut program = || workshop.program(choice.formulation, &choice.stages);
        let mut measured = match kept {
            Some(kept) => kept,
            None => {
                let measured =
                    measure(choice, &*program()?, machine, question.elements, &yardstick)?;
                work.save(key, &measured);
                measured
            }
        };
        if question.cpu && operations <= processor::LARGEST {
            measure::time(&*program()?, &mut measured);
        }
        numbers.resize(points.len() + measured.len(), number);
        points.extend(measured);
    }
    if work.share != WorkShare::ALL {
        return Ok(Explored::Share(counted(count, "choice"), found));
    }
    let verdicts = verdicts(&points, question.elements.len());
    let mut front = Front {
        name: function.name,
        machine: machine.clone(),
        operations,
        elements: question.elements.to_vec(),
        states: function.count,
        seed: function.states.seed(),
        has_ranges: !function.states.ranges().is_empty(),
        left,
        points,
        verdicts,
    };
    progress("searching for the largest errors");
    for index in front.searched() {
        let (number, point) = (numbers[index], &mut front.points[index]);
        let choice = &choices[number];
        let program = workshop.program(choice.formulation, &choice.stages)?;
        let format = point.format.parse().expect("formats of choices are valid");
        let found = worst(&module, (&program, format), &function.states, None)?;
        point.found = Some(found.with_sampled(point.normwise.worst));
    }
    Ok(Explored::Whole(front))
}

/// The choices of the thesis, and ours: a list, and programs searched for.
fn choices(
    function: &ExploredFunction,
    question: &FrontQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<Vec<FrontChoice>, ExplorationError> {
    let formulations: Vec<Formulation> = function.others.iter().map(|(one, _)| *one).collect();
    let mut choices = choice::listed(function.operations(), &formulations, question.angle);
    let elements: Vec<[u32; 2]> = question.elements.iter().map(|&n| [n, n]).collect();
    let found = function.searched(question.machine, &elements, question.work, progress)?;
    choices.extend(found.into_iter().map(|program| {
        let other = program.start.checked_sub(1);
        let formulation = other.map(|other| formulations[other]);
        choice::found(&program.name, formulation, &program.passes)
    }));
    Ok(choices)
}

/// Keys of the points of choices: hashes of their dependences, with a store.
fn keys(
    function: &ExploredFunction,
    question: &FrontQuestion<'_>,
    choices: &[FrontChoice],
) -> Vec<Option<PointKey>> {
    let Some(key) = question.work.key("front") else {
        return vec![None; choices.len()];
    };
    let key = key
        .with_module(&function.module)
        .with_machine(question.machine);
    let (states, count, angle) = (&function.states, function.count, question.angle);
    let key = key.with(&format!(
        "{:?} {states:?} {count} {angle}",
        question.elements
    ));
    let others = function.others.iter();
    let others = others.map(|(formulation, module)| (*formulation, key.with_module(module)));
    let others: Vec<(Formulation, PointKey)> = others.collect();
    let of = |choice: &FrontChoice| {
        let mut own = others.iter();
        let own = own.find(|(formulation, _)| choice.formulation == Some(*formulation));
        let key = own.map_or(key, |(_, key)| *key);
        // What the points are called is kept with them.
        Some(key.with(&format!("{choice:?}")))
    };
    choices.iter().map(of).collect()
}

/// Leaves out formulations that read inputs which the function does not have,
/// with the reason: one may read a length without effect.
fn leave_out(
    yardstick: &Yardstick,
    others: &mut Vec<(Formulation, Module)>,
) -> Vec<(String, String)> {
    let mut left = Vec::new();
    others.retain(|(formulation, module)| {
        let inputs = yardstick.inputs(view(module));
        if let Err(error) = &inputs {
            left.push((formulation.name().to_owned(), error.to_string()));
        }
        inputs.is_ok()
    });
    left
}

/// Measures compared with a given number of elements: cycles, the median of the
/// relative errors, the worst normwise error and the share of the device. A
/// program that cannot be placed is worse than everything.
fn measures(point: &FrontPoint, elements: usize) -> [f64; 4] {
    let cycles = point.cycles[elements].map_or(f64::INFINITY, f64::from);
    let share = point.shares[elements].unwrap_or(f64::INFINITY);
    [cycles, point.relative.median, point.normwise.worst, share]
}

/// True when the first point is nowhere worse than the second and somewhere
/// better, with the given number of elements: in cycles, in the median of the
/// relative errors, in the worst normwise error and in the share of the device.
pub fn dominates(first: &FrontPoint, second: &FrontPoint, elements: usize) -> bool {
    pareto::dominates(&measures(first, elements), &measures(second, elements))
}

impl Front {
    /// The points that no other one dominates, by cycles.
    pub fn undominated(&self, elements: usize) -> Vec<usize> {
        let points: Vec<[f64; 4]> = self
            .points
            .iter()
            .map(|point| measures(point, elements))
            .collect();
        let mut front = pareto::front(&points, EqualPoints::All);
        front.retain(|&index| self.points[index].cycles[elements].is_some());
        front.sort_by_key(|&index| (self.points[index].cycles[elements], index));
        front
    }
}

fn verdicts(points: &[FrontPoint], elements: usize) -> Vec<FrontVerdict> {
    let mut verdicts = Vec::new();
    for (index, point) in points.iter().enumerate().filter(|(_, point)| point.thesis) {
        for count in (0..elements).filter(|&count| point.cycles[count].is_some()) {
            let best = |same_format: bool| {
                let better = points.iter().enumerate().filter(|(_, other)| {
                    let comparable = !same_format || other.format == point.format;
                    !other.thesis && comparable && dominates(other, point, count)
                });
                let best = better.min_by(|(_, a), (_, b)| {
                    let order = a.cycles[count].cmp(&b.cycles[count]);
                    order.then(a.normwise.worst.total_cmp(&b.normwise.worst))
                });
                best.map(|(index, _)| index)
            };
            verdicts.push(FrontVerdict {
                point: index,
                elements: count,
                by: best(false),
                in_its_format: best(true),
            });
        }
    }
    verdicts
}
