//! Models with closed loops, drawn at random: the closing functions, and
//! accelerations against the full equations with multipliers.

use super::loops::held;
use super::{Case, Outputs};
use crate::reference::dynamics::{bias, mass_matrix};
use crate::reference::kinematics::{anchor, base, frames, point};
use crate::reference::loops::{Constraint, constraints};
use crate::reference::random::{self, ModelDraw, Recipe};
use crate::reference::spatial::{apply, dot, sub, zeros};
use crate::reference::{State, Tree};
use robovec::generate::{Formulation, GenerationRequest, generate};
use robovec::model::{Anchor, Cut, CutKind, Model, ModelPoint, Nature};
use robovec::robotran::FunctionKind;
use robovec_ir::Module;
use robovec_num::double_double::Double;
use robovec_num::random::Random;

/// Number of models tried.
const MODELS: u64 = 200;

/// A model whose cuts are closed at its initial state, with that state; `None`
/// where the draw leaves no joint free.
pub(super) fn closed(seed: u64) -> Option<Case> {
    let mut random = Random::new(seed);
    let recipe = Recipe {
        bodies: 4 + random.below(9),
        zeros: 0.4 * (seed % 2) as f64,
        massless: false,
        driven: true,
        placed: seed.is_multiple_of(3),
        cuts: 0,
        devices: 0,
    };
    let mut model = random::model(&mut random, &recipe);
    let mut state = random::state(&mut random, &model);
    for (joint, q) in model.joints.iter_mut().zip(&state.q) {
        joint.initial[0] = *q;
    }
    for _ in 0..1 + random.below(3) {
        add_cut(&mut random, &mut model, &state);
    }
    if recipe.placed {
        random::add_coupling(&mut random, &mut model, &state.q);
    }
    let rows: usize = model.cuts.iter().map(Cut::rows).sum();
    let free = model.joints.iter();
    let free = free.filter(|joint| joint.nature != Nature::Driven).count();
    // Velocities follow from the independent ones.
    state.qdd.fill(0.0);
    (rows > 0 && free > rows).then_some(Case { seed, model, state })
}

/// Adds a point after those of its body; returns its place.
fn insert(model: &mut Model, point: ModelPoint) -> usize {
    let place = model
        .points
        .partition_point(|other| other.body <= point.body);
    model.points.insert(place, point);
    let moved = |point: &mut Option<usize>| *point = point.map(|at| at + usize::from(at >= place));
    model
        .bodies
        .iter_mut()
        .for_each(|body| moved(&mut body.point));
    model
        .joints
        .iter_mut()
        .for_each(|joint| moved(&mut joint.point));
    let cuts = model.cuts.iter_mut();
    cuts.flat_map(|cut| &mut cut.ends)
        .for_each(|end| moved(&mut end.point));
    place
}

/// Adds cuts between two bodies in the given state: a ball, or a rod of the
/// present length.
fn add_cut(random: &mut Random, model: &mut Model, state: &State<f64>) {
    let bodies = model.bodies.len();
    let (one, other) = (random.below(bodies), random.below(bodies));
    if one == other {
        return;
    }
    let tree: Tree<f64> = Tree::new(model);
    let frames = frames(&tree, state, zeros());
    let mut ends = [one, other].map(|body| Anchor {
        body: Some(body),
        point: model.points.iter().position(|p| p.body == Some(body)),
    });
    let place = |end: &Anchor| {
        let (joint, place) = anchor::<f64>(model, end);
        point(&tree, &frames, joint, place).position
    };
    let [first, second] = [place(&ends[0]), place(&ends[1])];
    let number = model.cuts.len() + 1;
    let (kind, end) = if random.chance(0.6) {
        // The second body gets a point where the first one has its own.
        let joint = model.last_joint(Some(other));
        let frame = joint.map_or(base(zeros()), |joint| frames[joint]);
        let added = ModelPoint {
            name: format!("cut{number}"),
            body: Some(other),
            coordinates: apply(&frame.rotation, sub(first, frame.origin)),
        };
        let point = insert(model, added);
        ends[0] = Anchor {
            body: Some(one),
            point: model.points.iter().position(|p| p.body == Some(one)),
        };
        (
            CutKind::Ball,
            Anchor {
                body: Some(other),
                point: Some(point),
            },
        )
    } else {
        let span = sub(first, second);
        (CutKind::Rod(dot(span, span).sqrt()), ends[1])
    };
    model.cuts.push(Cut {
        name: format!("cut{number}"),
        kind,
        ends: [ends[0], end],
        ignore: [false; 3],
        rotation: None,
    });
}

/// A function of a case at its state.
pub(super) fn outputs(case: &Case, kind: FunctionKind, forces: &[f64]) -> Option<Outputs> {
    Some(outputs_of(
        &equations(&case.model, kind)?,
        case,
        kind,
        forces,
    ))
}

/// A function of a model; `None` where it has none.
pub(super) fn equations(model: &Model, kind: FunctionKind) -> Option<Module> {
    let request = GenerationRequest {
        formulation: Formulation::Composite,
        ..GenerationRequest::new(kind)
    };
    generate(model, &request).ok()
}

/// The outputs of a function that was generated.
pub(super) fn outputs_of(
    module: &Module,
    case: &Case,
    kind: FunctionKind,
    forces: &[f64],
) -> Outputs {
    let mut inputs = case.inputs();
    inputs.joint_forces.copy_from_slice(forces);
    Outputs::of(case, module, kind.name(), &inputs)
}

/// The rows of the reference that the equations number, by their places.
pub(super) fn numbered_rows(case: &Case) -> Vec<usize> {
    let all = constraints(&case.model, &case.exact().1);
    let forces = vec![0.0; case.model.joints.len()];
    let outputs = outputs(case, FunctionKind::ConsHJ, &forces).expect("every model has them");
    let held = held(case, &all.residual, &outputs);
    (0..held.len()).filter(|&row| held[row]).collect()
}

/// Some rows of the reference at a state.
pub(super) fn rows(case: &Case, state: &State<Double>, kept: &[usize]) -> Constraint<Double> {
    let all = constraints(&case.model, state);
    Constraint {
        residual: kept.iter().map(|&row| all.residual[row]).collect(),
        jacobian: kept.iter().map(|&row| all.jacobian[row].clone()).collect(),
        quadratic: kept.iter().map(|&row| all.quadratic[row]).collect(),
    }
}

/// Solves a square system in double-double, with the largest pivot of a
/// column.
pub(super) fn solve(matrix: Vec<Vec<Double>>, right: Vec<Double>) -> Vec<Double> {
    solve_with_pivots(matrix, right).0
}

/// The solution, and the smallest pivot in parts of the largest.
fn solve_with_pivots(mut matrix: Vec<Vec<Double>>, mut right: Vec<Double>) -> (Vec<Double>, f64) {
    let n = right.len();
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    for k in 0..n {
        let pivot = (k..n)
            .max_by(|&a, &b| {
                let size = |row: usize| matrix[row][k].high.abs();
                size(a).total_cmp(&size(b))
            })
            .expect("a row is left");
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        let size = matrix[k][k].high.abs();
        (least, most) = (least.min(size), most.max(size));
        for row in k + 1..n {
            let factor = matrix[row][k] / matrix[k][k];
            let (above, below) = matrix.split_at_mut(row);
            for (entry, &above) in below[0].iter_mut().zip(&above[k]).skip(k) {
                *entry = *entry - factor * above;
            }
            right[row] = right[row] - factor * right[k];
        }
    }
    for k in (0..n).rev() {
        let known = (k + 1..n).fold(right[k], |sum, j| sum - matrix[k][j] * right[j]);
        right[k] = known / matrix[k][k];
    }
    (right, least / most)
}

/// The independent rows of the loops at the state of a case.
pub(super) fn independent(case: &Case, rows: &[usize]) -> Constraint<Double> {
    let numbered = numbered_rows(case);
    let kept: Vec<usize> = rows.iter().map(|&row| numbered[row]).collect();
    self::rows(case, &case.exact().1, &kept)
}

/// The accelerations of the full equations: `M qdd + c = Qq + J^T lambda` for
/// free joints, `J qdd + Jdqd = 0` for independent rows.
pub(super) fn full(case: &Case, forces: &[f64], rows: &Constraint<Double>) -> Vec<Double> {
    full_at(case, &case.exact().1, forces, rows).0
}

/// As [`full`], at another state; and the smallest pivot of the equations in
/// parts of the largest.
pub(super) fn full_at(
    case: &Case,
    state: &State<Double>,
    forces: &[f64],
    rows: &Constraint<Double>,
) -> (Vec<Double>, f64) {
    let tree = Tree::new(&case.model);
    let (mass, bias) = (mass_matrix(&tree, state), bias(&tree, state));
    let n = case.model.joints.len();
    let size = n + rows.jacobian.len();
    let mut matrix = vec![vec![Double::from(0.0); size]; size];
    let mut right = vec![Double::from(0.0); size];
    for i in 0..n {
        if case.model.joints[i].nature == Nature::Driven {
            matrix[i][i] = Double::from(1.0);
            right[i] = state.qdd[i];
            continue;
        }
        matrix[i][..n].copy_from_slice(&mass[i]);
        for (k, row) in rows.jacobian.iter().enumerate() {
            matrix[i][n + k] = row[i];
        }
        right[i] = Double::from(forces[i]) - bias[i];
    }
    for (k, row) in rows.jacobian.iter().enumerate() {
        matrix[n + k][..n].copy_from_slice(row);
        right[n + k] = -rows.quadratic[k];
    }
    let (mut solution, weakest) = solve_with_pivots(matrix, right);
    solution.truncate(n);
    (solution, weakest)
}

/// Velocities that the loops allow, from the function itself, and its residual
/// of `J qd` in the independent rows.
pub(super) fn with_velocities(case: &mut Case, forces: &[f64], independent: &[usize]) -> f64 {
    let velocities =
        outputs(case, FunctionKind::LoopVelocities, forces).expect("the loops can be closed");
    for (joint, velocity) in velocities.assigned("qd") {
        case.state.qd[joint] = velocity;
    }
    let state = case.exact().1;
    let loops = rows(case, &state, &numbered_rows(case));
    let sums = independent.iter().map(|&row| {
        let entries = loops.jacobian[row].iter();
        let terms = entries.zip(&state.qd).map(|(&entry, &qd)| entry * qd);
        terms
            .fold(Double::from(0.0), |sum, term| sum + term)
            .high
            .abs()
    });
    let size = state
        .qd
        .iter()
        .fold(1.0f64, |size, qd| size.max(qd.high.abs()));
    sums.fold(0.0, f64::max) / size
}

/// Moves the dependent joints away and closes the loops again, round by
/// round; gives the last `h`.
fn closed_again(case: &Case, forces: &[f64], dependent: &[usize]) -> f64 {
    let mut moved = Case {
        seed: case.seed,
        model: case.model.clone(),
        state: case.state.convert(|number| number),
    };
    for (place, &joint) in dependent.iter().enumerate() {
        moved.state.q[joint] += 1e-4 * (place as f64 - 1.5);
    }
    let mut left = f64::INFINITY;
    for _ in 0..6 {
        let round = outputs(&moved, FunctionKind::LoopPositions, forces)
            .expect("the same function was generated before");
        left = round
            .assigned("h")
            .fold(0.0, |left, (_, h)| h.abs().max(left));
        for (joint, q) in round.assigned("q") {
            moved.state.q[joint] = q;
        }
    }
    left
}

#[test]
fn loops_close_and_accelerations_solve_the_full_equations() {
    let (mut tried, mut seed, mut worst) = (0, 0, 0.0f64);
    while tried < MODELS {
        seed += 1;
        let Some(mut case) = closed(seed) else {
            continue;
        };
        tried += 1;
        let joints = 0..case.model.joints.len();
        let forces: Vec<f64> = joints.map(|joint| (joint * 7 % 11) as f64 - 5.0).collect();
        let found = |case: &Case, kind: FunctionKind| {
            outputs(case, kind, &forces)
                .unwrap_or_else(|| panic!("seed {seed}: no {}", kind.name()))
        };
        let closed = found(&case, FunctionKind::LoopPositions);
        let rows: Vec<usize> = closed.assigned("h").map(|(row, _)| row).collect();
        let residual = closed
            .assigned("h")
            .fold(0.0, |most, (_, h)| h.abs().max(most));
        assert!(residual < 1e-12, "seed {seed}: {residual:e}");
        let dependent: Vec<usize> = closed.assigned("q").map(|(joint, _)| joint).collect();
        assert_eq!(rows.len(), dependent.len(), "seed {seed}");
        let residual = closed_again(&case, &forces, &dependent);
        assert!(residual < 1e-12, "seed {seed}: {residual:e} after closing");
        let left = with_velocities(&mut case, &forces, &rows);
        assert!(left < 1e-11, "seed {seed}: {left:e} of J qd");
        let accelerations = found(&case, FunctionKind::Accelred);
        let expected = full(&case, &forces, &independent(&case, &rows));
        let size = expected
            .iter()
            .fold(1.0f64, |size, x| size.max(x.high.abs()));
        for (joint, number) in accelerations.assigned("qdd") {
            let error = expected[joint].distance(number) / size;
            assert!(error < 1e-10, "seed {seed}, joint {}: {error:e}", joint + 1);
            worst = worst.max(error);
        }
    }
    println!("worst of {MODELS} models: {worst:e}");
}
