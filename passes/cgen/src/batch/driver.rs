//! The functions that callers call.

use super::writer::BatchWriter;
use crate::emit::Real;
use crate::emit::arrays::{extent, place};
use crate::emit::frame::ParameterList;
use robovec_ir::{Array, Operand};
use std::collections::BTreeSet;
use std::fmt::{Display, Write};

/// The declarations of the header: result type, name, parameters.
pub(super) fn signatures(writer: &BatchWriter<'_>) -> [(&'static str, String, String); 4] {
    let own = |own: &str| format!("{}_{own}", writer.names.function);
    let mut all = ParameterList::default();
    all.add("long ", "states");
    writer.add_inputs(&mut all, &[true, false], "");
    writer.add_outputs(&mut all, "");
    let all = all.declared();
    [
        ("void", own("prepare"), writer.prepare_list().declared()),
        ("void", own("batch"), writer.batch_list().declared()),
        ("int", own("many"), all.clone()),
        ("int", own("states"), all),
    ]
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

/// The definitions of the functions that [`signatures`] declares, except for
/// the first.
pub(super) fn functions(writer: &BatchWriter<'_>) -> String {
    let arrays = varying(writer);
    let mut text = batch(writer);
    if !arrays.is_empty() {
        copies(&mut text, writer, &arrays);
    }
    text + &many(writer, &arrays) + &states(writer, &arrays)
}

/// The arrays of states, with the elements that the function touches.
fn varying<'a>(writer: &'a BatchWriter<'a>) -> Vec<Varying<'a>> {
    let function = writer.function();
    let mut read: Vec<BTreeSet<u64>> = vec![BTreeSet::new(); function.inputs().len()];
    let mut set: Vec<BTreeSet<u64>> = vec![BTreeSet::new(); function.outputs().len()];
    for input in function.reads().filter_map(Operand::input) {
        let index = function.input_array(input);
        let array = &function.inputs()[index];
        read[index].insert(place(array, input.0 - array.offset));
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
    let list = writer.batch_list();
    let lane = |name| match name {
        "prepared" => name.to_owned(),
        _ => format!("{name} + lane"),
    };
    let moved: Vec<String> = list.names().map(lane).collect();
    let body = match writer.options.lanes {
        1 => "    @name@_lanes(@whole@);\n",
        _ => {
            "\
#if @width@ == @lanes@
    @name@_lanes(@whole@);
#else
    for (int lane = 0; lane < @lanes@; lane += @width@ + !@width@)
        @name@_lanes(@moved@);
#endif
"
        }
    };
    writer.fill(
        &format!("void @name@_batch(@parameters@)\n{{\n{body}}}\n\n"),
        &[
            ("parameters", &list.declared()),
            ("whole", &list.arguments()),
            ("moved", &moved.join(", ")),
        ],
    )
}

/// The function that makes runs of states, or states of runs. A full batch
/// whose elements are side by side is copied in blocks: a number at a time
/// takes a load and a store for each, a block of registers takes one of both
/// for a row, and shuffles between them.
fn copy(writer: &BatchWriter<'_>, is_gather: bool) -> String {
    let lanes = writer.options.lanes;
    // Place of element `i` of state `lane`, and the distance of rows.
    let states = ("lane * next + i".to_owned(), "next".to_owned());
    let runs = (format!("i * {lanes} + lane"), lanes.to_string());
    let (template, (from, next), (to, step)) = if is_gather {
        (include_str!("gather.c"), states, runs)
    } else {
        (include_str!("scatter.c"), runs, states)
    };
    let blocks = if has_blocks(lanes) {
        writer.fill(
            include_str!("blocks.c"),
            &[
                ("from", &from),
                ("next", &next),
                ("to", &to),
                ("step", &step),
            ],
        )
    } else {
        String::new()
    };
    writer.fill(template, &[("blocks", &blocks)]) + "\n"
}

/// True when a batch of this number of lanes can be turned in blocks.
fn has_blocks(lanes: u32) -> bool {
    lanes.is_multiple_of(4)
}

/// The function that turns one square block of `ROBOVEC_BLOCK` rows, which is
/// 0 where compilers know no vectors.
fn turned_block(writer: &BatchWriter<'_>) -> String {
    let (wide, integer, condition) = match writer.options.real {
        Real::Double => (2, "long long", "defined(__AVX__)"),
        Real::Float => (4, "int", "1"),
    };
    let words: [(&str, &dyn Display); 3] = [
        ("wide", &wide),
        ("integer", &integer),
        ("condition", &condition),
    ];
    writer.fill(include_str!("turn.c"), &words) + "\n"
}

/// Copies of a batch whose lanes are not contiguous, or that is not full.
fn copies(text: &mut String, writer: &BatchWriter<'_>, arrays: &[Varying<'_>]) {
    let name = &writer.names.function;
    let lanes = u64::from(writer.options.lanes);
    let touched = |input: bool| {
        let mut arrays = arrays.iter();
        arrays.any(|array| array.input == input && !array.spans.is_empty())
    };
    let (gathers, scatters) = (touched(true), touched(false));
    if has_blocks(writer.options.lanes) && (gathers || scatters) {
        *text += &turned_block(writer);
    }
    if gathers {
        *text += &copy(writer, true);
    }
    if scatters {
        *text += &copy(writer, false);
    }
    let (mut lists, mut inputs, mut outputs) = (String::new(), String::new(), String::new());
    if !gathers && !scatters {
        lists += "    (void)count;\n    (void)runs;\n";
    }
    for (index, array) in arrays.iter().enumerate() {
        let Varying {
            name: own,
            input,
            extent,
            ref spans,
            offset,
        } = *array;
        let (way, copied) = if input {
            ("gather", &mut inputs)
        } else {
            ("scatter", &mut outputs)
        };
        if spans.is_empty() {
            let _ = writeln!(copied, "    (void){own};");
            continue;
        }
        let list: Vec<String> = spans.iter().map(|(a, b)| format!("{{{a}, {b}}}")).collect();
        let list = list.join(", ");
        let _ = writeln!(
            lists,
            "    static const int spans_{index}[][2] = {{{list}}};"
        );
        let (number, place) = (spans.len(), offset * lanes);
        let _ = writeln!(
            copied,
            "    {name}_{way}(count, {own}, runs ? {lanes} : 1, runs ? 1 : {extent}, \
             spans_{index}, {number}, memory + {place});",
        );
    }
    let arguments = arguments(arrays, |array| format!("memory + {}", array.offset * lanes));
    *text += &writer.fill(
        "/* A batch of `count` states that is copied: of arrays of runs, or of states. */
static void @name@_copied(long count, int runs, @real@ *memory, @parameters@)
{
@lists@@inputs@    @name@_batch(@arguments@);
@outputs@}

",
        &[
            ("parameters", &writer.batch_list().declared()),
            ("lists", &lists),
            ("inputs", &inputs),
            ("arguments", &arguments),
            ("outputs", &outputs),
        ],
    );
}

fn arguments(arrays: &[Varying<'_>], argument: impl Fn(&Varying<'_>) -> String) -> String {
    let inputs = arrays.iter().filter(|array| array.input).map(&argument);
    let outputs = arrays.iter().filter(|array| !array.input).map(&argument);
    let prepared = ["prepared".to_owned()];
    let all: Vec<String> = inputs.chain(prepared).chain(outputs).collect();
    all.join(", ")
}

/// A driver: the common part, and its own lines.
fn driver(
    writer: &BatchWriter<'_>,
    (returns, own, parameters): &(&str, String, String),
    lines: &str,
    words: &[(&str, &dyn Display)],
) -> String {
    let head = format!(
        "{returns} {own}({parameters})\n{{\n    @real@ prepared[@name@_PREPARED];\n    \
         @name@_prepare({});\n{lines}",
        writer.prepare_list().arguments()
    );
    writer.fill(&head, words)
}

/// Many states in arrays of runs.
fn many(writer: &BatchWriter<'_>, arrays: &[Varying<'_>]) -> String {
    let lanes = u64::from(writer.options.lanes);
    let moved = |by: &str| {
        arguments(arrays, |array| {
            format!("{} + {by} * {}", array.name, array.extent * lanes)
        })
    };
    let rest = if lanes > 1 && !arrays.is_empty() {
        "    const long rest = states - batches * @lanes@;
    if (rest > 0) {
        @real@ *memory = malloc(@size@ * sizeof(@real@));
        if (!memory)
            return -1;
        @name@_copied(rest, 1, memory, @last@);
        free(memory);
    }
"
    } else {
        ""
    };
    let lines = "    const long batches = states / @lanes@;
#ifdef _OPENMP
#pragma omp parallel for
#endif
    for (long batch = 0; batch < batches; batch++)
        @name@_batch(@whole@);
";
    driver(
        writer,
        &signatures(writer)[2],
        &format!("{lines}{rest}    return 0;\n}}\n\n"),
        &[
            ("whole", &moved("batch")),
            ("last", &moved("batches")),
            ("size", &(memory(arrays) * lanes)),
        ],
    )
}

/// Many states one after the other.
fn states(writer: &BatchWriter<'_>, arrays: &[Varying<'_>]) -> String {
    let lines = if arrays.is_empty() {
        "    (void)states;\n    return 0;\n}\n"
    } else {
        include_str!("states.c")
    };
    let scattered = arguments(arrays, |array| {
        format!("{} + first * {}", array.name, array.extent)
    });
    let size = memory(arrays) * u64::from(writer.options.lanes);
    driver(
        writer,
        &signatures(writer)[3],
        lines,
        &[("scattered", &scattered), ("size", &size)],
    )
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
