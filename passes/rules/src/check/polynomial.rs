//! Polynomials in one unknown over a prime field.
//!
//! The factors of a divisor show on a line: where the variables run along a
//! random straight line, a node is a quotient of polynomials in one unknown,
//! and one polynomial divides another in all variables exactly when it does so
//! on a line in general position.

use robovec_num::field::Modulus;

/// The largest degree that is worked with.
const HIGHEST: usize = 96;

/// A polynomial: coefficients from the constant one up, without trailing zeros.
pub(super) type ModularPolynomial = Vec<u64>;

fn trimmed(mut polynomial: ModularPolynomial) -> ModularPolynomial {
    while polynomial.last() == Some(&0) {
        polynomial.pop();
    }
    polynomial
}

pub(super) fn sum(
    modulus: Modulus,
    a: &ModularPolynomial,
    b: &ModularPolynomial,
) -> ModularPolynomial {
    let at = |polynomial: &ModularPolynomial, index| polynomial.get(index).copied().unwrap_or(0);
    let terms = (0..a.len().max(b.len())).map(|index| modulus.add(at(a, index), at(b, index)));
    trimmed(terms.collect())
}

pub(super) fn negative(modulus: Modulus, a: &ModularPolynomial) -> ModularPolynomial {
    a.iter().map(|&number| modulus.neg(number)).collect()
}

/// The product; `None` beyond the largest degree.
pub(super) fn product(
    modulus: Modulus,
    a: &ModularPolynomial,
    b: &ModularPolynomial,
) -> Option<ModularPolynomial> {
    if a.is_empty() || b.is_empty() {
        return Some(Vec::new());
    }
    let len = a.len() + b.len() - 1;
    if len > HIGHEST + 1 {
        return None;
    }
    let mut result = vec![0; len];
    for (i, &x) in a.iter().enumerate() {
        for (j, &y) in b.iter().enumerate() {
            result[i + j] = modulus.add(result[i + j], modulus.mul(x, y));
        }
    }
    Some(trimmed(result))
}

/// Quotient and remainder by a divisor that is not zero.
pub(super) fn divide(
    modulus: Modulus,
    a: &ModularPolynomial,
    b: &ModularPolynomial,
) -> (ModularPolynomial, ModularPolynomial) {
    let mut rest = a.clone();
    let Some(extra) = (a.len() + 1)
        .checked_sub(b.len())
        .filter(|&extra| extra > 0)
    else {
        return (Vec::new(), rest);
    };
    let mut quotient = vec![0; extra];
    let leading = *b.last().expect("a divisor is not zero");
    let leading = modulus.invert(leading);
    for step in (0..extra).rev() {
        let factor = modulus.mul(rest[step + b.len() - 1], leading);
        quotient[step] = factor;
        for (index, &number) in b.iter().enumerate() {
            let taken = modulus.mul(factor, number);
            rest[step + index] = modulus.sub(rest[step + index], taken);
        }
    }
    (trimmed(quotient), trimmed(rest))
}

/// A greatest common divisor.
pub(super) fn common(
    modulus: Modulus,
    a: &ModularPolynomial,
    b: &ModularPolynomial,
) -> ModularPolynomial {
    let (mut a, mut b) = (a.clone(), b.clone());
    while !b.is_empty() {
        let (_, rest) = divide(modulus, &a, &b);
        a = b;
        b = rest;
    }
    a
}

/// The rest of a polynomial when all factors that it shares with another are
/// taken out, as often as they occur.
pub(super) fn without(
    modulus: Modulus,
    a: &ModularPolynomial,
    factors: &ModularPolynomial,
) -> ModularPolynomial {
    let mut left = a.clone();
    loop {
        let shared = common(modulus, &left, factors);
        if shared.len() <= 1 {
            return left;
        }
        left = divide(modulus, &left, &shared).0;
    }
}

#[cfg(test)]
mod tests {
    use super::super::primes::primes;
    use super::*;
    use robovec_num::random::Random;

    #[test]
    fn factors_are_found_and_taken_out() {
        let modulus = Modulus::new(primes(&mut Random::new(4)).0);
        let plain = |numbers: &[u64]| -> ModularPolynomial {
            numbers
                .iter()
                .map(|&number| modulus.number(number))
                .collect()
        };
        // (x + 2)^2 (x + 3), and (x + 2)(x + 5).
        let (two, three, five) = (plain(&[2, 1]), plain(&[3, 1]), plain(&[5, 1]));
        let times =
            |a: &ModularPolynomial, b: &ModularPolynomial| product(modulus, a, b).expect("small");
        let first = times(&times(&two, &two), &three);
        let second = times(&two, &five);
        let shared = common(modulus, &first, &second);
        assert_eq!(shared.len(), 2);
        assert!(divide(modulus, &shared, &two).1.is_empty());
        let left = without(modulus, &first, &second);
        assert!(divide(modulus, &left, &three).1.is_empty());
        assert_eq!(left.len(), 2);
        let (quotient, rest) = divide(modulus, &first, &two);
        assert!(rest.is_empty());
        assert_eq!(quotient, times(&two, &three));
        assert_eq!(
            sum(modulus, &two, &negative(modulus, &two)),
            ModularPolynomial::new()
        );
        assert_eq!(without(modulus, &five, &first), five);
    }
}
