//! Errors of the generator.

use crate::kinematics::named_joints;
use robovec_model::Model;
use thiserror::Error;

/// Reason why nothing was generated.
#[derive(Clone, PartialEq, Eq, Error, Debug)]
pub enum GenerateError {
    /// The lists of the model do not fit together.
    #[error("the model '{0}' is inconsistent")]
    Inconsistent(String),
    /// The equations would fill the memory.
    #[error(
        "the joints of '{model}' have {pairs} ancestors, themselves included; more than {limit} \
         would give hundreds of millions of bytes of equations (the formulation 'articulated' has \
         no such limit)"
    )]
    TooLarge {
        /// The name of the model.
        model: String,
        /// The pairs of a joint and an ancestor or itself.
        pairs: usize,
        /// The most that are allowed.
        limit: usize,
    },
    /// The elimination of the mass matrix would fill the memory.
    #[error(
        "to eliminate the mass matrix of '{model}' takes more than {limit} products (for models \
         without loops the formulation 'articulated' needs no elimination)"
    )]
    Elimination {
        /// The name of the model.
        model: String,
        /// The most that are allowed.
        limit: usize,
    },
    /// The formulation cannot give the function.
    #[error("the formulation '{formulation}' does not give {function}; these do: {possible}")]
    NotGiven {
        /// The name of the formulation.
        formulation: &'static str,
        /// The name of the function.
        function: &'static str,
        /// The names of those that give it.
        possible: String,
    },
    /// The formulation supports no constraints.
    #[error("the formulation '{formulation}' does not support constraints; these do: {possible}")]
    NoLoops {
        /// The name of the formulation.
        formulation: &'static str,
        /// The names of the formulations that close them.
        possible: String,
    },
    /// The formulation gives no forces of driven joints.
    #[error(
        "the formulation '{formulation}' gives no forces of driven joints; these do: {possible}"
    )]
    NoDriveForces {
        /// The name of the formulation.
        formulation: &'static str,
        /// The names of the formulations that give them.
        possible: String,
    },
    /// The formulation needs identities that the options forbid.
    #[error(
        "the formulation '{formulation}' needs sin^2 + cos^2 = 1, which the options exclude; \
         'recursive' does not need it"
    )]
    NeedsTrueAngles {
        /// The name of the formulation.
        formulation: &'static str,
    },
    /// Every formulation of the function needs identities that options forbid.
    #[error(
        "{function} needs sin^2 + cos^2 = 1, and the cosine as the derivative of the sine, which \
         the options exclude; the pass 'trigonometry' may replace sines and cosines afterwards"
    )]
    NeedsSines {
        /// The name of the function.
        function: &'static str,
    },
    /// Forces cannot move joints in a determined way.
    #[error(
        "no acceleration of {} is determined: what {} no mass or inertia in that direction; drive \
         {them} (--driven), hold {them} (--hold) or bind {them} by constraints of the project \
         (--user-constraints)",
        named_joints(joints),
        if joints.len() == 1 { "it moves has" } else { "they move has" },
        them = if joints.len() == 1 { "it" } else { "them" }
    )]
    Singular {
        /// Names of the joints.
        joints: Vec<String>,
    },
    /// Constraints of the user have no dependent joints.
    #[error(
        "{rows} user constraint(s) determine as many dependent joints beside the {of_loops} of \
         the loops, and the model names {left}: set the nature of the joints to 'dependent'"
    )]
    UserConstraints {
        /// Rows that the user computes.
        rows: usize,
        /// Dependent joints of the model that the loops do not determine.
        left: usize,
        /// Dependent joints that the loops determine.
        of_loops: usize,
    },
    /// Actuators are not those that inverse dynamics can find the forces of.
    #[error(
        "inverse dynamics finds as many forces of actuators as joints move freely, {free}, and the \
         model has {actuated} actuator(s)"
    )]
    Actuators {
        /// Joints that move freely.
        free: usize,
        /// Actuated joints of the model that are not driven.
        actuated: usize,
    },
    /// Constraints do not hold the joints that have no actuator.
    #[error(
        "the constraints do not determine the forces at joints without an actuator: actuators at \
         other joints may"
    )]
    Unactuated,
    /// Derivatives would need those of the user's computations.
    #[error(
        "{function} needs the derivatives of constraints that the user computes, which are not \
         known"
    )]
    UserDerivatives {
        /// The name of the function.
        function: &'static str,
    },
    /// The base cannot be described by a quaternion.
    #[error("the base of '{model}' cannot be described by a quaternion: {why}")]
    Quaternion {
        /// The name of the model.
        model: String,
        /// The reason.
        why: String,
    },
    /// There is no motion to linearise.
    #[error("no joint of the model '{0}' moves freely")]
    Motionless(String),
    /// The function would set nothing.
    #[error("the model '{model}' has no {lacks}: {function} would be empty")]
    Empty {
        /// The name of the model.
        model: String,
        /// The name of the function.
        function: &'static str,
        /// The part of models that the function is about.
        lacks: &'static str,
    },
    /// The loops cannot be closed at the model's initial state.
    #[error("the dependent joints cannot be chosen: {0}")]
    Loops(String),
}

impl GenerateError {
    /// The error of joints that forces cannot move in a determined way.
    pub(super) fn singular(
        model: &Model,
        joints: impl IntoIterator<Item = usize>,
    ) -> GenerateError {
        let name = |joint: usize| model.joints[joint].name.clone();
        GenerateError::Singular {
            joints: joints.into_iter().map(name).collect(),
        }
    }
}
