//! `robovec rules bench`.

use super::super::{CommandFailure, input};
use super::read;
use crate::present::text_table;
use clap::Args;
use rayon::prelude::*;
use robovec_analysis::critical_path::critical_path;
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::Pipeline;
use robovec_ir::{Machine, Module};
use robovec_passes::eqsat;
use robovec_rules::RuleSet;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// What is measured.
#[derive(Args, Debug)]
pub(super) struct RuleBenchArguments {
    /// Equations or models (.mbs, .urdf) to try the rules on
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Rules beside those that ship: a .rules file; false ones are told and
    /// left out
    #[arg(long, value_name = "FILE")]
    rules: Vec<String>,
    /// Only the rules named by --rules
    #[arg(long, requires = "rules")]
    only: bool,
    /// Passes before the rules are used
    #[arg(long, default_value = "atomise,zero-removal,balance,cse,dce")]
    before: String,
    /// Passes that use the rules
    #[arg(long, default_value = "eqsat,balance,cse,dce")]
    passes: String,
    /// Machine whose cycles count: a name or a .toml file
    #[arg(long, default_value = "thesis")]
    machine: String,
    /// Write the figures as JSON
    #[arg(long)]
    json: bool,
}

/// Size of a program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct ProgramSize {
    cycles: u32,
    operations: usize,
}

/// What limited the windows in which rules were used.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
struct WindowLimits {
    windows: u64,
    /// Those that the limit of forms ended, and that of rounds of rules.
    out_of_nodes: u64,
    out_of_iterations: u64,
    forms: u64,
}

/// A program that rules were used on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Rewritten {
    size: ProgramSize,
    limits: WindowLimits,
}

/// One rule, or several that say the same.
struct RuleRow {
    rules: Vec<String>,
    /// With no other rule.
    alone: Rewritten,
    /// With all rules but this.
    without: Rewritten,
}

/// All rules on one input.
struct RuleTable {
    input: String,
    none: Rewritten,
    all: Rewritten,
    rows: Vec<RuleRow>,
}

/// Runs the command.
pub(super) fn run(arguments: &RuleBenchArguments) -> Result<String, CommandFailure> {
    let machine = input::machine(&arguments.machine)?;
    let before = input::passes(&arguments.before)?;
    let passes = input::passes(&arguments.passes)?;
    let rules = read::sound(&arguments.rules, !arguments.only)?;
    let kinds = eqsat::kinds(&rules, arguments.passes.contains("trig"));
    let mut tables = Vec::with_capacity(arguments.inputs.len());
    for path in &arguments.inputs {
        let mut input = input::equations_or_model(path, None, None)?;
        compile(&mut input.module, &before, &machine, &RuleSet::default())?;
        let name = input.name.clone();
        tables.push(measure(
            name,
            &input.module,
            &passes,
            &machine,
            &rules,
            &kinds.used,
        )?);
    }
    if arguments.json {
        return Ok(format!("{:#}\n", to_json(&tables, &kinds.unused)));
    }
    Ok(to_text(&tables, &kinds.unused))
}

fn compile(
    module: &mut Module,
    passes: &Pipeline,
    machine: &Machine,
    rules: &RuleSet,
) -> Result<Rewritten, CommandFailure> {
    let mut log = Vec::new();
    let config = Config {
        rules: Some(rules),
        ..Config::new(machine, &mut log)
    };
    let outcome = manager::run(module, passes, config)
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    let mut limits = WindowLimits::default();
    for (name, count) in outcome.records.iter().flat_map(|record| &record.statistics) {
        match *name {
            eqsat::WINDOWS => limits.windows += count,
            eqsat::OUT_OF_NODES => limits.out_of_nodes += count,
            eqsat::OUT_OF_ITERATIONS => limits.out_of_iterations += count,
            eqsat::FORMS => limits.forms += count,
            _ => {}
        }
    }
    let mut size = ProgramSize {
        cycles: 0,
        operations: 0,
    };
    for function in &module.functions {
        size.cycles = size.cycles.max(critical_path(function, machine).asap_cycle);
        size.operations += function.nodes().len();
    }
    Ok(Rewritten { size, limits })
}

/// The rules of a set whose names are asked for, or all but these.
fn subset(rules: &RuleSet, names: &[String], keep: bool) -> RuleSet {
    let kept = rules
        .rules
        .iter()
        .filter(|rule| names.contains(&rule.name) == keep);
    RuleSet {
        rules: kept.cloned().collect(),
        files: rules.files.clone(),
    }
}

fn measure(
    input: String,
    module: &Module,
    passes: &Pipeline,
    machine: &Machine,
    rules: &RuleSet,
    kinds: &[Vec<String>],
) -> Result<RuleTable, CommandFailure> {
    let with = |rules: &RuleSet| compile(&mut module.clone(), passes, machine, rules);
    let none = with(&RuleSet::default())?;
    let all = with(rules)?;
    // Side by side; the rows stay in order of the rules.
    let rows: Result<Vec<RuleRow>, CommandFailure> = kinds
        .par_iter()
        .map(|names| {
            Ok(RuleRow {
                rules: names.clone(),
                alone: with(&subset(rules, names, true))?,
                without: with(&subset(rules, names, false))?,
            })
        })
        .collect();
    Ok(RuleTable {
        input,
        none,
        all,
        rows: rows?,
    })
}

/// A change, with a sign.
fn change(from: i64, to: i64) -> String {
    match to - from {
        0 => "0".to_owned(),
        change => format!("{change:+}"),
    }
}

fn changes(from: ProgramSize, to: ProgramSize) -> [String; 2] {
    [
        change(from.cycles.into(), to.cycles.into()),
        change(from.operations as i64, to.operations as i64),
    ]
}

/// Why a program with a rule more is worse than the one without it.
fn why_worse(row: &RuleRow, all: Rewritten) -> Option<String> {
    let (with, without) = (all.limits, row.without.limits);
    if all.size.cycles <= row.without.size.cycles {
        return None;
    }
    let rule = row.rules.join(", ");
    let forms = |limits: WindowLimits| limits.forms / limits.windows.max(1);
    let room = |limits: WindowLimits| share(limits.out_of_nodes, limits.windows);
    let why = match room(with).total_cmp(&room(without)) {
        std::cmp::Ordering::Greater => "it takes the room of others in the graphs",
        _ if with.out_of_iterations > without.out_of_iterations => {
            "with it the rounds of rules end sooner"
        }
        _ => {
            "no limit tells them apart: windows are rewritten one after the other, and a gain in \
             one can spoil that of a later one"
        }
    };
    Some(format!(
        "  {rule}: {why}; {} of {} windows end without room for more forms ({} of {} without it), \
         {} and {} with no rounds left, {} and {} forms a window",
        with.out_of_nodes,
        with.windows,
        without.out_of_nodes,
        without.windows,
        with.out_of_iterations,
        without.out_of_iterations,
        forms(with),
        forms(without),
    ))
}

fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

fn to_text(tables: &[RuleTable], unused: &[String]) -> String {
    let mut text = String::new();
    for found in tables {
        let (none, all) = (found.none.size, found.all.size);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{}: {} cycles and {} operations without rules, {} and {} with all\n",
            found.input, none.cycles, none.operations, all.cycles, all.operations
        );
        let rows: Vec<Vec<String>> = found
            .rows
            .iter()
            .map(|row| {
                let mut cells = vec![row.rules.join(", ")];
                cells.extend(changes(none, row.alone.size));
                cells.extend(changes(row.without.size, all));
                cells
            })
            .collect();
        let head = "rule | >alone: cycles | >operations | >among all: cycles | >operations";
        text.push_str(&text_table(head, &rows));
        let limits = found.all.limits;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "\n\nWith all rules: {} windows, {} forms; {:.0} % end without room for more forms, \
             {:.0} % with no rounds of rules left.\n",
            limits.windows,
            limits.forms,
            100.0 * share(limits.out_of_nodes, limits.windows),
            100.0 * share(limits.out_of_iterations, limits.windows),
        );
        let worse: Vec<String> = found
            .rows
            .iter()
            .filter_map(|row| why_worse(row, found.all))
            .collect();
        if !worse.is_empty() {
            let _ = writeln!(text, "Worse with than without:\n{}\n", worse.join("\n"));
        }
    }
    text.push_str(
        "Alone: change by this rule over no rule at all. Among all: change by adding this rule to \
         all others. Rules on one line say the same of signed sums.\n",
    );
    if !unused.is_empty() {
        let _ = writeln!(
            text,
            "Not used, since signed sums and products have them built in, or of a weaker class: {}.",
            unused.join(", ")
        );
    }
    text
}

fn to_json(tables: &[RuleTable], unused: &[String]) -> Value {
    let size = |made: Rewritten| {
        let (size, limits) = (made.size, made.limits);
        json!({
            "cycles": size.cycles,
            "operations": size.operations,
            "windows": limits.windows,
            "out_of_nodes": limits.out_of_nodes,
            "out_of_iterations": limits.out_of_iterations,
            "forms": limits.forms,
        })
    };
    let tables: Vec<Value> = tables
        .iter()
        .map(|found| {
            let rows: Vec<Value> = found
                .rows
                .iter()
                .map(|row| {
                    json!({
                        "rules": row.rules,
                        "alone": size(row.alone),
                        "without": size(row.without),
                    })
                })
                .collect();
            json!({
                "input": found.input,
                "none": size(found.none),
                "all": size(found.all),
                "rules": rows,
            })
        })
        .collect();
    json!({"inputs": tables, "unused": unused})
}
