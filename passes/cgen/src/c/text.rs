//! The text of a generated C function.

use super::interface::Interface;
use super::parts::{CodePart, CodePlan, CodeStatement};
use super::{Options, Real};
use crate::emit::expression::{BoundText, Operands, Tightness, apply, literal};
use crate::emit::frame::{self, APART, CLONES};
use crate::emit::order::CodeStep;
use robovec_ir::{Function, Operand, OperandKind, Value, View};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Writes one function.
pub(super) struct PlainWriter<'a> {
    function: &'a Function,
    real: Real,
    is_local: bool,
    plan: &'a CodePlan,
    interface: &'a Interface<'a>,
    parts: Vec<String>,
    /// The name of the function that computes sines.
    sines: String,
    /// The name of the work array.
    work: String,
    /// For each node its variable; empty for inlined ones.
    values: Vec<String>,
}

/// The body of a part, and what it uses.
#[derive(Default)]
struct PartBody {
    text: String,
    pointers: BTreeSet<usize>,
    /// Names that stand in the text.
    uses_work: bool,
    /// Values fetched from the work array so far.
    fetched: BTreeSet<Value>,
}

impl<'a> PlainWriter<'a> {
    pub(super) fn new(
        view: View<'a>,
        options: &Options,
        interface: &'a Interface<'a>,
        plan: &'a CodePlan,
    ) -> PlainWriter<'a> {
        let function = view.function;
        let symbols = &view.tables.symbols;
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
        let values = function
            .values()
            .map(
                |(value, node)| match (plan.is_inlined(value), node.name.is_none()) {
                    (true, _) => String::new(),
                    (false, true) => names.take(&format!("inner_{}", value.0)),
                    (false, false) => names.take(&node.name.display(symbols)),
                },
            )
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
            values,
        }
    }

    /// The header: one declaration.
    pub(super) fn header(&self) -> String {
        let declared = self.declared();
        let data = self.interface.data_header();
        frame::header(&self.comment(), self.interface.file(), data, &declared)
    }

    /// The declaration: result type, name and parameters.
    fn declared(&self) -> String {
        let parameters = self.interface.parameters().iter();
        let parameters = frame::parameters(parameters.map(|(text, _)| text));
        let (result, name) = (self.interface.result(), self.interface.name());
        format!("{result} {name}({parameters})")
    }

    /// The source.
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
        let _ = write!(text, "\n{clones}{linkage}{}\n{{\n", self.declared());
        self.main(&mut text);
        if self.interface.result() == "int" {
            text.push_str("    return 0;\n");
        }
        text.push_str("}\n");
        text
    }

    fn includes(&self, text: &mut String) {
        let has_sines = !self.plan.slots.angles().is_empty();
        if has_sines {
            text.push_str("#include <float.h>\n");
        }
        text.push_str("#include <math.h>\n");
        if has_sines {
            text.push_str("#include <stdint.h>\n#include <string.h>\n");
        }
        if let Some(header) = self.interface.data_header() {
            let _ = writeln!(text, "\n#include \"{header}\"");
        }
        if has_sines || !self.plan.is_flat {
            text.push('\n');
            text.push_str(APART);
            text.push_str(CLONES);
        }
    }

    /// A part as a function of its own.
    fn part(&self, text: &mut String, number: usize, part: &CodePart) {
        let mut parameters: Vec<&str> = self
            .interface
            .inner()
            .iter()
            .map(|(text, _)| &**text)
            .collect();
        let work = format!("{} *restrict {}", self.real.name(), self.work);
        parameters.push(&work);
        let name = &self.parts[number];
        let _ = write!(
            text,
            "\nROBOVEC_CLONES ROBOVEC_APART static void {name}({})\n{{\n",
            parameters.join(", ")
        );
        let mut body = PartBody::default();
        self.statements(&mut body, number, part);
        self.ignore_unused(text, &body, true);
        self.pointers(text, &body);
        text.push_str(&body.text);
        text.push_str("}\n");
    }

    /// The function itself: everything, or calls of its parts.
    fn main(&self, text: &mut String) {
        let has_sines = !self.plan.slots.angles().is_empty();
        if self.plan.work() > 0 || !self.plan.is_flat {
            let words = self.plan.work().max(1);
            let _ = writeln!(text, "    {} {}[{words}];", self.real.name(), self.work);
        }
        if has_sines {
            let angles = self.plan.slots.angle_words();
            let unused = angles.start + self.plan.slots.angles().len() as u32..angles.end;
            for word in unused {
                let _ = writeln!(text, "    {}[{word}] = 0;", self.work);
            }
        }
        let sines = format!("    {}({});\n", self.sines, self.work);
        if self.plan.is_flat {
            let mut body = PartBody::default();
            for (number, part) in self.plan.parts.iter().enumerate() {
                if has_sines && number == self.plan.head {
                    body.text.push_str(&sines);
                }
                self.statements(&mut body, number, part);
            }
            self.ignore_unused(text, &body, false);
            self.pointers(text, &body);
            text.push_str(&body.text);
            return;
        }
        let mut arguments: Vec<&str> = self
            .interface
            .inner()
            .iter()
            .map(|(_, name)| &**name)
            .collect();
        let parameters = self.interface.parameters().iter();
        for (_, name) in parameters.filter(|(_, name)| !arguments.contains(&&**name)) {
            let _ = writeln!(text, "    (void){name};");
        }
        arguments.push(&self.work);
        let arguments = arguments.join(", ");
        for (number, name) in self.parts.iter().enumerate() {
            if has_sines && number == self.plan.head {
                text.push_str(&sines);
            }
            let _ = writeln!(text, "    {name}({arguments});");
        }
    }

    /// The comment about the arrays, and what the user must do about user
    /// calls.
    fn comment(&self) -> String {
        let mut text = format!(
            "/* {} by robovec. Arrays count from 1; element 0 is not used.\n",
            self.interface.name()
        );
        if self.interface.is_robotran() && !self.is_local {
            let model = self.function.metadata("model").unwrap_or("model");
            let _ = writeln!(
                text,
                "   It takes the place of Robotran's function of the model {}.",
                frame::quoted(model)
            );
        }
        text + &frame::boundaries(self.function) + "*/\n"
    }

    /// Marks the parameters that a body leaves alone as used, for strict
    /// compilers.
    fn ignore_unused(&self, text: &mut String, body: &PartBody, is_part: bool) {
        let parameters = match is_part {
            true => self.interface.inner(),
            false => self.interface.parameters(),
        };
        let mut declarations = String::new();
        self.pointers(&mut declarations, body);
        let names = parameters.iter().map(|(_, name)| &**name);
        text.push_str(&frame::unused(names, &[&body.text, &declarations]));
        if is_part && !body.uses_work {
            let _ = writeln!(text, "    (void){};", self.work);
        }
    }

    fn pointers(&self, text: &mut String, body: &PartBody) {
        for &pointer in &body.pointers {
            let _ = writeln!(text, "    {}", self.interface.pointers[pointer].declaration);
        }
    }

    fn statements(&self, body: &mut PartBody, number: usize, part: &CodePart) {
        let real = self.real.name();
        for &statement in &part.statements {
            match statement {
                CodeStatement::Step(CodeStep::Define(value)) => {
                    let name = &self.values[value.index()];
                    let expression = self.expression(body, number, value).text;
                    let _ = writeln!(body.text, "    const {real} {name} = {expression};");
                    if let Some(word) = self.plan.word(value) {
                        body.uses_work = true;
                        let _ = writeln!(body.text, "    {}[{word}] = {name};", self.work);
                    }
                }
                CodeStatement::Angle(slot) => {
                    body.uses_work = true;
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
            body.uses_work = true;
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

    fn operand(&self, body: &mut PartBody, number: usize, operand: Operand) -> BoundText {
        match operand.kind() {
            OperandKind::Value(value) if self.plan.is_inlined(value) => {
                self.expression(body, number, value)
            }
            OperandKind::Value(value) => BoundText::primary(self.variable(body, number, value)),
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
