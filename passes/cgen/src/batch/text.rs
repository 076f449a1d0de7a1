//! The source and the header.

use super::plan::{AngleGroup, BatchItem, OperandPlace};
use super::writer::{BatchWriter, List};
use super::{comment, driver};
use crate::emit::arrays::{extent, place};
use crate::emit::expression::{BoundText, Operands, apply, lane_literal};
use crate::emit::frame::{self, APART};
use crate::emit::order::CodeStep;
use robovec_ir::{Operand, Operation, Value};
use std::fmt::Write;

impl BatchWriter<'_> {
    /// The header.
    pub(super) fn header(&self) -> String {
        let name = &self.names.function;
        let upper = name.to_ascii_uppercase();
        let mut text = comment::header(self);
        let _ = write!(
            text,
            "#ifndef ROBOVEC_{upper}_BATCH_H\n#define ROBOVEC_{upper}_BATCH_H\n\n\
             /* States of a batch, and numbers that are prepared for all. */\n\
             #define {name}_LANES {}\n#define {name}_PREPARED {}\n\n\
             /* Runs of a batch, or numbers of a state, in each array. */\n",
            self.options.lanes,
            self.plan.prepared.len().max(1)
        );
        let inputs = self.function().inputs().iter().zip(&self.names.inputs);
        let outputs = self.function().outputs().iter().zip(&self.names.outputs);
        for (array, own) in inputs.chain(outputs) {
            let _ = writeln!(text, "#define {name}_SIZE_{own} {}", extent(array));
        }
        text += "\n#ifdef __cplusplus\nextern \"C\" {\n#endif\n\n";
        for (returns, own, parameters) in driver::signatures(self) {
            let _ = write!(text, "{returns} {own}({parameters});\n\n");
        }
        text + "#ifdef __cplusplus\n}\n#endif\n\n#endif\n"
    }

    /// The source.
    pub(super) fn source(&self) -> String {
        let mut text = comment::source(self);
        let name = &self.names.function;
        let _ = write!(text, "#include \"{name}_batch.h\"\n#include <stdlib.h>\n");
        text += &self.kernel.types();
        if self.plan.angles > 0 {
            text += "\n";
            text += &self.kernel.runs();
        }
        text += "\n";
        self.macros(&mut text);
        self.root(&mut text);
        text += &self.prepared.write(
            self.function(),
            self.plan,
            &self.names,
            self.options,
            &driver::prepare_list(self, List::Parameters),
            &driver::prepare_list(self, List::Arguments),
        );
        for number in 0..self.plan.parts.len() {
            self.part(&mut text, number);
        }
        self.lanes(&mut text);
        text += &driver::functions(self);
        text
    }

    fn macros(&self, text: &mut String) {
        let (lanes, unaligned) = (self.options.lanes, self.kernel.unaligned());
        let _ = write!(
            text,
            "/* The lanes of an element of an array, whose address may be any. */\n\
             #define IN(array, element) (*(const {unaligned} *)((array) + (element) * {lanes}))\n\
             #define OUT(array, element) (*({unaligned} *)((array) + (element) * {lanes}))\n\n\
             /* Parts stay apart: compilers are fast for short functions only. */\n\
             {APART}\n"
        );
    }

    /// Square roots of all lanes, where there are any.
    fn root(&self, text: &mut String) {
        let roots = self.function().values().any(|(value, node)| {
            node.operation == Operation::Sqrt && !self.plan.uniform[value.index()]
        });
        if !roots {
            return;
        }
        let vector = self.kernel.vector();
        let root = match self.options.real {
            super::Real::Double => "sqrt",
            super::Real::Float => "sqrtf",
        };
        let _ = write!(
            text,
            "static inline void robovec_root(const {vector} *of, {vector} *root)\n{{\n"
        );
        let lanes = self.options.lanes;
        let plain = format!("    *root = {root}(*of);\n");
        if lanes == 1 {
            *text += &plain;
        } else {
            let _ = write!(
                text,
                "{guard}    for (int lane = 0; lane < {width}; lane++)\n        \
                 (*root)[lane] = {root}((*of)[lane]);\n#else\n{plain}#endif\n",
                guard = self.guard(),
                width = self.width()
            );
        }
        *text += "}\n\n";
    }

    /// Parameters or arguments of the parts: inputs that differ, outputs, and
    /// the arrays between parts.
    fn part_list(&self, list: List) -> String {
        let real = self.options.real.name();
        let vector = self.kernel.vector();
        let mut items = Vec::new();
        let mut add = |declared: String, name: &str| {
            items.push(match list {
                List::Parameters => format!("{declared}{name}"),
                List::Arguments => name.to_owned(),
            });
        };
        for (name, shared) in self.names.inputs.iter().zip(&self.plan.shared) {
            if !shared {
                add(format!("const {real} *restrict "), name);
            }
        }
        for name in &self.names.outputs {
            add(format!("{real} *restrict "), name);
        }
        if !self.plan.prepared.is_empty() {
            add(format!("const {real} *restrict "), "prepared");
        }
        if self.plan.angles > 0 {
            add(format!("const {vector} *restrict "), "sines");
            add(format!("const {vector} *restrict "), "cosines");
        }
        if self.plan.has_computed_angles() {
            add(format!("{vector} *restrict "), "angles");
        }
        add(format!("{vector} *restrict "), "work");
        items.join(", ")
    }

    fn part(&self, text: &mut String, number: usize) {
        let vector = self.kernel.vector();
        let parameters = self.part_list(List::Parameters);
        let name = format!("{}_part_{}", self.names.function, number + 1);
        let _ = write!(text, "static ROBOVEC_APART void {name}({parameters})\n{{\n");
        let body = text.len();
        let crossing = &self.plan.crossing;
        for &value in &crossing.loads[number] {
            let word = crossing
                .word(value)
                .expect("a value that is loaded has a word");
            let name = &self.names.values[value.index()];
            let _ = writeln!(text, "    const {vector} {name} = work[{word}];");
        }
        for &step in &self.plan.parts[number] {
            match step {
                CodeStep::Define(value) => self.define(text, value),
                CodeStep::Assign(index) => self.assign(text, index),
            }
        }
        let list = self.part_list(List::Arguments);
        let unused = frame::unused(list.split(", "), &[&text[body..]]);
        text.insert_str(body, &unused);
        *text += "}\n\n";
    }

    fn define(&self, text: &mut String, value: Value) {
        let vector = self.kernel.vector();
        let node = self.function().node(value);
        let name = &self.names.values[value.index()];
        let operands: Vec<BoundText> = node
            .operands()
            .iter()
            .map(|&operand| self.operand(operand))
            .collect();
        if node.operation == Operation::Sqrt {
            let _ = writeln!(
                text,
                "    {vector} {name} = {};\n    robovec_root(&{name}, &{name});",
                operands[0].text
            );
        } else {
            let real = self.options.real;
            let expression = apply(node.operation, &operands, real, Operands::Lanes).text;
            let _ = writeln!(text, "    const {vector} {name} = {expression};");
        }
        if let Some(word) = self.plan.crossing.word(value) {
            let _ = writeln!(text, "    work[{word}] = {name};");
        }
        if let Some(angle) = self.plan.angle(value) {
            let _ = writeln!(text, "    angles[{angle}] = {name};");
        }
    }

    fn assign(&self, text: &mut String, index: u32) {
        let assignment = &self.function().assignments[index as usize];
        let (array, _, _) = self.function().output_element(assignment.output);
        let name = &self.names.outputs[self.function().output_array(assignment.output)];
        let element = place(array, assignment.output.0 - array.offset);
        let operand = self.operand(assignment.operand).text;
        let spread = match self.plan.place(self.function(), assignment.operand) {
            OperandPlace::Prepared(_) | OperandPlace::Literal(_) => {
                format!("({}){{0}} + ", self.kernel.vector())
            }
            OperandPlace::Variable(_) | OperandPlace::Circular(..) | OperandPlace::Input(_) => {
                String::new()
            }
        };
        let _ = writeln!(text, "    OUT({name}, {element}) = {spread}{operand};");
    }

    fn operand(&self, operand: Operand) -> BoundText {
        let text = match self.plan.place(self.function(), operand) {
            OperandPlace::Variable(value) => self.names.values[value.index()].clone(),
            OperandPlace::Circular(Operation::Sin, angle) => format!("sines[{angle}]"),
            OperandPlace::Circular(_, angle) => format!("cosines[{angle}]"),
            OperandPlace::Prepared(place) => format!("prepared[{place}]"),
            OperandPlace::Literal(number) => return lane_literal(number, self.options.real),
            OperandPlace::Input(input) => {
                let index = self.function().input_array(input);
                let array = &self.function().inputs()[index];
                let element = place(array, input.0 - array.offset);
                format!("IN({}, {element})", self.names.inputs[index])
            }
        };
        BoundText::primary(text)
    }

    /// The function that calls kernel and parts in turn.
    fn lanes(&self, text: &mut String) {
        let name = &self.names.function;
        let vector = self.kernel.vector();
        let parameters = driver::batch_list(self, List::Parameters);
        let _ = write!(text, "static void {name}_lanes({parameters})\n{{\n");
        if self.plan.prepared.is_empty() {
            *text += "    (void)prepared;\n";
        }
        if self.plan.angles > 0 {
            let count = self.plan.angles;
            let _ = writeln!(text, "    {vector} sines[{count}], cosines[{count}];");
        }
        if self.plan.has_computed_angles() {
            let _ = writeln!(text, "    {vector} angles[{}];", self.plan.angles);
        }
        let _ = writeln!(
            text,
            "    {vector} work[{}];",
            self.plan.crossing.length.max(1)
        );
        let arguments = self.part_list(List::Arguments);
        for item in &self.plan.items {
            match item {
                BatchItem::Part(number) => {
                    let _ = writeln!(text, "    {name}_part_{}({arguments});", number + 1);
                }
                BatchItem::Circular(group) => self.circular(text, group),
            }
        }
        if self.plan.parts.is_empty() {
            let names = arguments.split(", ");
            let own = ["prepared", "sines", "cosines", "angles"];
            *text += &frame::unused(names.filter(|name| !own.contains(name)), &[]);
        }
        *text += "}\n\n";
    }

    fn circular(&self, text: &mut String, group: &AngleGroup) {
        let (first, count) = (group.first, group.angles.len());
        let function = self.function();
        let places = group.angles.iter().zip(first..).map(|(angle, number)| {
            let place = match angle.input() {
                Some(input) => {
                    let array = &function.inputs()[function.input_array(input)];
                    place(array, input.0 - array.offset)
                }
                None => u64::from(number),
            };
            place.to_string()
        });
        let places = places.collect::<Vec<_>>().join(", ");
        for (&angle, number) in group.angles.iter().zip(first..) {
            if let OperandPlace::Circular(..) = self.plan.place(function, angle) {
                let _ = writeln!(text, "    angles[{number}] = {};", self.operand(angle).text);
            }
        }
        let real = self.options.real.name();
        let (from, stride) = match group.array {
            Some(array) => (
                self.names.inputs[array].clone(),
                self.options.lanes.to_string(),
            ),
            None => (
                format!("(const {real} *)angles"),
                format!("(long)(sizeof(angles[0]) / sizeof({real}))"),
            ),
        };
        let _ = writeln!(
            text,
            "    {{\n        static const int places[] = {{{places}}};\n        \
             {}({count}, {from}, places, {stride}, sines + {first}, cosines + {first});\n    }}",
            self.kernel.runs_name()
        );
    }
}
