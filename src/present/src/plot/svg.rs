//! Writing SVG elements.

use crate::escape::Escaped;
use std::fmt::Write;

/// Place of a text relative to its point.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum TextAnchor {
    Start,
    Middle,
    End,
}

impl TextAnchor {
    fn name(self) -> &'static str {
        match self {
            TextAnchor::Start => "start",
            TextAnchor::Middle => "middle",
            TextAnchor::End => "end",
        }
    }
}

/// An SVG document that grows.
pub(super) struct Svg {
    text: String,
}

/// Style of all drawings: thin greys for axes and grids under the data.
const STYLE: &str = "text{font:11px Helvetica,Arial,'Liberation Sans',sans-serif;fill:#222}\
.panel{font-weight:bold;font-size:12px}.axis{font-size:12px}.tick{fill:#444}\
.grid{stroke:#e4e4e4;stroke-width:1}.frame{stroke:#666;stroke-width:1;fill:none}\
.leader{stroke:#999;stroke-width:.6;fill:none}.note{fill:#555;font-style:italic}";

impl Svg {
    /// An empty drawing of a size in pixels.
    pub(super) fn new(width: f64, height: f64, title: &str) -> Svg {
        let mut svg = Svg {
            text: String::new(),
        };
        let (width, height) = (SvgNumber(width), SvgNumber(height));
        svg.write(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             width=\"{width}\" height=\"{height}\" role=\"img\" aria-label=\"{}\">\n\
             <style>{STYLE}</style>\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n",
            Escaped(title),
        ));
        svg
    }

    fn write(&mut self, arguments: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.text.write_fmt(arguments);
    }

    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], class: &str) {
        self.write(format_args!(
            "<line class=\"{class}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>\n",
            SvgNumber(from[0]),
            SvgNumber(from[1]),
            SvgNumber(to[0]),
            SvgNumber(to[1]),
        ));
    }

    /// An open line through points.
    pub(super) fn polyline(&mut self, points: &[[f64; 2]], style: &str, title: &str) {
        self.write(format_args!("<polyline fill=\"none\" {style} points=\""));
        for [x, y] in points {
            self.write(format_args!("{},{} ", SvgNumber(*x), SvgNumber(*y)));
        }
        self.write(format_args!("\">{}</polyline>\n", Title(title)));
    }

    pub(super) fn rectangle(&mut self, at: [f64; 2], size: [f64; 2], style: &str, title: &str) {
        self.write(format_args!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {style}>{}</rect>\n",
            SvgNumber(at[0]),
            SvgNumber(at[1]),
            SvgNumber(size[0]),
            SvgNumber(size[1]),
            Title(title),
        ));
    }

    /// A shape by the data of its path, around a point.
    pub(super) fn shape(&mut self, at: [f64; 2], path: &str, style: &str, title: &str) {
        self.write(format_args!(
            "<path transform=\"translate({} {})\" d=\"{path}\" {style}>{}</path>\n",
            SvgNumber(at[0]),
            SvgNumber(at[1]),
            Title(title),
        ));
    }

    pub(super) fn text(&mut self, at: [f64; 2], anchor: TextAnchor, class: &str, text: &str) {
        self.write(format_args!(
            "<text class=\"{class}\" x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n",
            SvgNumber(at[0]),
            SvgNumber(at[1]),
            anchor.name(),
            Escaped(text),
        ));
    }

    /// A coloured text that starts at a point.
    pub(super) fn label(&mut self, at: [f64; 2], colour: &str, text: &str) {
        self.write(format_args!(
            "<text x=\"{}\" y=\"{}\" style=\"fill:{colour}\">{}</text>\n",
            SvgNumber(at[0]),
            SvgNumber(at[1]),
            Escaped(text),
        ));
    }

    /// A small centred text on a coloured ground, light or dark.
    pub(super) fn small_text(&mut self, at: [f64; 2], light: bool, text: &str) {
        let colour = if light { "#fff" } else { "#222" };
        self.write(format_args!(
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" \
             style=\"font-size:9px;fill:{colour};pointer-events:none\">{}</text>\n",
            SvgNumber(at[0]),
            SvgNumber(at[1]),
            Escaped(text),
        ));
    }

    /// A text that reads upwards, centred on a point.
    pub(super) fn upright_text(&mut self, at: [f64; 2], class: &str, text: &str) {
        self.write(format_args!(
            "<text class=\"{class}\" transform=\"translate({} {}) rotate(-90)\" \
             text-anchor=\"middle\">{}</text>\n",
            SvgNumber(at[0]),
            SvgNumber(at[1]),
            Escaped(text),
        ));
    }

    pub(super) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// Approximate width of a text, in pixels: browsers and printers differ.
pub(super) fn text_width(text: &str) -> f64 {
    text.chars().count() as f64 * 5.9
}

/// A coordinate with a tenth of a pixel.
struct SvgNumber(f64);

impl std::fmt::Display for SvgNumber {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let tenths = (self.0 * 10.0).round() as i64;
        if tenths % 10 == 0 {
            write!(formatter, "{}", tenths / 10)
        } else {
            let sign = if tenths < 0 { "-" } else { "" };
            write!(
                formatter,
                "{sign}{}.{}",
                tenths.abs() / 10,
                tenths.abs() % 10
            )
        }
    }
}

struct Title<'a>(&'a str);

impl std::fmt::Display for Title<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.is_empty() {
            return Ok(());
        }
        write!(formatter, "<title>{}</title>", Escaped(self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short_and_signed() {
        for (value, text) in [(1.0, "1"), (-0.26, "-0.3"), (-1.04, "-1"), (12.345, "12.3")] {
            assert_eq!(SvgNumber(value).to_string(), text);
        }
    }

    #[test]
    fn hostile_texts_stay_text() {
        let mut svg = Svg::new(10.0, 10.0, "a\"b");
        svg.text([0.0, 0.0], TextAnchor::End, "axis", "</text><script>&\u{1}");
        let text = svg.finish();
        let document = roxmltree::Document::parse(&text).expect("well formed");
        let found = document
            .descendants()
            .find(|node| node.has_tag_name("text"));
        assert_eq!(
            found.and_then(|node| node.text()),
            Some("</text><script>& ")
        );
    }
}
