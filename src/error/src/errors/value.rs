//! The error of one value or output, for `--explain`.

use super::heat::{Heat, blame, blame_of};
use super::view::{place, small};
use robovec_analysis::adjoint::{AdjointRun, Tape};
use robovec_framework::trail::TrackedItem;
use robovec_ir::diagnostic::counted;
use robovec_ir::states::States;
use robovec_ir::{Format, View};
use robovec_present::number::percent;
use std::fmt::Write;

/// Number of equations named as the origin of an output's error.
const MOST: usize = 5;

/// Effect of rounding on a value or an output: its error in the first state,
/// its bound, the part that its operation adds, and its share in the errors of
/// the outputs; `None` when the function has no such value.
pub fn explain(
    view: View<'_>,
    item: TrackedItem,
    format: Format,
    states: &States,
) -> Option<String> {
    let function = view.function;
    let tape = Tape::new(function);
    let (slot, output) = match item {
        TrackedItem::Value(name) => {
            let mut nodes = function.nodes().iter();
            (nodes.position(|node| node.name == name)?, None)
        }
        TrackedItem::Output(output) => {
            let mut assignments = function.assignments.iter();
            let place = assignments.position(|assignment| assignment.output == output)?;
            (tape.output_slot(place), Some(place))
        }
    };
    let run = AdjointRun::of(function, &tape, format, &states.draw(view, 0));
    // One slot was asked for.
    let error = run.slots(&[slot]).into_iter().next()?;
    let mut text = format!(
        "rounding in {format}, at state 0 of seed {}\n",
        states.seed()
    );
    let _ = writeln!(
        text,
        "    {:.6e}, with an error of {}, at most {}",
        error.exact,
        small(error.actual),
        small(error.bound)
    );
    match output {
        None => {
            let (lost, most) = (run.local_errors()[slot], run.local_bounds()[slot]);
            let _ = writeln!(
                text,
                "    its last operation adds {}, and at most {}",
                small(lost),
                small(most)
            );
            let (blame, count, outputs) = blame(view, &tape, format, states);
            let share = percent(blame.share(slot));
            let _ = writeln!(
                text,
                "    that is {share} of the errors of {}, over {}",
                counted(outputs, "output"),
                counted(count, "state")
            );
        }
        Some(output) => {
            let blame = blame_of(view, &tape, format, states, 0..1, &[output], 1);
            let about = (states.seed(), 1, 1);
            let heat = Heat::new(view, &tape, format, &blame, about, MOST);
            for equation in &heat.equations {
                let name = equation.name.as_deref().unwrap_or("the output");
                let share = percent(equation.share);
                let _ = writeln!(text, "    {share} from {name} at {}", place(equation));
            }
        }
    }
    Some(text)
}
