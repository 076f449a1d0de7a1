//! Random programs in more accurate forms and in mixed formats.

use crate::generate::{Kind, module};
use arbitrary::{Result, Unstructured};
use robovec_framework::manager::{self, Config, RunError};
use robovec_ir::{Machine, Module, print};
use robovec_passes::registry::REGISTRY;

/// Runs `accurate` with random budgets and `mixed` with a random error over a
/// random program.
///
/// # Panics
///
/// Panics when a pass changes the function over the prime field, panics or
/// breaks an invariant.
pub fn precision_keeps_programs(data: &[u8]) {
    // Bytes that run out make a smaller case, never a failure.
    let _ = run(&mut Unstructured::new(data));
}

fn run(bytes: &mut Unstructured<'_>) -> Result<bool> {
    let budget = bytes.choose(&["", "{growth=50}", "{growth=900 slack=400}"])?;
    let format = bytes.choose(&["f32", "f64", "f16"])?;
    let error = bytes.choose(&["1e-3", "1e-6", "1e-12"])?;
    let machine = bytes.choose(&["thesis", "fused"])?;
    let mut module = module(bytes, Kind::Tame)?;
    let accurate = match budget.strip_suffix('}') {
        None => format!("accurate{{format={format}}}"),
        Some(options) => format!("{options} format={format}}}").replacen('{', "accurate{", 1),
    };
    let kept = execute(&mut module, &format!("atomise,{accurate}"), machine);
    let mixed = format!("mixed{{error={error} narrow=bf16 between=2 states=8}}");
    Ok(execute(&mut module, &mixed, machine) && kept)
}

/// False when a pass has a reason to refuse the function.
fn execute(module: &mut Module, text: &str, machine: &str) -> bool {
    let pipeline = REGISTRY.pipeline(text).expect("made of known passes");
    let machine = Machine::built_in(machine).expect("it ships");
    let before = print::print_module(module);
    let mut log = Vec::new();
    let config = Config {
        check_each: Some(2),
        ..Config::new(&machine, &mut log)
    };
    match manager::run(module, &pipeline, config) {
        Ok(_) => true,
        Err(RunError::Pass { .. }) => false,
        Err(error) => panic!("{text}: {error}\non {before}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn accurate_and_mixed_keep_random_programs() {
        let (mut ran, mut kept) = (0, 0);
        cases::of_sizes(100, 3000, |bytes| {
            kept += u32::from(run(bytes)?);
            ran += 1;
            Ok(())
        });
        assert!(ran > 10, "only {ran} programs were long enough to test");
        assert!(kept > ran / 20, "only {kept} of {ran} went through");
    }
}
