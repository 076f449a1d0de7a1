//! The whole step of a simulation as C that takes the place of Robotran's
//! `accelred`.
//!
//! MBsysC calls `mbs_accelred` once for every evaluation of the derivative and
//! asks for everything: the motion of driven joints, loops that are closed,
//! forces, and accelerations. Without it the library does the same with dense
//! matrices around `dirdyna` and `cons_hJ`, in which most of the time of a
//! simulation goes. What is straight-line code comes from the generator, sparse
//! as the model is, one C function each; here they are put together, with the
//! calls of the user's functions between them and Newton's method around the
//! round that closes the loops.
//!
//! **What is asked for at run time.** Which joints depend is decided when the
//! equations are made. The project decides it too, when it starts; should the
//! two differ, or should the project have constraints of its own, the function
//! says so and fails, since its result would be that of another system.

mod driver;

use crate::generate::{
    Formulation, GenerateError, GenerationRequest, Options, cuts_of_rows, generate_into,
    independent_joints,
};
use crate::model::{Model, Nature};
use crate::robotran::FunctionKind;
use robovec_codegen::c::{self, SignatureError};
use robovec_codegen::kind::{Generation, file_stem};
use robovec_ir::{Module, View};
use thiserror::Error;

/// The kind of the function that solves for accelerations: `accelred` is the
/// whole.
const SOLVED: &str = "accelerations";

/// Why the files of a step cannot be made.
#[derive(Clone, PartialEq, Eq, Error, Debug)]
pub enum WholeStepError {
    /// A part cannot be generated.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// A part has no C.
    #[error(transparent)]
    Signature(#[from] SignatureError),
}

/// The functions that a model's step consists of.
fn parts(model: &Model) -> Vec<FunctionKind> {
    let loops = [FunctionKind::LoopPositions, FunctionKind::LoopVelocities];
    let loops = loops.into_iter().filter(|_| !model.cuts.is_empty());
    loops.chain([FunctionKind::Accelred]).collect()
}

/// Generates the functions of a step into one module.
///
/// # Errors
///
/// See [`GenerateError`].
pub fn generate_parts(
    model: &Model,
    formulation: Formulation,
    options: &Options,
) -> Result<Module, GenerateError> {
    let mut module = Module::new();
    for function in parts(model) {
        let request = GenerationRequest {
            function,
            formulation,
            options: options.clone(),
        };
        generate_into(&mut module, model, &request)?;
    }
    Ok(module)
}

/// The C of a step, from its functions ([`generate_parts`], with any passes
/// run over them): names and texts of the files.
///
/// # Errors
///
/// When a function has no signature of Robotran's.
pub fn files(
    model: &Model,
    module: &Module,
    options: &c::Options,
    generation: Generation,
) -> Result<Vec<(String, String)>, WholeStepError> {
    let mut files = Vec::new();
    for function in &module.functions {
        let mut function = function.clone();
        if function.name == FunctionKind::Accelred.name() {
            SOLVED.clone_into(&mut function.name);
            function.metadata.retain(|(key, _)| key != "kind");
            function
                .metadata
                .push(("kind".to_owned(), SOLVED.to_owned()));
        }
        generation.mark(&mut function);
        let view = View {
            tables: &module.tables,
            function: &function,
        };
        files.extend(c::files(view, options)?);
    }
    let stem = file_stem(&model.name);
    let step = StepPlan::new(model, generation)?;
    files.push((
        format!("mbs_accelred_{stem}.c"),
        driver::source(&step, &stem),
    ));
    Ok(files)
}

/// What the driver of a step must know of a model.
struct StepPlan<'m> {
    model: &'m Model,
    generation: Generation,
    /// Numbers of the independent joints, from 1, ascending.
    independent: Vec<usize>,
    /// Rows of constraints, redundant ones included.
    rows: usize,
}

impl StepPlan<'_> {
    fn new(model: &Model, generation: Generation) -> Result<StepPlan<'_>, GenerateError> {
        let joints = independent_joints(model)?;
        Ok(StepPlan {
            model,
            generation,
            independent: joints.into_iter().map(|joint| joint + 1).collect(),
            rows: cuts_of_rows(model)?.len(),
        })
    }

    fn has_driven_joints(&self) -> bool {
        let mut joints = self.model.joints.iter();
        joints.any(|joint| joint.nature == Nature::Driven)
    }

    fn has_loops(&self) -> bool {
        !self.model.cuts.is_empty()
    }
}
