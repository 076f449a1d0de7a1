//! The numbers that all states share, computed once.
//!
//! Of the operations of a real file a tenth combines parameters only. They
//! are computed as plain numbers, in parts like the others; what a part reads
//! from an earlier one is prepared as well, so that no second array is
//! needed.

use super::Options;
use super::names::BatchNames;
use super::plan::BatchPlan;
use crate::emit::arrays::place;
use crate::emit::expression::{BoundText, Operands, apply, lane_literal};
use crate::emit::frame::unused;
use robovec_ir::{Function, Operand, OperandKind, Shape, Value};
use std::fmt::Write;

/// The code that prepares numbers for all states.
pub(super) struct Prepared {
    /// For each part the values it computes.
    parts: Vec<Vec<Value>>,
    /// For each value the part that computes it, if one does.
    part_of: Vec<Option<usize>>,
}

impl Prepared {
    /// Cuts what is to be prepared into parts. Adds to the prepared numbers
    /// those that cross from part to part.
    pub(super) fn new(function: &Function, plan: &mut BatchPlan, part: u32) -> Prepared {
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
        let mut part_of = vec![None; wanted.len()];
        let size = part.max(1) as usize;
        for (index, value) in values.iter().enumerate() {
            part_of[value.index()] = Some(index / size);
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
        plan: &BatchPlan,
        names: &BatchNames,
        options: &Options,
        parameters: &str,
        arguments: &str,
    ) -> String {
        let writer = PreparedWriter {
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
            let mut body = String::new();
            for &value in values {
                writer.define(&mut body, value, number);
            }
            text += &unused(arguments.split(", "), &[&body]);
            text += &body;
            text += "}\n\n";
        }
        let _ = write!(text, "void {}_prepare({parameters})\n{{\n", names.function);
        let (mut inputs, mut calls) = (String::new(), String::new());
        for (place, &operand) in plan.prepared.iter().enumerate() {
            if let OperandKind::Input(_) = operand.kind() {
                let input = writer.operand(operand, 0).text;
                let _ = writeln!(inputs, "    prepared[{place}] = {input};");
            }
        }
        for number in 1..=self.parts.len() {
            let _ = writeln!(
                calls,
                "    {}_prepare_{number}({arguments});",
                names.function
            );
        }
        let unused = unused(arguments.split(", "), &[&inputs, &calls]);
        text + &inputs + &unused + &calls + "}\n\n"
    }
}

struct PreparedWriter<'a> {
    function: &'a Function,
    plan: &'a BatchPlan,
    names: &'a BatchNames,
    options: &'a Options,
    part_of: &'a [Option<usize>],
}

impl PreparedWriter<'_> {
    fn define(&self, text: &mut String, value: Value, part: usize) {
        let node = self.function.node(value);
        let operands: Vec<BoundText> = node
            .operands()
            .iter()
            .map(|&operand| self.operand(operand, part))
            .collect();
        let real = self.options.real;
        let expression = apply(node.operation, &operands, real, Operands::Lanes).text;
        let name = &self.names.values[value.index()];
        let real = real.name();
        let _ = writeln!(text, "    const {real} {name} = {expression};");
        // What is not prepared is read in this part.
        if let Some(place) = self.plan.prepared_place(value.into()) {
            let _ = writeln!(text, "    prepared[{place}] = {name};");
        }
    }

    fn operand(&self, operand: Operand, part: usize) -> BoundText {
        let text = match operand.kind() {
            OperandKind::Value(value) if self.part_of[value.index()] == Some(part) => {
                self.names.values[value.index()].clone()
            }
            OperandKind::Value(_) => {
                let place = self.plan.prepared_place(operand);
                format!(
                    "prepared[{}]",
                    place.expect("what crosses parts was prepared")
                )
            }
            OperandKind::Input(input) => {
                let index = self.function.input_array(input);
                let array = &self.function.inputs()[index];
                let name = &self.names.inputs[index];
                match array.shape {
                    Shape::Scalar => name.clone(),
                    Shape::Vector(_) | Shape::Matrix(..) => {
                        format!("{name}[{}]", place(array, input.0 - array.offset))
                    }
                }
            }
            OperandKind::Constant(constant) => {
                return lane_literal(self.function.constant_number(constant), self.options.real);
            }
            OperandKind::None => unreachable!("an operation has all its operands"),
        };
        BoundText::primary(text)
    }
}
