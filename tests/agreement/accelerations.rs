//! Accelerations for given joint forces, by their residual in the equations of
//! motion: the possible error of `qdd` itself depends on the mass matrix.

use super::{Case, Outputs, PLAIN, each};
use crate::reference::dynamics::{bias, mass_matrix};
use crate::reference::loops::constraints;
use crate::reference::random::Recipe;
use robovec::generate::{Formulation, GenerationRequest};
use robovec::kinematics::linear::{DenseMatrix, solve_square};
use robovec::model::{Model, Nature, mbs::read_mbs};
use robovec::motion::{EquationSetting, Laws, MultibodySystem};
use robovec::robotran::FunctionKind;
use robovec_num::double_double::Double;
use std::path::Path;

/// Accelerations of all joints by a formulation; those of driven ones are
/// given.
fn accelerations(case: &Case, formulation: Formulation, forces: &[f64]) -> Vec<f64> {
    let module = case.generate(&GenerationRequest {
        formulation,
        ..GenerationRequest::new(FunctionKind::Accelred)
    });
    let mut inputs = case.inputs();
    inputs.joint_forces.copy_from_slice(forces);
    let outputs = Outputs::of(case, &module, "accelred", &inputs);
    let mut found = case.state.qdd.clone();
    for (place, number) in outputs.assigned("qdd") {
        if case.model.joints[place].nature != Nature::Driven {
            found[place] = number;
        }
    }
    found
}

fn forces(case: &Case) -> Vec<f64> {
    let joints = 0..case.model.joints.len();
    joints.map(|joint| (joint * 7 % 11) as f64 - 5.0).collect()
}

/// `M qdd + c - Qq`, and the size of its terms.
fn rest(case: &Case, forces: &[f64], accelerations: &[f64]) -> (Vec<Double>, f64) {
    let (tree, state) = case.exact();
    let mut size = 0.0f64;
    let rows = mass_matrix(&tree, &state);
    let bias = bias(&tree, &state);
    let rest = rows
        .iter()
        .zip(bias)
        .zip(forces)
        .map(|((row, bias), &force)| {
            let mut sum = bias - Double::from(force);
            size = size.max(bias.high.abs() + force.abs());
            for (&entry, &acceleration) in row.iter().zip(accelerations) {
                let term = entry * Double::from(acceleration);
                size = size.max(term.high.abs());
                sum = sum + term;
            }
            sum
        });
    (rest.collect(), size)
}

#[test]
fn accelerations_of_trees_leave_nothing_of_the_equations_of_motion() {
    let recipe = Recipe {
        massless: false,
        ..PLAIN
    };
    each(recipe, |case| {
        let forces = forces(case);
        for formulation in Formulation::ALL {
            let found = accelerations(case, formulation, &forces);
            let (rest, size) = rest(case, &forces, &found);
            for (joint, rest) in rest.iter().enumerate() {
                let free = case.model.joints[joint].nature != Nature::Driven;
                assert!(
                    !free || rest.high.abs() <= 1e-11 * size,
                    "seed {}, {}, joint {}: {:e} of {size:e}",
                    case.seed,
                    formulation.name(),
                    joint + 1,
                    rest.high
                );
            }
        }
    });
}

/// An example model with some motion of its independent joints.
fn example(name: &str) -> Model {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let bytes = std::fs::read(path.join(name)).expect("an example model");
    let mut model = read_mbs(name, &bytes).expect("a model").model;
    for (index, joint) in model.joints.iter_mut().enumerate() {
        joint.initial[1] = 0.7 - 0.3 * (index % 4) as f64;
    }
    model
}

#[test]
fn accelerations_with_loops_leave_what_the_loops_can_carry() {
    for name in ["four-bar.mbs", "slider-crank.mbs", "quarter-car.mbs"] {
        let model = example(name);
        let laws = Laws::of_model(&model);
        let (system, closed) =
            MultibodySystem::new(&model, laws, &EquationSetting::default()).expect("a system");
        let roles = system.partition().clone();
        let state = crate::reference::State {
            q: closed.q,
            qd: closed.qd,
            qdd: closed.qdd,
            frc: closed.frc,
            trq: closed.trq,
        };
        let case = Case {
            seed: 0,
            model: model.clone(),
            state,
        };
        let forces = forces(&case);
        let loops = constraints(&case.model, &case.exact().1);
        for formulation in Formulation::ALL {
            if !formulation.closes_loops() {
                continue;
            }
            let found = accelerations(&case, formulation, &forces);
            for (row, quadratic) in loops.jacobian.iter().zip(&loops.quadratic) {
                let second = row
                    .iter()
                    .zip(&found)
                    .fold(*quadratic, |sum, (&j, &a)| sum + j * Double::from(a));
                assert!(second.high.abs() < 1e-11, "{name}: {:e}", second.high);
            }
            // What is left of the equations of motion is J' lambda.
            let (rest, size) = rest(&case, &forces, &found);
            let changing: Vec<&Vec<Double>> = loops
                .jacobian
                .iter()
                .filter(|row| row.iter().any(|entry| entry.high.abs() > 1e-12))
                .collect();
            assert_eq!(changing.len(), roles.rows.len());
            let count = changing.len();
            let (mut square, mut right) = (
                DenseMatrix::zeros(count, count),
                DenseMatrix::zeros(count, 1),
            );
            for (i, &joint) in roles.dependent.iter().enumerate() {
                right[(i, 0)] = rest[joint].high;
                for (k, row) in changing.iter().enumerate() {
                    square[(i, k)] = row[joint].high;
                }
            }
            let multipliers = solve_square(square, right).expect("regular");
            for joint in 0..rest.len() {
                let carried: f64 = (0..count)
                    .map(|k| changing[k][joint].high * multipliers[(k, 0)])
                    .sum();
                let left = rest[joint].high - carried;
                assert!(
                    left.abs() < 1e-11 * size,
                    "{name}, {joint}: {left:e} of {size:e}"
                );
            }
        }
    }
}
