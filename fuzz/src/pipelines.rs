//! Random pipelines over random programs.

use crate::generate::{Kind, module};
use crate::running::run as run_checked;
use crate::text::check_round_trip;
use arbitrary::{Result, Unstructured};
use robovec_ir::{Level, Module};
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

/// Runs a pipeline, which reads back from its own text, and reads the result
/// back from its text.
fn execute(module: &mut Module, text: &str, machine: &str) {
    let pipeline = REGISTRY.pipeline(text).expect("made of known passes");
    let again = REGISTRY.pipeline(&pipeline.to_string());
    assert_eq!(again.expect("printed pipelines read back"), pipeline);
    // A machine without a divider refuses a division: that is an answer.
    if run_checked(module, text, machine, text.len() as u64, None).complete {
        check_round_trip(module);
    }
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
