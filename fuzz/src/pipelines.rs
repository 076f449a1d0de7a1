//! Random pipelines over random programs.

use crate::generate::{Kind, module};
use arbitrary::{Result, Unstructured};
use robovec_framework::manager::{self, Config};
use robovec_ir::states::States;
use robovec_ir::{Level, Machine, Module, parse, print};
use robovec_passes::registry::REGISTRY;

/// Runs a random pipeline over a random module under the verifier and the
/// semantic check.
///
/// # Panics
///
/// Panics when a pass breaks an invariant or changes the function, or when the
/// text of the result reads back as a different function.
pub fn random_pipeline(data: &[u8]) {
    // Bytes that run out make a smaller case, never a failure.
    let _ = run(&mut Unstructured::new(data));
}

fn run(bytes: &mut Unstructured<'_>) -> Result<()> {
    let names: Vec<&str> = REGISTRY
        .passes
        .iter()
        .filter(|info| {
            info.takes.contains(&Level::Atomic) && info.name != "codegen" && info.name != "place"
        })
        .map(|info| info.name)
        .collect();
    let mut text = "atomise".to_owned();
    for _ in 0..bytes.int_in_range(0..=6)? {
        let name = bytes.choose(&names)?;
        text += ",";
        text += name;
        if *name == "inline" {
            // Most other passes take single operations only.
            text += ",atomise";
        }
    }
    if bytes.arbitrary()? {
        let count = bytes.int_in_range(1..=4)?;
        let choice = bytes.choose(&["first", "preferential"])?;
        text += &format!(",place{{n_add={count} n_multi={count} choice={choice}}}");
    }
    let machine = bytes.choose(&["thesis", "side-split", "ideal"])?;
    let mut module = module(bytes, Kind::Tame)?;
    execute(&mut module, &text, machine);
    Ok(())
}

fn execute(module: &mut Module, text: &str, machine: &str) {
    let pipeline = REGISTRY.pipeline(text).expect("made of known passes");
    assert_eq!(
        REGISTRY
            .pipeline(&pipeline.to_string())
            .expect("printed pipelines read back"),
        pipeline
    );
    let machine = Machine::built_in(machine).expect("it ships");
    let before = print::print_module(module);
    let mut log = Vec::new();
    let result = manager::run(
        module,
        &pipeline,
        Config {
            check_each: Some(2),
            states: States::new(7),
            histories: text.len().is_multiple_of(2),
            ..Config::new(&machine, &mut log)
        },
    );
    match result {
        Ok(_) => {}
        // A machine without a divider refuses a division: that is an answer.
        Err(manager::RunError::Pass { .. }) => return,
        Err(error) => panic!("{text}: {error}\non {before}"),
    }
    let printed = print::print_module(module);
    let again = parse::parse_module("printed", &printed).expect("printed text reads back");
    assert!(again == *module, "{text}: the printed text differs");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn random_pipelines_keep_random_programs() {
        let mut ran = 0;
        cases::of_sizes(40, 3000, |bytes| {
            run(bytes)?;
            ran += 1;
            Ok(())
        });
        assert!(ran > 10, "only {ran} programs were long enough to test");
    }
}
