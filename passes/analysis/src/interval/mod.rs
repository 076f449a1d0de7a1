//! Sound ranges and error bounds in windows.
//!
//! Given ranges of its leaves, every value of a [`ConeWindow`] is enclosed by
//! interval arithmetic, once in exact arithmetic and once as a format computes
//! it. The error made inside the window is the sum over its operations of the
//! largest rounding error of each times its adjoint, where adjoints are
//! intervals of difference quotients between exact and computed values (the
//! mean-value form): no second-order term is left out, so the bound holds
//! exactly for every state in the ranges.
//!
//! Reason for windows: along a chain of rotations enclosures double every two
//! joints, and after some thousand operations they are useless. Up to about six
//! joints they are as tight as the proofs of specialised tools.
//!
//! Ranges of the leaves are known only for inputs with given ranges. Ranges of
//! other inputs are those that random states are drawn from, and ranges of
//! inner values are *assumed*: the hull of sampled values, widened by a margin.
//! Whatever rests on an assumed range states it ([`RangeBasis`]).

mod assumed;
mod boxes;
mod decimal;
mod loss;
mod seen;
#[cfg(test)]
mod tests;
mod window;

pub use assumed::{LeafRange, Leaves, MARGIN, RangeBasis, input_ranges};
pub use boxes::{SubdividedEnclosure, subdivide};
pub use decimal::exact_literal;
pub(crate) use loss::rounded;
pub use seen::{between, largest_seen};
pub use window::ConeWindow;

use super::adjoint::{Tape, TapeSlot, half_ulp};
use robovec_ir::{Format, Operation};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::Double;
use robovec_num::interval::{Enclosing, Interval};
use robovec_num::soft_float::FormatArithmetic;

/// The usual number of operations of a window; beyond some thousand the
/// enclosures widen faster than they show.
pub const USUAL: usize = 1000;

/// The enclosures of a window.
#[derive(Clone, PartialEq, Debug)]
pub struct WindowEnclosure {
    /// The exact value of every leaf, then of every node.
    pub exact: Vec<Interval>,
    /// The same in the arithmetic of the format.
    pub computed: Vec<Interval>,
    /// The largest loss of each of them by its own rounding.
    pub local: Vec<f64>,
    /// A bound of the error of the window's value, if the leaves that are
    /// values have none; infinite if unknown.
    pub error: f64,
}

robovec_num::named! {
    /// An alarm that a range raises about a format.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
    pub enum Alarm {
        /// Results may be larger than the format's largest number.
        MayOverflow = "may overflow",
        /// All results overflow.
        Overflows = "overflows",
        /// All results are smaller than the smallest normal number (of fixed point:
        /// than a step), zero excepted.
        Underflows = "underflows",
    }
}

impl Alarm {
    /// The alarm that a range of results raises.
    pub fn of(range: Interval, format: Format) -> Option<Alarm> {
        let over = |size: f64| half_ulp(format, size).is_infinite();
        let least = match format {
            Format::Float(float) => 2f64.powi(float.smallest_exponent()),
            Format::Fixed(fixed) => 2f64.powi(-(fixed.fraction as i32)),
        };
        if over(range.mignitude()) {
            Some(Alarm::Overflows)
        } else if over(range.low) || over(range.high) {
            Some(Alarm::MayOverflow)
        } else if range != Interval::ZERO && range.magnitude() < least {
            Some(Alarm::Underflows)
        } else {
            None
        }
    }
}

/// The bits before the point that fixed-point numbers of a range need, without
/// the sign; `None` for an infinite range.
pub fn integer_bits(range: Interval) -> Option<u32> {
    let size = range.magnitude();
    if !size.is_finite() {
        return None;
    }
    // Sizes from 2ᵏ on need k + 1 bits.
    Some(((size.to_bits() >> 52) as i32 - 1022).max(0) as u32)
}

/// Kind of inputs and literals before the run.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum GivenData {
    /// Inputs are numbers of the format, and literals those of binary64.
    #[default]
    Held,
    /// Inputs are real numbers, which the format rounds, and literals their
    /// printed decimals.
    Real,
}

/// The leaves of a window before and after they are rounded.
#[derive(Clone, PartialEq, Debug)]
pub struct WindowLeaves {
    format: Format,
    data: GivenData,
    /// The range of every leaf; that of a literal is one number.
    pub ranges: Vec<Interval>,
    kinds: Vec<WindowLeafKind>,
    /// The basis of the weakest range.
    pub knowledge: RangeBasis,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum WindowLeafKind {
    Input,
    Literal,
    Inner,
}

impl From<TapeSlot> for WindowLeafKind {
    fn from(slot: TapeSlot) -> WindowLeafKind {
        match slot {
            TapeSlot::Input(_) => WindowLeafKind::Input,
            TapeSlot::Constant(_) | TapeSlot::Nothing => WindowLeafKind::Literal,
            TapeSlot::Value(_) => WindowLeafKind::Inner,
        }
    }
}

impl WindowLeaves {
    /// The leaves of a window with their known ranges.
    pub fn new(
        tape: &Tape,
        window: &ConeWindow,
        format: Format,
        data: GivenData,
        leaves: &Leaves<'_>,
    ) -> WindowLeaves {
        let known = window.leaves.iter().map(|&slot| leaves.of(slot));
        let kinds = window.leaves.iter();
        let kinds = kinds.map(|&slot| WindowLeafKind::from(tape.slot(slot)));
        let weakest = known.clone().map(|leaf| leaf.knowledge).max();
        WindowLeaves {
            format,
            data,
            ranges: known.map(|leaf| leaf.range).collect(),
            kinds: kinds.collect(),
            knowledge: weakest.unwrap_or(RangeBasis::Given),
        }
    }

    /// Leaves of which only these ranges are known, without any relation
    /// between them.
    pub fn anything(window: &ConeWindow, format: Format, ranges: Vec<Interval>) -> WindowLeaves {
        assert_eq!(window.leaves.len(), ranges.len(), "a range for every leaf");
        WindowLeaves {
            format,
            data: GivenData::Held,
            kinds: vec![WindowLeafKind::Inner; ranges.len()],
            ranges,
            knowledge: RangeBasis::Given,
        }
    }

    fn is_input(&self, leaf: usize) -> bool {
        self.kinds[leaf] == WindowLeafKind::Input
    }

    fn is_literal(&self, leaf: usize) -> bool {
        self.kinds[leaf] == WindowLeafKind::Literal
    }

    /// Exact value of a leaf in a range, its value rounded to the format, and
    /// its largest rounding error.
    fn given(&self, leaf: usize, range: Interval) -> (Interval, Interval, f64) {
        let (exact, held, lost) = given(self.kinds[leaf], self.data, self.format, range);
        // An input that is always the same number, not a state that is tested.
        let known = self.ranges[leaf].low == self.ranges[leaf].high;
        if self.is_input(leaf) && known && lost.is_finite() {
            return (exact, held, (held.low - exact.low).abs());
        }
        (exact, held, lost)
    }
}

/// Exact value of a leaf in a range, its value rounded to the format, and its
/// largest rounding error.
pub(crate) fn given(
    kind: WindowLeafKind,
    data: GivenData,
    format: Format,
    range: Interval,
) -> (Interval, Interval, f64) {
    match (kind, data) {
        (WindowLeafKind::Inner, _) | (WindowLeafKind::Input, GivenData::Held) => {
            (range, range, 0.0)
        }
        (WindowLeafKind::Input, GivenData::Real) => {
            let (held, lost) = loss::nearest(range, format);
            (range, held, lost)
        }
        // A literal is rounded once and for all.
        (WindowLeafKind::Literal, data) => {
            let number = range.low;
            let held = FormatArithmetic::new(format).convert(number);
            let rounding = Double::from(held) - Double::from(number);
            let (exact, lost) = match data {
                GivenData::Held => (range, rounding.high.abs()),
                GivenData::Real => decimal::given(number, rounding),
            };
            (exact, Interval::point(held), lost)
        }
    }
}

/// Encloses all values of a window and bounds its error in the format of its
/// leaves, which lie in the ranges given.
pub fn enclose(
    tape: &Tape,
    window: &ConeWindow,
    leaves: &WindowLeaves,
    ranges: &[Interval],
) -> WindowEnclosure {
    let count = ranges.len() + window.nodes.len();
    let mut enclosure = WindowEnclosure {
        exact: Vec::with_capacity(count),
        computed: Vec::with_capacity(count),
        local: Vec::with_capacity(count),
        error: 0.0,
    };
    for (leaf, &range) in ranges.iter().enumerate() {
        let (exact, computed, local) = leaves.given(leaf, range);
        enclosure.exact.push(exact);
        enclosure.computed.push(computed);
        enclosure.local.push(local);
    }
    for (&node, places) in window.nodes.iter().zip(&window.operands) {
        let operation = tape.operation(node);
        let exact = operate(operation, places, &enclosure.exact);
        let before = operate(operation, places, &enclosure.computed);
        let operands = places.map(|place| enclosure.computed[place]);
        let (computed, local) = loss::rounded(operation, operands, before, leaves.format);
        enclosure.exact.push(exact);
        enclosure.computed.push(computed);
        enclosure.local.push(local);
    }
    enclosure.error = error(tape, window, &enclosure);
    enclosure
}

/// One operation on enclosures; a product with itself is a square.
pub(crate) fn operate(operation: Operation, places: &[usize; 3], values: &[Interval]) -> Interval {
    assert!(
        !values.is_empty(),
        "a node reads a leaf or a node before it"
    );
    if operation == Operation::Mul && places[0] == places[1] {
        return values[places[0]].square();
    }
    Enclosing.apply(operation, places.map(|place| values[place]))
}

/// The error of a window's value: adjoints of all nodes and literals as
/// intervals, times their rounding errors.
fn error(tape: &Tape, window: &ConeWindow, enclosure: &WindowEnclosure) -> f64 {
    let leaves = window.leaves.len();
    let mut adjoints = vec![Interval::ZERO; leaves + window.nodes.len()];
    let Some(last) = adjoints.last_mut() else {
        return 0.0;
    };
    *last = Interval::point(1.0);
    for (place, &node) in window.nodes.iter().enumerate().rev() {
        let adjoint = adjoints[leaves + place];
        if adjoint == Interval::ZERO {
            continue;
        }
        let (operation, operands) = (tape.operation(node), window.operands[place]);
        let secants = secant(operation, operands, enclosure, leaves + place);
        for (operand, secant) in operands.into_iter().zip(secants).take(operation.arity()) {
            adjoints[operand] = adjoints[operand] + adjoint * secant;
        }
    }
    let parts = adjoints.iter().zip(&enclosure.local);
    let parts = parts.filter(|(adjoint, local)| **local > 0.0 && **adjoint != Interval::ZERO);
    // Every product and every partial sum is rounded up.
    let total = parts.fold(0.0f64, |total, (adjoint, local)| {
        (total + (adjoint.magnitude() * local).next_up()).next_up()
    });
    if total.is_nan() { f64::INFINITY } else { total }
}

/// Enclosures of the quotients of differences between computed and exact
/// results, as in the adjoints at points.
fn secant(
    operation: Operation,
    places: [usize; 3],
    enclosure: &WindowEnclosure,
    result: usize,
) -> [Interval; 3] {
    let one = Interval::point(1.0);
    let exact = |operand: usize| enclosure.exact[places[operand]];
    let computed = |operand: usize| enclosure.computed[places[operand]];
    let both = || exact(0).hull(computed(0));
    match operation {
        Operation::Copy => [one; 3],
        Operation::Neg => [-one; 3],
        Operation::Add => [one; 3],
        Operation::Sub => [one, -one, one],
        Operation::Mul | Operation::Fma => [exact(1), computed(0), one],
        Operation::Fms => [exact(1), computed(0), -one],
        Operation::Fnma => [-exact(1), -computed(0), one],
        Operation::Div => {
            let inverse = one / computed(1);
            [inverse, -(enclosure.exact[result] * inverse), one]
        }
        Operation::Sin => [Enclosing.apply(Operation::Cos, [both(); 3]), one, one],
        Operation::Cos => [-Enclosing.apply(Operation::Sin, [both(); 3]), one, one],
        Operation::Sqrt => {
            let root = |argument| Enclosing.apply(Operation::Sqrt, [argument; 3]);
            [one / (root(computed(0)) + root(exact(0))), one, one]
        }
    }
}
