//! Derivatives of random equations: under the semantic check, against
//! differences of the equations themselves, and with faults planted.

use crate::equations::{Contents, equations};
use crate::mutants;
use crate::running::run as execute;
use crate::statistics::{Run, Statistics};
use arbitrary::{Result, Unstructured};
use robovec_framework::check::check_derivative;
use robovec_framework::pass::Pass;
use robovec_ir::evaluate::evaluate;
use robovec_ir::print::print_output;
use robovec_ir::states::States;
use robovec_ir::{Function, Module, Output, View, print};
use robovec_num::ball::{Ball, Balls};
use robovec_passes::registry::REGISTRY;

/// Number of runs of [`derivatives_hold`], with their inputs.
pub static STATISTICS: Statistics = Statistics::new("derivatives_hold");

const STATES: u32 = 2;
/// Larger derivatives are those near a pole.
const LARGEST: f64 = 1e9;
/// Steps of differences; their addition to the drawn numbers is exact.
const STEPS: [f64; 2] = [1.0 / (1u32 << 17) as f64, 1.0 / (1u32 << 20) as f64];
const CONTENTS: Contents = Contents {
    definitions: 12,
    divisions: true,
    hostile: false,
};

/// Passes that may come before and after.
const OTHERS: [&str; 8] = [
    "fold",
    "cse",
    "dce",
    "zero-removal",
    "factor",
    "balance",
    "fma",
    "factor-trig",
];

/// Differentiates random equations in a random way, with random passes before
/// and after. A Jacobian is compared with differences of the equations in
/// double-double, and a change of one of its operations that shows in numbers
/// must be refused.
///
/// # Panics
///
/// Panics when the check refuses a correct derivative or accepts a wrong one,
/// or when a Jacobian differs from central differences.
pub fn derivatives_hold(data: &[u8]) {
    // Bytes that run out make a smaller case, never a failure.
    let result = run(&mut Unstructured::new(data));
    STATISTICS.record(&result);
}

fn run(bytes: &mut Unstructured<'_>) -> Result<Run> {
    let seed = bytes.arbitrary()?;
    let options = options(bytes)?;
    let before = passes(bytes, "atomise")?;
    let after = passes(bytes, "")?;
    let module = equations(bytes, CONTENTS)?;
    let is_complete =
        |module: &mut Module, text: &str| execute(module, text, "ideal", seed, None).complete;
    let mut lowered = module.clone();
    if !is_complete(&mut lowered, &before) {
        return Ok(Run::default());
    }
    let mut derived = lowered.clone();
    let step = format!("differentiate{{{options}}}");
    let mut run = Run {
        operations: lowered.functions[0].nodes().len() as u64,
        passes: 1,
        ..Run::default()
    };
    if !is_complete(&mut derived, &step) {
        return Ok(run);
    }
    if options.contains("jacobian") {
        compare(&lowered, &derived, seed);
    }
    run.planted = 1;
    run.caught = u64::from(plant(bytes, &lowered, &derived, &step, seed)?);
    if !after.is_empty() && is_complete(&mut derived, &after) {
        run.passes += 1;
    }
    Ok(run)
}

fn options(bytes: &mut Unstructured<'_>) -> Result<String> {
    let of = bytes.choose(&["all", "M", "c", "c+M"])?;
    let by = bytes.choose(&["all", "q", "q+qd", "dpt+m", "In"])?;
    let mode = bytes.choose(&["mixed", "forward", "reverse"])?;
    let result = bytes.choose(&["jacobian", "jacobian", "direction", "gradient"])?;
    let values: bool = bytes.arbitrary()?;
    Ok(format!(
        "of={of} by={by} mode={mode} result={result} values={values}"
    ))
}

fn passes(bytes: &mut Unstructured<'_>, first: &str) -> Result<String> {
    let mut text = first.to_owned();
    for _ in 0..bytes.int_in_range(0..=3)? {
        if !text.is_empty() {
            text.push(',');
        }
        text.push_str(bytes.choose(&OTHERS)?);
    }
    Ok(text)
}

/// Compares every element of a Jacobian with difference quotients of two step
/// sizes; the tolerance is the distance between the two quotients.
fn compare(before: &Module, after: &Module, seed: u64) {
    let (old, new) = (&before.functions[0], &after.functions[0]);
    let view = after.tables.view(new);
    for state in 0..STATES {
        let of_old = before.tables.view(old);
        let inputs = States::new(seed).draw(of_old, state);
        let found = by_output(new, &inputs, (0, 0.0));
        for input in 0..old.input_len() {
            let column = name_of_input(of_old, input);
            let [coarse, fine] = STEPS.map(|step| slopes(old, &inputs, (input, step)));
            for (output, (coarse, fine)) in coarse.into_iter().zip(fine).enumerate() {
                let row = print_output(of_old, Output(output as u32));
                let Some(element) = element(view, &row, &column) else {
                    continue;
                };
                let computed = found[element].unwrap_or(Ball::exact([0.0]));
                let (Some([coarse, _]), Some([fine, rounding])) = (coarse, fine) else {
                    continue;
                };
                let doubt = (coarse - fine).abs() + rounding + computed.radius[0];
                let computed = computed.value.high[0];
                let allowed = 2.0 * doubt + 1e-9 * (fine.abs() + computed.abs()) + 1e-12;
                let apart = (computed - fine).abs();
                // Near poles neither says anything.
                let is_plain = fine.abs() < LARGEST && doubt <= 1e-3 * fine.abs().max(1e-6);
                assert!(
                    !is_plain || !computed.is_finite() || apart <= allowed,
                    "the derivative of {row} by {column} is {computed:e}, differences are {fine:e}, \
                     state {state} of seed {seed}, of\n{}",
                    print::print_module(before)
                );
            }
        }
    }
}

/// Central differences of all outputs by one input, each with a bound of its
/// rounding error; `None` where no bound is known.
fn slopes(
    function: &Function,
    inputs: &[f64],
    (input, step): (usize, f64),
) -> Vec<Option<[f64; 2]>> {
    let [ahead, behind] = [step, -step].map(|step| by_output(function, inputs, (input, step)));
    let pairs = ahead.into_iter().zip(behind);
    let slopes = pairs.map(|pair| {
        let (Some(ahead), Some(behind)) = pair else {
            return Some([0.0; 2]);
        };
        let rounding = ahead.radius[0] + behind.radius[0];
        let apart = ahead.value.high[0] - behind.value.high[0];
        let rest = ahead.value.low[0] - behind.value.low[0];
        let is_known = ahead.is_known(0) && behind.is_known(0);
        is_known.then_some([apart + rest, rounding].map(|number| number / (2.0 * step)))
    });
    slopes.collect()
}

/// The outputs with bounds, one input being moved; `None` for those that are
/// not set.
fn by_output(
    function: &Function,
    inputs: &[f64],
    (moved, step): (usize, f64),
) -> Vec<Option<Ball<1>>> {
    let inputs = inputs.iter().enumerate().map(|(input, &number)| {
        let step = if input == moved { step } else { 0.0 };
        Ball::exact([number + step])
    });
    let values = evaluate(function, &Balls::<1>, &inputs.collect::<Vec<_>>());
    let mut outputs = vec![None; function.output_len()];
    for (assignment, value) in function.assignments.iter().zip(values) {
        outputs[assignment.output.index()] = Some(value);
    }
    outputs
}

/// The name and place of an input, as `dpt 4`.
fn name_of_input(view: View<'_>, input: usize) -> String {
    let (array, _, _) = view.function.input_element(robovec_ir::Input(input as u32));
    let name = view.tables.symbols.text(array.name);
    format!("{name} {}", input as u32 - array.offset)
}

/// The output that holds the derivative of an element by another, if any: by
/// the names of the arrays and the manual's rules about their extents.
fn element(view: View<'_>, row: &str, column: &str) -> Option<usize> {
    let (by, place) = column.split_once(' ')?;
    let (of, indices) = row.split_once('[').unwrap_or((row, ""));
    let name = format!("{of}_{by}");
    let arrays = view.function.outputs();
    let array = arrays
        .iter()
        .find(|array| view.tables.symbols.text(array.name) == name)?;
    let indices: Vec<usize> = indices
        .trim_end_matches(']')
        .split(',')
        .filter_map(|index| index.parse().ok())
        .collect();
    let [rows, columns] = match array.shape {
        robovec_ir::Shape::Matrix(rows, columns) => [rows, columns].map(|size| size as usize),
        robovec_ir::Shape::Vector(size) => [1, size as usize],
        robovec_ir::Shape::Scalar => [1, 1],
    };
    let row = match indices.as_slice() {
        // Only square matrices and vectors are outputs here.
        [i, j] => (i - 1) * rows.isqrt() + j - 1,
        [i] => i - 1,
        _ => 0,
    };
    Some(array.offset as usize + row * columns + place.parse::<usize>().ok()?)
}

/// Changes one operation of a derivative; returns whether the change was
/// visible and was refused.
fn plant(
    bytes: &mut Unstructured<'_>,
    before: &Module,
    after: &Module,
    step: &str,
    seed: u64,
) -> Result<bool> {
    let new = &after.functions[0];
    if new.nodes().is_empty() {
        return Ok(false);
    }
    let wrong = mutants::mutate(bytes, new)?;
    if !mutants::differ(&after.tables, new, &wrong, seed) {
        return Ok(false);
    }
    let pipeline = REGISTRY.pipeline(step).expect("made of known passes");
    let pass = pipeline.passes().next().expect("it has one pass");
    let pass: Box<dyn Pass> = (pass.info.build)(&pass.options).expect("options were read");
    let differentiation = pass.differentiation().expect("it differentiates");
    let verdict = check_derivative(
        before.tables.view(&before.functions[0]),
        after.tables.view(&wrong),
        &differentiation,
        &States::new(seed),
        3,
    );
    assert!(
        !verdict.holds(),
        "a wrong derivative passed, seed {seed}:\n{}\nbecame\n{}",
        print::print_module(before),
        print::print_function(after.tables.view(&wrong))
    );
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn derivatives_of_random_programs_hold() {
        let mut ran = 0;
        let mut caught = 0;
        cases::of_sizes(400, 3000, |bytes| {
            let run = run(bytes)?;
            ran += 1;
            caught += run.caught;
            Ok(())
        });
        assert!(ran >= 200, "only {ran} programs were large enough");
        assert!(caught >= 50, "only {caught} faults were planted");
    }
}
