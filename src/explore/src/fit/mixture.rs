//! A format for every value, by the pass `mixed`.
//!
//! The formats lie around the narrowest in which the program as a whole meets
//! the tolerances: most values need less, a few need more. Elements compute in
//! one format, so the result is for other hardware, at the cost of its cells.

use super::format::{FormatQuestion, MeasuredFormat, WIDEST, meets};
use super::{FitError, FitProgram};
use crate::program::transformed_by;
use robovec_framework::scene::Scene;
use robovec_ir::Format;
use robovec_num::NumberFormat;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Number of bits by which formats may be narrower than the uniform one.
const NARROWER: u32 = 7;

/// The parts of the tolerances that the pass may use at its own states, and the
/// number of bits by which formats may be wider than the uniform one: tried in
/// sequence, until the result holds at the states of the validation.
const PARTS: [(f64, u32); 5] = [(0.7, 3), (0.5, 4), (0.35, 5), (0.2, 7), (0.1, 9)];

/// Formats of the single values of a program.
#[derive(Clone, PartialEq, Debug)]
pub struct ValueMixture {
    /// Index of the program with these values.
    pub base: usize,
    /// The format in which that program as a whole meets the tolerances.
    pub around: Format,
    /// Number of values in each format.
    pub text: String,
    /// The next part of the tolerances to try when this one fails.
    next: usize,
}

/// A program with formats for its values, measured, from one that meets the
/// tolerances in a single format or from a failed mixture, if there is one.
pub(super) fn mixture(
    question: &FormatQuestion<'_>,
    (base, around): (usize, Format),
    failed: Option<&ValueMixture>,
) -> Result<Option<(FitProgram, MeasuredFormat)>, FitError> {
    let Format::Float(float) = around else {
        return Ok(None);
    };
    let in_bits = |mantissa| {
        Format::Float(NumberFormat {
            mantissa,
            subnormals: true,
            ..float
        })
    };
    let narrowest = float.mantissa.saturating_sub(NARROWER).max(2);
    let first = failed.map_or(0, |failed| failed.next);
    let made = question.program;
    for (next, &(part, wider)) in (first + 1..).zip(PARTS.iter().skip(first)) {
        let widest = (float.mantissa + wider).min(WIDEST);
        let pass = format!(
            "mixed{{wide=\"{}\" narrow=\"{}\" between={}}}",
            in_bits(widest),
            in_bits(narrowest),
            (widest - narrowest).saturating_sub(1)
        );
        let scene = stricter(question.task.scene, part);
        let machine = question.task.machine;
        // The pass gives up where even the widest format does not do.
        let Ok(module) = transformed_by(&made.module, &pass, machine, Some(&scene)) else {
            continue;
        };
        let program = FitProgram {
            name: format!("{}, mixed", made.name),
            pipeline: format!("{},{pass}", made.pipeline),
            mixture: Some(ValueMixture {
                base,
                around,
                text: tally(&module.functions[0]),
                next,
            }),
            module: Arc::new(module),
            ..made.clone()
        };
        let asked = FormatQuestion {
            program: &program,
            ..*question
        };
        let measured = asked.validated(in_bits(widest))?;
        if meets(&measured, question.task.sampled()) {
            return Ok(Some((program, (in_bits(widest), measured))));
        }
    }
    Ok(None)
}

fn stricter(scene: &Scene, part: f64) -> Scene {
    let mut scene = scene.clone();
    for tolerance in scene
        .outputs
        .iter_mut()
        .filter_map(|need| need.tolerance.as_mut())
    {
        tolerance.bound *= part;
    }
    scene
}

/// Number of values with each significand, the shortest first.
fn tally(function: &robovec_ir::Function) -> String {
    let mut counts: BTreeMap<u32, u32> = BTreeMap::new();
    for format in function
        .formats
        .iter()
        .flat_map(|formats| formats.iter())
        .flatten()
    {
        *counts.entry(format.significand()).or_default() += 1;
    }
    let parts = counts
        .iter()
        .map(|(bits, count)| format!("{count} in {bits}"));
    let parts: Vec<String> = parts.collect();
    format!("values in bits of significand: {}", parts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_framework::scene::{ElementPattern, Measure, NeededOutputs, OutputTolerance};

    #[test]
    fn a_stricter_scene_allows_a_part_of_every_error() {
        let need = |tolerance| NeededOutputs {
            pattern: ElementPattern::whole("y"),
            tolerance,
        };
        let tolerance = OutputTolerance {
            measure: Measure::Norm,
            bound: 1e-3,
            scale: None,
        };
        let scene = Scene {
            outputs: vec![need(Some(tolerance)), need(None)],
            ..Scene::default()
        };
        let outputs = stricter(&scene, 0.5).outputs;
        assert_eq!(outputs[0].tolerance.map(|one| one.bound), Some(5e-4));
        assert_eq!(outputs[1].tolerance, None);
    }
}
