//! A third evaluation with GNU MPFR (crate `rug`, feature `mpfr`), which
//! shares neither arithmetic nor code with the others.

use robovec_ir::plan::EvaluationPlan;
use robovec_ir::{Function, Operation};
use rug::Float;
use rug::ops::NegAssign;

/// The value of every assignment, in order, computed with this number of bits
/// and rounded to binary64 once.
///
/// # Panics
///
/// Panics when the number of `inputs` is not that of the function, or `bits` is
/// beyond the limit of MPFR.
pub fn evaluate(function: &Function, inputs: &[f64], bits: u32) -> Vec<f64> {
    let outputs = EvaluationPlan::new(function).run_with(
        inputs,
        |number| Float::with_val(bits, number),
        |operation, operands| apply(operation, operands, bits),
    );
    outputs.iter().map(Float::to_f64).collect()
}

fn apply(operation: Operation, [a, b, c]: [&Float; 3], bits: u32) -> Float {
    match operation {
        Operation::Copy => a.clone(),
        Operation::Neg => Float::with_val(bits, -a),
        Operation::Add => Float::with_val(bits, a + b),
        Operation::Sub => Float::with_val(bits, a - b),
        Operation::Mul => Float::with_val(bits, a * b),
        Operation::Div => Float::with_val(bits, a / b),
        Operation::Sin => Float::with_val(bits, a.sin_ref()),
        Operation::Cos => Float::with_val(bits, a.cos_ref()),
        Operation::Sqrt => Float::with_val(bits, a.sqrt_ref()),
        Operation::Fma => Float::with_val(bits, a.mul_add_ref(b, c)),
        Operation::Fms => Float::with_val(bits, a.mul_sub_ref(b, c)),
        Operation::Fnma => {
            let mut difference = Float::with_val(bits, a.mul_sub_ref(b, c));
            difference.neg_assign();
            difference
        }
    }
}
