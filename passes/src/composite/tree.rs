//! The search for the tree of bodies of a mass matrix.
//!
//! The function can be evaluated at any state, so the tree need not be guessed:
//! for each property there are states that isolate it.
//!
//! 1. *Ancestors*: with the mass of one body only, the rows that are not
//!    zero show which joints move it.
//! 2. *Kinds*: a prismatic joint feels the mass of every body beyond it and
//!    nothing else; [`super::axes`] finds the axes with all frames aligned.
//! 3. *Points*: [`super::points`] finds where joints are, one attachment
//!    point at a time.
//! 4. *Products of inertia* that are given on one side of the diagonal: one
//!    body at a time, mirrored or not.
//!
//! The work is a number of evaluations linear in those of joints and points.
//! Axes that the aligned states leave open are tried one after the other when
//! the matrix so placed is not the one in the usual state; mostly every choice
//! gives the same matrix.

use super::axes;
use super::bodies::{CompositeInertia, JointAxis};
use super::matrix::{BodySystem, JointPlacement, mass_matrix};
use super::model::{AncestorTree, ModelInputs, SystemInput};
use super::points;
use super::probe::{MatrixProbe, ProbedMatrix, UsualState, near};
use robovec_ir::Function;

/// The number at a state with the mass of one body only.
fn alone(body: usize) -> impl Fn(SystemInput) -> f64 {
    move |input| match input.body() {
        Some(other) if other != body => 0.0,
        _ => input.usual(),
    }
}

/// Operations that may be spent on axes that no single state shows.
const WORK: usize = 2_000_000_000;

/// Operations that the matrices of accelerations may take, about two minutes:
/// those of a chain of some 100 joints.
const SOLVED_WORK: u64 = 40_000_000_000;

/// The placement of every joint, as far as the matrix shows.
///
/// # Errors
///
/// The reason why accelerations are not searched.
pub(super) fn find(
    function: &Function,
    model: &ModelInputs,
) -> Result<Vec<JointPlacement>, &'static str> {
    let mut probe = MatrixProbe::new(function, model);
    // A matrix for each body, twice, each joint that slides and each point.
    let matrices = (4 * model.len() + model.points.len()) as u64;
    if model.solved.is_some() && matrices.saturating_mul(probe.work() as u64) > SOLVED_WORK {
        return Err("the accelerations are too many operations for a search for their bodies");
    }
    if probe.is_bound() {
        return Err("accelerations follow from others, so they are not those of a tree of bodies");
    }
    let tree = ancestors(&mut probe, model);
    let mut axes = axes::find(&mut probe, model, &tree);
    let usual = probe.matrix(SystemInput::usual);
    let mut places = place(&mut probe, model, &tree, &axes.chosen);
    let mut wrong = differences(model, &places, &usual);
    let mut work = 0;
    for (joint, axis) in axes.open {
        work += probe.work() * (model.points.len() + 1);
        if wrong == 0 || work > WORK {
            break;
        }
        let before = std::mem::replace(&mut axes.chosen[joint], axis);
        let other = place(&mut probe, model, &tree, &axes.chosen);
        let left = differences(model, &other, &usual);
        if left < wrong {
            (places, wrong) = (other, left);
        } else {
            axes.chosen[joint] = before;
        }
    }
    Ok(places)
}

/// The placement of every joint, for given axes.
fn place(
    probe: &mut MatrixProbe<'_>,
    model: &ModelInputs,
    tree: &AncestorTree,
    axes: &[JointAxis],
) -> Vec<JointPlacement> {
    let points = points::find(probe, model, tree, axes);
    let placement = |(joint, points)| JointPlacement {
        parent: tree.parents[joint],
        joint: axes[joint],
        points,
        symmetric: false,
    };
    let mut places: Vec<JointPlacement> = points.into_iter().enumerate().map(placement).collect();
    for body in 0..model.len() {
        places[body].symmetric = is_symmetric(probe, model, tree, &places, body);
    }
    places
}

/// The joints that move each body, and the tree that follows: Robotran numbers
/// a joint beyond those that it is on.
fn ancestors(probe: &mut MatrixProbe<'_>, model: &ModelInputs) -> AncestorTree {
    let count = model.len();
    let mut tree = AncestorTree {
        parents: vec![None; count],
        behind: vec![Vec::new(); count],
        slides: vec![true; count],
    };
    for (body, inputs) in model.bodies.iter().enumerate() {
        if inputs.is_absent() {
            continue;
        }
        let matrix = probe.matrix(alone(body));
        let mass = match inputs.mass {
            Some(_) => SystemInput::Mass(body).usual(),
            None => 0.0,
        };
        let mut before = None;
        // Its own joint leads to a body even if it only turns a point mass.
        let moving = |&joint: &usize| joint == body || !matrix.is_row_zero(joint);
        for joint in (0..=body).filter(moving) {
            tree.slides[joint] &= near(matrix.at(joint, joint), mass, mass);
            tree.parents[joint] = tree.parents[joint].max(before);
            before = Some(joint);
        }
    }
    for body in 0..count {
        let chain: Vec<usize> = tree.chain(body).collect();
        for joint in chain {
            tree.behind[joint].push(body);
        }
    }
    tree
}

/// The number of elements of the matrix in the usual state that are not those
/// of the joints so placed.
fn differences(model: &ModelInputs, places: &[JointPlacement], usual: &ProbedMatrix) -> usize {
    let (made, _) = mass_matrix(&mut UsualState { model }, places);
    let count = model.len();
    let differs = |&place: &usize| {
        let given = usual.at(place / count, place % count);
        !near(made[place], given, usual.largest())
    };
    (0..made.len()).filter(differs).count()
}

/// Tests whether the products of inertia of a body are those of a symmetric
/// matrix of which one half is left out: the choice that is nearer to the
/// matrix with this body's mass alone.
fn is_symmetric(
    probe: &mut MatrixProbe<'_>,
    model: &ModelInputs,
    tree: &AncestorTree,
    places: &[JointPlacement],
    body: usize,
) -> bool {
    let given = &model.bodies[body];
    if given.mirrored(true) == *given {
        return false;
    }
    let matrix = probe.matrix(alone(body));
    let distance = |symmetric: bool| distance(model, tree, places, &matrix, body, symmetric);
    distance(true) <= distance(false)
}

/// The largest difference of a diagonal element from the value of a body.
fn distance(
    model: &ModelInputs,
    tree: &AncestorTree,
    places: &[JointPlacement],
    matrix: &ProbedMatrix,
    body: usize,
    symmetric: bool,
) -> f64 {
    let state = &mut UsualState { model };
    let own = JointPlacement {
        symmetric,
        ..places[body].clone()
    };
    let own = state.body(body, &own);
    let mut inertia = CompositeInertia::of(state, &own);
    let mut largest = 0.0f64;
    for joint in tree.chain(body) {
        let axis = places[joint].joint;
        let found = inertia.wrench(axis).along(axis);
        largest = largest.max((found - matrix.at(joint, joint)).abs());
        let stand = state.stand(joint, &places[joint]);
        inertia = stand.inertia(state, &inertia);
    }
    largest
}
