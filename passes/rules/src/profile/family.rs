//! Families of terms of growing size, on which rules show how graphs grow.

use super::super::pattern::{Pattern, PatternNode};
use super::super::rule::Rule;
use robovec_ir::Operation::{self, Add, Cos, Div, Mul, Neg, Sin, Sub};

/// Terms of growing size.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum TermFamily<'a> {
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
    /// The left side of a rule, n times, each instead of the last variable of
    /// the next.
    Nested(&'a str),
}

impl<'a> TermFamily<'a> {
    pub(super) const FIXED: [TermFamily<'static>; 9] = [
        TermFamily::Sum,
        TermFamily::Difference,
        TermFamily::Product,
        TermFamily::Horner,
        TermFamily::Common,
        TermFamily::Binomials,
        TermFamily::Quotient,
        TermFamily::Signs,
        TermFamily::Turns,
    ];

    /// The name of the family, for users.
    pub(super) fn name(self) -> String {
        match self {
            TermFamily::Sum => "a sum of n terms".to_owned(),
            TermFamily::Difference => "a difference of n terms".to_owned(),
            TermFamily::Product => "a product of n factors".to_owned(),
            TermFamily::Horner => "n levels x + y*(...)".to_owned(),
            TermFamily::Common => "n products with a common factor".to_owned(),
            TermFamily::Binomials => "a product of n binomials".to_owned(),
            TermFamily::Quotient => "a quotient of n values".to_owned(),
            TermFamily::Signs => "n signs".to_owned(),
            TermFamily::Turns => "n turns in the plane".to_owned(),
            TermFamily::Nested(name) => format!("{name}, n times nested"),
        }
    }

    /// The term of a size from 1.
    pub(super) fn term(self, size: u32, rules: &[&Rule]) -> Pattern {
        let mut maker = FamilyBuilder::default();
        match self {
            TermFamily::Sum => maker.chain(Add, size, FamilyBuilder::leaf),
            TermFamily::Difference => maker.chain(Sub, size, FamilyBuilder::leaf),
            TermFamily::Product => maker.chain(Mul, size, FamilyBuilder::leaf),
            TermFamily::Quotient => maker.chain(Div, size, FamilyBuilder::leaf),
            TermFamily::Binomials => maker.chain(Mul, size, |maker| {
                let (x, y) = (maker.leaf(), maker.leaf());
                maker.pattern.operation(Add, &[x, y])
            }),
            TermFamily::Common => {
                maker.leaves = 1;
                maker.chain(Add, size, |maker| {
                    let a = maker.pattern.push(PatternNode::Variable(0));
                    let x = maker.leaf();
                    maker.pattern.operation(Mul, &[a, x])
                });
            }
            TermFamily::Horner => maker.horner(size),
            TermFamily::Signs => maker.signs(size),
            TermFamily::Turns => maker.turns(size),
            TermFamily::Nested(name) => {
                if let Some(rule) = rules.iter().find(|rule| rule.name == name) {
                    maker.nested(&rule.left, size);
                }
            }
        }
        maker.pattern
    }
}

#[derive(Default)]
struct FamilyBuilder {
    pattern: Pattern,
    leaves: u32,
}

impl FamilyBuilder {
    fn leaf(&mut self) -> u32 {
        self.leaves += 1;
        self.pattern.push(PatternNode::Variable(self.leaves - 1))
    }

    /// `part ∘ part ∘ …`, from the left.
    fn chain(&mut self, operation: Operation, size: u32, part: fn(&mut FamilyBuilder) -> u32) {
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
