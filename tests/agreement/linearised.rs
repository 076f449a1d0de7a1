//! Derivatives of accelerations with closed loops, and linear systems, against
//! differences of the reference in double-double: its loops are closed by a
//! separate Newton method, and its accelerations solve the full equations.

use super::closing::{closed, full_at, numbered_rows, outputs, rows, solve, with_velocities};
use super::{Case, Outputs};
use crate::reference::State;
use robovec::model::Nature;
use robovec::robotran::FunctionKind;
use robovec_num::double_double::Double;

/// Number of models tried.
const MODELS: u64 = 24;

/// The step of differences; its square is the error they leave.
const STEP: f64 = 1e-9;

/// A case, with who depends on whom.
struct ClosedCase {
    case: Case,
    forces: Vec<f64>,
    /// Joints that the loops determine.
    dependent: Vec<usize>,
    /// The rows of the reference that determine the others.
    kept: Vec<usize>,
}

impl ClosedCase {
    fn new(seed: u64) -> Option<ClosedCase> {
        let mut case = closed(seed)?;
        let joints = 0..case.model.joints.len();
        let forces: Vec<f64> = joints.map(|joint| (joint * 7 % 11) as f64 - 5.0).collect();
        let round = outputs(&case, FunctionKind::LoopPositions, &forces)?;
        let numbered = numbered_rows(&case);
        let own: Vec<usize> = round.assigned("h").map(|(row, _)| row).collect();
        with_velocities(&mut case, &forces, &own);
        Some(ClosedCase {
            dependent: round.assigned("q").map(|(joint, _)| joint).collect(),
            kept: own.iter().map(|&row| numbered[row]).collect(),
            forces,
            case,
        })
    }

    /// The columns of the dependent joints in the rows that count.
    fn square(&self, jacobian: &[Vec<Double>]) -> Vec<Vec<Double>> {
        let row = |row: &Vec<Double>| self.dependent.iter().map(|&joint| row[joint]).collect();
        jacobian.iter().map(row).collect()
    }

    /// Closes the loops in positions and velocities.
    fn close(&self, state: &mut State<Double>) {
        for _ in 0..4 {
            let loops = rows(&self.case, state, &self.kept);
            let step = solve(self.square(&loops.jacobian), loops.residual);
            for (&joint, step) in self.dependent.iter().zip(step) {
                state.q[joint] = state.q[joint] - step;
            }
        }
        let loops = rows(&self.case, state, &self.kept);
        let moved = loops.jacobian.iter().map(|row| {
            let others = (0..state.qd.len()).filter(|joint| !self.dependent.contains(joint));
            others.fold(Double::from(0.0), |sum, joint| {
                sum - row[joint] * state.qd[joint]
            })
        });
        let rates = solve(self.square(&loops.jacobian), moved.collect());
        for (&joint, rate) in self.dependent.iter().zip(rates) {
            state.qd[joint] = rate;
        }
    }

    fn accelerations(&self, mut state: State<Double>, forces: &[f64]) -> Vec<Double> {
        self.close(&mut state);
        let loops = rows(&self.case, &state, &self.kept);
        full_at(&self.case, &state, forces, &loops).0
    }

    /// The derivatives of all accelerations by the position, the velocity or
    /// the force of a joint.
    fn column(&self, array: &str, joint: usize) -> Vec<Double> {
        let state = self.case.exact().1;
        let at = |step: f64| {
            let (mut moved, mut forces) = (state.clone(), self.forces.clone());
            match array {
                "qdd_q" => moved.q[joint] = moved.q[joint] + Double::from(step),
                "qdd_qd" => moved.qd[joint] = moved.qd[joint] + Double::from(step),
                _ => forces[joint] += step,
            }
            self.accelerations(moved, &forces)
        };
        // Accelerations are linear in forces, and forces are no wide numbers.
        let step = if array == "qdd_Qq" { 0.5 } else { STEP };
        let pairs = at(step).into_iter().zip(at(-step));
        let slope = |(after, before)| (after - before) / Double::from(2.0 * step);
        pairs.map(slope).collect()
    }
}

#[test]
fn derivatives_of_accelerations_keep_loops_closed() {
    let (mut tried, mut seed, mut worst) = (0, 0, 0.0f64);
    while tried < MODELS {
        seed += 1;
        let Some(closed) = ClosedCase::new(seed) else {
            continue;
        };
        tried += 1;
        let case = &closed.case;
        let given = |kind: FunctionKind| {
            outputs(case, kind, &closed.forces)
                .unwrap_or_else(|| panic!("seed {seed}: no {}", kind.name()))
        };
        let (accel, linear) = (given(FunctionKind::AccelD), given(FunctionKind::Linear));
        let joints = case.model.joints.len();
        let is_driven = |joint: usize| case.model.joints[joint].nature == Nature::Driven;
        let moves = |joint: &usize| !closed.dependent.contains(joint);
        let free: Vec<usize> = (0..joints)
            .filter(moves)
            .filter(|&joint| !is_driven(joint))
            .collect();
        for array in ["qdd_q", "qdd_qd", "qdd_Qq"] {
            let columns = (0..joints).filter(|joint| match array {
                "qdd_Qq" => !is_driven(*joint),
                "qdd_qd" => moves(joint) && case.model.joints[*joint].has_velocity,
                _ => moves(joint),
            });
            let expected: Vec<(usize, Vec<Double>)> = columns
                .map(|joint| (joint, closed.column(array, joint)))
                .collect();
            let sizes = expected.iter().flat_map(|(_, column)| column);
            let size = sizes.fold(1.0f64, |size, x| size.max(x.high.abs()));
            let found = accel.array(array).expect("it is an output");
            for (column, expected) in &expected {
                for row in (0..joints).filter(|&row| !is_driven(row)) {
                    let element = found[row * joints + column];
                    let error = expected[row].distance(element) / size;
                    assert!(
                        error < 1e-10,
                        "seed {seed}, {array}[{},{}]: {element} is not {}",
                        row + 1,
                        column + 1,
                        expected[row].high
                    );
                    worst = worst.max(error);
                }
            }
            compare_linear(&linear, array, (found, joints), &free, seed);
        }
    }
    println!("worst of {MODELS} models: {worst:e}");
}

/// `A` and `B` hold the same numbers at the places of the state.
fn compare_linear(
    linear: &Outputs,
    array: &str,
    (found, joints): (&[f64], usize),
    free: &[usize],
    seed: u64,
) {
    let count = free.len();
    let (name, first, width) = match array {
        "qdd_q" => ("A", 0, 2 * count),
        "qdd_qd" => ("A", count, 2 * count),
        _ => ("B", 0, joints),
    };
    let matrix = linear.array(name).expect("it is an output");
    assert_eq!(matrix.len(), 2 * count * width, "seed {seed}");
    for (row, &joint) in free.iter().enumerate() {
        let columns: Vec<usize> = match name {
            "A" => free.to_vec(),
            _ => (0..joints).collect(),
        };
        for (place, column) in columns.into_iter().enumerate() {
            let expected = found[joint * joints + column];
            let element = matrix[(count + row) * width + first + place];
            let error = (element - expected).abs();
            assert!(
                error <= 1e-9 * expected.abs().max(1.0),
                "seed {seed}, {name}: {element} is not {expected}"
            );
        }
        if name == "A" {
            assert_eq!(matrix[row * width + count + row], 1.0, "seed {seed}");
        }
    }
}
