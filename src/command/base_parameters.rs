//! Base parameters of a model as text, and the map to them as a table.

use super::CommandFailure;
use robovec_dynamics::generate::{BaseParameterError, BaseParameters, Options, parameter_name};
use robovec_ir::diagnostic::counted;
use robovec_model::Model;
use robovec_present::number::exponential;
use robovec_present::{DataTable, columns};
use std::fmt::Write;

/// Number of columns of text.
const WIDTH: usize = 80;

pub(super) fn find(model: &Model, options: &Options) -> Result<BaseParameters, CommandFailure> {
    BaseParameters::new(model, options).map_err(|error| {
        let notes = match error {
            BaseParameterError::Undecided { .. } | BaseParameterError::Unverified(_) => vec![
                "angles that are almost right and lengths that are almost zero have this effect: \
                 correct them in the file, or take --right-angles 1e-5"
                    .to_owned(),
            ],
            _ => Vec::new(),
        };
        CommandFailure::advised(error.to_string(), notes)
    })
}

/// A factor of the map.
struct MapEntry<'a> {
    base: usize,
    value: f64,
    column: usize,
    body: &'a str,
    factor: f64,
}

/// The map from all parameters to the base parameters, without its zeros.
pub(super) fn table(model: &Model, found: &BaseParameters) -> DataTable {
    let bases = found.parameters.iter().enumerate();
    let entries = bases.flat_map(|(place, base)| {
        base.terms.iter().map(move |&(column, factor)| MapEntry {
            base: place + 1,
            value: base.value,
            column,
            body: body(model, column),
            factor,
        })
    });
    let rows: Vec<MapEntry<'_>> = entries.collect();
    let columns = columns! { MapEntry<'_>;
        "base", [All, All], |entry| entry.base;
        "base value", [All, All], |entry| entry.value;
        "column", [All, All], |entry| entry.column + 1;
        "parameter", [All, All], |entry| parameter_name(entry.column);
        "body", [All, All], |entry| entry.body;
        "factor", [All, All], |entry| entry.factor;
    };
    columns.table("base-parameters", "Base parameters", "", &rows)
}

pub(super) fn text(model: &Model, found: &BaseParameters) -> String {
    let bodies = (0..model.joints.len()).filter(|&joint| model.body_of(joint).is_some());
    let all = 10 * bodies.count();
    let (count, zero) = (found.parameters.len(), found.without_effect.len());
    let mut text = format!(
        "{count} base parameters of {all} ({zero} without effect, {} in combinations only)\n",
        all - count - zero
    );
    let _ = writeln!(
        text,
        "effects relative to the largest: {} or more, and {} or less left out\n\
         Y p = Yb K p within {} of each column, at other states",
        exponential(found.least_kept),
        exponential(found.most_left_out),
        exponential(found.difference),
    );
    if !model.cuts.is_empty() {
        text += "loops are open: closed ones may need fewer\n";
    }
    let rotors = model.joints.iter().filter(|joint| joint.armature != 0.0);
    let rotors = rotors.count();
    if rotors > 0 {
        let rotors = counted(rotors, "joint");
        let _ = writeln!(text, "the armature of {rotors} is not among the parameters");
    }
    text += "\nbase  value        sum\n";
    for (place, base) in found.parameters.iter().enumerate() {
        let head = format!("{:4}  {:<11} ", place + 1, short(base.value));
        let terms = base.terms.iter().enumerate().map(|(index, &(at, factor))| {
            let sign = match (index, factor < 0.0) {
                (0, _) => "",
                (_, false) => "+ ",
                (_, true) => "- ",
            };
            let name = parameter_name(at);
            match factor.abs() {
                1.0 => format!("{sign}{name}"),
                size => format!("{sign}{} {name}", short(size)),
            }
        });
        wrapped(&mut text, head, terms);
    }
    if zero > 0 {
        text.push('\n');
        let names = found.without_effect.iter().map(|&at| parameter_name(at));
        wrapped(&mut text, "without effect:".to_owned(), names);
    }
    text
}

/// Adds words after the start of a line, on as many lines as they need.
fn wrapped(text: &mut String, mut line: String, words: impl Iterator<Item = String>) {
    let indent = line.len();
    for word in words {
        if line.len() + 1 + word.len() > WIDTH {
            let _ = writeln!(text, "{line}");
            line = " ".repeat(indent);
        }
        line.push(' ');
        line += &word;
    }
    let _ = writeln!(text, "{line}");
}

/// A number with six digits at most.
fn short(number: f64) -> String {
    let rounded: f64 = format!("{number:.5e}").parse().expect("it is a number");
    let plain = rounded.to_string();
    if plain.len() > 11 {
        format!("{rounded:e}")
    } else {
        plain
    }
}

/// The name of the body that a column belongs to.
fn body(model: &Model, column: usize) -> &str {
    model.body_of(column / 10).map_or("", |body| &body.name)
}
