use super::*;
use crate::testing::compiled_output;
use robovec_ir::Format;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::random::Random;
use robovec_num::trigonometry::{Circular, Polynomial};

#[test]
fn polynomials_are_the_best_of_their_degree() {
    for (real, format, order) in [
        (Real::Double, Format::BINARY64, [13, 14]),
        (Real::Float, Format::BINARY32, [7, 8]),
    ] {
        let constants = KernelConstants::of(real);
        // A little over an eighth of a turn, for what the reduction rounds.
        let range = 7854.0 / 1e4;
        let derive = |of, leading: &[f64], order| {
            let best = Polynomial::minimax_behind(of, leading, order, range, format);
            best.expect("a fit").coefficients[leading.len()..].to_vec()
        };
        assert_eq!(derive(Circular::Sine, &[1.0], order[0]), constants.sine);
        let cosine = derive(Circular::Cosine, &[1.0, -0.5], order[1]);
        assert_eq!(cosine, constants.cosine);
    }
}

#[test]
fn first_parts_of_a_quarter_turn_have_exact_products() {
    for (real, digits, significand) in [(Real::Double, 20, 53), (Real::Float, 12, 24)] {
        let constants = KernelConstants::of(real);
        let most = 2f64.powi(digits);
        assert!(constants.limit * constants.turns <= most);
        let (last, first) = constants.quarter.split_last().expect("parts");
        for part in first {
            // As many trailing zeros as a count has digits.
            let zeros = part.to_bits().trailing_zeros() as i32;
            assert!(53 - zeros + digits <= significand, "{part}");
        }
        let sum = constants.quarter.iter().rev().sum::<f64>();
        assert_eq!(sum, std::f64::consts::FRAC_PI_2);
        assert!(*last < first[first.len() - 1] / most);
    }
}

#[test]
fn the_types_stand_for_themselves() {
    for (kernel, vector, bytes) in [
        (
            SineKernel::widest(Real::Double),
            "robovec_d8",
            "(8 * ROBOVEC_D8)",
        ),
        (
            SineKernel::widest(Real::Float),
            "robovec_f16",
            "(4 * ROBOVEC_F16)",
        ),
    ] {
        assert_eq!(kernel.vector(), vector);
        assert!(kernel.types().contains(&format!("vector_size{bytes}")));
        assert!(kernel.arrays().contains(&kernel.arrays_name()));
        assert!(kernel.runs().contains(&kernel.runs_name()));
    }
    let alone = SineKernel {
        real: Real::Double,
        lanes: 1,
    };
    assert!(!alone.types().contains("vector_size"));
    assert!(alone.runs().contains("sin(angles"));
}

/// Angles over the whole range, some next to multiples of a quarter turn,
/// where nearly everything cancels, and some beyond.
fn angles(limit: f64, significand: u32) -> Vec<f64> {
    let rounded = |angle: f64| match significand {
        24 => f64::from(angle as f32),
        _ => angle,
    };
    let mut random = Random::new(1);
    let mut angles = vec![0.0, limit, -limit, 1e-30, 1e-5, 0.5 * limit];
    for index in 0..6000 {
        let unit = random.signed();
        let range = [1.0, 8.0, 100.0, limit][index % 4];
        let quarters = (unit * range * std::f64::consts::FRAC_2_PI).round();
        angles.push(rounded(unit * range));
        angles.push(rounded(quarters * std::f64::consts::FRAC_PI_2));
    }
    angles.extend([2.0 * limit, 1e9, -1e12].map(rounded));
    angles
}

/// The distance in units in the last place of the exact number.
fn units(found: f64, exact: Double, significand: i32) -> f64 {
    let exponent = exact.high.abs().log2().floor() as i32;
    exact.distance(found) / 2f64.powi(exponent + 1 - significand)
}

#[test]
fn compiled_kernels_are_within_one_unit_in_the_last_place() {
    use std::fmt::Write;
    for (real, significand) in [(Real::Double, 53), (Real::Float, 24)] {
        let kernel = SineKernel::widest(real);
        let angles = angles(KernelConstants::of(real).limit, significand);
        let mut text = kernel.types() + &kernel.arrays();
        let list: Vec<String> = angles.iter().map(|angle| format!("{angle:?}")).collect();
        let (name, count) = (real.name(), angles.len());
        write!(
            text,
            "#include <stdio.h>\nstatic const {name} x[] = {{{}, 0.0/0.0, 1.0/0.0}};\n\
             int main(void) {{ static {name} s[{count} + 2], c[{count} + 2];\n\
             for (int n = 0; n <= {count} + 2; n += n < 20 ? 1 : {count} + 2 - n ? {count} + 2 - n : 1) {}(n, x, s, c);\n\
             for (int i = 0; i < {count} + 2; i++) printf(\"%.17g %.17g\\n\", (double)s[i], (double)c[i]);\n return 0; }}\n",
            list.join(", "),
            kernel.arrays_name()
        )
        .expect("a string");
        let files = [("kernel.c".to_owned(), text)];
        // Neither contraction nor leave to regroup changes anything.
        for flags in [&["-O2"][..], &["-O3", "-march=native", "-ffast-math"]] {
            let Some((text, succeeds)) = compiled_output(&files, flags, &[]) else {
                return;
            };
            assert!(succeeds, "{text}");
            let mut lines = text.lines().map(|line| {
                let (sine, cosine) = line.split_once(' ').expect("two numbers");
                [sine, cosine].map(|word| word.parse::<f64>().unwrap_or(f64::NAN))
            });
            for &angle in &angles {
                let [sine, cosine] = lines.next().expect("a line for each angle");
                let exact = Double::from(angle);
                let wanted = [DoubleDouble.sin(exact), DoubleDouble.cos(exact)];
                if angle == 0.0 {
                    assert_eq!([sine, cosine], [0.0, 1.0]);
                    continue;
                }
                for (found, wanted) in [sine, cosine].into_iter().zip(wanted) {
                    let error = units(found, wanted, significand as i32);
                    assert!(error < 1.0, "{name} {angle:?}: {found:?} is {error} off");
                }
            }
            for numbers in lines {
                assert!(numbers.iter().all(|number| number.is_nan()), "{numbers:?}");
            }
        }
    }
}
