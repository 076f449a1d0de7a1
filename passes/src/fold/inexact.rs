//! Operations on constants whose result is exact in no format.
//!
//! `1.0/0.01` is computed once, in double-double, and rounded to binary64: the
//! machine then rounds one number instead of several. As in
//! [`crate::specialise`], whose table of known numbers this uses, the semantic
//! check proves a *witness* in which they are still expressions.

use crate::specialise::constants::{Known, KnownNumbers};
use crate::specialise::slice::SliceSignature;
use crate::specialise::write::{NOT_ROUNDED, is_kept, known, write};
use crate::sums::fused::apart;
use robovec_framework::pass::Context;
use robovec_ir::{Assignment, Function, Node, Operand, OperandKind, Operation};

/// The function with constants computed, its witness, and the number of
/// operations removed; `None` when there are none.
pub(super) fn fold(old: &Function, context: &mut Context<'_>) -> Option<(Function, Function, u64)> {
    let (written, folded) = folded(old, context);
    if is_kept(&written, context.tables, context.scene) {
        return (folded > 0).then_some((written.0, written.1, folded));
    }
    context.remark(NOT_ROUNDED.to_owned());
    None
}

fn folded(old: &Function, context: &Context<'_>) -> ((Function, Function), u64) {
    let mut folder = ConstantFolder {
        old,
        new: old.skeleton(old.level),
        constants: KnownNumbers::new(),
        // A unit of the host has sines of its own.
        has_sines: old.trigonometry_unit().is_none(),
        places: Vec::with_capacity(old.nodes().len()),
    };
    let mut folded = 0;
    for node in old.nodes() {
        let operands = node.operands.map(|operand| folder.translate(operand));
        let node = Node { operands, ..*node };
        let result = match folder.simplify(node) {
            FoldedNode::Operation(same) if same == node => FoldedNode::Operation(node),
            _ if !context.allow_rewrite(node.name, "constants known") => {
                FoldedNode::Operation(node)
            }
            simpler => {
                folded += 1;
                simpler
            }
        };
        let place = match result {
            FoldedNode::Operand(operand) => operand,
            FoldedNode::Operation(node) => folder.new.push(node).into(),
        };
        folder.places.push(place);
    }
    let assignments = old.assignments.iter().map(|assignment| Assignment {
        operand: folder.translate(assignment.operand),
        ..*assignment
    });
    let assignments = assignments.collect();
    folder.new.assignments = assignments;
    let view = context.tables.view(&folder.new);
    let signature = SliceSignature::whole(old);
    (write(view, &signature, &folder.constants), folded)
}

/// Rest of an operation.
enum FoldedNode {
    Operand(Operand),
    Operation(Node),
}

/// Writes a function again; a constant in it is the index of a known number.
struct ConstantFolder<'a> {
    old: &'a Function,
    new: Function,
    constants: KnownNumbers,
    has_sines: bool,
    /// For every old value its new operand.
    places: Vec<Operand>,
}

impl ConstantFolder<'_> {
    /// An operand of the old function in the new one.
    fn translate(&mut self, operand: Operand) -> Operand {
        match operand.kind() {
            OperandKind::Value(value) => self.places[value.index()],
            OperandKind::Constant(constant) => {
                let known = self.constants.literal(self.old.constant_number(constant));
                self.number(known)
            }
            OperandKind::Input(_) | OperandKind::None => operand,
        }
    }

    fn number(&mut self, known: Known) -> Operand {
        self.new.constant(f64::from(known.0)).into()
    }

    fn simplify(&mut self, node: Node) -> FoldedNode {
        let [a, b, c] = node.operands;
        let [x, y] = [a, b].map(|operand| known(&self.new, operand));
        let is_sine = node.operation.is_trigonometric();
        if node.operation.is_fused() {
            // One rounding is left where the product is known.
            let product = x
                .zip(y)
                .and_then(|(x, y)| self.computed(Operation::Mul, x, y));
            return match product {
                None => FoldedNode::Operation(node),
                Some(product) => {
                    let (operation, operands) = apart(node.operation, product, c);
                    self.simplify(Node {
                        operation,
                        operands: Operand::list(operands),
                        ..node
                    })
                }
            };
        }
        let result = match (x, y, node.operation.arity()) {
            (Some(x), _, 1) if !is_sine || self.has_sines => self.computed(node.operation, x, x),
            (Some(x), Some(y), 2) => self.computed(node.operation, x, y),
            _ => None,
        };
        if let Some(result) = result {
            return FoldedNode::Operand(result);
        }
        let zero = |known: Option<Known>| known == Some(Known::ZERO);
        let one = |known: Option<Known>| known == Some(Known::ONE);
        match node.operation {
            Operation::Add if zero(x) => FoldedNode::Operand(b),
            Operation::Add | Operation::Sub if zero(y) => FoldedNode::Operand(a),
            Operation::Mul if zero(x) || zero(y) => FoldedNode::Operand(self.number(Known::ZERO)),
            Operation::Mul if one(x) => FoldedNode::Operand(b),
            Operation::Mul | Operation::Div if one(y) => FoldedNode::Operand(a),
            _ => FoldedNode::Operation(node),
        }
    }

    /// The constant that an operation on constants gives.
    fn computed(&mut self, operation: Operation, x: Known, y: Known) -> Option<Operand> {
        let known = self.constants.apply(operation, [x, y])?;
        Some(self.number(known))
    }
}
