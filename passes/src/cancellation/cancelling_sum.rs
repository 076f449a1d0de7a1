//! Sums of products, in which equal terms cancel.

use robovec_ir::{Function, Operand, Operation};
use std::collections::BTreeMap;

/// Maximum number of terms of a sum that is multiplied out.
const TERMS: usize = 256;

/// Maximum number of operands multiplied in a term.
const DEGREE: usize = 6;

/// Maximum depth to which operations are expanded.
const DEPTH: u32 = 64;

/// A sum of numbers times products of operands, exact in its numbers.
#[derive(Clone, PartialEq, Default, Debug)]
pub(super) struct CancellingSum {
    /// For every product, its operands in order, the number; none is zero.
    terms: BTreeMap<Vec<Operand>, f64>,
}

impl CancellingSum {
    /// One operand.
    fn single(operand: Operand) -> CancellingSum {
        CancellingSum {
            terms: BTreeMap::from([(vec![operand], 1.0)]),
        }
    }

    fn number(number: f64) -> CancellingSum {
        let mut constant = CancellingSum::default();
        if number != 0.0 {
            constant.terms.insert(Vec::new(), number);
        }
        constant
    }

    /// An operand, its sums and products multiplied out.
    pub(super) fn of(function: &Function, operand: Operand) -> CancellingSum {
        let mut work = 4 * TERMS;
        expanded(function, operand, DEPTH, &mut work)
    }

    /// The sum plus another one times a number; `None` where a number would be
    /// rounded, or there are too many terms.
    pub(super) fn plus(&self, other: &CancellingSum, factor: f64) -> Option<CancellingSum> {
        let mut sum = self.clone();
        for (product, number) in &other.terms {
            let added = exact_product(*number, factor)?;
            let before = sum.terms.remove(product).unwrap_or(0.0);
            let number = exact_sum(before, added)?;
            if number != 0.0 {
                sum.terms.insert(product.clone(), number);
            }
        }
        (sum.terms.len() <= TERMS).then_some(sum)
    }

    /// The product with another one; `None` as for a sum.
    pub(super) fn times(&self, other: &CancellingSum) -> Option<CancellingSum> {
        let mut sum = CancellingSum::default();
        for (product, number) in &self.terms {
            let mut part = CancellingSum::default();
            for (others, other) in &other.terms {
                let mut product = [product.as_slice(), others].concat();
                product.sort_unstable();
                if product.len() > DEGREE {
                    return None;
                }
                part.terms.insert(product, exact_product(*number, *other)?);
            }
            sum = sum.plus(&part, 1.0)?;
        }
        Some(sum)
    }

    /// The difference of two operands, multiplied out where that cancels
    /// something.
    pub(super) fn difference(function: &Function, a: Operand, b: Operand) -> CancellingSum {
        let [first, second] = [a, b].map(|operand| CancellingSum::of(function, operand));
        let whole = first.plus(&second, -1.0);
        let cancelled = whole.filter(|whole| whole.len() < first.len() + second.len());
        cancelled.unwrap_or_else(|| CancellingSum {
            terms: BTreeMap::from([(vec![a], 1.0), (vec![b], -1.0)]),
        })
    }

    /// Number of terms.
    pub(super) fn len(&self) -> usize {
        self.terms.len()
    }

    /// The number, if it is one.
    pub(super) fn as_number(&self) -> Option<f64> {
        match self.len() {
            0 => Some(0.0),
            1 => self.terms.get(&Vec::new()).copied(),
            _ => None,
        }
    }

    /// Two operands of which it is the difference, the minuend first.
    pub(super) fn as_difference(&self) -> Option<[Operand; 2]> {
        let [(a, first), (b, second)] = *self.terms.iter().collect::<Vec<_>>() else {
            return None;
        };
        match (a.as_slice(), b.as_slice(), *first, *second) {
            (&[a], &[b], 1.0, -1.0) => Some([a, b]),
            (&[a], &[b], -1.0, 1.0) => Some([b, a]),
            _ => None,
        }
    }

    /// The terms, those that are subtracted (of number -1) last.
    pub(super) fn ordered(&self) -> Vec<(&[Operand], f64)> {
        let terms = self.terms.iter();
        let mut terms: Vec<(&[Operand], f64)> = terms
            .map(|(product, number)| (product.as_slice(), *number))
            .collect();
        terms.sort_by_key(|(product, number)| {
            (*number == -1.0 && !product.is_empty(), product.is_empty())
        });
        terms
    }
}

/// An operand multiplied out as far as numbers stay exact and sums short.
fn expanded(function: &Function, operand: Operand, depth: u32, work: &mut usize) -> CancellingSum {
    if let Some(number) = function.number(operand) {
        return CancellingSum::number(number);
    }
    let single = || CancellingSum::single(operand);
    let Some(value) = operand.value().filter(|_| depth > 0 && *work > 0) else {
        return single();
    };
    *work -= 1;
    let node = function.node(value);
    let [a, b, _] = node.operands;
    let mut part = |operand| expanded(function, operand, depth - 1, work);
    let whole = match node.operation {
        Operation::Add => part(a).plus(&part(b), 1.0),
        Operation::Sub => part(a).plus(&part(b), -1.0),
        Operation::Neg => CancellingSum::default().plus(&part(a), -1.0),
        Operation::Mul => part(a).times(&part(b)),
        _ => None,
    };
    whole.unwrap_or_else(single)
}

/// The sum of two numbers if it is exact.
fn exact_sum(a: f64, b: f64) -> Option<f64> {
    let sum = a + b;
    let part = sum - a;
    let error = (a - (sum - part)) + (b - part);
    (error == 0.0).then_some(sum)
}

/// The product of two numbers if it is exact.
fn exact_product(a: f64, b: f64) -> Option<f64> {
    let product = a * b;
    let is_exact = product.is_normal() && a.mul_add(b, -product) == 0.0;
    is_exact.then_some(product)
}
