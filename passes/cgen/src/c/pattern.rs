//! Description of arrays that count from 0: in words, and as constants of C.

use super::layout::{ElementOrder, OutputLayout};
use std::fmt::Write;

/// Lines of a comment: the order of elements, and what is kept of which output.
pub(super) fn comment(order: ElementOrder, outputs: &[(&str, &OutputLayout)]) -> String {
    let order = match order {
        ElementOrder::Row => "rows",
        ElementOrder::Column | ElementOrder::Packed => "columns",
    };
    let mut text = format!("Arrays count from 0, matrices by {order}.\n");
    for (name, layout) in outputs {
        let [rows, columns] = layout.extents;
        let count = layout.kept.len();
        if layout.is_triangle && u64::from(rows) * (u64::from(rows) + 1) == 2 * count as u64 {
            let _ = writeln!(
                text,
                "   {name}: the upper triangle of a symmetric matrix, {count} elements."
            );
        } else if !layout.is_dense() {
            let of = u64::from(rows) * u64::from(columns);
            let _ = writeln!(
                text,
                "   {name}: {count} of {of} elements; the others are zero."
            );
        }
    }
    text
}

/// Constants of C that give row and column of every element that is kept of a
/// matrix, and where each column (or row) starts, with names `FILE_ARRAY_row`.
pub(super) fn constants(
    file: &str,
    order: ElementOrder,
    outputs: &[(&str, &OutputLayout)],
) -> String {
    let mut text = String::new();
    for (name, layout) in outputs.iter().filter(|(_, layout)| !layout.is_dense()) {
        let [rows, columns] = layout.extents;
        let (lines, line) = match order {
            ElementOrder::Row => (rows, 0),
            ElementOrder::Column | ElementOrder::Packed => (columns, 1),
        };
        let count = layout.kept.len();
        let _ = writeln!(
            text,
            "/* {name}: row and column of each element; elements start[k] to start[k + 1] are of {} k. */",
            if line == 0 { "row" } else { "column" }
        );
        let _ = writeln!(text, "enum {{ {file}_{name}_nonzeros = {count} }};");
        let starts = (0..=lines).map(|k| layout.kept.partition_point(|place| place[line] < k));
        let places = |side: usize| layout.kept.iter().map(move |place| place[side] as usize);
        integers(&mut text, &format!("{file}_{name}_row"), places(0));
        integers(&mut text, &format!("{file}_{name}_column"), places(1));
        integers(&mut text, &format!("{file}_{name}_start"), starts);
        text.push('\n');
    }
    text
}

/// An array of integers; C has none without elements.
fn integers(text: &mut String, name: &str, numbers: impl Iterator<Item = usize>) {
    let mut numbers: Vec<String> = numbers.map(|number| number.to_string()).collect();
    if numbers.is_empty() {
        numbers.push("0".to_owned());
    }
    let _ = write!(text, "static const int {name}[{}] = {{", numbers.len());
    for line in numbers.chunks(16) {
        let _ = write!(text, "\n    {},", line.join(", "));
    }
    text.push_str("\n};\n");
}
