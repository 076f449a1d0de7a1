//! Aligned tables of text.

use comfy_table::{Cell, CellAlignment, LineStyle, Table, TableStyle};

/// A table with a line under its head (none without a head); the columns in
/// `right` are aligned to the right.
pub(crate) fn text_table(head: &[&str], rows: &[Vec<String>], right: &[usize]) -> String {
    let mut table = Table::new();
    table.load_style(TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─')));
    let cell = |column: usize, content: &str| {
        let alignment = if right.contains(&column) {
            CellAlignment::Right
        } else {
            CellAlignment::Left
        };
        Cell::new(content).set_alignment(alignment)
    };
    if !head.is_empty() {
        let cells = head.iter().enumerate().map(|(i, content)| cell(i, content));
        table.set_header(cells.collect::<Vec<Cell>>());
    }
    for row in rows {
        let cells = row.iter().enumerate().map(|(i, content)| cell(i, content));
        table.add_row(cells.collect::<Vec<Cell>>());
    }
    // The first column starts at the section's indentation.
    if let Some(first) = table.column_mut(0) {
        first.set_padding((0, 1));
    }
    table.to_string()
}

/// As [`text_table`], without blanks at the ends of its lines, and with a line
/// end behind the last.
pub(crate) fn text_lines(head: &[&str], rows: &[Vec<String>], right: &[usize]) -> String {
    indented("", &text_table(head, rows, right))
}

/// The lines of a text behind an indentation, without blanks at their ends.
pub(crate) fn indented(indentation: &str, text: &str) -> String {
    let lines = text.lines();
    lines
        .map(|line| format!("{indentation}{}\n", line.trim_end()))
        .collect()
}
