//! Panels of curves.

use super::labels::spread;
use super::paint::fill;
use super::scale::Ruler;
use super::svg::{Svg, TextAnchor};
use super::{PlotFrame, axis_titles};
use crate::number::trimmed;
use crate::{Curve, Mark, MarkFill, Panel, Stroke};

pub(super) fn draw(svg: &mut Svg, frame: PlotFrame, panel: &Panel, curves: &[Curve]) {
    let marks = || curves.iter().flat_map(|curve| &curve.marks);
    let heights = marks().flat_map(|mark| mark.range.into_iter().flatten().chain([mark.y]));
    let plane = Plane {
        frame,
        x: Ruler::new(&panel.x, marks().map(|mark| mark.x)),
        y: Ruler::new(&panel.y, heights),
    };
    plane.axes(svg);
    axis_titles(svg, frame, panel);
    // Guidance first, so that measured points lie on top of it.
    let is_marked = |curve: &&Curve| {
        matches!(
            curve.stroke,
            Stroke::Marked | Stroke::MarkedDashed | Stroke::Steps | Stroke::Points
        )
    };
    for curve in curves.iter().filter(|curve| !is_marked(curve)) {
        match curve.marks.len() {
            // No line joins one point.
            1 => plane.markers(svg, panel, curve),
            _ => plane.stroke(svg, curve),
        }
    }
    for curve in curves.iter().filter(is_marked) {
        plane.stroke(svg, curve);
        plane.markers(svg, panel, curve);
    }
    plane.labels(svg, curves);
}

struct Plane {
    frame: PlotFrame,
    x: Ruler,
    y: Ruler,
}

impl Plane {
    fn at(&self, x: f64, y: f64) -> [f64; 2] {
        [
            self.frame.left + self.frame.width * self.x.place(x),
            self.frame.bottom() - self.frame.height * self.y.place(y),
        ]
    }

    fn axes(&self, svg: &mut Svg) {
        let frame = self.frame;
        let mut last_end = f64::NEG_INFINITY;
        for tick in self.x.ticks() {
            let x = frame.left + frame.width * self.x.place(tick);
            svg.line([x, frame.top], [x, frame.bottom()], "grid");
            let text = self.x.text(tick);
            let half = super::svg::text_width(&text) / 2.0;
            // Numbers that would run into each other are left out.
            if x - half > last_end + 4.0 {
                svg.text(
                    [x, frame.bottom() + 15.0],
                    TextAnchor::Middle,
                    "tick",
                    &text,
                );
                last_end = x + half;
            }
        }
        for tick in self.y.ticks() {
            let y = frame.bottom() - frame.height * self.y.place(tick);
            svg.line([frame.left, y], [frame.right(), y], "grid");
            svg.text(
                [frame.left - 6.0, y + 4.0],
                TextAnchor::End,
                "tick",
                &self.y.text(tick),
            );
        }
        svg.rectangle(
            [frame.left, frame.top],
            [frame.width, frame.height],
            "class=\"frame\"",
            "",
        );
    }

    fn stroke(&self, svg: &mut Svg, curve: &Curve) {
        let style = match curve.stroke {
            Stroke::Marked => "stroke-width=\"1.6\"",
            Stroke::MarkedDashed => "stroke-width=\"1.4\" stroke-dasharray=\"5 3\"",
            Stroke::Steps => "stroke-width=\"1.2\" stroke-opacity=\".8\"",
            Stroke::Plain => "stroke-width=\"1.4\"",
            Stroke::Dashed => "stroke-width=\"1\" stroke-dasharray=\"3 3\" stroke-opacity=\".75\"",
            Stroke::Points => return,
        };
        let points: Vec<[f64; 2]> = curve
            .marks
            .iter()
            .map(|mark| self.at(mark.x, mark.y))
            .collect();
        let points = match curve.stroke {
            Stroke::Steps => stairs(&points),
            _ => points,
        };
        let style = format!(
            "stroke=\"{}\" stroke-linejoin=\"round\" {style}",
            curve.paint.colour()
        );
        svg.polyline(&points, &style, &curve.label);
    }

    fn markers(&self, svg: &mut Svg, panel: &Panel, curve: &Curve) {
        let colour = curve.paint.colour();
        for mark in &curve.marks {
            let at = self.at(mark.x, mark.y);
            if let Some([low, high]) = mark.range {
                let [bottom, top] = [self.at(mark.x, low)[1], self.at(mark.x, high)[1]];
                let size = [5.0, (bottom - top).max(1.0)];
                let style = format!("fill=\"{colour}\" fill-opacity=\".35\"");
                svg.rectangle([at[0] - 2.5, top], size, &style, "");
            }
            let style = fill(mark.zone.map_or(MarkFill::Full, |zone| zone.fill), &colour);
            svg.shape(
                at,
                curve.paint.marker(),
                &style,
                &describe(panel, curve, mark),
            );
        }
    }

    fn labels(&self, svg: &mut Svg, curves: &[Curve]) {
        let ends = curves.iter().filter(|curve| !curve.label.is_empty());
        let ends = ends.filter_map(|curve| Some((curve, curve.marks.last()?)));
        let ends: Vec<(&Curve, [f64; 2])> = ends
            .map(|(curve, mark)| (curve, self.at(mark.x, mark.y)))
            .collect();
        let wanted: Vec<f64> = ends.iter().map(|(_, at)| at[1]).collect();
        let heights = spread(&wanted, self.frame.top + 4.0, self.frame.bottom() + 8.0);
        assert_eq!(heights.len(), ends.len(), "every label has a height");
        for ((curve, at), height) in ends.iter().zip(heights) {
            let start = [(at[0] + 5.0).min(self.frame.right() + 3.0), at[1]];
            let turn = self.frame.right() + 4.0;
            let end = self.frame.right() + 13.0;
            if (height - at[1]).abs() > 2.0 || turn - at[0] > 12.0 {
                let route = [start, [turn.max(start[0]), at[1]], [end, height]];
                svg.polyline(&route, "class=\"leader\"", "");
            }
            svg.label(
                [end + 2.0, height + 4.0],
                &curve.paint.colour(),
                &curve.label,
            );
        }
    }
}

/// Points with a corner between every two: level first, then vertical.
fn stairs(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut stairs: Vec<[f64; 2]> = Vec::new();
    for &[x, y] in points {
        stairs.extend(stairs.last().map(|&[_, level]| [x, level]));
        stairs.push([x, y]);
    }
    stairs
}

/// The values of a marker, shown under the pointer.
fn describe(panel: &Panel, curve: &Curve, mark: &Mark) -> String {
    let mut text = format!(
        "{}\n{}: {}\n{}: {}",
        curve.label,
        panel.x.title,
        trimmed(mark.x),
        panel.y.title,
        trimmed(mark.y)
    );
    if let Some([low, high]) = mark.range {
        text += &format!("\nfrom {} to {}", trimmed(low), trimmed(high));
    }
    if let Some(zone) = mark.zone {
        text += &format!("\n{}", zone.name);
    }
    text
}
