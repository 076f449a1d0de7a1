//! The errors of every output of a function in number formats, in every form.

use robovec_analysis::accuracy::{Accuracy, ElementError, FormatAccuracy, StateSpread};
use robovec_ir::View;
use robovec_ir::diagnostic::counted;
use robovec_ir::print::print_output;
use robovec_present::csv::push_line;
use robovec_present::number::{or_dash, or_nothing, scientific};
use robovec_present::text_lines;
use serde::Serialize;
use std::fmt::Write;

/// Errors of one output in one format, for programs; `null` if not finite.
#[derive(Clone, PartialEq, Serialize, Debug)]
pub struct OutputLine {
    /// The model or file, and the function.
    pub function: String,
    /// The number format.
    pub format: String,
    /// The output element.
    pub output: String,
    /// The distance from the exact value, in its unit.
    pub absolute: ErrorQuantiles,
    /// Relative to the exact value.
    pub relative: ErrorQuantiles,
    /// In units in the last place of the exact value.
    pub ulps: ErrorQuantiles,
    /// Number of wrong bits.
    pub bits: ErrorQuantiles,
    /// Error relative to the exact value and its sensitivity.
    pub mixed: ErrorQuantiles,
    /// The estimated condition number for independent errors of the inputs.
    pub sensitivity: f64,
    /// Componentwise condition number at the largest relative error.
    pub condition: Option<f64>,
    /// That error over condition number and unit roundoff.
    pub backward: Option<f64>,
    /// `accurate`, `hard problem` or `unstable code`.
    pub judgement: Option<&'static str>,
    /// Number of states in which it is zero except for rounding.
    pub vanishing: u32,
    /// Number of states in which it is computed below the normal numbers.
    pub subnormal: u32,
    /// Number of states in which it is not finite but the exact value is.
    pub overflowed: u32,
}

/// Places in a distribution over the states.
#[derive(Clone, Copy, PartialEq, Serialize, Debug)]
pub struct ErrorQuantiles {
    /// Half of the states are at or below it.
    pub median: f64,
    /// 99 of 100 states are at or below it.
    pub percentile_99: f64,
    /// The largest.
    pub worst: f64,
    /// The state it was found in, counted from 0.
    pub state: u32,
}

impl From<StateSpread> for ErrorQuantiles {
    fn from(spread: StateSpread) -> ErrorQuantiles {
        ErrorQuantiles {
            median: spread.median,
            percentile_99: spread.percentile_99,
            worst: spread.worst,
            state: spread.worst_state,
        }
    }
}

/// One line for every output and format.
pub fn lines(name: &str, view: View<'_>, accuracy: &Accuracy) -> Vec<OutputLine> {
    let line = |format: &FormatAccuracy, element: &ElementError| OutputLine {
        function: name.to_owned(),
        format: format.format.to_string(),
        output: print_output(view, element.output),
        absolute: element.absolute.into(),
        relative: element.relative.into(),
        ulps: element.ulps.into(),
        bits: element.ulps.bits().into(),
        mixed: element.mixed.into(),
        sensitivity: element.sensitivity,
        condition: element.conditioned.map(|found| found.condition),
        backward: element.conditioned.map(|found| found.backward),
        judgement: element.conditioned.map(|found| found.judgement.name()),
        vanishing: element.vanishing,
        subnormal: element.subnormal,
        overflowed: element.overflowed,
    };
    let formats = accuracy.formats.iter();
    formats
        .flat_map(|format| {
            format
                .elements
                .iter()
                .map(move |element| line(format, element))
        })
        .collect()
}

/// The lines as a table with a head, numbers in full.
pub fn csv(lines: &[OutputLine]) -> String {
    let mut head = ["function", "format", "output"].map(str::to_owned).to_vec();
    for measure in ["absolute", "relative", "ulps", "bits", "mixed"] {
        let places = ["median", "99 %", "worst", "state"];
        head.extend(places.map(|place| format!("{measure} {place}")));
    }
    let rest = "sensitivity,condition,backward,judgement,vanishing,subnormal,overflowed";
    head.extend(rest.split(',').map(str::to_owned));
    let mut text = String::new();
    push_line(&mut text, head.iter().map(String::as_str));
    for line in lines {
        push_line(&mut text, fields(line).iter().map(String::as_str));
    }
    text
}

fn fields(line: &OutputLine) -> Vec<String> {
    let number = |number: f64| {
        if number.is_nan() {
            String::new()
        } else {
            format!("{number:e}")
        }
    };
    let optional = |value: Option<f64>| or_nothing(value, number);
    let mut fields = vec![
        line.function.clone(),
        line.format.clone(),
        line.output.clone(),
    ];
    for places in [
        line.absolute,
        line.relative,
        line.ulps,
        line.bits,
        line.mixed,
    ] {
        fields.extend([places.median, places.percentile_99, places.worst].map(number));
        fields.push(places.state.to_string());
    }
    fields.extend([
        number(line.sensitivity),
        optional(line.condition),
        optional(line.backward),
        or_nothing(line.judgement, str::to_owned),
        line.vanishing.to_string(),
        line.subnormal.to_string(),
        line.overflowed.to_string(),
    ]);
    fields
}

/// The errors for a user: each format as a whole, its arrays, and at most this
/// number of outputs, those with the largest mixed errors, in their order.
pub fn text(name: &str, view: View<'_>, accuracy: &Accuracy, most: usize) -> String {
    let certainty = accuracy.certainty;
    let proved = certainty.double_double + certainty.precise + certainty.zero;
    let mut text = format!(
        "{name}: errors over {}, seed {}; reference {}, {} of {} \
         proved ({} in arbitrary precision, {} zero by identity)\n",
        counted(accuracy.states, "random state"),
        accuracy.seed,
        accuracy.effort,
        proved,
        counted(proved + certainty.uncertain, "value"),
        certainty.precise,
        certainty.zero,
    );
    for matrix in &accuracy.matrices {
        let _ = writeln!(
            text,
            "condition of {} in the 2-norm: median {}, worst {} (state {})",
            array_name(view, matrix.array),
            scientific(matrix.condition.median),
            scientific(matrix.condition.worst),
            matrix.condition.worst_state,
        );
    }
    text.push('\n');
    for format in &accuracy.formats {
        let _ = writeln!(
            text,
            "{}: {:.1} % of the computed outputs subnormal, {:.1} % overflowed",
            format.format,
            100.0 * format.subnormal,
            100.0 * format.overflowed,
        );
        text += &arrays(view, format);
        text.push('\n');
        text += &elements(view, format, most);
        text.push('\n');
    }
    text
}

fn arrays(view: View<'_>, format: &FormatAccuracy) -> String {
    let spread = |spread: &StateSpread| {
        [spread.median, spread.percentile_99, spread.worst]
            .map(scientific)
            .into_iter()
            .chain([spread.worst_state.to_string()])
    };
    let mut rows: Vec<Vec<String>> = Vec::new();
    for array in &format.arrays {
        let mut row = vec![array_name(view, array.array)];
        for measure in [&array.normwise, &array.componentwise, &array.mixed] {
            row.extend(spread(measure));
        }
        rows.push(row);
    }
    let mut row = vec!["(all outputs)".to_owned()];
    row.extend([const { String::new() }; 4]);
    row.extend(spread(&format.relative));
    row.extend(spread(&format.mixed));
    rows.push(row);
    let head = "array | >normwise: median | >99 % | >worst | >state | >relative: median | >99 % | \
         >worst | >state | >mixed: median | >99 % | >worst | >state";
    text_lines(head, &rows)
}

fn elements(view: View<'_>, format: &FormatAccuracy, most: usize) -> String {
    let mut shown: Vec<&ElementError> = format.elements.iter().collect();
    let size = |element: &ElementError| {
        if element.mixed.worst.is_nan() {
            -1.0
        } else {
            element.mixed.worst
        }
    };
    shown.sort_by(|a, b| size(b).total_cmp(&size(a)));
    shown.truncate(most);
    shown.sort_by_key(|element| element.output);
    let rows: Vec<Vec<String>> = shown
        .iter()
        .map(|element| {
            let optional = |value: Option<f64>| or_dash(value, scientific);
            let conditioned = element.conditioned;
            vec![
                print_output(view, element.output),
                scientific(element.absolute.worst),
                scientific(element.relative.median),
                scientific(element.relative.percentile_99),
                scientific(element.relative.worst),
                element.relative.worst_state.to_string(),
                scientific(element.ulps.worst),
                bits(element.ulps.bits().worst),
                scientific(element.mixed.worst),
                optional(conditioned.map(|found| found.condition)),
                optional(conditioned.map(|found| found.backward)),
                or_dash(conditioned, |found| found.judgement.name().to_owned()),
            ]
        })
        .collect();
    let head = "output | >absolute: worst | >relative: median | >99 % | >worst | >state | >ulps | >bits | >mixed | \
         >condition | >backward | judgement";
    text_lines(head, &rows)
}

fn bits(number: f64) -> String {
    or_dash((!number.is_nan()).then_some(number), |bits| {
        format!("{bits:.1}")
    })
}

fn array_name(view: View<'_>, array: usize) -> String {
    let name = view.function.outputs()[array].name;
    view.tables.symbols.text(name).to_owned()
}
