//! The numbers on the edges of a linearised graph, and their algebra.
//!
//! The known form of a weight: one, a constant, a value, each of either sign.
//! Products with one cost nothing, signs are deferred until the number is
//! needed, and an existing operation is used again.

use crate::cse::{Key, KnownValues};
use crate::fold::known;
use crate::sums::groups::GroupFamily;
use crate::sums::writer::joining;
use robovec_ir::{FreshNames, Function, Name, Node, Operand, Operation, SourceSet, Symbol, Value};

/// A weight that is not zero.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct PathWeight {
    pub(super) negative: bool,
    /// `None` represents one. A constant is positive and not one.
    pub(super) factor: Option<Operand>,
}

impl PathWeight {
    pub(super) const ONE: PathWeight = PathWeight {
        negative: false,
        factor: None,
    };

    /// The weight, negated on request.
    pub(super) fn flip(self, flip: bool) -> PathWeight {
        PathWeight {
            negative: self.negative ^ flip,
            ..self
        }
    }
}

/// Names and sources of the operations for a derivative.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartialOrigin {
    pub(super) base: Symbol,
    pub(super) sources: SourceSet,
    /// The rule they are noted with.
    pub(super) rule: &'static str,
}

/// Writes operations after those of a function.
#[derive(Clone)]
pub(super) struct WeightWriter {
    pub(super) function: Function,
    known: KnownValues,
    names: FreshNames,
    /// The rule of every value that was written.
    pub(super) rules: Vec<(Name, &'static str)>,
}

impl WeightWriter {
    pub(super) fn new(function: Function) -> WeightWriter {
        let mut known = KnownValues::with_capacity(2 * function.nodes().len());
        for (value, node) in function.values() {
            let key = Key::new(node.operation, node.operands);
            known.find_or_insert(&function, key, value);
        }
        WeightWriter {
            names: function.fresh_names(),
            function,
            known,
            rules: Vec::new(),
        }
    }

    /// The number of operations so far.
    pub(super) fn len(&self) -> usize {
        self.function.nodes().len()
    }

    /// The weight of an operand; `None` for zero.
    pub(super) fn weight(&mut self, operand: Operand) -> Option<PathWeight> {
        match self.function.number(operand) {
            None => Some(PathWeight {
                negative: false,
                factor: Some(operand),
            }),
            Some(number) => self.constant(number),
        }
    }

    fn constant(&mut self, number: f64) -> Option<PathWeight> {
        let size = number.abs();
        let factor = (size != 1.0).then(|| self.function.constant(size).into());
        (number != 0.0).then_some(PathWeight {
            negative: number < 0.0,
            factor,
        })
    }

    /// The number of a weight that is one, without its sign.
    fn operand(&mut self, weight: PathWeight) -> Operand {
        let one = || self.function.constant(1.0).into();
        weight.factor.unwrap_or_else(one)
    }

    /// The product of two weights along a path.
    pub(super) fn product(
        &mut self,
        a: PathWeight,
        b: PathWeight,
        origin: PartialOrigin,
    ) -> PathWeight {
        let negative = a.negative ^ b.negative;
        let factor = match (a.factor, b.factor) {
            (factor, None) | (None, factor) => factor,
            (Some(a), Some(b)) => {
                let numbers = [a, b].map(|operand| self.function.number(operand));
                match known(Operation::Mul, numbers[0], numbers[1]) {
                    // An exact product of numbers that are not zero is not.
                    Some(number) if number != 0.0 => {
                        (number != 1.0).then(|| self.function.constant(number).into())
                    }
                    _ => Some(self.operation(Operation::Mul, [a, b], origin)),
                }
            }
        };
        PathWeight { negative, factor }
    }

    /// The sum of the weights of two paths; `None` when they cancel.
    pub(super) fn sum(
        &mut self,
        a: PathWeight,
        b: PathWeight,
        origin: PartialOrigin,
    ) -> Option<PathWeight> {
        if a == b.flip(true) {
            return None;
        }
        let [x, y] = [a, b].map(|weight| self.operand(weight));
        let number = |weight: PathWeight, operand: Operand| {
            let number = self.function.number(operand)?;
            Some(if weight.negative { -number } else { number })
        };
        if let Some(number) = known(Operation::Add, number(a, x), number(b, y)) {
            return self.constant(number);
        }
        let terms = [(x, a.negative), (y, b.negative)];
        let (operation, operands, negative) = joining(GroupFamily::Sum, terms, false);
        let swapped = Key::new(operation, [operands[1], operands[0]]);
        let turned = operation == Operation::Sub;
        let factor = match self.known.find(&self.function, swapped) {
            // What is there with the other sign is there.
            Some(value) if turned => {
                return Some(PathWeight {
                    negative: !negative,
                    factor: Some(value.into()),
                });
            }
            _ => self.operation(operation, operands, origin),
        };
        Some(PathWeight {
            negative,
            factor: Some(factor),
        })
    }

    /// The operand that holds a weight with its sign.
    pub(super) fn signed(&mut self, weight: PathWeight, origin: PartialOrigin) -> Operand {
        let operand = self.operand(weight);
        match (weight.negative, self.function.number(operand)) {
            (false, _) => operand,
            (true, Some(number)) => self.function.constant(-number).into(),
            (true, None) => {
                let zero = self.function.constant(0.0).into();
                self.operation(Operation::Sub, [zero, operand], origin)
            }
        }
    }

    /// An operation on operands, once.
    pub(super) fn operation<const COUNT: usize>(
        &mut self,
        operation: Operation,
        operands: [Operand; COUNT],
        origin: PartialOrigin,
    ) -> Operand {
        let key = Key::new(operation, operands);
        if let Some(value) = self.known.find(&self.function, key) {
            return value.into();
        }
        let name = self.names.fresh(origin.base);
        self.rules.push((name, origin.rule));
        let value: Value = self.function.push(Node {
            name,
            sources: origin.sources,
            operands: Operand::list(operands),
            operation,
        });
        self.known.insert(&self.function, value);
        value.into()
    }
}
