//! The names in a file of batch code.

use crate::emit::names::CNames;
use robovec_ir::View;

/// The names of generated text, and those that compilers define.
const OWN: [&str; 26] = [
    "true", "false", "IN", "OUT", "work", "sines", "cosines", "angles", "prepared", "states",
    "lane", "lanes", "batch", "batches", "first", "rest", "gather", "scatter", "memory", "malloc",
    "free", "from", "to", "linux", "unix", "i386",
];

/// The names in a generated file.
pub(super) struct BatchNames {
    /// The name of the function; all defined names begin with it.
    pub(super) function: String,
    /// Input arrays, in order.
    pub(super) inputs: Vec<String>,
    /// Output arrays, in order.
    pub(super) outputs: Vec<String>,
    /// For each node its variable.
    pub(super) values: Vec<String>,
}

impl BatchNames {
    pub(super) fn new(view: View<'_>) -> BatchNames {
        let mut taken = CNames::beside(&OWN);
        let function = taken.take(&view.function.name);
        let inputs = taken.take_arrays(view, view.function.inputs());
        let outputs = taken.take_arrays(view, view.function.outputs());
        let values = view.function.values();
        let values = values.map(|(value, _)| taken.take_value(view, value));
        let values = values.collect();
        BatchNames {
            function,
            inputs,
            outputs,
            values,
        }
    }
}
