//! Units that compute sines and cosines before the run, in integers.
//!
//! A host's library rounds a sine once; a unit of shifts, tables or short
//! polynomials (`trigonometry{on=host …}`) errs by more, which counts against
//! the tolerances like every other error. Its resources are no part of the
//! machine: of each method the first sufficient one is chosen, those of few
//! bits before others and the cheapest of equal bits first.

use super::format::{FormatQuestion, MeasuredFormat, meets};
use super::{FitError, FitProgram, SineTreatment};
use crate::program::transformed_by;
use robovec_ir::Format;
use robovec_num::trigonometry::host::{Implementation, TrigonometricUnit};
use std::sync::Arc;

/// Guard bits of a unit: bits after the point beyond its results' significand.
const GUARDS: [u32; 3] = [1, 4, 8];

/// Orders of polynomials.
const ORDERS: [u32; 7] = [1, 3, 5, 7, 9, 11, 13];
/// Degrees of the polynomials after a table.
const DEGREES: [u32; 4] = [1, 2, 3, 5];
/// Numbers of entries of a table.
const ENTRIES: [u32; 4] = [16, 64, 256, 1024];

/// The first unit of every method with which a program in a format uses up a
/// part of the tolerances at most, the fastest first, with the errors.
pub(super) fn units(
    question: &FormatQuestion<'_>,
    format: Format,
    part: f64,
) -> Result<Vec<(FitProgram, MeasuredFormat)>, FitError> {
    let mut bits = GUARDS
        .map(|guard| (format.significand() + guard).clamp(8, 50))
        .to_vec();
    bits.dedup();
    let mut found = Vec::new();
    for method in methods() {
        for implementation in bits.iter().flat_map(|&bits| method(bits)) {
            if let Some(made) = unit(question, implementation, (format, part))? {
                let unit = TrigonometricUnit::new(implementation);
                let cost = unit.expect("a measured unit can be built").cost();
                found.push(((cost.latency, cost.table_bits), made));
                break;
            }
        }
    }
    found.sort_by_key(|(cost, _)| *cost);
    Ok(found.into_iter().map(|(_, made)| made).collect())
}

/// For every method its implementations of some bits, the cheapest first.
fn methods() -> [fn(u32) -> Vec<Implementation>; 3] {
    let polynomial: fn(u32) -> Vec<Implementation> = |bits| {
        let orders = ORDERS.into_iter();
        orders
            .map(|order| Implementation::Polynomial { order, bits })
            .collect()
    };
    let table: fn(u32) -> Vec<Implementation> = |bits| {
        let sizes = DEGREES
            .into_iter()
            .flat_map(|degree| ENTRIES.map(|entries| (degree, entries)));
        sizes
            .map(|(degree, entries)| Implementation::Table {
                entries,
                degree,
                bits,
            })
            .collect()
    };
    let cordic: fn(u32) -> Vec<Implementation> = |bits| {
        let counts = bits.saturating_sub(8).max(4)..=bits;
        counts
            .map(|iterations| Implementation::Cordic { iterations, bits })
            .collect()
    };
    [polynomial, table, cordic]
}

/// A program with sines by a unit, measured; `None` if its errors are large.
fn unit(
    question: &FormatQuestion<'_>,
    implementation: Implementation,
    (format, part): (Format, f64),
) -> Result<Option<(FitProgram, MeasuredFormat)>, FitError> {
    let (task, base) = (question.task, question.program);
    let pass = pass(implementation);
    let module = transformed_by(&base.module, &pass, task.machine, Some(task.scene))?;
    let mut program = FitProgram {
        pipeline: format!("{},{pass}", base.pipeline),
        treatment: SineTreatment::Unit(implementation),
        module: Arc::new(module),
        excluded: None,
        ..base.clone()
    };
    let asked = |program| FormatQuestion {
        program,
        ..*question
    };
    // Most fail at the few states of the search.
    if !meets(&asked(&program).searched(format)?, part) {
        return Ok(None);
    }
    let measured = asked(&program).validated(format)?;
    program.model_share = asked(&program).searched(Format::BINARY64)?.used();
    Ok(meets(&measured, part).then_some((program, (format, measured))))
}

/// The pass that inserts the unit.
fn pass(implementation: Implementation) -> String {
    let options = match implementation {
        Implementation::Polynomial { order, bits } => {
            format!("method=polynomial order={order} bits={bits}")
        }
        Implementation::Table {
            entries,
            degree,
            bits,
        } => {
            format!("method=table entries={entries} degree={degree} bits={bits}")
        }
        Implementation::Cordic { iterations, bits } => {
            format!("method=cordic iterations={iterations} bits={bits}")
        }
    };
    format!("trigonometry{{on=host {options}}}")
}
