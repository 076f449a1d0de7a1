//! The text form, written.
//!
//! The text is the whole truth: reading it back gives an equal module, at
//! every level (`ir/src/parse` reads it, `docs/text-format.md` describes it).
//! Output goes through its own buffer because the formatting machinery
//! of the standard library would cost more than all passes together on a
//! function of 600,000 operations.

mod expression;
mod text;

use crate::entity::{Operand, Value};
use crate::function::{Array, Assignment, Boundary, Shape, Timing};
use crate::history::History;
use crate::module::{Module, View};
use crate::placement::{Bank, Element, Placement, Schedule, Word};
use crate::source::{SourcePlace, SourceSet};
use std::io;
use text::Text;

/// First line of every text; the number is the version of the format.
pub const HEADER: &str = "// robovec 1";

/// Writes a module in the text form.
///
/// # Errors
///
/// Passes on the errors of the writer.
pub fn write_module(module: &Module, writer: &mut dyn io::Write) -> io::Result<()> {
    let mut text = Text::new(writer);
    module_text(module, &mut text)?;
    text.finish()
}

/// A module as a string, in the text form.
pub fn print_module(module: &Module) -> String {
    printed(|text| module_text(module, text))
}

fn module_text(module: &Module, text: &mut Text<'_>) -> io::Result<()> {
    text.file_header(&module.tables);
    for function in &module.functions {
        text.push("\n");
        let view = module.tables.view(function);
        FunctionPrinter::new(view).print(text)?;
    }
    Ok(())
}

/// The text that is printed into a vector.
fn printed(print: impl FnOnce(&mut Text<'_>) -> io::Result<()>) -> String {
    let mut bytes = Vec::new();
    let mut text = Text::new(&mut bytes);
    let done = print(&mut text).and_then(|()| text.finish());
    done.expect("a vector takes every byte");
    String::from_utf8(bytes).expect("what is printed is UTF-8")
}

/// One function as its own whole text.
pub fn print_file(view: View<'_>) -> String {
    printed(|text| {
        text.file_header(view.tables);
        text.push("\n");
        FunctionPrinter::new(view).print(text)
    })
}

/// One function as a string, as written in the text of its module.
pub fn print_function(view: View<'_>) -> String {
    printed(|text| FunctionPrinter::new(view).print(text))
}

/// The definition of one value as written in the text, without indentation
/// and line end; the whole expression tree at the equations level.
pub fn print_definition(view: View<'_>, value: Value) -> String {
    printed(|text| {
        FunctionPrinter::new(view).definition(text, value);
        Ok(())
    })
}

/// An output element as written in the text (`M[1,2]`).
pub fn print_output(view: View<'_>, output: crate::Output) -> String {
    let (array, indices, rank) = view.function.output_element(output);
    printed(|text| {
        text.element(view.tables, array, &indices[..rank]);
        Ok(())
    })
}

/// An operand as written in the text (`%OM16`, `q[3]`, `0.5`); a value
/// without a name as its expression.
pub fn print_operand(view: View<'_>, operand: Operand) -> String {
    printed(|text| {
        FunctionPrinter::new(view).operand(text, operand);
        Ok(())
    })
}

struct FunctionPrinter<'a> {
    view: View<'a>,
    /// Numbers of the sets with several places, in order of first use;
    /// [`UNUSED`] for those that the function does not use, and none where a
    /// definition is printed alone.
    set_numbers: Vec<u32>,
    sets: Vec<SourceSet>,
    /// Numbers of the steps of histories; 0 for those not needed.
    steps: Vec<u32>,
    /// The name of every processing element and its length; empty where one is
    /// longer, and where a definition is printed alone.
    elements: Vec<([u8; 16], usize)>,
}

/// The number of a set of places that the function does not use.
const UNUSED: u32 = u32::MAX;

impl<'a> FunctionPrinter<'a> {
    fn new(view: View<'a>) -> FunctionPrinter<'a> {
        FunctionPrinter {
            view,
            set_numbers: Vec::new(),
            sets: Vec::new(),
            steps: Vec::new(),
            elements: Vec::new(),
        }
    }

    fn name_elements(&mut self, schedule: &Schedule) {
        let names = (0..schedule.element_count()).map(|element| {
            let (kind, number) = schedule.element_name(Element::new(element));
            let name = format!("{kind}{number}");
            let mut bytes = [0; 16];
            let place = bytes.get_mut(..name.len())?;
            place.copy_from_slice(name.as_bytes());
            Some((bytes, name.len()))
        });
        let names: Option<Vec<([u8; 16], usize)>> = names.collect();
        self.elements = names.unwrap_or_default();
    }

    fn number_sets(&mut self) {
        let function = self.view.function;
        let used = function
            .boundaries
            .iter()
            .map(|boundary| boundary.sources)
            .chain(function.nodes().iter().map(|node| node.sources))
            .chain(function.assignments.iter().map(|output| output.sources));
        let sources = &self.view.tables.sources;
        self.set_numbers = vec![UNUSED; sources.several()];
        for set in used {
            if let Some(several) = sources.number_of_several(set)
                && self.set_numbers[several] == UNUSED
            {
                self.set_numbers[several] = self.sets.len() as u32;
                self.sets.push(set);
            }
        }
    }

    fn print(mut self, text: &mut Text<'_>) -> io::Result<()> {
        self.number_sets();
        if let Some(histories) = &self.view.function.histories {
            self.steps = histories.numbers();
        }
        if let Some(schedule) = &self.view.function.schedule {
            self.name_elements(schedule);
        }
        let function = self.view.function;
        text.push("function ");
        text.push(&function.name);
        text.push(" ");
        text.push(function.level.name());
        text.push(" {");
        text.end_line()?;
        self.header(text)?;
        if function.nodes().iter().any(|node| !node.name.is_none()) {
            text.end_line()?;
        }
        for (value, node) in function.values() {
            if !node.name.is_none() {
                text.push("  ");
                self.definition(text, value);
                text.end_line()?;
            }
        }
        if !function.assignments.is_empty() {
            text.end_line()?;
        }
        for (index, assignment) in function.assignments.iter().enumerate() {
            text.push("  ");
            self.assignment(text, index, assignment);
            text.end_line()?;
        }
        text.push("}");
        text.end_line()
    }

    fn header(&self, text: &mut Text<'_>) -> io::Result<()> {
        let function = self.view.function;
        for (key, content) in &function.metadata {
            text.push("  meta ");
            text.push(key);
            text.push(" ");
            text.quoted(content);
            text.end_line()?;
        }
        for (word, arrays) in [("  in ", function.inputs()), ("  out ", function.outputs())] {
            for array in arrays {
                text.push(word);
                self.array(text, array);
                text.end_line()?;
            }
        }
        for (number, &set) in self.sets.iter().enumerate() {
            text.push("  places !");
            text.integer(number as u32);
            text.push(" =");
            for place in self.view.tables.sources.places(set) {
                text.push(" @");
                self.place(text, place);
            }
            text.end_line()?;
        }
        self.steps(text)?;
        for boundary in &function.boundaries {
            self.boundary(text, boundary);
            text.end_line()?;
        }
        if let Some(schedule) = &function.schedule {
            self.schedule(text, schedule)?;
        }
        Ok(())
    }

    fn steps(&self, text: &mut Text<'_>) -> io::Result<()> {
        let histories = self.view.function.histories.iter();
        let steps = histories.flat_map(|histories| histories.steps());
        for (step, &number) in steps.zip(&self.steps).filter(|(_, number)| **number > 0) {
            text.push("  history ");
            text.integer(number);
            text.push(" =");
            if let Some(before) = step.before.index() {
                text.push(" ");
                text.integer(self.steps[before]);
            }
            for word in std::iter::once(&step.pass).chain(&step.rules) {
                text.push(" ");
                text.quoted(word);
            }
            text.end_line()?;
        }
        Ok(())
    }

    /// The attribute of a value or output that was changed since it was read.
    fn history(&self, text: &mut Text<'_>, history: Option<&History>) {
        // A definition printed alone has no header to refer to.
        let index = history.and_then(|history| history.index());
        if let Some(&number) = index.and_then(|index| self.steps.get(index)) {
            text.push(" history ");
            text.integer(number);
        }
    }

    fn array(&self, text: &mut Text<'_>, array: &Array) {
        text.push(self.view.tables.symbols.text(array.name));
        match array.shape {
            Shape::Scalar => {}
            Shape::Vector(length) => {
                text.push("[1..");
                text.integer(length);
                text.push("]");
            }
            Shape::Matrix(rows, columns) => {
                text.push("[1..");
                text.integer(rows);
                text.push(",1..");
                text.integer(columns);
                text.push("]");
            }
        }
    }

    fn boundary(&self, text: &mut Text<'_>, boundary: &Boundary) {
        text.push("  call ");
        text.quoted(&boundary.callee);
        text.push("(");
        for (index, argument) in boundary.arguments.iter().enumerate() {
            if index > 0 {
                text.push(", ");
            }
            text.quoted(argument);
        }
        text.push(")");
        if let Some(result) = &boundary.result {
            text.push(" -> ");
            text.quoted(result);
        }
        self.sources(text, boundary.sources);
    }

    fn schedule(&self, text: &mut Text<'_>, schedule: &Schedule) -> io::Result<()> {
        text.push("  schedule ");
        text.quoted(&schedule.machine);
        if let Some(hash) = schedule.machine_hash {
            text.push(" (hash ");
            text.quoted(&hash.text());
            text.push(")");
        }
        for kind in &schedule.kinds {
            text.push(" ");
            text.push(&kind.name);
            text.push("*");
            text.integer(kind.count);
        }
        text.push(" cycles ");
        text.integer(schedule.cycles);
        text.push(" bound ");
        text.integer(schedule.lower_bound);
        text.end_line()?;
        let Some(placement) = &self.view.function.placement else {
            return Ok(());
        };
        for preload in &placement.preloads {
            text.push("  preload ");
            self.word(text, schedule, preload.word);
            text.push(" = ");
            self.operand(text, preload.operand);
            text.end_line()?;
        }
        Ok(())
    }

    fn word(&self, text: &mut Text<'_>, schedule: &Schedule, word: Word) {
        self.element_name(text, schedule, word.element);
        match word.bank {
            Bank::Unified => {}
            Bank::Left => text.push(".left"),
            Bank::Right => text.push(".right"),
        }
        text.push("[");
        text.integer(word.address.number());
        text.push("]");
    }

    fn element_name(&self, text: &mut Text<'_>, schedule: &Schedule, element: Element) {
        if let Some((bytes, length)) = self.elements.get(element.index()) {
            return text.short(bytes, *length);
        }
        let (kind, number) = schedule.element_name(element);
        text.push(kind);
        text.integer(number);
    }

    fn definition(&self, text: &mut Text<'_>, value: Value) {
        let function = self.view.function;
        let node = function.node(value);
        self.name(text, value);
        text.push(" = ");
        self.expression(text, value);
        if let Some(format) = function
            .formats
            .as_ref()
            .and_then(|formats| formats.get(value))
        {
            text.push(" as ");
            text.push(&format.to_string());
        }
        if let Some(schedule) = &function.schedule {
            text.push(" on ");
            match schedule.slots[value.index()] {
                None => text.push("host"),
                Some(slot) => {
                    self.element_name(text, schedule, slot.element);
                    text.push(" at ");
                    text.integer(slot.cycle);
                }
            }
            if let Some(placement) = &function.placement {
                self.transfers(text, schedule, placement, value);
            }
        }
        if let Some(timing) = &function.timing {
            timing_attributes(text, timing[value.index()]);
        }
        if let Some(histories) = &function.histories {
            self.history(text, histories.values.get(value.index()));
        }
        self.sources(text, node.sources);
    }

    fn transfers(
        &self,
        text: &mut Text<'_>,
        schedule: &Schedule,
        placement: &Placement,
        value: Value,
    ) {
        let reads = placement.reads[value.index()];
        for (index, read) in reads.iter().map_while(|&read| read).enumerate() {
            text.push(if index == 0 { " read " } else { " " });
            text.integer(read.number());
        }
        if let Some(word) = placement.buffers[value.index()] {
            text.push(" buffer ");
            text.integer(word.number());
        }
        for (index, write) in placement.writes_of(value).iter().enumerate() {
            text.push(if index == 0 { " write " } else { ", " });
            self.word(text, schedule, write.word);
            text.push(" at ");
            text.integer(write.cycle);
        }
    }

    fn assignment(&self, text: &mut Text<'_>, index: usize, assignment: &Assignment) {
        let function = self.view.function;
        let (array, indices, rank) = function.output_element(assignment.output);
        text.element(self.view.tables, array, &indices[..rank]);
        text.push(" = ");
        self.operand(text, assignment.operand);
        if let (Some(schedule), Some(placement)) = (&function.schedule, &function.placement)
            && let Some(word) = placement.homes[index]
        {
            text.push(" in ");
            self.word(text, schedule, word);
        }
        if let Some(histories) = &function.histories {
            self.history(text, histories.outputs.get(index));
        }
        self.sources(text, assignment.sources);
    }

    fn sources(&self, text: &mut Text<'_>, set: SourceSet) {
        let sources = &self.view.tables.sources;
        let several = sources.number_of_several(set);
        if let Some(&number) = several.and_then(|several| self.set_numbers.get(several)) {
            assert_ne!(number, UNUSED, "a function uses the sets it prints");
            text.push(" @!");
            text.integer(number);
        } else if let Some(place) = sources.first(set) {
            text.push(" @");
            self.place(text, place);
        }
    }

    fn place(&self, text: &mut Text<'_>, place: SourcePlace) {
        if place.file != 0 {
            text.integer(place.file);
            text.push("/");
        }
        text.integer(place.line);
        text.push(":");
        text.integer(place.column);
        text.push("-");
        if place.end_line != place.line {
            text.integer(place.end_line);
            text.push(":");
        }
        text.integer(place.end_column);
    }
}

fn timing_attributes(text: &mut Text<'_>, timing: Timing) {
    for (key, number) in [
        (" {asap ", timing.asap),
        (" alap ", timing.alap),
        (" asap_cycle ", timing.asap_cycle),
        (" alap_cycle ", timing.alap_cycle),
        (" mobility ", timing.mobility()),
    ] {
        text.push(key);
        text.integer(number);
    }
    text.push("}");
}
