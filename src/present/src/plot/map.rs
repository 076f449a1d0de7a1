//! Panels that are maps.

use super::paint::sequence;
use super::svg::{Svg, TextAnchor};
use super::{PlotFrame, axis_titles};
use crate::number::trimmed;
use crate::{Panel, TileMap};

/// Draws a map: light squares are small values, which are the good ones.
pub(super) fn draw(svg: &mut Svg, frame: PlotFrame, panel: &Panel, map: &TileMap) {
    let found = map.values.iter().flatten();
    let (low, high) = found.fold((f64::INFINITY, 0f64), |(low, high), &value| {
        (low.min(value), high.max(value))
    });
    if low > high || low <= 0.0 {
        return;
    }
    let shade = |value: f64| match (high / low).ln() {
        0.0 => 1.0,
        range => 1.0 - (value / low).ln() / range,
    };
    let columns = map.columns.len();
    assert_eq!(
        map.values.len(),
        columns * map.rows.len(),
        "a value for each pair of numbers"
    );
    assert!(
        map.columns.is_sorted() && map.rows.is_sorted(),
        "numbers along an axis ascend"
    );
    let size = [
        frame.width / columns as f64,
        frame.height / map.rows.len() as f64,
    ];
    let corner = |column: usize, row: usize| {
        [
            frame.left + column as f64 * size[0],
            frame.bottom() - (row + 1) as f64 * size[1],
        ]
    };
    for (index, value) in map.values.iter().enumerate() {
        let Some(value) = *value else { continue };
        let (row, column) = (index / columns, index % columns);
        let title = format!(
            "{}: {}\n{}: {}\n{}: {}",
            panel.x.title,
            map.columns[column],
            panel.y.title,
            map.rows[row],
            map.quantity,
            trimmed(value)
        );
        let at = corner(column, row);
        let style = format!(
            "fill=\"{}\" stroke=\"#fff\" stroke-width=\".6\"",
            sequence(shade(value))
        );
        svg.rectangle(at, size, &style, &title);
        // Squares too small for their number show it when pointed at.
        if size[0] >= 26.0 && size[1] >= 14.0 {
            let middle = [at[0] + size[0] / 2.0, at[1] + size[1] / 2.0 + 3.5];
            svg.small_text(middle, shade(value) <= 0.55, &trimmed(value));
        }
    }
    for [column, row] in &map.framed {
        let place = |list: &[u32], wanted: &u32| list.iter().position(|number| number == wanted);
        if let (Some(column), Some(row)) = (place(&map.columns, column), place(&map.rows, row)) {
            let style = "fill=\"none\" stroke=\"#c40000\" stroke-width=\"2\"";
            svg.rectangle(corner(column, row), size, style, "");
        }
    }
    for (index, column) in map.columns.iter().enumerate() {
        let x = frame.left + (index as f64 + 0.5) * size[0];
        svg.text(
            [x, frame.bottom() + 15.0],
            TextAnchor::Middle,
            "tick",
            &column.to_string(),
        );
    }
    for (index, row) in map.rows.iter().enumerate() {
        let y = frame.bottom() - (index as f64 + 0.5) * size[1] + 4.0;
        svg.text(
            [frame.left - 6.0, y],
            TextAnchor::End,
            "tick",
            &row.to_string(),
        );
    }
    axis_titles(svg, frame, panel);
    scale(svg, frame, map, [low, high]);
}

/// The bar that relates shades to values.
fn scale(svg: &mut Svg, frame: PlotFrame, map: &TileMap, [low, high]: [f64; 2]) {
    const STEPS: usize = 24;
    let left = frame.right() + 16.0;
    let height = frame.height * 0.8 / STEPS as f64;
    let top = frame.top + frame.height * 0.15;
    svg.text(
        [frame.right() + 8.0, frame.top + 8.0],
        TextAnchor::Start,
        "tick",
        &map.quantity,
    );
    for step in 0..STEPS {
        let place = step as f64 / (STEPS - 1) as f64;
        let at = [left, top + step as f64 * height];
        svg.rectangle(
            at,
            [12.0, height + 0.5],
            &format!("fill=\"{}\"", sequence(place)),
            "",
        );
    }
    let value = |place: f64| trimmed((high * (low / high).powf(place)).round());
    for place in [0.0, 0.5, 1.0] {
        let y = top + place * (height * STEPS as f64) + 4.0;
        svg.text([left + 17.0, y], TextAnchor::Start, "tick", &value(place));
    }
}
