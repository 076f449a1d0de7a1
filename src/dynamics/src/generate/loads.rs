//! Forces and torques on bodies, collected from force elements: the columns of
//! `frc` and `trq`.
//!
//! They act on a body's centre of mass, in its frame, and are added to the
//! loads of the caller.

use super::algebra::{Scalar, Sum};
use super::equations::{Equations, QuantityLabel};
use super::parameters::ModelParameters;
use super::vector::{Matrix, SumVector, Vector, add_cross, sums};

/// Loads added to the bodies, by joint.
pub(super) struct Loads {
    columns: Vec<Option<(SumVector, SumVector)>>,
}

impl Loads {
    pub(super) fn new(parameters: &ModelParameters<'_>) -> Loads {
        Loads {
            columns: vec![None; parameters.joints()],
        }
    }

    /// The force and torque of a joint's body, to be added to.
    pub(super) fn of(&mut self, joint: usize) -> &mut (SumVector, SumVector) {
        self.columns[joint].get_or_insert_with(|| (sums(), sums()))
    }

    /// Adds a force at a lever from the centre of mass, both in the frame of
    /// the body.
    pub(super) fn add_force(
        &mut self,
        joint: usize,
        force: &Vector,
        lever: &Vector,
        negative: bool,
    ) {
        let (forces, torques) = self.of(joint);
        for (component, &value) in forces.iter_mut().zip(force) {
            component.add(&[value.negated_if(negative)]);
        }
        add_cross(torques, lever, force, negative);
    }

    /// Writes the outputs.
    pub(super) fn write(self, equations: &mut Equations) {
        for (joint, column) in self.columns.into_iter().enumerate() {
            let Some((force, torque)) = column else {
                continue;
            };
            for (name, vector) in [("frc", force), ("trq", torque)] {
                for (k, sum) in vector.into_iter().enumerate() {
                    if sum.is_empty() {
                        continue;
                    }
                    let mut total = Sum::of(equations.input(name, &[k + 1, joint + 1]));
                    total.add_sum(&sum);
                    let label = QuantityLabel::new(name, k + 1, joint + 1);
                    let value = equations.define(label, total);
                    equations.output(name, &[k + 1, joint + 1], value);
                }
            }
        }
    }
}

/// A vector of the reference frame in the frame whose axes are given.
pub(super) fn into_frame(
    equations: &mut Equations,
    axes: &Matrix,
    vector: &[Scalar; 3],
    label: impl Fn(usize) -> QuantityLabel,
) -> Vector {
    let mut row = 0;
    axes.map(|axis| {
        let mut sum = Sum::new();
        for (entry, &component) in axis.iter().zip(vector) {
            sum.add(&[component, *entry]);
        }
        row += 1;
        equations.define(label(row), sum)
    })
}
