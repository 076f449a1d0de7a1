//! Terms of a single body in the axes of a reference: its moments of inertia
//! and the torque that its own rotation takes.

use super::algebra::Sum;
use super::bias::BiasMotion;
use super::equations::{Equations, QuantityLabel};
use super::hub::Pose;
use super::vector::{Matrix, SumVector, ZERO, cyclic, sums};

/// Moments of inertia in the axes of the reference. Since the axes are
/// orthogonal, `R^T I R = I_11 E + R^T (I - I_11 E) R`, with an entry less.
pub(super) fn turned_moments(
    equations: &mut Equations,
    joint: usize,
    moments: &Matrix,
    pose: &Pose,
) -> Matrix {
    if pose.axes == Pose::HERE.axes {
        return *moments;
    }
    let first = moments[0][0];
    let mut rest = *moments;
    for axis in 0..3 {
        let sum = Sum::total(&[moments[axis][axis], -first]);
        rest[axis][axis] = equations.define(QuantityLabel::new("ID", axis + 1, joint + 1), sum);
    }
    let mut half = [ZERO; 3];
    for (row, entries) in rest.iter().enumerate() {
        half[row] = {
            let sum = pose.lever(entries);
            let mut component = 0;
            sum.map(|sum| {
                component += 1;
                let label = QuantityLabel::new("IR", 3 * row + component, joint + 1);
                equations.define(label, sum)
            })
        };
    }
    let mut turned = [ZERO; 3];
    for row in 0..3 {
        for column in row..3 {
            let mut sum = Sum::new();
            if row == column {
                sum.add(&[first]);
            }
            for (axis, half) in pose.axes.iter().zip(&half) {
                sum.add(&[axis[row], half[column]]);
            }
            let label = QuantityLabel::new("JB", 3 * row + column + 1, joint + 1);
            turned[row][column] = equations.define(label, sum);
            turned[column][row] = turned[row][column];
        }
    }
    turned
}

/// The torque that a body's own rotation takes, about its centre of mass.
pub(super) fn euler(
    equations: &mut Equations,
    joint: usize,
    moments: &Matrix,
    motion: &BiasMotion,
) -> SumVector {
    let mut torque = sums();
    for a in 0..3 {
        let (b, c) = cyclic(a);
        let (low, high) = (b.min(c), b.max(c));
        let product = Sum::product(&[motion.velocity[b], motion.velocity[c]]);
        let label = QuantityLabel::new("BS", 3 * low + high + 1, joint + 1);
        let product = equations.define(label, product);
        let squares = Sum::total(&[motion.squares[b], -motion.squares[c]]);
        let squares = equations.define(QuantityLabel::new("BD", a + 1, joint + 1), squares);
        let difference = Sum::total(&[moments[c][c], -moments[b][b]]);
        let difference = equations.define(QuantityLabel::new("JE", a + 1, joint + 1), difference);
        torque[a]
            .add(&[moments[a][a], motion.angular[a]])
            .add(&[difference, product])
            .add(&[moments[b][c], squares])
            .subtract(&[moments[a][b], motion.tilde[c][a]])
            .add(&[moments[a][c], motion.tilde[b][a]]);
    }
    torque
}
