//! C that evaluates a function for many states at once.
//!
//! Every operation computes a vector of `lanes` states, in the vector
//! extensions that gcc and clang share; without them the same text computes
//! lane by lane. `docs/c-batch.md` is the contract with the caller: the layout
//! of all numbers, and the names of the functions.
//!
//! The speed of such code depends on the places of values, so:
//!
//! * operations are in an order with few live values
//!   ([`crate::emit::order`]);
//! * they are in functions of bounded length ([`plan`]), since compilers
//!   take quadratic time for long ones; values that cross from one to the
//!   next are in a work array whose words are reused;
//! * inputs, sines and cosines are read where they are used and never kept;
//! * values that depend on shared parameters only are computed once for all
//!   states ([`prepared`]) and read as one number for all lanes;
//! * sines and cosines of all angles are computed in one loop
//!   ([`crate::sincos`]).
//!
//! Only the order of operations differs from the function: results equal the
//! evaluator's except for sines, cosines and operations that the compiler
//! contracts.

mod driver;
mod names;
mod plan;
mod prepared;
mod shared;
mod text;
mod writer;

use super::emit::Real;
use robovec_ir::View;

/// Arrays that hold parameters of a model, in Robotran's names: places of
/// points, centres of mass, masses, inertias and gravity.
pub const PARAMETERS: [&str; 5] = ["dpt", "l", "m", "In", "g"];

/// The numbers of states a vector can hold.
pub const LANES: [u32; 4] = [1, 4, 8, 16];

/// The options of batch code.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Options {
    /// The type it computes in.
    pub real: Real,
    /// States of a vector: one of [`LANES`].
    pub lanes: u32,
    /// Names of input arrays that are the same for all states.
    pub shared: Vec<String>,
    /// Operations per function.
    pub part: u32,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            real: Real::Double,
            lanes: 8,
            shared: PARAMETERS.map(str::to_owned).to_vec(),
            part: 500,
        }
    }
}

/// The C source of a function for batches of states and the header that
/// declares it, in this order, as (file name, text). Takes a function of any
/// level; schedules and placements play no part.
///
/// For a function `F` the files are `F_batch.c` and `F_batch.h` and define
///
/// * `void F_prepare(shared inputs, real *prepared)`: the values that depend on
///   shared inputs only, `F_PREPARED` numbers;
/// * `void F_batch(other inputs, const real *prepared, outputs)`: `F_LANES`
///   states in arrays of runs;
/// * `int F_many(long states, inputs, outputs)`: any number of states in
///   arrays of runs, in parallel under OpenMP; 0, or -1 without memory;
/// * `int F_states(long states, inputs, outputs)`: the same for arrays of
///   one state after the other.
///
/// Arrays come in order of declaration. In arrays of runs an element has
/// `F_LANES` numbers, one for each state: that of state `s` in an array
/// counted from 1 as in Robotran is `(s / F_LANES * F_SIZE_array + element) *
/// F_LANES + s % F_LANES`, `element` being `i` or `i * (columns + 1) + j`.
pub fn batch_files(view: View<'_>, options: &Options) -> [(String, String); 2] {
    let mut plan = plan::BatchPlan::new(view, options);
    let prepared = prepared::Prepared::new(view.function, &mut plan, options.part);
    let writer = writer::BatchWriter::new(view, options, &plan, &prepared);
    let name = writer.names.function.clone();
    [
        (format!("{name}_batch.c"), writer.source()),
        (format!("{name}_batch.h"), writer.header()),
    ]
}

#[cfg(test)]
mod tests;
