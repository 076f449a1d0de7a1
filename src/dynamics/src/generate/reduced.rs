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
use super::composite::MassAndBias;
use super::equations::Equations;
use super::massless::{MasslessJoint, massless_joints};
use super::parameters::ModelParameters;
use super::reactions::{self, ForceBalance};
use super::reduction::{CoordinateReduction, DependentAccelerations, ReducedSystem, sorted};
use super::roles::JointRoles;
use super::user_constraints::BoundAccelerations;
use super::{GenerateError, Options};
use robovec_model::Nature;

/// Accelerations, and the equations that they are the solution of.
pub(super) struct ReducedMotion<'e, 'p, 'm> {
    pub(super) reduction: CoordinateReduction<'e, 'p, 'm>,
    pub(super) roles: JointRoles,
    pub(super) loops: DependentAccelerations,
    pub(super) system: ReducedSystem,
    pub(super) balance: ForceBalance,
}

impl<'e, 'p, 'm> ReducedMotion<'e, 'p, 'm> {
    /// Solves for all accelerations, in roles at a state of the model.
    /// `massless` are joints with accelerations by rows of the user alone.
    pub(super) fn new(
        equations: &'e mut Equations,
        parameters: &'p ModelParameters<'m>,
        options: &Options,
        dynamics: MassAndBias,
        (roles, massless): (JointRoles, &[MasslessJoint]),
    ) -> Result<Self, GenerateError> {
        let model = parameters.model;
        let mut reduction = CoordinateReduction {
            equations,
            parameters,
            masses: dynamics.mass.iter().map(|row| sorted(row)).collect(),
            given: vec![Scalar::ZERO; model.joints.len()],
        };
        let roles = roles.framed(parameters.frames);
        for joint in 0..model.joints.len() {
            if model.joints[joint].nature == Nature::Driven {
                reduction.given[joint] = parameters.acceleration(reduction.equations, joint);
            }
        }
        let loops = reduction.loops(&roles, options)?;
        let forces: Vec<Scalar> = (0..model.joints.len())
            .map(|joint| reduction.residual(joint, dynamics.bias[joint]))
            .collect();
        let mut system = reduction.reduced(&roles, &loops, &forces);
        let mut user = reduction.user(&roles, &loops, options);
        user.add_massless(reduction.equations, massless, &mut system.rows);
        let mut sides = vec![system.right.clone()];
        sides.extend(user.reduced.matrix.iter().cloned());
        let joints = (model, &roles.free[..]);
        let mut solutions = system.solve(reduction.equations, joints, &sides)?;
        let forced = solutions.split_off(1);
        let unbound = solutions.pop().expect("the forces are the first side");
        let multipliers = user.multipliers(reduction.equations, &unbound, &forced, options.growth);
        let solution =
            BoundAccelerations::bound(reduction.equations, &unbound, &forced, &multipliers);
        let accelerations = reduction.accelerations(&roles, &loops, &solution);
        Ok(ReducedMotion {
            reduction,
            roles,
            loops,
            system,
            balance: ForceBalance {
                bias: dynamics.bias,
                forces,
                accelerations,
                user: user.rows.into_iter().zip(multipliers).collect(),
            },
        })
    }
}

/// Writes `qdd`.
pub(super) fn accelerations(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    dynamics: MassAndBias,
) -> Result<(), GenerateError> {
    let source = parameters.frames.source;
    let roles = JointRoles::of_loops(source)?;
    if options.user_constraints > roles.free.len() {
        return Err(GenerateError::UserConstraints {
            rows: options.user_constraints,
            left: roles.free.len(),
            of_loops: roles.dependent.len(),
        });
    }
    let massless = massless_joints(source, &roles, options)?;
    let mut motion =
        ReducedMotion::new(equations, parameters, options, dynamics, (roles, &massless))?;
    for (joint, &value) in motion.balance.accelerations.iter().enumerate() {
        motion
            .reduction
            .equations
            .output("qdd", &[joint + 1], value);
    }
    if options.multipliers {
        let reduction = &mut motion.reduction;
        reactions::write(reduction, &motion.roles, &motion.loops, &motion.balance)?;
    }
    Ok(())
}
