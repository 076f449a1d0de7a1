//! The names of operations, for messages about a wrong result.

use super::TestBench;
use robovec_ir::Value;
use robovec_ir::print::print_definition;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Places of an operation's equations that are reported.
const MAX_PLACES: usize = 4;
/// Characters of a definition that are reported; the bench in Verilog reads lines
/// of 500.
const MAX_CHARACTERS: usize = 280;

/// The text of `operations.txt`: for every result a line with its element,
/// its cycles, the operation, and the places of its equations.
pub(super) fn operations(bench: &TestBench<'_>) -> String {
    let issued = issues(bench);
    let mut text = String::new();
    for result in bench.runs.iter().take(1).flat_map(|run| &run.results) {
        let elements = &bench.manifest.elements;
        let name = elements.get(result.element as usize);
        let name = name.map_or("?", |element| element.name.as_str());
        // Writing to a string cannot fail, here and below.
        let _ = write!(text, "{name}, on its bus in cycle {}", result.cycle);
        match issued.get(&(result.cycle, result.element)) {
            Some(&(value, cycle)) => {
                let _ = write!(text, ", issued in {cycle}: ");
                describe(bench, value, &mut text);
            }
            None => text.push_str(": no operation of the schedule"),
        }
        text.push('\n');
    }
    text
}

/// The operation and its cycle for every cycle and element in which the
/// schedule has a result.
fn issues(bench: &TestBench<'_>) -> BTreeMap<(u32, u32), (Value, u32)> {
    let function = bench.view.function;
    let Some(schedule) = &function.schedule else {
        return BTreeMap::new();
    };
    // The latency of each element from its kind.
    let stages: Vec<u32> = schedule
        .kinds
        .iter()
        .flat_map(|kind| {
            let mut known = bench.machine.elements.iter();
            let found = known.find(|element| element.kind == kind.name);
            let stages = found.map_or(0, |element| element.stages);
            (0..kind.count).map(move |_| stages)
        })
        .collect();
    function
        .values()
        .zip(&schedule.slots)
        .filter_map(|((value, _), slot)| {
            let slot = (*slot)?;
            let stages = stages.get(slot.element.index())?;
            let cycle = slot.cycle.checked_add(stages + 1)?;
            Some(((cycle, slot.element.number()), (value, slot.cycle)))
        })
        .collect()
}

fn describe(bench: &TestBench<'_>, value: Value, text: &mut String) {
    let view = bench.view;
    let definition = print_definition(view, value);
    // Placement and sources follow the definition; the former is known.
    let definition = definition.lines().next().unwrap_or_default();
    text.extend(definition.chars().take(MAX_CHARACTERS));
    let sources = &view.tables.sources;
    let places = sources.places(view.function.node(value).sources);
    let count = places.len();
    for (number, place) in places.take(MAX_PLACES).enumerate() {
        let before = if number == 0 { "; from" } else { "," };
        let file = sources.files.get(place.file as usize);
        let file = file.map_or("?", String::as_str);
        let _ = write!(text, "{before} {file} line {}", place.line);
    }
    if count > MAX_PLACES {
        let _ = write!(text, " and {} more", count - MAX_PLACES);
    }
}
