//! Random programs in more accurate forms and in mixed formats.

use crate::generate::{Kind, module};
use crate::running::run as run_checked;
use arbitrary::{Result, Unstructured};

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
    let mut execute = |text: &str| run_checked(&mut module, text, machine, 1, None).complete;
    let kept = execute(&format!("atomise,{accurate}"));
    let mixed = format!("mixed{{error={error} narrow=bf16 between=2 states=8}}");
    Ok(execute(&mixed) && kept)
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
