//! Error of a step's results that are computed in a shorter format.
//!
//! Random positions would leave loops open, where the results mean nothing. So
//! the independent joints are drawn around the model's closed initial state,
//! and the loops are closed again, in binary64 as the step itself does.

use super::StepFunction;
use crate::generate::{GenerateError, loop_constraints};
use crate::kinematics::{InputSources, LoopClosure, MotionState, closed_states};
use robovec_error::yardstick::Yardstick;
use robovec_error::yardstick::account::ErrorAccount;
use robovec_ir::{Format, Module, View};
use robovec_model::Model;

/// States that are measured, and the seed they are drawn with.
const STATES: usize = 16;
const SEED: u64 = 1;

/// The error of the results of a step in a format, against exact results of the
/// same equations. `None` where no state was found that closes the loops, or
/// where the function reads an element that the model does not have.
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
