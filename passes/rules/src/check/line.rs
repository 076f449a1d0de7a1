//! The nodes of a rule on random lines, as quotients of polynomials.
//!
//! The variables run along a straight line; a variable under a root runs
//! along the square of one, so that its root is a line. The point of the
//! circle of each angle runs along its rational parametrisation,
//! `(1 - u², 2u) / (1 + u²)` with a line `u`, turned by some angle: the one
//! point that it leaves out is then another one in each of several charts, and
//! with one chart more than there are angles every combination of angles lies
//! in some chart. Other roots are their own lines. All that is concluded
//! holds more generally than for real angles and roots.

use super::super::pattern::PatternNode;
use super::facts::NodeFacts;
use super::field::{RuleField, RuleResidue};
use super::polynomial::{ModularPolynomial, common, divide, negative, product, sum, without};
use robovec_ir::Operation;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::field::Modulus;
use robovec_num::random::Random;

/// More angles than in any rule that makes sense.
const MAX_ANGLES: usize = 5;

/// Numerator and denominator; `None` where they grew too large.
type Quotient = Option<(ModularPolynomial, ModularPolynomial)>;

/// All nodes in each chart.
pub(super) struct Lines {
    modulus: Modulus,
    /// For each chart, all nodes; empty when there are too many angles.
    charts: Vec<Vec<Quotient>>,
}

impl Lines {
    pub(super) fn of(facts: &NodeFacts<'_>) -> Lines {
        let (field, values) = &facts.points[0];
        let modulus = field.modulus();
        let nodes = &facts.joined.pattern.nodes;
        let mut angles: Vec<u64> = nodes
            .iter()
            .filter_map(|node| match *node {
                PatternNode::Operation(Operation::Sin | Operation::Cos, [a, _]) => {
                    let angle = values[a as usize].value;
                    Some(angle.min(modulus.neg(angle)))
                }
                _ => None,
            })
            .collect();
        angles.sort_unstable();
        angles.dedup();
        let charts = match angles.len() {
            count if count <= MAX_ANGLES => 0..count as u64 + 1,
            _ => 0..0,
        };
        Lines {
            modulus,
            charts: charts
                .map(|chart| nodes_of_chart(facts, field, values, chart))
                .collect(),
        }
    }

    /// True when a node is nowhere zero: when all its factors are factors of
    /// known nonzero numbers.
    pub(super) fn is_nonzero(&self, facts: &NodeFacts<'_>, node: usize) -> bool {
        !self.charts.is_empty()
            && self.charts.iter().all(|chart| {
                let Some((numerator, denominator)) = &chart[node] else {
                    return false;
                };
                if numerator.is_empty() {
                    return false;
                }
                let modulus = self.modulus;
                let shared = common(modulus, numerator, denominator);
                let mut left = divide(modulus, numerator, &shared).0;
                for (other, quotient) in chart[..facts.defined].iter().enumerate() {
                    let Some((numerator, denominator)) = quotient else {
                        continue;
                    };
                    left = without(modulus, &left, denominator);
                    if facts.ranges[other].nonzero && !numerator.is_empty() {
                        left = without(modulus, &left, numerator);
                    }
                }
                left.len() == 1
            })
    }
}

fn line(modulus: Modulus, thing: u64, number: u64) -> ModularPolynomial {
    let mut random = Random::new(number ^ thing.rotate_left(60));
    vec![modulus.number(random.bits()), modulus.number(random.bits())]
}

fn nodes_of_chart(
    facts: &NodeFacts<'_>,
    field: &RuleField,
    values: &[RuleResidue],
    chart: u64,
) -> Vec<Quotient> {
    let modulus = field.modulus();
    let nodes = &facts.joined.pattern.nodes;
    let under_root = |variable: u32| {
        nodes.iter().any(|node| match *node {
            PatternNode::Operation(Operation::Sqrt, [a, _]) => {
                nodes[a as usize] == PatternNode::Variable(variable)
            }
            _ => false,
        })
    };
    let one = vec![modulus.number(1)];
    let mut quotients: Vec<Quotient> = Vec::with_capacity(nodes.len());
    for node in nodes {
        let quotient = match *node {
            PatternNode::Number(number) => Some((constant(field, number), one.clone())),
            PatternNode::Variable(variable) => {
                let straight = line(modulus, 1, u64::from(variable));
                if under_root(variable) {
                    product(modulus, &straight, &straight)
                } else {
                    Some(straight)
                }
                .map(|numerator| (numerator, one.clone()))
            }
            PatternNode::Operation(operation, [a, b]) => {
                let angle = values[a as usize].value;
                match operation {
                    Operation::Sin | Operation::Cos => wave(modulus, operation, angle, chart),
                    Operation::Sqrt => {
                        let root = match nodes[a as usize] {
                            PatternNode::Variable(variable) => {
                                line(modulus, 1, u64::from(variable))
                            }
                            _ => line(modulus, 2, angle),
                        };
                        Some((root, one.clone()))
                    }
                    _ => {
                        let operands = (&quotients[a as usize], &quotients[b as usize]);
                        match operands {
                            (Some(a), Some(b)) => rational(modulus, operation, a, b),
                            _ => None,
                        }
                    }
                }
            }
        };
        quotients.push(quotient);
    }
    quotients
}

fn constant(field: &RuleField, number: f64) -> ModularPolynomial {
    match field.literal(number).value {
        0 => Vec::new(),
        value => vec![value],
    }
}

/// Sine or cosine on a chart of the circle.
fn wave(modulus: Modulus, operation: Operation, angle: u64, chart: u64) -> Quotient {
    let opposite = modulus.neg(angle);
    let u = line(modulus, 3, angle.min(opposite));
    let one = vec![modulus.number(1)];
    let square = product(modulus, &u, &u)?;
    let denominator = sum(modulus, &one, &square);
    let cosine = sum(modulus, &one, &negative(modulus, &square));
    let sine = sum(modulus, &u, &u);
    // Turned by the angle whose half has this tangent.
    let tangent = modulus.number(chart);
    let tangent_square = modulus.mul(tangent, tangent);
    let scale = modulus.invert(modulus.add(modulus.number(1), tangent_square));
    let c = vec![modulus.mul(modulus.sub(modulus.number(1), tangent_square), scale)];
    let s = vec![modulus.mul(modulus.add(tangent, tangent), scale)];
    let mixed = |p: &ModularPolynomial, q: &ModularPolynomial| -> Option<ModularPolynomial> {
        let (first, second) = (product(modulus, p, &cosine)?, product(modulus, q, &sine)?);
        Some(sum(modulus, &first, &second))
    };
    let numerator = match operation {
        Operation::Cos => mixed(&c, &negative(modulus, &s))?,
        _ if angle == opposite => Vec::new(),
        _ if angle < opposite => mixed(&s, &c)?,
        _ => negative(modulus, &mixed(&s, &c)?),
    };
    Some((numerator, denominator))
}

fn rational(
    modulus: Modulus,
    operation: Operation,
    (p, q): &(ModularPolynomial, ModularPolynomial),
    (r, s): &(ModularPolynomial, ModularPolynomial),
) -> Quotient {
    let times = |a: &ModularPolynomial, b: &ModularPolynomial| product(modulus, a, b);
    let added = |r: &ModularPolynomial| {
        if q == s {
            Some((sum(modulus, p, r), q.clone()))
        } else {
            Some((sum(modulus, &times(p, s)?, &times(r, q)?), times(q, s)?))
        }
    };
    match operation {
        Operation::Copy => Some((p.clone(), q.clone())),
        Operation::Neg => Some((negative(modulus, p), q.clone())),
        Operation::Add => added(r),
        Operation::Sub => added(&negative(modulus, r)),
        Operation::Mul => Some((times(p, r)?, times(q, s)?)),
        Operation::Div if r.is_empty() => None,
        Operation::Div => Some((times(p, s)?, times(q, r)?)),
        _ => None,
    }
}
