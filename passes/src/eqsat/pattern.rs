//! Rules as the e-graph sees them: patterns over signed bags.

use robovec_ir::Operation;

/// A pattern: sums and products as wide as they are written, signs outside.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Bag {
    /// Stands for any value.
    Variable(u32),
    /// This number, by its bits; never negative.
    Number(u64),
    /// The sum of these.
    Sum(Vec<Signed>),
    /// The product of these; the sign of a product stands outside it.
    Product(Vec<Bag>),
    /// Any other operation.
    Other(Operation, Vec<Signed>),
}

/// A pattern with a sign.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct Signed {
    pub(crate) bag: Bag,
    pub(crate) negative: bool,
}

impl Signed {
    pub(crate) fn variable(number: u32) -> Signed {
        Bag::Variable(number).into()
    }

    pub(crate) fn number(number: f64) -> Signed {
        Signed {
            bag: Bag::Number(if number == 0.0 {
                0
            } else {
                number.abs().to_bits()
            }),
            negative: number < 0.0,
        }
    }

    fn turned(self, negative: bool) -> Signed {
        Signed {
            bag: self.bag,
            negative: self.negative ^ negative,
        }
    }

    /// One operation on patterns, in normal form: sums of sums and products
    /// of products are one, terms and factors are sorted.
    pub(crate) fn operation(operation: Operation, mut operands: Vec<Signed>) -> Signed {
        match operation {
            Operation::Copy => operands.swap_remove(0),
            Operation::Neg => operands.swap_remove(0).turned(true),
            Operation::Add | Operation::Sub => {
                let minus = operation == Operation::Sub;
                let mut summands = Vec::new();
                for (place, operand) in operands.into_iter().enumerate() {
                    let operand = operand.turned(minus && place == 1);
                    match operand.bag {
                        Bag::Sum(inner) => summands
                            .extend(inner.into_iter().map(|term| term.turned(operand.negative))),
                        // Adding zero is no part of a pattern.
                        Bag::Number(0) => {}
                        _ => summands.push(operand),
                    }
                }
                match summands.len() {
                    0 => Signed::number(0.0),
                    1 => summands.swap_remove(0),
                    _ => {
                        summands.sort();
                        Bag::Sum(summands).into()
                    }
                }
            }
            Operation::Mul => {
                let mut factors = Vec::new();
                let mut negative = false;
                for operand in operands {
                    negative ^= operand.negative;
                    match operand.bag {
                        Bag::Product(inner) => factors.extend(inner),
                        other => factors.push(other),
                    }
                }
                factors.sort();
                Signed {
                    bag: Bag::Product(factors),
                    negative,
                }
            }
            _ => Bag::Other(operation, operands).into(),
        }
    }
}

impl From<Bag> for Signed {
    fn from(bag: Bag) -> Signed {
        Signed {
            bag,
            negative: false,
        }
    }
}

/// A rule over bags.
#[derive(Clone, Debug)]
pub(crate) struct BagRule {
    pub(crate) name: String,
    pub(crate) left: Signed,
    pub(crate) right: Signed,
    /// Number of variables.
    pub(crate) variables: usize,
}

impl BagRule {
    /// True when both sides are the same bag: what associativity,
    /// commutativity and the rules of signs say is true of bags by
    /// themselves.
    pub(crate) fn is_trivial(&self) -> bool {
        self.left == self.right
    }
}
