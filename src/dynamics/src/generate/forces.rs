//! External forces: the motion of their points, a call of the user's law for
//! each, and the contribution of its nine numbers to `frc` and `trq`.
//!
//! The law returns a force and a torque in the base frame and, in the frame of
//! the body, the place of the force from the frame's origin.

use super::Options;
use super::algebra::{Scalar, Sum};
use super::equations::{Equations, QuantityLabel};
use super::parameters::ModelParameters;
use super::sensor::{self, SensorNames};
use super::vector::{Matrix, SumVector, Vector, add_cross, sums};
use robovec_ir::{Boundary, SourceSet};
use robovec_model::Asks;

pub(super) fn write(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) {
    let model = parameters.model;
    let mut loads = Loads::new(parameters);
    for (index, force) in model.forces.iter().enumerate() {
        let number = index + 1;
        let chain = sensor::chain(equations, parameters, options, ("F", number), force);
        let asks = Asks {
            jacobian: false,
            ..sensor::ALL
        };
        let names = SensorNames::of_force(number);
        sensor::outputs(equations, parameters, &chain, asks, &names);
        let result = format!("SWr{number}");
        // What acts on the base moves nothing.
        let joint = model.last_joint(model.points[force.point].body);
        equations.calls.push(Boundary {
            callee: "user_ExtForces".to_owned(),
            arguments: ["PxF", "RxF", "VxF", "OMxF", "AxF", "OMPxF"]
                .iter()
                .map(|name| format!("{name}{number}"))
                .chain(["s".to_owned(), "tsim".to_owned(), number.to_string()])
                .collect(),
            result: joint.map(|_| result.clone()),
            sources: SourceSet::EMPTY,
        });
        let Some(joint) = joint else {
            continue;
        };
        let mut part = |first: usize| [0, 1, 2].map(|k| equations.input(&result, &[first + k]));
        let (applied, torque, place) = (part(1), part(4), part(7));
        let axes = chain.axes();
        let name = |prefix| move |row| QuantityLabel::new(prefix, row, number);
        let applied = into_frame(equations, &axes, &applied, name("xfrc"));
        let torque = into_frame(equations, &axes, &torque, name("xtrq"));
        for (component, &value) in loads.of(joint).1.iter_mut().zip(&torque) {
            component.add(&[value]);
        }
        let center = parameters.centers[joint];
        let lever = [0, 1, 2].map(|k| {
            let sum = Sum::total(&[place[k], -center[k]]);
            equations.define(QuantityLabel::new("dxF", k + 1, number), sum)
        });
        loads.add_force(joint, &applied, &lever, false);
    }
    loads.write(equations);
}

/// Loads added to the bodies, by joint: the columns of `frc` and `trq`, which
/// act on a body's centre of mass, in its frame, beside those of the caller.
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

    /// Adds a force at a lever from the centre of mass, in the body's frame.
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
