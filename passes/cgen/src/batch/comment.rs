//! The comments of generated files about themselves.

use super::writer::BatchWriter;
use crate::emit::frame;
use std::fmt::Write;

/// The head of the source.
pub(super) fn source(writer: &BatchWriter<'_>) -> String {
    format!(
        "/* {} for batches of {} states by robovec. Compile with -O3 and for the processor at\n   \
         hand (-march=native), with -fopenmp to use its cores. */\n",
        writer.names.function, writer.options.lanes
    )
}

/// The head of the header: the contract.
pub(super) fn header(writer: &BatchWriter<'_>) -> String {
    let name = &writer.names.function;
    let mut text = format!(
        "/* {name} for batches of {lanes} states by robovec.

   Arrays of runs, for {name}_batch and {name}_many: every element has {lanes} numbers one
   behind the other, one for each state of a batch, and batches follow each other.
   Element e of array A of state s is
       A[(s / {lanes} * {name}_SIZE_A + e) * {lanes} + s % {lanes}].
   Arrays of states, for {name}_states: A[s * {name}_SIZE_A + e].
   Elements count from 1: e is i for A[i] and i * (columns + 1) + j for A[i][j]; what has an
   index 0 is not used. A scalar has e = 0. Arrays need no alignment; runs that begin at
   multiples of their length in bytes are fastest. Arrays may not overlap.
",
        lanes = writer.options.lanes,
    );
    let shared: Vec<&str> = (writer.names.inputs.iter().zip(&writer.plan.shared))
        .filter(|(_, shared)| **shared)
        .map(|(name, _)| name.as_str())
        .collect();
    if shared.is_empty() {
        let _ = write!(
            text,
            "\n   {name}_prepare fills numbers that are the same for all states, once.\n"
        );
    } else {
        let _ = write!(
            text,
            "\n   The same for all states, one number per element: {}.
   {name}_prepare computes what depends on nothing else, once; _many and _states call it.\n",
            shared.join(", ")
        );
    }
    text += &frame::boundaries(writer.function());
    text + "\n   _many and _states return 0, or -1 when there is no memory. */\n"
}
