//! Invariants 11 and 13: earliest and latest times.

use super::{ViolationCollector, ViolationSubject};
use crate::entity::Value;
use crate::function::{Level, Timing};

pub(super) fn check(collector: &mut ViolationCollector<'_>) {
    let function = collector.view.function;
    let Some(timing) = &function.timing else {
        return;
    };
    if function.level == Level::Equations {
        let message = || "a function of the level equations has no times".to_owned();
        return collector.add(ViolationSubject::Function, message);
    }
    let count = function.nodes().len();
    if timing.len() != count {
        let message = || format!("there are times for {} of {count} nodes", timing.len());
        return collector.add(ViolationSubject::Function, message);
    }
    for (value, node) in function.values() {
        let own = timing[value.index()];
        if own.asap > own.alap || own.asap_cycle > own.alap_cycle {
            collector.value(value, || "has an earliest time after its latest".to_owned());
        }
        // Sine and cosine come from the host and take no time.
        let least = u32::from(!node.operation.is_trigonometric());
        for operand in node.operands().iter().filter_map(|operand| operand.value()) {
            if !follows(own, timing[operand.index()], least) {
                contradiction(collector, value, operand);
            }
        }
    }
}

/// True when each of the times comes after that of the operand.
fn follows(own: Timing, operand: Timing, least: u32) -> bool {
    let after = |own: u32, operand: u32| operand.checked_add(least).is_some_and(|end| own >= end);
    after(own.asap, operand.asap)
        && after(own.alap, operand.alap)
        && after(own.asap_cycle, operand.asap_cycle)
        && after(own.alap_cycle, operand.alap_cycle)
}

fn contradiction(collector: &mut ViolationCollector<'_>, value: Value, operand: Value) {
    let view = collector.view;
    collector.value(value, || {
        let operand = super::describe(view, operand);
        format!("has a time that does not come after that of {operand}, which it reads")
    });
}
