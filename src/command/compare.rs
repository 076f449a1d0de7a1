//! `robovec check`: two files compared as functions.
//!
//! By default at random points of a prime field, which proves equality over the
//! real numbers. With a model, in 64-bit floats at random states and with the
//! model's parameters: generators may treat a zero parameter differently, and a
//! user wants to know how far rounding takes the results apart.

use super::CommandFailure;
use super::flags::{SEED, real, whole};
use super::input;
use clap::Args;
use robovec_analysis::class::NumericClass;
use robovec_dynamics::kinematics::parameter;
use robovec_dynamics::stale::zero;
use robovec_framework::check::check;
use robovec_io::sources::ReadEquations;
use robovec_ir::diagnostic::counted;
use robovec_ir::evaluate::evaluate;
use robovec_ir::states::States;
use robovec_ir::{Function, Input, Module, Tables, View};
use robovec_model::Model;
use robovec_num::arithmetic::Binary64;
use robovec_robotran::align;
use std::fmt::Write;
use std::path::PathBuf;

/// Arguments of `check`.
#[derive(Args, Debug)]
pub(super) struct CheckArguments {
    /// First file
    before: PathBuf,
    /// Second file
    after: PathBuf,
    /// Random points, or states
    #[arg(long, default_value_t = 8, add = whole(1, 1_000_000, "both functions are evaluated at every point"))]
    points: u32,
    /// Seed of the points
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// Meaning of equal: the same bits (exact), the same real number (real), or
    /// the same where sin^2 + cos^2 = 1 (real-trig)
    #[arg(long, value_name = "CLASS", default_value = "real",
          value_parser = ["exact", "real", "real-trig"])]
    class: String,
    /// An older word for `--class exact`
    #[arg(long, hide = true, conflicts_with = "class")]
    exact: bool,
    /// An older word for `--class real-trig`
    #[arg(long, hide = true, conflicts_with_all = ["exact", "class"])]
    circle: bool,
    /// Compare all arrays and elements of both files; an element that a file
    /// does not set counts as zero, or as the caller's value (frc, trq)
    #[arg(long)]
    align: bool,
    /// Set the parameters to zero that are zero in this model (.mbs); implies
    /// --align
    #[arg(long, value_name = "FILE", conflicts_with = "model")]
    zeros: Option<PathBuf>,
    /// Compare in 64-bit floats, with the parameters of this model (.mbs)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["exact", "circle", "class"])]
    model: Option<PathBuf>,
    /// With --model: the largest difference allowed, relative to the largest
    /// element of the output array
    #[arg(long, default_value_t = 1e-13, requires = "model",
          add = real(0.0, 1.0, "a tolerance above 1 compares nothing"))]
    tolerance: f64,
}

impl CheckArguments {
    fn class(&self) -> NumericClass {
        match self.class.as_str() {
            "exact" => NumericClass::Exact,
            _ if self.exact => NumericClass::Exact,
            "real-trig" => NumericClass::RealTrig,
            _ if self.circle => NumericClass::RealTrig,
            _ => NumericClass::Real,
        }
    }
}

pub(super) fn run(arguments: &CheckArguments) -> Result<String, CommandFailure> {
    let (mut before, mut after) = (
        input::equations(&arguments.before, None)?,
        input::equations(&arguments.after, None)?,
    );
    let model = match &arguments.model {
        None => None,
        Some(path) => Some(input::model(path)?.model),
    };
    if arguments.align || arguments.zeros.is_some() || model.is_some() {
        align_modules(&mut before.module, &mut after.module);
    }
    if let Some(path) = &arguments.zeros {
        let model = input::model(path)?.model;
        for module in [&mut before.module, &mut after.module] {
            for function in &mut module.functions {
                zero(&model, &module.tables, function);
            }
        }
    }
    let states = states(&before, &after, arguments.seed);
    let mut text = String::new();
    for function in &before.module.functions {
        let Some(other) = after.module.function(&function.name) else {
            return Err(CommandFailure::plain(format!(
                "{} has no function '{}'",
                after.name, function.name
            )));
        };
        let view = |tables, function| View { tables, function };
        let views = (
            view(&before.module.tables, function),
            view(&after.module.tables, other),
        );
        let verdict = match &model {
            None => proof(views, &states, arguments)?,
            Some(model) => distance(views, model, &states, arguments)?,
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}: {verdict}", function.name);
    }
    Ok(text)
}

/// Random states in the ranges that the files give, the first one first.
fn states(before: &ReadEquations, after: &ReadEquations, seed: u64) -> States {
    let scene = input::scene_of(after, input::scene_of(before, None));
    input::states(scene.as_ref(), seed)
}

fn proof(
    (before, after): (View<'_>, View<'_>),
    states: &States,
    arguments: &CheckArguments,
) -> Result<String, CommandFailure> {
    let judge = |class| check(before, after, class, states, arguments.points);
    let verdict = judge(arguments.class());
    let name = &before.function.name;
    if verdict.holds() {
        return if verdict.is_decided() {
            Ok(verdict.to_string())
        } else {
            Err(CommandFailure::plain(format!("'{name}': {verdict}")))
        };
    }
    // Programs that `optimise` takes often rest on it, so that a user
    // who compares one with its input would take the refusal for a fault.
    let is_missed_by_trigonometry =
        arguments.class() == NumericClass::Real && judge(NumericClass::RealTrig).holds();
    Err(CommandFailure::plain(if is_missed_by_trigonometry {
        format!(
            "'{name}' is equal only where sin^2 + cos^2 = 1, as it is for true sines and \
             cosines; `--class real-trig` accepts that"
        )
    } else {
        format!("'{name}' differs: {verdict}")
    }))
}

/// Largest difference, relative to the largest element of its array and state.
fn distance(
    (before, after): (View<'_>, View<'_>),
    model: &Model,
    states: &States,
    arguments: &CheckArguments,
) -> Result<String, CommandFailure> {
    let mut worst = (0.0, String::new());
    for state in 0..arguments.points {
        let inputs = inputs(before, model, states, state);
        let one = evaluate(before.function, &Binary64, &inputs);
        let other = evaluate(after.function, &Binary64, &inputs);
        for (name, difference) in differences(before, &one, &other) {
            // A NaN must not pass for a small difference.
            if difference.is_nan() || difference > worst.0 {
                worst = (difference, name);
            }
        }
    }
    let (difference, place) = worst;
    let name = &before.function.name;
    if difference <= arguments.tolerance {
        let states = arguments.points;
        return Ok(format!(
            "within {difference:.1e} at {}",
            counted(states, "state")
        ));
    }
    Err(CommandFailure::plain(format!(
        "'{name}' differs: {place} by {difference:.1e} of the largest element"
    )))
}

/// A random state, with parameters from the model.
fn inputs(view: View<'_>, model: &Model, states: &States, state: u32) -> Vec<f64> {
    let mut inputs = states.draw(view, state);
    for (index, number) in inputs.iter_mut().enumerate() {
        let (array, indices, rank) = view.function.input_element(Input(index as u32));
        let name = view.tables.symbols.text(array.name);
        if let Some(known) = parameter(model, name, &indices[..rank]) {
            *number = known;
        }
    }
    inputs
}

/// For each output array its largest difference, with the array's name.
fn differences(view: View<'_>, one: &[f64], other: &[f64]) -> Vec<(String, f64)> {
    let function = view.function;
    let mut arrays = vec![(0.0f64, 0.0f64); function.outputs().len()];
    // After aligning, both functions set the same elements in the same order.
    for (assignment, (a, b)) in function.assignments.iter().zip(one.iter().zip(other)) {
        let after = function
            .outputs()
            .partition_point(|array| array.offset <= assignment.output.0);
        let (largest, difference) = &mut arrays[after - 1];
        *largest = largest.max(a.abs()).max(b.abs());
        let distance = (a - b).abs();
        if distance.is_nan() || distance > *difference {
            *difference = distance;
        }
    }
    let named = function.outputs().iter().zip(arrays);
    named
        .filter(|(_, (largest, difference))| *largest > 0.0 || difference.is_nan())
        .map(|(array, (largest, difference))| {
            let name = view.tables.symbols.text(array.name).to_owned();
            (name, difference / largest)
        })
        .collect()
}

/// Gives functions of the same name the same arrays.
fn align_modules(before: &mut Module, after: &mut Module) {
    for index in 0..before.functions.len() {
        let name = &before.functions[index].name;
        let Some(other) = after.functions.iter().position(|f| f.name == *name) else {
            continue;
        };
        let one: (&Function, &mut Tables) = (&before.functions[index], &mut before.tables);
        let aligned = align::align(one, (&after.functions[other], &mut after.tables));
        (before.functions[index], after.functions[other]) = aligned;
    }
}
