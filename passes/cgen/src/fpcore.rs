//! FPCore text (<https://fpbench.org/spec/fpcore-2.0.html>), for the tools
//! that bound or lower rounding errors: Daisy, FPTaylor, Satire, Herbie.
//!
//! A core has one result, so that a function gives a core for every output,
//! with the operations that this output needs. Array elements become scalars
//! (`q[3]` is `q_3`), and ranges of a scene the precondition.

use super::emit::Real;
use super::emit::inlining::Inlining;
use robovec_ir::print::{print_operand, print_output};
use robovec_ir::states::Ranges;
use robovec_ir::{Assignment, Input, Operand, OperandKind, Operation, Value, View};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The longest text, in bytes: an expression shared by outputs is repeated for
/// each of them.
const LONGEST: usize = 1 << 28;

/// The text of all cores of a function; `None` when it would be too long.
pub fn fpcore(view: View<'_>, real: Real, ranges: &Ranges) -> Option<String> {
    let function = view.function;
    let inlining = Inlining::new(function, |_, node| node.name.is_none());
    let writer = CoreWriter {
        view,
        real,
        ranges,
        inlined: &inlining.inlined,
        names: names(view),
    };
    let mut text = String::new();
    for assignment in &function.assignments {
        if !text.is_empty() {
            text.push('\n');
        }
        writer.core(assignment, &mut text);
        if text.len() > LONGEST {
            return None;
        }
    }
    Some(text)
}

/// Words that represent numbers in FPCore, or truths.
const CONSTANTS: &str = "E FALSE INFINITY LN10 LN2 LOG10E LOG2E M_1_PI M_2_PI M_2_SQRTPI NAN PI \
    PI_2 PI_4 SQRT1_2 SQRT2 TRUE";

/// The names of the inputs, then of the values.
fn names(view: View<'_>) -> (Vec<String>, Vec<String>) {
    let mut taken: BTreeMap<String, u64> = BTreeMap::new();
    taken.extend(CONSTANTS.split(' ').map(|name| (name.to_owned(), 1)));
    let mut name = |wish: &str| {
        let wish = word(wish);
        let mut number = taken.get(&wish).copied().unwrap_or(0);
        let mut free = wish.clone();
        while taken.contains_key(&free) {
            number += 1;
            free = format!("{wish}_{number}");
        }
        taken.insert(wish, number);
        taken.entry(free.clone()).or_insert(0);
        free
    };
    let function = view.function;
    let inputs = 0..function.input_len() as u32;
    let inputs = inputs.map(|input| name(&print_operand(view, Input(input).into())));
    let inputs = inputs.collect();
    let values = function.values().map(|(value, node)| {
        let symbols = &view.tables.symbols;
        if node.name.is_none() {
            name(&format!("v{}", value.0))
        } else {
            name(&node.name.display(symbols))
        }
    });
    (inputs, values.collect())
}

/// A name of letters, digits and `_`: `M[1,2]` is `M_1_2`.
fn word(name: &str) -> String {
    let name = name.trim_end_matches(']');
    let fits = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    name.chars().map(fits).collect()
}

/// A number as FPCore writes it, with all its digits.
fn number(number: f64) -> String {
    if number.is_nan() {
        return "NAN".to_owned();
    }
    if number.is_infinite() {
        let sign = if number > 0.0 {
            "INFINITY"
        } else {
            "(- INFINITY)"
        };
        return sign.to_owned();
    }
    let digits = format!("{number:?}");
    digits.strip_suffix(".0").unwrap_or(&digits).to_owned()
}

struct CoreWriter<'a> {
    view: View<'a>,
    real: Real,
    ranges: &'a Ranges,
    inlined: &'a [bool],
    names: (Vec<String>, Vec<String>),
}

/// Piece of an expression that is still to be written.
enum Piece {
    Operand(Operand),
    Text(&'static str),
}

impl CoreWriter<'_> {
    /// Writes the core of an output. Writing to a string cannot fail.
    fn core(&self, assignment: &Assignment, text: &mut String) {
        let function = self.view.function;
        let (needed, read) = self.cone(assignment.operand);
        let only = function.assignments.len() == 1;
        let inputs = (0..function.input_len()).filter(|&input| only || read.contains(&input));
        let inputs: Vec<usize> = inputs.collect();
        let arguments: Vec<&str> = inputs.iter().map(|&i| self.names.0[i].as_str()).collect();
        let _ = writeln!(text, "(FPCore ({})", arguments.join(" "));
        let title = if only {
            function.name.clone()
        } else {
            let output = print_output(self.view, assignment.output);
            format!("{}_{}", function.name, word(&output))
        };
        let _ = writeln!(text, " :name \"{title}\"");
        let precision = match self.real {
            Real::Double => "binary64",
            Real::Float => "binary32",
        };
        let _ = writeln!(text, " :precision {precision}");
        self.precondition(&inputs, text);
        let bound = needed.iter().filter(|value| !self.inlined[value.index()]);
        let bound: Vec<Value> = bound.copied().collect();
        let (last, bound) = match bound.split_last() {
            // The result need not have a name.
            Some((last, rest)) if Some(*last) == assignment.operand.value() => (Some(*last), rest),
            _ => (None, bound.as_slice()),
        };
        for (place, &value) in bound.iter().enumerate() {
            text.push_str(if place == 0 { " (let* (" } else { "\n        " });
            let _ = write!(text, "[{} ", self.names.1[value.index()]);
            self.operation(value, text);
            text.push(']');
        }
        text.push_str(if bound.is_empty() { " " } else { ")\n  " });
        match last {
            Some(last) => self.operation(last, text),
            None => self.pieces(vec![Piece::Operand(assignment.operand)], text),
        }
        text.push_str(if bound.is_empty() { ")\n" } else { "))\n" });
    }

    /// The values that an operand needs, in order, and the inputs.
    fn cone(&self, operand: Operand) -> (Vec<Value>, BTreeSet<usize>) {
        let (mut values, mut inputs) = (BTreeSet::new(), BTreeSet::new());
        let mut open = vec![operand];
        while let Some(operand) = open.pop() {
            if let Some(input) = operand.input() {
                inputs.insert(input.index());
            }
            if let Some(value) = operand.value().filter(|&value| values.insert(value)) {
                open.extend(self.view.function.node(value).operands());
            }
        }
        (values.into_iter().collect(), inputs)
    }

    /// Writes the known ranges of the inputs.
    fn precondition(&self, inputs: &[usize], text: &mut String) {
        let function = self.view.function;
        let mut conditions = Vec::new();
        for &input in inputs {
            let (array, indices, _) = function.input_element(Input(input as u32));
            let array = self.view.tables.symbols.text(array.name);
            if let Some([low, high]) = self.ranges.get(array, indices) {
                let name = &self.names.0[input];
                conditions.push(format!("(<= {} {name} {})", number(low), number(high)));
            }
        }
        let _ = match conditions.as_slice() {
            [] => Ok(()),
            [one] => writeln!(text, " :pre {one}"),
            several => writeln!(text, " :pre (and {})", several.join("\n           ")),
        };
    }

    /// Writes a value's operation with the values inside it.
    fn operation(&self, value: Value, text: &mut String) {
        let mut pieces = Vec::new();
        self.open(value, &mut pieces);
        self.pieces(pieces, text);
    }

    /// Writes pieces, the last one first.
    fn pieces(&self, mut pieces: Vec<Piece>, text: &mut String) {
        while let Some(piece) = pieces.pop() {
            let operand = match piece {
                Piece::Text(part) => {
                    text.push_str(part);
                    continue;
                }
                Piece::Operand(operand) => operand,
            };
            match operand.kind() {
                OperandKind::Value(value) if self.inlined[value.index()] => {
                    self.open(value, &mut pieces);
                }
                OperandKind::Value(value) => text.push_str(&self.names.1[value.index()]),
                OperandKind::Input(input) => text.push_str(&self.names.0[input.index()]),
                OperandKind::Constant(constant) => {
                    text.push_str(&number(self.view.function.constant_number(constant)));
                }
                OperandKind::None => {}
            }
        }
    }

    /// Puts an operation among the pieces, the last one first.
    fn open(&self, value: Value, pieces: &mut Vec<Piece>) {
        let node = self.view.function.node(value);
        let [a, b, c] = node.operands.map(Piece::Operand);
        let text = Piece::Text;
        let parts = match node.operation {
            Operation::Copy => vec![a],
            Operation::Neg => vec![text("(- "), a, text(")")],
            Operation::Add => vec![text("(+ "), a, text(" "), b, text(")")],
            Operation::Sub => vec![text("(- "), a, text(" "), b, text(")")],
            Operation::Mul => vec![text("(* "), a, text(" "), b, text(")")],
            Operation::Div => vec![text("(/ "), a, text(" "), b, text(")")],
            Operation::Sin => vec![text("(sin "), a, text(")")],
            Operation::Cos => vec![text("(cos "), a, text(")")],
            Operation::Sqrt => vec![text("(sqrt "), a, text(")")],
            Operation::Fma => vec![text("(fma "), a, text(" "), b, text(" "), c, text(")")],
            // A sign rounds nothing.
            Operation::Fms => {
                vec![text("(fma "), a, text(" "), b, text(" (- "), c, text("))")]
            }
            Operation::Fnma => {
                vec![text("(fma (- "), a, text(") "), b, text(" "), c, text(")")]
            }
        };
        pieces.extend(parts.into_iter().rev());
    }
}
