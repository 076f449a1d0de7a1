//! `robovec rules bench`.

use super::super::shares::ShareArguments;
use super::super::{CommandFailure, input, output};
use super::read;
use clap::Args;
use rayon::prelude::*;
use robovec_analysis::critical_path::critical_path;
use robovec_explore::share::SharedWork;
use robovec_explore::store::PointKey;
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::Pipeline;
use robovec_ir::diagnostic::counted;
use robovec_ir::{Machine, Module};
use robovec_passes::eqsat;
use robovec_present::json::json_text;
use robovec_present::text_table;
use robovec_present::{DataCell, DataTable};
use robovec_rules::RuleSet;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Arguments of `rules bench`.
#[derive(Args, Debug)]
pub(super) struct RuleBenchArguments {
    /// Equations or models (.mbs, .urdf, .xml) to try the rules on
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Additional rules: a .rules file; false rules are reported and left out
    #[arg(long, value_name = "FILE")]
    rules: Vec<String>,
    /// Only the rules named by --rules
    #[arg(long, requires = "rules")]
    only: bool,
    /// Passes to run before the rules are used
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
    /// Folder for rules.csv and rules.json, and for the figures of every rule
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    shares: ShareArguments,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
struct ProgramSize {
    cycles: u32,
    operations: usize,
}

/// Limits of the windows in which rules were used.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Serialize, Deserialize)]
struct WindowLimits {
    windows: u64,
    /// Those that the limit of forms ended, and that of rounds of rules.
    out_of_nodes: u64,
    out_of_iterations: u64,
    forms: u64,
}

/// A program that rules were used on.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
struct Rewritten {
    size: ProgramSize,
    limits: WindowLimits,
}

/// One rule, or several that are equal.
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

/// Settings for every input.
struct RuleBench<'a> {
    machine: &'a Machine,
    passes: &'a Pipeline,
    rules: &'a RuleSet,
    /// Names of the rules, equal ones together.
    kinds: &'a [Vec<String>],
    work: SharedWork<'a>,
}

pub(super) fn run(arguments: &RuleBenchArguments) -> Result<String, CommandFailure> {
    let machine = input::machine(&arguments.machine)?;
    let before = input::passes(&arguments.before)?;
    let passes = input::passes(&arguments.passes)?;
    let rules = read::sound(&arguments.rules, !arguments.only)?;
    let kinds = eqsat::kinds(&rules, arguments.passes.contains("trig"));
    let store = arguments.shares.store(arguments.output.as_deref())?;
    let bench = RuleBench {
        machine: &machine,
        passes: &passes,
        rules: &rules,
        kinds: &kinds.used,
        work: SharedWork::new(store.as_ref(), arguments.shares.share()),
    };
    let mut tables = Vec::with_capacity(arguments.inputs.len());
    let mut text = String::new();
    for (number, path) in arguments.inputs.iter().enumerate() {
        let input = input::equations_or_model(path, None, None)?;
        let name = input.name.clone();
        let mut module = input::without_ranges(input, "rules bench")?;
        compile(&mut module, &before, &machine, &RuleSet::default())?;
        let measured = bench.measure(number, &module)?;
        match arguments.shares.shard {
            None => tables.push(bench.table(name, &measured)),
            Some(_) => {
                let (count, found) = (measured.len(), measured.iter().filter(|m| m.found).count());
                text += &format!(
                    "{name}: {}, {found} of them found\n",
                    counted(count, "measurement")
                );
            }
        }
    }
    if arguments.shares.shard.is_some() {
        return Ok(text);
    }
    let data = to_json(&tables, &kinds.unused);
    if let Some(folder) = &arguments.output {
        write(folder, &tables, &data)?;
    }
    if arguments.json {
        return Ok(format!("{data:#}\n"));
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

/// The rules of a set whose names are requested, or all but these.
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

/// Two programs of an input.
struct RuleMeasurement {
    /// With these rules alone, and with all others; first with none and all.
    programs: [Rewritten; 2],
    /// Kept by an earlier run or another worker.
    found: bool,
}

impl RuleBench<'_> {
    /// A share's measurements on input `number`: of all rules, then by kind.
    fn measure(
        &self,
        number: usize,
        module: &Module,
    ) -> Result<Vec<RuleMeasurement>, CommandFailure> {
        let key = self.work.key("rules bench");
        let key = key.map(|key| self.with_rules(key.with_module(module)));
        let count = self.kinds.len() + 1;
        let own = (0..count).filter(|kind| self.work.share.holds(number * count + kind));
        let own: Vec<usize> = own.collect();
        // Side by side; the measurements stay in order of the rules.
        let measured = own.into_par_iter().map(|kind| {
            let names: &[String] = kind.checked_sub(1).map_or(&[], |kind| &self.kinds[kind]);
            let key = key.map(|key| names.iter().fold(key, |key, name| key.with(name)));
            let found = self.work.load(key);
            let programs = match found {
                Some(programs) => programs,
                None => {
                    let programs = self.programs(module, names)?;
                    self.work.save(key, &programs);
                    programs
                }
            };
            let found = found.is_some();
            Ok(RuleMeasurement { programs, found })
        });
        measured.collect()
    }

    /// Programs with rules alone, and with all others.
    fn programs(
        &self,
        module: &Module,
        names: &[String],
    ) -> Result<[Rewritten; 2], CommandFailure> {
        let with = |keep: bool| {
            let rules = subset(self.rules, names, keep);
            compile(&mut module.clone(), self.passes, self.machine, &rules)
        };
        Ok([with(true)?, with(false)?])
    }

    /// Adds to a key the rules and limits common to all inputs.
    fn with_rules(&self, key: PointKey) -> PointKey {
        let key = key.with_machine(self.machine);
        let mut key = key.with(&self.passes.to_string());
        for file in &self.rules.files {
            key = key.with(&file.name).with(&file.text);
        }
        // Which of their rules are used.
        for rule in &self.rules.rules {
            key = key.with(&rule.name);
        }
        key.with("")
    }

    /// The table of an input whose measurements are complete.
    fn table(&self, input: String, measured: &[RuleMeasurement]) -> RuleTable {
        let [none, all] = measured[0].programs;
        let rows = self.kinds.iter().zip(&measured[1..]);
        let rows = rows.map(|(names, measured)| RuleRow {
            rules: names.clone(),
            alone: measured.programs[0],
            without: measured.programs[1],
        });
        RuleTable {
            input,
            none,
            all,
            rows: rows.collect(),
        }
    }
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

/// Reason why a program with a rule more is worse than the one without it.
fn why_worse(row: &RuleRow, all: Rewritten) -> Option<String> {
    let (with, without) = (all.limits, row.without.limits);
    if all.size.cycles <= row.without.size.cycles {
        return None;
    }
    let rule = row.rules.join(", ");
    let forms = |limits: WindowLimits| limits.forms / limits.windows.max(1);
    let room = |limits: WindowLimits| share(limits.out_of_nodes, limits.windows);
    let why = match room(with).total_cmp(&room(without)) {
        std::cmp::Ordering::Greater => "it takes the place of other forms in the graphs",
        _ if with.out_of_iterations > without.out_of_iterations => {
            "with it fewer rounds of rules are possible"
        }
        _ => {
            "no limit makes the difference: windows are rewritten one after the other, and a gain in \
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
            "{}: {} and {} without rules, {} and {} with all\n",
            found.input,
            counted(none.cycles, "cycle"),
            counted(none.operations, "operation"),
            all.cycles,
            all.operations
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
            "\n\nWith all rules: {}, {}; {:.0} % end without room for more forms, \
             {:.0} % with no rounds of rules left.\n",
            counted(limits.windows, "window"),
            counted(limits.forms, "form"),
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
         all others. Rules on one line are the same for signed sums.\n",
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

fn data_table(tables: &[RuleTable]) -> DataTable {
    let size = |size: ProgramSize| {
        [
            DataCell::count(size.cycles),
            DataCell::count(size.operations),
        ]
    };
    let rows = tables.iter().flat_map(|found| {
        found.rows.iter().map(move |row| {
            let mut cells = vec![
                DataCell::text(&found.input),
                DataCell::text(row.rules.join(" ")),
            ];
            for each in [found.none, row.alone, row.without, found.all] {
                cells.extend(size(each.size));
            }
            cells
        })
    });
    DataTable::new(
        "rules",
        "Rules: what each earns",
        "Cycles of the longest path and operations: without rules, with this rule alone, with all but this, with all.",
        "input | rules | cycles without rules | operations without rules | cycles alone | \
         operations alone | cycles among others without | operations among others without | \
         cycles with all | operations with all",
        rows,
    )
}

fn write(folder: &Path, tables: &[RuleTable], data: &Value) -> Result<(), CommandFailure> {
    let files = [
        ("rules.csv", data_table(tables).to_csv()),
        ("rules.json", json_text(data)),
    ];
    output::write_files(folder, &files)
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
