//! Known numbers: their construction, to 30 digits, and their residues in the
//! prime field.
//!
//! A constant is kept as an expression of its source numbers, so that the
//! semantic check can prove the specialised function before anything is
//! rounded. Its value, in double-double with a bound of its error, is rounded
//! once, when the function is written. Two constants are one when they agree in
//! both fields and within their bounds: `0.1*0.3` is the same however it was
//! put together, and `0.5 - 0.5` is a zero that multiplies terms away. The
//! result of a cancellation is a constant only while its bound guarantees all
//! digits of a binary64 number. Where rounding them would move results by more
//! than rounding does (a large number in an angle, a sum that cancels), only
//! those are computed that binary64 holds ([`KnownNumbers::exact`]).

use hashbrown::HashMap;
use robovec_ir::Operation;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::ball::{Ball, Balls};
use robovec_num::field::PrimeField;
use rustc_hash::FxBuildHasher;
use smallvec::SmallVec;

/// A known number.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct Known(pub(crate) u32);

impl Known {
    pub(crate) const ZERO: Known = Known(0);
    pub(crate) const ONE: Known = Known(1);
    pub(crate) const MINUS_ONE: Known = Known(2);

    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// The expression that made a number.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NumberExpression {
    /// It is in the function or in the scene.
    Literal(f64),
    /// By an operation on one or two earlier numbers; with one, the second
    /// repeats it.
    Apply(Operation, [Known; 2]),
}

struct KnownNumber {
    value: Ball<1>,
    elements: [u64; 2],
    expression: NumberExpression,
}

pub(crate) struct KnownNumbers {
    entries: Vec<KnownNumber>,
    /// Those with the same elements of the fields; more than one only where
    /// different numbers have the same residues by accident.
    of_elements: HashMap<[u64; 2], SmallVec<[Known; 1]>, FxBuildHasher>,
    /// The fields numbers are distinguished in. The semantic check draws others.
    fields: [PrimeField; 2],
    /// True when only numbers exact in binary64 are made.
    exact: bool,
}

/// The bound of a constant's error, as a part of it: rounding in double-double
/// is far below, and rounding to binary64 far above.
const NEAR: f64 = 1e-18;

impl KnownNumbers {
    /// Zero, one and minus one.
    pub(crate) fn new() -> KnownNumbers {
        let mut constants = KnownNumbers {
            entries: Vec::new(),
            of_elements: HashMap::default(),
            fields: PrimeField::pair(0x5bec_1a11, false),
            exact: false,
        };
        for (place, number) in (0..).zip([0.0, 1.0, -1.0]) {
            let known = constants.literal(number);
            assert_eq!(known, Known(place), "0, 1 and -1 come first");
        }
        constants
    }

    /// The set of known numbers limited to those exact in binary64.
    pub(crate) fn exact() -> KnownNumbers {
        KnownNumbers {
            exact: true,
            ..KnownNumbers::new()
        }
    }

    /// A literal number. A number that is not finite is no element of the field
    /// and cannot be folded.
    pub(crate) fn literal(&mut self, number: f64) -> Known {
        let entry = KnownNumber {
            value: Balls.literal(number),
            elements: self.fields.map(|field| field.literal(number)),
            expression: NumberExpression::Literal(number),
        };
        match self.intern(entry) {
            Ok(known) => known,
            Err(entry) => {
                self.entries.push(entry);
                Known(self.entries.len() as u32 - 1)
            }
        }
    }

    /// The result of an operation; `None` where it has none (a division by
    /// zero, an overflow) or where its digits are lost (a product below the
    /// range, the rest of a cancellation, one that binary64 does not hold).
    pub(crate) fn apply(&mut self, operation: Operation, operands: [Known; 2]) -> Option<Known> {
        let known = self.computed(operation, operands)?;
        let is_held = self.entries[known.index()].value.value.low[0] == 0.0;
        (!self.exact || is_held).then_some(known)
    }

    /// As [`KnownNumbers::apply`], also for results that binary64 does not
    /// represent.
    fn computed(&mut self, operation: Operation, operands: [Known; 2]) -> Option<Known> {
        let values = operands.map(|known| self.entries[known.index()].value);
        let mut elements = [0; 2];
        for (place, (element, field)) in elements.iter_mut().zip(&self.fields).enumerate() {
            let operands = operands.map(|known| self.entries[known.index()].elements[place]);
            *element = calculate(field, operation, operands)?;
        }
        let entry = KnownNumber {
            value: calculate(&Balls, operation, values)?,
            elements,
            expression: NumberExpression::Apply(operation, operands),
        };
        self.intern(entry).ok()
    }

    /// The number of an entry; the entry itself when it is no number, or one
    /// of which too little is known.
    fn intern(&mut self, entry: KnownNumber) -> Result<Known, KnownNumber> {
        if entry.elements.into_iter().any(PrimeField::is_undefined) || !entry.value.is_known(0) {
            return Err(entry);
        }
        let twins = self.of_elements.entry(entry.elements).or_default();
        let near = |twin: &&Known| self.entries[twin.index()].value.touches(&entry.value, 0);
        if let Some(&twin) = twins.iter().find(near) {
            return Ok(twin);
        }
        if entry.value.radius[0] > NEAR * entry.value.value.high[0].abs() {
            return Err(entry);
        }
        let known = Known(self.entries.len() as u32);
        twins.push(known);
        self.entries.push(entry);
        Ok(known)
    }

    pub(crate) fn negative(&mut self, known: Known) -> Known {
        match self.entries[known.index()].expression {
            NumberExpression::Literal(number) => self.literal(-number),
            NumberExpression::Apply(..) => self
                .computed(Operation::Mul, [Known::MINUS_ONE, known])
                .expect("what was made of numbers is finite"),
        }
    }

    /// A number without its sign, and a flag: true when it was negative.
    pub(crate) fn magnitude(&mut self, known: Known) -> (Known, bool) {
        if self.rounded(known) < 0.0 {
            (self.negative(known), true)
        } else {
            (known, false)
        }
    }

    /// The number rounded to binary64, once.
    pub(crate) fn rounded(&self, known: Known) -> f64 {
        self.entries[known.index()].value.value.high[0]
    }

    /// The expression that made a number; its operands have smaller indices.
    pub(crate) fn expression(&self, known: Known) -> NumberExpression {
        self.entries[known.index()].expression
    }

    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }
}

fn calculate<A: Arithmetic>(
    arithmetic: &A,
    operation: Operation,
    [a, b]: [A::Number; 2],
) -> Option<A::Number> {
    Some(match operation {
        Operation::Add => arithmetic.add(a, b),
        Operation::Sub => arithmetic.sub(a, b),
        Operation::Mul => arithmetic.mul(a, b),
        Operation::Div => arithmetic.div(a, b),
        Operation::Sin => arithmetic.sin(a),
        Operation::Cos => arithmetic.cos(a),
        Operation::Sqrt => arithmetic.sqrt(a),
        Operation::Copy | Operation::Neg | Operation::Fma | Operation::Fms | Operation::Fnma => {
            return None;
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_num::double_double::Double;

    #[test]
    fn what_is_left_of_a_cancellation_is_no_constant() {
        // Of 2^122 + 1/4 double-double keeps no quarter.
        let mut constants = KnownNumbers::new();
        let [large, quarter] = [122f64.exp2(), 0.25].map(|number| constants.literal(number));
        let mut apply = |operation, a, b| constants.apply(operation, [a, b]);
        let sum = apply(Operation::Add, large, quarter);
        let difference = apply(Operation::Sub, quarter, large);
        assert_eq!(
            apply(
                Operation::Add,
                sum.expect("it is finite"),
                difference.expect("too")
            ),
            None
        );
        let again = apply(Operation::Add, quarter, large);
        assert_eq!(
            apply(Operation::Sub, again.expect("too"), sum.expect("too")),
            Some(Known::ZERO)
        );
    }

    #[test]
    fn equal_numbers_are_one_however_they_were_made() {
        let mut constants = KnownNumbers::new();
        let [a, b, c] = [0.1, 0.3, 7.0].map(|number| constants.literal(number));
        let mut apply = |operation, a, b| constants.apply(operation, [a, b]);
        let product = |apply: &mut dyn FnMut(Operation, Known, Known) -> Option<Known>, x, y| {
            apply(Operation::Mul, x, y).expect("it is finite")
        };
        let first = product(&mut apply, a, b);
        let first = product(&mut apply, first, c);
        let second = product(&mut apply, b, c);
        let second = product(&mut apply, a, second);
        assert_eq!(first, second);
        assert_eq!(apply(Operation::Sub, first, second), Some(Known::ZERO));
        assert_eq!(apply(Operation::Div, b, b), Some(Known::ONE));
        assert_eq!(apply(Operation::Div, a, Known::ZERO), None);
        let rest = apply(Operation::Sub, b, a).expect("it is finite");
        let fifth = apply(Operation::Add, a, a).expect("it is finite");
        assert_ne!(rest, fifth, "0.3 - 0.1 is not 0.2 in binary numbers");
        let exact = Double::from(0.1) * Double::from(0.3) * Double::from(7.0);
        assert_eq!(constants.rounded(first), exact.high);
        let infinite = constants.literal(f64::INFINITY);
        assert_eq!(constants.apply(Operation::Mul, [infinite, a]), None);
        assert_eq!(constants.magnitude(Known::MINUS_ONE), (Known::ONE, true));
        let minus = constants.negative(first);
        assert_eq!(constants.magnitude(minus), (first, true));
        let sine = constants.apply(Operation::Sin, [Known::ZERO; 2]);
        let cosine = constants.apply(Operation::Cos, [Known::ZERO; 2]);
        assert_eq!((sine, cosine), (Some(Known::ZERO), Some(Known::ONE)));
    }
}
