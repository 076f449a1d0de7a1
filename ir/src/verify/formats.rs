//! Invariant 21: formats of values.

use super::{ViolationCollector, ViolationSubject};
use crate::function::Level;

pub(super) fn check(collector: &mut ViolationCollector<'_>) {
    let function = collector.view.function;
    let Some(formats) = &function.formats else {
        return;
    };
    if function.level == Level::Equations {
        let message = || "a function of the level equations has no formats".to_owned();
        return collector.add(ViolationSubject::Function, message);
    }
    let count = function.nodes().len();
    if formats.len() != count {
        let message = || format!("there are formats for {} of {count} nodes", formats.len());
        return collector.add(ViolationSubject::Function, message);
    }
    for format in formats.table() {
        if !format.is_possible() {
            let message = || format!("no operation can be computed in the format {format}");
            collector.add(ViolationSubject::Function, message);
        }
    }
}
