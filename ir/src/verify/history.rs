//! Invariant 20: histories.

use super::{ViolationCollector, ViolationSubject};
use crate::history::{Histories, History};

pub(super) fn check(collector: &mut ViolationCollector<'_>) {
    let function = collector.view.function;
    let Some(histories) = &function.histories else {
        return;
    };
    for (what, found, count) in [
        ("nodes", histories.values.len(), function.nodes().len()),
        (
            "outputs",
            histories.outputs.len(),
            function.assignments.len(),
        ),
    ] {
        if found != count {
            let message = || format!("there are histories for {found} of {count} {what}");
            return collector.add(ViolationSubject::Function, message);
        }
    }
    for (&history, (value, node)) in histories.values.iter().zip(function.values()) {
        if node.name.is_none() && history != History::NONE {
            collector.value(value, || {
                "has a history, which belongs to its definition".to_owned()
            });
        }
        if !exists(histories, history) {
            collector.value(value, || {
                "has a history that is not in the table".to_owned()
            });
        }
    }
    for (index, &history) in histories.outputs.iter().enumerate() {
        if !exists(histories, history) {
            collector.assignment(index, || {
                "has a history that is not in the table".to_owned()
            });
        }
    }
}

fn exists(histories: &Histories, history: History) -> bool {
    let count = histories.steps().len();
    history.index().is_none_or(|index| index < count)
}
