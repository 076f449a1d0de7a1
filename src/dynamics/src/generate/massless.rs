//! Joints whose accelerations masses and loops do not determine.
//!
//! The reduced mass matrix `Mr` is singular where a joint moves no mass, or
//! where joints have the same effect. Accelerations exist all the same if `Mr`
//! and the Jacobian `A` of the user's rows are regular together, that is if
//! `x^T Mr x > 0` for `A x = 0`. With `E` the unit vectors of the joints found
//! here and any `s > 0`, `Mr + E s E^T` is positive definite, and
//!
//! ```text
//! Mr x = f + A^T mu,  A x = -g
//! (Mr + E s E^T) x = f + A^T mu + E z,  A x = -g,  E^T x = z / s
//! ```
//!
//! have the same solution `x`. So the joints are further rows beside those of
//! the user, with `-1/s` on the diagonal of the matrix of multipliers. That
//! matrix is quasi-definite: in the order of its rows, the user's first, it
//! needs no pivots. `s` affects rounding alone, and is near the other masses.

use super::roles::{JointRoles, compiled, constraints};
use super::{Formulation, GenerateError, GenerationRequest, Options};
use crate::kinematics::linear::{DenseMatrix, largest, solve_square};
use crate::kinematics::{LoopClosure, MotionState, closed_states, stack};
use robovec_model::Model;
use robovec_robotran::FunctionKind;

/// Random states that masses are evaluated in, beside the initial one.
const STATES: usize = 3;
const SEED: u64 = 1;

/// Pivots, in parts of their entry, that count as zero and as weak. A joint
/// with a weak one may do without its mass where there are rows enough.
const ZERO: f64 = 1e-12;
const WEAK: f64 = 1e-6;

/// A mass in parts of a usual one that is rounding of loops.
const ROUNDING: f64 = 1e-20;

/// A joint that gets its acceleration from rows of the user.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct MasslessJoint {
    /// Place among the free joints.
    pub(super) place: usize,
    /// `s`: a mass (kg) or an inertia (kg m^2) that other joints have.
    pub(super) inertia: f64,
}

/// Joints, from 0, whose accelerations only user rows determine, ascending.
///
/// # Errors
///
/// [`GenerateError::Singular`] with more of them than rows, or open loops.
pub fn massless(model: &Model, options: &Options) -> Result<Vec<usize>, GenerateError> {
    let roles = JointRoles::of_loops(model)?;
    let found = massless_joints(model, &roles, options)?;
    let joints = found.iter().map(|joint| roles.free[joint.place]);
    Ok(joints.collect())
}

/// The joints that need rows of the user, ascending, if there are enough rows.
pub(super) fn massless_joints(
    model: &Model,
    roles: &JointRoles,
    options: &Options,
) -> Result<Vec<MasslessJoint>, GenerateError> {
    let masses = masses(model, roles)?;
    let inertias = inertias(model, roles, &masses);
    let rows = options.user_constraints;
    let lacking = |matrix: &DenseMatrix, limit| without_mass(matrix.clone(), &inertias, limit);
    let least = masses.iter().map(|matrix| lacking(matrix, ZERO));
    if let Some(least) = least.min_by_key(Vec::len)
        && least.len() > rows
    {
        let joints = least.iter().map(|&place| roles.free[place]);
        return Err(GenerateError::singular(model, joints));
    }
    // A state may need more than another: a gimbal that starts stretched.
    let found = [WEAK, ZERO].map(|limit| {
        let mut places = Vec::new();
        for matrix in &masses {
            let mut matrix = matrix.clone();
            for &place in &places {
                matrix[(place, place)] += inertias[place];
            }
            places.extend(lacking(&matrix, limit));
        }
        places
    });
    let enough = found.into_iter().find(|places| places.len() <= rows);
    let last = || masses.last().map(|matrix| lacking(matrix, ZERO));
    let mut places = enough.or_else(last).unwrap_or_default();
    places.sort_unstable();
    let joint = |place: usize| MasslessJoint {
        place,
        inertia: inertias[place],
    };
    Ok(places.into_iter().map(joint).collect())
}

/// The reduced mass matrix in the initial state and in random ones; none where
/// the loops do not close or the equations are those of another model.
fn masses(model: &Model, roles: &JointRoles) -> Result<Vec<DenseMatrix>, GenerateError> {
    let constraints = constraints(model)?;
    let loops = LoopClosure {
        model,
        constraints: &constraints,
    };
    let mut states = vec![MotionState::initial(model)];
    if loops.start(&mut states[0]).is_err() {
        return Ok(Vec::new());
    }
    states.extend(closed_states(&loops, STATES, SEED));
    let request = GenerationRequest {
        function: FunctionKind::Dirdyna,
        formulation: Formulation::Composite,
        options: Options {
            external_forces: false,
            ..Options::default()
        },
    };
    let compiled = compiled(model, &request)?;
    let joints = model.joints.len();
    let reduced = |state: &MotionState| {
        let matrix = compiled.evaluate(state).matrix("M", joints, joints);
        let jacobian = constraints.evaluate(state).1;
        let (u, v) = (&roles.free, &roles.dependent);
        let mut right = jacobian.select(&roles.rows, u);
        right.scale(-1.0);
        let slopes = solve_square(jacobian.select(&roles.rows, v), right)?;
        let transform = stack(u, v, &slopes, joints);
        Some(transform.transposed().product(&matrix.product(&transform)))
    };
    Ok(states.iter().filter_map(reduced).collect())
}

/// A usual mass or inertia for each joint: the geometric mean of its kind's.
fn inertias(model: &Model, roles: &JointRoles, masses: &[DenseMatrix]) -> Vec<f64> {
    let revolute = |place: usize| model.joints[roles.free[place]].kind.is_revolute();
    let places = 0..roles.free.len();
    let mean = |is_revolute: bool| {
        let of_kind = places
            .clone()
            .filter(|&place| revolute(place) == is_revolute);
        let entries = of_kind.flat_map(|place| masses.iter().map(move |m| m[(place, place)]));
        let entries: Vec<f64> = entries.collect();
        let least = ROUNDING * largest(&entries);
        let of_masses = entries.into_iter().filter(|&entry| entry > least);
        let logarithms: Vec<f64> = of_masses.map(f64::log2).collect();
        let sum: f64 = logarithms.iter().sum();
        // A power of two: products with it are exact.
        (sum / logarithms.len().max(1) as f64).round().exp2()
    };
    let means = [false, true].map(mean);
    places
        .clone()
        .map(|place| means[usize::from(revolute(place))])
        .collect()
}

/// The joints left of an elimination by the largest pivots above a limit.
fn without_mass(mut matrix: DenseMatrix, inertias: &[f64], limit: f64) -> Vec<usize> {
    let count = matrix.rows();
    assert_eq!(inertias.len(), count, "every joint has an inertia");
    let entries: Vec<f64> = (0..count).map(|i| matrix[(i, i)]).collect();
    let mut left: Vec<usize> = (0..count).collect();
    loop {
        let is_mass =
            |i: usize| entries[i] > ROUNDING * inertias[i] && matrix[(i, i)] > limit * entries[i];
        let size = |place: usize| matrix[(left[place], left[place])] / inertias[left[place]];
        let places = (0..left.len()).filter(|&place| is_mass(left[place]));
        let Some(best) = places.max_by(|&a, &b| size(a).total_cmp(&size(b))) else {
            return left;
        };
        let i = left.remove(best);
        for &j in &left {
            let factor = matrix[(j, i)] / matrix[(i, i)];
            for &k in &left {
                let known = factor * matrix[(i, k)];
                matrix[(j, k)] -= known;
            }
        }
    }
}
