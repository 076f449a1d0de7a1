//! Families of terms of growing size, on which rules show how graphs grow.

use super::super::pattern::{Pattern, PatternNode};
use super::super::rule::Rule;
use robovec_ir::Operation::{self, Add, Cos, Div, Mul, Neg, Sin, Sub};

/// Terms of growing size.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Family<'a> {
    /// `x1 + x2 + … + xn`.
    Sum,
    /// `x1 - x2 - … - xn`.
    Difference,
    /// `x1*x2*…*xn`.
    Product,
    /// `(x1 + y1*(x2 + y2*(…)))`, n levels.
    Horner,
    /// `a*x1 + a*x2 + … + a*xn`.
    Common,
    /// `(x1 + y1)*(x2 + y2)*…*(xn + yn)`.
    Binomials,
    /// `x1/x2/…/xn`.
    Quotient,
    /// `-x1 - (-x2 - (…))`, n terms.
    Signs,
    /// A vector in the plane turned n times: its first component.
    Turns,
    /// The left side of a rule, n times, each in the place of the last
    /// variable of the next.
    Nested(&'a str),
}

impl<'a> Family<'a> {
    pub(super) const FIXED: [Family<'static>; 9] = [
        Family::Sum,
        Family::Difference,
        Family::Product,
        Family::Horner,
        Family::Common,
        Family::Binomials,
        Family::Quotient,
        Family::Signs,
        Family::Turns,
    ];

    /// What the family is, for people.
    pub(super) fn name(self) -> String {
        match self {
            Family::Sum => "a sum of n terms".to_owned(),
            Family::Difference => "a difference of n terms".to_owned(),
            Family::Product => "a product of n factors".to_owned(),
            Family::Horner => "n levels x + y*(...)".to_owned(),
            Family::Common => "n products with a common factor".to_owned(),
            Family::Binomials => "a product of n binomials".to_owned(),
            Family::Quotient => "a quotient of n values".to_owned(),
            Family::Signs => "n signs".to_owned(),
            Family::Turns => "n turns in the plane".to_owned(),
            Family::Nested(name) => format!("{name}, n times nested"),
        }
    }

    /// The term of a size from 1.
    pub(super) fn term(self, size: u32, rules: &[&Rule]) -> Pattern {
        let mut maker = Maker::default();
        match self {
            Family::Sum => maker.chain(Add, size, Maker::leaf),
            Family::Difference => maker.chain(Sub, size, Maker::leaf),
            Family::Product => maker.chain(Mul, size, Maker::leaf),
            Family::Quotient => maker.chain(Div, size, Maker::leaf),
            Family::Binomials => maker.chain(Mul, size, |maker| {
                let (x, y) = (maker.leaf(), maker.leaf());
                maker.pattern.operation(Add, &[x, y])
            }),
            Family::Common => {
                maker.leaves = 1;
                maker.chain(Add, size, |maker| {
                    let a = maker.pattern.push(PatternNode::Variable(0));
                    let x = maker.leaf();
                    maker.pattern.operation(Mul, &[a, x])
                });
            }
            Family::Horner => maker.horner(size),
            Family::Signs => maker.signs(size),
            Family::Turns => maker.turns(size),
            Family::Nested(name) => {
                if let Some(rule) = rules.iter().find(|rule| rule.name == name) {
                    maker.nested(&rule.left, size);
                }
            }
        }
        maker.pattern
    }
}

#[derive(Default)]
struct Maker {
    pattern: Pattern,
    leaves: u32,
}

impl Maker {
    fn leaf(&mut self) -> u32 {
        self.leaves += 1;
        self.pattern.push(PatternNode::Variable(self.leaves - 1))
    }

    /// `part ∘ part ∘ …`, from the left.
    fn chain(&mut self, operation: Operation, size: u32, part: fn(&mut Maker) -> u32) {
        let mut last = part(self);
        for _ in 1..size {
            let next = part(self);
            last = self.pattern.operation(operation, &[last, next]);
        }
    }

    fn horner(&mut self, size: u32) {
        let mut last = self.leaf();
        for _ in 0..size {
            let y = self.leaf();
            let product = self.pattern.operation(Mul, &[y, last]);
            let x = self.leaf();
            last = self.pattern.operation(Add, &[x, product]);
        }
    }

    fn signs(&mut self, size: u32) {
        let mut last = self.leaf();
        for _ in 0..size {
            let x = self.leaf();
            let negated = self.pattern.operation(Neg, &[x]);
            last = self.pattern.operation(Sub, &[negated, last]);
        }
    }

    fn turns(&mut self, size: u32) {
        let (mut x, mut y) = (self.leaf(), self.leaf());
        for _ in 0..size {
            let angle = self.leaf();
            let cosine = self.pattern.operation(Cos, &[angle]);
            let sine = self.pattern.operation(Sin, &[angle]);
            let mut product = |a, b| self.pattern.operation(Mul, &[a, b]);
            let (cx, sy, sx, cy) = (
                product(cosine, x),
                product(sine, y),
                product(sine, x),
                product(cosine, y),
            );
            y = self.pattern.operation(Sub, &[cy, sx]);
            x = self.pattern.operation(Add, &[cx, sy]);
        }
    }

    fn nested(&mut self, left: &Pattern, size: u32) {
        let hole = left.variables().last().copied();
        let mut inner: Option<u32> = None;
        for _ in 0..size {
            let base = self.leaves;
            let mut places: Vec<u32> = Vec::with_capacity(left.nodes.len());
            for node in &left.nodes {
                let place = match *node {
                    PatternNode::Variable(variable) => match inner {
                        Some(inner) if Some(variable) == hole => inner,
                        _ => self.pattern.push(PatternNode::Variable(base + variable)),
                    },
                    PatternNode::Operation(operation, operands) => {
                        let operands = operands.map(|operand| places[operand as usize]);
                        self.pattern
                            .push(PatternNode::Operation(operation, operands))
                    }
                    number => self.pattern.push(number),
                };
                places.push(place);
            }
            self.leaves = base + left.variables().last().map_or(0, |last| last + 1);
            inner = places.last().copied();
        }
    }
}
