//! The verdicts on hard cases, and that every class has a cure.
//!
//! What each case is expected to be called stands with the case. Those that
//! take long without optimisation are left to optimised builds and to
//! `robovec stress`, which checks the same.

use robovec::stress::{CaseClass, StressVerdict, cases, examine, judge};
use std::collections::BTreeSet;

#[test]
fn names_are_unique_and_every_class_has_cases() {
    let cases = cases();
    let names: BTreeSet<&str> = cases.iter().map(|case| case.name.as_str()).collect();
    assert_eq!(names.len(), cases.len());
    for class in CaseClass::ALL {
        assert!(cases.iter().any(|case| case.class == class), "{class:?}");
        assert_eq!(CaseClass::from_name(class.name()), Some(class));
    }
    for verdict in StressVerdict::ALL {
        let met = cases.iter().any(|case| case.expected == verdict);
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
        if found.verdict != case.expected {
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
