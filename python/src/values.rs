//! Functions at many states, on several threads.

use crate::Error;
use pyo3::PyErr;
use rayon::prelude::*;
use robovec_ir::evaluate::evaluate_mixed;
use robovec_ir::{Format, Function};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::limits::{Amount, NumberLimit};
use robovec_num::soft_float::FormatArithmetic;

const BYTES: usize = size_of::<f64>();

/// Number of threads; 0 is the number of processors.
const THREADS: NumberLimit = NumberLimit::whole(0, 1024, "every thread takes memory");

/// The outputs at consecutive states, as bytes of binary64 in the order of this
/// machine. Every state is computed alone, so results do not depend on the
/// number of threads (0: as many as there are processors).
pub(crate) fn evaluate_states(
    function: &Function,
    inputs: &[u8],
    format: Format,
    threads: usize,
) -> Result<Vec<u8>, PyErr> {
    let amount = Amount::Whole(threads as u64);
    THREADS
        .check(amount)
        .map_err(|reason| Error::new_err(format!("threads: {reason}")))?;
    let width = function.input_len() * BYTES;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Error::new_err(format!("cannot start threads: {error}")))?;
    let arithmetic = FormatArithmetic::new(format);
    let states: Vec<&[u8]> = match width {
        0 => vec![&[]],
        width => inputs.chunks_exact(width).collect(),
    };
    let rows: Vec<Vec<u8>> = pool.install(|| {
        let rows = states.par_iter();
        rows.map(|state| one_state(function, &arithmetic, state))
            .collect()
    });
    Ok(rows.concat())
}

fn one_state(function: &Function, arithmetic: &FormatArithmetic, state: &[u8]) -> Vec<u8> {
    let numbers = state.as_chunks::<BYTES>().0.iter();
    let inputs = numbers.map(|number| arithmetic.literal(f64::from_ne_bytes(*number)));
    let inputs: Vec<f64> = inputs.collect();
    let results = evaluate_mixed(function, arithmetic.format(), &inputs);
    let mut outputs = vec![0.0; function.output_len()];
    for (assignment, result) in function.assignments.iter().zip(results) {
        outputs[assignment.output.index()] = result;
    }
    outputs
        .iter()
        .flat_map(|output| output.to_ne_bytes())
        .collect()
}
