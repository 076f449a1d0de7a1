//! The verdicts on hard cases, and that every class has a cure.
//!
//! The expected verdict of each case is beside the case. Those that take long
//! without optimisation are left to optimised builds and to `robovec stress`,
//! which checks the same.

use crate::support::programs::{assert_fits_a_screen, robovec, said};
use robovec::stress::{CaseClass, StressVerdict, cases, examine, judge};
use std::collections::BTreeSet;

#[test]
fn names_are_unique_and_every_class_has_cases() {
    let cases = cases();
    let names: BTreeSet<&str> = cases.iter().map(|case| case.name.as_str()).collect();
    assert_eq!(names.len(), cases.len());
    for class in CaseClass::ALL {
        assert!(cases.iter().any(|case| case.class == class), "{class:?}");
        assert_eq!(CaseClass::from_name(class.name), Some(class));
    }
    for verdict in StressVerdict::ALL {
        let met = cases.iter().any(|case| case.expected == Some(verdict));
        assert!(met, "no case is {verdict}");
    }
}

#[test]
fn verdicts_are_those_expected() {
    let mut wrong = Vec::new();
    for case in cases() {
        if case.long && cfg!(debug_assertions) {
            continue;
        }
        let found = judge(&case).expect("it can be measured");
        // Binary64 is never worse, but for what no format changes. In
        // binary32 there may be no result at all.
        let worse = found.long.error > found.short.error * 1.001;
        assert!(!worse && found.long.error.is_finite(), "{}", case.name);
        if Some(found.verdict) != case.expected {
            wrong.push(format!(
                "{} is {}: {:e} in f32, {:e} in f64, {:e} attainable",
                case.name, found.verdict, found.short.error, found.long.error, found.floor
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_class_is_cured() {
    for class in CaseClass::ALL {
        // One case of each class; the hard ones stand behind the easy ones.
        let mut of_class = cases().into_iter().filter(|case| case.class == class);
        let case = of_class.rfind(|case| !case.long);
        let case = case.expect("every class has a short case");
        let found = examine(&case).expect("it can be measured");
        let cure = found
            .cure()
            .unwrap_or_else(|| panic!("{} has no cure", case.name));
        let exact = f64::EPSILON / 2.0;
        assert!(cure.measured.error <= 10.0 * found.long.error.max(exact));
        assert!(cure.measured.consistent);
        // The cheapest one costs no more than computing all in binary64.
        let wide = found
            .trials
            .iter()
            .find(|trial| trial.measured == found.long);
        let wide = wide.expect("binary64 is tried");
        assert!(
            cure.cost <= wide.cost,
            "{}: {} {}",
            case.name,
            cure.label,
            cure.cost
        );
    }
}

/// The hard states of a model and of a function are found: the gimbal of the
/// leg, which random states miss, and the state in which sums cancel.
#[test]
fn a_given_file_is_driven_to_its_hard_states() {
    let text = said(&robovec(&[
        "stress",
        "examples/models/leg.mbs",
        "--verdicts",
    ]));
    assert_fits_a_screen(&text);
    let row = |name: &str| {
        let mut lines = text.lines().filter(|line| line.starts_with(name));
        lines.next_back().expect("a case").to_owned()
    };
    assert!(row("random").contains("fine"), "{text}");
    assert!(row("singular").contains("hard problem"), "{text}");
    let text = said(&robovec(&[
        "stress",
        "examples/models/four-bar.mbs",
        "--verdicts",
    ]));
    assert!(text.contains("condition of the loops"), "{text}");
    let function = ["--function", "versine", "--verdicts"];
    let text = said(&robovec(
        &[
            &["stress", "examples/rounding/cancellation.fpcore"],
            &function[..],
        ]
        .concat(),
    ));
    assert!(
        text.contains("bad code") || text.contains("hard problem"),
        "{text}"
    );
}
