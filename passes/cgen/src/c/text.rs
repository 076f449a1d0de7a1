//! The text of a generated C function.

use super::interface::Interface;
use super::parts::{CodePart, CodePlan, CodeStatement};
use super::pattern;
use super::vectors;
use super::{Options, Real};
use crate::emit::expression::{BoundText, Operands, Tightness, apply, literal};
use crate::emit::frame::{self, APART, CLONES};
use crate::emit::names::CNames;
use crate::emit::order::CodeStep;
use crate::kind::model_name;
use robovec_ir::{Function, Operand, OperandKind, Value, View};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Writes one function.
pub(super) struct PlainWriter<'a> {
    function: &'a Function,
    pub(super) real: Real,
    is_local: bool,
    pub(super) plan: &'a CodePlan,
    interface: &'a Interface<'a>,
    parts: Vec<String>,
    /// The name of the function that computes sines.
    sines: String,
    /// The name of the work array.
    work: String,
    /// The name of the array of superwords.
    pub(super) vectors: String,
    /// For each node its variable; empty for inlined ones.
    values: Vec<String>,
    /// For each superword its variable.
    pub(super) words: Vec<String>,
}

/// The body of a part, and its variables.
#[derive(Default)]
pub(super) struct PartBody {
    pub(super) text: String,
    pointers: BTreeSet<usize>,
    /// Values fetched from the work array so far.
    fetched: BTreeSet<Value>,
    /// Superwords fetched or gathered so far.
    pub(super) fetched_words: BTreeSet<usize>,
}

impl<'a> PlainWriter<'a> {
    pub(super) fn new(
        view: View<'a>,
        options: &Options,
        interface: &'a Interface<'a>,
        plan: &'a CodePlan,
    ) -> PlainWriter<'a> {
        let function = view.function;
        let mut names = interface.names();
        let words = [
            "ROBOVEC_APART",
            "ROBOVEC_ANGLES",
            "ROBOVEC_CLONES",
            "ROBOVEC_CLONED",
        ];
        for word in words {
            names.take(word);
        }
        let name = interface.name();
        let parts = (1..=plan.parts.len())
            .map(|number| names.take(&format!("{name}_part_{number}")))
            .collect();
        let sines = names.take(&format!("{name}_sines"));
        let work = names.take("work");
        let words = &plan.superwords;
        let vectors = match words.lanes() {
            1 => String::new(),
            _ => names.take("vectors"),
        };
        let values = function
            .values()
            .map(|(value, _)| {
                if plan.is_inlined(value) || words.computing(value).is_some() {
                    String::new()
                } else {
                    names.take_value(view, value)
                }
            })
            .collect();
        let words = words.words().iter();
        let words = words
            .map(|word| match word.items[0].value() {
                Some(value) => names.take(&format!("{}_all", CNames::value(view, value))),
                None => names.take("input_all"),
            })
            .collect();
        PlainWriter {
            function,
            real: options.real,
            is_local: options.is_local,
            plan,
            interface,
            parts,
            sines,
            work,
            vectors,
            values,
            words,
        }
    }

    /// The header: one declaration.
    pub(super) fn header(&self) -> String {
        let declared = self.head() + "(" + &self.interface.parameters.declared() + ")";
        if let Some((order, outputs)) = self.interface.layouts() {
            let constants = pattern::constants(self.interface.file(), order, &outputs);
            let file = self.interface.file();
            return frame::header_for_both(&self.comment(), file, &constants, &declared);
        }
        let data = self.interface.data_header();
        frame::header(&self.comment(), self.interface.file(), data, &declared)
    }

    /// Result type and name.
    fn head(&self) -> String {
        format!("{} {}", self.interface.result(), self.interface.name())
    }

    pub(super) fn source(&self) -> String {
        let mut text = self.comment();
        self.includes(&mut text);
        let has_sines = !self.plan.slots.angles().is_empty();
        if has_sines {
            text.push('\n');
            text += &self.plan.slots.source(&self.sines, self.real.name());
        }
        if !self.plan.is_flat {
            for (number, part) in self.plan.parts.iter().enumerate() {
                self.part(&mut text, number, part);
            }
        }
        let clones = match has_sines || !self.plan.is_flat {
            true => "ROBOVEC_CLONES\n",
            // A few operations are not worth a choice.
            false => "",
        };
        let linkage = if self.is_local { "static " } else { "" };
        let returns = match self.interface.result() {
            "int" => "    return 0;\n",
            _ => "",
        };
        let (head, parameters) = (self.head(), self.interface.parameters.declared());
        let (locals, body) = (self.locals(), self.main());
        let unused = frame::unused(self.interface.parameters.names(), &body);
        let _ = write!(
            text,
            "\n{clones}{linkage}{head}({parameters})\n{{\n{locals}{unused}{body}{returns}}}\n"
        );
        text
    }

    fn includes(&self, text: &mut String) {
        let has_sines = !self.plan.slots.angles().is_empty();
        if has_sines {
            text.push_str("#include <float.h>\n");
        }
        text.push_str("#include <math.h>\n");
        if has_sines {
            text.push_str("#include <stdint.h>\n");
        }
        if has_sines || self.has_gaps() {
            text.push_str("#include <string.h>\n");
        }
        if let Some(header) = self.interface.data_header() {
            let _ = writeln!(text, "\n#include \"{header}\"");
        }
        if has_sines || !self.plan.is_flat {
            text.push('\n');
            text.push_str(APART);
            text.push_str(CLONES);
        }
        if self.plan.superwords.lanes() > 1 {
            *text += &vectors::types(self.plan.superwords.width(), self.real);
        }
    }

    /// True if elements of arrays must be set to zero.
    fn has_gaps(&self) -> bool {
        let outputs = self.interface.layouts().map(|(_, outputs)| outputs);
        let mut outputs = outputs.into_iter().flatten();
        outputs.any(|(_, layout)| layout.has_gaps)
    }

    /// A part as its own function.
    fn part(&self, text: &mut String, number: usize, part: &CodePart) {
        let mut list = self.interface.inner.clone();
        list.add(&format!("{} *restrict ", self.real.name()), &self.work);
        if self.plan.vectors() > 0 {
            list.add(&format!("{} *restrict ", self.vector()), &self.vectors);
        }
        let mut body = PartBody::default();
        self.statements(&mut body, number, part);
        let head = format!(
            "\nROBOVEC_CLONES ROBOVEC_APART static void {}",
            self.parts[number]
        );
        *text += &list.definition(&head, &self.body(&body));
    }

    /// The work array, the words of it that angles leave empty, and zeros in
    /// the elements of dense arrays that are never set.
    fn locals(&self) -> String {
        let mut text = String::new();
        if self.plan.work() > 0 || !self.plan.is_flat {
            let words = self.plan.work().max(1);
            let _ = writeln!(text, "    {} {}[{words}];", self.real.name(), self.work);
        }
        if self.plan.vectors() > 0 {
            let (vector, count) = (self.vector(), self.plan.vectors());
            let _ = writeln!(text, "    {vector} {}[{count}];", self.vectors);
        }
        let slots = &self.plan.slots;
        let angles = slots.angle_words();
        for word in angles.start + slots.angles().len() as u32..angles.end {
            let _ = writeln!(text, "    {}[{word}] = 0;", self.work);
        }
        let outputs = self.interface.layouts().map(|(_, outputs)| outputs);
        for (name, layout) in outputs.into_iter().flatten() {
            if layout.has_gaps {
                let (real, count) = (self.real.name(), layout.kept.len());
                let _ = writeln!(text, "    memset({name}, 0, sizeof({real}) * {count});");
            }
        }
        text
    }

    /// The statements of the function itself: everything, or calls of its
    /// parts.
    fn main(&self) -> String {
        let mut list = self.interface.inner.clone();
        list.add("", &self.work);
        if self.plan.vectors() > 0 {
            list.add("", &self.vectors);
        }
        let arguments = list.arguments();
        let mut body = PartBody::default();
        for (number, part) in self.plan.parts.iter().enumerate() {
            if !self.plan.slots.angles().is_empty() && number == self.plan.head {
                let _ = writeln!(body.text, "    {}({});", self.sines, self.work);
            }
            if self.plan.is_flat {
                self.statements(&mut body, number, part)
            } else {
                let _ = writeln!(body.text, "    {}({arguments});", self.parts[number]);
            }
        }
        self.body(&body)
    }

    /// The comment about the arrays, and about the user calls that the caller
    /// must make.
    fn comment(&self) -> String {
        let mut text = format!("/* {} by robovec. ", self.interface.name());
        match self.interface.layouts() {
            Some((order, outputs)) => text += &pattern::comment(order, &outputs),
            None => text += "Arrays count from 1; element 0 is not used.\n",
        }
        if self.interface.is_robotran() && !self.is_local {
            let model = model_name(self.function);
            let _ = writeln!(
                text,
                "   It takes the place of Robotran's function of the model {}.",
                frame::quoted(model)
            );
        }
        let words = &self.plan.superwords;
        if words.lanes() > 1 {
            let _ = writeln!(
                text,
                "   {} operations are on vectors of {} numbers of equal structure.",
                self.plan.vector_operations(),
                words.lanes()
            );
        }
        text + &frame::boundaries(self.function) + "*/\n"
    }

    /// A body with the pointers that it uses.
    fn body(&self, body: &PartBody) -> String {
        let mut text = String::new();
        for &pointer in &body.pointers {
            let _ = writeln!(text, "    {}", self.interface.pointers[pointer].declaration);
        }
        text + &body.text
    }

    fn statements(&self, body: &mut PartBody, number: usize, part: &CodePart) {
        let real = self.real.name();
        for &statement in &part.statements {
            match statement {
                CodeStatement::Step(CodeStep::Define(value))
                    if let Some((word, _)) = self.plan.superwords.computing(value) =>
                {
                    self.define_word(body, number, word, value);
                }
                CodeStatement::Step(CodeStep::Define(value)) => {
                    let name = &self.values[value.index()];
                    let expression = self.expression(body, number, value).text;
                    let _ = writeln!(body.text, "    const {real} {name} = {expression};");
                    if let Some(word) = self.plan.word(value) {
                        let _ = writeln!(body.text, "    {}[{word}] = {name};", self.work);
                    }
                }
                CodeStatement::Angle(slot) => {
                    let angle = self.plan.slots.angles()[slot as usize];
                    let word = self.plan.slots.angle_words().start + slot;
                    let operand = self.operand(body, number, angle).text;
                    let _ = writeln!(body.text, "    {}[{word}] = {operand};", self.work);
                }
                CodeStatement::Step(CodeStep::Assign(index)) => {
                    let assignment = &self.function.assignments[index as usize];
                    let operand = self.operand(body, number, assignment.operand).text;
                    let target = self.interface.element(true, assignment.output.0);
                    body.pointers.extend(target.pointer);
                    let _ = writeln!(body.text, "    {} = {operand};", target.text);
                }
            }
        }
    }

    /// A value's variable, fetched from the work array where it is read
    /// first.
    fn variable(&self, body: &mut PartBody, number: usize, value: Value) -> String {
        let name = &self.values[value.index()];
        if let Some(word) = self.plan.load(value, number)
            && body.fetched.insert(value)
        {
            let (real, work) = (self.real.name(), &self.work);
            let _ = writeln!(body.text, "    const {real} {name} = {work}[{word}];");
        }
        name.clone()
    }

    /// The expression of a node. Inlined trees have a bounded number of
    /// operations ([`Inlining`](crate::emit::inlining::Inlining)), so
    /// the recursion is bounded.
    fn expression(&self, body: &mut PartBody, number: usize, value: Value) -> BoundText {
        let node = self.function.node(value);
        let operands: Vec<BoundText> = node
            .operands()
            .iter()
            .map(|&operand| self.operand(body, number, operand))
            .collect();
        apply(node.operation, &operands, self.real, Operands::Numbers)
    }

    pub(super) fn operand(
        &self,
        body: &mut PartBody,
        number: usize,
        operand: Operand,
    ) -> BoundText {
        match operand.kind() {
            OperandKind::Value(value) if self.plan.is_inlined(value) => {
                self.expression(body, number, value)
            }
            OperandKind::Value(value) => {
                let text = match self.plan.superwords.computing(value) {
                    Some((word, lane)) => {
                        format!("{}[{lane}]", self.word(body, number, word))
                    }
                    None => self.variable(body, number, value),
                };
                BoundText::primary(text)
            }
            OperandKind::Input(input) => {
                let element = self.interface.element(false, input.0);
                body.pointers.extend(element.pointer);
                match self.real {
                    Real::Float if self.interface.is_robotran() => {
                        BoundText::new(format!("(float){}", element.text), Tightness::Unary)
                    }
                    Real::Float | Real::Double => BoundText::primary(element.text),
                }
            }
            OperandKind::Constant(constant) => {
                literal(self.function.constant_number(constant), self.real)
            }
            OperandKind::None => unreachable!("an operation has all its operands"),
        }
    }
}
