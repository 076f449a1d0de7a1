//! The text form: reading and printing are inverse at every level, and faults
//! of a text are reported with a caret under the place.

use crate::support::files::{compare_with_record, each, name, tree};
use robovec_ir::diagnostic::Report;
use robovec_ir::parse::parse_module;
use robovec_ir::print::print_module;
use robovec_ir::verify::verify_placement;
use robovec_ir::{Level, Machine, Module, View};
use std::fs;
use std::time::{Duration, Instant};

fn parse(name: &str, text: &str) -> Module {
    match parse_module(name, text) {
        Ok(module) => module,
        Err(diagnostics) => panic!("{}", Report::of(name, text, diagnostics).render_plain()),
    }
}

#[test]
fn printed_text_reads_and_prints_the_same() {
    let mut levels = Vec::new();
    each("tests/text", &["rvir"], |path| {
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
    each("tests/errors/text", &["rvir"], |path| {
        let text = fs::read_to_string(path).expect("the test file is readable");
        let name = name(path);
        match parse_module(&name, &text) {
            Ok(_) => panic!("{name} is read without complaint"),
            Err(diagnostics) => {
                let shown = Report::of(&name, text, diagnostics).render_plain();
                compare_with_record(&tree("tests/errors/text"), &name, &shown);
            }
        }
    });
}

/// Reads a text that is no module, within a time that only a superlinear
/// algorithm would exceed; returns the messages as printed.
fn refused(text: &str) -> String {
    let start = Instant::now();
    let Err(diagnostics) = parse_module("hostile", text) else {
        panic!("{} bytes are read without complaint", text.len());
    };
    let shown = Report::of("hostile", text, diagnostics).render_plain();
    assert!(
        start.elapsed() < Duration::from_secs(20),
        "this takes too long"
    );
    assert!(shown.len() < 50_000, "{} bytes of messages", shown.len());
    shown
}

#[test]
fn hostile_text_is_refused_quickly_and_briefly() {
    let inside = |body: &str| format!("function f equations {{\n  in q\n  out M\n{body}\n}}\n");
    let shown = refused(&"(".repeat(1 << 20));
    assert!(shown.contains("'(' is not expected here"), "{shown}");
    let shown = refused(&inside(&format!("  M = {}", "(".repeat(1 << 20))));
    assert!(shown.contains("error"), "{shown}");
    let shown = refused(&inside(&format!("  M = {}", "-".repeat(1 << 20))));
    assert!(
        shown.contains("is a minus") || shown.contains("error"),
        "{shown}"
    );
    refused(&"function f equations {\n".repeat(100_000));
    refused(&"}\n".repeat(1 << 20));
    refused(&inside(&"  in q[1..3]\n".repeat(100_000)));
    refused(&inside(&"  %x = %y + %z\n".repeat(100_000)));
    refused(&inside(&format!(
        "  %x = {}",
        "%unknown + ".repeat(100_000)
    )));
    refused(&inside(&format!("  meta a \"{}", "x".repeat(10 << 20))));
    refused(&"\u{0}\u{1}\u{7f}\u{80}é".repeat(100_000));
    refused(&"%".repeat(10 << 20));
    refused(&inside(&format!("  %{} = q", "x.".repeat(1 << 20))));
    let binary: Vec<u8> = (0..1u32 << 20)
        .map(|byte| (byte.wrapping_mul(byte) >> 7) as u8)
        .collect();
    refused(&String::from_utf8_lossy(&binary));
}

#[test]
fn a_late_misspelling_in_a_large_function_is_found_quickly() {
    let mut text = String::from("function f equations {\n  in q\n  out M\n  %AF0 = q\n");
    for index in 1..200_000 {
        text.push_str(&format!("  %AF{index} = %AF{}*q\n", index - 1));
    }
    for index in 0..30 {
        text.push_str(&format!("  %E{index} = %FA{index}77\n"));
    }
    text.push_str("  M = %E0\n}\n");
    let shown = refused(&text);
    assert!(shown.contains("did you mean"), "{shown}");
}

#[test]
fn a_circle_through_a_large_function_is_shown_in_part() {
    let count = 100_000;
    let mut text = String::from("function f equations {\n  in q\n  out M\n");
    for index in 0..count {
        text.push_str(&format!("  %x{index} = %x{}*q\n", (index + 1) % count));
    }
    text.push_str("  M = %x0\n}\n");
    let shown = refused(&text);
    assert!(shown.contains("form a circle"), "{shown}");
    assert!(shown.contains("99994 more"), "{shown}");
}

#[test]
fn deep_and_wide_expressions_are_read_and_printed() {
    let function = |expression: &str| {
        format!(
            "// robovec 1\n\nfunction f equations {{\n  in q\n  out M\n\n  M = {expression}\n}}\n"
        )
    };
    let deep = function(&format!("{}q{}", "(".repeat(100_000), ")".repeat(100_000)));
    assert_eq!(print_module(&parse("deep", &deep)), function("q"));
    for expression in [
        format!("{}q{}", "sin(".repeat(100_000), ")".repeat(100_000)),
        format!("{}q{}", "-(".repeat(100_000), ")".repeat(100_000)).replace("-(q)", "-q"),
        format!("{}q{}", "q - (".repeat(100_000), ")".repeat(100_000)).replace("(q)", "q"),
        format!("q{}", " + q*q".repeat(1_000_000)),
    ] {
        let text = function(&expression);
        assert!(print_module(&parse("deep", &text)) == text);
    }
}

#[test]
fn layout_is_free() {
    let loose = "\u{feff}// a comment\r\nfunction f equations\r\n{\n\n in q [ 1 .. 2 ] // why\n\
        out M[1..2]\n// robovec 7\n\tM[2]=q[1]+   // goes on\n  q[2]\n   * 3 // and on\n\
        %x=-q[1]*2 places !0\n}";
    assert!(
        parse_module("loose", loose).is_err(),
        "an attribute is no statement"
    );
    let loose = loose.replace(" places !0", "\nM [1] = (\n%x\n)");
    let tight = "// robovec 1\n\nfunction f equations {\n  in q[1..2]\n  out M[1..2]\n\n  \
        %x = -q[1]*2.0\n\n  M[1] = %x\n  M[2] = q[1] + q[2]*3.0\n}\n";
    assert_eq!(print_module(&parse("loose", &loose)), tight);
}

#[test]
fn the_examples_of_the_documentation_are_read() {
    let document = include_str!("../docs/text-format.md");
    let examples: Vec<&str> = document
        .split("```text rvir\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .collect();
    assert_eq!(examples.len(), 5);
    for example in examples {
        let module = if example.contains("source 0") {
            parse("text-format.md", example)
        } else {
            parse("text-format.md", &format!("source 0 \"a.m\"\n{example}"))
        };
        for function in module.functions.iter().filter(|f| f.level == Level::Placed) {
            let schedule = function.schedule.as_ref().expect("it is placed");
            let machine = Machine::built_in(&schedule.machine).expect("it ships");
            let view = View {
                tables: &module.tables,
                function,
            };
            assert_eq!(verify_placement(view, &machine), []);
        }
        if example.contains("source 0") {
            assert_eq!(print_module(&module), example);
        }
    }
}

/// The message of a text that is refused.
fn complaint(text: &str) -> String {
    match parse_module("refused", text) {
        Ok(module) => panic!("it is read as\n{}", print_module(&module)),
        Err(diagnostics) => Report::of("refused", text, diagnostics).render_plain(),
    }
}

#[test]
fn names_of_one_function_mean_nothing_in_the_next() {
    for name in ["x", "x.2", "x.900000"] {
        let function = |number: u32, read: &str| {
            format!(
                "function f{number} atomic {{\n  in q\n  out M\n  %y = q + q\n  M = %{read}\n}}\n"
            )
        };
        let first = function(0, name).replace("%y", &format!("%{name}"));
        assert!(parse_module("first", &first).is_ok());
        let shown = complaint(&(first.clone() + &function(1, name)));
        assert!(
            shown.contains(&format!("%{name} is not defined")),
            "{shown}"
        );
        // Where both define it, each reads its own.
        let second = first.replace("f0", "f1").replace("q + q", "q*q");
        let module = parse("both", &(first + &second));
        assert_eq!(print_module(&module).matches("q*q").count(), 1);
    }
}

#[test]
fn outputs_may_be_set_in_any_order() {
    let text = |first: &str, second: &str| {
        format!(
            "function f equations {{\n  in q[1..3]\n  out M[1..2]\n  %a = q[1]*q[2] + q[3]\n\
             {first}{second}}}\n"
        )
    };
    let (one, two) = ("  M[1] = q[1]*%a\n", "  M[2] = q[2] - %a*q[3]\n");
    let ordered = parse("ordered", &text(one, two));
    assert!(parse("disordered", &text(two, one)) == ordered);
}
