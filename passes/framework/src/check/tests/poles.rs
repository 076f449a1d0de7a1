//! Divisors that are new, and vanish or only seem to.

use super::*;

#[test]
fn sums_that_are_zero_by_rounding_are_no_poles() {
    // (x - 2^60) + 2^60 is zero in binary64 for small x. Twice of it is a
    // divisor that was not there before.
    let quotient = |shifted: bool| {
        single(move |b| {
            let [large, two, three] = [60f64.exp2(), 2.0, 3.0].map(|number| b.constant(number));
            let square = b.binary(Mul, Builder::x(1), Builder::x(1));
            let x = b.binary(Add, square, three);
            if !shifted {
                return b.binary(Div, Builder::x(2), x);
            }
            let difference = b.binary(Sub, x, large);
            let same = b.binary(Add, difference, large);
            let divisor = b.binary(Mul, two, same);
            let half = b.binary(Div, Builder::x(2), divisor);
            b.binary(Mul, two, half)
        })
    };
    assert!(holds(&quotient(false), &quotient(true), NumericClass::Real));
}

#[test]
fn a_divisor_with_a_pole_of_its_own_is_no_zero_elsewhere() {
    // x4/(k/(x1*x2*(x3 + x4))): the inner quotient is large near its pole and
    // nowhere zero. One version divides by half of it.
    let quotient = |outside: bool| {
        single(move |b| {
            let [half, small, two] = [0.5, 1e-19, 2.0].map(|number| b.constant(number));
            let sum = b.binary(Add, Builder::x(3), Builder::x(4));
            let product = b.binary(Mul, Builder::x(1), Builder::x(2));
            let product = b.binary(Mul, product, sum);
            let inner = b.binary(Div, small, product);
            let divisor = if outside {
                inner
            } else {
                b.binary(Mul, half, inner)
            };
            let whole = b.binary(Div, Builder::x(4), divisor);
            if outside {
                b.binary(Mul, whole, two)
            } else {
                whole
            }
        })
    };
    for seed in 0..20 {
        let [before, after] = [false, true].map(quotient);
        let verdict = check(
            before.view(),
            after.view(),
            NumericClass::Real,
            &States::new(seed),
            8,
        );
        assert!(verdict.holds(), "{seed}: {:?}", verdict.failure);
    }
}

#[test]
fn a_divisor_that_is_mostly_no_number_is_compared_where_it_is_one() {
    // x4/(x1/sqrt(x1*x2 + 0.001)): the divisor has a value on a part of the
    // line alone, and vanishes with x1. One version divides by half of x1.
    let quotient = |outside: bool| {
        single(move |b| {
            let [half, small] = [0.5, 0.001].map(|number| b.constant(number));
            let product = b.binary(Mul, Builder::x(1), Builder::x(2));
            let sum = b.binary(Add, product, small);
            let root = b.unary(Sqrt, sum);
            if !outside {
                let divisor = b.binary(Div, Builder::x(1), root);
                return b.binary(Div, Builder::x(4), divisor);
            }
            let product = b.binary(Mul, half, root);
            let over = b.binary(Mul, Builder::x(4), product);
            let divisor = b.binary(Mul, half, Builder::x(1));
            b.binary(Div, over, divisor)
        })
    };
    for seed in 0..60 {
        let [before, after] = [false, true].map(quotient);
        let states = &States::new(seed);
        let verdict = check(before.view(), after.view(), NumericClass::Real, states, 8);
        assert!(verdict.holds(), "{seed}: {:?}", verdict.failure);
    }
}

#[test]
fn a_divisor_that_overflowed_is_as_small_where_it_is_small() {
    // In x1/(k*x2*2^997) the divisor overflows nearly everywhere; with the
    // power outside it does not, and vanishes where the first does.
    let quotient = |outside: bool| {
        single(move |b| {
            let [large, small] = [997f64, -997.0].map(|power| b.constant(power.exp2()));
            let k = b.constant(3e18);
            let divisor = b.binary(Mul, k, Builder::x(2));
            if outside {
                let whole = b.binary(Div, Builder::x(1), divisor);
                return b.binary(Mul, small, whole);
            }
            let divisor = b.binary(Mul, divisor, large);
            b.binary(Div, Builder::x(1), divisor)
        })
    };
    let [before, after] = [false, true].map(quotient);
    for seed in 0..20 {
        let found = check(
            before.view(),
            after.view(),
            NumericClass::Real,
            &States::new(seed),
            8,
        );
        assert!(found.holds(), "{seed}: {:?}", found.failure);
    }
}
