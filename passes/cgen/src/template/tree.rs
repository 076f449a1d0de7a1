//! The function as a target needs it: names, statements, expressions.

use super::description::TargetTexts;
use crate::c::layout::indices;
use crate::emit::expression::{BoundText, Tightness};
use crate::emit::inlining::Inlining;
use crate::emit::names::CNames;
use robovec_analysis::slice::live;
use robovec_ir::{
    Array, Constant, Function, Input, Operand, OperandKind, Operation, Output, Shape, Value, View,
};
use std::collections::BTreeSet;

/// The function with everything that its text needs.
#[derive(Debug)]
pub(super) struct TargetTree {
    pub(super) function: Function,
    texts: TargetTexts,
    /// Name of the function in the target.
    pub(super) title: String,
    /// Names of the arrays.
    inputs: Vec<String>,
    outputs: Vec<String>,
    /// Names of elements of inputs and of constants; empty if the texts of the
    /// target do not use them.
    elements: Vec<String>,
    constants: Vec<String>,
    /// Names of values; empty for those without a statement.
    values: Vec<String>,
    inlined: Vec<bool>,
    /// Operands of copies, in targets without copies.
    copied: Vec<Option<Operand>>,
    /// Values with a statement, in program order.
    pub(super) statements: Vec<Value>,
    /// Elements of inputs and constants that are read.
    pub(super) read_inputs: Vec<Input>,
    pub(super) read_constants: Vec<Constant>,
    /// For each element of the outputs what it is set to; others are zero.
    pub(super) set: Vec<Option<Operand>>,
    zero: Constant,
}

impl TargetTree {
    pub(super) fn new(view: View<'_>, texts: &TargetTexts) -> TargetTree {
        let mut function = view.function.clone();
        let zero = function.constant(0.0);
        let view = View {
            function: &function,
            ..view
        };
        let mut tree = TargetTree {
            title: String::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            elements: Vec::new(),
            constants: Vec::new(),
            values: Vec::new(),
            inlined: vec![false; function.nodes().len()],
            copied: vec![None; function.nodes().len()],
            statements: Vec::new(),
            read_inputs: Vec::new(),
            read_constants: Vec::new(),
            set: vec![None; function.output_len()],
            zero,
            texts: texts.clone(),
            function: Function::new("", function.level),
        };
        for assignment in &function.assignments {
            tree.set[assignment.output.index()] = Some(assignment.operand);
        }
        tree.choose_statements(&function);
        tree.find_reads(&function);
        tree.take_names(view);
        tree.function = function;
        tree
    }

    /// Decides which operations are statements.
    fn choose_statements(&mut self, function: &Function) {
        let has_copies = self.texts.operation(Operation::Copy).is_some();
        let mut is_copied = vec![false; function.nodes().len()];
        for (value, node) in function.values() {
            if node.operation == Operation::Copy && !has_copies {
                self.copied[value.index()] = Some(self.source(node.operands[0]));
                let inner = node.operands[0].value();
                inner.inspect(|inner| is_copied[inner.index()] = true);
            }
        }
        if self.texts.is_nested {
            // A copied value can have several readers.
            self.inlined = Inlining::new(function, |value, node| {
                node.name.is_none() && !is_copied[value.index()]
            })
            .inlined;
        }
        let live = live(function);
        for (value, _) in function.values() {
            let is_written = live[value.index()] && self.copied[value.index()].is_none();
            self.inlined[value.index()] &= is_written;
            if is_written && !self.inlined[value.index()] {
                self.statements.push(value);
            }
        }
    }

    /// Finds the elements and constants that statements and outputs read.
    fn find_reads(&mut self, function: &Function) {
        let mut inputs = vec![false; function.input_len()];
        let mut constants = vec![false; function.constants().len()];
        let mut open: Vec<Operand> = (self.set.iter())
            .map(|set| set.unwrap_or(self.zero.into()))
            .collect();
        let statements = self.statements.iter();
        open.extend(statements.flat_map(|&value| function.node(value).operands()));
        while let Some(operand) = open.pop() {
            match self.source(operand).kind() {
                OperandKind::Input(input) => inputs[input.index()] = true,
                OperandKind::Constant(constant) => constants[constant.index()] = true,
                OperandKind::Value(value) if self.inlined[value.index()] => {
                    open.extend(function.node(value).operands());
                }
                OperandKind::Value(_) | OperandKind::None => {}
            }
        }
        let read = |flags: Vec<bool>| (0..flags.len() as u32).filter(move |&k| flags[k as usize]);
        self.read_inputs = read(inputs).map(Input).collect();
        self.read_constants = read(constants).map(Constant).collect();
    }

    fn take_names(&mut self, view: View<'_>) {
        let function = view.function;
        let mut names = CNames::reserving(&self.texts.reserved);
        self.title = names.take(&function.name);
        self.inputs = names.take_arrays(view, function.inputs());
        self.outputs = names.take_arrays(view, function.outputs());
        if self.texts.elements.iter().any(|text| text.has(4)) {
            self.elements = vec![String::new(); function.input_len()];
            for input in &self.read_inputs {
                let (_, indices, rank) = function.input_element(*input);
                let mut wanted = self.inputs[function.input_array(*input)].clone();
                for index in &indices[..rank] {
                    wanted += &format!("_{index}");
                }
                self.elements[input.index()] = names.take(&wanted);
            }
        }
        if self.texts.constant.has(1) {
            self.constants = vec![String::new(); function.constants().len()];
            for constant in &self.read_constants {
                let index = constant.index();
                self.constants[index] = names.take(&format!("number_{index}"));
            }
        }
        self.values = vec![String::new(); function.nodes().len()];
        for value in &self.statements {
            self.values[value.index()] = names.take_value(view, *value);
        }
    }

    /// The operations of the text.
    fn used(&self) -> impl Iterator<Item = Operation> {
        let values = self.function.values();
        let is_written = |index: usize| self.inlined[index] || !self.values[index].is_empty();
        let written = values.filter(move |(value, _)| is_written(value.index()));
        written.map(|(_, node)| node.operation)
    }

    /// The names of the operations of the text, each once.
    pub(super) fn operations(&self) -> Vec<&'static str> {
        let used: BTreeSet<Operation> = self.used().collect();
        used.into_iter().map(Operation::name).collect()
    }

    /// The first operation or number of the text that the target has no text for.
    pub(super) fn missing(&self) -> Option<String> {
        let mut operations = self.used();
        if let Some(operation) = operations.find(|&used| self.texts.operation(used).is_none()) {
            return Some(format!("'{}'", operation.name()));
        }
        let numbers = self.read_constants.iter();
        let mut numbers = numbers.map(|&constant| self.function.constant_number(constant));
        let missing = numbers.find(|&number| self.texts.number(number).is_none())?;
        Some(format!("the number {missing}"))
    }

    /// The operand, or what it is a copy of.
    fn source(&self, operand: Operand) -> Operand {
        let copied = operand.value().and_then(|value| self.copied[value.index()]);
        copied.unwrap_or(operand)
    }

    /// The name of a value.
    pub(super) fn value_name(&self, value: Value) -> &str {
        &self.values[value.index()]
    }

    /// The name of a constant, if the target names constants.
    pub(super) fn constant_name(&self, constant: Constant) -> &str {
        self.constants
            .get(constant.index())
            .map_or("", String::as_str)
    }

    /// The name of an element of an input, if the target names elements.
    pub(super) fn element_name(&self, input: Input) -> &str {
        self.elements.get(input.index()).map_or("", String::as_str)
    }

    /// The arrays of one side, and their names.
    pub(super) fn arrays(&self, is_output: bool) -> (&[Array], &[String]) {
        if is_output {
            (self.function.outputs(), &self.outputs)
        } else {
            (self.function.inputs(), &self.inputs)
        }
    }

    /// Place of an element in its array: index, row and column.
    pub(super) fn place(&self, is_output: bool, array: usize, offset: u32) -> [u32; 3] {
        let [row, column] = indices(self.arrays(is_output).0[array].shape, offset);
        [offset, row, column].map(|index| index + self.texts.base)
    }

    /// An element of an array, as an expression.
    pub(super) fn element(&self, is_output: bool, array: usize, offset: u32) -> String {
        let (arrays, names) = self.arrays(is_output);
        let text = match arrays[array].shape {
            Shape::Scalar => &self.texts.elements[0],
            Shape::Vector(_) => &self.texts.elements[1],
            Shape::Matrix(..) => &self.texts.elements[2],
        };
        let place = self.place(is_output, array, offset);
        text.fill(|field| match field {
            0 => names[array].clone(),
            4 if is_output => String::new(),
            4 => {
                let input = Input(arrays[array].offset + offset);
                self.element_name(input).to_owned()
            }
            direction => place[direction - 1].to_string(),
        })
    }

    /// The number of a constant, as the target writes it.
    pub(super) fn number(&self, constant: Constant) -> String {
        let text = self.texts.number(self.function.constant_number(constant));
        text.expect("numbers without a text are refused")
    }

    /// Operand that an element of the outputs is set to.
    pub(super) fn assigned(&self, output: Output) -> Operand {
        self.set[output.index()].unwrap_or(self.zero.into())
    }

    pub(super) fn operand(&self, operand: Operand) -> BoundText {
        match self.source(operand).kind() {
            OperandKind::Value(value) if self.inlined[value.index()] => self.expression(value),
            OperandKind::Value(value) => {
                let name = self.value_name(value).to_owned();
                BoundText::primary(self.texts.value.fill(|_| name.clone()))
            }
            OperandKind::Input(input) => {
                let array = self.function.input_array(input);
                let offset = input.0 - self.function.inputs()[array].offset;
                BoundText::primary(self.element(false, array, offset))
            }
            OperandKind::Constant(constant) => {
                let text = self.texts.constant.fill(|field| match field {
                    0 => self.number(constant),
                    _ => self.constant_name(constant).to_owned(),
                });
                let tightness = match text.starts_with('-') {
                    true => Tightness::Unary,
                    false => Tightness::Primary,
                };
                BoundText::new(text, tightness)
            }
            OperandKind::None => unreachable!("an operation has all its operands"),
        }
    }

    /// The expression of a value; it holds a bounded number of others.
    pub(super) fn expression(&self, value: Value) -> BoundText {
        let node = self.function.node(value);
        let text = self.texts.operation(node.operation);
        let text = text.expect("operations without a text are refused");
        if text.pattern.is_field() {
            return self.operand(node.operands[0]);
        }
        let written = text.pattern.fill(|field| match node.operands().get(field) {
            Some(&operand) => self.operand(operand).within(text.least[field]),
            None => self.value_name(value).to_owned(),
        });
        BoundText::new(written, text.tightness)
    }
}
