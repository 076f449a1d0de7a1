//! Tables beside the nodes: writes, formats and histories that no text gives.

use super::{ATOMIC, PLACED, after, placement};
use crate::entity::Value;
use crate::history::{Histories, HistoryStep};
use crate::value_formats::ValueFormats;
use robovec_num::format::{FixedFormat, Format};

#[test]
fn writes_of_a_value_are_in_order() {
    let messages = after(PLACED, |function| {
        let placement = placement(function);
        let starts = &placement.write_starts;
        let several = starts.windows(2).find(|range| range[1] - range[0] > 1);
        let several = several.expect("a value is written twice");
        placement
            .writes
            .swap(several[0] as usize, several[0] as usize + 1);
    });
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(
        messages[0].ends_with("has writes out of order"),
        "{messages:?}"
    );
}

#[test]
fn formats_can_be_computed_in() {
    let format = Format::Fixed(FixedFormat {
        integer: 40,
        fraction: 14,
    });
    let messages = after(ATOMIC, |function| {
        let mut formats = ValueFormats::new(function.nodes().len());
        formats.set(Value(0), Some(format));
        function.formats = Some(formats);
    });
    assert_eq!(
        messages,
        [format!(
            "no operation can be computed in the format {format}"
        )]
    );
}

#[test]
fn histories_are_in_the_table() {
    let step = || HistoryStep {
        before: crate::History::NONE,
        pass: "balance".to_owned(),
        rules: Vec::new(),
    };
    for (node, output) in [(true, false), (false, true)] {
        let messages = after(ATOMIC, |function| {
            let mut longer = Histories::new(0, 0);
            longer.add(step());
            let mut other = step();
            other.pass = "swap".to_owned();
            let beyond = longer.add(other);
            let mut histories = Histories::new(function.nodes().len(), function.assignments.len());
            let known = histories.add(step());
            histories.values[1] = if node { beyond } else { known };
            histories.outputs[0] = if output { beyond } else { known };
            function.histories = Some(histories);
        });
        let subject = if node { "%y" } else { "M" };
        let expected = format!("{subject} has a history that is not in the table");
        assert_eq!(messages, [expected]);
    }
}
