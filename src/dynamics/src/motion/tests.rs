//! Generated accelerations of loops against the equations of motion.

use super::{EquationSetting, Laws, MotionEquations, MultibodySystem};
use crate::generate::{Formulation, GenerationRequest, generate};
use crate::kinematics::linear::{DenseMatrix, solve_square};
use crate::kinematics::{InputSources, MotionState};
use robovec_ir::View;
use robovec_ir::evaluate::evaluate;
use robovec_model::Model;
use robovec_model::family::built_in;
use robovec_num::arithmetic::Binary64;
use robovec_robotran::FunctionKind;

/// `qdd` and `Lambda` in a state, in binary64.
fn accelerations(model: &Model, formulation: Formulation, state: &MotionState) -> Vec<f64> {
    let mut request = GenerationRequest::new(FunctionKind::Accelred);
    request.formulation = formulation;
    request.options.multipliers = true;
    let module = generate(model, &request).expect("the loops close");
    let view = View {
        tables: &module.tables,
        function: &module.functions[0],
    };
    let inputs = InputSources::new(model, view).expect("the function belongs to the model");
    evaluate(view.function, &Binary64, &inputs.gather(state))
}

/// The state after closing the loops, with arbitrary joint forces and
/// velocities: no velocity needs to satisfy the loops for the equations between
/// `M`, `c`, `Jac` and `Jdqd` to hold.
fn some_state(model: &Model) -> MotionState {
    let setting = EquationSetting::default();
    let laws = Laws::of_model(model);
    let (_, mut state) = MultibodySystem::new(model, laws, &setting).expect("loops close");
    for joint in 0..model.joints.len() {
        state.qd[joint] = 0.3 + joint as f64;
        state.joint_forces[joint] = 2.0 - 3.0 * joint as f64;
    }
    state
}

#[test]
fn accelerations_satisfy_loops() {
    for name in ["four-bar", "slider-crank"] {
        let model = built_in(name).expect("a family");
        let state = some_state(&model);
        let equations =
            MotionEquations::new(&model, &EquationSetting::default()).expect("it generates");
        let (mass, bias) = equations.dynamics(&state);
        let (_, jacobian) = equations.constraints().evaluate(&state);
        let (n, rows) = (model.joints.len(), jacobian.rows());
        assert!(rows > 0);
        let mut matrix = DenseMatrix::zeros(n + rows, n + rows);
        let mut right = DenseMatrix::zeros(n + rows, 1);
        for i in 0..n {
            for j in 0..n {
                matrix[(i, j)] = mass[(i, j)];
            }
            for row in 0..rows {
                matrix[(i, n + row)] = -jacobian[(row, i)];
                matrix[(n + row, i)] = jacobian[(row, i)];
            }
            right[(i, 0)] = state.joint_forces[i] - bias[i];
        }
        for (row, value) in equations.quadratic(&state).into_iter().enumerate() {
            right[(n + row, 0)] = -value;
        }
        let expected = solve_square(matrix, right).expect("no row is redundant");
        for formulation in Formulation::ALL {
            if !formulation.closes_loops() {
                continue;
            }
            let found = accelerations(&model, formulation, &state);
            assert_eq!(found.len(), n + rows);
            for (joint, &value) in found.iter().enumerate() {
                let error = (value - expected[(joint, 0)]).abs();
                assert!(
                    error <= 1e-10 * (1.0 + value.abs()),
                    "{} of {}, element {joint}: {error:e}",
                    formulation.name(),
                    model.name
                );
            }
        }
    }
}
