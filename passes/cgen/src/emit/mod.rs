//! The text of C that every target shares.
//!
//! Plain C ([`super::c`]), C that replaces Robotran's, C for batches
//! ([`super::batch`]) and C with loops ([`super::rolled`]) differ in the places
//! of values. What a piece of C looks like is decided here, once:
//!
//! * [`names`]: names that C accepts, each for one thing only;
//! * [`expression`]: literals, operations and their parentheses;
//! * [`arrays`]: arrays that count from 1, as parameters and as elements;
//! * [`frame`]: comments, headers, parameters and definitions of functions;
//! * [`inlining`]: which operations are inside the expression of another;
//! * [`order`]: in which order statements are;
//! * [`crossing`]: how values travel from one function to the next.
//!
//! Fixed text is a C file beside its writer, with words between `@` for the
//! parts that depend on a function ([`robovec_framework::template`]).
//!
//! Invariant: code here depends on a target only through an argument that
//! describes a difference, so that a rule of C is implemented once.

pub(super) mod arrays;
pub(super) mod crossing;
pub(super) mod expression;
pub(super) mod frame;
pub(super) mod inlining;
pub(super) mod names;
pub(super) mod order;

use robovec_framework::option_words;

option_words! {
    /// The type that a C function computes in.
    #[derive(Default)]
    pub enum Real {
        /// IEEE binary64.
        #[default]
        Double = "double",
        /// IEEE binary32; sine and cosine are those of binary64, rounded once.
        Float = "float",
    }
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
