//! Mass matrix, bias forces, accelerations, energies and momenta.

use super::kinematics::{Frame, body_jacobian, frames};
use super::spatial::*;
use super::{Real, State, Tree};

/// `M`, all entries, row by row: the sum of `Jᵀ I J` over the bodies.
pub(crate) fn mass_matrix<T: Real>(tree: &Tree<T>, state: &State<T>) -> Vec<Vec<T>> {
    let frames = frames(tree, state, zeros());
    let n = tree.links.len();
    let mut matrix = vec![vec![T::zero(); n]; n];
    for i in 0..n {
        let inertia = inertia(tree, i);
        let columns = body_jacobian(tree, &frames, Some(i));
        for &(j, left) in &columns {
            for &(k, right) in &columns {
                matrix[j][k] = matrix[j][k] + dot(left, apply(&inertia, right));
            }
        }
        matrix[i][i] = matrix[i][i] + tree.links[i].armature;
    }
    matrix
}

/// `c`: the joint forces that hold accelerations at zero.
pub(crate) fn bias<T: Real>(tree: &Tree<T>, state: &State<T>) -> Vec<T> {
    let mut still = state.clone();
    still.qdd.fill(T::zero());
    inverse_dynamics(tree, &still)
}

/// The joint forces that cause the accelerations of a state.
pub(crate) fn inverse_dynamics<T: Real>(tree: &Tree<T>, state: &State<T>) -> Vec<T> {
    // Gravity is what a base that accelerates upwards feels like.
    let frames = frames(tree, state, tree.gravity.map(|x| -x));
    let mut forces = vec![T::zero(); tree.links.len()];
    for i in 0..tree.links.len() {
        let needed = sub(newton_euler(tree, &frames[i], i), external(tree, state, i));
        for (k, column) in body_jacobian(tree, &frames, Some(i)) {
            forces[k] = forces[k] + dot(column, needed);
        }
        forces[i] = forces[i] + tree.links[i].armature * state.qdd[i];
    }
    forces
}

/// The accelerations that joint forces cause; `None` when the mass matrix is
/// not positive definite.
pub(crate) fn forward_dynamics<T: Real>(
    tree: &Tree<T>,
    state: &State<T>,
    forces: &[T],
) -> Option<Vec<T>> {
    let bias = bias(tree, state);
    let right = forces.iter().zip(&bias).map(|(&f, &c)| f - c).collect();
    solve(mass_matrix(tree, state), right)
}

fn inertia<T: Real>(tree: &Tree<T>, i: usize) -> Matrix6<T> {
    let link = &tree.links[i];
    spatial_inertia(link.mass, link.center, &link.inertia)
}

/// The rate of change of a body's momentum.
fn newton_euler<T: Real>(tree: &Tree<T>, frame: &Frame<T>, i: usize) -> Vector6<T> {
    let inertia = inertia(tree, i);
    let momentum = apply(&inertia, frame.velocity);
    add(
        apply(&inertia, frame.acceleration),
        cross_force(frame.velocity, momentum),
    )
}

/// The external force on a body about the origin of its frame.
fn external<T: Real>(tree: &Tree<T>, state: &State<T>, i: usize) -> Vector6<T> {
    let moment = cross(tree.links[i].center, state.frc[i]);
    join(add(state.trq[i], moment), state.frc[i])
}

/// Kinetic energy.
pub(crate) fn kinetic_energy<T: Real>(tree: &Tree<T>, state: &State<T>) -> T {
    let frames = frames(tree, state, zeros());
    let twice = frames
        .iter()
        .enumerate()
        .fold(T::zero(), |sum, (i, frame)| {
            sum + dot(frame.velocity, apply(&inertia(tree, i), frame.velocity))
                + tree.links[i].armature * state.qd[i] * state.qd[i]
        });
    twice / T::from(2.0)
}

/// Potential energy in gravity, zero where all centres of mass are at the
/// origin.
pub(crate) fn potential_energy<T: Real>(tree: &Tree<T>, state: &State<T>) -> T {
    let frames = frames(tree, state, zeros());
    let links = tree.links.iter().zip(&frames);
    links.fold(T::zero(), |sum, (link, frame)| {
        let outward = transpose(&frame.rotation);
        let center = add(frame.origin, apply(&outward, link.center));
        sum - link.mass * dot(tree.gravity, center)
    })
}

/// Momentum of the whole system about the base's origin, in the base frame:
/// angular, then linear.
pub(crate) fn momentum<T: Real>(tree: &Tree<T>, state: &State<T>) -> Vector6<T> {
    let frames = frames(tree, state, zeros());
    frames.iter().enumerate().fold(zeros(), |sum, (i, frame)| {
        // Momenta transform as forces do: by the transposed transform.
        let transform = plucker(&frame.rotation, frame.origin);
        let own = apply(&inertia(tree, i), frame.velocity);
        add(sum, apply(&transpose(&transform), own))
    })
}

/// Solves a symmetric positive definite system by Cholesky's method; `None`
/// when a pivot is not positive.
pub(crate) fn solve<T: Real>(mut matrix: Vec<Vec<T>>, mut right: Vec<T>) -> Option<Vec<T>> {
    let n = right.len();
    cholesky(&mut matrix)?;
    for i in 0..n {
        let known = (0..i).fold(right[i], |sum, k| sum - matrix[i][k] * right[k]);
        right[i] = known / matrix[i][i];
    }
    for i in (0..n).rev() {
        let known = (i + 1..n).fold(right[i], |sum, k| sum - matrix[k][i] * right[k]);
        right[i] = known / matrix[i][i];
    }
    Some(right)
}

/// Replaces the lower triangle by its Cholesky factor; `None` when the matrix
/// is not positive definite.
pub(crate) fn cholesky<T: Real>(matrix: &mut [Vec<T>]) -> Option<()> {
    for i in 0..matrix.len() {
        for j in 0..=i {
            let rest = (0..j).fold(matrix[i][j], |sum, k| sum - matrix[i][k] * matrix[j][k]);
            if i == j {
                if rest.value() <= 0.0 || rest.value().is_nan() {
                    return None;
                }
                matrix[i][i] = rest.root();
            } else {
                matrix[i][j] = rest / matrix[j][j];
            }
        }
    }
    Some(())
}
