//! Random pipelines keep random equations, and their errors stay within the
//! bound of [`robovec_analysis::error_bound`].

use crate::equations::{Contents, equations};
use crate::passes;
use crate::running::run as execute;
use crate::statistics::{Run, Statistics};
use arbitrary::{Result, Unstructured};
use robovec_analysis::class::NumericClass;
use robovec_analysis::error_bound::{Binary32Bound, Bounded};
use robovec_framework::manager::Limit;
use robovec_framework::pipeline::Pipeline;
use robovec_ir::evaluate::{evaluate, evaluate_nodes, outputs};
use robovec_ir::states::States;
use robovec_ir::{Function, Module, print};
use robovec_num::arithmetic::Binary32;
use robovec_num::double_double::DoubleDouble;
use robovec_passes::registry::REGISTRY;

/// Number of runs of [`errors_stay_within_bounds`], with their inputs.
pub static STATISTICS: Statistics = Statistics::new("errors_stay_within_bounds");

const STATES: u32 = 3;
/// Magnitudes beyond this are near an overflow, or meet an underflow.
const LARGEST: f64 = 1e15;
const CONTENTS: Contents = Contents {
    definitions: 20,
    divisions: true,
    hostile: false,
};

/// Runs a random pipeline over random equations under the verifier and the
/// semantic check, stops it after a random number of rewrites as well, and
/// compares errors with bounds.
///
/// # Panics
///
/// Panics when a pass changes the function, with all of its rewrites or with
/// the first ones; when the result in binary32 is farther from the exact result
/// of the equations than the bound; or when a pass that is *real* brings in
/// cancellations.
pub fn errors_stay_within_bounds(data: &[u8]) {
    // Bytes that run out make a smaller case, never a failure.
    let result = run(&mut Unstructured::new(data));
    STATISTICS.record(&result);
}

fn run(bytes: &mut Unstructured<'_>) -> Result<Run> {
    let text = passes::pipeline(bytes, 5)?;
    let seed = bytes.arbitrary()?;
    let share: u8 = bytes.arbitrary()?;
    let before = equations(bytes, CONTENTS)?;
    let mut after = before.clone();
    let executed = execute(&mut after, &text, "ideal", seed, None).executed;
    let last = executed.last().map_or(0, |pass| pass.rewrites);
    let rewrites = executed.iter().map(|pass| pass.rewrites).sum();
    // The first rewrites alone are right too.
    let limit = Limit {
        passes: executed.len() as u64,
        rewrites: Some(last * u64::from(share) / 255),
    };
    execute(&mut before.clone(), &text, "ideal", seed, Some(limit));
    let pipeline = REGISTRY.pipeline(&text).expect("made of known passes");
    compare(&before, &after, &pipeline, seed);
    Ok(Run {
        operations: before.functions[0].nodes().len() as u64,
        passes: executed.len() as u64,
        rewrites,
        ..Run::default()
    })
}

fn compare(before: &Module, after: &Module, pipeline: &Pipeline, seed: u64) {
    let class = pipeline.passes().map(|pass| pass.info.class).max();
    let class = class.unwrap_or(NumericClass::Exact);
    if class == NumericClass::Approximating {
        return;
    }
    let (tables, old) = (&before.tables, &before.functions[0]);
    let new = &after.functions[0];
    // Arrays that nothing reads may have gone; states are those of both.
    if old.input_len() != new.input_len() || old.assignments.len() != new.assignments.len() {
        return;
    }
    for state in 0..STATES {
        let view = tables.view(old);
        let inputs = States::new(seed).draw(view, state);
        let Some(found) = Found::new(old, new, &inputs) else {
            continue;
        };
        for place in 0..old.assignments.len() {
            if let Err(reason) = found.judge(place, class) {
                panic!(
                    "{pipeline}, seed {seed}, state {state}, output {place}: {reason}\non {}\nto {}",
                    print::print_module(before),
                    print::print_module(after),
                );
            }
        }
    }
}

/// All outputs at one state.
struct Found {
    exact: Vec<f64>,
    rounded: Vec<f32>,
    bounds_before: Vec<Bounded>,
    bounds_after: Vec<Bounded>,
}

impl Found {
    /// `None` where numbers approach the limits of binary32.
    fn new(old: &Function, new: &Function, inputs: &[f64]) -> Option<Found> {
        let wide: Vec<_> = inputs.iter().map(|&number| number.into()).collect();
        let narrow: Vec<f32> = inputs.iter().map(|&number| number as f32).collect();
        let bounded: Vec<Bounded> = inputs
            .iter()
            .map(|&number| Bounded::exact(number))
            .collect();
        let values = evaluate_nodes(new, &Binary32Bound, &bounded);
        if values.iter().any(|value| value.magnitude > LARGEST) {
            return None;
        }
        Some(Found {
            exact: evaluate(old, &DoubleDouble, &wide)
                .into_iter()
                .map(|number| number.high)
                .collect(),
            rounded: evaluate(new, &Binary32, &narrow),
            bounds_before: evaluate(old, &Binary32Bound, &bounded),
            bounds_after: outputs(new, &Binary32Bound, &bounded, &values),
        })
    }

    fn judge(&self, place: usize, class: NumericClass) -> std::result::Result<(), String> {
        let (before, after) = (self.bounds_before[place], self.bounds_after[place]);
        let exact = self.exact[place];
        if !before.bound().is_finite() || !after.bound().is_finite() {
            return Ok(());
        }
        // Above what can underflow on the way.
        let slack = 1e-9 * after.magnitude.max(before.magnitude) + 1e-30;
        if class <= NumericClass::Real && after.magnitude > before.magnitude + slack {
            return Err(format!(
                "the magnitude grew from {:e} to {:e}: terms that cancel were brought in",
                before.magnitude, after.magnitude
            ));
        }
        let magnitude = match class {
            NumericClass::Exact | NumericClass::Real => before.magnitude,
            NumericClass::RealTrig | NumericClass::Approximating => after.magnitude,
        };
        let error = (f64::from(self.rounded[place]) - exact).abs();
        let bound = after.bound_for(magnitude) + slack;
        if error > bound {
            return Err(format!(
                "the error is {error:e}, over {bound:e}, at {} roundings",
                after.roundings
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn random_pipelines_keep_equations_and_their_errors() {
        cases::on_all_cores(150, 6000, |bytes| {
            let result = run(bytes);
            STATISTICS.record(&result);
            result.map(|_| ())
        });
        eprintln!("{STATISTICS}");
        assert!(STATISTICS.valid() > 120, "{STATISTICS}");
        assert!(STATISTICS.rewrites() > 10_000, "{STATISTICS}");
    }
}
