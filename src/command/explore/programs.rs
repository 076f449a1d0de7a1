//! Explorations of programs: speed against error.

use super::{ExploreArguments, each};
use crate::command::{CommandFailure, input};
use robovec_explore::front::{FrontQuestion, front};

/// Numbers of elements per kind, unless the user names others.
const ELEMENTS: [u32; 3] = [4, 16, 64];

pub(super) fn run(arguments: &ExploreArguments) -> Result<String, CommandFailure> {
    let angle = arguments.angle.unwrap_or(0.1);
    each(arguments, Some(angle), |function, work, progress| {
        let machine = match arguments.machine.first() {
            Some(machine) => input::machine(machine)?,
            None => input::machine(input::usual_machine(&function.module.functions[0])?)?,
        };
        let question = FrontQuestion {
            machine: &machine,
            elements: match arguments.elements.as_slice() {
                [] => &ELEMENTS,
                elements => elements,
            },
            angle,
            cpu: arguments.cpu,
            work,
        };
        Ok(front(function, &question, progress))
    })
}
