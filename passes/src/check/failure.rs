//! What broke a claim, and where to look first.

use super::pairing::{Pair, Pairs};
use crate::analysis::slice::slice;
use robovec_ir::evaluate::evaluate_nodes;
use robovec_ir::field::PrimeField;
use robovec_ir::print::{print_definition, print_output};
use robovec_ir::{Name, Operand, Output, Value, View};
use std::fmt;

/// How a claim was broken.
#[derive(Clone, PartialEq, Debug)]
pub enum FailureKind {
    /// The versions have other inputs, other outputs, or set others.
    Signature {
        /// Which, as a sentence part.
        reason: String,
    },
    /// They differ as functions.
    Field {
        /// The seed of the point ([`PrimeField::seed`]).
        point: u64,
        /// The value before, in the field.
        before: u64,
        /// The value after.
        after: u64,
    },
    /// They have no value in the field, and differ in double-double.
    Distance {
        /// The number of the state, as [`robovec_ir::states::States::draw`]
        /// counts.
        state: u32,
        /// The value before.
        before: f64,
        /// The value after.
        after: f64,
    },
    /// A constant is not the number it was computed from.
    Constants {
        /// Which, as a sentence part.
        reason: String,
    },
    /// They differ by rounding, and the pass claimed to be exact.
    Bits {
        /// `binary32` or `binary64`.
        format: &'static str,
        /// The number of the state, as [`robovec_ir::states::States::draw`]
        /// counts.
        state: u32,
        /// The value before.
        before: f64,
        /// The value after.
        after: f64,
    },
}

/// The first output that breaks the claim, with what is needed to find out
/// why.
#[derive(Clone, PartialEq, Debug)]
pub struct Failure {
    /// In what way.
    pub kind: FailureKind,
    /// Which output; `None` when the signatures differ.
    pub output: Option<Output>,
    /// The output as text (`M[1,2]`), or the function's name.
    pub name: String,
    /// The values of the version before that the output depends on.
    pub slice_before: Vec<Value>,
    /// The values of the version after that the output depends on.
    pub slice_after: Vec<Value>,
    /// The earliest value after that bears the name of a value before and
    /// differs from it (by more than its sign), as text before and after: the
    /// place to look first.
    pub first_difference: Option<(String, String)>,
}

impl Failure {
    /// A failure that is about no output.
    pub(super) fn about(kind: FailureKind, after: View<'_>) -> Failure {
        Failure {
            kind,
            output: None,
            name: after.function.name.clone(),
            slice_before: Vec::new(),
            slice_after: Vec::new(),
            first_difference: None,
        }
    }
}

/// The failure of an output, with its slices and the first value that differs
/// in the given field.
pub(super) fn explain(
    pairs: &Pairs<'_>,
    kind: FailureKind,
    output: Output,
    field: &PrimeField,
) -> Failure {
    let cut = |view: View<'_>, index: fn(&Pair) -> usize| {
        let pair = pairs.list.iter().find(|pair| pair.output == output);
        let root = pair.map_or(Operand::NONE, |pair| {
            view.function.assignments[index(pair)].operand
        });
        slice(view.function, &[root])
    };
    let slice_before = cut(pairs.before, |pair| pair.before);
    let slice_after = cut(pairs.after, |pair| pair.after);
    let first_difference = first_difference(pairs, &slice_after, field);
    Failure {
        kind,
        output: Some(output),
        name: print_output(pairs.before, output),
        slice_before,
        slice_after,
        first_difference,
    }
}

/// Names survive passes, so a value that bears the same name before and after
/// should be the same number, or its negative where a pass moved a minus.
fn first_difference(
    pairs: &Pairs<'_>,
    slice: &[Value],
    field: &PrimeField,
) -> Option<(String, String)> {
    let (before, after) = (pairs.before, pairs.after);
    let text = |view: View<'_>, name: Name| name.display(&view.tables.symbols);
    let mut named: Vec<(String, Value)> = before
        .function
        .values()
        .filter(|(_, node)| !node.name.is_none())
        .map(|(value, node)| (text(before, node.name), value))
        .collect();
    named.sort();
    let [before_inputs, after_inputs] = pairs.point(field);
    let old = evaluate_nodes(before.function, field, &before_inputs);
    let new = evaluate_nodes(after.function, field, &after_inputs);
    let same = |old: u64, new: u64| old == new || old.checked_add(new) == Some(PrimeField::MODULUS);
    slice.iter().find_map(|&value| {
        let name = after.function.node(value).name;
        if name.is_none() {
            return None;
        }
        let name = text(after, name);
        let place = named.binary_search_by(|(other, _)| other.cmp(&name)).ok()?;
        let partner = named[place].1;
        (!same(old[partner.index()], new[value.index()])).then(|| {
            (
                print_definition(before, partner),
                print_definition(after, value),
            )
        })
    })
}

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            FailureKind::Signature { reason } | FailureKind::Constants { reason } => {
                return formatter.write_str(reason);
            }
            FailureKind::Field {
                point,
                before,
                after,
            } => write!(
                formatter,
                "{} is another function: {} before and {} after, at point {point:#x} of the prime \
                 field",
                self.name,
                Element(*before),
                Element(*after)
            )?,
            FailureKind::Distance {
                state,
                before,
                after,
            } => write!(
                formatter,
                "{} divides by zero, and is {before:e} before and {after:e} after in random state \
                 {state}",
                self.name
            )?,
            FailureKind::Bits {
                format,
                state,
                before,
                after,
            } => write!(
                formatter,
                "{} is rounded otherwise in {format}: {before:e} before and {after:e} after, in \
                 random state {state}",
                self.name
            )?,
        }
        write!(
            formatter,
            "; it depends on {} operations before and {} after",
            self.slice_before.len(),
            self.slice_after.len()
        )?;
        if let Some((before, after)) = &self.first_difference {
            write!(
                formatter,
                "; the first value of the same name that differs is\n  before: {before}\n  after:  \
                 {after}"
            )?;
        }
        Ok(())
    }
}

/// A field element as text.
struct Element(u64);

impl fmt::Display for Element {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if PrimeField::is_undefined(self.0) {
            return formatter.write_str("undefined");
        }
        self.0.fmt(formatter)
    }
}
