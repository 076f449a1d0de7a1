//! Definitions by equations: names, elements and outputs.

use super::{EmittedFunction, FunctionEmitter, LATER, Later, SymbolSet};
use crate::Language;
use crate::explain::refusal;
use crate::lower::scan::{READ_BACK, REWRITTEN};
use crate::syntax::{LeafKind, StatementKind, SyntaxLeaf};
use crate::token::{RobotranName, SourceSpan};
use robovec_ir::diagnostic::{Diagnostic, Label};
use robovec_ir::{Name, Node, Operand, Operation, Output, SourceSet, Symbol, Value};

impl<'e, 'a, 't> FunctionEmitter<'e, 'a, 't> {
    pub(super) fn set_definition(&mut self, symbol: Symbol, operand: Operand) {
        if symbol.index() >= self.shared.definitions.len() {
            let length = symbol.index() + 1;
            self.shared.definitions.resize(length, Operand::NONE);
        }
        self.shared.definitions[symbol.index()] = operand;
        self.defined.push(symbol);
    }

    pub(super) fn define(
        &mut self,
        name: RobotranName,
        operand: Operand,
        fresh: bool,
        sources: SourceSet,
    ) {
        let symbol = name.symbol();
        if self.shared.language == Language::C && name.is_of_data() {
            self.member_of_data(symbol);
            return;
        }
        if self.signature.given.contains(&name) && self.storage.find(name).is_none() {
            self.errors.push(refusal(
                "a parameter is assigned to",
                self.shared.syntax.statements[self.statement].span,
                "from here on it would mean another number",
                "give the number another name",
            ));
            return;
        }
        if self.storage.find(name).is_some() {
            self.errors.push(refusal(
                "an array is assigned to without an index",
                self.shared.syntax.statements[self.statement].span,
                "which element is meant?",
                "write the index, or give the temporary another name",
            ));
            return;
        }
        if self.names.is_defined(symbol) && self.crossing.is_none() {
            self.defined_twice(symbol);
            return;
        }
        let name = self.names.scalar(symbol);
        let value = self.named(name, operand, fresh, sources);
        self.set_definition(symbol, value);
    }

    /// Names a value: a new node itself, of any other value a copy.
    pub(super) fn named(
        &mut self,
        name: Name,
        operand: Operand,
        fresh: bool,
        sources: SourceSet,
    ) -> Operand {
        if fresh && let Some(value) = operand.value() {
            self.function.node_mut(value).name = name;
            return operand;
        }
        Operand::from(self.function.push(Node {
            name,
            sources,
            operands: Operand::list([operand]),
            operation: Operation::Copy,
        }))
    }

    /// The output element of a slot that is written once and never read back.
    pub(super) fn plain_output(&self, slot: u32) -> Option<Output> {
        let (array, _, _) = self.storage.element(slot);
        let output = self.outputs[self.storage.find(array.name)? as usize]?;
        let plain = self.scan.flags[slot as usize] & (REWRITTEN | READ_BACK) == 0;
        plain.then_some(Output(output.offset + (slot - array.offset)))
    }

    pub(in crate::lower) fn write(
        &mut self,
        slot: u32,
        operand: Operand,
        fresh: bool,
        sources: SourceSet,
    ) {
        if let Some(output) = self.plain_output(slot) {
            self.function.assign(output, operand, sources);
            return;
        }
        let (array, indices, rank) = self.storage.element(slot);
        let symbols = &mut self.shared.tables.symbols;
        let name = self
            .names
            .element(symbols, array.name.symbol(), &indices[..rank]);
        let value = self.named(name, operand, fresh, sources);
        if self.elements[slot as usize].is_none() {
            self.named_elements.push(slot);
        }
        self.elements[slot as usize] = value;
    }

    /// Appends the expressions after all definitions, in order of outputs.
    fn append_trees(&mut self) {
        let Later { nodes, mut trees } = std::mem::take(&mut self.later);
        trees.sort_by_key(|&(output, _)| output);
        for (output, run) in trees {
            let base = self.function.nodes().len() as u32;
            let moved = |operand: Operand| match operand.value() {
                Some(Value(index)) if index >= LATER => Operand::from(Value(base + index - LATER)),
                Some(_) | None => operand,
            };
            let mut root = None;
            for node in &nodes[run] {
                root = Some(self.function.push(Node {
                    operands: node.operands.map(moved),
                    ..*node
                }));
            }
            if let Some(root) = root {
                self.function.assign(
                    output,
                    Operand::from(root),
                    self.function.node(root).sources,
                );
            }
        }
    }

    /// Finishes the function: last values of elements, and scalars for others.
    pub(in crate::lower) fn finish(mut self) -> EmittedFunction {
        for slot in std::mem::take(&mut self.named_elements) {
            let number = self.storage.array_of(slot);
            let array = &self.storage.arrays[number];
            let operand = self.elements[slot as usize];
            if let (Some(output), Some(node)) = (self.outputs[number], operand.value()) {
                let sources = self.function.node(node).sources;
                self.function.assign(
                    Output(output.offset + (slot - array.offset)),
                    operand,
                    sources,
                );
            }
        }
        if let Some(crossing) = self.crossing {
            let mut seen = SymbolSet::default();
            for symbol in self.defined.clone() {
                let operand = self.shared.definitions[symbol.index()];
                if crossing.outputs.contains(&symbol)
                    && seen.insert(symbol)
                    && let Some(node) = operand.value()
                {
                    let sources = self.function.node(node).sources;
                    self.scalar_output(symbol, operand, sources);
                }
            }
        }
        assert!(
            self.function.nodes().len() < LATER as usize,
            "later expressions are numbered after all others"
        );
        self.append_trees();
        self.function.sort_assignments();
        for symbol in self.defined {
            self.shared.definitions[symbol.index()] = Operand::NONE;
        }
        EmittedFunction {
            function: self.function,
            missing: self.missing,
            errors: self.errors,
            warnings: self.warnings,
        }
    }
}

impl<'e, 'a, 't> FunctionEmitter<'e, 'a, 't> {
    /// A number of the structure of unknown type, or hidden by a variable.
    pub(super) fn member_of_data(&mut self, symbol: Symbol) {
        if !self.missing_known.insert(symbol) {
            return;
        }
        let text = self.shared.tables.symbols.text(symbol).to_owned();
        self.errors.push(refusal(
            &format!("`{text}` of the data structure is used as a number"),
            self.shared.syntax.statements[self.statement].span,
            "its type and its number are not known here",
            "the inputs of the equations are the arrays of the structure and the time `tsim`",
        ));
    }

    pub(super) fn whole_number(&mut self, symbol: Symbol) {
        if !self.missing_known.insert(symbol) {
            return;
        }
        let text = self.shared.tables.symbols.text(symbol).to_owned();
        self.errors.push(refusal(
            &format!("`{text}` is a whole number and is read in an equation"),
            self.shared.syntax.statements[self.statement].span,
            "whole numbers are divided and rounded in another way",
            "declare it `double`, or write its number in its place",
        ));
    }

    pub(in crate::lower) fn both_scalar_and_array(&mut self, symbol: Symbol) {
        let text = self.shared.tables.symbols.text(symbol).to_owned();
        self.errors.push(refusal(
            &format!("`{text}` is used as a number and as an array"),
            self.shared.syntax.statements[self.statement].span,
            "as a number here",
            "write the index, or give one of the two another name",
        ));
    }

    pub(in crate::lower) fn defined_twice(&mut self, symbol: Symbol) {
        let text = self.shared.tables.symbols.text(symbol).to_owned();
        let again = self.shared.syntax.statements[self.statement].span;
        let first = self.first_definition(symbol);
        self.errors.push(
            Diagnostic::error()
                .with_message(format!("`{text}` is defined twice"))
                .with_labels(vec![
                    Label::primary(0, again.range()).with_message("defined again here"),
                    Label::secondary(0, first.range()).with_message("first defined here"),
                ])
                .with_note("every temporary has one equation; rename or delete one of the two"),
        );
    }

    fn first_definition(&self, symbol: Symbol) -> SourceSpan {
        let mut statements = self.shared.syntax.statements[..self.statement].iter();
        let found = statements.rfind(|statement| match statement.kind {
            StatementKind::Equation { target, .. } => defines(Some(target), symbol),
            StatementKind::Call(call) => {
                defines(self.shared.syntax.calls[call as usize].target, symbol)
            }
            _ => false,
        });
        found.expect("what is defined has a definition").span
    }
}

/// True for the assignment to a scalar.
fn defines(target: Option<SyntaxLeaf>, symbol: Symbol) -> bool {
    let kind = target.map(SyntaxLeaf::kind);
    matches!(kind, Some(LeafKind::Scalar(name)) if name.symbol() == symbol)
}
