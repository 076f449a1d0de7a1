//! Independent evaluation of functions, which shares no code with the checks of
//! the compiler.
//!
//! Over the real numbers: every value between two numbers of some hundred bits,
//! rounded outwards at every operation. Two disjoint results are different
//! numbers, for any constants; there is no tolerance, and no field in which a
//! constant could be zero. A pole and the root of a negative number are no
//! numbers; a result that the bits leave undecided is unknown, and is computed
//! again with more bits.
//!
//! In binary64 and binary32: the operations of the processor, in order.

use astro_float::{BigFloat, Consts, RoundingMode};
use robovec_ir::{Function, Operand, OperandKind, Operation};

/// Bits of the first attempt, and of the last.
pub(crate) const BITS: [usize; 2] = [320, 4096];

/// Angles beyond this power of two are treated as arbitrary: reducing them
/// takes as many bits.
const LARGEST_ANGLE: i32 = 150;

/// Knowledge about a real number.
#[derive(Clone, Debug)]
pub(crate) enum Real {
    /// It is between these numbers, inclusive.
    Between(Box<[BigFloat; 2]>),
    /// There is no such number.
    Undefined,
    /// The bits do not show whether there is one, or it is too large to state.
    Unknown,
}

/// Errors allowed to the literals and functions of a program.
#[derive(Clone, Copy, Default, Debug)]
pub(crate) struct Leniency {
    /// Literals were rounded once to binary64.
    pub(crate) rounded_literals: bool,
    /// Sines and cosines may be wrong by so much.
    pub(crate) circular: f64,
}

/// Evaluates functions in intervals of real numbers.
pub(crate) struct Referee {
    bits: usize,
    consts: Consts,
}

impl Referee {
    pub(crate) fn new(bits: usize) -> Referee {
        Referee {
            bits,
            consts: Consts::new().expect("there is memory for the digits of pi"),
        }
    }

    /// Values of the assignments of a function.
    pub(crate) fn evaluate(
        &mut self,
        function: &Function,
        inputs: &[f64],
        leniency: Leniency,
    ) -> Vec<Real> {
        let constants: Vec<Real> = function
            .constants()
            .iter()
            .map(|&number| self.literal(number, leniency))
            .collect();
        let inputs: Vec<Real> = inputs.iter().map(|&number| self.point(number)).collect();
        let mut values: Vec<Real> = Vec::with_capacity(function.nodes().len());
        for node in function.nodes() {
            let value = {
                let get =
                    |place: usize| look_up(node.operands[place], &values, &inputs, &constants);
                let operands = [get(0), get(1), get(2)];
                self.apply(node.operation, operands, leniency)
            };
            values.push(value);
        }
        let assignments = function.assignments.iter();
        assignments
            .map(|assignment| look_up(assignment.operand, &values, &inputs, &constants).clone())
            .collect()
    }

    fn point(&self, number: f64) -> Real {
        match exact(number, self.bits) {
            Some(exact) => Real::Between(Box::new([exact.clone(), exact])),
            None => Real::Undefined,
        }
    }

    fn literal(&self, number: f64, leniency: Leniency) -> Real {
        let point = self.point(number);
        let Real::Between(ends) = &point else {
            return point;
        };
        if !leniency.rounded_literals {
            return point;
        }
        // Half a unit in the last place, of subnormal numbers too.
        let half = number.abs() * 2f64.powi(-52) + f64::from_bits(1);
        let Some(half) = exact(half, self.bits) else {
            return Real::Unknown;
        };
        between(self.down_sub(&ends[0], &half), self.up_add(&ends[1], &half))
    }

    fn down_sub(&self, a: &BigFloat, b: &BigFloat) -> BigFloat {
        a.sub(b, self.bits, RoundingMode::Down)
    }

    fn up_add(&self, a: &BigFloat, b: &BigFloat) -> BigFloat {
        a.add(b, self.bits, RoundingMode::Up)
    }

    fn apply(&mut self, operation: Operation, operands: [&Real; 3], leniency: Leniency) -> Real {
        let arity = operation.arity();
        let mut ends = Vec::with_capacity(arity);
        for operand in &operands[..arity] {
            match operand {
                Real::Undefined => return Real::Undefined,
                Real::Unknown => {}
                Real::Between(between) => ends.push(between.as_ref()),
            }
        }
        if ends.len() < arity {
            return Real::Unknown;
        }
        match operation {
            Operation::Copy => between(ends[0][0].clone(), ends[0][1].clone()),
            Operation::Neg => between(ends[0][1].neg(), ends[0][0].neg()),
            Operation::Add => self.add(ends[0], ends[1]),
            Operation::Sub => self.sub(ends[0], ends[1]),
            Operation::Mul => self.mul(ends[0], ends[1]),
            Operation::Div => self.div(ends[0], ends[1]),
            Operation::Sqrt => self.sqrt(ends[0]),
            Operation::Sin | Operation::Cos => self.circular(operation, ends[0], leniency),
            Operation::Fma | Operation::Fms | Operation::Fnma => {
                let Real::Between(product) = self.mul(ends[0], ends[1]) else {
                    return Real::Unknown;
                };
                match operation {
                    Operation::Fma => self.add(&product, ends[2]),
                    Operation::Fms => self.sub(&product, ends[2]),
                    _ => self.sub(ends[2], &product),
                }
            }
        }
    }

    fn add(&self, a: &[BigFloat; 2], b: &[BigFloat; 2]) -> Real {
        between(
            a[0].add(&b[0], self.bits, RoundingMode::Down),
            a[1].add(&b[1], self.bits, RoundingMode::Up),
        )
    }

    fn sub(&self, a: &[BigFloat; 2], b: &[BigFloat; 2]) -> Real {
        between(
            a[0].sub(&b[1], self.bits, RoundingMode::Down),
            a[1].sub(&b[0], self.bits, RoundingMode::Up),
        )
    }

    fn mul(&self, a: &[BigFloat; 2], b: &[BigFloat; 2]) -> Real {
        self.corners(a, b, |a, b, bits, rounding| a.mul(b, bits, rounding))
    }

    fn div(&self, a: &[BigFloat; 2], b: &[BigFloat; 2]) -> Real {
        if b[0].is_zero() && b[1].is_zero() {
            return Real::Undefined;
        }
        if b.iter().any(BigFloat::is_zero) || b[0].is_negative() != b[1].is_negative() {
            return Real::Unknown;
        }
        self.corners(a, b, |a, b, bits, rounding| a.div(b, bits, rounding))
    }

    fn corners(
        &self,
        a: &[BigFloat; 2],
        b: &[BigFloat; 2],
        operation: impl Fn(&BigFloat, &BigFloat, usize, RoundingMode) -> BigFloat,
    ) -> Real {
        let mut ends: Option<[BigFloat; 2]> = None;
        for a in distinct(a) {
            for b in distinct(b) {
                let low = operation(a, b, self.bits, RoundingMode::Down);
                let high = operation(a, b, self.bits, RoundingMode::Up);
                ends = Some(match ends {
                    None => [low, high],
                    Some([least, most]) => [least.min(&low), most.max(&high)],
                });
            }
        }
        let [low, high] = ends.expect("an interval has ends");
        between(low, high)
    }

    fn sqrt(&self, a: &[BigFloat; 2]) -> Real {
        let below_zero = |number: &BigFloat| number.is_negative() && !number.is_zero();
        if below_zero(&a[1]) {
            return Real::Undefined;
        }
        if below_zero(&a[0]) {
            return Real::Unknown;
        }
        let root = |number: &BigFloat, rounding| match number.is_zero() {
            // Of a zero of either sign.
            true => BigFloat::new(self.bits),
            false => number.sqrt(self.bits, rounding),
        };
        between(
            root(&a[0], RoundingMode::Down),
            root(&a[1], RoundingMode::Up),
        )
    }

    /// Sine or cosine of an interval: the slope is at most one, so the result
    /// differs from that of the lower end by at most the width of the angle.
    fn circular(&mut self, operation: Operation, a: &[BigFloat; 2], leniency: Leniency) -> Real {
        let large = |number: &BigFloat| number.exponent().is_some_and(|e| e > LARGEST_ANGLE);
        let one = BigFloat::from_f64(1.0, self.bits);
        if a.iter().any(large) {
            return between(one.neg(), one);
        }
        let mut reach = a[1].sub(&a[0], self.bits, RoundingMode::Up);
        // The library's result is correctly rounded; a unit more costs nothing.
        let mut unit = one.clone();
        unit.set_exponent(2 - self.bits as i32);
        for more in [Some(unit), exact(leniency.circular, self.bits)] {
            let more = more.expect("an error is finite");
            reach = reach.add(&more, self.bits, RoundingMode::Up);
        }
        // A whole number of words more for what reducing the angle takes away.
        let bits = self.bits + 192;
        let near = match operation {
            Operation::Sin => a[0].sin(bits, RoundingMode::ToEven, &mut self.consts),
            _ => a[0].cos(bits, RoundingMode::ToEven, &mut self.consts),
        };
        between(self.down_sub(&near, &reach), self.up_add(&near, &reach))
    }
}

/// The one or two ends of an interval.
fn distinct(ends: &[BigFloat; 2]) -> &[BigFloat] {
    match ends[0].cmp(&ends[1]) {
        Some(0) => &ends[..1],
        _ => ends,
    }
}

fn between(low: BigFloat, high: BigFloat) -> Real {
    let whole = |number: &BigFloat| !number.is_nan() && !number.is_inf();
    if whole(&low) && whole(&high) {
        Real::Between(Box::new([low, high]))
    } else {
        Real::Unknown
    }
}

/// A binary64 number, exactly; `None` for infinities and NaN.
fn exact(number: f64, bits: usize) -> Option<BigFloat> {
    if !number.is_finite() {
        return None;
    }
    if number == 0.0 {
        return Some(BigFloat::new(bits));
    }
    // The library does not take subnormal numbers for what they are.
    let small = number.abs() < 1e-290;
    let moved = if small {
        number * 2f64.powi(200)
    } else {
        number
    };
    let mut exact = BigFloat::from_f64(moved, bits);
    if small && let Some(exponent) = exact.exponent() {
        exact.set_exponent(exponent - 200);
    }
    Some(exact)
}

fn look_up<'a>(
    operand: Operand,
    values: &'a [Real],
    inputs: &'a [Real],
    constants: &'a [Real],
) -> &'a Real {
    match operand.kind() {
        OperandKind::Value(value) => &values[value.index()],
        OperandKind::Input(input) => &inputs[input.index()],
        OperandKind::Constant(constant) => &constants[constant.index()],
        OperandKind::None => &Real::Unknown,
    }
}

/// Verdict of two versions of a number on each other.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Opinion {
    /// They overlap, within a range that contains no other wrong term.
    Same,
    /// They overlap, but could be many numbers.
    Vague,
    /// They are not the same number.
    Different,
    /// There was a number, and there is none.
    Lost,
    /// There was a number; the bits of the other number do not decide.
    Open,
    /// There was none.
    Nothing,
}

/// Compares the number before with the one after.
pub(crate) fn compare(before: &Real, after: &Real) -> Opinion {
    match (before, after) {
        (Real::Undefined | Real::Unknown, _) => Opinion::Nothing,
        (_, Real::Undefined) => Opinion::Lost,
        (_, Real::Unknown) => Opinion::Open,
        (Real::Between(before), Real::Between(after)) => {
            let above = |a: &BigFloat, b: &BigFloat| a.cmp(b).is_some_and(|order| order > 0);
            if above(&before[0], &after[1]) || above(&after[0], &before[1]) {
                return Opinion::Different;
            }
            let width = |ends: &[BigFloat; 2]| ends[1].sub(&ends[0], 64, RoundingMode::Up);
            let width = width(before).max(&width(after));
            let size = before[0].abs().max(&before[1].abs());
            let places = match (width.exponent(), size.exponent()) {
                _ if width.is_zero() => i32::MAX,
                (Some(width), Some(size)) => size.saturating_sub(width),
                _ => 0,
            };
            if places < 40 {
                Opinion::Vague
            } else {
                Opinion::Same
            }
        }
    }
}

impl Real {
    /// True for a number that overflows in binary64.
    pub(crate) fn is_beyond_binary64(&self) -> bool {
        let Real::Between(ends) = self else {
            return false;
        };
        ends.iter()
            .all(|end| end.exponent().is_some_and(|exponent| exponent > 1024))
    }

    /// The middle as a number people read.
    pub(crate) fn describe(&self) -> String {
        match self {
            Real::Undefined => "no number".to_owned(),
            Real::Unknown => "not known".to_owned(),
            Real::Between(ends) => {
                let mut low = ends[0].clone();
                let shorter = low.set_precision(192, RoundingMode::ToEven);
                match shorter {
                    Ok(()) => format!("{low}"),
                    Err(_) => format!("{}", ends[0]),
                }
            }
        }
    }
}

/// Values of assignments in the arithmetic of the processor; `None` where a
/// number on their way is not finite.
pub(crate) fn in_hardware(function: &Function, inputs: &[f64], single: bool) -> Vec<Option<f64>> {
    let round = |number: f64| {
        if single {
            f64::from(number as f32)
        } else {
            number
        }
    };
    let number = |operand: Operand, values: &[Option<f64>]| match operand.kind() {
        OperandKind::Value(value) => values[value.index()],
        OperandKind::Input(input) => Some(round(inputs[input.index()])),
        OperandKind::Constant(constant) => Some(round(function.constant_number(constant))),
        OperandKind::None => Some(0.0),
    };
    let mut values: Vec<Option<f64>> = Vec::with_capacity(function.nodes().len());
    for node in function.nodes() {
        let [a, b, c] = node.operands.map(|operand| number(operand, &values));
        let result = a.zip(b).zip(c).map(|((a, b), c)| {
            if single {
                f64::from(operate32(
                    node.operation,
                    [a, b, c].map(|number| number as f32),
                ))
            } else {
                operate64(node.operation, [a, b, c])
            }
        });
        values.push(result.filter(|number| number.is_finite()));
    }
    let assignments = function.assignments.iter();
    assignments
        .map(|assignment| number(assignment.operand, &values).filter(|number| number.is_finite()))
        .collect()
}

fn operate64(operation: Operation, [a, b, c]: [f64; 3]) -> f64 {
    match operation {
        Operation::Copy => a,
        Operation::Neg => -a,
        Operation::Add => a + b,
        Operation::Sub => a - b,
        Operation::Mul => a * b,
        Operation::Div => a / b,
        Operation::Sin => a.sin(),
        Operation::Cos => a.cos(),
        Operation::Sqrt => a.sqrt(),
        Operation::Fma => a.mul_add(b, c),
        Operation::Fms => a.mul_add(b, -c),
        Operation::Fnma => (-a).mul_add(b, c),
    }
}

fn operate32(operation: Operation, [a, b, c]: [f32; 3]) -> f32 {
    match operation {
        Operation::Fma => a.mul_add(b, c),
        Operation::Fms => a.mul_add(b, -c),
        Operation::Fnma => (-a).mul_add(b, c),
        // Sines and cosines are those of binary64, rounded once; all other
        // results are the same when they are rounded twice, since 53 bits are
        // more than twice 24 (Figueroa 1995).
        _ => operate64(operation, [a, b, c].map(f64::from)) as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::parse::parse_module;

    fn opinions(text: &str, inputs: &[f64]) -> Vec<Opinion> {
        let module = parse_module("referee", text).expect("it is well formed");
        let mut referee = Referee::new(BITS[0]);
        let [before, after] = [0, 1]
            .map(|index| referee.evaluate(&module.functions[index], inputs, Leniency::default()));
        before
            .iter()
            .zip(&after)
            .map(|(a, b)| compare(a, b))
            .collect()
    }

    #[test]
    fn what_fields_and_roundings_miss_is_seen() {
        let found = opinions(
            "function f atomic {\n in x\n out y[1..7]\n\
             %a = x*2305843009213693952.0\n %b = x + 1e-60\n %c = x*x\n %d = sqrt(%c)\n\
             %e = sin(x)\n %f = 0.0 - x\n %g = x*3.0\n\
             y[1] = %a\n y[2] = %b\n y[3] = %d\n y[4] = %e\n y[5] = x\n y[6] = %f\n y[7] = %g\n}\n\
             function g atomic {\n in x\n out y[1..7]\n\
             %a = x*1.0\n %b = x + 0.0\n %c = x*x\n %d = 0.0 - x\n\
             %h = x + x\n %i = x - x\n %j = x/%i\n %k = sqrt(%d)\n %g = %h + x\n\
             y[1] = x\n y[2] = %b\n y[3] = x\n y[4] = x\n y[5] = %j\n y[6] = %k\n y[7] = %g\n}",
            &[-1.5],
        );
        let expected = [
            Opinion::Different,
            Opinion::Different,
            Opinion::Different,
            Opinion::Different,
            Opinion::Lost,
            // The root of 1.5 is there.
            Opinion::Different,
            Opinion::Same,
        ];
        assert_eq!(found, expected);
    }
}
