//! Tables of results: one structure, written as CSV, JSON and HTML.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

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
#[derive(Clone, PartialEq, Debug)]
pub enum Cell {
    /// Nothing to tell.
    Empty,
    /// A whole number.
    Count(u64),
    /// A number, printed with at most this many decimals.
    Number(f64, u8),
    /// Text.
    Text(String),
    /// A figure of the thesis that cannot be right, shown struck through; in
    /// JSON `{"doubtful": 12488}`.
    Doubtful {
        /// The figure as printed.
        doubtful: f64,
    },
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Cell::Empty => serializer.serialize_none(),
            Cell::Count(count) => serializer.serialize_u64(*count),
            Cell::Number(number, _) => serializer.serialize_f64(*number),
            Cell::Text(text) => serializer.serialize_str(text),
            Cell::Doubtful { doubtful } => {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry("doubtful", doubtful)?;
                map.end()
            }
        }
    }
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
        let json = serde_json::to_value(&table.rows).expect("plain data");
        let expected = serde_json::json!([["a \"bogie\"", 7.42, { "doubtful": 12488.0 }]]);
        assert_eq!(json, expected);
        assert_eq!(
            table.to_csv(),
            "\"system, name\",Y,path\n\"a \"\"bogie\"\"\",7.42,12488?\n"
        );
    }
}
