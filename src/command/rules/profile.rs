//! `robovec rules profile`.

use super::super::flags::whole;
use super::super::{CommandFailure, input, progress};
use super::read;
use clap::Args;
use robovec_present::text_table;
use robovec_rules::profile::{self, Growing, Growth, POINTS, PairGrowth, RuleProfile, SideErrors};
use robovec_rules::{Rule, RuleSet};
use serde_json::{Value, json};
use std::fmt::Write;

/// Arguments of `rules profile`.
#[derive(Args, Debug)]
pub(super) struct ProfileArguments {
    /// Rule files, or names of files that ship; all that ship by default
    files: Vec<String>,
    /// Machine whose cycles count: a name or a .toml file
    #[arg(long, default_value = "thesis")]
    machine: String,
    /// Random points for the errors
    #[arg(long, value_name = "N", default_value_t = POINTS as u32,
          add = whole(1, 10_000_000, "every rule is evaluated at every point"))]
    points: u32,
    /// Also find pairs of rules that make a graph grow exponentially, among
    /// these rules and between these and those that ship
    #[arg(long)]
    pairs: bool,
    /// Write the profiles as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &ProfileArguments) -> Result<String, CommandFailure> {
    let machine = input::machine(&arguments.machine)?;
    let set = read::read_or_shipped(&arguments.files)?;
    let points = arguments.points as usize;
    let bar = progress::plain();
    let mut progress = |done: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    };
    let mut profiles = Vec::with_capacity(set.rules.len());
    for (index, rule) in set.rules.iter().enumerate() {
        progress(index, set.rules.len());
        profiles.push(profile::profile(rule, &machine, points));
    }
    let pairs = arguments.pairs.then(|| pairs(&set, &mut progress));
    bar.finish_and_clear();
    if arguments.json {
        return Ok(format!(
            "{:#}\n",
            to_json(&set, &profiles, pairs.as_deref())
        ));
    }
    Ok(to_text(&set, &profiles, pairs.as_deref()))
}

fn pairs(set: &RuleSet, progress: &mut dyn FnMut(usize, usize)) -> Vec<PairGrowth> {
    let built_in = RuleSet::built_in();
    let rules: Vec<&Rule> = set.rules.iter().collect();
    let mut others = rules.clone();
    let is_new = |rule: &&Rule| set.get(&rule.name).is_none();
    others.extend(built_in.rules.iter().filter(is_new));
    profile::pairs(&rules, &others, progress)
}

fn signed(change: i64) -> String {
    match change {
        0 => "0".to_owned(),
        change => format!("{change:+}"),
    }
}

fn ulps(error: f64) -> String {
    match error {
        error if error < 10.0 => format!("{error:.2}"),
        error if error < 1e5 => format!("{error:.0}"),
        error => format!("{error:.1e}"),
    }
}

fn class(growing: &Growing) -> String {
    let about = if growing.exact { "" } else { "~" };
    match growing.growth {
        Growth::Constant => "constant".to_owned(),
        Growth::Polynomial(1) => format!("{about}linear"),
        Growth::Polynomial(degree) => format!("{about}n^{degree}"),
        Growth::Exponential(base) => format!("{about}{base}^n"),
        Growth::Endless => "endless".to_owned(),
    }
}

fn grows(growing: &Growing) -> [String; 3] {
    let (formula, family) = (growing.formula.clone(), growing.family.clone());
    [class(growing), formula, family]
}

fn to_text(set: &RuleSet, profiles: &[RuleProfile], pairs: Option<&[PairGrowth]>) -> String {
    let mut rows = Vec::new();
    for (rule, profile) in set.rules.iter().zip(profiles) {
        let (transfer, change) = (&profile.transfer, &profile.change);
        let spread = |left: f64, right: f64| format!("{} > {}", ulps(left), ulps(right));
        let mut row = vec![
            rule.name.clone(),
            spread(transfer.left.median, transfer.right.median),
            spread(transfer.left.high, transfer.right.high),
            signed(change.operations),
            signed(change.cycles),
            match &change.late {
                None => String::new(),
                Some((variable, gain)) => format!("{} ({variable})", signed(*gain)),
            },
        ];
        row.extend(grows(&profile.growing));
        row.push(profile.partner.clone().unwrap_or_default());
        rows.push(row);
    }
    let head = "rule | >median error | >p99.9 error | >operations | >cycles | >late variable | \
         growth | nodes | on | with";
    let mut text = text_table(head, &rows);
    text.push_str(
        "\n\nErrors: left side > right side, in units in the last place of binary32 against the \
         left side in\ndouble-double arithmetic; inputs log-uniform from 1e-3 to 1e3, of either \
         sign.\nLate variable: change of cycles when the variable that gains most comes last.\n\
         Growth: of a graph under the rule and those that are always on (order of operands, \
         zeros, ones, double\nsigns), on its worst family of terms; ~ marks an estimate from \
         the numbers of nodes for growing n.\nWith: the rule together with which it grows \
         without bound, itself if alone.\n",
    );
    let Some(pairs) = pairs else {
        return text;
    };
    text.push_str("\nPairs that grow without bound although neither rule does:\n");
    for pair in pairs {
        let [growth, formula, family] = grows(&pair.growing);
        let names = pair.names.join(" with ");
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {names}: {growth} ({formula}) on {family}");
    }
    if pairs.is_empty() {
        text.push_str("  none\n");
    }
    text
}

fn growing_json(growing: &Growing) -> Value {
    json!({
        "class": class(growing),
        "nodes": growing.formula,
        "family": growing.family,
    })
}

fn to_json(set: &RuleSet, profiles: &[RuleProfile], pairs: Option<&[PairGrowth]>) -> Value {
    let spread = |spread: SideErrors| json!({"median": spread.median, "p99_9": spread.high});
    let rules = set.rules.iter().zip(profiles).map(|(rule, profile)| {
        let change = &profile.change;
        let late = change.late.as_ref();
        json!({
            "rule": rule.name,
            "file": rule.group,
            "left_ulps": spread(profile.transfer.left),
            "right_ulps": spread(profile.transfer.right),
            "points": profile.transfer.points,
            "operations": change.operations,
            "cycles": change.cycles,
            "late": late.map(|(variable, gain)| json!({"variable": variable, "cycles": gain})),
            "growth": growing_json(&profile.growing),
            "grows_with": profile.partner,
        })
    });
    let rules: Vec<Value> = rules.collect();
    let pairs = pairs.map(|pairs| {
        let pairs = pairs.iter();
        let list =
            pairs.map(|pair| json!({"rules": pair.names, "growth": growing_json(&pair.growing)}));
        list.collect::<Vec<Value>>()
    });
    json!({"rules": rules, "pairs": pairs})
}
