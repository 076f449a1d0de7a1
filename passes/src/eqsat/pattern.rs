//! Rules as the e-graph sees them: patterns over signed bags.

use robovec_analysis::class::NumericClass;
use robovec_ir::Operation;
use robovec_rules::{Condition, Pattern, PatternNode, Rule, RuleSet};

/// A pattern: sums and products in the widths written, signs outside.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Bag {
    /// Represents any value.
    Variable(u32),
    /// This number, by its bits; never negative.
    Number(u64),
    /// The sum of these.
    Sum(Vec<SignedPattern>),
    /// The product of these; the sign of a product is outside it.
    Product(Vec<Bag>),
    /// Any other operation.
    Other(Operation, Vec<SignedPattern>),
}

#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct SignedPattern {
    pub(crate) bag: Bag,
    pub(crate) negative: bool,
}

impl SignedPattern {
    pub(crate) fn variable(number: u32) -> SignedPattern {
        Bag::Variable(number).into()
    }

    pub(crate) fn number(number: f64) -> SignedPattern {
        SignedPattern {
            bag: Bag::Number(if number == 0.0 {
                0
            } else {
                number.abs().to_bits()
            }),
            negative: number < 0.0,
        }
    }

    fn turned(self, negative: bool) -> SignedPattern {
        SignedPattern {
            bag: self.bag,
            negative: self.negative ^ negative,
        }
    }

    /// One operation on patterns, in normal form: sums of sums and products
    /// of products are one, terms and factors are sorted.
    pub(crate) fn operation(
        operation: Operation,
        mut operands: Vec<SignedPattern>,
    ) -> SignedPattern {
        match operation {
            Operation::Copy => operands.swap_remove(0),
            Operation::Neg => operands.swap_remove(0).turned(true),
            Operation::Add | Operation::Sub => {
                let minus = operation == Operation::Sub;
                let mut summands = Vec::new();
                for (place, operand) in operands.into_iter().enumerate() {
                    let operand = operand.turned(minus && place == 1);
                    match operand.bag {
                        Bag::Sum(inner) => {
                            for term in inner {
                                add(&mut summands, term.turned(operand.negative));
                            }
                        }
                        // Adding zero is no part of a pattern.
                        Bag::Number(0) => {}
                        _ => add(&mut summands, operand),
                    }
                }
                match summands.len() {
                    0 => SignedPattern::number(0.0),
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
                        Bag::Number(ONE) => {}
                        other => factors.push(other),
                    }
                }
                factors.sort();
                let bag = match factors.len() {
                    _ if factors.contains(&Bag::Number(0)) => return SignedPattern::number(0.0),
                    0 => Bag::Number(ONE),
                    1 => factors.swap_remove(0),
                    _ => Bag::Product(factors),
                };
                SignedPattern { bag, negative }
            }
            // Signs come out of these, as they do in the e-graph.
            Operation::Div | Operation::Sin | Operation::Cos => {
                let odd = operands.iter().filter(|operand| operand.negative).count() % 2 == 1;
                for operand in &mut operands {
                    operand.negative = false;
                }
                SignedPattern {
                    bag: Bag::Other(operation, operands),
                    negative: odd && operation != Operation::Cos,
                }
            }
            _ => Bag::Other(operation, operands).into(),
        }
    }
}

impl SignedPattern {
    /// The pattern with the variables of a mask negated.
    fn flipped(&self, mask: u32) -> SignedPattern {
        let all = |parts: &[SignedPattern]| parts.iter().map(|part| part.flipped(mask)).collect();
        let flipped = match &self.bag {
            Bag::Variable(variable) => SignedPattern {
                bag: self.bag.clone(),
                negative: *variable < 32 && mask >> variable & 1 == 1,
            },
            Bag::Number(_) => self.bag.clone().into(),
            Bag::Sum(parts) => {
                let mut parts: Vec<SignedPattern> = all(parts);
                parts.sort();
                Bag::Sum(parts).into()
            }
            Bag::Product(factors) => {
                let parts: Vec<SignedPattern> = factors
                    .iter()
                    .map(|factor| SignedPattern::from(factor.clone()).flipped(mask))
                    .collect();
                SignedPattern::operation(Operation::Mul, parts)
            }
            Bag::Other(operation, parts) => SignedPattern::operation(*operation, all(parts)),
        };
        flipped.turned(self.negative)
    }
}

const ONE: u64 = 1.0f64.to_bits();

/// Adds a term to a sum, in which opposite terms cancel.
fn add(summands: &mut Vec<SignedPattern>, term: SignedPattern) {
    let opposite = term.clone().turned(true);
    match summands.iter().position(|other| *other == opposite) {
        Some(place) => {
            summands.swap_remove(place);
        }
        None => summands.push(term),
    }
}

impl From<&Pattern> for SignedPattern {
    fn from(pattern: &Pattern) -> SignedPattern {
        let mut parts: Vec<SignedPattern> = Vec::with_capacity(pattern.nodes.len());
        for node in &pattern.nodes {
            parts.push(match *node {
                PatternNode::Variable(variable) => SignedPattern::variable(variable),
                PatternNode::Number(number) => SignedPattern::number(number),
                PatternNode::Operation(operation, places) => {
                    let operands = places[..operation.arity()].iter();
                    let operands = operands.map(|&place| parts[place as usize].clone());
                    SignedPattern::operation(operation, operands.collect())
                }
            });
        }
        parts.pop().expect("a pattern has a root")
    }
}

impl From<Bag> for SignedPattern {
    fn from(bag: Bag) -> SignedPattern {
        SignedPattern {
            bag,
            negative: false,
        }
    }
}

/// A rule over bags.
#[derive(Clone, Debug)]
pub(crate) struct BagRule {
    pub(crate) name: String,
    pub(crate) left: SignedPattern,
    pub(crate) right: SignedPattern,
    /// Number of variables.
    pub(crate) variables: usize,
    pub(crate) conditions: Vec<Condition>,
}

impl BagRule {
    /// The rules of a set that change bags, in one direction each: not those
    /// whose sides are the same bag, as associativity, commutativity and the
    /// rules of signs are, nor those that would match every bag. Rules of a
    /// weaker class than allowed are left out.
    pub(crate) fn all(rules: &RuleSet, weakest: NumericClass) -> Vec<BagRule> {
        let allowed = rules.rules.iter().filter(|rule| rule.class <= weakest);
        let directed = allowed.flat_map(Rule::directed);
        let bags = directed.map(|rule| BagRule {
            left: SignedPattern::from(&rule.left),
            right: SignedPattern::from(&rule.right),
            variables: rule.variables.len(),
            conditions: rule.conditions,
            name: rule.name,
        });
        let mut known: Vec<(SignedPattern, SignedPattern)> = Vec::new();
        let new = |rule: &BagRule| {
            let sides = rule.sides();
            let is_new = !known.contains(&sides);
            known.push(sides);
            is_new || !rule.conditions.is_empty()
        };
        bags.filter(BagRule::is_useful).filter(new).collect()
    }

    /// Both sides with the signs of the variables chosen so that rules which
    /// differ in signs only have the same: a variable of a bag represents
    /// values of either sign, so `distribute-sub` is `distribute`.
    pub(crate) fn sides(&self) -> (SignedPattern, SignedPattern) {
        let masks = 0..1u32 << self.variables.min(6);
        let turned = masks.map(|mask| {
            let (left, right) = (self.left.flipped(mask), self.right.flipped(mask));
            let negative = left.negative;
            (left.turned(negative), right.turned(negative))
        });
        turned.min().expect("one of the masks turns nothing")
    }

    fn is_useful(&self) -> bool {
        let everything = matches!(self.left.bag, Bag::Variable(_) | Bag::Number(_));
        let bound = |variable| self.left.bag.has(variable);
        let closed = (0..self.variables as u32).all(|v| bound(v) || !self.right.bag.has(v));
        self.left != self.right && !everything && closed
    }
}

impl Bag {
    /// True when a variable occurs.
    fn has(&self, variable: u32) -> bool {
        match self {
            Bag::Variable(own) => *own == variable,
            Bag::Number(_) => false,
            Bag::Product(factors) => factors.iter().any(|bag| bag.has(variable)),
            Bag::Sum(parts) | Bag::Other(_, parts) => {
                parts.iter().any(|part| part.bag.has(variable))
            }
        }
    }
}
