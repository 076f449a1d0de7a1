//! Invariants 1, 2, 5 and 7: words, arrays, constants, user calls.

use super::{ViolationCollector, ViolationSubject};
use crate::entity::Constant;
use crate::function::{Array, MAX_INPUT_ELEMENTS, MAX_OUTPUT_ELEMENTS};
use crate::symbol::is_word;
use hashbrown::HashSet;
use robovec_num::trigonometry::host;
use rustc_hash::FxBuildHasher;

pub(super) fn check(collector: &mut ViolationCollector<'_>) {
    let function = collector.view.function;
    if !is_word(&function.name) {
        let message = || format!("the name '{}' of the function is not a word", function.name);
        collector.add(ViolationSubject::Function, message);
    }
    if let Some(text) = function.metadata(host::KEY)
        && let Err(error) = text.parse::<host::Implementation>()
    {
        let message = || format!("the metadata entry '{}' is '{text}': {error}", host::KEY);
        collector.add(ViolationSubject::Function, message);
    }
    for (key, _) in &function.metadata {
        if !is_word(key) {
            let message = || format!("the key '{key}' of the metadata is not a word");
            collector.add(ViolationSubject::Function, message);
        }
    }
    arrays(
        collector,
        function.inputs(),
        ("input", MAX_INPUT_ELEMENTS),
        ViolationSubject::Input,
    );
    arrays(
        collector,
        function.outputs(),
        ("output", MAX_OUTPUT_ELEMENTS),
        ViolationSubject::Output,
    );
    for (index, &number) in function.constants().iter().enumerate() {
        if !number.is_finite() {
            let subject = ViolationSubject::Constant(Constant(index as u32));
            collector.add(subject, || format!("the constant {number} is not finite"));
        }
    }
    boundaries(collector);
}

fn arrays(
    collector: &mut ViolationCollector<'_>,
    arrays: &[Array],
    (kind, most): (&str, u64),
    subject: impl Fn(usize) -> ViolationSubject,
) {
    let symbols = &collector.view.tables.symbols;
    let mut seen: HashSet<_, FxBuildHasher> = HashSet::default();
    let mut elements = 0u64;
    for (index, array) in arrays.iter().enumerate() {
        if array.name.index() >= symbols.len() {
            collector.add(subject(index), || format!("an {kind} array has no name"));
            continue;
        }
        let name = symbols.text(array.name);
        if !is_word(name) {
            let message = || format!("the name '{name}' of an {kind} array is not a word");
            collector.add(subject(index), message);
        }
        if !seen.insert(array.name) {
            let message = || format!("there are two {kind} arrays '{name}'");
            collector.add(subject(index), message);
        }
        let before = elements;
        elements = elements.saturating_add(array.shape.len() as u64);
        if before <= most && elements > most {
            let message = || format!("the {kind} arrays have more than {most} elements");
            collector.add(subject(index), message);
        }
    }
}

fn boundaries(collector: &mut ViolationCollector<'_>) {
    let view = collector.view;
    let inputs = view.function.inputs().iter();
    let names: HashSet<&str, FxBuildHasher> = inputs
        .filter(|array| array.name.index() < view.tables.symbols.len())
        .map(|array| view.tables.symbols.text(array.name))
        .collect();
    for (index, boundary) in view.function.boundaries.iter().enumerate() {
        if let Some(result) = &boundary.result
            && !names.contains(result.as_str())
        {
            collector.add(ViolationSubject::Boundary(index), || {
                let callee = &boundary.callee;
                format!("the result '{result}' of the call of '{callee}' is not an input array")
            });
        }
    }
}
