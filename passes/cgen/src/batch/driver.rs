//! The functions that callers call.

use super::turn::{TurnedPlaces, has_blocks, turned_block};
use super::writer::{BatchWriter, List};
use crate::emit::arrays::{extent, place};
use robovec_ir::{Array, OperandKind, Shape};
use std::collections::BTreeSet;
use std::fmt::Write;

/// The declarations of the header: what is returned, name, parameters.
pub(super) fn signatures(writer: &BatchWriter<'_>) -> [(&'static str, String, String); 4] {
    let name = &writer.names.function;
    let all = all_list(writer, List::Parameters);
    let many = match all.is_empty() {
        true => "long states".to_owned(),
        false => format!("long states, {all}"),
    };
    [
        (
            "void",
            format!("{name}_prepare"),
            prepare_list(writer, List::Parameters),
        ),
        (
            "void",
            format!("{name}_batch"),
            batch_list(writer, List::Parameters),
        ),
        ("int", format!("{name}_many"), many.clone()),
        ("int", format!("{name}_states"), many),
    ]
}

/// The shared inputs and what is prepared from them.
pub(super) fn prepare_list(writer: &BatchWriter<'_>, list: List) -> String {
    let real = writer.options.real.name();
    let mut items = Vec::new();
    for (index, name) in writer.names.inputs.iter().enumerate() {
        if writer.plan.shared[index] {
            let array = &writer.function().inputs()[index];
            items.push(item(list, &shared_type(array, real), name));
        }
    }
    items.push(item(list, &format!("{real} *"), "prepared"));
    items.join(", ")
}

/// The other inputs, what was prepared, and the outputs.
pub(super) fn batch_list(writer: &BatchWriter<'_>, list: List) -> String {
    let real = writer.options.real.name();
    let mut items = Vec::new();
    for (name, shared) in writer.names.inputs.iter().zip(&writer.plan.shared) {
        if !shared {
            items.push(item(list, &format!("const {real} *"), name));
        }
    }
    items.push(item(list, &format!("const {real} *"), "prepared"));
    for name in &writer.names.outputs {
        items.push(item(list, &format!("{real} *"), name));
    }
    items.join(", ")
}

/// All arrays in order of declaration.
fn all_list(writer: &BatchWriter<'_>, list: List) -> String {
    let real = writer.options.real.name();
    let mut items = Vec::new();
    for (index, name) in writer.names.inputs.iter().enumerate() {
        let array = &writer.function().inputs()[index];
        let declared = match writer.plan.shared[index] {
            true => shared_type(array, real),
            false => format!("const {real} *"),
        };
        items.push(item(list, &declared, name));
    }
    for name in &writer.names.outputs {
        items.push(item(list, &format!("{real} *"), name));
    }
    items.join(", ")
}

fn item(list: List, declared: &str, name: &str) -> String {
    match list {
        List::Parameters => format!("{declared}{name}"),
        List::Arguments => name.to_owned(),
    }
}

/// The type of a parameter that all states share.
fn shared_type(array: &Array, real: &str) -> String {
    match array.shape {
        Shape::Scalar => format!("{real} "),
        Shape::Vector(_) | Shape::Matrix(..) => format!("const {real} *"),
    }
}

/// An array that differs from state to state.
struct Varying<'a> {
    name: &'a str,
    input: bool,
    extent: u64,
    /// First element and length of the stretches that are read or set.
    spans: Vec<(u64, u64)>,
    /// The start of its runs in the memory of a copied batch.
    offset: u64,
}

/// The definitions of what [`signatures`] declares, but for the first.
pub(super) fn functions(writer: &BatchWriter<'_>) -> String {
    let arrays = varying(writer);
    let mut text = batch(writer);
    if !arrays.is_empty() {
        copies(&mut text, writer, &arrays);
    }
    many(&mut text, writer, &arrays);
    states(&mut text, writer, &arrays);
    text
}

/// The arrays of states, with the elements that the function touches.
fn varying<'a>(writer: &'a BatchWriter<'a>) -> Vec<Varying<'a>> {
    let function = writer.function();
    let mut read: Vec<BTreeSet<u64>> = vec![BTreeSet::new(); function.inputs().len()];
    let mut set: Vec<BTreeSet<u64>> = vec![BTreeSet::new(); function.outputs().len()];
    let reads = function.nodes().iter().flat_map(|node| node.operands());
    let outputs = function.assignments.iter().map(|a| &a.operand);
    for operand in reads.chain(outputs) {
        if let OperandKind::Input(input) = operand.kind() {
            let index = function.input_array(input);
            let array = &function.inputs()[index];
            read[index].insert(place(array, input.0 - array.offset));
        }
    }
    for assignment in &function.assignments {
        let (array, _, _) = function.output_element(assignment.output);
        let element = place(array, assignment.output.0 - array.offset);
        set[function.output_array(assignment.output)].insert(element);
    }
    let mut arrays = Vec::new();
    let mut offset = 0;
    let mut add = |name: &'a str, input: bool, array: &Array, touched: &BTreeSet<u64>| {
        arrays.push(Varying {
            name,
            input,
            extent: extent(array),
            spans: spans(touched),
            offset,
        });
        offset += extent(array);
    };
    for (index, array) in function.inputs().iter().enumerate() {
        if !writer.plan.shared[index] {
            add(&writer.names.inputs[index], true, array, &read[index]);
        }
    }
    for (index, array) in function.outputs().iter().enumerate() {
        add(&writer.names.outputs[index], false, array, &set[index]);
    }
    arrays
}

/// Stretches of consecutive numbers.
fn spans(numbers: &BTreeSet<u64>) -> Vec<(u64, u64)> {
    let mut spans: Vec<(u64, u64)> = Vec::new();
    for &number in numbers {
        match spans.last_mut() {
            Some((first, length)) if *first + *length == number => *length += 1,
            _ => spans.push((number, 1)),
        }
    }
    spans
}

/// One batch in place.
fn batch(writer: &BatchWriter<'_>) -> String {
    let name = &writer.names.function;
    let parameters = batch_list(writer, List::Parameters);
    let whole = batch_list(writer, List::Arguments);
    if writer.options.lanes == 1 {
        return format!("void {name}_batch({parameters})\n{{\n    {name}_lanes({whole});\n}}\n\n");
    }
    let moved: Vec<String> = whole
        .split(", ")
        .map(|word| match word {
            "prepared" => word.to_owned(),
            _ => format!("{word} + lane"),
        })
        .collect();
    format!(
        "void {name}_batch({parameters})\n{{\n#if {width} == {lanes}\n    {name}_lanes({whole});\n\
         #else\n    for (int lane = 0; lane < {lanes}; lane += {width} + !{width})\n        \
         {name}_lanes({moved});\n#endif\n}}\n\n",
        width = writer.width(),
        lanes = writer.options.lanes,
        moved = moved.join(", "),
    )
}

/// The function that makes runs of states.
fn gather(name: &str, real: &str, lanes: u32) -> String {
    let places = TurnedPlaces {
        from: ("lane * next + i".to_owned(), "next".to_owned()),
        to: (format!("i * {lanes} + lane"), lanes.to_string()),
    };
    let blocks = places.lines(name, lanes);
    format!(
        "/* Some elements of the first states, `step` numbers from element to element and
   `next` from state to state, into runs; missing lanes repeat the last state. */
static void {name}_gather(long count, const {real} *from, long step, long next,
    const int (*spans)[2], long number, {real} *to)
{{
{blocks}    for (long lane = 0; lane < {lanes}; lane++) {{
        const {real} *own = from + (lane < count ? lane : count - 1) * next;
        for (long span = 0; span < number; span++)
            for (long i = spans[span][0]; i < spans[span][0] + spans[span][1]; i++)
                to[i * {lanes} + lane] = own[i * step];
    }}
}}

"
    )
}

/// The function that makes states of runs.
fn scatter(name: &str, real: &str, lanes: u32) -> String {
    let places = TurnedPlaces {
        from: (format!("i * {lanes} + lane"), lanes.to_string()),
        to: ("lane * next + i".to_owned(), "next".to_owned()),
    };
    let blocks = places.lines(name, lanes);
    format!(
        "/* Runs into some elements of the first states, without the missing lanes. */
static void {name}_scatter(long count, {real} *to, long step, long next,
    const int (*spans)[2], long number, const {real} *from)
{{
{blocks}    for (long lane = 0; lane < count; lane++) {{
        {real} *own = to + lane * next;
        for (long span = 0; span < number; span++)
            for (long i = spans[span][0]; i < spans[span][0] + spans[span][1]; i++)
                own[i * step] = from[i * {lanes} + lane];
    }}
}}

"
    )
}

/// Copies of a batch whose lanes are not together, or not all there.
fn copies(text: &mut String, writer: &BatchWriter<'_>, arrays: &[Varying<'_>]) {
    let name = &writer.names.function;
    let real = writer.options.real.name();
    let lanes = writer.options.lanes;
    let touched = |input: bool| {
        let mut arrays = arrays.iter();
        arrays.any(|array| array.input == input && !array.spans.is_empty())
    };
    if has_blocks(lanes) && (touched(true) || touched(false)) {
        text.push_str(&turned_block(name, writer.options.real));
    }
    if touched(true) {
        text.push_str(&gather(name, real, lanes));
    }
    if touched(false) {
        text.push_str(&scatter(name, real, lanes));
    }
    let _ = write!(
        text,
        "/* A batch of `count` states that is copied: of arrays of runs, or of states. */
static void {name}_copied(long count, int runs, {real} *memory, {})
{{
",
        batch_list(writer, List::Parameters)
    );
    if !touched(true) && !touched(false) {
        *text += "    (void)count;\n    (void)runs;\n";
    }
    for (index, array) in arrays.iter().enumerate() {
        if !array.spans.is_empty() {
            let list = array.spans.iter();
            let list: Vec<String> = list.map(|(a, b)| format!("{{{a}, {b}}}")).collect();
            let list = list.join(", ");
            let _ = writeln!(
                text,
                "    static const int spans_{index}[][2] = {{{list}}};"
            );
        }
    }
    for input in [true, false] {
        for (index, array) in arrays.iter().enumerate() {
            let Varying { name: own, .. } = array;
            if array.spans.is_empty() && array.input == input {
                let _ = writeln!(text, "    (void){own};");
            } else if array.input == input {
                let way = if input { "gather" } else { "scatter" };
                let _ = writeln!(
                    text,
                    "    {name}_{way}(count, {own}, runs ? {lanes} : 1, runs ? 1 : {}, spans_{index}, {}, memory + {});",
                    array.extent,
                    array.spans.len(),
                    array.offset * u64::from(lanes)
                );
            }
        }
        if input {
            let arguments = arguments(arrays, |array| {
                format!("memory + {}", array.offset * u64::from(lanes))
            });
            let _ = writeln!(text, "    {name}_batch({arguments});");
        }
    }
    *text += "}\n\n";
}

/// Arguments of a batch.
fn arguments(arrays: &[Varying<'_>], argument: impl Fn(&Varying<'_>) -> String) -> String {
    let inputs = arrays.iter().filter(|array| array.input).map(&argument);
    let outputs = arrays.iter().filter(|array| !array.input).map(&argument);
    let prepared = ["prepared".to_owned()];
    let all: Vec<String> = inputs.chain(prepared).chain(outputs).collect();
    all.join(", ")
}

/// The head that both drivers share.
fn head(text: &mut String, writer: &BatchWriter<'_>, own: &str, parameters: &str) {
    let name = &writer.names.function;
    let real = writer.options.real.name();
    let _ = write!(
        text,
        "int {own}({parameters})\n{{\n    {real} prepared[{name}_PREPARED];\n    {name}_prepare({});\n",
        prepare_list(writer, List::Arguments)
    );
}

/// Many states in arrays of runs.
fn many(text: &mut String, writer: &BatchWriter<'_>, arrays: &[Varying<'_>]) {
    let [_, _, (_, own, parameters), _] = signatures(writer);
    let name = &writer.names.function;
    let lanes = writer.options.lanes;
    head(text, writer, &own, &parameters);
    let whole = arguments(arrays, |array| {
        format!(
            "{} + batch * {}",
            array.name,
            array.extent * u64::from(lanes)
        )
    });
    let _ = write!(
        text,
        "    const long batches = states / {lanes};\n#ifdef _OPENMP\n#pragma omp parallel for\n#endif\n    \
         for (long batch = 0; batch < batches; batch++)\n        {name}_batch({whole});\n"
    );
    if lanes > 1 && !arrays.is_empty() {
        let rest = arguments(arrays, |array| {
            format!(
                "{} + batches * {}",
                array.name,
                array.extent * u64::from(lanes)
            )
        });
        let _ = write!(
            text,
            "    const long rest = states - batches * {lanes};\n    if (rest > 0) {{\n        \
             {real} *memory = malloc({size} * sizeof({real}));\n        if (!memory)\n            return -1;\n        \
             {name}_copied(rest, 1, memory, {rest});\n        free(memory);\n    }}\n",
            real = writer.options.real.name(),
            size = memory(arrays) * u64::from(lanes),
        );
    }
    *text += "    return 0;\n}\n\n";
}

/// Many states one after the other.
fn states(text: &mut String, writer: &BatchWriter<'_>, arrays: &[Varying<'_>]) {
    let [_, _, _, (_, own, parameters)] = signatures(writer);
    let name = &writer.names.function;
    let (lanes, real) = (writer.options.lanes, writer.options.real.name());
    head(text, writer, &own, &parameters);
    if arrays.is_empty() {
        *text += "    (void)states;\n    return 0;\n}\n";
        return;
    }
    let scattered = arguments(arrays, |array| {
        format!("{} + first * {}", array.name, array.extent)
    });
    let _ = write!(
        text,
        "    const long batches = (states + {lanes} - 1) / {lanes};
    int failed = 0;
#ifdef _OPENMP
#pragma omp parallel reduction(| : failed)
#endif
    {{
        /* Room to begin at a multiple of 64 bytes. */
        char *memory = malloc({size} * sizeof({real}) + 64);
        failed |= !memory;
#ifdef _OPENMP
#pragma omp for
#endif
        for (long batch = 0; batch < batches; batch++) {{
            const long first = batch * {lanes};
            const long count = states - first < {lanes} ? states - first : {lanes};
            if (memory)
                {name}_copied(count, 0, ({real} *)(memory + (64 - (size_t)memory % 64)), {scattered});
        }}
        free(memory);
    }}
    return failed ? -1 : 0;
}}
",
        size = memory(arrays) * u64::from(lanes),
    );
}

/// The runs of all arrays.
fn memory(arrays: &[Varying<'_>]) -> u64 {
    arrays.iter().map(|array| array.extent).sum::<u64>().max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_stretches() {
        let numbers = BTreeSet::from([1, 2, 3, 5, 8, 9]);
        assert_eq!(spans(&numbers), [(1, 3), (5, 1), (8, 2)]);
    }
}
