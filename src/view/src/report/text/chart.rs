//! The occupation of processing elements, drawn with block characters.

use crate::report::schedule::{KindReport, ScheduleReport};

/// Rows of text per kind of element.
const HEIGHT: usize = 4;

/// An eighth of a row more each.
const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// One chart per kind, time from left to right, and the cycles below.
pub(super) fn occupation(schedule: &ScheduleReport) -> String {
    let mut text = String::new();
    for kind in &schedule.elements {
        chart(kind, schedule.cycles, &mut text);
    }
    let width = schedule
        .elements
        .first()
        .map_or(0, |kind| kind.occupation.len());
    let end = schedule.cycles.to_string();
    let gap = width.saturating_sub(1 + end.len());
    text.push_str(&format!("{:>14} 0{}{end} cycles\n", "", " ".repeat(gap)));
    text
}

fn chart(kind: &KindReport, cycles: u32, text: &mut String) {
    let slots = f64::from(kind.count) * f64::from(cycles.max(1));
    let mean = kind.operations as f64 / slots * 100.0;
    for row in (0..HEIGHT).rev() {
        let label = match row {
            row if row == HEIGHT - 1 => format!("{} {}", kind.count, kind.kind),
            0 => format!("mean {mean:.1} %"),
            _ => String::new(),
        };
        let bars: String = kind
            .occupation
            .iter()
            .map(|&share| block(share, row))
            .collect();
        text.push_str(&format!("{label:<14}▕{bars}▏"));
        text.push_str(match row {
            row if row == HEIGHT - 1 => "100 %\n",
            0 => "  0 %\n",
            _ => "\n",
        });
    }
}

/// The part of a bar that falls into a row, counted from the bottom. A value
/// that is not zero gets at least one eighth.
fn block(share: f64, row: usize) -> char {
    debug_assert!(row < HEIGHT, "a bar has so many rows");
    let steps = BLOCKS.len() - 1;
    let full = HEIGHT * steps;
    let mut eighths = (share.clamp(0.0, 1.0) * full as f64).round() as usize;
    if share > 0.0 {
        eighths = eighths.max(1);
    }
    BLOCKS[eighths.saturating_sub(row * steps).min(steps)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_fill_from_the_bottom_and_little_is_not_nothing() {
        let bar = |share| -> String { (0..HEIGHT).map(|row| block(share, row)).collect() };
        assert_eq!(bar(0.0), "    ");
        assert_eq!(bar(0.001), "▁   ");
        assert_eq!(bar(0.5), "██  ");
        assert_eq!(bar(0.625), "██▄ ");
        assert_eq!(bar(1.0), "████");
    }
}
