//! The text of a generated C function.

use super::interface::Interface;
use super::parts::{Part, Plan, Statement};
use super::{Options, Real};
use robovec_ir::{Function, Operand, OperandKind, Operation, Value, View};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Writes one function.
pub(super) struct Writer<'a> {
    function: &'a Function,
    real: Real,
    plan: &'a Plan,
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
struct Body {
    text: String,
    pointers: BTreeSet<usize>,
    /// Names that stand in the text.
    uses_work: bool,
    /// Values fetched from the work array so far.
    fetched: BTreeSet<Value>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(
        view: View<'a>,
        options: &Options,
        interface: &'a Interface<'a>,
        plan: &'a Plan,
    ) -> Writer<'a> {
        let function = view.function;
        let symbols = &view.tables.symbols;
        let mut names = interface.names();
        for word in ["ROBOVEC_APART", "ROBOVEC_ANGLES"] {
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
        Writer {
            function,
            real: options.real,
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
        let guard: String = self.interface.file().to_ascii_uppercase().replace('-', "_");
        let guard = format!("ROBOVEC_{guard}_H");
        let data = self.interface.data_header();
        let data = data.map_or(String::new(), |name| format!("#include \"{name}\"\n\n"));
        format!(
            "{}#ifndef {guard}\n#define {guard}\n\n{data}{} {}({});\n\n#endif\n",
            self.comment(),
            self.interface.result(),
            self.interface.name(),
            self.parameters()
        )
    }

    /// The source.
    pub(super) fn source(&self) -> String {
        let mut text = self.comment();
        self.includes(&mut text);
        let has_sines = !self.plan.slots.angles().is_empty();
        if has_sines {
            let kernel = self.plan.slots.source(&self.sines, self.real.name());
            text.push_str(&kernel);
        }
        if !self.plan.is_flat {
            for (number, part) in self.plan.parts.iter().enumerate() {
                self.part(&mut text, number, part);
            }
        }
        let (result, name) = (self.interface.result(), self.interface.name());
        let _ = write!(text, "\n{result} {name}({})\n{{\n", self.parameters());
        self.main(&mut text);
        if result == "int" {
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
            text.push_str(APART);
        }
    }

    /// A part as a function of its own.
    fn part(&self, text: &mut String, number: usize, part: &Part) {
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
            "\nROBOVEC_APART static void {name}({})\n{{\n",
            parameters.join(", ")
        );
        let mut body = Body::default();
        self.statements(&mut body, number, part);
        self.ignore_unused(text, &body, true);
        self.pointers(text, &body);
        text.push_str(&body.text);
        text.push_str("}\n");
    }

    /// What the function itself does: everything, or calls of its parts.
    fn main(&self, text: &mut String) {
        let has_sines = !self.plan.slots.angles().is_empty();
        if self.plan.work > 0 || !self.plan.is_flat {
            let words = self.plan.work.max(1);
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
            let mut body = Body::default();
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

    /// What the arrays are, and what the user must do about user calls.
    fn comment(&self) -> String {
        let mut text = format!(
            "/* {} by robovec. Arrays count from 1; element 0 is not used.\n",
            self.interface.name()
        );
        // A comment cannot hold its own end.
        let quoted = |text: &str| text.replace("*/", "* /");
        if self.interface.is_robotran() {
            let model = self.function.metadata("model").unwrap_or("model");
            let _ = writeln!(
                text,
                "   It takes the place of Robotran's function of the model {}.",
                quoted(model)
            );
        }
        for boundary in &self.function.boundaries {
            let result = boundary.result.as_deref().unwrap_or("nothing");
            let _ = writeln!(
                text,
                "   The results of {} are taken from the input {}; its arguments are outputs.",
                quoted(&boundary.callee),
                quoted(result)
            );
        }
        text.push_str("*/\n");
        text
    }

    fn parameters(&self) -> String {
        let parameters = self.interface.parameters().iter();
        let parameters: Vec<&str> = parameters.map(|(text, _)| &**text).collect();
        match parameters.is_empty() {
            true => "void".to_owned(),
            false => parameters.join(", "),
        }
    }

    /// Marks the parameters that a body leaves alone as used, for strict
    /// compilers.
    fn ignore_unused(&self, text: &mut String, body: &Body, is_part: bool) {
        let parameters = match is_part {
            true => self.interface.inner(),
            false => self.interface.parameters(),
        };
        let mut declarations = String::new();
        self.pointers(&mut declarations, body);
        for (_, name) in parameters {
            if !has_word(&body.text, name) && !has_word(&declarations, name) {
                let _ = writeln!(text, "    (void){name};");
            }
        }
        if is_part && !body.uses_work {
            let _ = writeln!(text, "    (void){};", self.work);
        }
    }

    fn pointers(&self, text: &mut String, body: &Body) {
        for &pointer in &body.pointers {
            let _ = writeln!(text, "    {}", self.interface.pointers[pointer].declaration);
        }
    }

    fn statements(&self, body: &mut Body, number: usize, part: &Part) {
        let real = self.real.name();
        for &statement in &part.statements {
            match statement {
                Statement::Define(value) => {
                    let name = &self.values[value.index()];
                    let (expression, _) = self.expression(body, number, value);
                    let _ = writeln!(body.text, "    const {real} {name} = {expression};");
                    if let Some(word) = self.plan.word(value) {
                        body.uses_work = true;
                        let _ = writeln!(body.text, "    {}[{word}] = {name};", self.work);
                    }
                }
                Statement::Angle(slot) => {
                    body.uses_work = true;
                    let angle = self.plan.slots.angles()[slot as usize];
                    let word = self.plan.slots.angle_words().start + slot;
                    let operand = self.operand(body, number, angle, 0);
                    let _ = writeln!(body.text, "    {}[{word}] = {operand};", self.work);
                }
                Statement::Assign(index) => {
                    let assignment = &self.function.assignments[index as usize];
                    let operand = self.operand(body, number, assignment.operand, 0);
                    let target = self.interface.element(true, assignment.output.0);
                    body.pointers.extend(target.pointer);
                    let _ = writeln!(body.text, "    {} = {operand};", target.text);
                }
            }
        }
    }

    /// A value's variable, fetched from the work array where it is read
    /// first.
    fn variable(&self, body: &mut Body, number: usize, value: Value) -> String {
        let name = &self.values[value.index()];
        let sine = self.plan.slots.of(value);
        let crossing = self
            .plan
            .word(value)
            .filter(|_| self.plan.is_foreign(value, number));
        if let Some(word) = sine.or(crossing)
            && body.fetched.insert(value)
        {
            body.uses_work = true;
            let (real, work) = (self.real.name(), &self.work);
            let _ = writeln!(body.text, "    const {real} {name} = {work}[{word}];");
        }
        name.clone()
    }

    /// The expression of a node, and how tightly it binds. Inlined trees are
    /// at most [`super::parts`]' limit deep, so the recursion is bounded.
    fn expression(&self, body: &mut Body, number: usize, value: Value) -> (String, u8) {
        let node = self.function.node(value);
        let [left, right, third] = node.operands;
        let mut binary = |sign: &str, binding: u8| {
            let a = self.operand(body, number, left, binding);
            let b = self.operand(body, number, right, binding + 1);
            (format!("{a} {sign} {b}"), binding)
        };
        let double = self.real == Real::Double;
        match node.operation {
            Operation::Copy => (self.operand(body, number, left, PRIMARY), PRIMARY),
            Operation::Neg => (
                format!("-{}", self.operand(body, number, left, PRIMARY)),
                UNARY,
            ),
            Operation::Add => binary("+", SUM),
            Operation::Sub => binary("-", SUM),
            Operation::Mul => binary("*", PRODUCT),
            Operation::Div => binary("/", PRODUCT),
            Operation::Sin | Operation::Cos if !double => {
                let (name, argument) = (
                    node.operation.name(),
                    self.operand(body, number, left, UNARY),
                );
                (format!("(float){name}((double){argument})"), UNARY)
            }
            Operation::Sin | Operation::Cos | Operation::Sqrt => {
                let suffix = if double { "" } else { "f" };
                let (name, argument) = (node.operation.name(), self.operand(body, number, left, 0));
                (format!("{name}{suffix}({argument})"), PRIMARY)
            }
            Operation::Fma | Operation::Fms | Operation::Fnma => {
                let function = if double { "fma" } else { "fmaf" };
                let mut signed = |minus: bool, operand: Operand| match minus {
                    true => format!("-{}", self.operand(body, number, operand, PRIMARY)),
                    false => self.operand(body, number, operand, 0),
                };
                let a = signed(node.operation == Operation::Fnma, left);
                let b = signed(false, right);
                let c = signed(node.operation == Operation::Fms, third);
                (format!("{function}({a}, {b}, {c})"), PRIMARY)
            }
        }
    }

    /// An operand, in parentheses where it binds less tightly than it must.
    fn operand(&self, body: &mut Body, number: usize, operand: Operand, binding: u8) -> String {
        let (text, own) = match operand.kind() {
            OperandKind::Value(value) if self.plan.is_inlined(value) => {
                self.expression(body, number, value)
            }
            OperandKind::Value(value) => (self.variable(body, number, value), PRIMARY),
            OperandKind::Input(input) => {
                let element = self.interface.element(false, input.0);
                body.pointers.extend(element.pointer);
                match self.real {
                    Real::Float if self.interface.is_robotran() => {
                        (format!("(float){}", element.text), UNARY)
                    }
                    Real::Float | Real::Double => (element.text, PRIMARY),
                }
            }
            OperandKind::Constant(constant) => {
                let text = literal(self.function.constant_number(constant), self.real);
                let own = if text.starts_with('-') {
                    UNARY
                } else {
                    PRIMARY
                };
                (text, own)
            }
            OperandKind::None => ("0".to_owned(), PRIMARY),
        };
        if own < binding {
            format!("({text})")
        } else {
            text
        }
    }
}

const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const UNARY: u8 = 3;
const PRIMARY: u8 = 4;

/// Keeps compilers from putting parts together again.
const APART: &str = "
#if defined(__GNUC__)
#define ROBOVEC_APART __attribute__((noinline))
#else
#define ROBOVEC_APART
#endif
";

/// True when a word stands in a text.
fn has_word(text: &str, word: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
    text.match_indices(word).any(|(place, _)| {
        !text[..place].ends_with(is_letter) && !text[place + word.len()..].starts_with(is_letter)
    })
}

/// A number as a C literal that reads back as the same number.
pub(in crate::codegen) fn literal(number: f64, real: Real) -> String {
    let single = number as f32;
    let (finite, text) = match real {
        Real::Double => (number.is_finite(), format!("{:?}", number.abs())),
        Real::Float => (single.is_finite(), format!("{:?}f", single.abs())),
    };
    let text = match (finite, number.is_nan()) {
        (true, _) => text,
        (false, true) => return "NAN".to_owned(),
        (false, false) => "INFINITY".to_owned(),
    };
    if number.is_sign_negative() {
        format!("-{text}")
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_keep_every_bit_and_their_sign() {
        let double = |number| literal(number, Real::Double);
        assert_eq!(double(0.1), "0.1");
        assert_eq!(double(-0.0), "-0.0");
        assert_eq!(double(1e300), "1e300");
        assert_eq!(double(f64::NEG_INFINITY), "-INFINITY");
        assert_eq!(literal(1e300, Real::Float), "INFINITY");
        assert_eq!(literal(0.1, Real::Float), "0.1f");
        assert_eq!(literal(3.0, Real::Float), "3.0f");
    }
}
