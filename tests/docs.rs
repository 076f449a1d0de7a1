//! The manual in `docs/` agrees with the registry.

mod commands;
pub(crate) mod limits;
mod passes;

use std::path::Path;

/// Compares a generated page with the present sources.
fn is_up_to_date(page: &str, manual: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
    if std::env::var_os("INSTA_UPDATE").is_some_and(|value| value == "always") {
        std::fs::write(&path, manual).expect("a writable folder");
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == manual,
        "{page} is not up to date; INSTA_UPDATE=always cargo test --workspace --test all docs:: writes it"
    );
}

#[test]
fn the_manual_of_passes_is_up_to_date() {
    let registry = &robovec_passes::registry::REGISTRY;
    is_up_to_date("docs/passes.md", &passes::page(registry));
}

#[test]
fn the_table_of_limits_is_up_to_date() {
    is_up_to_date("docs/limits.md", &limits::manual());
}

#[test]
fn the_page_of_commands_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/commands.md");
    let written = std::fs::read_to_string(path).expect("it is in the repository");
    is_up_to_date("docs/commands.md", &commands::page(&written));
}

#[test]
fn editors_know_every_operation_and_level() {
    use robovec_ir::{Level, Operation};
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("editors");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("it ships");
    // Operations with a sign of their own are not written as words.
    let signs = ["neg", "add", "sub", "mul", "div"];
    let operations = Operation::ALL.into_iter().map(Operation::name);
    let operations: Vec<&str> = operations.filter(|name| !signs.contains(name)).collect();
    let known = format!("({})", operations.join("|"));
    for name in ["rvir", "rules"] {
        let grammar = read(&format!("vscode/syntaxes/{name}.tmLanguage.json"));
        let parsed: serde_json::Value = serde_json::from_str(&grammar).expect("JSON");
        assert!(
            parsed["patterns"]
                .as_array()
                .is_some_and(|list| list.len() > 5)
        );
        assert!(grammar.contains(&known), "{name}: {known}");
    }
    for name in ["rvir", "robovecrules"] {
        let syntax = read(&format!("vim/syntax/{name}.vim"));
        assert!(syntax.contains(&known.replace(['(', ')'], "").replace('|', "\\|")));
    }
    for level in Level::ALL.map(Level::name) {
        for name in [
            "vscode/syntaxes/rvir.tmLanguage.json",
            "vim/syntax/rvir.vim",
        ] {
            assert!(read(name).contains(level), "{name}: {level}");
        }
    }
    for name in ["package", "rvir", "rules"] {
        let text = read(&format!("vscode/{name}.json"));
        serde_json::from_str::<serde_json::Value>(&text).expect("JSON");
    }
}
