//! Speed against error: every way to compute a function as a point, and the
//! points that no other one beats.
//!
//! A point has a time (cycles on a machine with so many elements), an error
//! (everything included: series, rounding, data that the format cannot hold)
//! and a cost (its share of the device). One point *dominates* another that is
//! nowhere better and somewhere worse: in time, in the median and in the worst
//! case, in cost. What is not dominated is the front, and the only place where
//! there is something to choose.

pub mod choice;
mod key;
pub mod measure;
pub mod page;
pub mod text;

use crate::optimise::found::found;
use crate::optimise::start::starts;
use crate::pareto::{self, EqualPoints};
use crate::program::{ExplorationError, ProgramWorkshop, view};
use crate::share::SharedWork;
use crate::{ExplorationProgress, processor};
use choice::FrontChoice;
use key::ChoiceKeys;
use measure::{FrontPoint, measure};
use robovec_dynamics::generate::Formulation;
use robovec_error::yardstick::Yardstick;
use robovec_ir::count::Counts;
use robovec_ir::states::States;
use robovec_ir::{Machine, Module};
use serde::Serialize;

/// Question.
#[derive(Clone, Debug)]
pub struct FrontQuestion<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Numbers of elements per kind.
    pub elements: &'a [u32],
    /// Origin of the states.
    pub states: &'a States,
    /// Number of states.
    pub count: u32,
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
    /// The machine that it is measured on.
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
    /// of ours that dominates it.
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

/// Measurements of a share of the choices.
#[derive(Clone, PartialEq, Debug)]
pub struct MeasuredShare {
    /// The choices of the share.
    pub choices: usize,
    /// Number of them kept by an earlier run or another worker.
    pub found: usize,
    /// Their points, in the order of the choices.
    points: Vec<FrontPoint>,
    left: Vec<(String, String)>,
}

/// Measures all choices for a function: `module` holds it alone, as it came;
/// `others` the same in other formulations. Each choice is told before it is
/// measured.
///
/// # Errors
///
/// Fails when a pass gives up on it, a formulation computes something else, or
/// a point cannot be kept.
pub fn front(
    name: &str,
    module: &Module,
    others: Vec<(Formulation, Module)>,
    question: &FrontQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<Front, ExplorationError> {
    let measured = measure_share(module, others, question, progress)?;
    let verdicts = verdicts(&measured.points, question.elements.len());
    Ok(Front {
        name: name.to_owned(),
        machine: question.machine.clone(),
        operations: Counts::of(view(module).function).operations,
        elements: question.elements.to_vec(),
        states: question.count,
        seed: question.states.seed(),
        has_ranges: !question.states.ranges().is_empty(),
        left: measured.left,
        points: measured.points,
        verdicts,
    })
}

/// Measures the choices of a share; those that are kept are found, and the
/// others kept.
///
/// # Errors
///
/// Those of [`front`].
pub fn measure_share(
    module: &Module,
    mut others: Vec<(Formulation, Module)>,
    question: &FrontQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<MeasuredShare, ExplorationError> {
    let view = view(module);
    let operations = Counts::of(view.function).operations;
    let yardstick = Yardstick::new(view, question.states, question.count);
    let left = leave_out(&yardstick, &mut others);
    let keys = ChoiceKeys::new(module, &others, question);
    let mut workshop = ProgramWorkshop::new(question.machine, module.clone());
    let formulations: Vec<Formulation> =
        others.iter().map(|(formulation, _)| *formulation).collect();
    let mut choices: Vec<FrontChoice> = choice::of_the_thesis();
    choices.extend(choice::ours(operations, &formulations, question.angle));
    choices.extend(searched(module, &others, question, progress)?);
    for (formulation, module) in others {
        workshop.add(formulation, module);
    }
    let mut share = MeasuredShare {
        choices: 0,
        found: 0,
        points: Vec::new(),
        left,
    };
    let numbered = choices.iter().enumerate();
    for (_, choice) in numbered.filter(|&(number, _)| question.work.share.holds(number)) {
        progress(&choice.name);
        let key = keys.of(choice);
        let kept: Option<Vec<FrontPoint>> = question.work.load(key);
        share.choices += 1;
        share.found += usize::from(kept.is_some());
        let times = question.cpu && operations <= processor::LARGEST;
        let mut program = || workshop.program(choice.formulation, &choice.stages);
        let mut measured = match kept {
            Some(kept) => kept,
            None => {
                let (machine, elements) = (question.machine, question.elements);
                let measured = measure(choice, &*program()?, machine, elements, &yardstick)?;
                question.work.save(key, &measured);
                measured
            }
        };
        if times {
            measure::time(&*program()?, &mut measured);
        }
        share.points.extend(measured);
    }
    Ok(share)
}

/// Leaves out formulations that read what the function does not, with the
/// reason: one may read a length that the result does not depend on, of which the
/// states say nothing.
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

/// Program that the search of `robovec optimise` finds for the numbers of
/// elements.
fn searched(
    module: &Module,
    others: &[(Formulation, Module)],
    question: &FrontQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<Vec<FrontChoice>, ExplorationError> {
    let starts = starts(module.clone(), others.iter().cloned());
    let elements: Vec<[u32; 2]> = question.elements.iter().map(|&n| [n, n]).collect();
    let programs = found(
        &starts,
        question.machine,
        &elements,
        question.work,
        progress,
    );
    let programs = programs?.into_iter().map(|program| {
        let other = program.start.checked_sub(1);
        let formulation = other.map(|other| others[other].0);
        choice::found(&program.name, formulation, &program.passes)
    });
    Ok(programs.collect())
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
