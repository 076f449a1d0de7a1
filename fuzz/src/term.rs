//! Random terms and their rewritten forms, as the two sides of rules.

use arbitrary::{Result, Unstructured};
use robovec_ir::Operation;
use std::fmt;

/// A small term; its constructor bounds its depth.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Term {
    /// One of four variables.
    Variable(u8),
    /// A whole number.
    Number(u8),
    /// A minus.
    Minus(Box<Term>),
    /// A sum, difference or product.
    Pair(Operation, Box<Term>, Box<Term>),
}

use Term::{Minus, Number, Pair, Variable};

/// The names of the variables.
const NAMES: [&str; 4] = ["a", "b", "c", "d"];

/// Number of times a term may grow while it is rewritten.
const LARGEST: usize = 40;

fn pair(operation: Operation, left: Term, right: Term) -> Term {
    Pair(operation, Box::new(left), Box::new(right))
}

impl Term {
    /// A random term of some depth; an operation, if the depth is not 0.
    pub(crate) fn random(bytes: &mut Unstructured<'_>, depth: u32) -> Result<Term> {
        if depth == 0 {
            return Ok(match bytes.int_in_range(0..=9)? {
                0 => Number(bytes.int_in_range(1..=3)?),
                _ => Variable(bytes.int_in_range(0..=3)?),
            });
        }
        let operation = *bytes.choose(&[
            Operation::Add,
            Operation::Add,
            Operation::Sub,
            Operation::Mul,
            Operation::Mul,
            Operation::Neg,
        ])?;
        let [left, right] = [
            bytes.int_in_range(0..=depth - 1)?,
            bytes.int_in_range(0..=depth - 1)?,
        ];
        let left = Term::random(bytes, left)?;
        if operation == Operation::Neg {
            return Ok(Minus(Box::new(left)));
        }
        Ok(pair(operation, left, Term::random(bytes, right)?))
    }

    /// `-(-x)`.
    pub(crate) fn twice_minus(self) -> Term {
        Minus(Box::new(Minus(Box::new(self))))
    }

    /// Its nodes.
    pub(crate) fn size(&self) -> usize {
        match self {
            Variable(_) | Number(_) => 1,
            Minus(inner) => 1 + inner.size(),
            Pair(_, left, right) => 1 + left.size() + right.size(),
        }
    }

    /// The variables that occur, by number.
    pub(crate) fn variables(&self) -> [bool; 4] {
        match self {
            Variable(number) => std::array::from_fn(|index| index == usize::from(*number)),
            Number(_) => [false; 4],
            Minus(inner) => inner.variables(),
            Pair(_, left, right) => {
                let (left, right) = (left.variables(), right.variables());
                std::array::from_fn(|index| left[index] || right[index])
            }
        }
    }

    /// Its value, exactly as long as the numbers are small and whole.
    pub(crate) fn evaluate(&self, values: [f64; 4]) -> f64 {
        match self {
            Variable(number) => values[usize::from(*number)],
            Number(number) => f64::from(*number),
            Minus(inner) => -inner.evaluate(values),
            Pair(operation, left, right) => {
                let (left, right) = (left.evaluate(values), right.evaluate(values));
                match operation {
                    Operation::Add => left + right,
                    Operation::Sub => left - right,
                    _ => left * right,
                }
            }
        }
    }

    /// The node of a number, counted in pre-order.
    fn node(&mut self, number: &mut usize) -> Option<&mut Term> {
        if *number == 0 {
            return Some(self);
        }
        *number -= 1;
        match self {
            Variable(_) | Number(_) => None,
            Minus(inner) => inner.node(number),
            Pair(_, left, right) => match left.node(number) {
                Some(found) => Some(found),
                None => right.node(number),
            },
        }
    }

    /// An equal term, by random identities of commutative rings.
    pub(crate) fn rewritten(&self, bytes: &mut Unstructured<'_>, steps: u32) -> Result<Term> {
        let mut term = self.clone();
        for _ in 0..steps {
            let size = term.size();
            let mut place = bytes.int_in_range(0..=size - 1)?;
            let choice = bytes.int_in_range(0..=5)?;
            if let Some(node) = term.node(&mut place)
                && let Some(equal) = equal(node, choice, size < LARGEST)
            {
                *node = equal;
            }
        }
        Ok(term)
    }

    /// A term that is likely another function.
    pub(crate) fn mutated(&self, bytes: &mut Unstructured<'_>) -> Result<Term> {
        let mut term = self.clone();
        let mut place = bytes.int_in_range(0..=term.size() - 1)?;
        let choice = bytes.int_in_range(0..=2)?;
        if let Some(node) = term.node(&mut place) {
            *node = match (node.clone(), choice) {
                (Variable(number), _) => Variable((number + 1) % 4),
                (Number(number), _) => Number(number + 1),
                (Minus(inner), _) => *inner,
                (Pair(_, left, _), 0) => *left,
                (Pair(Operation::Sub, left, right), 1) => Pair(Operation::Sub, right, left),
                (Pair(Operation::Add, left, right), _) => Pair(Operation::Sub, left, right),
                (Pair(Operation::Sub, left, right), _) => Pair(Operation::Add, left, right),
                (Pair(_, left, right), _) => Pair(Operation::Add, left, right),
            };
        }
        Ok(term)
    }
}

/// One step of a law of rings at the root of a term, where it fits.
fn equal(term: &Term, choice: u8, may_grow: bool) -> Option<Term> {
    use Operation::{Add, Mul, Sub};
    let Pair(operation, left, right) = term else {
        return match (term, choice) {
            (Minus(inner), 0..=2) => match &**inner {
                Minus(twice) => Some((**twice).clone()),
                Pair(Sub, a, b) => Some(pair(Sub, (**b).clone(), (**a).clone())),
                Pair(Mul, a, b) => Some(pair(Mul, Minus(a.clone()), (**b).clone())),
                _ => None,
            },
            (_, 3) if may_grow => Some(term.clone().twice_minus()),
            _ => None,
        };
    };
    let (a, b) = ((**left).clone(), (**right).clone());
    match (operation, choice) {
        (Add | Mul, 0) => Some(pair(*operation, b, a)),
        (Sub, 0) => Some(pair(Add, a, Minus(Box::new(b)))),
        (Add | Mul, 1) => match a {
            Pair(inner, x, y) if inner == *operation => Some(pair(inner, *x, pair(inner, *y, b))),
            _ => None,
        },
        (Add | Mul, 2) => match b {
            Pair(inner, x, y) if inner == *operation => Some(pair(inner, pair(inner, a, *x), *y)),
            _ => None,
        },
        (Mul, 3) if may_grow => match b {
            Pair(inner @ (Add | Sub), x, y) => {
                Some(pair(inner, pair(Mul, a.clone(), *x), pair(Mul, a, *y)))
            }
            _ => None,
        },
        (Add | Sub, 4) => match (a, b) {
            (Pair(Mul, x, y), Pair(Mul, z, w)) if x == z => {
                Some(pair(Mul, *x, pair(*operation, *y, *w)))
            }
            _ => None,
        },
        (Sub, 5) => Some(Minus(Box::new(pair(Sub, b, a)))),
        _ => None,
    }
}

impl fmt::Display for Term {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Variable(number) => formatter.write_str(NAMES[usize::from(*number)]),
            Number(number) => write!(formatter, "{number}"),
            Minus(inner) => write!(formatter, "(-{inner})"),
            Pair(operation, left, right) => {
                let sign = match operation {
                    Operation::Add => '+',
                    Operation::Sub => '-',
                    _ => '*',
                };
                write!(formatter, "({left} {sign} {right})")
            }
        }
    }
}
