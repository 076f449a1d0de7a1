//! The page `docs/passes.md`, made from a registry.

use robovec_framework::pass::{Gives, PassInfo, Property, Registry};
use std::fmt::Write;

/// The page as Markdown.
pub(super) fn page(registry: &Registry) -> String {
    let mut text = "# Passes\n\nPasses of `robovec-opt`, made from their registry.\n".to_owned();
    for info in registry.passes {
        section(info, &mut text);
    }
    text.push_str("\n# Presets\n\n| preset | passes | gives |\n|---|---|---|\n");
    for preset in registry.presets {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| `${}` | `{}` | {} |",
            preset.name, preset.pipeline, preset.summary
        );
    }
    text
}

fn section(info: &PassInfo, text: &mut String) {
    let _ = writeln!(text, "\n## {}\n", info.name);
    for line in info.documentation.lines() {
        let _ = writeln!(text, "{}", line.trim());
    }
    let levels: Vec<&str> = info.takes.iter().map(|level| level.name()).collect();
    let gives = match info.gives {
        Gives::Same => "the same level",
        Gives::Level(level) => level.name(),
    };
    let _ = writeln!(
        text,
        "\nTakes {}; gives {gives}; numeric class {}.",
        levels.join(", "),
        info.class
    );
    for (label, properties) in [
        ("Needs", info.requires),
        ("Establishes", info.sets),
        ("Destroys", info.destroys),
    ] {
        if !properties.is_empty() {
            let names: Vec<&str> = properties.iter().map(|&p| Property::name(p)).collect();
            let _ = writeln!(text, "{label}: {}.", names.join(", "));
        }
    }
    if info.options.is_empty() {
        return;
    }
    text.push_str("\n| option | type | default | |\n|---|---|---|---|\n");
    for option in info.options {
        let words: Vec<&str> = option.documentation.lines().map(str::trim).collect();
        let _ = writeln!(
            text,
            "| `{}` | {} | `{}` | {} |",
            option.name,
            option.type_text().replace('|', "or"),
            (option.default)(),
            words.join(" ").trim(),
        );
    }
}
