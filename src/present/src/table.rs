//! Tables of results: one structure, written as CSV, JSON and HTML.

use super::csv;
use super::number::round;
use super::text::BETWEEN;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::fmt::Debug;

/// A table.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct DataTable {
    /// Name of its files: `table-3.1`.
    pub name: String,
    /// Number and subject: `Table 3.1: …`.
    pub title: String,
    /// Explanation of the table.
    pub caption: String,
    /// Heads of the columns, with units.
    pub columns: Vec<String>,
    /// Rows, each as long as `columns`.
    pub rows: Vec<Vec<DataCell>>,
}

/// A cell.
#[derive(Clone, PartialEq, Debug)]
pub enum DataCell {
    /// An empty cell.
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

impl Serialize for DataCell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            DataCell::Empty => serializer.serialize_none(),
            DataCell::Count(count) => serializer.serialize_u64(*count),
            DataCell::Number(number, _) => serializer.serialize_f64(*number),
            DataCell::Text(text) => serializer.serialize_str(text),
            DataCell::Doubtful { doubtful } => {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry("doubtful", doubtful)?;
                map.end()
            }
        }
    }
}

impl DataCell {
    /// A text cell.
    pub fn text(text: impl Into<String>) -> DataCell {
        DataCell::Text(text.into())
    }

    /// A count of items in memory, which fits into 64 bits.
    pub fn count<C: TryInto<u64, Error: Debug>>(count: C) -> DataCell {
        DataCell::Count(count.try_into().expect("counts are not negative"))
    }

    /// A number with decimals, empty when it is not finite.
    pub fn number(number: f64, decimals: u8) -> DataCell {
        if number.is_finite() {
            DataCell::Number(round(number, decimals), decimals)
        } else {
            DataCell::Empty
        }
    }

    /// The cell as plain text, for CSV.
    pub fn plain(&self) -> String {
        match self {
            DataCell::Empty => String::new(),
            DataCell::Count(count) => count.to_string(),
            DataCell::Number(number, decimals) => format!("{number:.*}", usize::from(*decimals)),
            DataCell::Text(text) => text.clone(),
            DataCell::Doubtful { doubtful } => format!("{doubtful}?"),
        }
    }
}

impl DataTable {
    /// A table; `columns` has the heads of all columns, ` | ` between them.
    pub fn new(
        name: impl Into<String>,
        title: impl Into<String>,
        caption: impl Into<String>,
        columns: &str,
        rows: impl IntoIterator<Item = Vec<DataCell>>,
    ) -> DataTable {
        let columns: Vec<String> = columns.split(BETWEEN).map(str::to_owned).collect();
        let rows: Vec<Vec<DataCell>> = rows.into_iter().collect();
        debug_assert!(
            rows.iter().all(|row| row.len() == columns.len()),
            "every row is as long as the head"
        );
        DataTable {
            name: name.into(),
            title: title.into(),
            caption: caption.into(),
            columns,
            rows,
        }
    }

    /// The table as comma-separated values (RFC 4180, with line feeds).
    pub fn to_csv(&self) -> String {
        let mut text = String::new();
        csv::push_line(&mut text, self.columns.iter().map(String::as_str));
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(DataCell::plain).collect();
            csv::push_line(&mut text, cells.iter().map(String::as_str));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_with_commas_and_quotes_are_quoted() {
        let table = DataTable::new(
            "table-0",
            "Table 0: nothing",
            "",
            "system, name | Y | path",
            [vec![
                DataCell::text("a \"bogie\""),
                DataCell::number(7.4219, 2),
                DataCell::Doubtful { doubtful: 12488.0 },
            ]],
        );
        let json = serde_json::to_value(&table.rows).expect("plain data");
        let expected = serde_json::json!([["a \"bogie\"", 7.42, { "doubtful": 12488.0 }]]);
        assert_eq!(json, expected);
        assert_eq!(
            table.to_csv(),
            "\"system, name\",Y,path\n\"a \"\"bogie\"\"\",7.42,12488?\n"
        );
    }
}
