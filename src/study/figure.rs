//! Figures as data: panels of curves or maps, before anything is drawn.
//!
//! A figure is written as CSV and drawn as SVG from the same structure, so
//! that what is seen can be looked up.

use super::table::line;
use std::fmt::Write;

/// A figure.
#[derive(Clone, PartialEq, Debug)]
pub struct Figure {
    /// Name of its files: `figure-3.4`.
    pub name: String,
    /// Number and subject: `Figure 3.4: …`.
    pub title: String,
    /// What it shows and how to read it.
    pub caption: String,
    /// Its panels, drawn side by side in rows of [`Figure::columns`].
    pub panels: Vec<Panel>,
    /// Panels in a row.
    pub columns: usize,
}

/// A pair of axes and what is drawn on them.
#[derive(Clone, PartialEq, Debug)]
pub struct Panel {
    /// Its title, drawn above it.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn.
    pub content: Content,
}

/// What is drawn on a pair of axes.
#[derive(Clone, PartialEq, Debug)]
pub enum Content {
    /// Curves and points.
    Curves(Vec<Curve>),
    /// A map of squares.
    Map(Map),
}

/// An axis.
#[derive(Clone, PartialEq, Debug)]
pub struct Axis {
    /// Quantity, and unit in parentheses.
    pub title: String,
    /// How values are spaced.
    pub scale: Scale,
    /// The least value that must show, beyond those drawn.
    pub from: Option<f64>,
    /// The largest value that must show, beyond those drawn.
    pub to: Option<f64>,
}

/// How values are spaced along an axis.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By their logarithm, with marks at powers of two.
    PowersOfTwo,
    /// By their logarithm, with marks at 1, 2 and 5 times powers of ten.
    Decades,
}

impl Axis {
    /// An axis as wide as what is drawn.
    pub fn new(title: &str, scale: Scale) -> Axis {
        Axis {
            title: title.to_owned(),
            scale,
            from: None,
            to: None,
        }
    }

    /// The axis, extended to show a range.
    pub fn showing(mut self, from: f64, to: f64) -> Axis {
        (self.from, self.to) = (Some(from), Some(to));
        self
    }
}

/// A curve.
#[derive(Clone, PartialEq, Debug)]
pub struct Curve {
    /// Its label, drawn at its end; an unlabelled curve belongs to the
    /// labelled one of the same colour.
    pub label: String,
    /// Colour and marker.
    pub paint: Paint,
    /// How it is drawn.
    pub stroke: Stroke,
    /// Its points, in the order in which they are joined.
    pub marks: Vec<Mark>,
}

/// Colour and marker of a curve.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Paint {
    /// One of a set of colours easy to tell apart, each with a marker of its
    /// own.
    Distinct(usize),
    /// A place, and the number of places, in a sequence from dark to light.
    Ordered(usize, usize),
}

/// How a curve is drawn.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stroke {
    /// A line with a marker at every point.
    Marked,
    /// A dashed line with a marker at every point.
    MarkedDashed,
    /// A thin line.
    Plain,
    /// A thin dashed line.
    Dashed,
    /// Markers alone.
    Points,
}

/// A point of a curve.
#[derive(Clone, PartialEq, Debug)]
pub struct Mark {
    /// Where.
    pub x: f64,
    /// How much.
    pub y: f64,
    /// The ends of a bar through the point.
    pub range: Option<[f64; 2]>,
    /// The zone it lies in, shown by how its marker is filled.
    pub zone: Option<Zone>,
}

impl Mark {
    /// A point.
    pub fn at(x: f64, y: f64) -> Mark {
        Mark {
            x,
            y,
            range: None,
            zone: None,
        }
    }
}

/// The three zones of thesis 3.3.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Zone {
    /// More elements shorten the run in proportion.
    Parallelisation,
    /// More elements shorten the run, at the cost of their use.
    Transition,
    /// More elements are of no use.
    Saturation,
}

impl Zone {
    /// The zone's name.
    pub fn name(self) -> &'static str {
        match self {
            Zone::Parallelisation => "parallelisation",
            Zone::Transition => "transition",
            Zone::Saturation => "saturation",
        }
    }
}

/// A map: a value for each pair of whole numbers.
#[derive(Clone, PartialEq, Debug)]
pub struct Map {
    /// The numbers along the horizontal axis, ascending.
    pub columns: Vec<u32>,
    /// The numbers along the vertical axis, ascending.
    pub rows: Vec<u32>,
    /// Values row by row; `None` where there is none.
    pub values: Vec<Option<f64>>,
    /// What a value is, with its unit.
    pub quantity: String,
    /// Squares to frame, by column and row number.
    pub framed: Vec<[u32; 2]>,
}

impl Figure {
    /// The figure's numbers as comma-separated values.
    pub fn to_csv(&self) -> String {
        let mut text = "panel,curve,x,y,low,high,zone\n".to_owned();
        for panel in &self.panels {
            match &panel.content {
                Content::Curves(curves) => {
                    for curve in curves {
                        for mark in &curve.marks {
                            mark_line(&mut text, &panel.title, curve, mark);
                        }
                    }
                }
                Content::Map(map) => {
                    let rows = map
                        .rows
                        .iter()
                        .flat_map(|row| map.columns.iter().map(move |column| (row, column)));
                    for ((row, column), value) in rows.zip(&map.values) {
                        let value = value.map_or(String::new(), number);
                        let (row, column) = (row.to_string(), column.to_string());
                        let fields = [&panel.title, &map.quantity, &column, &row, &value];
                        line(
                            &mut text,
                            fields.into_iter().map(String::as_str).chain(["", ""]),
                        );
                    }
                }
            }
        }
        text
    }
}

fn mark_line(text: &mut String, panel: &str, curve: &Curve, mark: &Mark) {
    let range = mark.range.map(|range| range.map(number));
    let [low, high] = range.unwrap_or_default();
    let (x, y) = (number(mark.x), number(mark.y));
    let zone = mark.zone.map_or("", Zone::name);
    line(
        text,
        [panel, &curve.label, &x, &y, &low, &high, zone].into_iter(),
    );
}

/// A number without the noise of its last bits.
pub(super) fn number(number: f64) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write!(text, "{number:.4}");
    let trimmed = text.trim_end_matches('0').trim_end_matches('.');
    if trimmed == "-0" {
        "0".to_owned()
    } else {
        trimmed.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-0.00001, "0"),
            (1.5, "1.5"),
            (743.0, "743"),
            (0.12345, "0.1235"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
