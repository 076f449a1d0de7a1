//! Cost of arithmetic in a number format, for comparing formats.
//!
//! A multiplier has as many cells as the square of the bits of the significand,
//! an adder and a word as many as bits; operations computed in a loop of
//! multiplications count as a multiplier. This is the one account of it: the
//! pass `mixed` chooses formats by it, and stress tests compare treatments. The
//! resources that a machine takes of a device are counted by parts instead
//! (`robovec_fpga::hardware`), whose blocks come in whole numbers.

use crate::function::Function;
use robovec_num::format::Format;
use robovec_num::operation::Operation;
use std::ops::{Add, Mul};

/// Arithmetic without a format: the number of operations that cost the square
/// of the bits, and of those that cost the bits.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub struct OperationWork {
    /// Products, quotients, roots.
    pub products: f64,
    /// Sums, and values that are only stored.
    pub sums: f64,
}

impl OperationWork {
    /// Work of a number of products and sums.
    pub const fn new(products: f64, sums: f64) -> OperationWork {
        OperationWork { products, sums }
    }

    /// That of one operation.
    pub fn of_operation(operation: Operation) -> OperationWork {
        match operation {
            Operation::Mul | Operation::Div | Operation::Sqrt => OperationWork::new(1.0, 0.0),
            Operation::Fma | Operation::Fms | Operation::Fnma => OperationWork::new(1.0, 1.0),
            Operation::Add | Operation::Sub | Operation::Neg => OperationWork::new(0.0, 1.0),
            Operation::Copy | Operation::Sin | Operation::Cos => OperationWork::new(0.0, 1.0),
        }
    }

    /// That of all operations of a function.
    pub fn of(function: &Function) -> OperationWork {
        let nodes = function.nodes().iter();
        nodes.fold(OperationWork::default(), |all, node| {
            all + OperationWork::of_operation(node.operation)
        })
    }

    /// Cost in a format, in cells.
    pub fn cost(self, format: Format) -> f64 {
        let bits = f64::from(format.significand());
        self.products * bits * bits + self.sums * bits
    }
}

/// Cost of the operations of a function, in cells: each in the format of its
/// value, where it has one.
pub fn function_cost(function: &Function, format: Format) -> f64 {
    let Some(formats) = &function.formats else {
        return OperationWork::of(function).cost(format);
    };
    let nodes = function.values().map(|(value, node)| {
        let format = formats.get(value).unwrap_or(format);
        OperationWork::of_operation(node.operation).cost(format)
    });
    nodes.sum()
}

impl Add for OperationWork {
    type Output = OperationWork;

    fn add(self, other: OperationWork) -> OperationWork {
        OperationWork::new(self.products + other.products, self.sums + other.sums)
    }
}

impl Mul<f64> for OperationWork {
    type Output = OperationWork;

    fn mul(self, times: f64) -> OperationWork {
        OperationWork::new(self.products * times, self.sums * times)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_cost_the_square_and_sums_the_bits() {
        let [single, double] = [Format::BINARY32, Format::BINARY64];
        let product = OperationWork::of_operation(Operation::Mul);
        let sum = OperationWork::of_operation(Operation::Sub);
        let fused = OperationWork::of_operation(Operation::Fma);
        assert_eq!(product.cost(single), 576.0);
        assert_eq!(product.cost(double), 2809.0);
        assert_eq!(sum.cost(double), 53.0);
        assert_eq!(fused, product + sum);
        assert_eq!((fused * 2.0).cost(single), 1200.0);
    }
}
