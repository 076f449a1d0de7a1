//! Forms of sums that are equal to them and need not cancel.

use super::BetterForm;
use super::cancelling_sum::CancellingSum;
use super::trial::is_positive;
use robovec_ir::{Function, Node, Operand, Operation};

/// Maximum number of quotients brought to a common denominator.
const QUOTIENTS: usize = 8;

/// A form of a sum with roots or quotients.
pub(super) fn without_cancellation(function: &Function, node: &Node) -> Option<BetterForm> {
    let [a, b, _] = node.operands;
    conjugate(function, [a, b], node.operation).or_else(|| quotients(function, node))
}

/// The operand of the operation of this kind that gives an operand.
fn argument(function: &Function, operand: Operand, operation: Operation) -> Option<Operand> {
    let node = function.node(operand.value()?);
    (node.operation == operation).then_some(node.operands[0])
}

/// `a + b` or `a - b` as `(a*a - b*b)` over the sum with the other sign, where
/// one is a root and terms of the numerator cancel.
fn conjugate(
    function: &Function,
    [a, b]: [Operand; 2],
    operation: Operation,
) -> Option<BetterForm> {
    let radicands = [a, b].map(|operand| argument(function, operand, Operation::Sqrt));
    let numerator = match (radicands, operation) {
        ([Some(first), Some(second)], Operation::Sub) => {
            let numerator = CancellingSum::difference(function, first, second);
            let is_number = numerator.as_number().is_some_and(|number| number != 0.0);
            let is_safe =
                || is_number || is_positive(function, first) || is_positive(function, second);
            is_safe().then_some(numerator)?
        }
        ([None, None] | [Some(_), Some(_)], _) => return None,
        _ => {
            let square = |place: usize| match radicands[place] {
                Some(radicand) => Some(CancellingSum::of(function, radicand)),
                None => {
                    let base = CancellingSum::of(function, [a, b][place]);
                    base.times(&base)
                }
            };
            let (first, second) = (square(0)?, square(1)?);
            let numerator = first.plus(&second, -1.0)?;
            let has_cancelled = numerator.len() < first.len() + second.len();
            has_cancelled.then_some(numerator)?
        }
    };
    let other = match operation {
        Operation::Sub => Operation::Add,
        _ => Operation::Sub,
    };
    let divisor = BetterForm::apply(other, [a, b].map(BetterForm::Operand));
    let numerator = BetterForm::Sum(numerator);
    Some(BetterForm::apply(Operation::Div, [numerator, divisor]))
}

/// A sum of quotients over their common denominator, where terms of the
/// numerator cancel.
fn quotients(function: &Function, node: &Node) -> Option<BetterForm> {
    let [a, b, _] = node.operands;
    let sign = match node.operation {
        Operation::Sub => -1.0,
        _ => 1.0,
    };
    let mut open = vec![(b, sign), (a, 1.0)];
    let mut parts: Vec<(Operand, Option<Operand>, f64)> = Vec::new();
    while let Some((operand, sign)) = open.pop() {
        if parts.len() + open.len() > QUOTIENTS {
            return None;
        }
        let node = operand.value().map(|value| function.node(value));
        match node.map(|node| (node.operation, node.operands)) {
            Some((Operation::Add, [a, b, _])) => open.extend([(b, sign), (a, sign)]),
            Some((Operation::Sub, [a, b, _])) => open.extend([(b, -sign), (a, sign)]),
            Some((Operation::Div, [a, b, _])) => parts.push((a, Some(b), sign)),
            _ => parts.push((operand, None, sign)),
        }
    }
    let mut divisors: Vec<Operand> = Vec::new();
    for divisor in parts.iter().filter_map(|(_, divisor, _)| *divisor) {
        if !divisors.contains(&divisor) {
            divisors.push(divisor);
        }
    }
    if divisors.len() < 2 {
        return None;
    }
    let (mut numerator, mut terms) = (CancellingSum::default(), 0);
    for (above, divisor, sign) in parts {
        let others = divisors.iter().filter(|&&other| Some(other) != divisor);
        let mut part = CancellingSum::of(function, above);
        for &other in others {
            part = part.times(&CancellingSum::of(function, other))?;
        }
        terms += part.len();
        numerator = numerator.plus(&part, sign)?;
    }
    let roots = numerator
        .as_difference()
        .and_then(|roots| conjugate(function, roots, Operation::Sub));
    let numerator = match roots {
        Some(roots) => roots,
        None => (numerator.len() < terms).then_some(BetterForm::Sum(numerator))?,
    };
    let factors = divisors.into_iter().map(BetterForm::Operand);
    let divisor = factors.reduce(|a, b| BetterForm::apply(Operation::Mul, [a, b]));
    let divisor = divisor.expect("there are divisors");
    Some(BetterForm::apply(Operation::Div, [numerator, divisor]))
}

/// A form of a difference of sines or cosines, or of one and a cosine.
pub(super) fn of_angles(function: &Function, node: &Node) -> Option<BetterForm> {
    let [a, b, _] = node.operands;
    if node.operation != Operation::Sub {
        return None;
    }
    let both = |operation| {
        let angle = |operand| argument(function, operand, operation);
        Some([angle(a)?, angle(b)?])
    };
    if let Some(angles) = both(Operation::Sin) {
        return Some(product(function, angles, (2.0, Operation::Cos)));
    }
    if let Some(angles) = both(Operation::Cos) {
        return Some(product(function, angles, (-2.0, Operation::Sin)));
    }
    let cosine = |operand| argument(function, operand, Operation::Cos);
    let one = |operand| function.number(operand) == Some(1.0);
    let (angle, factor) = match (cosine(a), cosine(b)) {
        (None, Some(angle)) if one(a) => (angle, 2.0),
        (Some(angle), None) if one(b) => (angle, -2.0),
        _ => return None,
    };
    let sine = BetterForm::apply(Operation::Sin, [half(BetterForm::Operand(angle))]);
    let square = BetterForm::apply(Operation::Mul, [sine.clone(), sine]);
    let factor = BetterForm::Number(factor);
    Some(BetterForm::apply(Operation::Mul, [factor, square]))
}

fn half(form: BetterForm) -> BetterForm {
    BetterForm::apply(Operation::Mul, [BetterForm::Number(0.5), form])
}

/// The product of a number, a function of half the sum of two angles and the
/// sine of half their difference.
fn product(
    function: &Function,
    [a, b]: [Operand; 2],
    (factor, of_sum): (f64, Operation),
) -> BetterForm {
    let sum = BetterForm::apply(Operation::Add, [a, b].map(BetterForm::Operand));
    let difference = BetterForm::Sum(CancellingSum::difference(function, a, b));
    let of_sum = BetterForm::apply(of_sum, [half(sum)]);
    let sine = BetterForm::apply(Operation::Sin, [half(difference)]);
    let scaled = BetterForm::apply(Operation::Mul, [BetterForm::Number(factor), of_sum]);
    BetterForm::apply(Operation::Mul, [scaled, sine])
}
