//! Panels of curves.

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

/// The smallest distance of two labels, in pixels.
const SPACING: f64 = 12.5;

/// New heights for labels near the given ones, at least [`SPACING`] apart and
/// inside a range as far as they fit, in the order of the input.
///
/// Overlapping labels form a block around their mean, overlapping blocks one.
pub(super) fn spread(wanted: &[f64], from: f64, to: f64) -> Vec<f64> {
    debug_assert!(from <= to, "labels have room");
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]).then(a.cmp(&b)));
    // Blocks of labels: number, and sum of the places their first ones want.
    let mut blocks: Vec<(usize, f64)> = Vec::new();
    let top = |block: &(usize, f64)| {
        let height = (block.0 - 1) as f64 * SPACING;
        (block.1 / block.0 as f64).min(to - height).max(from)
    };
    for &index in &order {
        let mut block = (1, wanted[index]);
        while let Some(before) = blocks.last() {
            let end = top(before) + before.0 as f64 * SPACING;
            if end <= top(&block) {
                break;
            }
            let shift = (block.0 * before.0) as f64 * SPACING;
            block = (before.0 + block.0, before.1 + block.1 - shift);
            blocks.pop();
        }
        blocks.push(block);
    }
    let mut heights = vec![0.0; wanted.len()];
    let mut next = order.iter();
    for block in &blocks {
        for (place, &index) in next.by_ref().take(block.0).enumerate() {
            heights[index] = top(block) + place as f64 * SPACING;
        }
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_with_room_stay_and_others_move_apart() {
        assert_eq!(spread(&[100.0, 20.0], 0.0, 200.0), [100.0, 20.0]);
        assert_eq!(spread(&[50.0, 50.0], 0.0, 200.0), [43.75, 56.25]);
        assert_eq!(spread(&[], 0.0, 1.0), Vec::<f64>::new());
    }

    #[test]
    fn crowds_stay_apart_and_inside() {
        let heights = spread(&[199.0; 8], 0.0, 200.0);
        let gaps = heights.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(gaps.into_iter().all(|gap| gap >= SPACING - 1e-9));
        assert!(
            heights
                .iter()
                .all(|&height| (0.0..=200.0).contains(&height))
        );
    }
}
