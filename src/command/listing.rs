//! `--list-passes`, `--help-pass`, `--list-machines`: the registry for users.

use super::CommandFailure;
use robovec_framework::pass::{Gives, PassInfo, Property};
use robovec_ir::diagnostic::suggestion;
use robovec_ir::{Machine, machine};
use robovec_passes::registry::REGISTRY;
use std::fmt::Write;

/// The passes and presets, a line each.
pub(crate) fn passes() -> String {
    let width = REGISTRY
        .passes
        .iter()
        .map(|info| info.name.len())
        .chain(REGISTRY.presets.iter().map(|preset| preset.name.len() + 1))
        .fold(0, usize::max);
    let mut text = "passes:\n".to_owned();
    for info in REGISTRY.passes {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {:width$}  {}", info.name, info.summary());
    }
    text.push_str("groups:\n");
    let _ = writeln!(
        text,
        "  fixpoint{{max=N}}(…)  repeats passes until nothing changes, at most N times (8)"
    );
    text.push_str("presets:\n");
    for preset in REGISTRY.presets {
        let name = format!("${}", preset.name);
        let _ = writeln!(text, "  {name:width$}  {}", preset.summary);
        let _ = writeln!(text, "  {:width$}  = {}", "", preset.pipeline);
    }
    text
}

/// The manual page of a pass.
pub(crate) fn pass(name: &str) -> Result<String, CommandFailure> {
    let Some(info) = REGISTRY.find(name) else {
        let names: Vec<&str> = REGISTRY.passes.iter().map(|info| info.name).collect();
        let mut notes: Vec<String> = suggestion(name, names.iter().copied())
            .into_iter()
            .collect();
        notes.push(format!("passes: {}", names.join(", ")));
        return Err(CommandFailure::advised(
            format!("there is no pass '{name}'"),
            notes,
        ));
    };
    Ok(page(info))
}

fn page(info: &PassInfo) -> String {
    let mut text = format!("{}\n\n", info.name);
    for line in info.documentation.lines() {
        let _ = writeln!(text, "  {}", line.trim_start());
    }
    let levels: Vec<&str> = info.takes.iter().map(|level| level.name()).collect();
    let gives = match info.gives {
        Gives::Same => "the same",
        Gives::Level(level) => level.name(),
    };
    let _ = writeln!(text, "\n  takes     {}", levels.join(", "));
    let _ = writeln!(text, "  gives     {gives}");
    let _ = writeln!(text, "  numerics  {}", info.class.name());
    for (label, properties) in [
        ("needs", info.requires),
        ("sets", info.sets),
        ("destroys", info.destroys),
    ] {
        if !properties.is_empty() {
            let names: Vec<&str> = properties.iter().map(|&p| Property::name(p)).collect();
            let _ = writeln!(text, "  {label:8}  {}", names.join(", "));
        }
    }
    if !info.options.is_empty() {
        text.push_str("\n  options\n");
    }
    for option in info.options {
        let _ = writeln!(
            text,
            "    {}=<{}>  (default {})",
            option.name,
            (option.type_name)(),
            (option.default)()
        );
        for line in option.documentation.lines() {
            let _ = writeln!(text, "      {}", line.trim());
        }
    }
    text
}

/// The machines that ship with robovec.
pub(crate) fn machines() -> String {
    let width = machine::BUILT_IN
        .iter()
        .map(|(name, _)| name.len())
        .fold(0, usize::max);
    let mut text = String::new();
    for (name, _) in machine::BUILT_IN {
        let machine = Machine::built_in(name).expect("the machines of the table ship");
        let _ = writeln!(text, "{name:width$}  {}", machine.description);
    }
    text
}
