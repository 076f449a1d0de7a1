//! `robovec rules check`.

use super::super::flags::whole;
use super::super::{Failure, output};
use super::{list, read};
use crate::report::table;
use clap::Args;
use robovec_passes::rules::check::{self, Finding, POINTS, TRIALS, Verdict};
use robovec_passes::rules::{Rule, RuleSet};
use serde_json::{Value, json};
use std::fmt::Write;

/// What is checked.
#[derive(Args, Debug)]
pub(super) struct CheckArguments {
    /// Rule files, or names of files that ship; all that ship by default
    files: Vec<String>,
    /// Random trials in floating point per rule
    #[arg(long, value_name = "N", default_value_t = TRIALS as u32,
          add = whole(1, 10_000_000, "every rule is evaluated at every trial"))]
    trials: u32,
    /// Write the findings as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command: findings go to the standard output, what is wrong also,
/// with its place, to the standard error.
pub(super) fn run(arguments: &CheckArguments) -> Result<String, Failure> {
    let names = if arguments.files.is_empty() {
        list::shipped()
    } else {
        arguments.files.clone()
    };
    let set = read::read(&names)?;
    let findings: Vec<Finding> = set
        .rules
        .iter()
        .map(|rule| check::check(rule, arguments.trials as usize))
        .collect();
    let text = if arguments.json {
        format!("{:#}\n", to_json(&set, &findings))
    } else {
        to_text(&set, &findings, !arguments.files.is_empty())
    };
    let mut report = set.report();
    let pairs = set.rules.iter().zip(&findings);
    report.extend(pairs.filter_map(|(rule, finding)| check::diagnose(rule, finding)));
    if report.is_empty() {
        return Ok(text);
    }
    output::write_stdout(|stdout| stdout.write_all(text.as_bytes()))?;
    Err(Failure(report))
}

fn verdict(finding: &Finding) -> &'static str {
    match finding.verdict {
        Verdict::Proved { circle: false, .. } => "proved",
        Verdict::Proved { circle: true, .. } => "proved on the circle",
        Verdict::False(_) => "FALSE",
        Verdict::Unproved => "not proved",
    }
}

/// The table, and with `examples` one for each special value.
fn to_text(set: &RuleSet, findings: &[Finding], examples: bool) -> String {
    let mut rows = Vec::new();
    let mut notes = String::new();
    for (rule, finding) in set.rules.iter().zip(findings) {
        let found = match finding.is_sound() {
            true => finding.class.name(),
            false => "-",
        };
        let words: Vec<&str> = finding.notes.iter().map(|note| note.kind.word()).collect();
        rows.push(vec![
            rule.name.clone(),
            rule.group.clone(),
            verdict(finding).to_owned(),
            rule.class.name().to_owned(),
            found.to_owned(),
            format!("{:.1}", 100.0 * finding.equal_bits),
            words.join(" "),
        ]);
        for note in &finding.notes {
            let (name, what) = (&rule.name, note.kind.describe());
            // Writing to a string cannot fail.
            let _ = writeln!(notes, "{name}: {what} ({}: {})", note.format, note.example);
        }
    }
    let head = [
        "rule",
        "file",
        "verdict",
        "declared",
        "found",
        "equal bits %",
    ];
    let sound = findings.iter().filter(|finding| finding.is_sound()).count();
    let degree = findings.iter().filter_map(|finding| match finding.verdict {
        Verdict::Proved { degree, .. } => Some(degree),
        _ => None,
    });
    let degree = degree.max().unwrap_or(0);
    let mut text = table(&head, &rows, &[5]);
    let _ = write!(
        text,
        "\n\n{sound} of {} rules proved at {POINTS} points of the field of 2^61-1; \
         degree at most {degree}, so a false rule passes with probability at most \
         {:.0e}.\nEqual bits: in binary32, random inputs from 1e-3 to 1e3.\n",
        findings.len(),
        (degree as f64 / 2f64.powi(61)).powi(POINTS as i32),
    );
    if examples && !notes.is_empty() {
        text.push_str(
            "\nSpecial values (max, min and tiny: the largest, the smallest normal and the \
             smallest number of the format):\n",
        );
        text.push_str(&notes);
    }
    text
}

fn to_json(set: &RuleSet, findings: &[Finding]) -> Value {
    let pairs = set.rules.iter().zip(findings);
    pairs
        .map(|(rule, finding)| one_json(rule, finding))
        .collect()
}

fn one_json(rule: &Rule, finding: &Finding) -> Value {
    let notes: Vec<Value> = finding
        .notes
        .iter()
        .map(|note| {
            json!({
                "kind": note.kind.word(),
                "what": note.kind.describe(),
                "format": note.format,
                "example": note.example,
            })
        })
        .collect();
    let counterexample = match &finding.verdict {
        Verdict::False(found) => {
            let values: serde_json::Map<String, Value> = found
                .values
                .iter()
                .map(|(name, value)| (name.clone(), json!(value)))
                .collect();
            json!({
                "backwards": found.backwards,
                "values": values,
                "left": found.left,
                "right": found.right,
                "difference": found.difference,
            })
        }
        Verdict::Proved { .. } | Verdict::Unproved => Value::Null,
    };
    json!({
        "rule": rule.name,
        "file": rule.group,
        "text": rule.to_string(),
        "verdict": verdict(finding),
        "sound": finding.is_sound(),
        "declared": rule.class.name(),
        "found": finding.is_sound().then(|| finding.class.name()),
        "equal_bits": finding.equal_bits,
        "counterexample": counterexample,
        "notes": notes,
    })
}
