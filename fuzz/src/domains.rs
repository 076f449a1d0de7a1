//! Pairs of functions that differ only in their domains.

use arbitrary::{Result, Unstructured};
use robovec_analysis::class::NumericClass;
use robovec_framework::check::{CheckVerdict, DomainVerdict, check};
use robovec_ir::states::States;
use robovec_ir::{Module, View};

/// The expressions that replace `V`: defined where `D` is not zero or not
/// negative alone, and there of the same value.
const NARROWED: [&str; 10] = [
    "V*(D/D)",
    "V + 0*sqrt(D)",
    "V + (sqrt(D) - sqrt(D))",
    "V*((sqrt(D*D)/D)*(sqrt(D*D)/D))",
    "(V*D)/D",
    "V*sqrt(D)/sqrt(D)",
    "V + D/D - 1",
    "V*(sqrt(D)*sqrt(D))/D",
    "V + 0/D",
    "V - 0/sqrt(D)",
];

/// Expressions in `A` and `B`, polynomials of inputs, that have both signs.
const BOTH_SIGNS: [&str; 7] = [
    "(A - B)",
    "(A*B - 2)",
    "(A + sin(B))",
    "(1000000000 - A*B)",
    "(A*A - B*B)",
    "((A - 3)*(B + 5))",
    "(cos(A) - 0.5*B)",
];

/// The finding about a pair: refused, or equal with the qualification.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum DomainFinding {
    /// A point was found at which one has a value and the other none.
    Refused,
    /// Equal where both are defined.
    Qualified,
}

/// Makes a function and one with the same values that is defined in fewer
/// places, and lets the check compare the two both ways.
///
/// # Panics
///
/// Panics when they are called equal without a word about where.
pub fn domains_are_compared(data: &[u8]) {
    // Too few bytes for a pair are no finding.
    let _ = compare(&mut Unstructured::new(data));
}

/// As [`domains_are_compared`], and returns the finding.
///
/// # Errors
///
/// Fails when the bytes run out.
///
/// # Panics
///
/// As [`domains_are_compared`].
pub fn compare(bytes: &mut Unstructured<'_>) -> Result<DomainFinding> {
    let value = polynomial(bytes)?;
    let [a, b] = [input(bytes)?, input(bytes)?];
    let b = if a == b { "x[5]".to_owned() } else { b };
    let both = bytes.choose(&BOTH_SIGNS)?.replace('A', &a).replace('B', &b);
    let narrowed = bytes.choose(&NARROWED)?;
    // The condition may be another output's already.
    let other = match bytes.int_in_range(0..=3)? {
        0 => format!("1/{both}"),
        1 => format!("sqrt({both})"),
        _ => a,
    };
    let text = |output: &str| {
        format!(
            "// robovec 1\nfunction f equations {{\n  in x[1..5]\n  out y\n  out z\n\n  y = {output}\n  \
             z = {other}\n}}\n"
        )
    };
    let before = text(&value);
    let after = text(
        &narrowed
            .replace('V', &format!("({value})"))
            .replace('D', &both),
    );
    let seed = bytes.arbitrary()?;
    let verdict = judged([&before, &after], seed);
    let is_open = matches!(verdict.domain, DomainVerdict::Open(_));
    assert!(
        !verdict.holds() || is_open,
        "fewer places passed: {verdict}\n{before}\nbecame\n{after}"
    );
    let back = judged([&after, &before], seed);
    assert!(
        back.holds() && back.domain != DomainVerdict::Same,
        "more places: {back}\n{after}\nbecame\n{before}"
    );
    Ok(if is_open {
        DomainFinding::Qualified
    } else {
        DomainFinding::Refused
    })
}

fn judged(texts: [&str; 2], seed: u64) -> CheckVerdict {
    let [before, after] = texts.map(|text| {
        let read = robovec_ir::parse::parse_module("pair.rvir", text);
        read.unwrap_or_else(|_| panic!("a pair is well formed:\n{text}"))
    });
    check(
        view(&before),
        view(&after),
        NumericClass::Real,
        &States::new(seed),
        2,
    )
}

fn view(module: &Module) -> View<'_> {
    module.tables.view(&module.functions[0])
}

fn input(bytes: &mut Unstructured<'_>) -> Result<String> {
    Ok(format!("x[{}]", bytes.int_in_range(1..=4)?))
}

/// A sum of products of inputs and sines, defined everywhere.
fn polynomial(bytes: &mut Unstructured<'_>) -> Result<String> {
    let mut text = input(bytes)?;
    for _ in 0..bytes.int_in_range(0..=5)? {
        let next = input(bytes)?;
        text = match bytes.int_in_range(0..=4)? {
            0 => format!("({text} + {next})"),
            1 => format!("({text} - {next})"),
            2 => format!("{text}*{next}"),
            3 => format!("({text} + sin({next}))"),
            _ => format!("({text} + {}*{next})", bytes.int_in_range(2..=9)?),
        };
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn no_pair_passes_without_the_qualification() {
        pairs(200);
    }

    #[test]
    #[ignore = "takes minutes: as many as an account of the check names"]
    fn none_of_twenty_thousand_pairs_passes() {
        pairs(20_000);
    }

    fn pairs(count: u64) {
        let refused = AtomicU32::new(0);
        cases::on_all_cores(count, 256, |bytes| {
            let finding = compare(bytes)?;
            refused.fetch_add(
                u32::from(finding == DomainFinding::Refused),
                Ordering::Relaxed,
            );
            Ok(())
        });
        let refused = refused.into_inner();
        eprintln!("{count} pairs, {refused} refused with a point");
        assert!(
            2 * u64::from(refused) > count,
            "{refused} of {count} refused"
        );
    }
}
