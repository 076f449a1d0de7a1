//! The text of a generated C function.

use super::Real;
use super::names::Names;
use super::parts::{Part, Plan, Statement, place};
use robovec_ir::{Array, Function, Operand, OperandKind, Operation, Shape, Value, View};
use std::fmt::Write;

/// Writes one function.
pub(super) struct Writer<'a> {
    function: &'a Function,
    real: Real,
    plan: &'a Plan,
    name: String,
    parts: Vec<String>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    /// The name of the work array.
    work: String,
    /// For each node its variable; empty for inlined ones.
    values: Vec<String>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(view: View<'a>, real: Real, plan: &'a Plan) -> Writer<'a> {
        let function = view.function;
        let symbols = &view.tables.symbols;
        let mut names = Names::new();
        let name = names.take(&function.name);
        let mut arrays = |arrays: &[Array]| -> Vec<String> {
            arrays
                .iter()
                .map(|array| names.take(symbols.text(array.name)))
                .collect()
        };
        let (inputs, outputs) = (arrays(function.inputs()), arrays(function.outputs()));
        let parts = (1..=plan.parts.len())
            .map(|number| names.take(&format!("{name}_part_{number}")))
            .collect();
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
            real,
            plan,
            name,
            parts,
            inputs,
            outputs,
            work,
            values,
        }
    }

    pub(super) fn function_name(&self) -> &str {
        &self.name
    }

    /// The header: one declaration.
    pub(super) fn header(&self) -> String {
        let guard = format!("ROBOVEC_{}_H", self.name.to_ascii_uppercase());
        format!(
            "{}#ifndef {guard}\n#define {guard}\n\nvoid {}({});\n\n#endif\n",
            self.comment(),
            self.name,
            self.parameters(false)
        )
    }

    /// The source.
    pub(super) fn source(&self) -> String {
        let mut text = self.comment();
        text.push_str("#include <math.h>\n");
        if let [part] = self.plan.parts.as_slice() {
            let parameters = self.parameters(false);
            let _ = write!(text, "\nvoid {}({parameters})\n{{\n", self.name);
            self.body(&mut text, part);
            text.push_str("}\n");
            return text;
        }
        for (part, name) in self.plan.parts.iter().zip(&self.parts) {
            let parameters = self.parameters(true);
            let _ = write!(text, "\nstatic void {name}({parameters})\n{{\n");
            self.body(&mut text, part);
            text.push_str("}\n");
        }
        let parameters = self.parameters(false);
        let _ = write!(text, "\nvoid {}({parameters})\n{{\n", self.name);
        let words = self.plan.work.max(1);
        let _ = writeln!(text, "    {} {}[{words}];", self.real.name(), self.work);
        let names = self.inputs.iter().chain(&self.outputs).chain([&self.work]);
        let arguments: Vec<&str> = names.map(String::as_str).collect();
        for name in &self.parts {
            let _ = writeln!(text, "    {name}({});", arguments.join(", "));
        }
        text.push_str("}\n");
        text
    }

    /// What the arrays are, and what the user must do about user calls.
    fn comment(&self) -> String {
        let mut text = format!(
            "/* {} by robovec. Arrays count from 1; element 0 is not used.\n",
            self.name
        );
        for boundary in &self.function.boundaries {
            // A comment cannot hold its own end.
            let callee = boundary.callee.replace("*/", "* /");
            let result = boundary.result.as_deref().unwrap_or("nothing");
            let _ = writeln!(
                text,
                "   The results of {callee} are taken from the input {}; its arguments are outputs.",
                result.replace("*/", "* /")
            );
        }
        text.push_str("*/\n");
        text
    }

    fn parameters(&self, with_work: bool) -> String {
        let real = self.real.name();
        let mut list = Vec::new();
        for (array, name) in self.function.inputs().iter().zip(&self.inputs) {
            list.push(match array.shape {
                Shape::Scalar => format!("{real} {name}"),
                Shape::Vector(_) => format!("const {real} *{name}"),
                Shape::Matrix(_, columns) => {
                    format!("const {real} {name}[][{}]", u64::from(columns) + 1)
                }
            });
        }
        for (array, name) in self.function.outputs().iter().zip(&self.outputs) {
            list.push(match array.shape {
                Shape::Scalar | Shape::Vector(_) => format!("{real} *{name}"),
                Shape::Matrix(_, columns) => {
                    format!("{real} {name}[][{}]", u64::from(columns) + 1)
                }
            });
        }
        if with_work {
            list.push(format!("{real} *{}", self.work));
        }
        if list.is_empty() {
            return "void".to_owned();
        }
        list.join(", ")
    }

    /// Marks the parameters that a part leaves alone as used, for strict
    /// compilers.
    fn ignore_unused(&self, text: &mut String, part: &Part) {
        let used = self.plan.used_arrays(self.function, part);
        let arrays = self.inputs.iter().chain(&self.outputs);
        let mut unused: Vec<&str> = arrays
            .zip(used)
            .filter(|(_, used)| !used)
            .map(|(name, _)| name.as_str())
            .collect();
        let crosses = |statement: &Statement| match statement {
            Statement::Define(value) => self.plan.word(*value).is_some(),
            Statement::Assign(_) => false,
        };
        let alone = self.plan.parts.len() == 1;
        if !alone && part.loads.is_empty() && !part.statements.iter().any(crosses) {
            unused.push(&self.work);
        }
        for name in unused {
            let _ = writeln!(text, "    (void){name};");
        }
    }

    fn body(&self, text: &mut String, part: &Part) {
        let real = self.real.name();
        self.ignore_unused(text, part);
        for &value in &part.loads {
            if let Some(word) = self.plan.word(value) {
                let name = &self.values[value.index()];
                let _ = writeln!(text, "    const {real} {name} = {}[{word}];", self.work);
            }
        }
        for &statement in &part.statements {
            match statement {
                Statement::Define(value) => {
                    let name = &self.values[value.index()];
                    let (expression, _) = self.expression(value);
                    let _ = writeln!(text, "    const {real} {name} = {expression};");
                    if let Some(word) = self.plan.word(value) {
                        let _ = writeln!(text, "    {}[{word}] = {name};", self.work);
                    }
                }
                Statement::Assign(index) => {
                    let assignment = &self.function.assignments[index as usize];
                    let (array, indices, rank) = self.function.output_element(assignment.output);
                    let name = &self.outputs[place(self.function.outputs(), array)];
                    let target = match rank {
                        0 => format!("*{name}"),
                        _ => element(name, &indices[..rank]),
                    };
                    let operand = self.operand(assignment.operand, 0);
                    let _ = writeln!(text, "    {target} = {operand};");
                }
            }
        }
    }

    /// The expression of a node, and how tightly it binds. Inlined trees are
    /// at most [`super::parts`]' limit deep, so the recursion is bounded.
    fn expression(&self, value: Value) -> (String, u8) {
        let node = self.function.node(value);
        let [left, right, third] = node.operands;
        let binary = |sign: &str, binding: u8| {
            let (a, b) = (
                self.operand(left, binding),
                self.operand(right, binding + 1),
            );
            (format!("{a} {sign} {b}"), binding)
        };
        let call = |function: &str| (format!("{function}({})", self.operand(left, 0)), PRIMARY);
        let double = self.real == Real::Double;
        match node.operation {
            Operation::Copy => (self.operand(left, PRIMARY), PRIMARY),
            Operation::Neg => (format!("-{}", self.operand(left, PRIMARY)), UNARY),
            Operation::Add => binary("+", SUM),
            Operation::Sub => binary("-", SUM),
            Operation::Mul => binary("*", PRODUCT),
            Operation::Div => binary("/", PRODUCT),
            Operation::Sin | Operation::Cos if !double => {
                let (name, argument) = (node.operation.name(), self.operand(left, UNARY));
                (format!("(float){name}((double){argument})"), UNARY)
            }
            Operation::Sqrt if !double => call("sqrtf"),
            Operation::Sin | Operation::Cos | Operation::Sqrt => call(node.operation.name()),
            Operation::Fma | Operation::Fms | Operation::Fnma => {
                let function = if double { "fma" } else { "fmaf" };
                let signed = |minus: bool, operand: Operand| match minus {
                    true => format!("-{}", self.operand(operand, PRIMARY)),
                    false => self.operand(operand, 0),
                };
                let a = signed(node.operation == Operation::Fnma, left);
                let b = self.operand(right, 0);
                let c = signed(node.operation == Operation::Fms, third);
                (format!("{function}({a}, {b}, {c})"), PRIMARY)
            }
        }
    }

    /// An operand, in parentheses where it binds less tightly than it must.
    fn operand(&self, operand: Operand, binding: u8) -> String {
        let (text, own) = match operand.kind() {
            OperandKind::Value(value) if self.plan.is_inlined(value) => self.expression(value),
            OperandKind::Value(value) => (self.values[value.index()].clone(), PRIMARY),
            OperandKind::Input(input) => {
                let (array, indices, rank) = self.function.input_element(input);
                let name = &self.inputs[place(self.function.inputs(), array)];
                (element(name, &indices[..rank]), PRIMARY)
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

fn element(name: &str, indices: &[u32]) -> String {
    let mut text = name.to_owned();
    for index in indices {
        let _ = write!(text, "[{index}]");
    }
    text
}

/// A number as a C literal that reads back as the same number.
fn literal(number: f64, real: Real) -> String {
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
