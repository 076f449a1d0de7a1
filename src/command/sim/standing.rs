//! `robovec sim equilibrium` and `robovec sim modal`: the state of rest of a
//! model under its laws, and small motions around it.

use super::{MovedModel, failure};
use crate::command::{CommandFailure, output};
use clap::{Args, ValueEnum};
use robovec_dynamics::motion::{
    EquationSetting, Equilibrium, Laws, Mode, MotionError, MultibodySystem, SmallMotions, modes,
};
use robovec_ir::diagnostic::counted;
use robovec_model::{JointKind, Model};
use robovec_present::text_lines;
use serde_json::{Value, json};
use std::path::PathBuf;

/// A model and its laws.
#[derive(Args, Debug)]
pub(super) struct EquilibriumArguments {
    #[command(flatten)]
    subject: MovedModel,
    /// JSON file to write all numbers to
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Around which state.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Debug)]
enum PlaceChoice {
    /// State in which the forces balance
    Equilibrium,
    /// The initial positions, at rest, even if forces are not in balance
    Initial,
}

/// Arguments of `modal`.
#[derive(Args, Debug)]
pub(super) struct ModalArguments {
    #[command(flatten)]
    standing: EquilibriumArguments,
    /// State around which the small motions are computed
    #[arg(long, value_enum, default_value_t = PlaceChoice::Equilibrium)]
    at: PlaceChoice,
}

/// Runs `robovec sim equilibrium`: the text for the standard output.
pub(super) fn equilibrium(arguments: &EquilibriumArguments) -> Result<String, CommandFailure> {
    let (model, laws) = arguments.subject.read()?;
    let found = rest(&model, laws.at_rest()).map_err(failure)?;
    if let Some(path) = &arguments.output {
        write(path, &equilibrium_json(&model, &found))?;
    }
    Ok(equilibrium_text(&model, &found))
}

fn rest(model: &Model, laws: Laws) -> Result<Equilibrium, MotionError> {
    let (mut system, initial) = MultibodySystem::new(model, laws, &EquationSetting::default())?;
    system.equilibrium(&initial)
}

/// Runs `robovec sim modal`: the text for the standard output.
pub(super) fn modal(arguments: &ModalArguments) -> Result<String, CommandFailure> {
    let (model, laws) = arguments.standing.subject.read()?;
    let (motions, found) = around(&model, laws.at_rest(), arguments.at).map_err(failure)?;
    if let Some(path) = &arguments.standing.output {
        write(path, &modal_json(&model, &motions, &found))?;
    }
    Ok(modal_text(&model, (arguments.at, &motions), &found))
}

fn around(
    model: &Model,
    laws: Laws,
    place: PlaceChoice,
) -> Result<(SmallMotions, Vec<Mode>), MotionError> {
    let (mut system, mut initial) = MultibodySystem::new(model, laws, &EquationSetting::default())?;
    let motions = match place {
        PlaceChoice::Equilibrium => system.equilibrium(&initial)?.motions,
        PlaceChoice::Initial => {
            initial.qd.fill(0.0);
            initial.qdd.fill(0.0);
            system.linearise(&initial)?
        }
    };
    let found = modes(&motions)?;
    Ok((motions, found))
}

fn write(path: &std::path::Path, value: &Value) -> Result<(), CommandFailure> {
    let text = format!("{value:#}\n");
    output::write_file(path, |writer| writer.write_all(text.as_bytes()))
}

fn unit(kind: JointKind) -> &'static str {
    if kind.is_revolute() { "rad" } else { "m" }
}

fn equilibrium_text(model: &Model, found: &Equilibrium) -> String {
    let mut rows = Vec::new();
    for (index, joint) in model.joints.iter().enumerate() {
        let place = found.motions.joints.binary_search(&index).ok();
        let remark = match place.map(|place| found.errors[place]) {
            Some(Some(error)) => format!("{error:.1e}"),
            Some(None) => "free".to_owned(),
            None => String::new(),
        };
        let [position, start] = [found.state.q[index], joint.initial[0]];
        rows.push(vec![
            (index + 1).to_string(),
            joint.name.clone(),
            format!("{position:.12}"),
            unit(joint.kind).to_owned(),
            format!("{:.3e}", position - start),
            joint.nature.name().to_owned(),
            remark,
        ]);
    }
    let head = ">joint | name | >position | | >from start | nature | >error";
    format!(
        "{}: equilibrium after {} of Newton's method\n\n{}\n\
         Nothing holds a 'free' joint: it stays where it starts. The error is the most by which\n\
         rounding of the forces moves the position.\n",
        model.name,
        counted(found.rounds, "round"),
        text_lines(head, &rows)
    )
}

fn equilibrium_json(model: &Model, found: &Equilibrium) -> Value {
    let joints = model.joints.iter().enumerate().map(|(index, joint)| {
        let place = found.motions.joints.binary_search(&index).ok();
        json!({
            "name": joint.name,
            "nature": joint.nature.name(),
            "position": found.state.q[index],
            "error": place.and_then(|place| found.errors[place]),
        })
    });
    json!({
        "model": model.name,
        "rounds": found.rounds,
        "joints": joints.collect::<Vec<Value>>(),
    })
}

/// Joints that a line of a mode names.
const NAMED: usize = 3;

/// Joints that move less than this share of the largest motion are not named.
const SEEN: f64 = 0.05;

/// The joints that move most, with the share and the phase of their motion.
fn movers(model: &Model, motions: &SmallMotions, mode: &Mode) -> String {
    let mut order: Vec<usize> = motions.joints.clone();
    // What is alike but for rounding stays in the order of the joints.
    let share = |joint: usize| (mode.shape[joint].norm() * 1e6).round();
    order.sort_by(|&one, &other| share(other).total_cmp(&share(one)));
    let seen = order.into_iter().take(NAMED);
    let seen = seen.filter(|&joint| mode.shape[joint].norm() >= SEEN);
    let named = seen.map(|joint| {
        let motion = mode.shape[joint];
        let degrees = motion.arg().to_degrees().round();
        let name = &model.joints[joint].name;
        match degrees.abs() {
            0.0 => format!("{name} {:.2}", motion.norm()),
            180.0 => format!("{name} -{:.2}", motion.norm()),
            _ => format!("{name} {:.2} at {degrees}\u{b0}", motion.norm()),
        }
    });
    named.collect::<Vec<String>>().join(", ")
}

fn modal_text(
    model: &Model,
    (at, motions): (PlaceChoice, &SmallMotions),
    found: &[Mode],
) -> String {
    let mut rows = Vec::new();
    for (index, mode) in found.iter().enumerate() {
        let oscillates = mode.eigenvalue.im > 0.0;
        let number = |number: f64, shown: bool| {
            if shown {
                format!("{number:.6}")
            } else {
                String::new()
            }
        };
        rows.push(vec![
            (index + 1).to_string(),
            number(mode.frequency(), oscillates),
            number(100.0 * mode.damping_ratio(), oscillates),
            format!("{:.6}", mode.eigenvalue.re),
            number(mode.eigenvalue.im, oscillates),
            mode.error
                .map_or_else(|| "several".to_owned(), |error| format!("{error:.1e}")),
            movers(model, motions, mode),
        ]);
    }
    let head = ">mode | >Hz | >damping % | >Re 1/s | >Im 1/s | >error 1/s | joints that move most";
    let mut text = format!(
        "{}: {} of freedom\n\n{}",
        model.name,
        counted(motions.joints.len(), "degree"),
        text_lines(head, &rows)
    );
    let unbalanced = motions.residual.iter().zip(&motions.rounding);
    if at == PlaceChoice::Initial
        && unbalanced
            .into_iter()
            .any(|(left, rounding)| left.abs() > 1e3 * rounding)
    {
        text += "\nIn this state forces are not in balance: it is not an equilibrium.\n";
    }
    if found.iter().any(|mode| mode.error.is_none()) {
        text += "\n'several': eigenvalues fall together here, as those of a motion that nothing holds do.\n";
    }
    text
}

fn modal_json(model: &Model, motions: &SmallMotions, found: &[Mode]) -> Value {
    let rows = |matrix: &robovec_dynamics::kinematics::linear::DenseMatrix| -> Vec<Vec<f64>> {
        (0..matrix.rows())
            .map(|row| matrix.row(row).to_vec())
            .collect()
    };
    let modes = found.iter().map(|mode| {
        let shape = mode.shape.iter().map(|x| json!([x.re, x.im]));
        json!({
            "frequency": mode.frequency(),
            "damping_ratio": mode.damping_ratio(),
            "eigenvalue": [mode.eigenvalue.re, mode.eigenvalue.im],
            "error": mode.error,
            "shape": shape.collect::<Vec<Value>>(),
        })
    });
    let name = |&joint: &usize| model.joints[joint].name.clone();
    json!({
        "model": model.name,
        "independent": motions.joints.iter().map(name).collect::<Vec<String>>(),
        "joints": model.joints.iter().map(|joint| joint.name.clone()).collect::<Vec<String>>(),
        "mass": rows(&motions.mass),
        "damping": rows(&motions.damping),
        "stiffness": rows(&motions.stiffness),
        "modes": modes.collect::<Vec<Value>>(),
    })
}
