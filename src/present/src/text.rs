//! Aligned tables of text.

use comfy_table::{Cell, CellAlignment, LineStyle, Table, TableStyle};

/// Separator of the heads of two columns.
pub(super) const BETWEEN: &str = " | ";

/// A table with a line under its head. `head` has the heads of all columns,
/// ` | ` between them; a `>` before a head aligns its column to the right. A
/// table whose heads are all empty has no head.
pub fn text_table(head: &str, rows: &[Vec<String>]) -> String {
    let heads = head.split(BETWEEN);
    let heads: Vec<(&str, bool)> = heads
        .map(|head| (head.trim_start_matches('>'), head.starts_with('>')))
        .collect();
    aligned(&heads, rows)
}

/// The same of heads that carry whether their columns are aligned to the right.
pub(super) fn aligned(heads: &[(&str, bool)], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table.load_style(TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─')));
    let cell = |(column, content): (usize, &str)| {
        let is_right = heads.get(column).is_some_and(|(_, is_right)| *is_right);
        Cell::new(content).set_alignment(if is_right {
            CellAlignment::Right
        } else {
            CellAlignment::Left
        })
    };
    let names = heads.iter().map(|(head, _)| *head);
    if names.clone().any(|name| !name.is_empty()) {
        table.set_header(names.enumerate().map(cell).collect::<Vec<Cell>>());
    }
    for row in rows {
        let cells = row.iter().map(String::as_str).enumerate();
        table.add_row(cells.map(cell).collect::<Vec<Cell>>());
    }
    // The first column starts at the section's indentation.
    if let Some(first) = table.column_mut(0) {
        first.set_padding((0, 1));
    }
    table.to_string()
}

/// As [`text_table`], without blanks at line ends, with a final line end.
pub fn text_lines(head: &str, rows: &[Vec<String>]) -> String {
    indented("", &text_table(head, rows))
}

/// Columns of a terminal.
pub const WIDTH: usize = 80;

/// Texts after their labels, folded at 80 columns.
pub fn labelled(lines: &[(&str, String)]) -> String {
    let widths = lines.iter().map(|(label, _)| label.chars().count());
    let column = widths.max().unwrap_or(0) + 2;
    let blank = " ".repeat(column);
    let mut text = String::new();
    for (label, content) in lines {
        let first = format!("{label:<column$}");
        let options = textwrap::Options::new(WIDTH)
            .initial_indent(&first)
            .subsequent_indent(&blank)
            .word_splitter(textwrap::WordSplitter::NoHyphenation);
        text += &textwrap::fill(content, options);
        text.push('\n');
    }
    text
}

/// A headline after its subject, or below it where a line is too short.
pub fn headed(subject: &str, headline: &str) -> String {
    let one = format!("{subject}  {headline}\n");
    if one.chars().count() <= WIDTH {
        one
    } else {
        format!("{}\n  {headline}\n", cut(subject, WIDTH))
    }
}

/// A text of at most this number of characters, with `…` where it is cut.
pub fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let start: String = text.chars().take(most - 1).collect();
    format!("{start}…")
}

/// At most `most` items of a list, with the first and the last.
pub fn thinned<T: Copy>(all: &[T], most: usize) -> Vec<T> {
    let room = all.len().min(most);
    let last = all.len().saturating_sub(1);
    let steps = room.saturating_sub(1).max(1);
    (0..room).map(|place| all[place * last / steps]).collect()
}

/// Texts in their order, each once.
pub fn distinct<'t>(texts: impl Iterator<Item = &'t str>) -> String {
    let mut known: Vec<&str> = Vec::new();
    for text in texts {
        if !known.contains(&text) {
            known.push(text);
        }
    }
    known.join(", ")
}

/// The lines of a text, indented, without blanks at their ends.
pub fn indented(indentation: &str, text: &str) -> String {
    let lines = text.lines();
    lines
        .map(|line| format!("{indentation}{}\n", line.trim_end()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labelled_lines_fit_a_terminal() {
        let long = "word ".repeat(40);
        let text = labelled(&[("x", "1.5 times".to_owned()), ("proved", long)]);
        assert!(text.starts_with("x       1.5 times\nproved  word "));
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH));
        assert_eq!(text.lines().count(), 4);
    }
}
