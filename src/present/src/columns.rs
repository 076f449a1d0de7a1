//! ColumnList: one declaration of head, cell and digits for all outputs.

use super::number::exponential;
use super::table::{DataCell, DataTable};
use super::text::{aligned, indented};

/// The digits of a column's numbers; texts and counts are printed exactly.
#[derive(Clone, Copy)]
pub enum Digits {
    /// The column is left out.
    Hidden,
    /// All that are needed to read the number back.
    All,
    /// At most this many decimals.
    Decimals(u8),
    /// A number of decimals and an exponent.
    Exponent(u8),
    /// Text from a function.
    Words(fn(f64) -> String),
}

/// The content of a cell before its digits are chosen.
#[derive(Clone, PartialEq, Debug)]
pub enum CellValue {
    /// Nothing: `-` among numbers on the terminal, else empty.
    Nothing,
    /// A whole number.
    Count(u64),
    /// A number; empty, with decimals, where it is not finite.
    Number(f64),
    /// Text.
    Text(String),
    /// A figure that cannot be right ([`DataCell::Doubtful`]).
    Doubtful(f64),
}

impl CellValue {
    fn is_number(&self) -> bool {
        matches!(self, CellValue::Count(_) | CellValue::Number(_))
    }
}

impl From<&str> for CellValue {
    fn from(text: &str) -> CellValue {
        CellValue::Text(text.to_owned())
    }
}

impl From<&String> for CellValue {
    fn from(text: &String) -> CellValue {
        CellValue::Text(text.clone())
    }
}

impl From<String> for CellValue {
    fn from(text: String) -> CellValue {
        CellValue::Text(text)
    }
}

impl From<f64> for CellValue {
    fn from(number: f64) -> CellValue {
        CellValue::Number(number)
    }
}

impl From<u32> for CellValue {
    fn from(count: u32) -> CellValue {
        CellValue::Count(count.into())
    }
}

impl From<u64> for CellValue {
    fn from(count: u64) -> CellValue {
        CellValue::Count(count)
    }
}

impl From<usize> for CellValue {
    fn from(count: usize) -> CellValue {
        CellValue::Count(count as u64)
    }
}

impl<C: Into<CellValue>> From<Option<C>> for CellValue {
    fn from(content: Option<C>) -> CellValue {
        content.map_or(CellValue::Nothing, Into::into)
    }
}

/// A column of tables whose rows are values of the type `R`.
struct Column<'a, R> {
    head: String,
    shown: Digits,
    stored: Digits,
    cell: Box<dyn Fn(&R) -> CellValue + 'a>,
}

/// The columns of tables whose rows are values of the type `R`.
pub struct ColumnList<'a, R>(Vec<Column<'a, R>>);

impl<'a, R> ColumnList<'a, R> {
    /// No column.
    #[expect(clippy::new_without_default, reason = "a table has columns")]
    pub fn new() -> ColumnList<'a, R> {
        ColumnList(Vec::new())
    }

    /// One more column: its head with the unit, its digits on the terminal and
    /// in files, its cells.
    #[must_use]
    pub fn with<C: Into<CellValue>>(
        mut self,
        head: impl Into<String>,
        shown: Digits,
        stored: Digits,
        cell: impl Fn(&R) -> C + 'a,
    ) -> ColumnList<'a, R> {
        self.0.push(Column {
            head: head.into(),
            shown,
            stored,
            cell: Box::new(move |row| cell(row).into()),
        });
        self
    }

    /// These columns, then others.
    #[must_use]
    pub fn and(mut self, others: ColumnList<'a, R>) -> ColumnList<'a, R> {
        self.0.extend(others.0);
        self
    }

    /// The columns of some heads.
    #[must_use]
    pub fn only(mut self, heads: &[&str]) -> ColumnList<'a, R> {
        self.0
            .retain(|column| heads.contains(&column.head.as_str()));
        self
    }

    /// The rows as aligned text, numbers to the right, without columns that are
    /// empty in every row and blanks at the ends of lines.
    pub fn text(&self, rows: &[R]) -> String {
        let shown = self
            .0
            .iter()
            .filter(|column| !matches!(column.shown, Digits::Hidden));
        let (mut heads, mut cells) = (Vec::new(), vec![Vec::new(); rows.len()]);
        for column in shown {
            let values: Vec<CellValue> = rows.iter().map(|row| (column.cell)(row)).collect();
            if values.iter().all(|value| *value == CellValue::Nothing) {
                continue;
            }
            let is_right = values.iter().any(CellValue::is_number);
            heads.push((column.head.as_str(), is_right));
            for (row, value) in cells.iter_mut().zip(values) {
                row.push(match data_cell(value, column.shown) {
                    DataCell::Empty if is_right => "-".to_owned(),
                    cell => cell.plain(),
                });
            }
        }
        indented("", &aligned(&heads, &cells))
    }

    /// The rows as a table for files.
    pub fn table(
        &self,
        name: impl Into<String>,
        title: impl Into<String>,
        caption: impl Into<String>,
        rows: &[R],
    ) -> DataTable {
        let stored = self
            .0
            .iter()
            .filter(|column| !matches!(column.stored, Digits::Hidden));
        let cells = |row| {
            let cells = stored.clone();
            cells
                .map(|column| data_cell((column.cell)(row), column.stored))
                .collect()
        };
        DataTable {
            name: name.into(),
            title: title.into(),
            caption: caption.into(),
            columns: stored.clone().map(|column| column.head.clone()).collect(),
            rows: rows.iter().map(cells).collect(),
        }
    }
}

/// [`ColumnList`] by lines of head, digits on the terminal and in files, cell.
///
/// ```
/// # use robovec_present::columns;
/// let columns = columns! { (u32, f64);
///     "cycles", [All, All], |row| row.0;
///     "time (us)", [Decimals(1), Decimals(3)], |row| row.1;
/// };
/// let csv = columns.table("", "", "", &[(157, 1.57)]).to_csv();
/// assert_eq!(csv, "cycles,time (us)\n157,1.570\n");
/// ```
#[macro_export]
macro_rules! columns {
    ($row:ty; $($head:expr, [$shown:expr, $stored:expr], $cell:expr;)*) => {{
        #[allow(unused_imports, reason = "a table needs some kinds of digits")]
        use $crate::Digits::{All, Decimals, Exponent, Hidden, Words};
        $crate::ColumnList::<$row>::new()$(.with($head, $shown, $stored, $cell))*
    }};
}

fn data_cell(value: CellValue, digits: Digits) -> DataCell {
    let number = match value {
        CellValue::Nothing => return DataCell::Empty,
        CellValue::Count(count) => return DataCell::Count(count),
        CellValue::Text(text) => return DataCell::Text(text),
        CellValue::Doubtful(doubtful) => return DataCell::Doubtful { doubtful },
        CellValue::Number(number) => number,
    };
    DataCell::Text(match digits {
        Digits::Decimals(decimals) => return DataCell::number(number, decimals),
        Digits::Words(words) => words(number),
        Digits::Exponent(1) => exponential(number),
        Digits::Exponent(digits) => format!("{number:.*e}", usize::from(digits)),
        Digits::All | Digits::Hidden => format!("{number:e}"),
    })
}
