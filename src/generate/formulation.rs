//! The recursions equations can be made by, what each needs and gives.

use super::equations::Equations;
use super::parameters::Parameters;
use super::{FunctionKind, GenerateError, Request, composite, composite_base, prefix, recursive};

/// A recursion.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum Formulation {
    /// Recursive Newton-Euler, column by column: what Robotran prints.
    #[default]
    Recursive,
    /// Composite rigid bodies in body frames: the fewest operations for short
    /// chains and for trees of many short branches.
    Composite,
    /// Composite rigid bodies with the columns of `M` in one common frame, that
    /// of the first body with mass: the fewest operations for long chains.
    CompositeBase,
    /// Everything in one common frame, as sums and products over paths: the
    /// shortest critical path.
    Prefix {
        /// In which order paths and subtrees are combined.
        network: Network,
        /// Which frame is the common one.
        origin: Origin,
    },
}

/// In which order values along a path are combined.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum Network {
    /// One after another: the fewest operations.
    Serial,
    /// In twice logarithmic depth with at most twice the operations.
    BrentKung,
    /// In logarithmic depth: the shortest path.
    #[default]
    Sklansky,
}

impl Network {
    /// All networks.
    pub const ALL: [Network; 3] = [Network::Serial, Network::BrentKung, Network::Sklansky];
}

/// The frame whose origin moments are about.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum Origin {
    /// The base.
    Base,
    /// The first body with mass on each path: it moves with the system, so
    /// that moments stay small and short number formats keep small entries.
    #[default]
    Body,
}

/// What equations ask of numbers.
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
    pub const ALL: [Formulation; 9] = [
        Formulation::Recursive,
        Formulation::Composite,
        Formulation::CompositeBase,
        Formulation::prefix(Network::Serial, Origin::Body),
        Formulation::prefix(Network::BrentKung, Origin::Body),
        Formulation::prefix(Network::Sklansky, Origin::Body),
        Formulation::prefix(Network::Serial, Origin::Base),
        Formulation::prefix(Network::BrentKung, Origin::Base),
        Formulation::prefix(Network::Sklansky, Origin::Base),
    ];

    const fn prefix(network: Network, origin: Origin) -> Formulation {
        Formulation::Prefix { network, origin }
    }

    /// The formulation's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Formulation::Recursive => "recursive",
            Formulation::Composite => "composite",
            Formulation::CompositeBase => "composite-base",
            Formulation::Prefix { network, origin } => match (network, origin) {
                (Network::Serial, Origin::Body) => "prefix-serial",
                (Network::BrentKung, Origin::Body) => "prefix-brent-kung",
                (Network::Sklansky, Origin::Body) => "prefix-sklansky",
                (Network::Serial, Origin::Base) => "prefix-serial-base",
                (Network::BrentKung, Origin::Base) => "prefix-brent-kung-base",
                (Network::Sklansky, Origin::Base) => "prefix-sklansky-base",
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

    /// True when the formulation makes a difference to the function and can
    /// give it, or when it makes none (constraints of loops have one form).
    pub fn gives(self, function: FunctionKind) -> bool {
        match function {
            FunctionKind::Invdyna => self == Formulation::Recursive,
            _ => true,
        }
    }

    /// What the equations of the formulation need.
    pub fn requirements(self) -> Requirements {
        Requirements {
            true_sin_cos: self != Formulation::Recursive,
            division: false,
            square_root: false,
        }
    }
}

/// Refuses what a formulation cannot give, with what can.
pub(super) fn check(request: &Request) -> Result<(), GenerateError> {
    let (formulation, function) = (request.formulation, request.function);
    if formulation.gives(function) {
        return Ok(());
    }
    let possible: Vec<&str> = Formulation::ALL
        .into_iter()
        .filter(|one| one.gives(function))
        .map(Formulation::name)
        .collect();
    Err(GenerateError::NotGiven {
        formulation: formulation.name(),
        function: function.name(),
        possible: possible.join(", "),
    })
}

/// Writes `M` and `c`.
pub(super) fn direct(equations: &mut Equations, parameters: &Parameters<'_>, request: &Request) {
    match request.formulation {
        Formulation::Recursive => recursive::direct(equations, parameters, &request.options),
        Formulation::Composite => composite::dynamics(equations, parameters).output(equations),
        Formulation::CompositeBase => {
            composite_base::dynamics(equations, parameters).output(equations);
        }
        Formulation::Prefix { network, origin } => {
            prefix::dynamics(equations, parameters, network, origin).output(equations);
        }
    }
}
