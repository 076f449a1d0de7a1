//! `robovec rules find`.

use super::super::flags::{NUMBER, whole};
use super::super::subjects::check_number;
use super::super::{CommandFailure, input, progress};
use super::exchange::deliver;
use super::read;
use clap::Args;
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::Pipeline;
use robovec_ir::diagnostic::counted;
use robovec_ir::{Function, Machine, Module};
use robovec_present::text_table;
use robovec_rules::RuleSet;
use robovec_rules::find::{self, Found, MinedRules, MiningSpace, RuleSearch, TermSpace};
use serde_json::{Value, json};
use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};

/// Arguments of `rules find`.
#[derive(Args, Debug)]
pub(super) struct FindArguments {
    /// Equations, models (.mbs, .urdf, .xml) or names such as bogie and serial-23, on
    /// whose critical paths rules are ranked
    #[arg(default_values = ["bogie", "serial-23", "semi-serial-23", "parallel-23"])]
    files: Vec<String>,
    /// Take left sides from these (as FILES) instead of trying all terms:
    /// windows of a few operations that occur more than once
    #[arg(long, value_name = "FILE")]
    from: Vec<String>,
    /// Passes to run before the search and the ranking; gains are in addition
    /// to theirs
    #[arg(
        long,
        value_name = "PASSES",
        default_value = "atomise,zero-removal,balance,cse,dce"
    )]
    before: String,
    /// With '--from': maximum number of operations of a window
    #[arg(long, value_name = "N", default_value_t = 6,
          add = whole(2, 8, "every operation triples the number of windows of a value"))]
    window: usize,
    /// With '--from': number of shapes for which right sides are searched, once
    /// to save operations and once to shorten chains
    #[arg(long, value_name = "N", default_value_t = 500,
          add = whole(1, 1_000_000, "several hundred thousand values are tried for each shape"))]
    shapes: usize,
    /// With '--from': maximum number of values tried for one shape
    #[arg(long, value_name = "N", default_value_t = 500_000,
          add = whole(1, 1_000_000_000, "ten million take a second"))]
    values: usize,
    /// Maximum number of operations of a term
    #[arg(long, value_name = "N", default_value_t = 4,
          add = whole(1, 6, "every operation multiplies the number of terms by some hundred"))]
    operations: u32,
    /// Number of variables of a term
    #[arg(long, value_name = "N", default_value_t = 3,
          add = whole(1, 5, "every variable multiplies the number of terms"))]
    variables: u32,
    /// Numbers that may occur in terms
    #[arg(long = "constants", alias = "numbers", value_name = "NUMBERS", value_delimiter = ',',
          allow_hyphen_values = true, add = NUMBER)]
    numbers: Vec<f64>,
    /// Add the sine and cosine of an angle to the terms
    #[arg(long)]
    trigonometric: bool,
    /// Maximum number of terms tried
    #[arg(long, value_name = "N", default_value_t = 200_000,
          add = whole(1, 5_000_000, "all terms are kept and compared"))]
    terms: u32,
    /// Known rules, in addition to those that ship: a file, or a name of
    /// 'robovec rules list'
    #[arg(long, value_name = "FILE")]
    rules: Vec<String>,
    /// Take only the rules that '--rules' names as known
    #[arg(long, requires = "rules")]
    no_default_rules: bool,
    /// Machine whose cycles count: a name or a .toml file
    #[arg(long, default_value = "thesis")]
    machine: String,
    /// Rules shown, best first
    #[arg(long, value_name = "N", default_value_t = 20,
          add = whole(0, 1_000_000, "each is a line of the result"))]
    top: usize,
    /// Also write the rules that are shown as a file of rules
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
    /// Write what was found as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &FindArguments) -> Result<String, CommandFailure> {
    if let Some(odd) = arguments.numbers.iter().find(|number| !number.is_finite()) {
        return Err(CommandFailure::plain(format!(
            "a term cannot hold the number {odd}"
        )));
    }
    let machine = input::machine(&arguments.machine)?;
    let mut names = if arguments.no_default_rules {
        Vec::new()
    } else {
        read::shipped()
    };
    names.extend(arguments.rules.iter().cloned());
    let (known, _) = read::read(&names)?.sound();
    let before = input::passes(&arguments.before)?;
    let modules_on = modules(&arguments.files, &before, &machine)?;
    let functions = functions(&modules_on);
    if !arguments.from.is_empty() {
        let from = modules(&arguments.from, &before, &machine)?;
        return mine(
            arguments,
            &known,
            &self::functions(&from),
            &functions,
            &machine,
        );
    }
    let space = TermSpace {
        operations: arguments.operations,
        variables: arguments.variables,
        numbers: arguments.numbers.clone(),
        trigonometric: arguments.trigonometric,
        budget: arguments.terms as usize,
    };
    let mut search =
        with_bar(|progress| find::find(&space, &known, &functions, &machine, progress));
    let all = keep_best(&mut search, arguments)?;
    if arguments.json {
        return Ok(format!("{:#}\n", to_json(&search, all)));
    }
    Ok(to_text(&search, all))
}

/// Work whose progress a bar shows.
fn with_bar<T>(work: impl FnOnce(&mut dyn FnMut(usize, usize)) -> T) -> T {
    let bar = progress::plain();
    let mut progress = |done: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    };
    let done = work(&mut progress);
    bar.finish_and_clear();
    done
}

/// Keeps the printed rules, writes them on request; returns their number.
fn keep_best(search: &mut RuleSearch, arguments: &FindArguments) -> Result<usize, CommandFailure> {
    let all = search.found.len();
    search.found.truncate(arguments.top);
    for found in &mut search.found {
        found.rule.reason = reason(found, &arguments.files);
    }
    if let Some(path) = &arguments.output {
        let rules = search.found.iter().map(|found| found.rule.clone());
        let set = RuleSet {
            rules: rules.collect(),
            files: Vec::new(),
        };
        deliver(set.to_text(), Some(path))?;
    }
    Ok(all)
}

/// Rules whose left sides occur in functions.
fn mine(
    arguments: &FindArguments,
    known: &RuleSet,
    from: &[&Function],
    functions: &[&Function],
    machine: &Machine,
) -> Result<String, CommandFailure> {
    let space = MiningSpace {
        window: arguments.window,
        shapes: arguments.shapes,
        work: arguments.values,
    };
    let mut mined =
        with_bar(|progress| find::mine(space, known, from, functions, machine, progress));
    let all = keep_best(&mut mined.search, arguments)?;
    if arguments.json {
        let mut json = to_json(&mined.search, all);
        json["windows"] = mined.windows.into();
        json["shapes"] = mined.shapes.into();
        return Ok(format!("{json:#}\n"));
    }
    Ok(mined_text(&mined, all))
}

fn functions(modules: &[Module]) -> Vec<&Function> {
    let functions = modules.iter().flat_map(|module| &module.functions);
    functions.collect()
}

fn modules(
    names: &[String],
    before: &Pipeline,
    machine: &Machine,
) -> Result<Vec<Module>, CommandFailure> {
    let mut modules = Vec::new();
    for name in names {
        check_number(name)?;
        let read = input::equations_or_model(Path::new(name), None, None)?;
        let mut module = input::without_ranges(read, "rules find")?;
        manager::run(&mut module, before, Config::new(machine, &mut io::sink()))
            .map_err(|error| CommandFailure::plain(format!("{name}: {error}")))?;
        modules.push(module);
    }
    Ok(modules)
}

fn reason(found: &Found, files: &[String]) -> String {
    let (gain, files) = (found.gain, files.join(", "));
    let cycles = gain.cycles;
    let operations = gain.operations;
    // A quotation mark in the name of a file would end the reason.
    format!("found: {cycles} cycles and {operations} operations in {files}").replace('"', "'")
}

fn to_text(search: &RuleSearch, all: usize) -> String {
    let mut text = String::new();
    let budget = if search.complete {
        ""
    } else {
        " (more than the budget of terms or candidates allows)"
    };
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{} tried{budget}, {} of different value; {}, {} derived by known rules, {all} new.",
        counted(search.tried, "term"),
        search.different,
        counted(search.candidates, "candidate"),
        search.derived
    );
    text.push_str(&table(search));
    text
}

fn mined_text(mined: &MinedRules, all: usize) -> String {
    let search = &mined.search;
    let limits = match (mined.all_windows, search.complete) {
        (false, _) => " (some values have more windows than are searched)",
        (true, false) => " (more than '--values' for some)",
        (true, true) => "",
    };
    format!(
        "{} of {} that could gain; {} tried for {} of them{limits}: \
         {}, {} derived by known rules, {all} new.\n{}",
        counted(mined.windows, "window"),
        counted(mined.shapes, "shape"),
        counted(search.tried, "right side"),
        search.different,
        counted(search.candidates, "candidate"),
        search.derived,
        table(search)
    )
}

fn table(search: &RuleSearch) -> String {
    let mut text = String::new();
    let rows: Vec<Vec<String>> = search
        .found
        .iter()
        .map(|Found { rule, gain }| {
            let side = |pattern: &robovec_rules::Pattern| pattern.to_text(&rule.variables);
            vec![
                rule.name.clone(),
                format!("{} => {}", side(&rule.left), side(&rule.right)),
                rule.class.to_string(),
                gain.cycles.to_string(),
                gain.critical_places.to_string(),
                gain.operations.to_string(),
                gain.places.to_string(),
            ]
        })
        .collect();
    let head = "name | rule | class | >cycles | >at critical places | >operations | >at places";
    // Writing to a string cannot fail.
    let _ = writeln!(text, "\n{}", text_table(head, &rows));
    text.push_str(
        "\nCycles: by how much values on a longest chain would be earlier than by any order of \
         operands, each place alone, added up.\nOperations: saved at places that do not touch \
         each other: so many fewer there are when the rule is used.\n",
    );
    text
}

fn to_json(search: &RuleSearch, all: usize) -> Value {
    let found = search.found.iter().map(|Found { rule, gain }| {
        json!({
            "rule": rule.name,
            "text": rule.to_string(),
            "class": rule.class.name(),
            "cycles": gain.cycles,
            "critical_places": gain.critical_places,
            "operations": gain.operations,
            "places": gain.places,
        })
    });
    json!({
        "tried": search.tried,
        "complete": search.complete,
        "different": search.different,
        "candidates": search.candidates,
        "derived": search.derived,
        "new": all,
        "found": found.collect::<Vec<Value>>(),
    })
}
