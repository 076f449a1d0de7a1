//! What all states share, computed once.
//!
//! Of the operations of a real file a tenth combines parameters only. They
//! are computed as plain numbers, in parts like the others; what a part reads
//! from an earlier one is prepared as well, so that no second array is
//! needed.

use super::expression::{expression, literal};
use super::names::Names;
use super::plan::{Plan, input_array};
use super::{Options, element};
use robovec_ir::{Function, Operand, OperandKind, Value};
use std::fmt::Write;

/// The code that prepares numbers for all states.
pub(super) struct Prepared {
    /// For each part the values it computes.
    parts: Vec<Vec<Value>>,
    /// For each value the part that computes it.
    part_of: Vec<usize>,
}

impl Prepared {
    /// Cuts what is to be prepared into parts. Adds to the prepared numbers
    /// those that cross from part to part.
    pub(super) fn new(function: &Function, plan: &mut Plan, part: u32) -> Prepared {
        let mut wanted = vec![false; function.nodes().len()];
        for value in plan.prepared.iter().filter_map(|operand| operand.value()) {
            wanted[value.index()] = true;
        }
        for (value, node) in function.values().rev() {
            if wanted[value.index()] {
                for operand in node.operands().iter().filter_map(|operand| operand.value()) {
                    wanted[operand.index()] = true;
                }
            }
        }
        let values = function.values().map(|(value, _)| value);
        let values: Vec<Value> = values.filter(|value| wanted[value.index()]).collect();
        let mut part_of = vec![usize::MAX; wanted.len()];
        let size = part.max(1) as usize;
        for (index, value) in values.iter().enumerate() {
            part_of[value.index()] = index / size;
        }
        for &value in &values {
            for &operand in function.node(value).operands() {
                let crosses = |other: Value| part_of[other.index()] != part_of[value.index()];
                if operand.value().is_some_and(crosses) {
                    plan.share(function, operand);
                }
            }
        }
        Prepared {
            parts: values.chunks(size).map(<[Value]>::to_vec).collect(),
            part_of,
        }
    }

    /// The functions of the parts, and the calls of all of them.
    pub(super) fn write(
        &self,
        function: &Function,
        plan: &Plan,
        names: &Names,
        options: &Options,
        parameters: &str,
        arguments: &str,
    ) -> String {
        let writer = Writer {
            function,
            plan,
            names,
            options,
            part_of: &self.part_of,
        };
        let mut text = String::new();
        for (number, values) in self.parts.iter().enumerate() {
            let name = format!("{}_prepare_{}", names.function, number + 1);
            let _ = write!(text, "static void {name}({parameters})\n{{\n");
            text += &writer.ignore(values, number);
            for &value in values {
                writer.define(&mut text, value, number);
            }
            text += "}\n\n";
        }
        let _ = write!(text, "void {}_prepare({parameters})\n{{\n", names.function);
        let mut used = vec![!self.parts.is_empty(); names.inputs.len()];
        for (place, operand) in plan.prepared.iter().enumerate() {
            if let OperandKind::Input(input) = operand.kind() {
                used[input_array(function, input)] = true;
                let _ = writeln!(text, "    prepared[{place}] = {};", writer.input(*operand));
            }
        }
        for (index, name) in names.inputs.iter().enumerate() {
            if plan.shared[index] && !used[index] {
                let _ = writeln!(text, "    (void){name};");
            }
        }
        for number in 1..=self.parts.len() {
            let _ = writeln!(
                text,
                "    {}_prepare_{number}({arguments});",
                names.function
            );
        }
        if plan.prepared.is_empty() {
            text += "    (void)prepared;\n";
        }
        text + "}\n\n"
    }
}

struct Writer<'a> {
    function: &'a Function,
    plan: &'a Plan,
    names: &'a Names,
    options: &'a Options,
    part_of: &'a [usize],
}

impl Writer<'_> {
    /// Marks parameters that a part leaves alone as used.
    fn ignore(&self, values: &[Value], part: usize) -> String {
        let mut used = vec![false; self.names.inputs.len()];
        let mut prepared = false;
        for &value in values {
            prepared |= self.plan.prepared_place(value.into()).is_some();
            for &operand in self.function.node(value).operands() {
                match operand.kind() {
                    OperandKind::Input(input) => used[input_array(self.function, input)] = true,
                    OperandKind::Value(other) => prepared |= self.part_of[other.index()] != part,
                    OperandKind::Constant(_) | OperandKind::None => {}
                }
            }
        }
        let mut text = String::new();
        for (index, name) in self.names.inputs.iter().enumerate() {
            if self.plan.shared[index] && !used[index] {
                let _ = writeln!(text, "    (void){name};");
            }
        }
        if !prepared {
            text += "    (void)prepared;\n";
        }
        text
    }

    fn define(&self, text: &mut String, value: Value, part: usize) {
        let node = self.function.node(value);
        let operands: Vec<String> = node
            .operands()
            .iter()
            .map(|&operand| self.operand(operand, part))
            .collect();
        let expression = expression(node.operation, &operands, self.options.real);
        let name = &self.names.values[value.index()];
        let real = self.options.real.name();
        let _ = writeln!(text, "    const {real} {name} = {expression};");
        // What is not prepared is read in this part.
        if let Some(place) = self.plan.prepared_place(value.into()) {
            let _ = writeln!(text, "    prepared[{place}] = {name};");
        }
    }

    fn operand(&self, operand: Operand, part: usize) -> String {
        match operand.kind() {
            OperandKind::Value(value) if self.part_of[value.index()] == part => {
                self.names.values[value.index()].clone()
            }
            OperandKind::Value(_) => match self.plan.prepared_place(operand) {
                Some(place) => format!("prepared[{place}]"),
                None => unreachable!("what crosses parts was prepared"),
            },
            OperandKind::Input(_) => self.input(operand),
            OperandKind::Constant(constant) => {
                literal(self.function.constant_number(constant), self.options.real)
            }
            OperandKind::None => String::new(),
        }
    }

    fn input(&self, operand: Operand) -> String {
        let Some(input) = operand.input() else {
            return String::new();
        };
        let index = input_array(self.function, input);
        let array = &self.function.inputs()[index];
        let name = &self.names.inputs[index];
        match array.shape {
            robovec_ir::Shape::Scalar => name.clone(),
            _ => format!("{name}[{}]", element(array, input.0 - array.offset)),
        }
    }
}
