//! `robovec rules check`.

use super::super::flags::whole;
use super::super::{CommandFailure, output};
use super::read;
use clap::Args;
use robovec_ir::diagnostic::counted;
use robovec_present::text_table;
use robovec_rules::check::{self, Finding, Proof, RuleVerdict, TRIALS};
use robovec_rules::{Rule, RuleSet};
use serde_json::{Value, json};
use std::fmt::Write;

/// Arguments of `rules check`.
#[derive(Args, Debug)]
pub(super) struct RuleCheckArguments {
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

/// Runs the command: findings on standard output, mistakes also on the error.
pub(super) fn run(arguments: &RuleCheckArguments) -> Result<String, CommandFailure> {
    let set = read::read_or_shipped(&arguments.files)?;
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
    Err(CommandFailure(report))
}

fn verdict(finding: &Finding) -> &'static str {
    match &finding.verdict {
        RuleVerdict::Proved(proof) if proof.circle => "proved on the circle",
        RuleVerdict::Proved(_) => "proved",
        RuleVerdict::False(_) => "FALSE",
        RuleVerdict::Unproved(_) => "not proved",
    }
}

/// A part of random points in percent; a positive part is not printed as 0.
fn percent(part: f64) -> String {
    match 100.0 * part {
        percent if percent > 0.0 && percent < 0.05 => "<0.1".to_owned(),
        percent => format!("{percent:.1}"),
    }
}

/// Facts established of all rules that are proved.
fn established(findings: &[Finding]) -> String {
    let proofs: Vec<Proof> = findings
        .iter()
        .filter_map(|finding| match finding.verdict {
            RuleVerdict::Proved(proof) => Some(proof),
            RuleVerdict::False(_) | RuleVerdict::Unproved(_) => None,
        })
        .collect();
    let count = format!(
        "{} of {} proved",
        proofs.len(),
        counted(findings.len(), "rule")
    );
    let least = |number: fn(&Proof) -> u32| proofs.iter().map(number).min();
    let (Some(points), Some(states)) = (least(|proof| proof.points), least(|proof| proof.states))
    else {
        return format!("{count}.");
    };
    let distance = proofs
        .iter()
        .map(|proof| proof.distance)
        .fold(0.0, f64::max);
    format!(
        "{count}: both sides are defined in the same places, and equal at {} or \
         more\nof each of two prime fields and at {} or more within {distance:.0e} \
         of the largest\nnumber there.",
        counted(points, "point"),
        counted(states, "state")
    )
}

/// The table, and with `examples` one for each special value.
fn to_text(set: &RuleSet, findings: &[Finding], examples: bool) -> String {
    let mut rows = Vec::new();
    let mut notes = String::new();
    for (rule, finding) in set.rules.iter().zip(findings) {
        let found = if finding.is_sound() {
            finding.class.name()
        } else {
            "-"
        };
        let words: Vec<&str> = finding.notes.iter().map(|note| note.kind.word()).collect();
        rows.push(vec![
            rule.name.clone(),
            rule.group.clone(),
            verdict(finding).to_owned(),
            rule.class.name().to_owned(),
            found.to_owned(),
            percent(finding.equal_bits),
            words.join(" "),
        ]);
        for note in &finding.notes {
            let (name, what) = (&rule.name, note.kind.describe());
            // Writing to a string cannot fail.
            let _ = writeln!(notes, "{name}: {what} ({}: {})", note.format, note.example);
        }
    }
    let head = "rule | file | verdict | declared | found | >equal bits %";
    let mut text = text_table(head, &rows);
    let _ = write!(
        text,
        "\n\n{}\nEqual bits: in binary32, random inputs from 1e-3 to 1e3; in binary64 or nearer to \
         the numbers\nof a rule where binary32 has none.\n",
        established(findings),
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
        RuleVerdict::False(found) => {
            let values: serde_json::Map<String, Value> = found
                .values
                .iter()
                .map(|(name, value)| (name.clone(), json!(value)))
                .collect();
            json!({
                "backwards": found.backwards,
                "values": values,
                "near": found.near,
                "left": found.left,
                "right": found.right,
                "difference": found.difference,
            })
        }
        RuleVerdict::Proved(_) | RuleVerdict::Unproved(_) => Value::Null,
    };
    let established = match &finding.verdict {
        RuleVerdict::Proved(proof) => proof.to_string(),
        RuleVerdict::False(found) => found.to_string(),
        RuleVerdict::Unproved(doubt) => doubt.to_string(),
    };
    json!({
        "rule": rule.name,
        "file": rule.group,
        "text": rule.to_string(),
        "verdict": verdict(finding),
        "established": established,
        "sound": finding.is_sound(),
        "declared": rule.class.name(),
        "found": finding.is_sound().then(|| finding.class.name()),
        "equal_bits": finding.equal_bits,
        "counterexample": counterexample,
        "notes": notes,
    })
}
