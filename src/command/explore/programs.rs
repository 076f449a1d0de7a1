//! Explorations of programs: speed against error.

use super::{ExploreArguments, Explored, ExploredFunction, ResultFiles, each};
use crate::command::{CommandFailure, input, progress};
use robovec_explore::front::{self, FrontQuestion};
use robovec_explore::share::SharedWork;
use robovec_ir::Module;
use robovec_ir::diagnostic::counted;
use robovec_ir::states::{Ranges, States};
use robovec_present::json::json_text;
use std::sync::Arc;

/// Numbers of elements per kind, unless the user names others.
const ELEMENTS: [u32; 3] = [4, 16, 64];

pub(super) fn run(arguments: &ExploreArguments) -> Result<String, CommandFailure> {
    let angle = arguments.angle.unwrap_or(0.1);
    let bar = progress::spinner();
    let explore = |function: ExploredFunction, work: SharedWork<'_>| {
        let ExploredFunction {
            name,
            module,
            others,
            mut ranges,
            states,
            seed,
        } = function;
        let machine = match arguments.machine.first() {
            Some(machine) => input::machine(machine)?,
            None => input::machine(input::usual_machine(&module.functions[0])?)?,
        };
        add_angles(&mut ranges, &module, angle);
        let question = FrontQuestion {
            machine: &machine,
            elements: match arguments.elements.as_slice() {
                [] => &ELEMENTS,
                elements => elements,
            },
            states: &States::new(seed).within(Arc::new(ranges)),
            count: states,
            angle,
            cpu: arguments.cpu,
            work,
        };
        let progress = |choice: &str| bar.set_message(format!("{name}: {choice}"));
        let failure = |error| CommandFailure::plain(format!("{name}: {error}"));
        if arguments.shares.shard.is_some() {
            let share = front::measure_share(&module, others, &question, &progress);
            let share = share.map_err(failure)?;
            let choices = counted(share.choices, "choice");
            return Ok(Explored::Share(choices, share.found));
        }
        let front = front::front(&name, &module, others, &question, &progress);
        let front = front.map_err(failure)?;
        let text = front::text::text(&front);
        Ok(Explored::Whole(front, text))
    };
    let files = |fronts: &[_]| ResultFiles {
        table: front::text::points_table(fronts),
        data: json_text(fronts),
        figure: front::text::figure(fronts),
        page: front::page::page(fronts),
    };
    let text = each(arguments, explore, files);
    bar.finish_and_clear();
    text
}

/// Every position of which nothing is known between the same bounds.
fn add_angles(ranges: &mut Ranges, module: &Module, bound: f64) {
    for array in module.functions[0].inputs() {
        if module.tables.symbols.text(array.name) == "q" {
            for offset in 0..array.shape.len() as u32 {
                let indices = array.shape.indices(offset).0;
                if ranges.get("q", indices).is_none() {
                    ranges.set("q", indices, -bound, bound);
                }
            }
        }
    }
}
