//! The functions that compute the values shared by all states.

use super::writer::BatchWriter;
use crate::emit::arrays::place;
use crate::emit::expression::{BoundText, Operands, apply, lane_literal};
use crate::emit::frame::unused;
use robovec_ir::{Operand, OperandKind, Shape, Value};
use std::fmt::Write;

impl BatchWriter<'_> {
    /// The functions of the parts, and the calls of all of them.
    pub(super) fn prepare(&self) -> String {
        let name = format!("{}_prepare", self.names.function);
        let list = self.prepare_list();
        let arguments = list.arguments();
        let (mut text, mut inputs, mut calls) = (String::new(), String::new(), String::new());
        for (number, values) in self.prepared.parts.iter().enumerate() {
            let mut body = String::new();
            for &value in values {
                self.prepare_value(&mut body, value, number);
            }
            let own = format!("{name}_{}", number + 1);
            text += &list.definition(&format!("static void {own}"), &body);
            text.push('\n');
            let _ = writeln!(calls, "    {own}({arguments});");
        }
        for (place, &operand) in self.plan.prepared.iter().enumerate() {
            if let OperandKind::Input(_) = operand.kind() {
                let input = self.shared_operand(operand, 0).text;
                let _ = writeln!(inputs, "    prepared[{place}] = {input};");
            }
        }
        let unused = unused(list.names(), &(inputs.clone() + &calls));
        let parameters = list.declared();
        text + &format!("void {name}({parameters})\n{{\n{inputs}{unused}{calls}}}\n\n")
    }

    fn prepare_value(&self, text: &mut String, value: Value, part: usize) {
        let node = self.function().node(value);
        let operands: Vec<BoundText> = node
            .operands()
            .iter()
            .map(|&operand| self.shared_operand(operand, part))
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

    fn shared_operand(&self, operand: Operand, part: usize) -> BoundText {
        let text = match operand.kind() {
            OperandKind::Value(value) if self.prepared.part_of[value.index()] == Some(part) => {
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
                let index = self.function().input_array(input);
                let array = &self.function().inputs()[index];
                let name = &self.names.inputs[index];
                match array.shape {
                    Shape::Scalar => name.clone(),
                    Shape::Vector(_) | Shape::Matrix(..) => {
                        format!("{name}[{}]", place(array, input.0 - array.offset))
                    }
                }
            }
            OperandKind::Constant(constant) => {
                return lane_literal(self.function().constant_number(constant), self.options.real);
            }
            OperandKind::None => unreachable!("an operation has all its operands"),
        };
        BoundText::primary(text)
    }
}
