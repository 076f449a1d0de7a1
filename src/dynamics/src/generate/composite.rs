//! Composite rigid bodies in body frames: `M` and `c`.
//!
//! The bodies beyond a joint, frozen, are one body: its *composite*. A unit of
//! acceleration of joint i takes the wrench `I_i s_i` of its composite, which
//! is carried to the joints before it; its components along their axes are the
//! column of `M`. So each pair of joints costs one change of frame, where the
//! recursive family has the cost of a whole body.
//!
//! The moments of inertia are turned with `sin^2 + cos^2 = 1`.

use super::algebra::{Scalar, Sum};
use super::bias::Bias;
use super::equations::{EquationStyle, Equations, QuantityLabel};
use super::inertia::Wrench;
use super::lower::operations;
use super::parameters::ModelParameters;
use super::vector::{Inertia, Vector};
use super::{Options, recursive};

/// `M`, its lower triangle by rows, and `c`.
pub(super) struct MassAndBias {
    /// For every joint, its entries with itself and the joints on its path.
    pub(super) mass: Vec<Vec<(usize, Scalar)>>,
    pub(super) bias: Vec<Scalar>,
}

impl MassAndBias {
    /// Removes the values set as outputs `M` and `c`, and returns them.
    pub(super) fn take(equations: &mut Equations, joints: usize) -> MassAndBias {
        let mut dynamics = MassAndBias {
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

    /// Adds the inertias of rotors to the diagonal of `M`.
    pub(super) fn with_armatures(
        mut self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
    ) -> MassAndBias {
        for (joint, entries) in self.mass.iter_mut().enumerate() {
            let own = entries.iter_mut().find(|(column, _)| *column == joint);
            let (_, own) = own.expect("a joint has an entry with itself");
            *own = with_armature(equations, parameters, joint, *own);
        }
        self
    }

    /// Sets the outputs `M` and `c`, without structural zeros.
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
pub(super) fn dynamics(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) -> MassAndBias {
    let offsets = parameters.named_offsets(equations);
    let composites = Inertia::composites(equations, parameters, &offsets);
    let bias = bias(equations, parameters, options, &offsets, &composites);
    let mass = (0..parameters.joints())
        .map(|joint| column(equations, parameters, &offsets, &composites, joint))
        .collect();
    MassAndBias { mass, bias }.with_armatures(equations, parameters)
}

/// The entry of `M` of a joint with itself, together with its rotor.
pub(super) fn with_armature(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    joint: usize,
    entry: Scalar,
) -> Scalar {
    let armature = parameters.armature(equations, joint);
    let label = QuantityLabel::new("MR", 0, joint + 1);
    equations.define(label, Sum::total(&[entry, armature]))
}

/// Joint forces for accelerations, by the form of fewer operations.
pub(super) fn inverse(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    accelerations: &[Scalar],
) -> Vec<Scalar> {
    if body_by_body(parameters, options, true) {
        return recursive::inverse(equations, parameters, options, accelerations);
    }
    let offsets = parameters.named_offsets(equations);
    let composites = Inertia::composites(equations, parameters, &offsets);
    Bias::new(parameters, &offsets, &composites)
        .accelerated(accelerations)
        .forces(equations)
}

/// `c`, with the composites that `M` needs anyway or body by body, whichever
/// takes fewer operations. Joints of fictitious bodies favour the latter, full
/// inertias and long chains the former.
pub(super) fn bias(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    offsets: &[Vector],
    composites: &[Inertia],
) -> Vec<Scalar> {
    if body_by_body(parameters, options, false) {
        recursive::bias(equations, parameters, options)
    } else {
        Bias::new(parameters, offsets, composites).forces(equations)
    }
}

/// Writes forces in both forms to find the one with fewer operations.
fn body_by_body(parameters: &ModelParameters<'_>, options: &Options, accelerated: bool) -> bool {
    let count = |bodies: bool| {
        let mut trial = Equations::new(EquationStyle {
            leading_signs: options.leading_signs,
        });
        let equations = &mut trial;
        let parameters = &ModelParameters::new(parameters.frames, options, equations);
        let offsets = parameters.named_offsets(equations);
        let composites = Inertia::composites(equations, parameters, &offsets);
        let accelerations: Vec<Scalar> = if accelerated {
            let joints = 0..parameters.joints();
            joints
                .map(|joint| parameters.acceleration(equations, joint))
                .collect()
        } else {
            for composite in &composites {
                let moments = composite.moments.iter().flatten();
                for &value in moments.chain(&composite.first).chain([&composite.mass]) {
                    equations.output("composite", &[], value);
                }
            }
            Vec::new()
        };
        let forces = if bodies {
            recursive::inverse(equations, parameters, options, &accelerations)
        } else {
            Bias::new(parameters, &offsets, &composites)
                .accelerated(&accelerations)
                .forces(equations)
        };
        for value in forces {
            equations.output("force", &[], value);
        }
        operations(equations)
    };
    count(true) < count(false)
}

/// The entries of `M` of a joint with the joints on its path to the base.
fn column(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
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
            ("FT", "NT"),
            (below, joint),
            &offsets[below],
        );
        entries.push((parent, wrench.along(parameters, parent)));
        below = parent;
    }
    entries
}

/// The wrench of a column (second joint) beyond a joint (first), before it.
pub(super) fn carry(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    wrench: &Wrench,
    names: (&'static str, &'static str),
    (joint, column): (usize, usize),
    offset: &Vector,
) -> Wrench {
    let place = (joint, column + 1);
    let turn = &parameters.turns[joint];
    wrench
        .to_parent(equations, names.0, place, turn, offset)
        .define(equations, names, joint, column + 1)
}
