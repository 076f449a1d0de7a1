//! Conversion of the function with numbered constants into the result, and into
//! the witness that proves it.
//!
//! While a function is specialised, the number of a constant in it is its index
//! in [`KnownNumbers`]. The *result* has the rounded numbers in their place.
//! The *witness* has nodes that compute them from the numbers they were made
//! of, before all others: it equals the function that was taken exactly, and
//! the result except for the rounding of constants.

use super::constants::{Known, KnownNumbers, NumberExpression};
use super::slice::SliceSignature;
use robovec_framework::check::{LARGEST_MOVE, moved};
use robovec_framework::scene::Scene;
use robovec_ir::states::States;
use robovec_ir::{
    Array, Assignment, Function, Name, Node, Operand, OperandKind, Operation, SourceSet, Tables,
    Value, View,
};

/// The result and its witness.
pub(crate) fn write(
    view: View<'_>,
    signature: &SliceSignature,
    constants: &KnownNumbers,
) -> (Function, Function) {
    let numbered = view.function;
    let mut result = empty(numbered, signature);
    copy(
        numbered,
        signature,
        &mut result,
        0,
        &mut |function, known| function.constant(constants.rounded(known)).into(),
    );
    let mut witness = empty(numbered, signature);
    let places = expressions(numbered, constants, &mut witness);
    let first = witness.nodes().len() as u32;
    copy(numbered, signature, &mut witness, first, &mut |_, known| {
        places[known.index()]
    });
    (result, witness)
}

/// Number of states at which a pass measures the effect of rounded constants on
/// outputs.
const STATES: u32 = 4;
/// Their seed; the semantic check draws others.
const SEED: u64 = 0x9a7e;

/// The remark where that is not so.
pub(crate) const NOT_ROUNDED: &str = "rounding constants would move results by more than rounding \
                                      does: only constants that binary64 holds are computed";

/// True when rounding the constants of a witness moves outputs far less than
/// the semantic check allows.
pub(crate) fn is_kept(
    (result, witness): &(Function, Function),
    tables: &Tables,
    scene: Option<&Scene>,
) -> bool {
    let states = scene.map_or_else(|| States::new(SEED), |scene| scene.states(SEED));
    let view = |function| View { tables, function };
    let inputs = (0..STATES).map(|state| states.draw(view(result), state));
    moved(view(witness), view(result), &inputs.collect::<Vec<_>>()).0 <= LARGEST_MOVE / 16.0
}

/// A function without a body.
fn empty(function: &Function, signature: &SliceSignature) -> Function {
    function.header(function.level).with_arrays(
        signature.inputs.iter().map(Array::declaration),
        signature.outputs.iter().map(Array::declaration),
    )
}

/// The constant an operand of the numbered function represents.
pub(crate) fn known(function: &Function, operand: Operand) -> Option<Known> {
    function.number(operand).map(|number| Known(number as u32))
}

/// Copies the body after the existing `first` nodes.
fn copy(
    numbered: &Function,
    signature: &SliceSignature,
    to: &mut Function,
    first: u32,
    constant: &mut dyn FnMut(&mut Function, Known) -> Operand,
) {
    to.reserve(numbered.nodes().len());
    let mut translate = |to: &mut Function, operand: Operand| match operand.kind() {
        OperandKind::Value(value) => Value(value.0 + first).into(),
        OperandKind::Constant(_) => {
            let known = known(numbered, operand).expect("it is a constant");
            constant(to, known)
        }
        OperandKind::Input(_) | OperandKind::None => signature.operand(operand),
    };
    for node in numbered.nodes() {
        let operands = node.operands.map(|operand| translate(to, operand));
        to.push(Node { operands, ..*node });
    }
    to.assignments = numbered
        .assignments
        .iter()
        .map(|assignment| Assignment {
            output: signature.output(assignment.output),
            operand: translate(to, assignment.operand),
            ..*assignment
        })
        .collect();
}

/// Writes the expressions of all constants that are read; returns their places.
fn expressions(numbered: &Function, constants: &KnownNumbers, to: &mut Function) -> Vec<Operand> {
    let mut needed = vec![false; constants.len()];
    let read = numbered.reads();
    for known in read.filter_map(|operand| known(numbered, operand)) {
        needed[known.index()] = true;
    }
    for index in (0..needed.len()).rev() {
        if needed[index]
            && let NumberExpression::Apply(_, operands) = constants.expression(Known(index as u32))
        {
            for operand in operands {
                needed[operand.index()] = true;
            }
        }
    }
    let mut places = vec![Operand::NONE; needed.len()];
    for index in 0..needed.len() {
        if !needed[index] {
            continue;
        }
        places[index] = match constants.expression(Known(index as u32)) {
            NumberExpression::Literal(number) => to.constant(number).into(),
            NumberExpression::Apply(operation, operands) => {
                let operands = operands.map(|operand| places[operand.index()]);
                to.push(Node {
                    name: Name::NONE,
                    sources: SourceSet::EMPTY,
                    operands: match operation.arity() {
                        1 => Operand::list([operands[0]]),
                        _ => Operand::list(operands),
                    },
                    operation,
                })
                .into()
            }
        };
    }
    places
}

/// Tests whether an operation can have a number as its only operand.
pub(crate) fn is_function(operation: Operation) -> bool {
    matches!(operation, Operation::Sin | Operation::Cos | Operation::Sqrt)
}
