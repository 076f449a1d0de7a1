//! The regressor: forces of inverse dynamics, linear in inertias of bodies.
//!
//! `Qq = Y(q, qd, qdd) p` without external forces, where `p` holds ten numbers
//! for each joint: of the body it moves the mass, the first moment `m l` and
//! the moments of inertia about the origin of its frame, `I11 I12 I13 I22 I23
//! I33`. Joints of fictitious bodies have columns of zeros. With the
//! acceleration `AF` of the origin minus gravity and `BE = ~OA + ~OM ~OM` the
//! force on a body is `m AF + BE h` and the torque `h x AF + I OA + OM x I OM`,
//! whose columns are transformed to the joints before it.

use super::Options;
use super::algebra::{Scalar, Sum};
use super::composite::carry;
use super::equations::{Equations, QuantityLabel};
use super::inertia::{SumWrench, Wrench};
use super::parameters::ModelParameters;
use super::recursive::Recursion;
use super::vector::{add_cross, cyclic, unit};

/// The numbers of a body.
pub(super) const NUMBERS: usize = 10;

/// Rows and columns of the moments of inertia, in their order.
pub(super) const MOMENTS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// Writes `Y`, or the columns of base parameters.
pub(super) fn write(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) {
    let accelerations: Vec<Scalar> = (0..parameters.joints())
        .map(|joint| parameters.acceleration(equations, joint))
        .collect();
    let mut recursion = Recursion::moving(equations, parameters, options, &accelerations);
    for frame in 0..parameters.joints() {
        let Some(joint) = parameters.frames.joint(frame) else {
            continue;
        };
        if parameters.model.body_of(frame).is_none() {
            continue;
        }
        for (number, wrench) in wrenches(&mut recursion, frame).into_iter().enumerate() {
            let column = NUMBERS * joint + number;
            let place = match &options.base_columns[..] {
                [] => Ok(column),
                kept => kept.binary_search(&column),
            };
            if let Ok(place) = place {
                write_column(&mut recursion, frame, (place, wrench));
            }
        }
    }
    // Every column is there, also those of the last joints without a body.
    let last = match options.base_columns.len() {
        0 => NUMBERS * parameters.frames.places().len(),
        kept => kept,
    };
    let size = [parameters.joints(), last];
    if let Some(joint) = (0..size[0]).find(|&joint| !parameters.frames.is_constant(joint)) {
        let there = equations.outputs.iter().any(|&(array, [_, column], _)| {
            equations.results[array as usize] == "Y" && column as usize == last
        });
        if !there {
            equations.output("Y", &[joint + 1, last], Scalar::ZERO);
        }
    }
}

/// Force and torque that each number of a body takes, in its frame.
fn wrenches(recursion: &mut Recursion<'_, '_, '_>, joint: usize) -> Vec<Wrench> {
    let motion = recursion.motions[joint];
    let tilde = recursion.tildes[joint];
    let velocity = recursion.velocities[joint];
    let mut wrenches = vec![Wrench {
        force: motion.linear,
        ..Wrench::ZERO
    }];
    for axis in 0..3 {
        let mut sums = SumWrench::new();
        for (component, row) in sums.force.iter_mut().zip(&tilde) {
            component.add(&[row[axis]]);
        }
        add_cross(&mut sums.torque, &unit(axis), &motion.linear, false);
        wrenches.push(sums.define(recursion.equations, ("YF", "YN"), joint, axis + 1));
    }
    for (row, column) in MOMENTS {
        let mut sums = SumWrench::new();
        // With the cyclic axes a, b, c: the torque about a of a moment I_kl is
        // that of the recursive family, see `Recursion::add_rotation`.
        for a in 0..3 {
            let (b, c) = cyclic(a);
            let term = &mut sums.torque[a];
            match (row, column) {
                pair if pair == (a, a) => {
                    term.add(&[motion.angular[a]]);
                }
                pair if pair == (b, b) => {
                    term.subtract(&[velocity[b], velocity[c]]);
                }
                pair if pair == (c, c) => {
                    term.add(&[velocity[b], velocity[c]]);
                }
                pair if pair == (a.min(b), a.max(b)) => {
                    term.subtract(&[tilde[c][a]]);
                }
                pair if pair == (a.min(c), a.max(c)) => {
                    term.add(&[tilde[b][a]]);
                }
                _ => {
                    term.add(&[tilde[b][b]]).subtract(&[tilde[c][c]]);
                }
            }
        }
        let number = wrenches.len();
        wrenches.push(sums.define(recursion.equations, ("YF", "YN"), joint, number));
    }
    wrenches
}

/// Carries a column to the joints before a body.
fn write_column(
    recursion: &mut Recursion<'_, '_, '_>,
    joint: usize,
    (column, mut wrench): (usize, Wrench),
) {
    let parameters = recursion.parameters;
    let mut below = joint;
    loop {
        if !parameters.frames.is_constant(below) {
            let mut value = Sum::of(wrench.along(parameters, below));
            let label = QuantityLabel::new("Y", 0, below + 1).column(column + 1);
            let value = recursion
                .equations
                .define(label, std::mem::take(&mut value));
            if !value.is_zero() {
                recursion
                    .equations
                    .output("Y", &[below + 1, column + 1], value);
            }
        }
        let Some(parent) = parameters.parent(below) else {
            break;
        };
        let offset = recursion.offsets[below];
        let place = (below, column);
        wrench = carry(
            recursion.equations,
            parameters,
            &wrench,
            ("YF", "YN"),
            place,
            &offset,
        );
        below = parent;
    }
}
