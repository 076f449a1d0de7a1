//! The three efforts against each other, and balls against the truth.

use super::*;
use robovec_ir::Module;
use robovec_ir::parse::parse_module;
use robovec_ir::states::States;

fn module(body: &str, outputs: u32) -> Module {
    let text = format!("function f atomic {{\n  in x[1..4]\n  out y[1..{outputs}]\n{body}}}\n");
    parse_module("f", &text).expect("it is well formed")
}

fn states(module: &Module, count: u32) -> Vec<Vec<f64>> {
    let view = module.tables.view(&module.functions[0]);
    (0..count)
        .map(|state| States::new(5).draw(view, state))
        .collect()
}

/// Everything an operation can do, and cancellation of all degrees.
const MIXED: &str = "
  %a = x[1]*x[2]
  %b = sin(%a)
  %c = cos(x[3])
  %d = %b+%c
  %e = %d*%d
  %f = sqrt(%e)
  %g = %f/x[4]
  %h = %g*x[4]
  %i = %h-%f
  %j = fma(%a, %d, %g)
  %k = fms(%a, %d, %j)
  %l = %g+1e25
  %m = %l-1e25
  %n = %b*1e-200
  %o = %n*%n
  %p = %o*1e80
  %r = 0.1+0.2
  %s = %r-0.3
  %u = fnma(%a, %b, %c)
  %v = x[1]*1e19
  %w = sin(%v)
  y[1] = %b
  y[2] = %e
  y[3] = %f
  y[4] = %g
  y[5] = %i
  y[6] = %k
  y[7] = %m
  y[8] = %p
  y[9] = %s
  y[10] = x[2]
  y[11] = %u
  y[12] = %w
";

#[test]
fn certified_and_audited_values_agree_to_the_last_bit() {
    let module = module(MIXED, 12);
    let function = &module.functions[0];
    let states = states(&module, 40);
    let certified = ReferenceEvaluator::new(function, ReferenceEffort::Certified).evaluate(&states);
    let audited = ReferenceEvaluator::new(function, ReferenceEffort::Audit).evaluate(&states);
    let plain = ReferenceEvaluator::new(function, ReferenceEffort::DoubleDouble).evaluate(&states);
    for ((certified, audited), plain) in certified.iter().zip(&audited).zip(&plain) {
        for (place, (one, other)) in certified.iter().zip(audited).enumerate() {
            assert!(
                one.is_certain() && other.is_certain(),
                "{place}: {one:?} {other:?}"
            );
            assert_eq!(one.value.high, other.value.high, "y[{}]", place + 1);
            // The bounds hold: both balls hold the same real number.
            let distance = (one.value - other.value).high.abs();
            assert!(
                distance <= one.bound + other.bound,
                "y[{}]: {one:?} {other:?}",
                place + 1
            );
            let kind = match place {
                // Zero by an identity, whatever rounding makes of it.
                4 => Some(ExactEvidence::Zero),
                // Beyond double-double: the angle, and the far end of the
                // range.
                11 => Some(ExactEvidence::Precise(192)),
                0 | 1 | 2 | 3 | 9 => Some(ExactEvidence::DoubleDouble),
                _ => None,
            };
            assert!(kind.is_none_or(|kind| kind == one.kind), "{place}: {one:?}");
        }
        assert!(plain.iter().all(|value| !value.is_certain()));
    }
    assert!(audited[0][0].kind == ExactEvidence::Precise(192));
    assert_eq!(audited[0][4].kind, ExactEvidence::Zero);
}

#[test]
fn what_double_double_loses_is_computed_again() {
    // A cancellation by 2^-110 of its terms: double-double sees noise.
    let module = module(
        "
  %a = x[1]+1e34
  %b = %a-1e34
  %c = %b-x[1]
  %d = x[2]*2.407412430484045e-35
  %e = x[1]+%d
  %f = %e-x[1]
  y[1] = %c
  y[2] = %f
  y[3] = %b
",
        3,
    );
    let function = &module.functions[0];
    let states = states(&module, 20);
    let exact = ReferenceEvaluator::new(function, ReferenceEffort::Certified).evaluate(&states);
    let mut precise = 0;
    for (values, inputs) in exact.iter().zip(&states) {
        assert_eq!(
            (values[0].value.high, values[0].kind),
            (0.0, ExactEvidence::Zero)
        );
        assert_eq!(values[1].value.high, inputs[1] * 2f64.powi(-115));
        assert_eq!(values[2].value.high, inputs[0]);
        precise += u32::from(values[1].kind == ExactEvidence::Precise(192));
    }
    assert!(precise > 10, "{precise}");
}

#[test]
fn the_edge_between_two_numbers_takes_more_bits() {
    // Half a unit and 2^-300: no 192 bits tell on which side it lies.
    let module = module(
        "
  %a = 1+1.1102230246251565e-16
  %b = %a+4.909093465297727e-91
  %c = %a-4.909093465297727e-91
  %d = %a-%a
  y[1] = %b
  y[2] = %c
  y[3] = %a
",
        3,
    );
    let function = &module.functions[0];
    let states = states(&module, 1);
    let exact = ReferenceEvaluator::new(function, ReferenceEffort::Certified).evaluate(&states);
    let found: Vec<(f64, ExactEvidence)> =
        exact[0].iter().map(|e| (e.value.high, e.kind)).collect();
    assert_eq!(found[0], (1.0 + f64::EPSILON, ExactEvidence::Precise(384)));
    assert_eq!(found[1], (1.0, ExactEvidence::Precise(384)));
    // A tie is known to be one, as nothing was rounded, and goes to even.
    assert_eq!(found[2], (1.0, ExactEvidence::Precise(192)));
}

#[test]
fn what_is_not_a_number_is_not_certain() {
    let module = module(
        "
  %z = x[1]-x[1]
  %a = x[2]/%z
  %b = %a-%a
  %c = 1e300*1e300
  %d = %c/1e300
  y[1] = %a
  y[2] = %b
  y[3] = %c
  y[4] = %d
",
        4,
    );
    let function = &module.functions[0];
    let states = states(&module, 2);
    for effort in [ReferenceEffort::Certified, ReferenceEffort::Audit] {
        let exact = ReferenceEvaluator::new(function, effort).evaluate(&states);
        let [a, b, c, d] = [0, 1, 2, 3].map(|place| exact[0][place]);
        assert!(!a.value.high.is_finite() && !a.is_certain());
        assert!(b.value.high.is_nan() && !b.is_certain());
        assert_eq!(c.value.high, f64::INFINITY);
        // The real number is 1e300, which binary64 alone cannot know.
        assert_eq!(d.value.high, 1e300, "{effort}");
    }
}

#[test]
fn what_is_no_number_with_few_bits_may_be_one_with_more() {
    // With 192 bits nothing is left of 2^-64 beside 2^183.
    let module = module(
        "
  %a = 5.421010862427522e-20+1.2259964326927111e55
  %small = %a-1.2259964326927111e55
  %root = sqrt(%small)
  %quotient = 1.0/%small
  y[1] = %root
  y[2] = %quotient
",
        2,
    );
    let states = states(&module, 1);
    let function = &module.functions[0];
    for effort in [ReferenceEffort::Certified, ReferenceEffort::Audit] {
        let exact = ReferenceEvaluator::new(function, effort).evaluate(&states);
        let values = [0, 1].map(|place| exact[0][place].value.high);
        let small = 5.421010862427522e-20f64;
        assert_eq!(values, [small.sqrt(), small.recip()], "{effort}");
    }
}

#[test]
fn efforts_read_back() {
    for effort in [
        ReferenceEffort::DoubleDouble,
        ReferenceEffort::Certified,
        ReferenceEffort::Audit,
    ] {
        assert_eq!(effort.to_string().parse(), Ok(effort));
    }
    assert!("exact".parse::<ReferenceEffort>().is_err());
}
