//! Constraints that a user computes, on random models with closed loops:
//! positions, velocities, accelerations, multipliers and forces of actuators
//! against the full equations.

use super::closing::{closed, full, full_at, independent};
use super::{Case, Outputs};
use crate::reference::dynamics::{bias, mass_matrix};
use crate::reference::loops::Constraint;
use crate::reference::random::ModelDraw;
use robovec::generate::{Formulation, GenerationRequest, Options, generate};
use robovec::model::{Model, Nature};
use robovec::robotran::FunctionKind;
use robovec_num::double_double::Double;
use robovec_num::random::Random;

/// Number of models tried.
const MODELS: usize = 60;

/// Number of models with bodies that have no mass.
const MASSLESS: usize = 300;

/// A model with rows that are linear in positions.
struct Bound {
    case: Case,
    /// Place where the rows are zero.
    origin: Vec<f64>,
    /// Their Jacobian.
    jacobian: Vec<Vec<f64>>,
    quadratic: Vec<f64>,
    /// Independent rows of the loops.
    loop_rows: Vec<usize>,
    forces: Vec<f64>,
}

impl Bound {
    /// A model of a seed, with bodies that have no mass where the rows can make
    /// up for it; `None` where the draw has no joint to bind, or no such body.
    fn new(seed: u64, massless: bool) -> Option<Bound> {
        let mut case = closed(seed)?;
        let mut random = Random::new(seed ^ 0x5eed);
        let joints = case.model.joints.len();
        let mut bound = Bound {
            origin: case.state.q.clone(),
            jacobian: Vec::new(),
            quadratic: Vec::new(),
            loop_rows: Vec::new(),
            forces: (0..joints).map(|_| 4.0 * random.unit() - 2.0).collect(),
            case: Case {
                seed,
                model: case.model.clone(),
                state: case.state.convert(|number| number),
            },
        };
        let loops = bound.outputs(FunctionKind::LoopPositions)?;
        bound.loop_rows = loops.assigned("h").map(|(row, _)| row).collect();
        let dependent: Vec<usize> = loops.assigned("q").map(|(joint, _)| joint).collect();
        for (joint, of_model) in case.model.joints.iter_mut().enumerate() {
            if of_model.nature != Nature::Driven {
                of_model.nature = if dependent.contains(&joint) {
                    Nature::Dependent
                } else {
                    Nature::Independent
                };
            }
        }
        let free = case.model.joints.iter_mut();
        let mut free: Vec<_> = free
            .filter(|joint| joint.nature == Nature::Independent)
            .collect();
        let rows = 1 + random.below(3);
        if free.len() <= rows {
            return None;
        }
        let sparse = massless && random.chance(0.5);
        let first = if massless {
            random.below(free.len() - rows + 1)
        } else {
            0
        };
        for joint in free.iter_mut().skip(first).take(rows) {
            joint.nature = Nature::Dependent;
        }
        for _ in 0..rows {
            let entry = |random: &mut Random| {
                if sparse && random.chance(0.6) {
                    0.0
                } else {
                    2.0 * random.unit() - 1.0
                }
            };
            let row = (0..joints).map(|_| entry(&mut random)).collect();
            bound.jacobian.push(row);
            bound.quadratic.push(2.0 * random.unit() - 1.0);
        }
        bound.case.model = case.model;
        if massless && !lighten(&mut bound.case.model, &dependent, rows) {
            return None;
        }
        Some(bound)
    }

    /// A function at the state; `None` where it cannot be generated.
    fn outputs(&self, kind: FunctionKind) -> Option<Outputs> {
        let request = GenerationRequest {
            formulation: Formulation::Composite,
            options: Options {
                user_constraints: self.jacobian.len(),
                multipliers: true,
                growth: true,
                ..Options::default()
            },
            ..GenerationRequest::new(kind)
        };
        let module = generate(&self.case.model, &request).ok()?;
        let mut inputs = self.case.inputs();
        inputs.joint_forces.copy_from_slice(&self.forces);
        let values = self.values();
        let numbers = |array: &str, indices: &[u32]| {
            let place = |number: usize| indices[number] as usize - 1;
            match array {
                "huserc" => Some(values[place(0)]),
                "Juserc" => Some(self.jacobian[place(0)][place(1)]),
                "jdqduserc" => Some(self.quadratic[place(0)]),
                _ => None,
            }
        };
        let subject = (kind.name(), &inputs);
        Some(Outputs::with_numbers(&self.case, &module, subject, numbers))
    }

    fn values(&self) -> Vec<f64> {
        let value = |row: &Vec<f64>| {
            let positions = self.case.state.q.iter().zip(&self.origin);
            let terms = row.iter().zip(positions);
            terms.map(|(entry, (q, origin))| entry * (q - origin)).sum()
        };
        self.jacobian.iter().map(value).collect()
    }

    /// All rows at the state, those of the loops first.
    fn rows(&self) -> Constraint<Double> {
        let mut rows = independent(&self.case, &self.loop_rows);
        let exact = |number: &f64| Double::from(*number);
        rows.residual.extend(self.values().iter().map(exact));
        let own = self.jacobian.iter();
        rows.jacobian
            .extend(own.map(|row| row.iter().map(exact).collect::<Vec<_>>()));
        rows.quadratic.extend(self.quadratic.iter().map(exact));
        rows
    }

    /// Moves the joints that follow, and closes everything again.
    fn close(&mut self) {
        for (joint, of_model) in self.case.model.joints.iter().enumerate() {
            if of_model.nature == Nature::Dependent {
                self.case.state.q[joint] += 1e-4 * (joint as f64 - 3.5);
            }
        }
        for _ in 0..7 {
            let round = self
                .outputs(FunctionKind::LoopPositions)
                .expect("it was generated before");
            for (joint, q) in round.assigned("q") {
                self.case.state.q[joint] = q;
            }
        }
        let velocities = self
            .outputs(FunctionKind::LoopVelocities)
            .expect("what closes has velocities");
        for (joint, qd) in velocities.assigned("qd") {
            self.case.state.qd[joint] = qd;
        }
    }

    /// The largest residuals of rows, of positions and of velocities.
    fn left(&self) -> [f64; 2] {
        let rows = self.rows();
        let largest = |numbers: &mut dyn Iterator<Item = Double>| {
            numbers.fold(0.0f64, |most, number| most.max(number.high.abs()))
        };
        let products = rows.jacobian.iter().map(|row| {
            let terms = row.iter().zip(&self.case.state.qd);
            terms.fold(Double::from(0.0), |sum, (&entry, &qd)| {
                sum + entry * Double::from(qd)
            })
        });
        [
            largest(&mut rows.residual.iter().copied()),
            largest(&mut products.into_iter()),
        ]
    }

    /// Residual of `M qdd + c = Qq + Qc + J^T lambda` at the numbers that a
    /// function gave, in parts of the largest force.
    fn balance(&self, found: &Outputs) -> f64 {
        let (tree, state) = self.case.exact();
        let (mass, bias) = (mass_matrix(&tree, &state), bias(&tree, &state));
        let rows = self.rows();
        let mut multipliers: Vec<f64> = Vec::new();
        let all: Vec<(usize, f64)> = found.assigned("Lambda").collect();
        for &row in &self.loop_rows {
            let (_, number) = all.iter().find(|(place, _)| *place == row).expect("a row");
            multipliers.push(*number);
        }
        let user = &all[self.loop_rows.len()..];
        multipliers.extend(user.iter().map(|(_, number)| *number));
        let mut accelerations = self.case.state.qdd.clone();
        for (joint, number) in found.assigned("qdd") {
            accelerations[joint] = number;
        }
        let driven: Vec<(usize, f64)> = found.assigned("Qc").collect();
        let (mut worst, mut size) = (0.0f64, 1.0f64);
        for joint in 0..accelerations.len() {
            let mut sum = bias[joint] - Double::from(self.forces[joint]);
            for (&entry, &acceleration) in mass[joint].iter().zip(&accelerations) {
                let term = entry * Double::from(acceleration);
                size = size.max(term.high.abs());
                sum = sum + term;
            }
            for (row, &multiplier) in rows.jacobian.iter().zip(&multipliers) {
                sum = sum - row[joint] * Double::from(multiplier);
            }
            let force = driven.iter().find(|(place, _)| *place == joint);
            sum = sum - Double::from(force.map_or(0.0, |(_, force)| *force));
            worst = worst.max(sum.high.abs());
        }
        worst / size
    }

    /// Distance of accelerations from those wanted when the forces that inverse
    /// dynamics finds for them act, in parts of the largest.
    fn actuated(&mut self, wanted: &[f64]) -> f64 {
        let kept = self.case.state.qdd.clone();
        self.case.state.qdd.copy_from_slice(wanted);
        let found = self
            .outputs(FunctionKind::Invdynared)
            .expect("independent joints have the actuators");
        let mut forces = self.forces.clone();
        let mut expected = wanted.to_vec();
        for (joint, force) in found.assigned("Qa") {
            forces[joint] += force;
        }
        for (joint, acceleration) in found.assigned("qdd") {
            expected[joint] = acceleration;
        }
        let moved = full(&self.case, &forces, &self.rows());
        self.case.state.qdd = kept;
        distance(&moved, &expected)
    }
}

/// Takes the masses of ends of the tree, so that at most `rows` joints that the
/// loops do not determine move none; false where there is no such end.
fn lighten(model: &mut Model, dependent: &[usize], rows: usize) -> bool {
    let mut left = rows;
    let mut carries = vec![false; model.bodies.len()];
    for body in (0..model.bodies.len()).rev() {
        let joints = model.bodies[body].joints.clone();
        let free = |joint: &usize| {
            model.joints[*joint].nature != Nature::Driven && !dependent.contains(joint)
        };
        let count = joints.filter(free).count();
        if !carries[body] && (1..=left).contains(&count) {
            left -= count;
            let light = &mut model.bodies[body];
            (light.mass, light.center, light.inertia) = (0.0, [0.0; 3], [0.0; 6]);
        } else if let Some(parent) = model.bodies[body].parent {
            carries[parent] = true;
        }
        if let (Some(parent), true) = (model.bodies[body].parent, carries[body]) {
            carries[parent] = true;
        }
    }
    left < rows
}

/// The largest difference in parts of the largest number, at least 1.
fn distance(exact: &[Double], numbers: &[f64]) -> f64 {
    let size = exact.iter().fold(1.0f64, |size, x| size.max(x.high.abs()));
    let errors = exact.iter().zip(numbers);
    errors.fold(0.0, |most, (exact, &number)| {
        most.max(exact.distance(number) / size)
    })
}

#[test]
fn rows_of_the_user_hold_with_those_of_loops() {
    let (mut tried, mut seed, mut worst) = (0, 0, [0.0f64; 5]);
    while tried < MODELS {
        seed += 1;
        let Some(mut bound) = Bound::new(seed, false) else {
            continue;
        };
        // Where other joints are better dependents than those named, the count
        // of what is left does not fit, and that is refused.
        if bound.outputs(FunctionKind::LoopPositions).is_none() {
            continue;
        }
        tried += 1;
        bound.close();
        let [positions, velocities] = bound.left();
        let found = bound
            .outputs(FunctionKind::Accelred)
            .unwrap_or_else(|| panic!("seed {seed}: no accelerations"));
        let mut accelerations = bound.case.state.qdd.clone();
        for (joint, number) in found.assigned("qdd") {
            accelerations[joint] = number;
        }
        let expected = full(&bound.case, &bound.forces, &bound.rows());
        let speed = bound
            .case
            .state
            .qd
            .iter()
            .fold(1.0f64, |most, qd| most.max(qd.abs()));
        let wanted: Vec<f64> = (0..accelerations.len())
            .map(|joint| match bound.case.model.joints[joint].nature {
                Nature::Driven => bound.case.state.qdd[joint],
                _ => 0.7 * (joint as f64).cos(),
            })
            .collect();
        let errors = [
            positions,
            velocities / speed,
            distance(&expected, &accelerations),
            bound.balance(&found),
            bound.actuated(&wanted),
        ];
        for (worst, error) in worst.iter_mut().zip(errors) {
            assert!(error < 1e-10, "seed {seed}: {errors:?}");
            *worst = worst.max(error);
        }
    }
    println!("worst of {MODELS} models of {seed} draws: {worst:?}");
}

/// Accelerations, multipliers and forces exist where masses and all rows
/// together are regular, and only there.
#[test]
fn rows_of_the_user_move_joints_without_mass() {
    let (mut tried, mut singular, mut seed, mut worst) = (0, 0, 0, [0.0f64; 3]);
    while tried < MASSLESS {
        seed += 1;
        let Some(bound) = Bound::new(seed, true) else {
            continue;
        };
        if bound.outputs(FunctionKind::LoopPositions).is_none() {
            continue;
        }
        let state = bound.case.exact().1;
        let (expected, weakest) = full_at(&bound.case, &state, &bound.forces, &bound.rows());
        let found = bound.outputs(FunctionKind::Accelred);
        let found = found.unwrap_or_else(|| panic!("seed {seed}: no accelerations"));
        let growth: Vec<f64> = found
            .assigned("Growth")
            .map(|(_, growth)| growth.abs())
            .collect();
        // Loops may give what has no mass that of other bodies.
        if growth.len() == bound.jacobian.len() {
            continue;
        }
        tried += 1;
        let is_regular = growth.iter().all(|&growth| growth <= 1e12);
        assert_eq!(
            is_regular,
            weakest > 1e-12,
            "seed {seed}: {weakest:e}, {growth:?}"
        );
        if !is_regular {
            singular += 1;
            continue;
        }
        let mut accelerations = bound.case.state.qdd.clone();
        for (joint, number) in found.assigned("qdd") {
            accelerations[joint] = number;
        }
        let mut bound = bound;
        let wanted: Vec<f64> = expected.iter().map(|number| 0.1 * number.high).collect();
        let errors = [
            distance(&expected, &accelerations),
            bound.balance(&found),
            bound.actuated(&wanted),
        ];
        for (worst, error) in worst.iter_mut().zip(errors) {
            assert!(error < 1e-10, "seed {seed}: {errors:?}");
            *worst = worst.max(error);
        }
    }
    println!("worst of {MASSLESS} models, {singular} of them singular: {worst:?}");
}
