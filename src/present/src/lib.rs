//! Results for users and for programs: aligned text, tables as CSV and HTML,
//! figures as CSV and SVG, self-contained pages.
//!
//! **Invariant.** This crate does not depend on the kind of results shown.

mod columns;
pub mod csv;
pub mod escape;
mod figure;
pub mod json;
pub mod number;
pub mod page;
pub mod plot;
mod table;
pub mod text;

pub use self::columns::{CellValue, ColumnList, Digits};
pub use figure::{
    AxisScale, Curve, Figure, Mark, MarkFill, MarkZone, Paint, Panel, PanelContent, PlotAxis,
    Stroke, TileMap,
};
pub use table::{DataCell, DataTable};
pub use text::{indented, text_lines, text_table};
