//! Bounds hold and predictions are right for random equations in random
//! formats.

use crate::equations::{Contents, equations};
use crate::statistics::{Run, Statistics};
use arbitrary::{Result, Unstructured};
use robovec_analysis::adjoint::{self, OutputError, Tape};
use robovec_ir::states::States;
use robovec_ir::{Format, print};

/// Number of runs of [`errors_are_predicted`], with their inputs.
pub static STATISTICS: Statistics = Statistics::new("errors_are_predicted");

const STATES: u32 = 3;
const FORMATS: [&str; 8] = [
    "f32",
    "f16",
    "bf16",
    "float(8,17)",
    "float(11,30)",
    "float(8,23,flush)",
    "fixed(14,20)",
    "fixed(6,9)",
];
/// Sizes beyond which the double-double reference has no digits to spare.
const SIZES: std::ops::Range<f64> = 1e-60..1e60;
const CONTENTS: Contents = Contents {
    definitions: 25,
    divisions: true,
    hostile: false,
};

/// Runs random equations in a random format and compares the actual error of
/// every output with its bound and its prediction.
///
/// # Panics
///
/// Panics when an error is larger than its bound, or differs from the
/// prediction.
pub fn errors_are_predicted(data: &[u8]) {
    let result = run(&mut Unstructured::new(data));
    STATISTICS.record(&result);
}

fn run(bytes: &mut Unstructured<'_>) -> Result<Run> {
    let format: Format = bytes.choose(&FORMATS)?.parse().expect("it is one");
    let seed = bytes.arbitrary()?;
    let module = equations(bytes, CONTENTS)?;
    let view = module.tables.view(&module.functions[0]);
    let tape = Tape::new(view.function);
    let outputs: Vec<usize> = (0..tape.outputs()).collect();
    for state in 0..STATES {
        let inputs = States::new(seed).draw(view, state);
        let run = adjoint::AdjointRun::of(view.function, &tape, format, &inputs);
        let usual = |value: &f64| *value == 0.0 || SIZES.contains(&value.abs());
        if !run.exact().iter().all(usual) {
            continue;
        }
        for (place, error) in run.outputs(&outputs).iter().enumerate() {
            if let Err(reason) = judge(error) {
                panic!(
                    "{format}, seed {seed}, state {state}, output {place}: {reason}: {error:?}\non {}",
                    print::print_module(&module)
                );
            }
        }
    }
    Ok(Run {
        operations: view.function.nodes().len() as u64,
        ..Run::default()
    })
}

fn judge(error: &OutputError) -> std::result::Result<(), &'static str> {
    // What is left when the format loses nothing is the reference's own.
    let least = 1e-25 * error.exact.abs();
    if error.actual.abs() > error.bound + least {
        return Err("the error is larger than its bound");
    }
    let miss = (error.predicted - error.actual).abs();
    if error.bound.is_finite() && miss > 1e-6 * error.bound + least {
        return Err("the error is not what was predicted");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn errors_of_random_equations_are_bounded_and_predicted() {
        cases::of_one_size(300, 4000, |bytes| {
            let result = run(bytes);
            STATISTICS.record(&result);
            result.map(|_| ())
        });
        eprintln!("{STATISTICS}");
        assert!(STATISTICS.valid() > 250, "{STATISTICS}");
    }
}
