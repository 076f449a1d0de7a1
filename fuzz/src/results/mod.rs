//! Random programs with hostile constants through random pipelines, pass by
//! pass, judged by their own referee ([`crate::referee`]).
//!
//! The output of a pass is compared with its input: over the real numbers for
//! every class that promises equality there (constants within one rounding
//! where a pass computes them, sines within the error of a series), and bit by
//! bit in binary64 and binary32 for passes that promise that. The check of the
//! compiler runs as well: it must refuse exactly the results that the referee
//! refuses.

mod bits;
mod case;
mod finding;
mod follow;
mod pairing;
mod promise;

pub use self::finding::{Finding, Tally};

use self::case::Case;
use self::follow::follow;
use arbitrary::{Result, Unstructured};
use robovec_ir::print;

/// Runs a random pipeline over a random program with hostile constants.
///
/// # Panics
///
/// Panics when a pass changes a value beyond its class.
pub fn results_stay_in_class(data: &[u8]) {
    // Bytes that run out make a smaller case, never a failure.
    if let Ok(Err(finding)) = examine(&mut Unstructured::new(data), &[]) {
        panic!("{finding}");
    }
}

/// As [`results_stay_in_class`], without some passes; returns the faults found.
///
/// # Errors
///
/// Fails when the bytes run out; otherwise returns the finding, if any.
pub fn examine(
    bytes: &mut Unstructured<'_>,
    without: &[String],
) -> Result<std::result::Result<Tally, Box<Finding>>> {
    let Case {
        steps,
        machine,
        seed,
        mut module,
    } = Case::draw(bytes, without)?;
    let mut tally = Tally {
        programs: 1,
        ..Tally::default()
    };
    for step in &steps {
        match follow(&mut module, step, &machine, seed, &mut tally) {
            Ok(true) => {}
            Ok(false) => break,
            Err(finding) => return Ok(Err(finding)),
        }
    }
    Ok(Ok(tally))
}

/// The pipeline and the program of some bytes, as text, for cases that end the
/// process.
///
/// # Errors
///
/// Fails when the bytes run out.
pub fn describe_case(bytes: &mut Unstructured<'_>) -> Result<String> {
    let case = Case::draw(bytes, &[])?;
    let program = print::print_module(&case.module);
    Ok(format!("// RUN: {}\n{program}", case.steps.join(",")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn hostile_constants_do_not_mislead_a_pass() {
        let mut tally = Tally::default();
        cases::of_one_size(60, 6000, |bytes| {
            match examine(bytes, &[])? {
                Ok(one) => tally.add(&one),
                Err(finding) => panic!("{finding}"),
            }
            Ok(())
        });
        assert!(tally.programs > 40 && tally.same > 500, "{tally}");
        assert!(tally.vague + tally.nothing < tally.same, "{tally}");
    }
}
