//! Constraints of loops, in the frame from which both chains of a cut start.

use super::kinematics::{Point, anchor, base, frames, point};
use super::spatial::*;
use super::{Real, State, Tree};
use robovec::model::{Cut, CutKind, JointCoupling, Model};

/// The rows of one cut.
pub(crate) struct Constraint<T> {
    /// `h`.
    pub(crate) residual: Vec<T>,
    /// `Jac`, one column per joint. The rotation rows of a solid cut are the
    /// relative angular velocity.
    pub(crate) jacobian: Vec<Vec<T>>,
    /// `Jdqd`: the second derivative without accelerations.
    pub(crate) quadratic: Vec<T>,
}

/// The rows of all cuts, in order.
pub(crate) fn constraints<T: Real>(model: &Model, state: &State<T>) -> Constraint<T> {
    let mut all = Constraint {
        residual: Vec::new(),
        jacobian: Vec::new(),
        quadratic: Vec::new(),
    };
    for cut in &model.cuts {
        let rows = constraint(model, state, cut);
        all.residual.extend(rows.residual);
        all.jacobian.extend(rows.jacobian);
        all.quadratic.extend(rows.quadratic);
    }
    all
}

/// The last joint that both anchors hang on; `None` for the base.
fn common<T: Real>(tree: &Tree<T>, a: Option<usize>, b: Option<usize>) -> Option<usize> {
    let other: Vec<usize> = tree.path(b).collect();
    tree.path(a).find(|joint| other.contains(joint))
}

/// The difference `A - B` of two points seen from a frame at rest.
struct Difference<T> {
    position: Vector3<T>,
    velocity: Vector3<T>,
    acceleration: Vector3<T>,
    angular_acceleration: Vector3<T>,
    jacobian: Vec<Vec<T>>,
    turn: Matrix3<T>,
}

fn difference<T: Real>(reference: &Matrix3<T>, a: &Point<T>, b: &Point<T>) -> Difference<T> {
    let seen = |x: Vector3<T>, y: Vector3<T>| apply(reference, sub(x, y));
    let n = a.jacobian[0].len();
    let mut jacobian = vec![vec![T::zero(); n]; 6];
    for k in 0..n {
        let column = |p: &Point<T>| p.jacobian.each_ref().map(|row| row[k]);
        let column = sub(column(a), column(b));
        // A point's rows are linear first: the halves keep their places.
        let halves = join(
            apply(reference, angular(column)),
            apply(reference, linear(column)),
        );
        for (row, &entry) in jacobian.iter_mut().zip(&halves) {
            row[k] = entry;
        }
    }
    let axes = |p: &Point<T>| product(reference, &transpose(&p.rotation));
    Difference {
        position: seen(a.position, b.position),
        velocity: seen(a.velocity, b.velocity),
        acceleration: seen(a.acceleration, b.acceleration),
        angular_acceleration: seen(a.angular_acceleration, b.angular_acceleration),
        jacobian,
        turn: product(&axes(a), &transpose(&axes(b))),
    }
}

/// `q_joint - factor q_leader - offset`.
fn coupling<T: Real>(state: &State<T>, coupling: &JointCoupling) -> Constraint<T> {
    let factor = T::from(coupling.factor);
    let mut row = vec![T::zero(); state.q.len()];
    row[coupling.joint] = T::from(1.0);
    row[coupling.leader] = -factor;
    let [follower, leader] = [coupling.joint, coupling.leader].map(|joint| state.q[joint]);
    Constraint {
        residual: vec![follower - factor * leader - T::from(coupling.offset)],
        jacobian: vec![row],
        quadratic: vec![T::zero()],
    }
}

fn constraint<T: Real>(model: &Model, state: &State<T>, cut: &Cut) -> Constraint<T> {
    if let CutKind::Coupling(ratio) = &cut.kind {
        return coupling(state, ratio);
    }
    let tree = Tree::new(model);
    let ends = cut.ends.each_ref().map(|end| anchor::<T>(model, end));
    let shared = common(&tree, ends[0].0, ends[1].0);
    // Seen from the common frame, what is before it stands still.
    let mut relative = state.clone();
    relative.qdd.fill(T::zero());
    for joint in tree.path(shared) {
        relative.qd[joint] = T::zero();
    }
    let frames = frames(&tree, &relative, zeros());
    let reference = shared.map_or(base(zeros()), |joint| frames[joint]).rotation;
    let [a, b] = ends.map(|(joint, place)| point(&tree, &frames, joint, place));
    let mut d = difference(&reference, &a, &b);
    for joint in tree.path(shared) {
        d.jacobian.iter_mut().for_each(|row| row[joint] = T::zero());
    }
    match cut.kind {
        CutKind::Ball => {
            let kept: Vec<usize> = (0..3).filter(|&i| !cut.ignore[i]).collect();
            Constraint {
                residual: kept.iter().map(|&i| d.position[i]).collect(),
                jacobian: kept.iter().map(|&i| d.jacobian[i].clone()).collect(),
                quadratic: kept.iter().map(|&i| d.acceleration[i]).collect(),
            }
        }
        CutKind::Coupling(_) => unreachable!("couplings have no chains"),
        CutKind::Rod(length) => rod(&d, T::from(length)),
        CutKind::Solid => {
            let mut residual = d.position.to_vec();
            residual.extend([d.turn[2][1], d.turn[0][2], d.turn[1][0]]);
            let mut quadratic = d.acceleration.to_vec();
            quadratic.extend(d.angular_acceleration);
            Constraint {
                residual,
                jacobian: d.jacobian,
                quadratic,
            }
        }
    }
}

fn rod<T: Real>(d: &Difference<T>, length: T) -> Constraint<T> {
    let row = |k: usize| [0, 1, 2].map(|i| d.jacobian[i][k]);
    let n = d.jacobian[0].len();
    let square = dot(d.position, d.position) - length * length;
    Constraint {
        residual: vec![square / T::from(2.0)],
        jacobian: vec![(0..n).map(|k| dot(d.position, row(k))).collect()],
        quadratic: vec![dot(d.position, d.acceleration) + dot(d.velocity, d.velocity)],
    }
}
