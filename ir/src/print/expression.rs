//! Names, operands and expressions, with no more parentheses than they need.

use super::FunctionPrinter;
use super::text::Text;
use crate::entity::{Operand, OperandKind, Value};
use robovec_num::operation::Operation;
use smallvec::SmallVec;

/// A piece of an expression that remains to be printed.
enum PendingPiece {
    Operand(Operand, u8),
    Text(&'static str),
}

/// The pieces of an expression; those of most need no allocation.
type Pieces = SmallVec<[PendingPiece; 8]>;

const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const UNARY: u8 = 3;

impl FunctionPrinter<'_> {
    pub(super) fn name(&self, text: &mut Text<'_>, value: Value) {
        let name = self.view.function.node(value).name;
        text.push("%");
        text.symbol(&self.view.tables.symbols, name.base);
        if name.suffix > 0 {
            text.push(".");
            text.integer(name.suffix);
        }
    }

    pub(super) fn operand(&self, text: &mut Text<'_>, operand: Operand) {
        match operand.kind() {
            OperandKind::Value(value) if self.view.function.node(value).name.is_none() => {
                self.expression(text, value);
            }
            OperandKind::Value(value) => self.name(text, value),
            OperandKind::Input(input) => {
                let (array, indices, rank) = self.view.function.input_element(input);
                text.element(self.view.tables, array, &indices[..rank]);
            }
            OperandKind::Constant(constant) => {
                text.number(self.view.function.constant_number(constant));
            }
            OperandKind::None => text.push("none"),
        }
    }

    /// Prints the tree under a node without recursion: trees of real files
    /// are shallow, those of hostile ones are not.
    pub(super) fn expression(&self, text: &mut Text<'_>, value: Value) {
        let function = self.view.function;
        if self.simple(text, value) {
            return;
        }
        let mut pieces = Pieces::new();
        self.open(&mut pieces, text, value);
        while let Some(piece) = pieces.pop() {
            match piece {
                PendingPiece::Text(fixed) => text.push(fixed),
                PendingPiece::Operand(operand, binding) => match operand.value() {
                    Some(inner) if function.node(inner).name.is_none() => {
                        if precedence(function.node(inner).operation) < binding {
                            text.push("(");
                            pieces.push(PendingPiece::Text(")"));
                        }
                        self.open(&mut pieces, text, inner);
                    }
                    Some(_) | None => self.operand(text, operand),
                },
            }
        }
    }

    /// Prints an operation on two operands that have their own names, as
    /// almost all have below the equations level; false for any other one.
    fn simple(&self, text: &mut Text<'_>, value: Value) -> bool {
        let function = self.view.function;
        let node = function.node(value);
        let fixed = match node.operation {
            Operation::Add => " + ",
            Operation::Sub => " - ",
            Operation::Mul => "*",
            Operation::Div => "/",
            _ => return false,
        };
        let [left, right, _] = node.operands;
        let is_leaf = |operand: Operand| {
            let value = operand.value();
            value.is_none_or(|value| !function.node(value).name.is_none())
        };
        if !is_leaf(left) || !is_leaf(right) {
            return false;
        }
        self.operand(text, left);
        text.push(fixed);
        self.operand(text, right);
        true
    }

    /// Pushes the pieces of one node, last first.
    fn open(&self, pieces: &mut Pieces, text: &mut Text<'_>, value: Value) {
        let node = self.view.function.node(value);
        let [left, right, third] = node.operands;
        let (fixed, binding) = match node.operation {
            Operation::Add => (" + ", SUM),
            Operation::Sub => (" - ", SUM),
            Operation::Mul => ("*", PRODUCT),
            Operation::Div => ("/", PRODUCT),
            Operation::Copy => {
                pieces.push(PendingPiece::Operand(left, 0));
                return;
            }
            Operation::Neg => {
                text.push("-");
                // A minus before a literal reads as a negative literal, so a
                // negated literal keeps its parentheses.
                if left.constant().is_some() {
                    text.push("(");
                    pieces.push(PendingPiece::Text(")"));
                }
                pieces.push(PendingPiece::Operand(left, UNARY + 1));
                return;
            }
            Operation::Sin | Operation::Cos | Operation::Sqrt => {
                text.push(node.operation.name());
                text.push("(");
                pieces.push(PendingPiece::Text(")"));
                pieces.push(PendingPiece::Operand(left, 0));
                return;
            }
            Operation::Fma | Operation::Fms | Operation::Fnma => {
                text.push(node.operation.name());
                text.push("(");
                pieces.push(PendingPiece::Text(")"));
                pieces.push(PendingPiece::Operand(third, 0));
                pieces.push(PendingPiece::Text(", "));
                pieces.push(PendingPiece::Operand(right, 0));
                pieces.push(PendingPiece::Text(", "));
                pieces.push(PendingPiece::Operand(left, 0));
                return;
            }
        };
        pieces.push(PendingPiece::Operand(right, binding + 1));
        pieces.push(PendingPiece::Text(fixed));
        pieces.push(PendingPiece::Operand(left, binding));
    }
}

fn precedence(operation: Operation) -> u8 {
    match operation {
        Operation::Add | Operation::Sub => SUM,
        Operation::Mul | Operation::Div => PRODUCT,
        Operation::Neg => UNARY,
        Operation::Copy
        | Operation::Sin
        | Operation::Cos
        | Operation::Sqrt
        | Operation::Fma
        | Operation::Fms
        | Operation::Fnma => UNARY + 1,
    }
}
