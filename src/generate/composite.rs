//! Composite rigid bodies in body frames: `M` and `c`.
//!
//! The bodies behind a joint, frozen, are one body: its *composite*. A unit of
//! acceleration of joint i takes the wrench `I_i s_i` of its composite, which
//! is carried to the joints before it; its components along their axes are the
//! column of `M`. So each pair of joints costs one change of frame, where the
//! recursive family pays for a whole body.
//!
//! The moments of inertia are turned with `sin^2 + cos^2 = 1`.

use super::algebra::Scalar;
use super::bias::Bias;
use super::equations::Equations;
use super::inertia::{Inertia, Wrench};
use super::parameters::Parameters;
use super::vector::Vector;

/// `M`, its lower triangle by rows, and `c`.
pub(super) struct Dynamics {
    /// For every joint, its entries with the joints on its path to the base,
    /// the joint itself first.
    pub(super) mass: Vec<Vec<(usize, Scalar)>>,
    pub(super) bias: Vec<Scalar>,
}

impl Dynamics {
    /// Takes back what was set as outputs `M` and `c`.
    pub(super) fn take(equations: &mut Equations, joints: usize) -> Dynamics {
        let mut dynamics = Dynamics {
            mass: vec![Vec::new(); joints],
            bias: vec![Scalar::ZERO; joints],
        };
        for (array, [row, column], value) in std::mem::take(&mut equations.outputs) {
            let (row, column) = (row as usize, column as usize);
            match equations.results[array as usize].as_str() {
                "M" if column <= row => dynamics.mass[row - 1].push((column - 1, value)),
                "c" => dynamics.bias[row - 1] = value,
                _ => {}
            }
        }
        equations.results.clear();
        dynamics
    }

    /// Sets the outputs `M` and `c`; entries that are structurally zero are
    /// left out.
    pub(super) fn output(&self, equations: &mut Equations) {
        for (joint, entries) in self.mass.iter().enumerate() {
            for &(ancestor, entry) in entries {
                if entry.is_zero() {
                    continue;
                }
                equations.output("M", &[joint + 1, ancestor + 1], entry);
                if joint != ancestor {
                    equations.output("M", &[ancestor + 1, joint + 1], entry);
                }
            }
        }
        for (joint, &value) in self.bias.iter().enumerate() {
            equations.output("c", &[joint + 1], value);
        }
    }
}

/// `M` and `c` in body frames.
pub(super) fn dynamics(equations: &mut Equations, parameters: &Parameters<'_>) -> Dynamics {
    let offsets = parameters.named_offsets(equations);
    let composites = Inertia::composites(equations, parameters, &offsets);
    let bias = Bias::new(parameters, &offsets, &composites).forces(equations);
    let mass = (0..parameters.joints())
        .map(|joint| column(equations, parameters, &offsets, &composites, joint))
        .collect();
    Dynamics { mass, bias }
}

/// Joint forces for given accelerations of the joints.
pub(super) fn inverse(
    equations: &mut Equations,
    parameters: &Parameters<'_>,
    accelerations: &[Scalar],
) -> Vec<Scalar> {
    let offsets = parameters.named_offsets(equations);
    let composites = Inertia::composites(equations, parameters, &offsets);
    Bias::new(parameters, &offsets, &composites)
        .accelerated(accelerations)
        .forces(equations)
}

/// The entries of `M` of a joint with the joints on its path to the base.
fn column(
    equations: &mut Equations,
    parameters: &Parameters<'_>,
    offsets: &[Vector],
    composites: &[Inertia],
    joint: usize,
) -> Vec<(usize, Scalar)> {
    let axis = parameters.axis(joint);
    let mut wrench = composites[joint].column(axis, parameters.is_revolute(joint));
    let mut entries = vec![(joint, wrench.along(parameters, joint))];
    let mut below = joint;
    while let Some(parent) = parameters.parent(below) {
        wrench = carry(
            equations,
            parameters,
            &wrench,
            (below, joint),
            &offsets[below],
        );
        entries.push((parent, wrench.along(parameters, parent)));
        below = parent;
    }
    entries
}

/// The wrench of a column (the second joint) behind a joint (the first), before
/// that joint.
pub(super) fn carry(
    equations: &mut Equations,
    parameters: &Parameters<'_>,
    wrench: &Wrench,
    (joint, column): (usize, usize),
    offset: &Vector,
) -> Wrench {
    let place = (joint, column + 1);
    let turn = &parameters.turns[joint];
    wrench
        .to_parent(equations, "FT", place, turn, offset)
        .define(equations, ("FT", "NT"), joint, column + 1)
}
