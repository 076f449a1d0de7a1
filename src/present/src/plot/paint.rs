//! Colours and markers.

use crate::{MarkFill, Paint};

/// Colours that people with any of the common colour vision deficiencies can
/// distinguish (after Okabe and Ito), dark enough for text.
const DISTINCT: [&str; 7] = [
    "#0072b2", "#c44e00", "#00805e", "#a3528a", "#000000", "#9a7400", "#3b8fc4",
];

/// From dark to light; in grey the order stays.
const SEQUENCE: [[f64; 3]; 5] = [
    [45.0, 10.0, 75.0],
    [50.0, 80.0, 140.0],
    [30.0, 135.0, 140.0],
    [85.0, 180.0, 95.0],
    [205.0, 195.0, 40.0],
];

/// Circle, square, triangle, diamond, downward triangle, star, bar.
const MARKERS: [&str; 7] = [
    "M-3.6 0a3.6 3.6 0 1 0 7.2 0a3.6 3.6 0 1 0-7.2 0z",
    "M-3.2-3.2h6.4v6.4h-6.4z",
    "M0-4.3L4.2 3.3H-4.2z",
    "M0-4.6L4 0L0 4.6L-4 0z",
    "M0 4.3L4.2-3.3H-4.2z",
    "M-1.4-4h2.8v2.6h2.6v2.8h-2.6v2.6h-2.8v-2.6h-2.6v-2.8h2.6z",
    "M-4-1.6h8v3.2h-8z",
];

impl Paint {
    pub(super) fn colour(self) -> String {
        match self {
            Paint::Distinct(index) => DISTINCT[index % DISTINCT.len()].to_owned(),
            Paint::Ordered(index, count) => {
                sequence(index as f64 / count.max(2).saturating_sub(1) as f64)
            }
        }
    }

    /// Its marker, as the data of a path.
    pub(super) fn marker(self) -> &'static str {
        match self {
            Paint::Distinct(index) | Paint::Ordered(index, _) => MARKERS[index % MARKERS.len()],
        }
    }
}

/// A colour of the sequence, from 0 (dark) to 1 (light).
pub(super) fn sequence(place: f64) -> String {
    let place = place.clamp(0.0, 1.0) * (SEQUENCE.len() - 1) as f64;
    let low = (place as usize).min(SEQUENCE.len() - 2);
    let share = place - low as f64;
    let mix = |channel: usize| {
        let (from, to) = (SEQUENCE[low][channel], SEQUENCE[low + 1][channel]);
        (from + (to - from) * share).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
}

/// The style of a marker of a colour.
pub(super) fn fill(fill: MarkFill, colour: &str) -> String {
    match fill {
        MarkFill::Full => format!("fill=\"{colour}\" stroke=\"{colour}\""),
        MarkFill::Tinted => {
            format!(
                "fill=\"{}\" stroke=\"{colour}\" stroke-width=\"1.3\"",
                tint(colour)
            )
        }
        MarkFill::Hollow => {
            format!("fill=\"#fff\" stroke=\"{colour}\" stroke-width=\"1.3\"")
        }
    }
}

/// A colour half way to white.
fn tint(colour: &str) -> String {
    let channel = |start: usize| {
        let value = u8::from_str_radix(&colour[start..start + 2], 16);
        128 + value.expect("colours are six hexadecimal digits") / 2
    };
    format!("#{:02x}{:02x}{:02x}", channel(1), channel(3), channel(5))
}
