//! The recursions for equations, with the requirements and outputs of each.

use super::algebra::{Scalar, Sum};
use super::composite::MassAndBias;
use super::equations::{Equations, QuantityLabel};
use super::hub::MomentOrigin;
use super::network::PrefixNetwork;
use super::parameters::ModelParameters;
use super::{
    FunctionKind, GenerateError, GenerationRequest, articulated, columns, composite,
    composite_base, factor, prefix, recursive, reduced,
};
use robovec_model::{Model, Nature};

/// A recursion.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum Formulation {
    /// Recursive Newton-Euler, column by column, as in Robotran.
    #[default]
    Recursive,
    /// Composite rigid bodies in body frames: the fewest operations for short
    /// chains and for trees of many short branches.
    Composite,
    /// Composite rigid bodies with the columns of `M` in one common frame, that
    /// of the first body with mass: the fewest operations for long chains.
    CompositeBase,
    /// Everything in one common frame, in sums over paths: the shortest chain.
    Prefix {
        /// In which order paths and subtrees are combined.
        network: PrefixNetwork,
        /// Origin of the common frame.
        origin: MomentOrigin,
    },
    /// Articulated bodies: accelerations of trees in a number of operations
    /// that grows with the number of joints alone. Gives no `M` and `c`.
    Articulated,
}

/// Requirements of equations on numbers.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Requirements {
    /// Sine and cosine must lie on the circle: the equations use
    /// `sin^2 + cos^2 = 1`. Then they may not be replaced by short series.
    pub true_sin_cos: bool,
    /// There are divisions.
    pub division: bool,
    /// There are square roots.
    pub square_root: bool,
}

impl Formulation {
    /// All formulations.
    pub const ALL: [Formulation; 10] = [
        Formulation::Recursive,
        Formulation::Composite,
        Formulation::CompositeBase,
        Formulation::prefix(PrefixNetwork::Serial, MomentOrigin::Body),
        Formulation::prefix(PrefixNetwork::BrentKung, MomentOrigin::Body),
        Formulation::prefix(PrefixNetwork::Sklansky, MomentOrigin::Body),
        Formulation::prefix(PrefixNetwork::Serial, MomentOrigin::Base),
        Formulation::prefix(PrefixNetwork::BrentKung, MomentOrigin::Base),
        Formulation::prefix(PrefixNetwork::Sklansky, MomentOrigin::Base),
        Formulation::Articulated,
    ];

    /// One common frame, with this order and this origin of moments.
    pub const fn prefix(network: PrefixNetwork, origin: MomentOrigin) -> Formulation {
        Formulation::Prefix { network, origin }
    }

    /// The formulation's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Formulation::Recursive => "recursive",
            Formulation::Composite => "composite",
            Formulation::CompositeBase => "composite-base",
            Formulation::Articulated => "articulated",
            Formulation::Prefix { network, origin } => match (network, origin) {
                (PrefixNetwork::Serial, MomentOrigin::Body) => "prefix-serial",
                (PrefixNetwork::BrentKung, MomentOrigin::Body) => "prefix-brent-kung",
                (PrefixNetwork::Sklansky, MomentOrigin::Body) => "prefix-sklansky",
                (PrefixNetwork::Serial, MomentOrigin::Base) => "prefix-serial-base",
                (PrefixNetwork::BrentKung, MomentOrigin::Base) => "prefix-brent-kung-base",
                (PrefixNetwork::Sklansky, MomentOrigin::Base) => "prefix-sklansky-base",
            },
        }
    }

    /// Description for the choice, in one line.
    pub fn description(self) -> &'static str {
        match self {
            Formulation::Recursive => "Newton-Euler, column by column: what Robotran prints",
            Formulation::Composite => {
                "composite bodies in body frames: fewest operations for trees and short chains"
            }
            Formulation::CompositeBase => {
                "composite bodies, long columns in one frame: fewest operations for long chains"
            }
            Formulation::Articulated => {
                "articulated bodies, accelred of trees: operations proportional to the number of joints, with divisions"
            }
            Formulation::Prefix { network, origin } => match (network, origin) {
                (PrefixNetwork::Serial, MomentOrigin::Body) => {
                    "one frame, one after another: linear depth"
                }
                (PrefixNetwork::BrentKung, MomentOrigin::Body) => {
                    "one frame, Brent-Kung network: logarithmic depth, few operations"
                }
                (PrefixNetwork::Sklansky, MomentOrigin::Body) => {
                    "one frame, Sklansky network: the shortest critical path"
                }
                (
                    PrefixNetwork::Serial | PrefixNetwork::BrentKung | PrefixNetwork::Sklansky,
                    MomentOrigin::Base,
                ) => "the same with moments about the base: loses digits in short formats",
            },
        }
    }

    /// The names of all formulations.
    pub fn names() -> Vec<&'static str> {
        Formulation::ALL
            .into_iter()
            .map(Formulation::name)
            .collect()
    }

    /// The formulation with this name.
    pub fn from_name(name: &str) -> Option<Formulation> {
        Formulation::ALL
            .into_iter()
            .find(|formulation| formulation.name() == name)
    }

    /// True when the formulation gives the function. Those that concern
    /// neither masses nor forces of joints have one form, which all give.
    pub fn gives(self, function: FunctionKind) -> bool {
        match function {
            FunctionKind::Dirdyna | FunctionKind::Invdyna | FunctionKind::Invdynared => {
                self != Formulation::Articulated
            }
            _ => true,
        }
    }

    /// True for accelerations of models with loops or constraints of the user.
    pub fn closes_loops(self) -> bool {
        self != Formulation::Articulated
    }

    /// Requirements of the equations of a function.
    pub fn requirements(self, function: FunctionKind) -> Requirements {
        let dynamics = matches!(
            function,
            FunctionKind::Dirdyna
                | FunctionKind::Invdyna
                | FunctionKind::Accelred
                | FunctionKind::Invdynared
        );
        // The regressor is a polynomial of velocities and accelerations.
        let derived = function.is_derived() && function != FunctionKind::Regressor;
        Requirements {
            // The recursive family does with or without, see `Options`.
            true_sin_cos: derived || self != Formulation::Recursive && dynamics,
            division: function.is_part_of_step()
                || matches!(
                    function,
                    FunctionKind::Link | FunctionKind::DirdynaD | FunctionKind::Minv
                ),
            square_root: function == FunctionKind::Link,
        }
    }
}

/// Refuses a function that a formulation cannot give, and names those that can.
pub(super) fn check(model: &Model, request: &GenerationRequest) -> Result<(), GenerateError> {
    let (chosen, function) = (request.formulation, request.function);
    let formulation = chosen.name();
    let names = |fits: &dyn Fn(Formulation) -> bool| {
        let fitting = Formulation::ALL.into_iter().filter(|&one| fits(one));
        fitting
            .map(Formulation::name)
            .collect::<Vec<_>>()
            .join(", ")
    };
    if !chosen.gives(function) {
        return Err(GenerateError::NotGiven {
            formulation,
            function: function.name(),
            possible: names(&|one| one.gives(function)),
        });
    }
    let is_bound = !model.cuts.is_empty() || request.options.user_constraints > 0;
    if function == FunctionKind::Accelred && is_bound && !chosen.closes_loops() {
        return Err(GenerateError::NoLoops {
            formulation,
            possible: names(&|one| one.gives(function) && one.closes_loops()),
        });
    }
    let mut joints = model.joints.iter();
    let is_driven = joints.any(|joint| joint.nature == Nature::Driven);
    let drives = is_driven && request.options.multipliers;
    if function == FunctionKind::Accelred && drives && chosen == Formulation::Articulated {
        return Err(GenerateError::NoDriveForces {
            formulation,
            possible: names(&|one| one.gives(function) && one != Formulation::Articulated),
        });
    }
    if function == FunctionKind::Accelred
        && chosen != Formulation::Articulated
        && factor::products(model) > factor::LIMIT
    {
        return Err(factor::too_large(model));
    }
    let options = &request.options;
    let substituted = !options.true_angles || !options.small_angles.is_empty();
    if function.is_derived() && function != FunctionKind::Regressor && substituted {
        return Err(GenerateError::NeedsSines {
            function: function.name(),
        });
    }
    if chosen.requirements(function).true_sin_cos && !options.true_angles {
        return Err(GenerateError::NeedsTrueAngles { formulation });
    }
    Ok(())
}

/// Writes `M` and `c`.
pub(super) fn direct(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    request: &GenerationRequest,
) {
    let options = &request.options;
    match request.formulation {
        Formulation::Recursive => columns::direct(equations, parameters, options),
        Formulation::Composite => {
            composite::dynamics(equations, parameters, options).output(equations);
        }
        Formulation::CompositeBase => {
            composite_base::dynamics(equations, parameters, options).output(equations);
        }
        Formulation::Prefix { network, origin } => {
            prefix::dynamics(equations, parameters, network, origin).output(equations);
        }
        // It gives neither, and was refused.
        Formulation::Articulated => {}
    }
}

/// Writes `Qq`, the joint forces that cause the accelerations `qdd`.
pub(super) fn inverse(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    request: &GenerationRequest,
) {
    let accelerations: Vec<Scalar> = (0..parameters.joints())
        .map(|joint| parameters.acceleration(equations, joint))
        .collect();
    let forces = inverse_forces(equations, parameters, request, &accelerations);
    for (joint, value) in forces.into_iter().enumerate() {
        equations.output("Qq", &[joint + 1], value);
    }
}

/// The joint forces for given accelerations of all joints.
pub(super) fn inverse_forces(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    request: &GenerationRequest,
    given: &[Scalar],
) -> Vec<Scalar> {
    let mut forces = match request.formulation {
        Formulation::Recursive => {
            recursive::inverse(equations, parameters, &request.options, given)
        }
        Formulation::Composite | Formulation::CompositeBase => {
            composite::inverse(equations, parameters, &request.options, given)
        }
        Formulation::Prefix { network, origin } => {
            prefix::inverse(equations, parameters, (network, origin), given)
        }
        Formulation::Articulated => unreachable!("it gives no forces, and was refused"),
    };
    for (joint, force) in forces.iter_mut().enumerate() {
        let armature = parameters.armature(equations, joint);
        let mut sum = Sum::of(*force);
        sum.add(&[armature, given[joint]]);
        *force = equations.define(QuantityLabel::new("QR", 0, joint + 1), sum);
    }
    forces
}

/// Writes `qdd`.
pub(super) fn accelerations(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    request: &GenerationRequest,
) -> Result<(), GenerateError> {
    if request.formulation == Formulation::Articulated {
        return articulated::accelerations(equations, parameters, &request.options)
            .map_err(|joint| GenerateError::singular(parameters.model, [joint]));
    }
    direct(equations, parameters, request);
    let dynamics = MassAndBias::take(equations, parameters.joints());
    reduced::accelerations(equations, parameters, &request.options, dynamics)
}
