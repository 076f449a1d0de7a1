//! Names that C accepts, each for one thing only.

use super::plan::Plan;
use hashbrown::HashSet;
use robovec_ir::{Array, View};
use rustc_hash::FxBuildHasher;

/// Words of C, functions of its library, and what generated text calls its
/// own.
const RESERVED: [&str; 70] = [
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else",
    "enum", "extern", "float", "for", "goto", "if", "inline", "int", "long", "register",
    "restrict", "return", "short", "signed", "sizeof", "static", "struct", "switch", "typedef",
    "union", "unsigned", "void", "volatile", "while", "main", "sin", "cos", "sqrt", "asm",
    "typeof", "bool", "true", "false", "INFINITY", "NAN", "NULL", "IN", "OUT", "work", "sines",
    "cosines", "angles", "prepared", "states", "lane", "lanes", "batch", "batches", "first",
    "rest", "gather", "scatter", "memory", "malloc", "free", "from", "to", "linux", "unix", "i386",
];

/// The names in a generated file.
pub(super) struct Names {
    /// The function; what is defined begins with it.
    pub(super) function: String,
    /// Input arrays, in order.
    pub(super) inputs: Vec<String>,
    /// Output arrays, in order.
    pub(super) outputs: Vec<String>,
    /// For each node its variable.
    pub(super) values: Vec<String>,
}

impl Names {
    pub(super) fn new(view: View<'_>, plan: &Plan) -> Names {
        let symbols = &view.tables.symbols;
        let mut taken = Taken::default();
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
        Names {
            function,
            inputs,
            outputs,
            values,
        }
    }
}

/// The names in use.
#[derive(Default)]
struct Taken(HashSet<String, FxBuildHasher>);

impl Taken {
    /// A name like the wanted one that nothing bears yet.
    fn take(&mut self, wanted: &str) -> String {
        let mut name: String = wanted
            .chars()
            .map(|letter| {
                if letter.is_ascii_alphanumeric() {
                    letter
                } else {
                    '_'
                }
            })
            .collect();
        if !name.starts_with(|first: char| first.is_ascii_alphabetic())
            || name.starts_with("robovec_")
        {
            name.insert_str(0, "v_");
        }
        let free = |name: &str| !self.0.contains(name) && !RESERVED.contains(&name);
        if !free(&name) {
            let numbered = (1u64..).map(|number| format!("{name}_{number}"));
            let mut numbered = numbered.filter(|name| free(name));
            name = numbered.next().unwrap_or(name);
        }
        self.0.insert(name.clone());
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_valid_and_new() {
        let mut taken = Taken::default();
        let names = ["OM16.1", "OM16_1", "work", "1a", "robovec_d8", ""].map(|n| taken.take(n));
        let expected = ["OM16_1", "OM16_1_1", "work_1", "v_1a", "v_robovec_d8", "v_"];
        assert_eq!(names, expected);
    }
}
