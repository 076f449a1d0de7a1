//! The rounding errors of every output, array by array.

use super::ReportOptions;
use super::records::SummaryReport;
use robovec_ir::View;
use robovec_ir::format::Format;
use robovec_ir::print::print_output;
use robovec_passes::analysis::accuracy::{ElementError, FormatAccuracy, Spread, accuracy};
use serde::Serialize;

/// Rounding errors over seeded random states.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ErrorReport {
    /// What the outputs are compared with.
    pub reference: &'static str,
    /// How many states.
    pub states: u32,
    /// Where they come from.
    pub seed: u64,
    /// In IEEE binary32.
    pub binary32: FormatReport,
    /// In IEEE binary64.
    pub binary64: FormatReport,
}

/// Rounding errors in one number format.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct FormatReport {
    /// The whole function.
    #[serde(flatten)]
    pub summary: SummaryReport,
    /// One entry per output array.
    pub arrays: Vec<ArrayReport>,
}

/// Rounding errors of an output array.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ArrayReport {
    /// The array's name.
    pub name: String,
    /// Largest error over largest element.
    pub normwise: SpreadReport,
    /// Its elements, in order.
    pub elements: Vec<ElementReport>,
}

/// Rounding errors of an output element.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ElementReport {
    /// The element (`M[1,2]`).
    pub name: String,
    /// Relative to the exact value.
    pub relative: SpreadReport,
    /// In units in the last place of the exact value.
    pub ulps: SpreadReport,
    /// The state with the largest relative error, counted from 0.
    pub worst_state: u32,
    /// In how many states the element is zero but for rounding and was not
    /// computed as zero; these have no relative error.
    pub vanishing: u32,
}

/// Median and worst case over the states.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct SpreadReport {
    /// Half of the states are at or below it.
    pub median: f64,
    /// The largest.
    pub worst: f64,
}

impl From<Spread> for SpreadReport {
    fn from(spread: Spread) -> SpreadReport {
        SpreadReport {
            median: spread.median,
            worst: spread.worst,
        }
    }
}

impl ErrorReport {
    pub(super) fn new(view: View<'_>, options: &ReportOptions) -> ErrorReport {
        let formats = [Format::BINARY32, Format::BINARY64];
        let accuracy = accuracy(view, &options.states, options.count, &formats);
        let [binary32, binary64] =
            [0, 1].map(|index| FormatReport::new(view, &accuracy.formats[index]));
        ErrorReport {
            reference: "double-double",
            states: accuracy.states,
            seed: accuracy.seed,
            binary32,
            binary64,
        }
    }
}

impl FormatReport {
    fn new(view: View<'_>, accuracy: &FormatAccuracy) -> FormatReport {
        let outputs = view.function.outputs();
        let element = |element: &ElementError| ElementReport {
            name: print_output(view, element.output),
            relative: element.relative.into(),
            ulps: element.ulps.into(),
            worst_state: element.worst_state,
            vanishing: element.vanishing,
        };
        let mut arrays: Vec<ArrayReport> = Vec::new();
        for array in &accuracy.arrays {
            let description = &outputs[array.array];
            let range = description.offset..description.offset + description.shape.len() as u32;
            // Assignments stand in order of the output elements.
            let first = accuracy
                .elements
                .partition_point(|element| element.output.0 < range.start);
            let past = accuracy
                .elements
                .partition_point(|element| element.output.0 < range.end);
            arrays.push(ArrayReport {
                name: view.tables.symbols.text(description.name).to_owned(),
                normwise: array.normwise.into(),
                elements: accuracy.elements[first..past].iter().map(element).collect(),
            });
        }
        FormatReport {
            summary: SummaryReport::new(&accuracy.summary(), view),
            arrays,
        }
    }
}
