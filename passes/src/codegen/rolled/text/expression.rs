//! Expressions: operations, and where what they read is.

use super::super::program::{Index, Place, Source, Space};
use super::super::statements::Step;
use super::{Real, Writer, literal};
use robovec_ir::{Operation, Shape};
use std::fmt::Write;

impl Writer<'_> {
    /// The expression of a statement: its template applied to its leaves.
    pub(super) fn expression(&self, position: usize) -> String {
        let code = &self.program.codes[position];
        let mut leaves = code.sources.iter().map(|source| self.source_text(source));
        let mut stack: Vec<(String, u8)> = Vec::new();
        for step in &self.program.templates[code.template as usize].steps {
            let done = match *step {
                Step::Leaf => leaves.next(),
                Step::Apply(operation) => {
                    let operands = stack.split_off(stack.len() - operation.arity());
                    Some(apply(operation, &operands, self.real))
                }
            };
            stack.extend(done);
        }
        stack.pop().map_or_else(String::new, |(text, _)| text)
    }

    pub(super) fn source_text(&self, source: &Source) -> (String, u8) {
        match source {
            Source::Position(position) => (self.variables[*position].clone(), PRIMARY),
            Source::Carried(carried) => (self.carried[*carried].clone(), PRIMARY),
            Source::Place(place) => (self.place(place), PRIMARY),
            Source::Number(number) => {
                let text = literal(*number, self.real);
                let binding = if text.starts_with('-') {
                    UNARY
                } else {
                    PRIMARY
                };
                (text, binding)
            }
        }
    }

    pub(super) fn place(&self, place: &Place) -> String {
        self.at(
            place.space,
            &self.index(&place.row),
            &self.index(&place.column),
        )
    }

    pub(super) fn at(&self, space: Space, row: &str, column: &str) -> String {
        let (array, name, pointer) = match space {
            Space::Work => return format!("{}[{column}]", self.work),
            Space::Constants => return format!("{}[{column}]", self.constants),
            Space::Input(array) => (&self.function.inputs()[array], &self.inputs[array], false),
            Space::Output(array) => (&self.function.outputs()[array], &self.outputs[array], true),
        };
        match array.shape {
            Shape::Scalar if pointer => format!("*{name}"),
            Shape::Scalar => name.clone(),
            Shape::Vector(_) => format!("{name}[{column}]"),
            Shape::Matrix(..) => format!("{name}[{row}][{column}]"),
        }
    }

    pub(super) fn index(&self, index: &Index) -> String {
        let mut text = String::new();
        let mut term = |negative: bool, term: String| {
            let sign = match (text.is_empty(), negative) {
                (true, false) => "",
                (true, true) => "-",
                (false, false) => " + ",
                (false, true) => " - ",
            };
            text.push_str(sign);
            text.push_str(&term);
        };
        if let Some((table, number)) = index.table {
            let (table, counter) = (&self.tables[table], &self.counters[number]);
            term(false, format!("{table}[{counter}]"));
        }
        for &(number, factor) in &index.factors {
            let name = &self.indices[number];
            let size = factor.unsigned_abs();
            let product = if size == 1 {
                name.clone()
            } else {
                format!("{size} * {name}")
            };
            term(factor < 0, product);
        }
        if index.base != 0 || text.is_empty() {
            let mut base = String::new();
            let _ = write!(base, "{}", index.base.unsigned_abs());
            let sign = match (text.is_empty(), index.base < 0) {
                (true, false) => "",
                (true, true) => "-",
                (false, false) => " + ",
                (false, true) => " - ",
            };
            text.push_str(sign);
            text.push_str(&base);
        }
        text
    }
}

const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const UNARY: u8 = 3;
const PRIMARY: u8 = 4;

/// An operation on expressions, and how tightly the result binds.
fn apply(operation: Operation, operands: &[(String, u8)], real: Real) -> (String, u8) {
    let double = real == Real::Double;
    let operand = |number: usize, binding: u8| {
        let (text, own) = &operands[number];
        if *own < binding {
            format!("({text})")
        } else {
            text.clone()
        }
    };
    let binary = |sign: &str, binding: u8| {
        let (left, right) = (operand(0, binding), operand(1, binding + 1));
        (format!("{left} {sign} {right}"), binding)
    };
    match operation {
        Operation::Copy => (operand(0, PRIMARY), PRIMARY),
        Operation::Neg => (format!("-{}", operand(0, PRIMARY)), UNARY),
        Operation::Add => binary("+", SUM),
        Operation::Sub => binary("-", SUM),
        Operation::Mul => binary("*", PRODUCT),
        Operation::Div => binary("/", PRODUCT),
        Operation::Sin | Operation::Cos if !double => {
            let text = format!("(float){}((double){})", operation.name(), operand(0, UNARY));
            (text, UNARY)
        }
        Operation::Sqrt if !double => (format!("sqrtf({})", operand(0, 0)), PRIMARY),
        Operation::Sin | Operation::Cos | Operation::Sqrt => {
            (format!("{}({})", operation.name(), operand(0, 0)), PRIMARY)
        }
        Operation::Fma | Operation::Fms | Operation::Fnma => {
            let function = if double { "fma" } else { "fmaf" };
            let first = match operation {
                Operation::Fnma => format!("-{}", operand(0, PRIMARY)),
                _ => operand(0, 0),
            };
            let last = match operation {
                Operation::Fms => format!("-{}", operand(2, PRIMARY)),
                _ => operand(2, 0),
            };
            let middle = operand(1, 0);
            (format!("{function}({first}, {middle}, {last})"), PRIMARY)
        }
    }
}
