//! External forces: the motion of their points, a call of the user's law for
//! each, and the contribution of its nine numbers to `frc` and `trq`.
//!
//! The law returns a force and a torque in the base frame and, in the frame of
//! the body, the place of the force from the frame's origin.

use super::Options;
use super::algebra::Sum;
use super::equations::{Equations, QuantityLabel};
use super::loads::{Loads, into_frame};
use super::parameters::ModelParameters;
use super::sensor::{self, SensorNames};
use robovec_ir::{Boundary, SourceSet};
use robovec_model::Asks;

/// Writes all external forces.
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
