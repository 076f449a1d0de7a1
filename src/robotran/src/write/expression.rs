//! Printer of expressions; reading its text gives the same tree.
//!
//! The grammar of Robotran's files, which is also how the three languages read
//! them: sums and products associate to the left, and a leading minus takes in
//! the whole first product (`-a*b` is the negated product, rounded alike). All
//! else needs parentheses: `a-(b+c)`, `a*(b*c)`, `(-a)*b`.

use super::names::FileIdentifiers;
use super::text::FileText;
use hashbrown::HashMap;
use robovec_ir::{Function, Input, Operand, OperandKind, Operation, Symbols, Value};
use rustc_hash::FxBuildHasher;

/// Facts about a function that the printer needs.
pub(super) struct PrinterSource<'a> {
    pub(super) function: &'a Function,
    pub(super) symbols: &'a Symbols,
    pub(super) names: &'a FileIdentifiers,
    /// Per input array: its text (`q`, `s.dpt`, `Flink1`).
    pub(super) inputs: &'a [String],
    /// The temporaries of input elements that outputs overwrite.
    pub(super) kept: &'a HashMap<Input, Box<str>, FxBuildHasher>,
}

const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const PRIMARY: u8 = 3;

/// Piece of an expression that remains to be printed.
enum ExpressionPiece {
    /// An operand; a text that binds less tightly gets parentheses.
    Operand(Operand, u8),
    Operator(&'static str),
    Close,
}

/// Prints expressions; the stack is kept between them.
#[derive(Default)]
pub(super) struct Printer {
    pieces: Vec<ExpressionPiece>,
    /// Operations printed so far.
    count: usize,
}

impl Printer {
    /// Operations printed so far as Robotran counts: signs and sines included.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The expression of a named value: its own operation.
    pub(super) fn definition(
        &mut self,
        text: &mut FileText,
        source: &PrinterSource<'_>,
        value: Value,
    ) {
        let node = source.function.node(value);
        match node.operation {
            Operation::Copy => self.right_side(text, source, node.operands[0], false),
            _ => {
                self.node(text, value, source.function);
                self.run(text, source, false);
            }
        }
    }

    /// The right side of an assignment. Among the `outputs` at the end, input
    /// elements that are overwritten come from their temporaries.
    pub(super) fn right_side(
        &mut self,
        text: &mut FileText,
        source: &PrinterSource<'_>,
        operand: Operand,
        outputs: bool,
    ) {
        if source
            .function
            .number(operand)
            .is_some_and(|number| number.to_bits() == 0)
        {
            text.push("0");
            return;
        }
        self.pieces.push(ExpressionPiece::Operand(operand, SUM));
        self.run(text, source, outputs);
    }

    fn run(&mut self, text: &mut FileText, source: &PrinterSource<'_>, outputs: bool) {
        while let Some(piece) = self.pieces.pop() {
            match piece {
                ExpressionPiece::Operator(operator) => text.operator(operator),
                ExpressionPiece::Close => text.push(")"),
                ExpressionPiece::Operand(operand, binding) => {
                    self.operand(text, source, operand, binding, outputs);
                }
            }
        }
    }

    fn operand(
        &mut self,
        text: &mut FileText,
        source: &PrinterSource<'_>,
        operand: Operand,
        binding: u8,
        outputs: bool,
    ) {
        match operand.kind() {
            OperandKind::Value(value) => {
                let node = source.function.node(value);
                if !node.name.is_none() {
                    text.push(source.names.text(node.name, source.symbols));
                } else if node.operation == Operation::Copy {
                    self.pieces
                        .push(ExpressionPiece::Operand(node.operands[0], binding));
                } else {
                    if precedence(node.operation) < binding {
                        text.push("(");
                        self.pieces.push(ExpressionPiece::Close);
                    }
                    self.node(text, value, source.function);
                }
            }
            OperandKind::Input(input) => element(text, source, input, outputs),
            OperandKind::Constant(constant) => {
                text.number(source.function.constant_number(constant));
            }
            OperandKind::None => {}
        }
    }

    /// Pushes the pieces of a node in reverse order.
    fn node(&mut self, text: &mut FileText, value: Value, function: &Function) {
        let node = function.node(value);
        let [left, right, third] = node.operands;
        self.count += match node.operation {
            Operation::Copy => 0,
            // Robotran has no fused operation: it becomes the two it stands for.
            operation if operation.is_fused() => 2,
            _ => 1,
        };
        let (operator, binding) = match node.operation {
            Operation::Add => ("+", SUM),
            Operation::Sub => ("-", SUM),
            Operation::Mul => ("*", PRODUCT),
            Operation::Div => ("/", PRODUCT),
            Operation::Copy => {
                self.pieces.push(ExpressionPiece::Operand(left, SUM));
                return;
            }
            Operation::Neg => {
                text.push("-");
                self.pieces.push(ExpressionPiece::Operand(left, PRODUCT));
                return;
            }
            Operation::Sin | Operation::Cos | Operation::Sqrt => {
                text.push(node.operation.name());
                text.push("(");
                self.pieces.push(ExpressionPiece::Close);
                self.pieces.push(ExpressionPiece::Operand(left, SUM));
                return;
            }
            Operation::Fma | Operation::Fms => {
                let add = node.operation == Operation::Fma;
                self.pieces.push(ExpressionPiece::Operand(third, SUM + 1));
                self.pieces
                    .push(ExpressionPiece::Operator(if add { "+" } else { "-" }));
                self.product(left, right);
                return;
            }
            Operation::Fnma => {
                self.product(left, right);
                self.pieces.push(ExpressionPiece::Operator("-"));
                self.pieces.push(ExpressionPiece::Operand(third, SUM));
                return;
            }
        };
        self.pieces
            .push(ExpressionPiece::Operand(right, binding + 1));
        self.pieces.push(ExpressionPiece::Operator(operator));
        self.pieces.push(ExpressionPiece::Operand(left, binding));
    }

    fn product(&mut self, left: Operand, right: Operand) {
        self.pieces
            .push(ExpressionPiece::Operand(right, PRODUCT + 1));
        self.pieces.push(ExpressionPiece::Operator("*"));
        self.pieces.push(ExpressionPiece::Operand(left, PRODUCT));
    }
}

fn element(text: &mut FileText, source: &PrinterSource<'_>, input: Input, outputs: bool) {
    if outputs && let Some(name) = source.kept.get(&input) {
        text.push(name);
        return;
    }
    let arrays = source.function.inputs();
    // As `Function::input_element`, which does not say which array it is.
    let number = arrays.partition_point(|array| array.offset <= input.0) - 1;
    let array = arrays[number];
    let (indices, rank) = array.shape.indices(input.0 - array.offset);
    text.element(&source.inputs[number], &indices[..rank]);
}

fn precedence(operation: Operation) -> u8 {
    match operation {
        Operation::Add
        | Operation::Sub
        | Operation::Neg
        | Operation::Fma
        | Operation::Fms
        | Operation::Fnma => SUM,
        Operation::Mul | Operation::Div => PRODUCT,
        Operation::Copy | Operation::Sin | Operation::Cos | Operation::Sqrt => PRIMARY,
    }
}
