//! Expressions: literals, operations and their operands.

use super::{ParseFailure, SyntaxBuilder, refused, unkept};
use crate::literal::{IntegerArithmetic, Literal, Unkept};
use crate::syntax::{LeafKind, SyntaxLeaf, SyntaxNode};
use crate::token::{RobotranElement, RobotranName, SourceSpan, TypeWords};
use robovec_ir::Operation;

impl SyntaxBuilder {
    fn push_node(
        &mut self,
        operation: Operation,
        left: SyntaxLeaf,
        right: SyntaxLeaf,
    ) -> SyntaxLeaf {
        let index = self.syntax.nodes.len() as u32;
        debug_assert!(
            [left, right]
                .into_iter()
                .all(|leaf| !matches!(leaf.kind(), LeafKind::Node(node) if node >= index)),
            "every operand comes before its user"
        );
        self.syntax.nodes.push(SyntaxNode {
            operands: [left, right],
            operation,
            grouped: false,
            whole_bits: 0,
        });
        SyntaxLeaf::node(index)
    }

    /// Number of bits of an operand that may be a whole number of Python, 0 for
    /// a float. Names represent whole numbers where any equation assigns one.
    pub(super) fn whole_bits(&self, leaf: SyntaxLeaf) -> u8 {
        match leaf.kind() {
            LeafKind::Node(index) => self.syntax.nodes[index as usize].whole_bits,
            LeafKind::Number(index) => match self.syntax.numbers[index as usize] {
                Literal::Whole { value, .. } => (64 - value.abs().leading_zeros() as u8).max(1),
                Literal::Single(_) | Literal::Double(_) => 0,
            },
            LeafKind::Scalar(name) => self.whole_names.get(&name).copied().unwrap_or(0),
            LeafKind::Element(_) => 0,
        }
    }

    /// An operation on whole numbers of Python, exact in a float up to 53 bits.
    fn exact(
        &self,
        operation: Operation,
        left: SyntaxLeaf,
        right: SyntaxLeaf,
    ) -> Result<u8, Unkept> {
        let (a, b) = (self.whole_bits(left), self.whole_bits(right));
        if a == 0 || b == 0 {
            return Ok(0);
        }
        let bits = match operation {
            Operation::Add | Operation::Sub => a.max(b) + 1,
            Operation::Mul => a + b,
            _ => return Ok(0),
        };
        if bits > 53 {
            return Err(Unkept {
                message: "whole numbers that may be too large for a 64-bit float",
                note: "Python computes them exactly; write them with decimal points",
            });
        }
        Ok(bits)
    }

    /// The literal of an operand, if it is one.
    pub(super) fn literal(&self, leaf: SyntaxLeaf) -> Option<Literal> {
        match leaf.kind() {
            LeafKind::Number(index) => Some(self.syntax.numbers[index as usize]),
            LeafKind::Node(_) | LeafKind::Element(_) | LeafKind::Scalar(_) => None,
        }
    }

    /// An operation on two operands; other literals than floats are combined.
    pub(crate) fn node(
        &mut self,
        operation: Operation,
        (start, left): (u32, SyntaxLeaf),
        (right, end): (SyntaxLeaf, u32),
    ) -> Result<SyntaxLeaf, ParseFailure> {
        if let (Some(a), Some(b)) = (self.literal(left), self.literal(right)) {
            let span = SourceSpan { start, end };
            let combined = a
                .combined(operation, b, self.arithmetic)
                .map_err(|error| unkept(error, span))?;
            if let Some(number) = combined {
                return Ok(self.number(number));
            }
        }
        let whole_bits = match self.arithmetic {
            IntegerArithmetic::Python => self
                .exact(operation, left, right)
                .map_err(|error| unkept(error, SourceSpan { start, end }))?,
            IntegerArithmetic::C | IntegerArithmetic::Floats => 0,
        };
        let node = self.push_node(operation, left, right);
        if let Some(last) = self.syntax.nodes.last_mut() {
            last.whole_bits = whole_bits;
        }
        Ok(node)
    }

    /// The sine, cosine or root of an operand.
    pub(crate) fn apply(&mut self, function: Operation, argument: SyntaxLeaf) -> SyntaxLeaf {
        self.push_node(function, argument, SyntaxLeaf::NONE)
    }

    /// A minus before an operand, which may be a product.
    pub(crate) fn negated(
        &mut self,
        start: u32,
        operand: SyntaxLeaf,
        end: u32,
    ) -> Result<SyntaxLeaf, ParseFailure> {
        if let Some(number) = self.literal(operand) {
            let span = SourceSpan { start, end };
            if let Some(negative) = number.negative().map_err(|error| unkept(error, span))? {
                return Ok(self.number(negative));
            }
        }
        // The minus belongs to the first factor, and a whole 0 has no sign.
        let mut first = operand;
        while let LeafKind::Node(index) = first.kind() {
            let node = self.syntax.nodes[index as usize];
            if node.grouped || !matches!(node.operation, Operation::Mul | Operation::Div) {
                break;
            }
            first = node.operands[0];
        }
        // A whole zero has no sign.
        let is_zero = matches!(self.literal(first), Some(Literal::Whole { value: 0, .. }));
        if first != operand && is_zero {
            return Ok(operand);
        }
        let whole_bits = self.whole_bits(operand);
        let node = self.push_node(Operation::Neg, operand, SyntaxLeaf::NONE);
        if let Some(last) = self.syntax.nodes.last_mut() {
            last.whole_bits = whole_bits;
        }
        Ok(node)
    }

    /// An expression in parentheses.
    pub(crate) fn grouped(&mut self, leaf: SyntaxLeaf) -> SyntaxLeaf {
        if let LeafKind::Node(index) = leaf.kind() {
            self.syntax.nodes[index as usize].grouped = true;
        }
        leaf
    }

    /// C's conversion to another type; only literals are no 64-bit floats.
    pub(crate) fn converted(
        &mut self,
        start: u32,
        words: TypeWords,
        operand: SyntaxLeaf,
        end: u32,
    ) -> Result<SyntaxLeaf, ParseFailure> {
        if !words.is_double() {
            return Err(refused(
                SourceSpan { start, end },
                "a conversion to another type than `double`",
                "it would round the number; write the rounded number, or leave the conversion out",
            ));
        }
        Ok(match self.literal(operand) {
            Some(number) => self.number(Literal::Double(number.number())),
            None => operand,
        })
    }

    pub(crate) fn element(&mut self, element: RobotranElement) -> SyntaxLeaf {
        let element = match self.rows.get(&element.name) {
            Some(row) if element.column == 0 && element.row > 0 => RobotranElement {
                column: element.row,
                ..*row
            },
            Some(_) | None => element,
        };
        let index = self.syntax.elements.len() as u32;
        self.syntax.elements.push(element);
        SyntaxLeaf::element(index)
    }

    /// Target of a pointer of C.
    pub(crate) fn pointed_at(&mut self, name: RobotranName) -> SyntaxLeaf {
        self.element(RobotranElement {
            name,
            row: 0,
            column: 0,
        })
    }

    pub(crate) fn number(&mut self, number: Literal) -> SyntaxLeaf {
        let index = self.syntax.numbers.len() as u32;
        self.syntax.numbers.push(number);
        SyntaxLeaf::number(index)
    }
}
