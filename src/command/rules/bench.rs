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

/// One rule, or several that say the same.
struct RuleRow {
    rules: Vec<String>,
    /// With no other rule.
    alone: ProgramSize,
    /// With all rules but this.
    without: ProgramSize,
}

/// All rules on one input.
struct RuleTable {
    input: String,
    none: ProgramSize,
    all: ProgramSize,
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
) -> Result<ProgramSize, CommandFailure> {
    let mut log = Vec::new();
    let config = Config {
        rules: Some(rules),
        ..Config::new(machine, &mut log)
    };
    manager::run(module, passes, config)
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    let mut size = ProgramSize {
        cycles: 0,
        operations: 0,
    };
    for function in &module.functions {
        size.cycles = size.cycles.max(critical_path(function, machine).asap_cycle);
        size.operations += function.nodes().len();
    }
    Ok(size)
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

fn to_text(tables: &[RuleTable], unused: &[String]) -> String {
    let mut text = String::new();
    for found in tables {
        let (none, all) = (found.none, found.all);
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
                cells.extend(changes(none, row.alone));
                cells.extend(changes(row.without, all));
                cells
            })
            .collect();
        let head = "rule | >alone: cycles | >operations | >among all: cycles | >operations";
        text.push_str(&text_table(head, &rows));
        text.push_str("\n\n");
    }
    text.push_str(
        "Alone: change by this rule over no rule at all. Among all: change by adding this rule to \
         all others;\nabove zero it takes the room or the way of better ones. Rules on one line \
         say the same of signed sums.\n",
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
    let size = |size: ProgramSize| json!({"cycles": size.cycles, "operations": size.operations});
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
