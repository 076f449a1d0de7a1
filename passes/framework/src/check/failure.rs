//! The failure that broke a claim, and where to look first.

use super::pairing::{Pairs, Unpaired};
use super::states::StatePlace;
use robovec_analysis::slice::slice;
use robovec_ir::evaluate::evaluate_nodes;
use robovec_ir::print::{print_definition, print_operand, print_output};
use robovec_ir::states::States;
use robovec_ir::{Input, Name, Output, Value, View};
use robovec_num::field::Field;
use robovec_num::limits::counted;
use std::fmt;

/// Two values of an output at a state.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Values {
    /// The state.
    pub state: StatePlace,
    /// The value before.
    pub before: f64,
    /// The value after.
    pub after: f64,
    /// The largest distance that the claim allows.
    pub allowed: f64,
}

/// An output whose values break a claim.
#[derive(Clone, Debug)]
pub(super) struct Failed {
    /// Index into [`Pairs::list`].
    pub(super) pair: usize,
    pub(super) values: Values,
    /// The inputs before, where they are not those of the state.
    pub(super) inputs: Option<Vec<f64>>,
}

/// The way in which a claim was broken.
#[derive(Clone, PartialEq, Debug)]
pub enum FailureKind {
    /// The versions have other inputs, other outputs, or set others.
    Signature {
        /// Reason as a sentence part.
        reason: String,
    },
    /// They differ as functions, and no state was found at which the numbers
    /// differ.
    Field {
        /// The prime.
        prime: u64,
        /// The value before modulo the prime; `None` when it is undefined.
        before: Option<u64>,
        /// The value after.
        after: Option<u64>,
    },
    /// They differ in numbers.
    Numbers(Values),
    /// An element of a derivative differs from that of dual numbers, which are
    /// given as the value before.
    Derivative(Values),
    /// One has a divisor that becomes zero where the other is defined.
    Pole(Values),
    /// It has no value, or a different one, where it had one before.
    Hole(Values),
    /// A constant is not the number it was computed from.
    Constants {
        /// Reason as a sentence part.
        reason: String,
    },
    /// They differ by rounding, and the pass claimed to be exact, or values
    /// have their own formats.
    Bits {
        /// The format of values that have none.
        format: &'static str,
        /// The values.
        values: Values,
    },
    /// Their distance exceeds the promise of an approximating pass.
    Promise(Values),
}

/// The first output that breaks the claim, with the data for a diagnosis.
#[derive(Clone, PartialEq, Debug)]
pub struct Failure {
    /// The kind of failure.
    pub kind: FailureKind,
    /// The output; `None` when the signatures differ.
    pub output: Option<Output>,
    /// The output as text (`M[1,2]`), or the function's name.
    pub name: String,
    /// The values of the version before that the output depends on.
    pub slice_before: Vec<Value>,
    /// The values of the version after that the output depends on.
    pub slice_after: Vec<Value>,
    /// The earliest value after that has the name of a value before and differs
    /// from it (by more than its sign), as text before and after: the place to
    /// look first.
    pub first_difference: Option<(String, String)>,
    /// The inputs on which the output depends, by name, with their numbers in
    /// the state of the failure: the first of them.
    pub inputs: Vec<(String, f64)>,
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
            inputs: Vec::new(),
        }
    }
}

impl Unpaired {
    pub(super) fn failure(self, before: View<'_>, after: View<'_>) -> Failure {
        let kind = FailureKind::Signature {
            reason: self.reason,
        };
        let mut failure = Failure::about(kind, after);
        failure.output = self.output;
        if let Some(output) = self.output {
            failure.name = print_output(before, output);
        }
        failure
    }
}

/// The failure of an output, with its slices and the first value that differs
/// in the given field.
pub(super) fn explain<F: Field>(
    pairs: &Pairs<'_>,
    source: &States,
    (index, kind): (usize, FailureKind),
    given: Option<&[f64]>,
    field: &F,
) -> Failure {
    let pair = &pairs.list[index];
    let cut = |view: View<'_>, assignment: usize| {
        slice(
            view.function,
            &[view.function.assignments[assignment].operand],
        )
    };
    let slice_before = cut(pairs.before, pair.before);
    let slice_after = cut(pairs.after, pair.after);
    let first_difference = first_difference(pairs, &slice_after, field);
    let inputs = match &kind {
        FailureKind::Numbers(values)
        | FailureKind::Pole(values)
        | FailureKind::Hole(values)
        | FailureKind::Promise(values)
        | FailureKind::Bits { values, .. } => {
            let state = match given {
                Some(given) => given,
                None => &pairs.numbers(source, values.state)[0],
            };
            inputs(pairs, index, [&slice_before, &slice_after], state)
        }
        _ => Vec::new(),
    };
    Failure {
        kind,
        output: Some(pair.output),
        name: print_output(pairs.before, pair.output),
        slice_before,
        slice_after,
        first_difference,
        inputs,
    }
}

/// Maximum number of inputs named in a failure.
const MAX_INPUTS: usize = 8;

/// The inputs on which the output of a pair depends, with their numbers: first
/// those of the version before, then those that only the version after reads.
fn inputs(
    pairs: &Pairs<'_>,
    pair: usize,
    slices: [&[Value]; 2],
    state: &[f64],
) -> Vec<(String, f64)> {
    let read = |view: View<'_>, slice: &[Value], assignment: usize| {
        let function = view.function;
        let nodes = slice.iter().map(|&value| function.node(value));
        let operands = nodes.flat_map(|node| node.operands());
        let operands = operands.chain([&function.assignments[assignment].operand]);
        let mut inputs: Vec<Input> = operands.filter_map(|operand| operand.input()).collect();
        inputs.sort_unstable();
        inputs.dedup();
        inputs
    };
    let places = &pairs.list[pair];
    let mut inputs = read(pairs.before, slices[0], places.before);
    if pairs.have_same_inputs() {
        let after = read(pairs.after, slices[1], places.after);
        inputs.extend(
            after
                .into_iter()
                .filter(|input| !inputs.contains(input))
                .collect::<Vec<_>>(),
        );
    }
    inputs
        .into_iter()
        .take(MAX_INPUTS)
        .map(|input| {
            (
                print_operand(pairs.before, input.into()),
                state[input.index()],
            )
        })
        .collect()
}

/// Names survive passes, so a value that has the same name before and after
/// should be the same number, or its negative where a pass moved a minus.
fn first_difference<F: Field>(
    pairs: &Pairs<'_>,
    slice: &[Value],
    field: &F,
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
    let same = |old: F::Number, new: F::Number| old == new || old == field.neg(new);
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
                prime,
                before,
                after,
            } => write!(
                formatter,
                "{} is another function: {} before and {} after modulo {prime}, although no \
                 state with different numbers was found",
                self.name,
                ResidueText(*before),
                ResidueText(*after)
            )?,
            FailureKind::Numbers(values) if !values.after.is_nan() => {
                write!(formatter, "{} is another function: {values}", self.name)?;
            }
            FailureKind::Derivative(values) => write!(
                formatter,
                "{} is not the derivative: {:?} by dual numbers and {:?} as computed in {}",
                self.name, values.before, values.after, values.state
            )?,
            FailureKind::Pole(values) => write!(
                formatter,
                "{} divides by a number that becomes zero where it did not: {values}",
                self.name
            )?,
            FailureKind::Numbers(values) | FailureKind::Hole(values) => write!(
                formatter,
                "{} is not defined everywhere it was: {values}",
                self.name
            )?,
            FailureKind::Promise(values) => write!(
                formatter,
                "{} has changed more than the pass promised: {values}, by {:.1e} where {:.1e} is \
                 allowed",
                self.name,
                (values.after - values.before).abs(),
                values.allowed
            )?,
            FailureKind::Bits { format, values } => write!(
                formatter,
                "{} is rounded differently in {format}: {values}",
                self.name
            )?,
        }
        for (index, (name, number)) in self.inputs.iter().enumerate() {
            let lead = if index == 0 { ", where " } else { ", " };
            write!(formatter, "{lead}{name} = {number:?}")?;
        }
        write!(
            formatter,
            "; it depends on {} before and {} after",
            counted(self.slice_before.len(), "operation"),
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

impl fmt::Display for Values {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Values {
            before,
            after,
            state,
            ..
        } = self;
        write!(
            formatter,
            "{before:?} before and {after:?} after in {state}"
        )
    }
}

/// A field element as text.
struct ResidueText(Option<u64>);

impl fmt::Display for ResidueText {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(number) => number.fmt(formatter),
            None => formatter.write_str("undefined"),
        }
    }
}
