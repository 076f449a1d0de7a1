//! No error is larger than its proved bound over boxes, and cutting boxes never
//! loses a state.

use crate::equations::{Contents, equations};
use arbitrary::{Result, Unstructured};
use robovec_analysis::adjoint::Tape;
use robovec_analysis::interval::{
    ConeWindow, GivenData, Leaves, WindowLeaves, enclose, largest_seen, subdivide,
};
use robovec_ir::states::{Ranges, States};
use robovec_ir::{Format, View};
use std::sync::Arc;

const CONTENTS: Contents = Contents {
    definitions: 8,
    divisions: true,
    hostile: false,
};

/// Bounds the errors of random equations in random ranges, and looks for
/// larger ones.
///
/// # Panics
///
/// Panics when an error is above its bound, or when a bound over boxes is above
/// that of the whole.
pub fn bounds_hold_over_boxes(data: &[u8]) {
    // Bytes that run out make a smaller case, never a failure.
    let _ = run(&mut Unstructured::new(data));
}

fn run(bytes: &mut Unstructured<'_>) -> Result<()> {
    let format = *bytes.choose(&["f64", "f32", "f16", "float(8,12,flush)", "fixed(9,20)"])?;
    let format: Format = format.parse().expect("it is one");
    let data = *bytes.choose(&[GivenData::Held, GivenData::Real])?;
    let boxes = bytes.int_in_range(1..=60)?;
    let (seed, spread) = (bytes.arbitrary()?, bytes.int_in_range(0..=12)?);
    let module = equations(bytes, CONTENTS)?;
    let (tables, function) = (&module.tables, &module.functions[0]);
    let view = View { tables, function };
    let tape = Tape::new(function);
    let states = States::new(seed);
    let mut ranges = Ranges::default();
    let drawn = states.draw(view, 0);
    let mut input = 0;
    for array in function.inputs() {
        for offset in 0..array.shape.len() as u32 {
            let (middle, width) = (drawn[input], 0.5f64.powi(spread) * drawn[input].abs());
            let (indices, _) = array.shape.indices(offset);
            let name = tables.symbols.text(array.name);
            ranges.set(name, indices, middle - width, middle + width);
            input += 1;
        }
    }
    let states = states.within(Arc::new(ranges));
    let known = Leaves::new(view, &tape, &states, 0);
    for output in 0..tape.outputs() {
        let window = ConeWindow::new(&tape, tape.output_slot(output), 1000);
        let leaves = WindowLeaves::new(&tape, &window, format, data, &known);
        let whole = enclose(&tape, &window, &leaves, &leaves.ranges);
        let found = subdivide(&tape, &window, &leaves, boxes);
        assert!(found.error <= whole.error, "{found:?}");
        assert!(found.share >= 0.0 && found.share <= 1.0 && found.finite <= found.error);
        let (seen, _) = largest_seen(&tape, &window, &leaves, &found.worst, seed, 64);
        assert!(
            seen <= found.error,
            "{seen:e} {format} {data:?} {found:?}\n{}",
            robovec_ir::print::print_module(&module)
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn no_error_is_above_its_bound() {
        cases::of_sizes(300, 3000, |bytes| {
            bounds_hold_over_boxes(bytes.bytes(bytes.len())?);
            Ok(())
        });
    }
}
