//! C99 for a processor.
//!
//! Two signatures ([`Signature`]). The plain one has the arrays of the
//! function as parameters; Robotran's has the names, types and order of
//! parameters of the file it replaces ([`crate::kind`]), so that a
//! project of MBsysC is built with one file exchanged. In both, arrays count
//! from 1 (`q[1]` is the first element, `q[0]` is never touched), unless a
//! [`Layout`] from 0 is requested.
//!
//! Every operation is in the grouping of the representation, so that the
//! result equals the evaluator's bit for bit when the C compiler does not
//! contract (`-ffp-contract=off`), computes in the type it is given
//! (`FLT_EVAL_METHOD` 0, as on every 64-bit processor) and sines are the
//! library's ([`Sines::Library`]).
//!
//! **Length.** Bodies are split into parts of some hundred operations
//! ([`parts`]), because the time compilers take grows faster than the length
//! of a function; values that cross from part to part travel in a work array
//! whose words are reused.
//!
//! **Order.** The delays of a processor in straight-line code are due to values
//! that have left its registers. Statements are in an order in which values are
//! read soon after they are made ([`super::emit::order`]), and each output is
//! written where its value is known, unless writing it could change an input.
//!
//! **Sines.** All sines and cosines of angles that need no other sine are
//! computed at the head in one loop that compilers turn into vector
//! instructions ([`sines`]).
//!
//! **Superwords.** On request, operations that repeat in the sides of a
//! mechanism are computed as vectors of gcc and clang ([`crate::superword`]).

mod interface;
pub mod layout;
mod parts;
mod pattern;
mod sines;
mod text;
mod trial;
mod vectors;

pub use super::emit::Real;
pub use interface::SignatureError;
pub use layout::{ElementOrder, Layout, OutputLayout};
pub use trial::{TrialState, minimal_data, trial_main};

use crate::superword::SuperwordLanes;
use interface::Interface;
use layout::OutputLayouts;
use parts::CodePlan;
use robovec_analysis::slice::live;
use robovec_framework::option_words;
use robovec_ir::{Array, Assignment, Function, Name, Node, Operand, Operation, View};
use sines::Slots;
use std::borrow::Cow;
use text::PlainWriter;

option_words! {
    /// The signature of a C function.
    pub enum Signature {
        /// As Robotran's function of the same name.
        Robotran = "robotran",
        /// The arrays as parameters, inputs before outputs.
        Plain = "plain",
    }
}

option_words! {
    /// The place where sines and cosines are computed.
    pub enum Sines {
        /// A loop in the generated file, for all angles at once; errors stay
        /// below 1.1 units in the last place.
        Inline = "inline",
        /// The C library, one by one.
        Library = "library",
    }
}

option_words! {
    /// The order of statements.
    pub enum StatementOrder {
        /// Each value shortly before it is read.
        Depth = "depth",
        /// As in the function.
        Program = "program",
    }
}

/// The options of C code.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Options {
    /// The signature of the function.
    pub signature: Signature,
    /// The type it computes in; Robotran's arrays are `double` in any case.
    pub real: Real,
    /// The place where sines and cosines are computed.
    pub sines: Sines,
    /// The order of statements.
    pub order: StatementOrder,
    /// Operations per part.
    pub part: u32,
    /// The function is for the file alone that it is in (`static`).
    pub is_local: bool,
    /// The arrangement of arrays in the plain signature.
    pub layout: Layout,
    /// The number of operations of equal structure that one vector computes.
    pub superwords: SuperwordLanes,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            signature: Signature::Robotran,
            real: Real::Double,
            sines: Sines::Inline,
            order: StatementOrder::Depth,
            part: 500,
            is_local: false,
            layout: Layout::FromOne,
            superwords: SuperwordLanes::None,
        }
    }
}

impl Options {
    /// Plain C whose results are the evaluator's, bit for bit.
    pub fn plain(real: Real) -> Options {
        Options {
            signature: Signature::Plain,
            real,
            sines: Sines::Library,
            order: StatementOrder::Program,
            ..Options::default()
        }
    }
}

/// The C source of a function and the header that declares it, in this order,
/// as (file name, text). Takes a function of any level; schedules and
/// placements play no part.
///
/// # Errors
///
/// Fails when the function has no signature of Robotran's and one is requested.
pub fn files(view: View<'_>, options: &Options) -> Result<[(String, String); 2], SignatureError> {
    let kept = kept(view.function);
    let view = View {
        function: &kept,
        ..view
    };
    let interface = Interface::new(view, options)?;
    let written = interface.written(view.function);
    let view = View {
        function: &written,
        ..view
    };
    let plan = CodePlan::new(view.function, options, interface.overwrites());
    let writer = PlainWriter::new(view, options, &interface, &plan);
    let name = interface.file().to_owned();
    Ok([
        (format!("{name}.c"), writer.source()),
        (format!("{name}.h"), writer.header()),
    ])
}

/// The function, with a copy for every output that is an input: where both
/// share one array, an earlier output may overwrite the input.
fn kept(function: &Function) -> Cow<'_, Function> {
    let shares = |array: &Array| {
        function
            .outputs()
            .iter()
            .any(|output| output.name == array.name)
    };
    if !function.inputs().iter().any(shares) {
        return Cow::Borrowed(function);
    }
    let mut kept = function.clone();
    for index in 0..kept.assignments.len() {
        let Assignment {
            operand, sources, ..
        } = kept.assignments[index];
        if operand.input().is_some() {
            let copy = kept.push(Node {
                name: Name::NONE,
                sources,
                operands: Operand::list([operand]),
                operation: Operation::Copy,
            });
            kept.assignments[index].operand = copy.into();
        }
    }
    Cow::Owned(kept)
}

/// The arrangement of every output array of a function that counts from 0.
pub fn output_layouts(
    function: &Function,
    order: ElementOrder,
    is_sparse: bool,
) -> Vec<OutputLayout> {
    OutputLayouts::new(function, order, is_sparse).arrays
}

/// The number of operations on vectors of several values of equal structure
/// ([`crate::superword`]).
pub fn vector_operations(function: &Function, options: &Options) -> usize {
    CodePlan::new(function, options, false).vector_operations()
}

/// The number of angles whose sines and cosines [`Sines::Inline`] computes in its
/// loop.
pub fn angles(function: &Function) -> usize {
    Slots::new(function, &live(function)).angles().len()
}

/// The name of the C function.
pub fn function_name(view: View<'_>, options: &Options) -> String {
    match Interface::new(view, options) {
        Ok(interface) => interface.name().to_owned(),
        Err(_) => view.function.name.clone(),
    }
}

/// The plain C source of a function and its header, with results that are the
/// evaluator's bit for bit: [`files`] with [`Options::plain`].
pub fn c_files(view: View<'_>, real: Real) -> [(String, String); 2] {
    files(view, &Options::plain(real)).expect("every function has a plain signature")
}
