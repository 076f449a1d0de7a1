//! The text of a generated C function.

use super::Real;
use super::names::Names;
use super::parts::{Part, Plan, Statement};
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
            let _ = write!(
                text,
                "\nvoid {}({})\n{{\n",
                self.name,
                self.parameters(false)
            );
            self.ignored(&mut text);
            self.body(&mut text, part);
            text.push_str("}\n");
            return text;
        }
        for (part, name) in self.plan.parts.iter().zip(&self.parts) {
            let parameters = self.parameters(true);
            let _ = write!(text, "\nstatic void {name}({parameters})\n{{\n");
            self.ignored(&mut text);
            let _ = writeln!(text, "    (void){};", self.work);
            self.body(&mut text, part);
            text.push_str("}\n");
        }
        let _ = write!(
            text,
            "\nvoid {}({})\n{{\n",
            self.name,
            self.parameters(false)
        );
        self.ignored(&mut text);
        if !self.parts.is_empty() {
            let words = self.plan.work.max(1);
            let _ = writeln!(text, "    {} {}[{words}];", self.real.name(), self.work);
        }
        let arguments: Vec<&str> = self
            .inputs
            .iter()
            .chain(&self.outputs)
            .chain([&self.work])
            .map(String::as_str)
            .collect();
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

    /// Marks all parameters as used, for strict compilers.
    fn ignored(&self, text: &mut String) {
        for name in self.inputs.iter().chain(&self.outputs) {
            let _ = writeln!(text, "    (void){name};");
        }
    }

    fn body(&self, text: &mut String, part: &Part) {
        let real = self.real.name();
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
                    let expression = self.expression(value);
                    let _ = writeln!(text, "    const {real} {name} = {expression};");
                    if let Some(word) = self.plan.word(value) {
                        let _ = writeln!(text, "    {}[{word}] = {name};", self.work);
                    }
                }
                Statement::Assign(index) => {
                    let assignment = &self.function.assignments[index as usize];
                    let (array, indices, rank) = self.function.output_element(assignment.output);
                    let place = self
                        .function
                        .outputs()
                        .iter()
                        .position(|a| a.name == array.name);
                    let name = place.map_or("", |place| &self.outputs[place]);
                    let target = match rank {
                        0 => format!("*{name}"),
                        _ => element(name, &indices[..rank]),
                    };
                    let operand = self.operand(assignment.operand);
                    let _ = writeln!(text, "    {target} = {operand};");
                }
            }
        }
    }

    /// The expression of a node. Inlined trees are at most
    /// [`super::parts`]' limit deep, so the recursion is bounded.
    fn expression(&self, value: Value) -> String {
        let node = self.function.node(value);
        let a = self.operand(node.operands[0]);
        let double = self.real == Real::Double;
        let binary = |sign: &str| format!("{a} {sign} {}", self.operand(node.operands[1]));
        match node.operation {
            Operation::Copy => a,
            Operation::Neg => format!("-{a}"),
            Operation::Add => binary("+"),
            Operation::Sub => binary("-"),
            Operation::Mul => binary("*"),
            Operation::Div => binary("/"),
            Operation::Sin | Operation::Cos if !double => {
                format!("(float){}((double){a})", node.operation.name())
            }
            Operation::Sqrt if !double => format!("sqrtf({a})"),
            Operation::Sin | Operation::Cos | Operation::Sqrt => {
                format!("{}({a})", node.operation.name())
            }
        }
    }

    /// An operand, in parentheses where it is more than a name.
    fn operand(&self, operand: Operand) -> String {
        match operand.kind() {
            OperandKind::Value(value) if self.plan.is_inlined(value) => {
                format!("({})", self.expression(value))
            }
            OperandKind::Value(value) => self.values[value.index()].clone(),
            OperandKind::Input(input) => {
                let (array, indices, rank) = self.function.input_element(input);
                let place = self
                    .function
                    .inputs()
                    .iter()
                    .position(|a| a.name == array.name);
                let name = place.map_or("", |place| &self.inputs[place]);
                element(name, &indices[..rank])
            }
            OperandKind::Constant(constant) => {
                literal(self.function.constant_number(constant), self.real)
            }
            OperandKind::None => "0".to_owned(),
        }
    }
}

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
        format!("(-{text})")
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
        assert_eq!(double(-0.0), "(-0.0)");
        assert_eq!(double(1e300), "1e300");
        assert_eq!(double(f64::NEG_INFINITY), "(-INFINITY)");
        assert_eq!(literal(1e300, Real::Float), "INFINITY");
        assert_eq!(literal(0.1, Real::Float), "0.1f");
        assert_eq!(literal(3.0, Real::Float), "3.0f");
    }
}
