//! Random rules, true and false, with the verdict of the rule check on them.
//!
//! The truth of a rule is known without the check: true ones are instances of
//! theorems ([`theorems`]); false ones are made from them by changes
//! ([`changes`]), and numbers of 2,000 bits ([`precise`]), or their
//! construction, show that they are false. None of the false ones may be
//! proved, none of the true ones refuted.

mod changes;
mod precise;
mod theorems;

use crate::statistics::{Run, Statistics};
use arbitrary::{Result, Unstructured};
use robovec_rules::check::{RuleVerdict, check};
use robovec_rules::{Rule, RuleSet};

/// Number of runs of [`rules_are_judged`], with their inputs.
pub static STATISTICS: Statistics = Statistics::new("rules_are_judged");

/// Number of trials of the rule check in floating point; the verdict does not
/// depend on it.
const TRIALS: usize = 1;

/// Makes a true rule or a false one, and runs the rule check on it.
///
/// # Panics
///
/// Panics when a false rule is proved or a true one refuted.
pub fn rules_are_judged(data: &[u8]) {
    let result = match data.split_first() {
        Some((0..64, rest)) => judge_true(&mut Unstructured::new(rest)),
        Some((_, rest)) => judge_false(&mut Unstructured::new(rest)),
        None => Err(arbitrary::Error::NotEnoughData),
    };
    STATISTICS.record(&result.map(|judged| Run {
        operations: judged.size,
        planted: u64::from(judged.is_false),
        caught: u64::from(judged.is_false && judged.decided),
        ..Run::default()
    }));
}

/// Verdict on a rule.
#[derive(Clone, PartialEq, Debug)]
struct Judged {
    text: String,
    is_false: bool,
    /// True when it was proved or refuted.
    decided: bool,
    size: u64,
}

fn judge_true(bytes: &mut Unstructured<'_>) -> Result<Judged> {
    let rule = theorems::theorem(bytes)?;
    let verdict = check(&rule, TRIALS).verdict;
    assert!(
        !matches!(verdict, RuleVerdict::False(_)),
        "true: {rule}\n{verdict:?}"
    );
    Ok(judged(&rule, &verdict, false))
}

fn judge_false(bytes: &mut Unstructured<'_>) -> Result<Judged> {
    let rule = theorems::theorem(bytes)?;
    let changed = changes::changed(bytes, &rule)?.ok_or(arbitrary::Error::IncorrectFormat)?;
    let verdict = check(&changed, TRIALS).verdict;
    assert!(
        !matches!(verdict, RuleVerdict::Proved(_)),
        "false: {changed}\n{verdict:?}"
    );
    Ok(judged(&changed, &verdict, true))
}

fn judged(rule: &Rule, verdict: &RuleVerdict, is_false: bool) -> Judged {
    Judged {
        text: rule.to_string(),
        is_false,
        decided: !matches!(verdict, RuleVerdict::Unproved(_)),
        size: (rule.left.nodes.len() + rule.right.nodes.len()) as u64,
    }
}

/// The only rule of a text; `None` when it is malformed.
fn parsed(text: &str) -> Option<Rule> {
    RuleSet::parse(text, "random.rules").ok()?.rules.pop()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;
    use robovec_num::random::Random;

    /// Judges this number of rules of both kinds; returns the number decided of
    /// each.
    fn run(truths: usize, falsehoods: usize, seed: u64) -> [Vec<Judged>; 2] {
        let mut judged = [Vec::new(), Vec::new()];
        let wanted = [truths, falsehoods];
        let mut data = vec![0u8; 600];
        let mut random = Random::new(seed);
        while judged[0].len() < truths || judged[1].len() < falsehoods {
            for byte in &mut data {
                *byte = random.below(256) as u8;
            }
            let bytes = &mut Unstructured::new(&data);
            let kind = usize::from(judged[0].len() >= truths);
            let result = match kind {
                0 => judge_true(bytes),
                _ => judge_false(bytes),
            };
            if let Ok(found) = result {
                judged[kind].push(found);
            }
            assert!(judged[kind].len() <= wanted[kind]);
        }
        judged
    }

    fn report([truths, falsehoods]: &[Vec<Judged>; 2], show: bool) -> (usize, usize) {
        let count = |judged: &[Judged]| judged.iter().filter(|one| one.decided).count();
        let (proved, refuted) = (count(truths), count(falsehoods));
        eprintln!(
            "true: {proved} of {} proved, none refuted; false: {refuted} of {} refuted, none proved",
            truths.len(),
            falsehoods.len()
        );
        for open in truths
            .iter()
            .chain(falsehoods)
            .filter(|one| show && !one.decided)
        {
            eprintln!("  open, {}: {}", !open.is_false, open.text);
        }
        (proved, refuted)
    }

    #[test]
    fn some_rules_are_judged_rightly() {
        let judged = run(60, 120, 1);
        let (proved, refuted) = report(&judged, false);
        assert!(
            proved >= 57,
            "at most one true rule in twenty is not proved"
        );
        assert!(refuted >= 100, "hardly any false rule is left open");
    }

    /// `cargo test -p robovec-fuzz --release -- --ignored ten_thousand`.
    #[test]
    #[ignore = "takes minutes"]
    fn ten_thousand_false_rules_and_five_hundred_true_ones() {
        let parts = std::thread::scope(|scope| {
            let start = |part: u64| scope.spawn(move || run(63, 1_250, 100 + part));
            let threads: Vec<_> = (0..8).map(start).collect();
            let join = |thread: std::thread::ScopedJoinHandle<'_, _>| thread.join();
            threads
                .into_iter()
                .map(join)
                .collect::<std::thread::Result<Vec<_>>>()
        });
        let mut judged = [Vec::new(), Vec::new()];
        for [truths, falsehoods] in parts.expect("no rule is misjudged") {
            judged[0].extend(truths);
            judged[1].extend(falsehoods);
        }
        let (proved, _) = report(&judged, true);
        assert!(
            proved * 20 >= judged[0].len() * 19,
            "one true rule in twenty is not proved"
        );
    }

    #[test]
    fn theorems_hold_in_many_bits() {
        let mut seen = 0;
        cases::of_one_size(200, 600, |bytes| {
            // Not all bytes make a rule.
            if let Ok(rule) = theorems::theorem(bytes) {
                assert!(!precise::is_false(&rule), "{rule}");
                seen += 1;
            }
            Ok(())
        });
        assert!(seen > 100);
    }
}
