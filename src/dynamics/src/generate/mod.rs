//! The generator: from a model to its equations.
//!
//! A *formulation* is a recursion over the tree of joints. It is carried out
//! with symbols: every component it computes becomes an equation, unless it is
//! zero, a copy or known already ([`equations`]). Equations that the outputs do
//! not need are dropped at the end ([`lower`]). All conventions are Robotran's:
//! names of arrays, indices from 1, `M qdd + c = Qq`, forces and torques of a
//! body at its centre of mass and in its frame.

// An axis is an index into several vectors at once.
#![allow(clippy::needless_range_loop)]

mod actuation;
mod algebra;
mod articulated;
mod base_parameters;
mod bias;
mod blocks;
mod chain;
mod chain_rates;
mod closing;
mod columns;
mod composite;
mod composite_base;
mod constraints;
mod contenders;
mod derivative;
mod equations;
mod error;
mod factor;
mod forces;
mod formulation;
mod frames;
mod free_base;
mod grouping;
mod hub;
mod inertia;
mod jacobians;
mod joint_arrays;
mod link;
mod loop_motion;
mod loop_rates;
mod lower;
mod massless;
mod named_frame;
mod network;
mod parameters;
mod prefix;
mod reactions;
mod recursive;
mod reduced;
mod reduction;
mod regressor;
mod roles;
mod sensitivity;
mod sensor;
mod user_constraints;
mod vector;

use self::algebra::Scalar;
pub use self::base_parameters::{BaseParameterError, BaseParameters, parameter_name};
pub use self::contenders::{Contender, Contenders, contenders, fewest};
use self::equations::{EquationStyle, Equations};
pub use self::error::GenerateError;
pub use self::formulation::{Formulation, Requirements};
use self::frames::ModelFrames;
pub use self::hub::MomentOrigin;
pub use self::jacobians::{with_jacobians, with_jacobians_into};
pub use self::joint_arrays::index_names;
use self::lower::Extents;
pub use self::massless::massless;
pub use self::network::PrefixNetwork;
pub use self::roles::{
    constraints as loop_constraints, cuts_of_rows, independent_joints, redundant_rows,
};
use self::sensitivity::AccelerationDerivatives;
use robovec_ir::verify::is_valid;
use robovec_ir::{Function, Level, Module};
use robovec_model::Model;
use robovec_robotran::FunctionKind;

/// In which order the terms of a backward sum are written. It affects only the
/// critical path of the unoptimised equations.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum TermOrder {
    /// The body's own terms, then those of its children.
    #[default]
    OwnFirst,
    /// Loads of the children, then the body's own terms.
    ChildFirst,
}

/// Form of a parameter of the model in the equations.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum ParameterBinding {
    /// An element of an input array, to be given at run time.
    #[default]
    Symbols,
    /// The number in the model.
    Numbers,
}

/// Options of the generator.
#[derive(Clone, PartialEq, Debug)]
pub struct Options {
    /// The order of terms in backward sums.
    pub order: TermOrder,
    /// Keep parameters that are zero in the model, and external loads of
    /// fictitious bodies ("All Parameter Symbols included").
    pub all_parameters: bool,
    /// Form of the parameters.
    pub parameters: ParameterBinding,
    /// Include the external forces `frc` and torques `trq` of bodies.
    pub external_forces: bool,
    /// Write sums as generator 8.1 does, a leading minus where the first term
    /// is negative; otherwise signs are moved to where they cost nothing.
    pub leading_signs: bool,
    /// Multiply out lever arms and `OM x (I OM)`, as Robotran prints them.
    pub expanded: bool,
    /// Use that `sin^2 + cos^2 = 1`. Without it the equations hold for any
    /// substitute of sine and cosine.
    pub true_angles: bool,
    /// Joints, by index, whose angles are small: their sine is the angle and
    /// their cosine one, in the equations of motion.
    pub small_angles: Vec<usize>,
    /// Give the multipliers `Lambda` of the constraints beside accelerations,
    /// with `M qdd + c = Qq + Jac^T Lambda`, those of the loops first; zero for
    /// redundant rows. And the forces `Qc` that move driven joints.
    pub multipliers: bool,
    /// Number of constraint rows of the user, in their own inputs: values
    /// `huserc`, Jacobian `Juserc` by all joints, and velocity terms of their
    /// second derivative, `jdqduserc`. As many dependent joints, besides those
    /// of the loops, follow from them.
    pub user_constraints: usize,
    /// Give also the factors `Growth` by which the elimination of each row of
    /// the user, and then of each of [`massless`], enlarges rounding.
    pub growth: bool,
    /// Describe the free base of the model by the quaternion `quat` (`x y z w`, of
    /// length one), and by its velocity, acceleration and force along its own
    /// axes, the linear ones first; its positions are not read.
    pub quaternion: bool,
    /// Columns of the regressor that are written, from 0, ascending; all when
    /// there are none ([`BaseParameters::columns`]).
    pub base_columns: Vec<usize>,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            order: TermOrder::default(),
            all_parameters: false,
            parameters: ParameterBinding::default(),
            external_forces: true,
            leading_signs: false,
            expanded: false,
            true_angles: true,
            small_angles: Vec::new(),
            multipliers: false,
            user_constraints: 0,
            growth: false,
            quaternion: false,
            base_columns: Vec::new(),
        }
    }
}

/// Function to generate, and its options.
#[derive(Clone, PartialEq, Debug)]
pub struct GenerationRequest {
    /// The function.
    pub function: FunctionKind,
    /// The recursion.
    pub formulation: Formulation,
    /// All other options.
    pub options: Options,
}

impl GenerationRequest {
    /// A function in the default formulation.
    pub fn new(function: FunctionKind) -> GenerationRequest {
        GenerationRequest {
            function,
            formulation: Formulation::default(),
            options: Options::default(),
        }
    }
}

/// The maximum number of pairs of a joint and one of its ancestors or itself:
/// those of a chain of 446 joints. Each takes some 70 operations.
const PAIR_LIMIT: usize = 100_000;

/// Refuses functions of too many pairs of a joint and an ancestor.
fn within_limit(model: &Model, request: &GenerationRequest) -> Result<(), GenerateError> {
    let grows = match request.function {
        FunctionKind::Dirdyna | FunctionKind::Accelred => {
            request.formulation != Formulation::Articulated
        }
        FunctionKind::Gensensor | FunctionKind::Frame => true,
        _ if request.function.is_derived() => true,
        _ => false,
    };
    let pairs = model.pairs();
    if grows && pairs > PAIR_LIMIT {
        return Err(GenerateError::TooLarge {
            model: model.name.clone(),
            pairs,
            limit: PAIR_LIMIT,
        });
    }
    Ok(())
}

/// Generates a function of a model, at the equations level. Sensor functions
/// come as one function for each sensor (`sensor_1`).
pub fn generate(model: &Model, request: &GenerationRequest) -> Result<Module, GenerateError> {
    let mut module = Module::new();
    generate_into(&mut module, model, request)?;
    Ok(module)
}

/// The name of a function whose case was requested by a name of the model:
/// `gensensor_7` for `gensensor_hand`, if joint 7 moves the body `hand` or has
/// this name. Any other name stays.
pub fn case_name(model: &Model, function: &str) -> String {
    let (kind, case) = function.split_once('_').unwrap_or_default();
    let place = match FunctionKind::from_name(kind) {
        Some(FunctionKind::Gensensor) => {
            let body = model.bodies.iter().position(|body| body.name == case);
            let joint = model.joints.iter().position(|joint| joint.name == case);
            body.map_or(joint, |body| model.last_joint(Some(body)))
        }
        Some(FunctionKind::Sensor) => {
            let mut sensors = model.sensors.iter().chain(&model.forces);
            sensors.position(|sensor| sensor.name == case)
        }
        Some(FunctionKind::Frame) => {
            let named = model.frames.iter().position(|frame| frame.name == case);
            return named.map_or(function.to_owned(), |frame| {
                named_frame::function_name(model, frame)
            });
        }
        _ => None,
    };
    place.map_or(function.to_owned(), |place| format!("{kind}_{}", place + 1))
}

/// Does as [`generate`], for a function that was requested by name.
///
/// # Errors
///
/// See [`GenerateError`]; a function that sets nothing is one.
pub fn generate_asked(model: &Model, request: &GenerationRequest) -> Result<Module, GenerateError> {
    let module = generate(model, request)?;
    refuse_empty(model, request.function, &module.functions)?;
    Ok(module)
}

/// An error when the functions of a kind set nothing.
///
/// # Errors
///
/// [`GenerateError::Empty`].
pub fn refuse_empty(
    model: &Model,
    kind: FunctionKind,
    functions: &[Function],
) -> Result<(), GenerateError> {
    if functions
        .iter()
        .any(|function| !function.assignments.is_empty())
    {
        return Ok(());
    }
    Err(GenerateError::Empty {
        model: model.name.clone(),
        function: kind.name(),
        lacks: match kind {
            FunctionKind::Sensor => "sensors",
            FunctionKind::Frame => "frames with names, as the links of a robot have",
            FunctionKind::Link => "links",
            FunctionKind::Extforces => "external forces",
            FunctionKind::ConsHJ
            | FunctionKind::ConsJdqd
            | FunctionKind::LoopPositions
            | FunctionKind::LoopVelocities => "loops",
            FunctionKind::Invdynared => "actuators",
            _ => "moving joints",
        },
    })
}

/// Does as [`generate`], and adds the functions to a module.
pub fn generate_into(
    module: &mut Module,
    model: &Model,
    request: &GenerationRequest,
) -> Result<(), GenerateError> {
    if !model.check() {
        return Err(GenerateError::Inconsistent(model.name.clone()));
    }
    formulation::check(model, request)?;
    if request.options.quaternion {
        free_base::check(model, request)?;
    }
    within_limit(model, request)?;
    let cases = match request.function {
        FunctionKind::Sensor => model.sensors.len() + model.forces.len(),
        FunctionKind::Gensensor => model.joints.len(),
        FunctionKind::Frame => model.frames.len(),
        _ => 1,
    };
    let written: Vec<Equations> = (0..cases)
        .map(|case| write(model, request, case))
        .collect::<Result<_, _>>()?;
    // The cases of a file share their arrays.
    let extents = Extents {
        joints: model.joints.len() as u32,
        points: written.iter().map(lower::points).fold(0, u32::max),
        columns: request.options.base_columns.len() as u32,
    };
    for (case, equations) in written.iter().enumerate() {
        let function = head(model, request, case)?;
        lower::lower(equations, &extents, function, module);
    }
    debug_assert!(is_valid(module), "every generated function is valid");
    Ok(())
}

/// Writes the equations of a function, or of one case of sensors (from 0).
fn write(
    model: &Model,
    request: &GenerationRequest,
    case: usize,
) -> Result<Equations, GenerateError> {
    let options = &request.options;
    let mut written = Equations::new(EquationStyle {
        leading_signs: options.leading_signs,
    });
    let equations = &mut written;
    let frames = &ModelFrames::new(model);
    let parameters = &parameters::of(frames, request, equations);
    match request.function {
        FunctionKind::Dirdyna => {
            formulation::direct(equations, parameters, request);
            // Without masses nothing is left of M; it is an output all the same.
            if !equations.results.iter().any(|name| name == "M") {
                equations.output("M", &[1, 1], Scalar::ZERO);
            }
        }
        FunctionKind::Invdyna => formulation::inverse(equations, parameters, request),
        FunctionKind::ConsHJ => constraints::position(equations, parameters, options),
        FunctionKind::ConsJdqd => constraints::acceleration(equations, parameters, options),
        FunctionKind::Link => link::write(equations, parameters, options),
        FunctionKind::Extforces => forces::write(equations, parameters, options),
        FunctionKind::Sensor => sensor::sensor(equations, parameters, options, case),
        FunctionKind::Gensensor => sensor::frame(equations, parameters, frames.place(case)),
        FunctionKind::Accelred => formulation::accelerations(equations, parameters, request)?,
        FunctionKind::Invdynared => actuation::write(equations, parameters, request)?,
        FunctionKind::LoopPositions => closing::positions(equations, parameters, options)?,
        FunctionKind::LoopVelocities => closing::velocities(equations, parameters, options)?,
        FunctionKind::InvdynaD => derivative::inverse(equations, parameters, options),
        FunctionKind::DirdynaD => sensitivity::forward(equations, parameters, options)?,
        FunctionKind::AccelD => {
            AccelerationDerivatives::new(equations, parameters, request)?.output(equations);
        }
        FunctionKind::Linear => sensitivity::write(equations, frames, parameters, request)?,
        FunctionKind::Minv => sensitivity::inverse(equations, parameters, options)?,
        FunctionKind::Regressor => regressor::write(equations, parameters, options),
        FunctionKind::Frame => named_frame::write(equations, parameters, case),
    }
    equations.number_outputs();
    equations.close();
    Ok(written)
}

fn head(
    model: &Model,
    request: &GenerationRequest,
    case: usize,
) -> Result<Function, GenerateError> {
    let mut name = request.function.name().to_owned();
    let mut metadata = metadata(model, request);
    if matches!(
        request.function,
        FunctionKind::Sensor | FunctionKind::Gensensor
    ) {
        // Cases count from 1 as sensors and joints do.
        name = format!("{name}_{}", case + 1);
        metadata.push(("case".to_owned(), (case + 1).to_string()));
    }
    if request.function == FunctionKind::Frame {
        name = named_frame::function_name(model, case);
        metadata.push(("frame".to_owned(), model.frames[case].name.clone()));
    }
    if request.function == FunctionKind::Linear {
        let state = sensitivity::state(model, request)?;
        metadata.push(("state".to_owned(), state));
    }
    let mut function = Function::new(&name, Level::Equations);
    function.metadata = metadata;
    Ok(function)
}

/// Origin of the equations, for their readers.
fn metadata(model: &Model, request: &GenerationRequest) -> Vec<(String, String)> {
    let mut metadata = vec![
        ("model", model.name.clone()),
        (
            "generator",
            concat!("robovec ", env!("CARGO_PKG_VERSION")).to_owned(),
        ),
        ("function", request.function.number().to_owned()),
        ("kind", request.function.name().to_owned()),
        ("joints", model.joints.len().to_string()),
    ];
    if request.formulation != Formulation::Recursive {
        metadata.push(("formulation", request.formulation.name().to_owned()));
    }
    if request.options.all_parameters {
        metadata.push(("all_parameter_symbols", "yes".to_owned()));
    }
    let columns = request.options.base_columns.iter();
    let columns: Vec<String> = columns.copied().map(parameter_name).collect();
    if !columns.is_empty() && request.function == FunctionKind::Regressor {
        metadata.push(("columns", columns.join(" ")));
    }
    metadata
        .into_iter()
        .map(|(key, value)| (key.to_owned(), value))
        .collect()
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod acceleration_tests;

#[cfg(test)]
mod formulation_tests;
