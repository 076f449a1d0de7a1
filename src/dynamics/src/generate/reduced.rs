//! Reduced accelerations: `qdd` from `M`, `c` and the loops.
//!
//! The constraints of loops give the accelerations of dependent joints v by
//! those of independent joints u: `qdd_v = B qdd_u + b` with `B = -Jv^-1 Ju`
//! and `b = -Jv^-1 (jdqd + Jc qdd_c)`. Put into `M qdd + c = Qq + J^T lambda`,
//! the multipliers drop out (coordinate partitioning):
//!
//! ```text
//! Mr = Muu + Muv B + (Muv B)^T + B^T Mvv B
//! Mr qdd_u = f_u - Muv b + B^T (f_v - Mvv b),    f = Qq - c - M_c qdd_c
//! ```
//!
//! Rows `A qdd_u + g = 0` that the user computes are satisfied by separate
//! multipliers, `(A Mr^-1 A^T) mu = -g - A Mr^-1 f_r`: their Jacobian is not
//! known before, and this matrix is positive definite for any Jacobian of full
//! rank. Where `Mr` is singular, [`super::massless`] makes it regular.
//!
//! The accelerations of driven joints c are inputs. Positions and velocities
//! must satisfy the loops. Which joints depend and which rows are redundant are
//! decided when the equations are made, at the closed initial state of the
//! model; where the joints chosen do not determine the others, the equations
//! fail. How loops are solved, and where that needs pivots: [`super::blocks`].

use super::algebra::Scalar;
use super::reduction::{CoordinateReduction, sorted};

use super::composite::MassAndBias;
use super::equations::Equations;
use super::factor::{LIMIT, Stop, solve_symmetric};
use super::massless::massless_joints;
use super::parameters::ModelParameters;
use super::reactions::{self, ForceBalance};
use super::roles::JointRoles;
use super::user_constraints::BoundAccelerations;
use super::{GenerateError, Options};
use robovec_model::{Model, Nature};

/// Writes `qdd`.
pub(super) fn accelerations(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    dynamics: &MassAndBias,
) -> Result<(), GenerateError> {
    let model = parameters.model;
    let mut reduction = CoordinateReduction {
        equations,
        parameters,
        masses: dynamics.mass.iter().map(|row| sorted(row)).collect(),
        given: vec![Scalar::ZERO; model.joints.len()],
    };
    let frames = parameters.frames;
    let roles = JointRoles::of_loops(frames.source)?;
    if options.user_constraints > roles.free.len() {
        return Err(GenerateError::UserConstraints {
            rows: options.user_constraints,
            left: roles.free.len(),
            of_loops: roles.dependent.len(),
        });
    }
    let massless = massless_joints(frames.source, &roles, options)?;
    let partition = roles.framed(frames);
    for joint in 0..model.joints.len() {
        if model.joints[joint].nature == Nature::Driven {
            reduction.given[joint] = parameters.acceleration(reduction.equations, joint);
        }
    }
    let loops = reduction.loops(&partition, options)?;
    let forces: Vec<Scalar> = (0..model.joints.len())
        .map(|joint| reduction.residual(joint, dynamics.bias[joint]))
        .collect();
    let (mut rows, right) = reduction.reduced(&partition, &loops, &forces);
    let mut user = reduction.user(&partition, &loops, options);
    user.add_massless(reduction.equations, &massless, &mut rows);
    let mut sides = vec![right];
    sides.extend(user.reduced.matrix.iter().cloned());
    let joints = &partition.free;
    let mut solutions =
        solve_symmetric(reduction.equations, &rows, &sides, joints).map_err(|stop| match stop {
            Stop::NoPivot(place) => GenerateError::singular(model, [joints[place]]),
            Stop::TooLarge => too_large(model),
        })?;
    let forced = solutions.split_off(1);
    let unbound = solutions.pop().expect("the forces are the first side");
    let growth = options.growth;
    let multipliers = user.multipliers(reduction.equations, &unbound, &forced, growth);
    let solution = BoundAccelerations::bound(reduction.equations, &unbound, &forced, &multipliers);
    let accelerations = reduction.output(&partition, &loops, &solution);
    if options.multipliers {
        let balance = ForceBalance {
            bias: &dynamics.bias,
            forces: &forces,
            accelerations: &accelerations,
            user: (&user.rows, &multipliers[..user.rows.len()]),
        };
        reactions::write(&mut reduction, &partition, &loops, &balance)?;
    }
    Ok(())
}

/// The error of a mass matrix whose elimination is too long.
pub(super) fn too_large(model: &Model) -> GenerateError {
    GenerateError::Elimination {
        model: model.name.clone(),
        limit: LIMIT,
    }
}
