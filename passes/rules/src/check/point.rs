//! Both sides of a rule at one point of the reals, with certainty.

use super::super::pattern::{Pattern, PatternNode};
use super::super::rule::Rule;
use super::ball::ScaledBall;
use super::field::{RuleField, RuleResidue};
use robovec_ir::Operation;

#[derive(Clone, PartialEq, Debug)]
pub(super) enum SideValue {
    /// The numbers of all nodes.
    Defined(Vec<ScaledBall>),
    /// Some operation is not defined for certain: a division by zero, the
    /// root of a negative number.
    Undefined,
    /// Too close to such a place to decide.
    Unknown,
}

impl SideValue {
    /// The numbers of all nodes, where they are defined.
    pub(super) fn numbers(self) -> Option<Vec<ScaledBall>> {
        match self {
            SideValue::Defined(numbers) => Some(numbers),
            SideValue::Undefined | SideValue::Unknown => None,
        }
    }

    /// The value of the whole side.
    pub(super) fn value(self) -> Option<ScaledBall> {
        self.numbers()?.last().copied()
    }
}

#[derive(Clone, Debug)]
pub(super) struct RealPoint {
    /// The variables.
    pub(super) values: Vec<f64>,
    /// The largest distance of each variable from its value.
    pub(super) radii: Vec<f64>,
}

impl RealPoint {
    /// Exactly these numbers.
    pub(super) fn exactly(values: Vec<f64>) -> RealPoint {
        RealPoint {
            radii: vec![0.0; values.len()],
            values,
        }
    }

    /// True when the conditions of a rule hold, on all of a place.
    pub(super) fn meets(&self, rule: &Rule) -> bool {
        assert_eq!(
            self.values.len(),
            self.radii.len(),
            "every number has a radius"
        );
        rule.conditions.iter().all(|condition| {
            let variable = condition.variable as usize;
            let (value, radius) = (self.values[variable], self.radii[variable]);
            [value - radius, value + radius]
                .iter()
                .all(|&end| condition.requirement.holds_for(end))
                && (value.abs() > radius || radius == 0.0)
        })
    }
}

/// Evaluates a pattern in balls. Whether a number that can be zero is zero is
/// decided by two prime fields.
pub(super) fn evaluate(pattern: &Pattern, place: &RealPoint, fields: &[RuleField; 2]) -> SideValue {
    let mut numbers: Vec<ScaledBall> = Vec::with_capacity(pattern.nodes.len());
    let mut zeros = Zeros {
        pattern,
        place,
        fields,
        residues: None,
    };
    for node in &pattern.nodes {
        let number = match *node {
            PatternNode::Variable(variable) => {
                let variable = variable as usize;
                ScaledBall::between(place.values[variable], place.radii[variable])
            }
            PatternNode::Number(number) => ScaledBall::exact(number),
            PatternNode::Operation(operation, [first, second]) => {
                let (a, b) = (numbers[first as usize], numbers[second as usize]);
                match operation {
                    Operation::Div => match a.over(b) {
                        Some(quotient) => quotient,
                        None if zeros.is_zero(second) => return SideValue::Undefined,
                        None => return SideValue::Unknown,
                    },
                    Operation::Sqrt => match a.sign() {
                        1 => a.root(),
                        0 if zeros.is_zero(first) => ScaledBall::exact(0.0),
                        0 => return SideValue::Unknown,
                        _ => return SideValue::Undefined,
                    },
                    _ => total(operation, a, b),
                }
            }
        };
        numbers.push(number);
    }
    SideValue::Defined(numbers)
}

/// An operation that is defined everywhere.
fn total(operation: Operation, a: ScaledBall, b: ScaledBall) -> ScaledBall {
    match operation {
        Operation::Neg => a.negative(),
        Operation::Add => a.plus(b),
        Operation::Sub => a.plus(b.negative()),
        Operation::Mul | Operation::Fma | Operation::Fms => a.times(b),
        Operation::Fnma => a.times(b).negative(),
        Operation::Sin => a.sine(),
        Operation::Cos => a.cosine(),
        // The partial ones are not for this.
        Operation::Copy | Operation::Div | Operation::Sqrt => a,
    }
}

/// Decides which nodes are exactly zero, on the first request.
struct Zeros<'a> {
    pattern: &'a Pattern,
    place: &'a RealPoint,
    fields: &'a [RuleField; 2],
    residues: Option<[Vec<RuleResidue>; 2]>,
}

impl Zeros<'_> {
    /// True when a node that may be zero is zero at this point. A number that
    /// is zero in both fields is zero unless two primes near 2⁶¹, drawn from
    /// the rule, divide its numerator.
    fn is_zero(&mut self, node: u32) -> bool {
        if self.place.radii.iter().any(|&radius| radius > 0.0) {
            return false;
        }
        let residues = self.residues.get_or_insert_with(|| {
            self.fields.map(|field| {
                use robovec_num::arithmetic::Arithmetic;
                let literal = |&value: &f64| field.literal(value);
                let inputs: Vec<RuleResidue> = self.place.values.iter().map(literal).collect();
                self.pattern.evaluate_all(&field, &inputs)
            })
        });
        residues.iter().all(|all| all[node as usize].value == 0)
    }
}
