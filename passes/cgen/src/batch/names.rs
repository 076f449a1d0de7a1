//! The names in a file of batch code.

use super::plan::BatchPlan;
use crate::emit::names::CNames;
use robovec_ir::{Array, View};

/// The names of generated text, and those that compilers define.
const OWN: [&str; 26] = [
    "true", "false", "IN", "OUT", "work", "sines", "cosines", "angles", "prepared", "states",
    "lane", "lanes", "batch", "batches", "first", "rest", "gather", "scatter", "memory", "malloc",
    "free", "from", "to", "linux", "unix", "i386",
];

/// The names in a generated file.
pub(super) struct BatchNames {
    /// The function; what is defined begins with it.
    pub(super) function: String,
    /// Input arrays, in order.
    pub(super) inputs: Vec<String>,
    /// Output arrays, in order.
    pub(super) outputs: Vec<String>,
    /// For each node its variable.
    pub(super) values: Vec<String>,
}

impl BatchNames {
    pub(super) fn new(view: View<'_>, plan: &BatchPlan) -> BatchNames {
        let symbols = &view.tables.symbols;
        let mut taken = CNames::beside(&OWN);
        let function = taken.take(&view.function.name);
        let mut arrays = |arrays: &[Array]| -> Vec<String> {
            let names = arrays.iter().map(|array| symbols.text(array.name));
            names.map(|name| taken.take(name)).collect()
        };
        let inputs = arrays(view.function.inputs());
        let outputs = arrays(view.function.outputs());
        let mut values = Vec::with_capacity(plan.uniform.len());
        for (value, node) in view.function.values() {
            values.push(match node.name.is_none() {
                true => taken.take(&format!("inner_{}", value.0)),
                false => taken.take(&node.name.display(symbols)),
            });
        }
        BatchNames {
            function,
            inputs,
            outputs,
            values,
        }
    }
}
