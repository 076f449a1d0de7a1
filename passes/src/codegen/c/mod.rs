//! C99 for a processor.
//!
//! One function per function of the module, with the arrays as parameters
//! that count from 1 as in Robotran (`q[1]` is the first element, `q[0]` is
//! never touched). Every operation stands in the order and grouping of the
//! representation, so that the result equals the evaluator's bit for bit when
//! the C compiler does not contract (`-ffp-contract=off`) and computes in the
//! type it is told to (`FLT_EVAL_METHOD` 0, as on every 64-bit processor).
//!
//! Outputs are written after everything is computed. Long bodies are split
//! into parts of some hundred operations, because the time compilers take
//! grows faster than the length of a function; values that cross from part to
//! part travel in a work array whose words are reused.

mod names;
mod parts;
mod text;

use parts::Plan;
use robovec_ir::View;
use text::Writer;

/// The type that a C function computes in.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Real {
    /// IEEE binary64.
    #[default]
    Double,
    /// IEEE binary32; sine and cosine are those of binary64, rounded once.
    Float,
}

impl Real {
    /// The name of the type in C.
    pub fn name(self) -> &'static str {
        match self {
            Real::Double => "double",
            Real::Float => "float",
        }
    }
}

/// The C source of a function and the header that declares it, in this order,
/// as (file name, text). Takes a function of any level; schedules and
/// placements play no part.
pub fn c_files(view: View<'_>, real: Real) -> [(String, String); 2] {
    let plan = Plan::new(view.function);
    let writer = Writer::new(view, real, &plan);
    let name = writer.function_name().to_owned();
    let header = writer.header();
    [
        (format!("{name}.c"), writer.source()),
        (format!("{name}.h"), header),
    ]
}
