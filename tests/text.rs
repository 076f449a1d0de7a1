//! The text form: reading and printing are inverse at every level, and what
//! is wrong with a text is said with a caret under the place.

use robovec_ir::diagnostic::Report;
use robovec_ir::parse::parse_module;
use robovec_ir::print::print_module;
use robovec_ir::verify::verify_placement;
use robovec_ir::{Level, Machine, Module, View};
use std::fs;

fn parse(name: &str, text: &str) -> Module {
    match parse_module(name, text) {
        Ok(module) => module,
        Err(diagnostics) => panic!("{}", Report::of(name, text, diagnostics).render_plain()),
    }
}

#[test]
fn printed_text_reads_and_prints_the_same() {
    let mut levels = Vec::new();
    insta::glob!("text/*.rvir", |path| {
        let text = fs::read_to_string(path).expect("the test file is readable");
        let name = path.display().to_string();
        let module = parse(&name, &text);
        let printed = print_module(&module);
        assert_same_lines(&name, &text, &printed);
        assert!(parse(&name, &printed) == module, "{name} reads otherwise");
        for function in &module.functions {
            levels.push(function.level);
            let Some(schedule) = function.schedule.as_ref() else {
                continue;
            };
            let machine = Machine::built_in(&schedule.machine).expect("a machine that ships");
            let view = View {
                tables: &module.tables,
                function,
            };
            if function.level == Level::Placed {
                assert_eq!(verify_placement(view, &machine), [], "{name}");
            }
        }
    });
    levels.sort_unstable();
    levels.dedup();
    assert_eq!(levels, Level::ALL, "every level has a file");
}

fn assert_same_lines(name: &str, expected: &str, actual: &str) {
    for (number, (left, right)) in expected.lines().zip(actual.lines()).enumerate() {
        assert_eq!(left, right, "{name}:{}", number + 1);
    }
    assert_eq!(expected.len(), actual.len(), "{name}");
}

#[test]
fn errors_point_at_their_place() {
    insta::glob!("errors/text/*.rvir", |path| {
        let text = fs::read_to_string(path).expect("the test file is readable");
        let name = path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned())
            .unwrap_or_default();
        match parse_module(&name, &text) {
            Ok(_) => panic!("{name} is read without complaint"),
            Err(diagnostics) => {
                let shown = Report::of(&name, text, diagnostics).render_plain();
                let mut settings = insta::Settings::clone_current();
                settings.set_snapshot_path("errors/text");
                settings.set_prepend_module_to_snapshot(false);
                settings.remove_snapshot_suffix();
                settings.set_omit_expression(true);
                settings.remove_input_file();
                settings.bind(|| insta::assert_snapshot!(name.clone(), shown));
            }
        }
    });
}
