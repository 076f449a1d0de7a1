//! Effects of series as text, table and figure.

use super::{TrigonometryEffect, TrigonometryRow};
use robovec_present::number::exponential;
use robovec_present::{
    AxisScale, Curve, DataCell, DataTable, Figure, Mark, Paint, Panel, PlotAxis, Stroke, text_lines,
};

/// The rows of one function, for people.
pub fn text(effect: &TrigonometryEffect) -> String {
    let mut head =
        "angles ± | order | >error of sin | >error of cos | >operations | >path".to_owned();
    for array in &effect.arrays {
        head += &format!(" | >{array}: median | >{array}: worst");
    }
    let rows: Vec<Vec<String>> = effect.rows.iter().map(cells).collect();
    format!("{}:\n{}", effect.name, text_lines(&head, &rows))
}

fn cells(row: &TrigonometryRow) -> Vec<String> {
    let mut cells = vec![row.angle.to_string()];
    match row.order {
        None => cells.extend(["true".to_owned(), String::new(), String::new()]),
        Some(order) => {
            cells.push(order.to_string());
            cells.extend(row.proved.map(exponential));
        }
    }
    cells.extend(row.size.map(|number| number.to_string()));
    for errors in &row.errors {
        cells.extend([exponential(errors.median), exponential(errors.worst)]);
    }
    cells
}

/// The same as a table for programs: one row for every output array.
pub fn table(effects: &[TrigonometryEffect]) -> DataTable {
    let exact = |number: f64| DataCell::text(format!("{number:e}"));
    let line = |effect: &TrigonometryEffect, row: &TrigonometryRow, array: usize| {
        vec![
            DataCell::text(&effect.name),
            exact(row.angle),
            row.order
                .map_or_else(|| DataCell::text("true"), DataCell::count),
            exact(row.proved[0]),
            exact(row.proved[1]),
            DataCell::count(row.size[0]),
            DataCell::count(row.size[1]),
            DataCell::text(&effect.arrays[array]),
            exact(row.errors[array].median),
            exact(row.errors[array].worst),
        ]
    };
    let mut rows = Vec::new();
    for effect in effects {
        for row in &effect.rows {
            rows.extend((0..effect.arrays.len()).map(|array| line(effect, row, array)));
        }
    }
    DataTable::new(
        "trig",
        "Errors of outputs by the order of the polynomials for sine and cosine",
        "The errors of sine and cosine are proved bounds on the range; those of the \
                  outputs are the largest of an array over its largest element, over random \
                  states with joints in the range, rounding included.",
        "function | range (rad) | order | largest error of sin | largest error of cos | \
         operations | path (cycles) | array | normwise error, median | normwise error, worst",
        rows,
    )
}

/// Median errors against the range, one curve for every order.
pub fn figure(effects: &[TrigonometryEffect]) -> Figure {
    let mut panels = Vec::new();
    for effect in effects {
        for (index, array) in effect.arrays.iter().enumerate() {
            panels.push(Panel::curves(
                format!("{} {array}", effect.name),
                PlotAxis::new("range of the joints (rad)", AxisScale::Decades),
                PlotAxis::new("median normwise error", AxisScale::Decades),
                curves(effect, index),
            ));
        }
    }
    Figure::new(
        "trig",
        "Errors of outputs against the range of the joints",
        "The median over random states of the largest error of an array over its \
                  largest element; a curve for every order of the polynomials that stand for \
                  sine and cosine.",
        panels.len().clamp(1, 2),
        panels,
    )
}

fn curves(effect: &TrigonometryEffect, array: usize) -> Vec<Curve> {
    let mut orders: Vec<Option<u32>> = effect.rows.iter().map(|row| row.order).collect();
    orders.sort_unstable();
    orders.dedup();
    let marks = |order: Option<u32>| {
        let rows = effect.rows.iter().filter(move |row| row.order == order);
        let marks = rows.map(|row| Mark::at(row.angle, row.errors[array].median));
        // A logarithm has no place for nothing.
        marks.filter(|mark| mark.y > 0.0)
    };
    orders
        .into_iter()
        .enumerate()
        .map(|(place, order)| {
            Curve::new(
                match order {
                    None => "true".to_owned(),
                    Some(order) => format!("order {order}"),
                },
                Paint::Distinct(place),
                Stroke::Marked,
                marks(order),
            )
        })
        .collect()
}
