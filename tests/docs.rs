//! The manual in `docs/` says what the registry says.

use std::path::Path;

#[test]
fn the_manual_of_passes_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/passes.md");
    let manual = robovec_framework::manual::manual(&robovec_passes::registry::REGISTRY);
    if std::env::var_os("INSTA_UPDATE").is_some_and(|value| value == "always") {
        std::fs::write(&path, &manual).expect("a writable folder");
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == manual,
        "docs/passes.md is not up to date; INSTA_UPDATE=always cargo test --workspace --test all docs:: writes it"
    );
}

#[test]
fn the_table_of_limits_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/limits.md");
    let manual = robovec::limits::manual();
    if std::env::var_os("INSTA_UPDATE").is_some_and(|value| value == "always") {
        std::fs::write(&path, &manual).expect("a writable folder");
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == manual,
        "docs/limits.md is not up to date; INSTA_UPDATE=always cargo test --workspace --test all docs:: writes it"
    );
}

#[test]
fn the_page_of_commands_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/commands.md");
    let manual = robovec::grammar::manual();
    if std::env::var_os("INSTA_UPDATE").is_some_and(|value| value == "always") {
        std::fs::write(&path, &manual).expect("a writable folder");
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == manual,
        "docs/commands.md is not up to date; INSTA_UPDATE=always cargo test --workspace --test all docs:: writes it"
    );
}
