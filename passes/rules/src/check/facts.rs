//! The facts about the numbers of a rule wherever its left side is defined:
//! bounds, signs, and nonzero nodes.
//!
//! The left side divides by numbers that are not zero and takes roots of
//! numbers that are not negative; conditions state more. From there bounds go
//! up through the operations, and "not zero" goes down to the factors of a
//! product. Nodes that are multiples of each other, or squares, are found by
//! their values in prime fields.

use super::super::pattern::PatternNode;
use super::super::rule::Requirement;
use super::Doubt;
use super::agree::{MAX_TRIED, points_for};
use super::ball::ScaledBall;
use super::field::{RuleField, RuleResidue};
use super::joined::Joined;
use robovec_analysis::range::Range;
use robovec_ir::Operation;

/// Points at which nodes are compared where there are no roots.
const POINTS: usize = 6;
/// Points at which a node must be a square to be taken for one.
const SQUARES: u64 = 64;
/// Nodes up to which each is compared with each.
const MAX_COMPARED: usize = 160;

/// The known facts about all nodes.
pub(super) struct NodeFacts<'a> {
    pub(super) joined: &'a Joined<'a>,
    pub(super) ranges: Vec<Range>,
    /// Number of nodes that are known to be defined; of others nothing is used.
    pub(super) defined: usize,
    /// Points at which both sides are defined, with the field of each.
    pub(super) points: Vec<(RuleField, Vec<RuleResidue>)>,
    /// A node, an earlier one that is a multiple of it, and the factor's
    /// sign; 2 for a node of equal value.
    links: Vec<(usize, usize, i32)>,
    squares: Vec<Option<bool>>,
    /// Real numbers of all nodes where both sides are defined.
    reals: &'a [Vec<ScaledBall>],
}

/// The factor between nodes of equal value.
const SAME: i32 = 2;

/// Points of the fields at which both sides are defined: enough that every
/// combination of square and non-square roots occurs; `None` when there are too
/// few.
fn points(joined: &Joined<'_>) -> Option<Vec<(RuleField, Vec<RuleResidue>)>> {
    let [left, right] = joined.roots();
    let mut needed = POINTS;
    let mut points: Vec<(RuleField, Vec<RuleResidue>)> = Vec::new();
    for point in 0..MAX_TRIED {
        let field = joined.field(point);
        let values = joined.values(&field);
        if values[left].is_undefined() || values[right].is_undefined() {
            continue;
        }
        if points.is_empty() {
            needed = points_for(joined, &values).unwrap_or(needed as u32) as usize;
        }
        points.push((field, values));
        if points.len() == needed {
            return Some(points);
        }
    }
    None
}

impl<'a> NodeFacts<'a> {
    /// Derives the facts.
    ///
    /// # Errors
    ///
    /// Fails when the sides are hardly ever both defined, or when the left side
    /// may be defined at single points, where general facts need not hold.
    pub(super) fn of(
        joined: &'a Joined<'a>,
        reals: &'a [Vec<ScaledBall>],
    ) -> Result<NodeFacts<'a>, Doubt> {
        let points = points(joined).ok_or(Doubt::Nowhere)?;
        let count = joined.pattern.nodes.len();
        let mut facts = NodeFacts {
            joined,
            ranges: vec![Range::ALL; count],
            defined: joined.left,
            points,
            links: Vec::new(),
            squares: vec![None; count],
            reals,
        };
        // First what holds whether or not the roots are defined.
        let rooted: Vec<bool> = (0..count).map(|node| facts.has_roots(node)).collect();
        facts.link(&|node| !rooted[node]);
        for [_, divisor] in joined.operands(Operation::Div, 0..joined.left) {
            facts.add(divisor, Range::NONZERO);
        }
        facts.propagate();
        if !facts.is_regular() {
            return Err(Doubt::Roots);
        }
        facts.links.clear();
        facts.link(&|_| true);
        for [operand, _] in joined.operands(Operation::Sqrt, 0..joined.left) {
            facts.add(operand, Range::NOT_NEGATIVE);
        }
        facts.propagate();
        Ok(facts)
    }

    /// Notes a fact.
    pub(super) fn add(&mut self, node: usize, range: Range) {
        self.ranges[node] = self.ranges[node].and(range);
    }

    /// Propagates facts up to results and down to operands until a fixed point.
    pub(super) fn propagate(&mut self) {
        for _ in 0..8 {
            let before = self.ranges.clone();
            for node in 0..self.defined {
                let range = self.computed(node);
                self.add(node, range);
            }
            for node in (0..self.defined).rev() {
                self.factors(node);
            }
            for index in 0..self.links.len() {
                let (node, other, factor) = self.links[index];
                if node >= self.defined {
                    continue;
                }
                let (one, two) = (self.ranges[node], self.ranges[other]);
                if factor == SAME {
                    self.add(node, two);
                    self.add(other, one);
                } else {
                    self.add(node, two.scaled(factor));
                    self.add(other, one.scaled(factor));
                }
            }
            if self.ranges == before {
                break;
            }
        }
    }

    /// The range of a node from those of its operands.
    fn computed(&mut self, node: usize) -> Range {
        match self.joined.pattern.nodes[node] {
            PatternNode::Number(number) => Range::between(number, number),
            PatternNode::Variable(variable) => {
                let needed = self.joined.rule.requirements(variable);
                needed.fold(Range::ALL, |range, requirement| match requirement {
                    Requirement::Constant => range,
                    Requirement::Nonzero => range.and(Range::NONZERO),
                    Requirement::Positive => range.and(Range::NOT_NEGATIVE).and(Range::NONZERO),
                })
            }
            PatternNode::Operation(operation, [a, b]) => {
                let (a, b) = (a as usize, b as usize);
                let operands = [self.ranges[a], self.ranges[b], Range::ALL];
                let is_square = operation == Operation::Mul && self.is_same(a, b);
                let range = Range::of(operation, operands, is_square);
                let known = range.and(self.ranges[node]);
                match (known.sign() == 0).then(|| self.square_sign(node)) {
                    Some(1) => range.and(Range::NOT_NEGATIVE),
                    Some(-1) => range.and(Range::NOT_NEGATIVE.negative()),
                    _ => range,
                }
            }
        }
    }

    /// Records the consequences of a nonzero node for its operands.
    fn factors(&mut self, node: usize) {
        if !self.ranges[node].nonzero {
            return;
        }
        if let PatternNode::Operation(operation, [a, b]) = self.joined.pattern.nodes[node] {
            match operation {
                Operation::Mul => {
                    self.add(a as usize, Range::NONZERO);
                    self.add(b as usize, Range::NONZERO);
                }
                Operation::Copy | Operation::Neg | Operation::Div | Operation::Sqrt => {
                    self.add(a as usize, Range::NONZERO);
                }
                _ => {}
            }
        }
    }

    fn is_same(&self, a: usize, b: usize) -> bool {
        a == b
            || self.links.iter().any(|&(node, other, factor)| {
                factor == SAME && (node, other) == (a.max(b), a.min(b))
            })
    }

    fn has_roots(&self, node: usize) -> bool {
        self.joined
            .part(node)
            .uses(|operation| operation == Operation::Sqrt)
    }

    /// Finds nodes that are multiples of each other.
    fn link(&mut self, wanted: &dyn Fn(usize) -> bool) {
        let count = self.ranges.len();
        if count > MAX_COMPARED {
            return;
        }
        for node in (0..count).filter(|&node| wanted(node)) {
            for other in (0..node).filter(|&node| wanted(node)) {
                if let Some(factor) = self.factor(node, other) {
                    self.links.push((node, other, factor));
                }
            }
        }
    }

    fn factor(&self, node: usize, other: usize) -> Option<i32> {
        let pairs = || {
            let points = self.points.iter();
            points.map(|(field, values)| (field, values[node].value, values[other].value))
        };
        if pairs().any(|(_, a, b)| a == 0 || b == 0) {
            return None;
        }
        if pairs().all(|(_, a, b)| a == b) {
            return Some(SAME);
        }
        // a : b is the same everywhere, in each of the fields by itself.
        let constant = pairs().all(|(field, a, b)| {
            let modulus = field.modulus();
            let mut first = pairs().filter(|(other, ..)| other.modulus() == modulus);
            first
                .next()
                .is_some_and(|(_, c, d)| modulus.mul(a, d) == modulus.mul(b, c))
        });
        if !constant {
            return None;
        }
        let signs = |numbers: &Vec<ScaledBall>| numbers[node].sign() * numbers[other].sign();
        self.reals.iter().map(signs).find(|&sign| sign != 0)
    }

    /// 1 for a node that is a square in general, −1 for one that is the
    /// opposite of a square, 0 for others. A node with roots in it is none.
    fn square_sign(&mut self, node: usize) -> i32 {
        let is_square = match self.squares[node] {
            Some(known) => known,
            None => {
                let found = self.is_square(node);
                self.squares[node] = Some(found);
                found
            }
        };
        if !is_square {
            return 0;
        }
        // What is a square in both fields is one up to a number.
        let signs = self.reals.iter().map(|numbers| numbers[node].sign());
        signs.into_iter().find(|&sign| sign != 0).unwrap_or(0)
    }

    fn is_square(&self, node: usize) -> bool {
        let part = self.joined.part(node);
        if self.has_roots(node) {
            return false;
        }
        let mut found = [None; 2];
        (0..SQUARES).all(|point| {
            let field = self.joined.field(point);
            let inputs = field.inputs(&self.joined.positive);
            let sign = field.sign(part.evaluate(&field, &inputs));
            sign != 0 && *found[(point % 2) as usize].get_or_insert(sign) == sign
        })
    }

    /// True when general facts also hold at every single point at which the
    /// left side is defined. At points where a number under a root is zero,
    /// more may be allowed than next to them: `sqrt(a*a*(b - 1))` is defined at
    /// `a = 0` for any `b`. So the argument of a root is either nonnegative in
    /// any case, or prime: a polynomial that is linear in some variable, whose
    /// sign is then independent of all others; or there is only one root, from
    /// which nothing else is concluded.
    fn is_regular(&self) -> bool {
        let all = 0..self.joined.pattern.nodes.len();
        let mut different: Vec<usize> = Vec::new();
        for [operand, _] in self.joined.operands(Operation::Sqrt, all) {
            let same = |&other: &usize| {
                self.is_same(operand, other) || self.joined.part(operand) == self.joined.part(other)
            };
            if !different.iter().any(same) {
                different.push(operand);
            }
        }
        let scales = self.scales();
        let mut left = self.joined.operands(Operation::Sqrt, 0..self.joined.left);
        different.len() <= 1
            || left.all(|[operand, _]| {
                let count = self.joined.positive.len() as u32;
                self.ranges[operand].low >= 0.0
                    || (0..count).any(|variable| self.is_line(operand, variable, &scales))
            })
    }

    /// Nodes that are numbers, positive variables, and products, quotients and
    /// roots of such.
    fn scales(&self) -> Vec<bool> {
        let mut scales: Vec<bool> = Vec::with_capacity(self.ranges.len());
        for node in &self.joined.pattern.nodes {
            scales.push(match *node {
                PatternNode::Number(number) => number != 0.0,
                PatternNode::Variable(variable) => self.joined.positive[variable as usize],
                PatternNode::Operation(operation, [a, b]) => match operation {
                    Operation::Copy | Operation::Neg | Operation::Sqrt => scales[a as usize],
                    Operation::Mul | Operation::Div => scales[a as usize] && scales[b as usize],
                    _ => false,
                },
            });
        }
        scales
    }

    /// True when a node is a scale times a variable plus a term that does not
    /// depend on it, without divisions but by scales.
    fn is_line(&self, mut node: usize, variable: u32, scales: &[bool]) -> bool {
        assert_eq!(
            scales.len(),
            self.joined.pattern.nodes.len(),
            "every node is a scale or not"
        );
        let contains = |node: usize| self.joined.part(node).variables().contains(&variable);
        let nodes = &self.joined.pattern.nodes;
        let needed = self.joined.pattern.needed(node);
        let is_whole = nodes
            .iter()
            .zip(needed)
            .all(|(inner, needed)| match *inner {
                PatternNode::Operation(Operation::Div, [_, divisor]) if needed => {
                    scales[divisor as usize]
                }
                _ => true,
            });
        if !is_whole {
            return false;
        }
        loop {
            let PatternNode::Operation(operation, [a, b]) = nodes[node] else {
                return nodes[node] == PatternNode::Variable(variable);
            };
            let (a, b) = (a as usize, b as usize);
            node = match operation {
                Operation::Copy | Operation::Neg => a,
                Operation::Add | Operation::Sub => match (contains(a), contains(b)) {
                    (true, false) => a,
                    (false, true) => b,
                    _ => return false,
                },
                Operation::Mul if scales[b] => a,
                Operation::Mul if scales[a] => b,
                Operation::Div if scales[b] => a,
                _ => return false,
            };
        }
    }

    /// Signs to require of points of the fields: those of nodes that are known
    /// and do not follow from others.
    pub(super) fn signs(&self) -> Vec<(usize, i32)> {
        let mut signs: Vec<(usize, i32)> = Vec::new();
        for (node, range) in self.ranges.iter().enumerate() {
            let follows = match self.joined.pattern.nodes[node] {
                PatternNode::Variable(variable) => self.joined.positive[variable as usize],
                PatternNode::Number(_) => false,
                PatternNode::Operation(operation, _) => !matches!(
                    operation,
                    Operation::Add | Operation::Sub | Operation::Sin | Operation::Cos
                ),
            };
            let is_square = self.squares[node] == Some(true);
            let known = signs.iter().any(|&(other, _)| {
                let pair = (node, other);
                self.links.iter().any(|&(a, b, _)| (a, b) == pair)
            });
            if range.sign() != 0 && !follows && !is_square && !known {
                signs.push((node, range.sign()));
            }
        }
        signs
    }
}
