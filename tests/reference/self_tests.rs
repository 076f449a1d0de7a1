//! The reference held against first principles, in double-double, where
//! central differences leave some 18 digits.

use super::dynamics::{
    bias, forward_dynamics, inverse_dynamics, kinetic_energy, mass_matrix, momentum,
    potential_energy,
};
use super::forces::{add_external, add_links, link_lengths};
use super::kinematics::{frames, point};
use super::loops::constraints;
use super::random::{self, Recipe};
use super::spatial::{add, apply, cross, dot, scale, skew, transpose, zeros};
use super::{Real, State, Tree};
use robovec::model::{CutKind, Model};
use robovec_num::double_double::Double;
use robovec_num::random::Random;

const RECIPE: Recipe = Recipe {
    bodies: 6,
    zeros: 0.2,
    massless: false,
    driven: false,
    placed: false,
    cuts: 1,
    devices: 2,
};

/// The step of differences; its square is the error they leave.
const STEP: f64 = 1e-9;
const TOLERANCE: f64 = 1e-13;

/// Runs a test on a few random models and states.
fn each(test: impl Fn(&Model, &State<Double>)) {
    for seed in 1..=8 {
        let mut random = Random::new(seed);
        let recipe = Recipe {
            placed: seed % 2 == 0,
            ..RECIPE
        };
        let model = random::model(&mut random, &recipe);
        let state = random::state(&mut random, &model);
        test(&model, &state.convert(Double::from));
    }
}

/// The state a moment later, with accelerations held.
fn later(state: &State<Double>, time: f64) -> State<Double> {
    let (t, half) = (Double::from(time), Double::from(0.5));
    let mut moved = state.clone();
    for i in 0..state.q.len() {
        moved.q[i] = state.q[i] + t * state.qd[i] + half * t * t * state.qdd[i];
        moved.qd[i] = state.qd[i] + t * state.qdd[i];
    }
    moved
}

/// The derivative in time of a function of the state.
fn derivative<const N: usize>(
    state: &State<Double>,
    what: impl Fn(&State<Double>) -> [Double; N],
) -> [Double; N] {
    let (after, before) = (what(&later(state, STEP)), what(&later(state, -STEP)));
    std::array::from_fn(|i| (after[i] - before[i]) / Double::from(2.0 * STEP))
}

fn close(left: Double, right: Double, what: &str) {
    let error = (left - right).value().abs();
    let size = left.value().abs().max(1.0);
    assert!(
        error <= TOLERANCE * size,
        "{what}: {} is not {}",
        left.value(),
        right.value()
    );
}

fn close_all(left: &[Double], right: &[Double], what: &str) {
    assert_eq!(left.len(), right.len());
    for (&left, &right) in left.iter().zip(right) {
        close(left, right, what);
    }
}

#[test]
fn velocities_and_accelerations_are_derivatives_of_positions() {
    each(|model, state| {
        let tree = Tree::<Double>::new(model);
        let joint = Some(model.joints.len() - 1);
        let place = [0.3, -0.4, 0.5].map(Double::from);
        let at = |state: &State<Double>| point(&tree, &frames(&tree, state, zeros()), joint, place);
        let now = at(state);
        let velocity = derivative(state, |state| at(state).position);
        close_all(&velocity, &now.velocity, "velocity");
        let acceleration = derivative(state, |state| at(state).velocity);
        close_all(&acceleration, &now.acceleration, "acceleration");
        // R' = -R ~w, as the rows of R are axes that turn with w.
        let spin = skew(now.angular_velocity);
        for row in 0..3 {
            let turned = derivative(state, |state| at(state).rotation[row]);
            close_all(&turned, &apply(&spin, now.rotation[row]), "rotation");
        }
        let spin = derivative(state, |state| at(state).angular_velocity);
        close_all(&spin, &now.angular_acceleration, "angular acceleration");
        for i in 0..3 {
            let product = |row: &[Double]| {
                row.iter()
                    .zip(&state.qd)
                    .fold(Double::zero(), |sum, (&j, &v)| sum + j * v)
            };
            close(product(&now.jacobian[i]), now.velocity[i], "Jacobian");
            close(
                product(&now.jacobian[i + 3]),
                now.angular_velocity[i],
                "Jacobian of the angular velocity",
            );
        }
    });
}

/// Kinetic energy by König's theorem, from points alone.
fn energy_by_koenig(tree: &Tree<Double>, state: &State<Double>) -> Double {
    let frames = frames(tree, state, zeros());
    let mut twice = Double::zero();
    for (i, link) in tree.links.iter().enumerate() {
        let center = point(tree, &frames, Some(i), link.center);
        let spin = apply(&center.rotation, center.angular_velocity);
        twice = twice
            + link.mass * dot(center.velocity, center.velocity)
            + dot(spin, apply(&link.inertia, spin))
            + link.armature * state.qd[i] * state.qd[i];
    }
    twice / Double::from(2.0)
}

#[test]
fn the_mass_matrix_is_that_of_the_kinetic_energy() {
    each(|model, state| {
        let tree = Tree::<Double>::new(model);
        let energy = energy_by_koenig(&tree, state);
        close(kinetic_energy(&tree, state), energy, "kinetic energy");
        let matrix = mass_matrix(&tree, state);
        let mut twice = Double::zero();
        for (row, &left) in matrix.iter().zip(&state.qd) {
            for (&entry, &right) in row.iter().zip(&state.qd) {
                twice = twice + left * entry * right;
            }
        }
        close(twice / Double::from(2.0), energy, "qd' M qd / 2");
    });
}

/// `Q = d/dt (dT/dqd) - dT/dq + dV/dq` minus the external forces.
#[test]
fn inverse_dynamics_is_lagranges() {
    each(|model, state| {
        let tree = Tree::<Double>::new(model);
        let generalized = |state: &State<Double>, j: usize| {
            let matrix = mass_matrix(&tree, state);
            matrix[j]
                .iter()
                .zip(&state.qd)
                .fold(Double::zero(), |sum, (&m, &v)| sum + m * v)
        };
        let lagrangian =
            |state: &State<Double>| energy_by_koenig(&tree, state) - potential_energy(&tree, state);
        let forces = inverse_dynamics(&tree, state);
        for (j, &force) in forces.iter().enumerate() {
            let [rate] = derivative(state, |state| [generalized(state, j)]);
            let shifted = |by: f64| {
                let mut moved = state.clone();
                moved.q[j] = moved.q[j] + Double::from(by);
                lagrangian(&moved)
            };
            let slope = (shifted(STEP) - shifted(-STEP)) / Double::from(2.0 * STEP);
            let external = external_power_per_velocity(&tree, state, j);
            close(force, rate - slope - external, "joint force");
        }
    });
}

/// Contribution of external forces to a joint, from the motion of the centres
/// of mass.
fn external_power_per_velocity(tree: &Tree<Double>, state: &State<Double>, j: usize) -> Double {
    let frames = frames(tree, state, zeros());
    let mut sum = Double::zero();
    for (i, link) in tree.links.iter().enumerate() {
        let center = point(tree, &frames, Some(i), link.center);
        let outward = transpose(&center.rotation);
        let column = |from: usize| [0, 1, 2].map(|k| center.jacobian[from + k][j]);
        sum = sum
            + dot(column(0), apply(&outward, state.frc[i]))
            + dot(column(3), apply(&outward, state.trq[i]));
    }
    sum
}

#[test]
fn forward_and_inverse_dynamics_are_inverses() {
    each(|model, state| {
        let tree = Tree::<Double>::new(model);
        let forces = inverse_dynamics(&tree, state);
        let back = forward_dynamics(&tree, state, &forces).expect("positive definite");
        close_all(&back, &state.qdd, "accelerations");
        let mut still = state.clone();
        still.qdd.fill(Double::zero());
        close_all(&inverse_dynamics(&tree, &still), &bias(&tree, state), "c");
    });
}

#[test]
fn momentum_changes_by_the_forces_from_outside() {
    each(|model, state| {
        // Joint forces of the joints on the base come from outside: the check
        // is by points instead.
        let tree = Tree::<Double>::new(model);
        let frames = frames(&tree, state, zeros());
        let mut sum = [Double::zero(); 6];
        for (i, link) in tree.links.iter().enumerate() {
            let center = point(&tree, &frames, Some(i), link.center);
            let linear = scale(link.mass, center.velocity);
            let spin = apply(&center.rotation, center.angular_velocity);
            let outward = transpose(&center.rotation);
            let own = apply(&outward, apply(&link.inertia, spin));
            let angular = add(own, cross(center.position, linear));
            for k in 0..3 {
                sum[k] = sum[k] + angular[k];
                sum[k + 3] = sum[k + 3] + linear[k];
            }
        }
        close_all(&momentum(&tree, state), &sum, "momentum");
    });
}

#[test]
fn constraint_rows_are_derivatives_of_each_other() {
    each(|model, state| {
        let rows = |state: &State<Double>| constraints(model, state);
        let now = rows(state);
        let mut still = state.clone();
        still.qdd.fill(Double::zero());
        let rate = |state: &State<Double>, row: usize| {
            let constraint = rows(state);
            constraint.jacobian[row]
                .iter()
                .zip(&state.qd)
                .fold(Double::zero(), |sum, (&j, &v)| sum + j * v)
        };
        let mut row = 0;
        for cut in &model.cuts {
            for place in 0..cut.kind.rows() {
                let [second] = derivative(&still, |state| [rate(state, row)]);
                let [first] = derivative(state, |state| [rows(state).residual[row]]);
                // The rotation rows of a solid cut are angular velocities.
                if !(cut.kind == CutKind::Solid && place >= 3) {
                    close(first, rate(state, row), "h and Jac");
                }
                close(second, now.quadratic[row], "Jac qd and Jdqd");
                row += 1;
            }
        }
        assert_eq!(row, now.residual.len());
    });
}

/// The angular rows of a solid cut follow from its rotation where that is
/// closed: there `h` and `Jac` must agree to first order.
#[test]
fn solid_cuts_agree_to_first_order_where_they_are_closed() {
    let mut model = random::model(&mut Random::new(3), &RECIPE);
    model.cuts.retain(|cut| cut.kind == CutKind::Solid);
    let mut closed = random::state(&mut Random::new(4), &model).convert(Double::from);
    closed.q.fill(Double::zero());
    let now = constraints(&model, &closed);
    for row in 3..6 {
        close(now.residual[row], Double::zero(), "closed rotation");
        let [rate] = derivative(&closed, |state| [constraints(&model, state).residual[row]]);
        let product = now.jacobian[row]
            .iter()
            .zip(&closed.qd)
            .fold(Double::zero(), |sum, (&j, &v)| sum + j * v);
        close(rate, product, "rotation rows");
    }
}

#[test]
fn links_do_the_work_of_their_length() {
    each(|model, state| {
        let tree = Tree::<Double>::new(model);
        let lengths = link_lengths(model, state);
        let rates = derivative(state, |state| {
            let lengths = link_lengths(model, state);
            [lengths[0].0, lengths[1].0]
        });
        close_all(&rates, &[lengths[0].1, lengths[1].1], "rates of length");
        let strengths = [3.0, -7.0].map(Double::from);
        let mut free = state.clone();
        free.frc.fill(zeros());
        free.trq.fill(zeros());
        let pulled = add_links(model, &free, &strengths);
        let mut power = Double::zero();
        for j in 0..model.joints.len() {
            power = power + external_power_per_velocity(&tree, &pulled, j) * state.qd[j];
        }
        let expected = strengths[0] * rates[0] + strengths[1] * rates[1];
        close(power, -expected, "power");
    });
}

#[test]
fn external_forces_do_work_at_their_point() {
    each(|model, state| {
        let tree = Tree::<Double>::new(model);
        let numbers: [Double; 9] =
            std::array::from_fn(|i| Double::from([5.0, -3.0, 2.0][i % 3] / (i + 1) as f64));
        let mut free = state.clone();
        free.frc.fill(zeros());
        free.trq.fill(zeros());
        let given = vec![numbers; model.forces.len()];
        let loaded = add_external(model, &free, &given);
        let (mut power, mut expected) = (Double::zero(), Double::zero());
        for j in 0..model.joints.len() {
            power = power + external_power_per_velocity(&tree, &loaded, j) * state.qd[j];
        }
        let frames = frames(&tree, state, zeros());
        for force in &model.forces {
            let joint = model.last_joint(model.points[force.point].body);
            let offset = [6, 7, 8].map(|i| numbers[i]);
            let at = point(&tree, &frames, joint, offset);
            expected = expected
                + dot([0, 1, 2].map(|i| numbers[i]), at.velocity)
                + dot([3, 4, 5].map(|i| numbers[i]), at.angular_velocity);
        }
        close(power, expected, "power");
    });
}
