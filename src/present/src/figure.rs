//! Figures as data: panels of curves or maps, before anything is drawn.
//!
//! A figure is written as CSV and drawn as SVG from the same structure, so that
//! every drawn point has its numbers in the CSV.

use super::csv;
use super::number::{or_nothing, trimmed};

/// A figure.
#[derive(Clone, PartialEq, Debug)]
pub struct Figure {
    /// Name of its files: `figure-3.4`.
    pub name: String,
    /// Number and subject: `Figure 3.4: …`.
    pub title: String,
    /// Explanation of the figure.
    pub caption: String,
    /// Its panels, drawn side by side in rows of [`Figure::columns`].
    pub panels: Vec<Panel>,
    /// Panels in a row.
    pub columns: usize,
}

/// A pair of axes with their curves.
#[derive(Clone, PartialEq, Debug)]
pub struct Panel {
    /// Its title, drawn above it.
    pub title: String,
    /// The horizontal axis.
    pub x: PlotAxis,
    /// The vertical axis.
    pub y: PlotAxis,
    /// Contents.
    pub content: PanelContent,
}

impl Panel {
    /// Axes with curves on them.
    pub fn curves(
        title: impl Into<String>,
        x: PlotAxis,
        y: PlotAxis,
        curves: impl IntoIterator<Item = Curve>,
    ) -> Panel {
        Panel {
            title: title.into(),
            x,
            y,
            content: PanelContent::Curves(curves.into_iter().collect()),
        }
    }

    /// True when nothing is drawn on the axes.
    pub fn is_empty(&self) -> bool {
        match &self.content {
            PanelContent::Curves(curves) => curves.iter().all(|curve| curve.marks.is_empty()),
            PanelContent::Tiles(map) => map.values.is_empty(),
        }
    }

    /// Axes with a map on them.
    pub fn map(title: impl Into<String>, x: PlotAxis, y: PlotAxis, map: TileMap) -> Panel {
        debug_assert!(
            map.columns.is_sorted() && map.rows.is_sorted(),
            "the numbers along an axis ascend"
        );
        Panel {
            title: title.into(),
            x,
            y,
            content: PanelContent::Tiles(map),
        }
    }
}

/// Contents of a pair of axes.
#[derive(Clone, PartialEq, Debug)]
pub enum PanelContent {
    /// Curves and points.
    Curves(Vec<Curve>),
    /// A map of squares.
    Tiles(TileMap),
}

/// An axis.
#[derive(Clone, PartialEq, Debug)]
pub struct PlotAxis {
    /// Quantity, and unit in parentheses.
    pub title: String,
    /// Way in which values are spaced.
    pub scale: AxisScale,
    /// The smallest value that must show, beyond those drawn.
    pub from: Option<f64>,
    /// The largest value that must show, beyond those drawn.
    pub to: Option<f64>,
}

/// Way in which values are spaced along an axis.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum AxisScale {
    /// Evenly.
    Linear,
    /// By their logarithm, with marks at powers of two.
    PowersOfTwo,
    /// By their logarithm, with marks at 1, 2 and 5 times powers of ten.
    Decades,
}

impl PlotAxis {
    /// An axis with the range of the drawn data.
    pub fn new(title: &str, scale: AxisScale) -> PlotAxis {
        PlotAxis {
            title: title.to_owned(),
            scale,
            from: None,
            to: None,
        }
    }

    /// The axis, extended to show a value.
    pub fn from(mut self, from: f64) -> PlotAxis {
        self.from = Some(from);
        self
    }

    /// The axis, extended to show a range.
    pub fn showing(mut self, from: f64, to: f64) -> PlotAxis {
        debug_assert!(from <= to, "the end of a range is not before its start");
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
    /// Stroke of the curve.
    pub stroke: Stroke,
    /// Its points, in the order in which they are joined.
    pub marks: Vec<Mark>,
}

impl Curve {
    /// A curve through the finite ones of some points; an empty label is none.
    pub fn new(
        label: impl Into<String>,
        paint: Paint,
        stroke: Stroke,
        marks: impl IntoIterator<Item = Mark>,
    ) -> Curve {
        Curve {
            label: label.into(),
            paint,
            stroke,
            marks: (marks.into_iter())
                .filter(|mark| mark.x.is_finite() && mark.y.is_finite())
                .collect(),
        }
    }

    /// Points that are not joined, in the colour of a place.
    pub fn points(
        label: impl Into<String>,
        place: usize,
        marks: impl IntoIterator<Item = Mark>,
    ) -> Curve {
        Curve::new(label, Paint::Distinct(place), Stroke::Points, marks)
    }
}

/// Colour and marker of a curve.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Paint {
    /// One of some colours that are easy to distinguish, each with a marker.
    Distinct(usize),
    /// A place, and the number of places, in a sequence from dark to light.
    Ordered(usize, usize),
}

/// Way in which a curve is drawn.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stroke {
    /// A line with a marker at every point.
    Marked,
    /// A dashed line with a marker at every point.
    MarkedDashed,
    /// Level lines with a marker where each begins and vertical ones between
    /// them, as between points that no other beats.
    Steps,
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
    /// Horizontal coordinate.
    pub x: f64,
    /// Vertical coordinate.
    pub y: f64,
    /// The ends of a bar through the point.
    pub range: Option<[f64; 2]>,
    /// The zone it lies in, shown by how its marker is filled.
    pub zone: Option<MarkZone>,
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

/// A zone of a plane, which has a name and shows in the markers of its points.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct MarkZone {
    /// Its name, in tables and in titles of markers.
    pub name: &'static str,
    /// Fill of its markers.
    pub fill: MarkFill,
}

/// Way in which a marker is filled.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum MarkFill {
    /// In its colour.
    Full,
    /// Half way to white.
    Tinted,
    /// White.
    Hollow,
}

/// A map: a value for each pair of whole numbers.
#[derive(Clone, PartialEq, Debug)]
pub struct TileMap {
    /// The numbers along the horizontal axis, ascending.
    pub columns: Vec<u32>,
    /// The numbers along the vertical axis, ascending.
    pub rows: Vec<u32>,
    /// Values row by row; `None` where there is none.
    pub values: Vec<Option<f64>>,
    /// Quantity of a value, with its unit.
    pub quantity: String,
    /// Squares to frame, by column and row number.
    pub framed: Vec<[u32; 2]>,
}

impl Figure {
    /// A figure of panels, this number in a row.
    pub fn new(
        name: impl Into<String>,
        title: impl Into<String>,
        caption: impl Into<String>,
        columns: usize,
        panels: Vec<Panel>,
    ) -> Figure {
        debug_assert!(columns > 0, "a row has a panel");
        Figure {
            name: name.into(),
            title: title.into(),
            caption: caption.into(),
            panels,
            columns,
        }
    }

    /// The figure, with a sentence in its caption on lines of a kind, if any.
    pub fn with_note(mut self, stroke: Stroke, note: &str) -> Figure {
        let is_drawn = |panel: &Panel| match &panel.content {
            PanelContent::Curves(curves) => curves
                .iter()
                .any(|curve| curve.stroke == stroke && curve.marks.len() > 1),
            PanelContent::Tiles(_) => false,
        };
        if self.panels.iter().any(is_drawn) {
            self.caption = format!("{} {note}", self.caption);
        }
        self
    }

    /// The figure's numbers as comma-separated values.
    pub fn to_csv(&self) -> String {
        let mut text = "panel,curve,x,y,low,high,zone\n".to_owned();
        for panel in &self.panels {
            match &panel.content {
                PanelContent::Curves(curves) => {
                    for curve in curves {
                        for mark in &curve.marks {
                            mark_line(&mut text, &panel.title, curve, mark);
                        }
                    }
                }
                PanelContent::Tiles(map) => {
                    assert_eq!(
                        map.values.len(),
                        map.rows.len() * map.columns.len(),
                        "a value for every square"
                    );
                    let rows = map
                        .rows
                        .iter()
                        .flat_map(|row| map.columns.iter().map(move |column| (row, column)));
                    for ((row, column), value) in rows.zip(&map.values) {
                        let value = or_nothing(*value, trimmed);
                        let (row, column) = (row.to_string(), column.to_string());
                        let fields = [&panel.title, &map.quantity, &column, &row, &value];
                        csv::push_line(
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
    let range = mark.range.map(|range| range.map(trimmed));
    let [low, high] = range.unwrap_or_default();
    let (x, y) = (trimmed(mark.x), trimmed(mark.y));
    let zone = mark.zone.map_or("", |zone| zone.name);
    let fields = [panel, &curve.label, &x, &y, &low, &high, zone];
    csv::push_line(text, fields.into_iter());
}
