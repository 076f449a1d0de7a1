//! A function whose constants were rounded, beside the one that computes them.

use robovec_analysis::reference::{ReferenceEffort, ReferenceEvaluator};
use robovec_ir::{Function, Operand, OperandKind, Operation, Output, View};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::ball::{Ball, Balls};

/// The largest relative distance of a rounded constant from its value, for any
/// value within its bound: one unit in the last place of binary64, twice the
/// error of one rounding.
const TOLERANCE: f64 = f64::EPSILON;

/// Tests whether a function is its witness with constants instead of constant
/// expressions: the witness computes these first, from numbers alone, and the
/// rest is operation for operation the same.
pub(super) fn compare(witness: &Function, after: View<'_>) -> Result<(), String> {
    let function = after.function;
    let extra = witness.nodes().len().checked_sub(function.nodes().len());
    let extra = extra.ok_or("it has operations that its witness has not")?;
    let numbers = numbers(witness, extra)?;
    let same = |new: Operand, old: Operand| match (new.kind(), old.kind()) {
        (OperandKind::Value(new), OperandKind::Value(old)) => new.index() + extra == old.index(),
        (OperandKind::Constant(new), _) => {
            let number = function.constant_number(new);
            match value(witness, &numbers, old) {
                Some(value) => is_rounded(number, value),
                None => false,
            }
        }
        (new, old) => new == old,
    };
    for (new, old) in function.nodes().iter().zip(&witness.nodes()[extra..]) {
        let mut operands = new.operands.into_iter().zip(old.operands);
        if new.operation != old.operation || !operands.all(|(new, old)| same(new, old)) {
            let name = new.name;
            return Err(if name.is_none() {
                "an operation is not that of its witness".to_owned()
            } else {
                format!(
                    "{} is not what it is in its witness",
                    name.display(&after.tables.symbols)
                )
            });
        }
    }
    let mut outputs = function.assignments.iter().zip(&witness.assignments);
    if function.assignments.len() != witness.assignments.len()
        || !outputs.all(|(new, old)| new.output == old.output && same(new.operand, old.operand))
    {
        return Err("an output is not that of its witness".to_owned());
    }
    Ok(())
}

/// The largest part of an array's largest element by which rounding constants
/// may move its elements: far above the effect of rounding on a sum or product
/// of them, far below that on the sine of a large one.
pub const LARGEST_MOVE: f64 = 1.0 / (1u64 << 30) as f64;

/// Operations up to which exact values are certified.
const LARGEST_CERTIFIED: usize = 20_000;

/// The distance by which rounding the constants of a witness moves outputs, as
/// a part of the largest element of their array over all states, and the output
/// that is moved farthest. Exact values are certified up to 20,000 operations.
pub fn moved(witness: View<'_>, after: View<'_>, states: &[Vec<f64>]) -> (f64, Option<Output>) {
    let effort = if after.function.nodes().len() > LARGEST_CERTIFIED {
        ReferenceEffort::DoubleDouble
    } else {
        ReferenceEffort::Certified
    };
    let [exact, rounded] = [witness, after]
        .map(|view| ReferenceEvaluator::new(view.function, effort).evaluate(states));
    let mut sizes = vec![(0.0f64, 0.0f64, None); after.function.outputs().len()];
    for (exact, rounded) in exact.into_iter().zip(rounded) {
        let outputs = exact
            .into_iter()
            .zip(rounded)
            .zip(&after.function.assignments);
        for ((exact, rounded), assignment) in outputs {
            let output = assignment.output;
            let array = after.function.output_array(output);
            let (exact, rounded) = (exact.value, rounded.value);
            let distance = (rounded - exact).high.abs();
            let (largest, farthest, worst) = &mut sizes[array];
            if distance.is_finite() {
                *largest = largest.max(exact.high.abs());
            }
            if distance.is_finite() && distance > *farthest {
                (*farthest, *worst) = (distance, Some(output));
            }
        }
    }
    let moved = sizes.into_iter().filter(|(_, farthest, _)| *farthest > 0.0);
    let moved = moved.map(|(largest, farthest, worst)| (farthest / largest, worst));
    moved
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((0.0, None))
}

fn is_rounded(number: f64, value: Ball<1>) -> bool {
    let middle = value.value.high[0];
    if !middle.is_finite() {
        // Numbers that are not finite were written so.
        return number == middle || number.is_nan() && middle.is_nan();
    }
    let distance = value.distance(&Ball::exact([number]), 0);
    distance + value.radius[0] <= TOLERANCE * number.abs()
}

/// The value of an operand that depends on numbers alone.
fn value(witness: &Function, numbers: &[Ball<1>], operand: Operand) -> Option<Ball<1>> {
    match operand.kind() {
        OperandKind::Value(value) => numbers.get(value.index()).copied(),
        OperandKind::Constant(constant) => Some(Balls.literal(witness.constant_number(constant))),
        OperandKind::Input(_) | OperandKind::None => None,
    }
}

/// The values of the first nodes, which must depend on numbers alone.
fn numbers(witness: &Function, count: usize) -> Result<Vec<Ball<1>>, String> {
    let mut numbers: Vec<Ball<1>> = Vec::with_capacity(count);
    for node in &witness.nodes()[..count] {
        let operand = |place: usize| {
            let operand = node.operands[place.min(node.operation.arity() - 1)];
            value(witness, &numbers, operand).ok_or("a constant depends on an input")
        };
        let (a, b) = (operand(0)?, operand(1)?);
        let number = match node.operation {
            Operation::Add => Balls.add(a, b),
            Operation::Sub => Balls.sub(a, b),
            Operation::Mul => Balls.mul(a, b),
            Operation::Div => Balls.div(a, b),
            Operation::Sin => Balls.sin(a),
            Operation::Cos => Balls.cos(a),
            Operation::Sqrt => Balls.sqrt(a),
            Operation::Neg => Balls.neg(a),
            Operation::Copy => a,
            Operation::Fma | Operation::Fms | Operation::Fnma => {
                return Err("a constant is made by a fused operation".to_owned());
            }
        };
        numbers.push(number);
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_right_only_while_its_bound_says_so() {
        let [large, quarter] = [122f64.exp2(), 0.25].map(|number| Balls.literal(number));
        let sum = Balls.add(large, quarter);
        assert!(is_rounded(122f64.exp2(), sum));
        // A quarter is left over the real numbers, of which the middle of the
        // ball has nothing.
        let rest = Balls.sub(sum, large);
        assert!(!is_rounded(0.0, rest) && !is_rounded(0.25, rest));
        assert!(is_rounded(0.25, quarter) && !is_rounded(0.25000001, quarter));
        assert!(is_rounded(f64::INFINITY, Balls.literal(f64::INFINITY)));
        let undefined = Balls.div(quarter, rest);
        assert!(!is_rounded(undefined.value.high[0], undefined));
    }
}
