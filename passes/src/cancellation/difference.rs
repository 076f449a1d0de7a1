//! The difference of two sums, without the terms they have in common.

use crate::sums::terms::cancel;
use robovec_framework::rewrite::Rewriter;
use robovec_ir::{Function, Operand, Operation};

/// No longer sums are taken apart.
const TERMS: usize = 256;

/// A difference of two values.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Difference {
    /// The terms, and which are subtracted.
    terms: Vec<(Operand, bool)>,
    /// A number that is added.
    number: f64,
}

impl Difference {
    /// The difference, taken apart where that cancels something.
    pub(super) fn new(function: &Function, a: Operand, b: Operand) -> Difference {
        let plain = Difference {
            terms: vec![(a, false), (b, true)],
            number: 0.0,
        };
        let mut open = vec![(b, true), (a, false)];
        let mut terms: Vec<(Operand, bool)> = Vec::new();
        let (mut number, mut literals) = (0.0, 0);
        while let Some((operand, minus)) = open.pop() {
            if terms.len() + open.len() > TERMS {
                return plain;
            }
            if let Some(literal) = function.number(operand) {
                let literal = if minus { -literal } else { literal };
                match exact_sum(number, literal) {
                    Some(sum) => (number, literals) = (sum, literals + 1),
                    None => return plain,
                }
                continue;
            }
            let node = operand.value().map(|value| function.node(value));
            match node.map(|node| (node.operation, node.operands)) {
                Some((Operation::Add, [a, b, _])) => open.extend([(b, minus), (a, minus)]),
                Some((Operation::Sub, [a, b, _])) => open.extend([(b, !minus), (a, minus)]),
                _ => terms.push((operand, minus)),
            }
        }
        let before = terms.len();
        cancel(&mut terms, |(operand, minus)| (operand, !minus));
        if terms.len() < before || literals > 1 {
            Difference { terms, number }
        } else {
            plain
        }
    }

    pub(super) fn number(&self) -> Option<f64> {
        self.terms.is_empty().then_some(self.number)
    }

    /// Writes its operations.
    pub(super) fn write(
        &self,
        rewriter: &mut Rewriter<'_>,
        push: &mut impl FnMut(&mut Rewriter<'_>, Operation, [Operand; 2]) -> Operand,
    ) -> Operand {
        // What is added comes first, so that nothing is negated.
        let mut terms = self.terms.clone();
        terms.sort_by_key(|(_, minus)| *minus);
        let added = terms.first().is_some_and(|(_, minus)| !minus);
        let number = Operand::from(rewriter.new.constant(self.number));
        let mut sum = (!added || self.number != 0.0).then_some(number);
        for (term, minus) in terms {
            let term = rewriter.translate(term);
            let operation = if minus {
                Operation::Sub
            } else {
                Operation::Add
            };
            sum = Some(match sum {
                None => term,
                Some(sum) => push(rewriter, operation, [sum, term]),
            });
        }
        sum.unwrap_or(number)
    }
}

/// The sum of two numbers where it is not rounded.
fn exact_sum(a: f64, b: f64) -> Option<f64> {
    let sum = a + b;
    let part = sum - a;
    let error = (a - (sum - part)) + (b - part);
    (error == 0.0).then_some(sum)
}
