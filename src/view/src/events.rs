//! Time lines in the trace event format that Chrome and Perfetto open: the
//! compiler's own time, pass by pass, and every schedule, cycle by cycle.

use crate::report::PassRunRecord;
use robovec_analysis::critical_path::Weights;
use robovec_ir::{Machine, Module};
use serde_json::{Value, json};

/// Process number of the passes.
const COMPILER: u32 = 1;

/// The events of a run as JSON, in microseconds of processor time or cycles.
pub fn events(module: &Module, passes: &[PassRunRecord], machine: &Machine) -> String {
    let mut events = vec![name("process_name", COMPILER, 0, "robovec, processor time")];
    let mut start = 0.0;
    for pass in passes {
        let end = start + pass.cpu_s * 1e6;
        events.push(json!({
            "name": pass.name, "cat": pass.function, "ph": "X", "pid": COMPILER, "tid": 0,
            "ts": start, "dur": end - start,
            "args": { "operations": pass.operations, "path": pass.asap_cycle },
        }));
        start = end;
    }
    let weights = Weights::cycles(machine);
    for (function, process) in module.functions.iter().zip(COMPILER + 1..) {
        let Some(schedule) = &function.schedule else {
            continue;
        };
        let title = format!("{}, a cycle of {} as 1 us", function.name, schedule.machine);
        events.push(name("process_name", process, 0, &title));
        for number in 0..schedule.element_count() {
            let element = robovec_ir::placement::Element::new(number);
            let (kind, count) = schedule.element_name(element);
            events.push(name(
                "thread_name",
                process,
                number,
                &format!("{kind}{count}"),
            ));
        }
        for (value, node) in function.values() {
            let Some(slot) = schedule.slots[value.index()] else {
                continue;
            };
            // The element takes a new operation in every cycle, and each
            // stays until its result can be read.
            events.push(json!({
                "name": format!("%{}", node.name.display(&module.tables.symbols)),
                "cat": node.operation.name(), "ph": "X", "pid": process,
                "tid": slot.element.number(), "ts": slot.cycle, "dur": 1,
                "args": { "readable": slot.cycle + weights.of(node.operation) },
            }));
        }
    }
    let mut text = json!({ "displayTimeUnit": "ms", "traceEvents": events }).to_string();
    text.push('\n');
    text
}

fn name(what: &str, process: u32, thread: u32, text: &str) -> Value {
    json!({ "name": what, "ph": "M", "pid": process, "tid": thread, "args": { "name": text } })
}
