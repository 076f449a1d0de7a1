//! Operations whose result is known, or is an operand.

mod inexact;

use crate::sums::fused::apart;
use robovec_analysis::class::NumericClass;
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::Rewriter;
use robovec_ir::{Function, Node, Operand, Operation};

declare_pass! {
    /// Computes values that are known before the run: constants, `x + 0`, `x *
    /// 1`, `x - x` ….
    ///
    /// Constants are combined only where the result is exact in every number
    /// format from binary32 up, so that no bit changes in any of these formats.
    /// Infinities and NaN are not considered: `0*x` and `x - x` are 0.
    ///
    /// With `inexact` all constants are computed, in double-double, and rounded
    /// once, to binary64: also `1.0/0.01`, `0.081 + 0.02`, roots and, unless a
    /// unit of the host has its own, sines. Bits change then, and the class is
    /// real: the values computed before constants are rounded are proved
    /// exactly, as for `specialise`. Functions whose values have their own
    /// formats keep theirs.
    pub struct Fold("fold") {
        /// Computes constants that binary32 does not hold.
        pub inexact: bool = false,
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Exact,
    destroys: [Timed],
}

impl Pass for Fold {
    fn class(&self, declared: NumericClass) -> NumericClass {
        if self.inexact {
            NumericClass::Real
        } else {
            declared
        }
    }

    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let mut rewriter = Rewriter::new(function, function.level);
        let mut folded = 0;
        for node in function.nodes() {
            let operands = rewriter.translate_operands(node);
            let node = Node { operands, ..*node };
            let simple = match simplify(&mut rewriter.new, node) {
                Simple::Node(same) if same == node => Simple::Node(node),
                _ if !context.allow_rewrite(node.name, "result known") => Simple::Node(node),
                simple => simple,
            };
            match simple {
                Simple::Operand(operand) => {
                    rewriter.record(operand);
                    folded += 1;
                }
                Simple::Node(node) => {
                    rewriter.keep(node);
                }
            }
        }
        *function = rewriter.finish();
        // Another rounding of a constant is another number in its own format.
        if self.inexact
            && function.formats.is_none()
            && let Some((result, witness, more)) = inexact::fold(function, context)
        {
            *context.witness = Some(witness);
            *function = result;
            folded += more;
        }
        context.count("operations folded", folded);
        Ok(())
    }
}

enum Simple {
    Operand(Operand),
    Node(Node),
}

fn simplify(function: &mut Function, node: Node) -> Simple {
    let [a, b, c] = node.operands;
    let (x, y) = (function.number(a), function.number(b));
    if node.operation.is_fused() {
        return simplify_fused(function, node, [a, b, c]);
    }
    if let Some(number) = known(node.operation, x, y) {
        return Simple::Operand(function.constant(number).into());
    }
    let zero = |function: &mut Function| Simple::Operand(function.constant(0.0).into());
    match (node.operation, x, y) {
        (Operation::Add, Some(0.0), _) => Simple::Operand(b),
        (Operation::Add | Operation::Sub, _, Some(0.0)) => Simple::Operand(a),
        (Operation::Sub, _, _) if a == b => zero(function),
        (Operation::Sub, Some(0.0), _) => match minus_of(function, b) {
            Some(positive) => Simple::Operand(positive),
            None => Simple::Node(node),
        },
        (Operation::Mul, Some(0.0), _) | (Operation::Mul, _, Some(0.0)) => zero(function),
        (Operation::Mul, Some(1.0), _) => Simple::Operand(b),
        (Operation::Mul | Operation::Div, _, Some(1.0)) => Simple::Operand(a),
        (Operation::Mul, Some(-1.0), _) => minus(function, node, b),
        (Operation::Mul | Operation::Div, _, Some(-1.0)) => minus(function, node, a),
        _ => Simple::Node(node),
    }
}

/// A fused operation that is a sum or a product, or less. Where its product is
/// known exactly, or a factor is 1 or -1, the result is rounded once in both
/// forms.
fn simplify_fused(function: &mut Function, node: Node, [a, b, c]: [Operand; 3]) -> Simple {
    let (x, y, z) = (function.number(a), function.number(b), function.number(c));
    let product = match (x, y) {
        (Some(0.0), _) | (_, Some(0.0)) => Some(function.constant(0.0).into()),
        (Some(1.0), _) => Some(b),
        (_, Some(1.0)) => Some(a),
        _ => known(Operation::Mul, x, y).map(|number| function.constant(number).into()),
    };
    let (operation, operands) = match (node.operation, product, z) {
        (operation, Some(product), _) => apart(operation, product, c),
        (Operation::Fma | Operation::Fms, None, Some(0.0)) => (Operation::Mul, [a, b]),
        _ => return Simple::Node(node),
    };
    simplify(
        function,
        Node {
            operation,
            operands: Operand::list(operands),
            ..node
        },
    )
}

/// `x` where the operand is `0 - x`.
fn minus_of(function: &Function, operand: Operand) -> Option<Operand> {
    let node = function.node(operand.value()?);
    let minus = node.operation == Operation::Sub && function.number(node.operands[0]) == Some(0.0);
    minus.then_some(node.operands[1])
}

fn minus(function: &mut Function, node: Node, operand: Operand) -> Simple {
    let zero = Operand::from(function.constant(0.0));
    Simple::Node(Node {
        operation: Operation::Sub,
        operands: Operand::list([zero, operand]),
        ..node
    })
}

/// The result of an operation on constants, where it is exact in binary32
/// and therefore in every format that holds binary32. Roots are left alone:
/// the prime field of the semantic check does not know their values.
pub(crate) fn known(operation: Operation, a: Option<f64>, b: Option<f64>) -> Option<f64> {
    let a = a.filter(|&number| is_binary32(number))?;
    let b = b.filter(|&number| is_binary32(number))?;
    // Sums, differences and products of binary32 numbers whose result is a
    // binary32 number are exact: a product has at most 48 bits, and a sum
    // that loses bits in binary64 cannot end on a binary32 number without
    // the check below failing.
    let result = match operation {
        Operation::Add => a + b,
        Operation::Sub => a - b,
        Operation::Mul => a * b,
        Operation::Div if b != 0.0 => a / b,
        _ => return None,
    };
    let exact = match operation {
        Operation::Add => result - a == b && result - b == a,
        Operation::Sub => result + b == a && a - result == b,
        Operation::Div => result * b == a,
        _ => true,
    };
    (exact && is_binary32(result)).then_some(result)
}

fn is_binary32(number: f64) -> bool {
    f64::from(number as f32) == number
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_combined_only_where_that_is_exact() {
        let known = |operation, a, b| known(operation, Some(a), Some(b));
        assert_eq!(known(Operation::Add, 1.0, 0.5), Some(1.5));
        assert_eq!(known(Operation::Mul, 2.0, -0.5), Some(-1.0));
        assert_eq!(known(Operation::Div, 1.0, 4.0), Some(0.25));
        assert_eq!(known(Operation::Div, 1.0, 3.0), None);
        assert_eq!(known(Operation::Add, 1.0, 1e-30), None);
        assert_eq!(known(Operation::Add, 0.1, 0.2), None);
        assert_eq!(known(Operation::Div, 1.0, 0.0), None);
        assert_eq!(known(Operation::Sqrt, 2.25, 0.0), None);
    }
}
