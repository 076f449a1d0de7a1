//! The laws of the text form.

use crate::generate::{self, Kind};
use arbitrary::{Result, Unstructured};
use robovec_framework::manager::{Config, RunError, run};
use robovec_ir::diagnostic::Report;
use robovec_ir::machine::BUILT_IN;
use robovec_ir::parse::parse_module;
use robovec_ir::print::print_module;
use robovec_ir::verify::verify;
use robovec_ir::{Function, Level, Machine, Module};
use robovec_passes::registry::REGISTRY;
use std::io;

/// Pipelines whose results have a text form at every level.
const PIPELINES: [&str; 6] = [
    "atomise",
    "atomise,zero-removal,balance,cse,dce,asap-alap",
    "atomise,fold,cse,dce",
    "atomise,place",
    "atomise,asap-alap,place{priority=mobility}",
    "atomise,fold,zero-removal,balance,cse,dce,place{choice=first},asap-alap",
];

/// Reads arbitrary bytes: the reader neither panics nor hangs, its messages
/// point into the text, and an accepted module is unchanged after it is printed
/// and read.
///
/// # Panics
///
/// Panics when a law is broken.
pub fn parse_text(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    match parse_module("fuzz", &text) {
        Ok(module) => {
            check_sound(&module);
            check_round_trip(&module);
        }
        Err(diagnostics) => {
            assert!(!diagnostics.is_empty(), "a refusal gives a reason");
            for label in diagnostics.iter().flat_map(|error| &error.labels) {
                assert!(label.range.start <= label.range.end && label.range.end <= text.len());
            }
            let shown = Report::of("fuzz", text, diagnostics).render_plain();
            assert!(shown.len() < 200_000, "{} bytes of messages", shown.len());
        }
    }
}

/// A random module: its printed text reads back as the same module, and so it
/// does at the lower levels, after random passes for a random machine.
///
/// # Panics
///
/// Panics when a law is broken, or the verifier refuses the result of a pass.
pub fn round_trip(data: &[u8]) {
    // Too few bytes are no finding.
    let _ = check_random(&mut Unstructured::new(data));
}

/// Returns whether the module was placed in the end.
fn check_random(bytes: &mut Unstructured<'_>) -> Result<bool> {
    let kind = *bytes.choose(&[Kind::Placeable, Kind::Tame, Kind::Wild])?;
    let pipeline = *bytes.choose(&PIPELINES)?;
    let (machine, _) = bytes.choose(BUILT_IN)?;
    let mut module = generate::module(bytes, kind)?;
    check_round_trip(&module);
    if !lower(&mut module, pipeline, machine) {
        return Ok(false);
    }
    check_round_trip(&module);
    let placed = |function: &Function| function.level == Level::Placed;
    Ok(module.functions.iter().any(placed))
}

/// Runs a pipeline; false when the machine lacks an operation that the module
/// needs.
pub(crate) fn lower(module: &mut Module, pipeline: &str, machine: &str) -> bool {
    let pipeline = match REGISTRY.pipeline(pipeline) {
        Ok(pipeline) => pipeline,
        Err(error) => panic!("{error:?}"),
    };
    let machine = Machine::built_in(machine).expect("it ships");
    let outcome = run(module, &pipeline, Config::new(&machine, &mut io::sink()));
    match outcome {
        Ok(_) => true,
        Err(RunError::Pass { .. }) => false,
        Err(error) => panic!("{error}"),
    }
}

/// Tests whether the verifier accepts all functions.
pub(crate) fn check_sound(module: &Module) {
    for function in &module.functions {
        assert_eq!(verify(module.tables.view(function)), []);
    }
}

/// Tests whether a module is unchanged after it is printed and read.
pub(crate) fn check_round_trip(module: &Module) {
    let text = print_module(module);
    let read = match parse_module("printed", &text) {
        Ok(read) => read,
        Err(diagnostics) => panic!(
            "printed text is refused:\n{}",
            Report::of("printed", text, diagnostics).render_plain()
        ),
    };
    assert!(read == *module, "this reads otherwise:\n{text}");
    assert_eq!(print_module(&read), text, "this prints otherwise");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn random_modules_round_trip_at_every_level() {
        let (mut cases, mut placed) = (0, 0);
        cases::of_sizes(300, 4096, |bytes| {
            cases += 1;
            placed += u32::from(check_random(bytes)?);
            Ok(())
        });
        assert!(placed > 20, "only {placed} of {cases} cases are placed");
    }

    #[test]
    fn any_bytes_are_read_or_refused() {
        cases::of_sizes(300, 500, |bytes| {
            let length = bytes.len();
            parse_text(bytes.bytes(length)?);
            Ok(())
        });
    }

    /// Damaged sound text finds more faults than random bytes.
    #[test]
    fn damaged_text_is_read_or_refused() {
        cases::of_sizes(500, 2048, |bytes| {
            let module = generate::module(bytes, Kind::Tame)?;
            let mut text = print_module(&module).into_bytes();
            cases::damage(bytes, &mut text, 4, 40)?;
            parse_text(&text);
            Ok(())
        });
    }

    #[test]
    fn words_of_the_language_in_any_order_are_read_or_refused() {
        const WORDS: [&str; 40] = [
            "function",
            "f",
            "equations",
            "atomic",
            "placed",
            "{",
            "}",
            "\n",
            "\n",
            "%x",
            "%y",
            "=",
            "=",
            "q",
            "M",
            "in",
            "out",
            "[",
            "]",
            "1",
            "..",
            "2",
            ",",
            "+",
            "*",
            "-",
            "/",
            "(",
            ")",
            "sin",
            "@1:2-3",
            "@!0",
            "places",
            "!0",
            "on",
            "add0",
            "at",
            "\"a\"",
            "source",
            "1.5",
        ];
        cases::of_sizes(1000, 500, |bytes| {
            let mut text = String::from("function f equations {\nin q\nout M\n");
            for _ in 0..bytes.int_in_range(1..=60)? {
                text.push_str(bytes.choose(&WORDS)?);
                text.push(' ');
            }
            parse_text(text.as_bytes());
            Ok(())
        });
    }
}
