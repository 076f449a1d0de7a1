//! The rounding errors of every output, array by array.

use super::ReportOptions;
use super::records::SummaryReport;
use robovec_analysis::accuracy::{
    ElementError, FormatAccuracy, MatrixCondition, Measurement, StateSpread, measure,
};
use robovec_analysis::reference::ReferenceEffort;
use robovec_ir::View;
use robovec_ir::print::print_output;
use robovec_num::format::Format;
use serde::Serialize;

/// Rounding errors over seeded random states.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ErrorReport {
    /// Reference of the outputs: `double-double`, `certified` or `audit`.
    pub reference: String,
    /// Share of outputs, in all states, proved to the last bit of binary64.
    pub certain: f64,
    /// Number of states.
    pub states: u32,
    /// Seed of the states.
    pub seed: u64,
    /// The output arrays that are symmetric matrices.
    pub matrices: Vec<MatrixReport>,
    /// In IEEE binary32.
    pub binary32: FormatReport,
    /// In IEEE binary64.
    pub binary64: FormatReport,
}

/// Effect of solving with an output matrix on errors.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct MatrixReport {
    /// The array's name.
    pub name: String,
    /// Its condition number in the 2-norm.
    pub condition: StateSpread,
}

/// Rounding errors in one number format.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct FormatReport {
    /// The whole function.
    #[serde(flatten)]
    pub summary: SummaryReport,
    /// All outputs in all states as one population, relative to the element.
    pub relative: StateSpread,
    /// The same, relative to the element and its sensitivity.
    pub mixed: StateSpread,
    /// The share of computed outputs below the normal numbers of the format.
    pub subnormal: f64,
    /// The share of results that are not finite although the exact value is.
    pub overflowed: f64,
    /// One entry per output array.
    pub arrays: Vec<ArrayReport>,
}

/// Rounding errors of an output array.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ArrayReport {
    /// The array's name.
    pub name: String,
    /// Largest error over largest element.
    pub normwise: StateSpread,
    /// Largest relative error of an element.
    pub componentwise: StateSpread,
    /// Largest mixed error of an element.
    pub mixed: StateSpread,
    /// Its elements, in order.
    pub elements: Vec<ElementReport>,
}

/// Rounding errors of an output element.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ElementReport {
    /// The element (`M[1,2]`).
    pub name: String,
    /// In the element's own unit.
    pub absolute: StateSpread,
    /// Relative to the exact value.
    pub relative: StateSpread,
    /// In units in the last place of the exact value.
    pub ulps: StateSpread,
    /// Number of wrong bits.
    pub bits: StateSpread,
    /// Error relative to the exact value and its sensitivity.
    pub mixed: StateSpread,
    /// The state with the largest relative error, counted from 0.
    pub worst_state: u32,
    /// Number of states in which the element is zero except for rounding and
    /// was not computed as zero; these have no relative error.
    pub vanishing: u32,
    /// Number of states in which it is computed below the normal numbers.
    pub subnormal: u32,
    /// Number of states in which it is not finite but the exact value is.
    pub overflowed: u32,
    /// The estimated condition number for independent errors of the inputs.
    pub sensitivity: f64,
    /// The componentwise condition number in the worst state.
    pub condition: Option<f64>,
    /// The worst relative error over condition number and unit roundoff.
    pub backward: Option<f64>,
    /// `accurate`, `hard problem` or `unstable code`.
    pub judgement: Option<&'static str>,
}

impl ErrorReport {
    pub(super) fn new(view: View<'_>, options: &ReportOptions) -> ErrorReport {
        let formats = [Format::BINARY32, Format::BINARY64];
        let measurement = measurement(view.function.nodes().len());
        let accuracy = measure(view, &options.states, options.count, &formats, measurement);
        let [binary32, binary64] =
            [0, 1].map(|index| FormatReport::new(view, &accuracy.formats[index]));
        let certainty = accuracy.certainty;
        let proved = certainty.double_double + certainty.precise + certainty.zero;
        let matrix = |matrix: &MatrixCondition| MatrixReport {
            name: array_name(view, matrix.array),
            condition: matrix.condition,
        };
        ErrorReport {
            reference: accuracy.effort.to_string(),
            certain: proved as f64 / (proved + certainty.uncertain).max(1) as f64,
            states: accuracy.states,
            seed: accuracy.seed,
            matrices: accuracy.matrices.iter().map(matrix).collect(),
            binary32,
            binary64,
        }
    }
}

/// Steps of reverse sweeps for condition numbers: some tenths of a second.
const CONDITION_WORK: u64 = 200_000_000;

fn measurement(operations: usize) -> Measurement {
    Measurement {
        effort: ReferenceEffort::of_size(operations),
        sensitivities: true,
        condition_work: CONDITION_WORK,
    }
}

fn array_name(view: View<'_>, array: usize) -> String {
    let name = view.function.outputs()[array].name;
    view.tables.symbols.text(name).to_owned()
}

impl FormatReport {
    fn new(view: View<'_>, accuracy: &FormatAccuracy) -> FormatReport {
        let outputs = view.function.outputs();
        let element = |element: &ElementError| ElementReport {
            name: print_output(view, element.output),
            absolute: element.absolute,
            relative: element.relative,
            ulps: element.ulps,
            bits: element.ulps.bits(),
            mixed: element.mixed,
            worst_state: element.worst_state,
            vanishing: element.vanishing,
            subnormal: element.subnormal,
            overflowed: element.overflowed,
            sensitivity: element.sensitivity,
            condition: element.conditioned.map(|found| found.condition),
            backward: element.conditioned.map(|found| found.backward),
            judgement: element.conditioned.map(|found| found.judgement.name()),
        };
        debug_assert!(
            accuracy.elements.is_sorted_by_key(|element| element.output),
            "elements are in the order of the outputs"
        );
        let mut arrays: Vec<ArrayReport> = Vec::new();
        for array in &accuracy.arrays {
            let description = &outputs[array.array];
            let range = description.offset..description.offset + description.shape.len() as u32;
            let first = accuracy
                .elements
                .partition_point(|element| element.output.0 < range.start);
            let past = accuracy
                .elements
                .partition_point(|element| element.output.0 < range.end);
            arrays.push(ArrayReport {
                name: array_name(view, array.array),
                normwise: array.normwise,
                componentwise: array.componentwise,
                mixed: array.mixed,
                elements: accuracy.elements[first..past].iter().map(element).collect(),
            });
        }
        FormatReport {
            summary: SummaryReport::new(&accuracy.summary(), view),
            relative: accuracy.relative,
            mixed: accuracy.mixed,
            subnormal: accuracy.subnormal,
            overflowed: accuracy.overflowed,
            arrays,
        }
    }
}
