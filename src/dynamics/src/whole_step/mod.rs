//! The whole step of a simulation as C, `accelred`, and as `invdynared`.
//!
//! MBsysC calls `mbs_accelred` once for every evaluation of the derivative, for
//! all quantities: the motion of driven joints, loops that are closed,
//! constraints of the user, forces, and accelerations. Without it the library
//! does the same with dense matrices around `dirdyna` and `cons_hJ`, which
//! takes most of the time of a simulation. The straight-line parts come from
//! the generator, sparse as the model is, one C function each; here they are
//! combined, with the calls of the user's functions between them and Newton's
//! method around the function that closes the loops.
//!
//! **Numbers.** Accelerations and forces of actuators can be computed in
//! binary32; the project's arrays and the closing of loops stay binary64: the
//! residual of Newton's method is below every tolerance of a project only in
//! binary64, and it consists of differences of nearly equal positions.
//!
//! **Choices at run time.** The dependent joints are chosen when the equations
//! are made. The project decides it too, when it starts; should the two differ,
//! the function reports it and fails, since its result would be that of another
//! system. It also fails where masses and constraints determine no motion.

mod driver;

use crate::generate::{
    Formulation, GenerateError, GenerationRequest, Options, cuts_of_rows, generate_into,
    independent_joints, loop_constraints, massless,
};
use crate::kinematics::{InputSources, LoopClosure, MotionState, closed_states};
use robovec_cgen::c::{self, Real, SignatureError};
use robovec_cgen::kind::{Generation, file_stem};
use robovec_error::yardstick::Yardstick;
use robovec_error::yardstick::account::ErrorAccount;
use robovec_ir::{Format, Function, Module, View};
use robovec_model::Model;
use robovec_robotran::FunctionKind;
use thiserror::Error;

/// A function of MBsysC that does a whole step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StepFunction {
    /// `accelred`: accelerations from forces.
    Accelerations,
    /// `invdynared`: forces of actuators from accelerations.
    ActuatorForces,
}

impl StepFunction {
    /// Robotran's name.
    pub fn name(self) -> &'static str {
        self.kind().name()
    }

    /// Kind of the generated part beside the closing of loops.
    fn kind(self) -> FunctionKind {
        match self {
            StepFunction::Accelerations => FunctionKind::Accelred,
            StepFunction::ActuatorForces => FunctionKind::Invdynared,
        }
    }

    /// The kind of the C function that this is: Robotran's name is the whole's.
    fn part(self) -> &'static str {
        match self {
            StepFunction::Accelerations => "accelerations",
            StepFunction::ActuatorForces => "actuator_forces",
        }
    }
}

/// Reason why the files of a step cannot be made.
#[derive(Clone, PartialEq, Eq, Error, Debug)]
pub enum WholeStepError {
    /// A part cannot be generated.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// A part has no C.
    #[error(transparent)]
    Signature(#[from] SignatureError),
}

fn parts(model: &Model, steps: &[StepFunction], options: &Options) -> Vec<FunctionKind> {
    let loops = [FunctionKind::LoopPositions, FunctionKind::LoopVelocities];
    let is_bound = !model.cuts.is_empty() || options.user_constraints > 0;
    let loops = loops.into_iter().filter(|_| is_bound);
    let steps = steps.iter().map(|step| step.kind());
    loops.chain(steps).collect()
}

/// Generates the functions of some steps into one module.
pub fn generate_parts(
    model: &Model,
    steps: &[StepFunction],
    formulation: Formulation,
    options: &Options,
) -> Result<Module, GenerateError> {
    let mut module = Module::new();
    for function in parts(model, steps, options) {
        let request = GenerationRequest {
            function,
            formulation,
            options: Options {
                growth: options.user_constraints > 0,
                ..options.clone()
            },
        };
        generate_into(&mut module, model, &request)?;
    }
    Ok(module)
}

/// Style of the files of a step.
pub struct StepStyle<'a> {
    /// Options of the equations as C.
    pub c: &'a c::Options,
    /// The generator whose names the C uses.
    pub generation: Generation,
    /// Options that the functions were generated with.
    pub options: &'a Options,
}

/// The C of steps, one self-contained file each, so that no build needs new
/// rules, from their functions ([`generate_parts`], after any passes): names
/// and texts of the files. Loops are closed in binary64 for every style.
///
/// # Errors
///
/// Fails when a function has no signature of Robotran's.
pub fn files(
    model: &Model,
    steps: &[StepFunction],
    module: &Module,
    style: &StepStyle<'_>,
) -> Result<Vec<(String, String)>, WholeStepError> {
    let stem = file_stem(&model.name);
    let plan = StepPlan::new(model, style)?;
    let file = |&step: &StepFunction| {
        let others = |name: &str| {
            steps
                .iter()
                .any(|other| *other != step && other.name() == name)
        };
        let own = module.functions.iter().filter(|own| !others(&own.name));
        let parts: Result<String, _> = own.map(|part| source(module, part, step, style)).collect();
        Ok((
            format!("mbs_{}_{stem}.c", step.name()),
            driver::source(&plan, step, &parts?),
        ))
    };
    steps.iter().map(file).collect()
}

/// The C of a generated function, local to the file of a step.
fn source(
    module: &Module,
    function: &Function,
    step: StepFunction,
    style: &StepStyle<'_>,
) -> Result<String, SignatureError> {
    let mut function = function.clone();
    let mut options = c::Options {
        is_local: true,
        ..style.c.clone()
    };
    if step.name() == function.name {
        step.part().clone_into(&mut function.name);
        function.metadata.retain(|(key, _)| key != "kind");
        let kind = ("kind".to_owned(), step.part().to_owned());
        function.metadata.push(kind);
    } else {
        options.real = Real::Double;
    }
    style.generation.mark(&mut function);
    let view = View {
        tables: &module.tables,
        function: &function,
    };
    let [(_, source), _header] = c::files(view, &options)?;
    Ok(source)
}

/// Facts about a model that the driver of a step needs.
struct StepPlan<'m> {
    model: &'m Model,
    generation: Generation,
    /// The independent joints, from 0, ascending.
    independent: Vec<usize>,
    /// The cut of each row of the loops, redundant ones included.
    rows: Vec<usize>,
    user_rows: usize,
    /// Joints that get their accelerations from rows of the user, from 0.
    massless: Vec<usize>,
    /// The arithmetic of accelerations is binary64.
    is_double: bool,
    /// True to compute the multipliers and the forces of driven joints.
    multipliers: bool,
}

impl StepPlan<'_> {
    fn new<'m>(model: &'m Model, style: &StepStyle<'_>) -> Result<StepPlan<'m>, GenerateError> {
        let independent = independent_joints(model, style.options)?;
        assert!(independent.is_sorted(), "joints ascend");
        Ok(StepPlan {
            model,
            generation: style.generation,
            independent,
            rows: cuts_of_rows(model)?,
            massless: match style.options.user_constraints {
                0 => Vec::new(),
                _ => massless(model, style.options)?,
            },
            is_double: style.c.real == Real::Double,
            user_rows: style.options.user_constraints,
            multipliers: style.options.multipliers,
        })
    }
}

/// States that are measured, and the seed they are drawn with.
const STATES: usize = 16;
const SEED: u64 = 1;

/// The error of the results of a step in a format, against exact results of the
/// same equations. `None` where no state was found that closes the loops, or
/// where the function reads an element that the model does not have.
///
/// Random positions would leave loops open, where the results mean nothing. So
/// the independent joints are drawn around the model's closed initial state,
/// and the loops are closed again, in binary64 as the step itself does.
///
/// # Errors
///
/// Fails when the constraints of the loops cannot be generated.
pub fn step_error(
    model: &Model,
    step: StepFunction,
    module: &Module,
    format: Format,
) -> Result<Option<ErrorAccount>, GenerateError> {
    let name = step.name();
    let function = module
        .functions
        .iter()
        .find(|function| function.name == name);
    let Some(function) = function else {
        return Ok(None);
    };
    let view = View {
        tables: &module.tables,
        function,
    };
    let states = states(model)?;
    let Some(sources) = InputSources::new(model, view)
        .ok()
        .filter(|_| !states.is_empty())
    else {
        return Ok(None);
    };
    let told = format!(
        "{} random states around the closed initial one, seed {SEED}",
        states.len()
    );
    let states = states.iter().map(|state| sources.gather(state));
    let yardstick = Yardstick::at(view, states.collect());
    Ok(ErrorAccount::measured(view, &yardstick, format, told).ok())
}

/// States with closed loops, and random forces.
fn states(model: &Model) -> Result<Vec<MotionState>, GenerateError> {
    let constraints = loop_constraints(model)?;
    let loops = LoopClosure {
        model,
        constraints: &constraints,
    };
    Ok(closed_states(&loops, STATES, SEED))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Formulation, Options};
    use crate::whole_step::generate_parts;
    use robovec_model::family::ModelFamily;

    /// Exact arithmetic is far better than binary32, which rounds at 6e-8; and
    /// loops are closed wherever it is measured.
    #[test]
    fn errors_are_those_of_the_format() {
        for name in ["four-bar", "quarter-car", "double-pendulum"] {
            let model = ModelFamily::from_name(name).expect("a family").build(0, 1);
            let formulation = Formulation::default();
            let step = StepFunction::Accelerations;
            let module = generate_parts(&model, &[step], formulation, &Options::default());
            let module = module.expect("it has all functions");
            let worst = |format: Format| {
                let account = step_error(&model, step, &module, format);
                let account = account.expect("the loops have constraints");
                let account = account.expect("there are closed states");
                assert!(account.states.starts_with("16 "), "{}", account.states);
                account.normwise.worst
            };
            let [single, double] = [Format::BINARY32, Format::BINARY64].map(worst);
            assert!(single > 1e-9 && single < 1e-4, "{name}: {single:e}");
            assert!(double < 1e-12 && double > 0.0, "{name}: {double:e}");
        }
    }

    #[test]
    fn states_close_the_loops() {
        let model = ModelFamily::from_name("four-bar")
            .expect("a family")
            .build(0, 1);
        let states = states(&model).expect("it has constraints");
        let constraints = loop_constraints(&model).expect("it has constraints");
        for state in &states {
            let (gaps, _) = constraints.evaluate(state);
            assert!(gaps.iter().all(|gap| gap.abs() < 1e-12), "{gaps:?}");
        }
        assert!(states[0].q != states[1].q);
    }
}
