//! Drawing figures as SVG.
//!
//! Written for paper and screen: text stays text, curves are labelled at their
//! ends, everyone can distinguish the colours, and in grey the markers. Every
//! marker has its values as an SVG title for the pointer.

mod curves;
mod map;
mod paint;
mod scale;
mod svg;

use crate::{Figure, Panel, PanelContent};
use svg::{Svg, TextAnchor};

/// Size of a panel's axes in a figure of one column, and of several.
const WIDE: [f64; 2] = [520.0, 320.0];
const NARROW: [f64; 2] = [300.0, 210.0];

/// Space to the left of the axes (numbers and title) and below them.
const LEFT: f64 = 62.0;
const BELOW: f64 = 50.0;
const ABOVE: f64 = 26.0;

/// The part of the drawing a panel's axes span.
#[derive(Clone, Copy, Debug)]
struct PlotFrame {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
}

impl PlotFrame {
    fn right(&self) -> f64 {
        self.left + self.width
    }

    fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// Draws a figure.
pub fn draw(figure: &Figure) -> String {
    let columns = figure.columns.clamp(1, figure.panels.len().max(1));
    let axes = if columns == 1 { WIDE } else { NARROW };
    drawing(figure, &figure.panels, columns, axes)
}

/// Maximum number of labels beside small axes.
const LABELS: usize = 14;

/// Draws every panel of a figure for itself, small enough for a narrow page,
/// so that a wide one puts several side by side.
pub fn draw_apart(figure: &Figure) -> Vec<String> {
    let panels = figure.panels.chunks(1);
    let draw = |panel: &[Panel]| {
        let axes = match &panel[0].content {
            PanelContent::Curves(curves) if curves.len() > LABELS => WIDE,
            PanelContent::Curves(_) | PanelContent::Tiles(_) => NARROW,
        };
        drawing(figure, panel, 1, axes)
    };
    panels.map(draw).collect()
}

/// Draws panels of a figure in this number of columns, with axes of a size.
fn drawing(figure: &Figure, panels: &[Panel], columns: usize, [width, height]: [f64; 2]) -> String {
    let beside = panels.iter().map(label_room).fold(12.0, f64::max);
    let cell = [LEFT + width + beside, ABOVE + height + BELOW];
    let rows = panels.len().div_ceil(columns);
    let mut svg = Svg::new(
        cell[0] * columns as f64,
        cell[1] * rows as f64 + 6.0,
        &figure.title,
    );
    for (index, panel) in panels.iter().enumerate() {
        let frame = PlotFrame {
            left: cell[0] * (index % columns) as f64 + LEFT,
            top: cell[1] * (index / columns) as f64 + ABOVE,
            width,
            height,
        };
        svg.text(
            [frame.left, frame.top - 9.0],
            TextAnchor::Start,
            "panel",
            &panel.title,
        );
        match &panel.content {
            PanelContent::Curves(curves) => curves::draw(&mut svg, frame, panel, curves),
            PanelContent::Tiles(map) => map::draw(&mut svg, frame, panel, map),
        }
    }
    svg.finish()
}

/// Width of the labels at the ends of a panel's curves.
fn label_room(panel: &Panel) -> f64 {
    match &panel.content {
        PanelContent::Curves(curves) => {
            let widths = curves.iter().map(|curve| svg::text_width(&curve.label));
            widths.fold(0.0, f64::max) + 24.0
        }
        PanelContent::Tiles(_) => 84.0,
    }
}

/// The titles of both axes.
fn axis_titles(svg: &mut Svg, frame: PlotFrame, panel: &Panel) {
    let middle = frame.left + frame.width / 2.0;
    svg.text(
        [middle, frame.bottom() + 38.0],
        TextAnchor::Middle,
        "axis",
        &panel.x.title,
    );
    let middle = frame.top + frame.height / 2.0;
    svg.upright_text([frame.left - 48.0, middle], "axis", &panel.y.title);
}

#[cfg(test)]
mod tests {
    use crate::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};

    fn figure(marks: &[[f64; 2]]) -> Figure {
        let axis = || PlotAxis::new("x", AxisScale::Linear);
        let marks = marks.iter().map(|&[x, y]| Mark::at(x, y));
        let curve = Curve::new("one", Paint::Distinct(0), Stroke::Plain, marks);
        let panel = Panel::curves("", axis(), axis(), [curve]);
        Figure::new("f", "F", "Points.", 1, vec![panel]).with_note(Stroke::Plain, "A line.")
    }

    #[test]
    fn a_curve_of_one_point_is_a_marker_and_no_line_in_the_caption() {
        let drawn = |figure: &Figure| {
            let svg = super::draw(figure);
            let count = |what: &str| svg.matches(what).count();
            (count("stroke-linejoin"), count("<path"))
        };
        let one = figure(&[[1.0, 2.0], [f64::NAN, 1.0]]);
        assert_eq!((drawn(&one), one.caption.as_str()), ((0, 1), "Points."));
        let two = figure(&[[1.0, 2.0], [2.0, 1.0]]);
        assert_eq!(
            (drawn(&two), two.caption.as_str()),
            ((1, 0), "Points. A line.")
        );
    }
}
