//! Tables of results: one structure, written as CSV, JSON and HTML.

use serde::Serialize;

/// A table.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Table {
    /// Name of its files: `table-3.1`.
    pub name: String,
    /// Number and subject: `Table 3.1: …`.
    pub title: String,
    /// What it shows and how to read it.
    pub caption: String,
    /// Heads of the columns, with units.
    pub columns: Vec<String>,
    /// Rows, each as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// Nothing to tell.
    Empty,
    /// A whole number.
    Count(u64),
    /// A number, printed with at most this many decimals.
    Number(f64, #[serde(skip)] u8),
    /// Text.
    Text(String),
    /// A figure of the thesis that cannot be right, shown struck through.
    Doubtful {
        /// The figure as printed.
        doubtful: f64,
    },
}

impl Cell {
    /// A text cell.
    pub fn text(text: impl Into<String>) -> Cell {
        Cell::Text(text.into())
    }

    /// A count.
    pub fn count(count: impl TryInto<u64>) -> Cell {
        count.try_into().map_or(Cell::Empty, Cell::Count)
    }

    /// A number with decimals, nothing when it is not finite.
    pub fn number(number: f64, decimals: u8) -> Cell {
        if number.is_finite() {
            Cell::Number(round(number, decimals), decimals)
        } else {
            Cell::Empty
        }
    }

    /// The cell as plain text, as CSV has it.
    pub fn plain(&self) -> String {
        match self {
            Cell::Empty => String::new(),
            Cell::Count(count) => count.to_string(),
            Cell::Number(number, decimals) => format!("{number:.*}", usize::from(*decimals)),
            Cell::Text(text) => text.clone(),
            Cell::Doubtful { doubtful } => format!("{doubtful}?"),
        }
    }
}

/// A number rounded to some decimals, so that the last bits of sums do not
/// show.
pub fn round(number: f64, decimals: u8) -> f64 {
    let scale = 10f64.powi(i32::from(decimals));
    (number * scale).round() / scale
}

impl Table {
    /// The table as comma-separated values (RFC 4180, with line feeds).
    pub fn to_csv(&self) -> String {
        let mut text = String::new();
        line(&mut text, self.columns.iter().map(String::as_str));
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(Cell::plain).collect();
            line(&mut text, cells.iter().map(String::as_str));
        }
        text
    }
}

/// Appends a line of fields, quoted where they need it.
pub(super) fn line<'a>(text: &mut String, fields: impl Iterator<Item = &'a str>) {
    for (index, field) in fields.enumerate() {
        if index > 0 {
            text.push(',');
        }
        if field.contains([',', '"', '\n', '\r']) {
            text.push('"');
            text.push_str(&field.replace('"', "\"\""));
            text.push('"');
        } else {
            text.push_str(field);
        }
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_with_commas_and_quotes_are_quoted() {
        let table = Table {
            name: "table-0".to_owned(),
            title: "Table 0: nothing".to_owned(),
            caption: String::new(),
            columns: vec!["system, name".to_owned(), "Y".to_owned(), "path".to_owned()],
            rows: vec![vec![
                Cell::text("a \"bogie\""),
                Cell::number(7.4219, 2),
                Cell::Doubtful { doubtful: 12488.0 },
            ]],
        };
        assert_eq!(
            table.to_csv(),
            "\"system, name\",Y,path\n\"a \"\"bogie\"\"\",7.42,12488?\n"
        );
    }
}
