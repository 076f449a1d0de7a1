//! Derivatives of forces and accelerations, against differences of the
//! reference in double-double; the inverse of the mass matrix and the
//! regressor, against products with known results.

use super::{Case, Outputs, PLAIN, each};
use crate::reference::dynamics::{bias, inverse_dynamics, mass_matrix, solve};
use crate::reference::random::Recipe;
use crate::reference::{Real, State, Tree};
use robovec::generate::{GenerationRequest, Options, ParameterBinding};
use robovec::model::Nature;
use robovec::robotran::FunctionKind;
use robovec_num::double_double::Double;

/// The step of differences; its square is the error they leave.
const STEP: f64 = 1e-9;

/// Variables of differentiation.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Coordinate {
    Position,
    Velocity,
}

/// The derivatives of a function by coordinates, a row for each component, by
/// joints that have a velocity where velocities change.
fn differences(
    case: &Case,
    coordinate: Coordinate,
    function: impl Fn(&Tree<Double>, &State<Double>) -> Vec<Double>,
) -> Vec<Double> {
    let (tree, state) = case.exact();
    let joints = state.q.len();
    let mut rows = vec![Double::zero(); joints * joints];
    let moves = |joint: &usize| {
        coordinate == Coordinate::Position || case.model.joints[*joint].has_velocity
    };
    for column in (0..joints).filter(moves) {
        let values = |step: f64| {
            let mut moved = state.clone();
            let coordinate = match coordinate {
                Coordinate::Position => &mut moved.q[column],
                Coordinate::Velocity => &mut moved.qd[column],
            };
            *coordinate = *coordinate + Double::from(step);
            function(&tree, &moved)
        };
        let pairs = values(STEP).into_iter().zip(values(-STEP));
        for (row, (after, before)) in pairs.enumerate() {
            rows[joints * row + column] = (after - before) / Double::from(2.0 * STEP);
        }
    }
    rows
}

/// Compares a matrix of joints with the output of a function; one that is all
/// zeros may have any size.
fn compare(case: &Case, outputs: &Outputs, array: &str, expected: &[Double]) {
    let none = vec![0.0; expected.len()];
    let found = outputs.array(array);
    let found = found.filter(|found| found.len() == expected.len());
    case.compare(array, found.unwrap_or(&none), expected);
}

#[test]
fn derivatives_of_inverse_dynamics_are_its_differences() {
    each(PLAIN, |case| {
        let by_position = differences(case, Coordinate::Position, inverse_dynamics);
        let by_velocity = differences(case, Coordinate::Velocity, inverse_dynamics);
        for options in [
            Options::default(),
            Options {
                all_parameters: true,
                expanded: true,
                ..Options::default()
            },
            Options {
                parameters: ParameterBinding::Numbers,
                ..Options::default()
            },
        ] {
            let module = case.generate(&GenerationRequest {
                options,
                ..GenerationRequest::new(FunctionKind::InvdynaD)
            });
            let outputs = Outputs::of(case, &module, "invdyna_d", &case.inputs());
            compare(case, &outputs, "Qq_q", &by_position);
            compare(case, &outputs, "Qq_qd", &by_velocity);
        }
    });
}

/// The accelerations of joints that are not driven, for given forces; zeros for
/// the others.
fn forward(
    case: &Case,
    forces: &[Double],
    tree: &Tree<Double>,
    state: &State<Double>,
) -> Vec<Double> {
    let joints = &case.model.joints;
    let is_free = |joint: &usize| joints[*joint].nature != Nature::Driven;
    let free: Vec<usize> = (0..joints.len()).filter(is_free).collect();
    let masses = mass_matrix(tree, state);
    let bias = bias(tree, state);
    let right = free.iter().map(|&row| {
        let driven = (0..joints.len()).filter(|joint| !is_free(joint));
        driven.fold(forces[row] - bias[row], |sum, joint| {
            sum - masses[row][joint] * state.qdd[joint]
        })
    });
    let rows = free
        .iter()
        .map(|&row| free.iter().map(|&column| masses[row][column]).collect());
    let solution = solve(rows.collect(), right.collect()).expect("bodies have mass");
    let mut accelerations = vec![Double::zero(); joints.len()];
    for (&joint, value) in free.iter().zip(solution) {
        accelerations[joint] = value;
    }
    accelerations
}

/// `M^-1` of the joints that are not driven: the accelerations per unit of
/// force.
fn inverse_mass(case: &Case) -> Vec<Double> {
    let (tree, state) = case.exact();
    let joints = case.model.joints.len();
    let mut inverse = vec![Double::zero(); joints * joints];
    let none = vec![Double::zero(); joints];
    let without = forward(case, &none, &tree, &state);
    let is_free = |joint: &usize| case.model.joints[*joint].nature != Nature::Driven;
    for column in (0..joints).filter(is_free) {
        let mut forces = none.clone();
        forces[column] = Double::from(1.0);
        let with = forward(case, &forces, &tree, &state);
        for row in 0..joints {
            inverse[joints * row + column] = with[row] - without[row];
        }
    }
    inverse
}

/// Bodies with mass and inertia: accelerations are determined.
const HEAVY: Recipe = Recipe {
    massless: false,
    ..PLAIN
};

#[test]
fn derivatives_of_forward_dynamics_are_its_differences() {
    each(HEAVY, |case| {
        let joints = 0..case.model.joints.len();
        let given: Vec<f64> = joints.map(|joint| (joint * 7 % 11) as f64 - 5.0).collect();
        let forces: Vec<Double> = given.iter().map(|&force| Double::from(force)).collect();
        let function =
            |tree: &Tree<Double>, state: &State<Double>| forward(case, &forces, tree, state);
        let mut inputs = case.inputs();
        inputs.joint_forces.copy_from_slice(&given);
        let by_position = differences(case, Coordinate::Position, function);
        let by_velocity = differences(case, Coordinate::Velocity, function);
        let inverse = inverse_mass(case);
        for parameters in [ParameterBinding::Symbols, ParameterBinding::Numbers] {
            let given = |function| {
                let request = GenerationRequest {
                    options: Options {
                        parameters,
                        ..Options::default()
                    },
                    ..GenerationRequest::new(function)
                };
                let module = case.generate(&request);
                Outputs::of(case, &module, function.name(), &inputs)
            };
            let outputs = given(FunctionKind::DirdynaD);
            compare(case, &outputs, "qdd_q", &by_position);
            compare(case, &outputs, "qdd_qd", &by_velocity);
            compare(case, &outputs, "qdd_Qq", &inverse);
            let same = given(FunctionKind::AccelD);
            compare(case, &same, "qdd_q", &by_position);
            compare(case, &given(FunctionKind::Minv), "Minv", &inverse);
        }
    });
}

/// The numbers of a body that the regressor multiplies.
fn inertias(case: &Case, joint: usize) -> [f64; 10] {
    let Some(body) = case.model.body_of(joint) else {
        return [0.0; 10];
    };
    let (mass, [x, y, z]) = (body.mass, body.center);
    let [xx, xy, xz, yy, yz, zz] = body.inertia;
    [
        mass,
        mass * x,
        mass * y,
        mass * z,
        xx + mass * (y * y + z * z),
        xy - mass * x * y,
        xz - mass * x * z,
        yy + mass * (x * x + z * z),
        yz - mass * y * z,
        zz + mass * (x * x + y * y),
    ]
}

#[test]
fn a_regressor_times_inertias_is_inverse_dynamics() {
    each(PLAIN, |case| {
        let (mut tree, mut state) = case.exact();
        for vector in state.frc.iter_mut().chain(&mut state.trq) {
            *vector = [Double::zero(); 3];
        }
        // Rotors have no column.
        for link in &mut tree.links {
            link.armature = Double::zero();
        }
        let joints = case.model.joints.len();
        let module = case.generate(&GenerationRequest::new(FunctionKind::Regressor));
        let outputs = Outputs::of(case, &module, "regressor", &case.inputs());
        let regressor = outputs.array("Y").expect("there are bodies");
        assert_eq!(regressor.len(), joints * 10 * joints, "seed {}", case.seed);
        let numbers: Vec<f64> = (0..joints)
            .flat_map(|joint| inertias(case, joint))
            .collect();
        let products = |row: &[f64]| {
            row.iter()
                .zip(&numbers)
                .map(|(one, other)| one * other)
                .sum()
        };
        let forces: Vec<f64> = regressor.chunks(numbers.len()).map(products).collect();
        case.compare("Y p", &forces, &inverse_dynamics(&tree, &state));
    });
}
