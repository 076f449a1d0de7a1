//! The intermediate representation of robovec.
//!
//! A [`Module`] holds [`Function`]s; a function is a straight-line list of SSA
//! nodes between named input and output arrays. It has a text form
//! ([`mod@print`]), a verifier, an evaluator generic over the kind of number
//! ([`evaluate`]), and the description of the target machine. This crate holds
//! no pass and no front end, and touches no file.

pub mod cost;
pub mod count;
pub mod diagnostic;
pub mod document;
pub mod entity;
pub mod evaluate;
pub mod function;
pub mod history;
mod index_type;
pub mod machine;
pub mod module;
pub mod parenthesised;
pub mod parse;
pub mod placement;
pub mod plan;
pub mod print;
pub mod source;
pub mod states;
pub mod symbol;
pub mod value_formats;
pub mod verify;

pub use entity::{Constant, Input, Operand, OperandKind, Output, Value};
pub use function::{
    Array, Assignment, Boundary, Function, Level, MAX_INPUT_ELEMENTS, MAX_OUTPUT_ELEMENTS, Node,
    Shape, Timing, places_by_name,
};
pub use history::{Histories, History, HistoryStep};
pub use machine::Machine;
pub use module::{Module, Tables, View, same_equations};
pub use robovec_num::{FixedFormat, Format, Operation};
pub use source::{SourcePlace, SourceSet, Sources};
pub use symbol::{FreshNames, Name, Symbol, Symbols};
pub use value_formats::ValueFormats;
