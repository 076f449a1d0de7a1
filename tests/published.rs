//! Bounds beside those that others publish for the same formulas and ranges.

use robovec::errors::{ErrorMethod, ErrorSettings, ErrorTable, IntervalRow};
use robovec::fpcore::read;
use robovec_analysis::interval::GivenData;
use robovec_ir::states::States;
use robovec_ir::{Format, View};
use std::sync::Arc;

/// Absolute errors in binary64 by FPTaylor efbbc83 with its improved rounding
/// model and at most 10⁶ boxes. It rounds inputs and literals.
const THEIRS: [(&str, f64); 13] = [
    ("doppler1", 1.22e-13),
    ("doppler2", 2.23e-13),
    ("carbonGas", 5.90e-9),
    ("sine", 3.87e-16),
    ("verhulst", 2.47e-16),
    ("kepler0", 7.47e-14),
    ("rigidBody1", 2.95e-13),
    ("rigidBody2", 3.61e-11),
    ("turbine1", 1.67e-14),
    ("jetEngine", 1.03e-11),
    ("sineOrder3", 5.94e-16),
    ("sphere", 8.21e-15),
    ("dqmom9", 3.44e-1),
];

fn bounded(text: &str, name: &str, data: GivenData, boxes: usize) -> IntervalRow {
    let core = read("benchmarks", text, Some(name)).expect("it is a good core");
    let view = View {
        tables: &core.module.tables,
        function: &core.module.functions[0],
    };
    let settings = ErrorSettings {
        format: Format::BINARY64,
        states: States::new(1).within(Arc::new(core.ranges)),
        state: 0,
        blamed: 1,
        methods: vec![ErrorMethod::Interval],
        outputs: vec![0],
        most_equations: 1,
        window: 1000,
        samples: 1,
        boxes,
        effort: 1,
        data,
    };
    let table = ErrorTable::measure(view, &settings).expect("intervals need no sampling");
    let row = table.outputs.into_iter().next();
    row.and_then(|row| row.interval).expect("it was asked for")
}

#[test]
fn bounds_are_near_published_ones_and_above_errors_seen() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/examples/rounding/benchmarks.fpcore"
    );
    let text = std::fs::read_to_string(path).expect("it ships");
    for (name, theirs) in THEIRS {
        for data in [GivenData::Held, GivenData::Real] {
            let row = bounded(&text, name, data, 20_000);
            assert_eq!((row.ranges, row.share), ("given", 1.0), "{name}");
            assert!(row.error <= 1.1 * theirs, "{name} {data:?}: {row:?}");
            assert!(row.seen <= row.error && row.at_a_state <= row.error);
            // The bound is not far from what happens, at random states only.
            let far = if name == "dqmom9" { 40.0 } else { 4.0 };
            assert!(row.error <= far * row.seen, "{name} {data:?}: {row:?}");
            assert!(
                row.error <= 2.0 * row.at_a_state,
                "{name} {data:?}: {row:?}"
            );
            // More boxes give no larger bound, and one box a larger one.
            let few = bounded(&text, name, data, 1);
            assert!(few.error >= row.error && few.boxes == 1, "{name}");
        }
    }
}

#[test]
fn a_pole_leaves_the_rest_of_the_ranges() {
    let text = "(FPCore pole (x) :pre (<= -1 x 3) (/ 1 x))";
    let row = bounded(text, "pole", GivenData::Held, 200);
    assert!(row.error.is_infinite() && row.finite.is_finite());
    assert!(row.share > 0.95 && row.share < 1.0, "{row:?}");
}
