//! Calls of user functions: the boundaries of compilation.
//!
//! The arguments of a call become outputs of the function and its result an
//! input. Robotran passes arrays it has filled, the scalars `Z` and `Zd`, and
//! words without meaning here (`s`, `tsim`, the number of the call).

use super::emit::FunctionEmitter;
use crate::explain::refusal;
use crate::syntax::{LeafKind, SyntaxLeaf};
use crate::token::SourceSpan;
use robovec_ir::diagnostic::{Diagnostic, Label};
use robovec_ir::{Boundary, Operand, Output, Shape, SourceSet, Symbol};

impl FunctionEmitter<'_, '_, '_> {
    /// Turns the call of a user function into a boundary.
    pub(super) fn call(&mut self, call: u32, span: SourceSpan) {
        let syntax = self.shared.syntax;
        let call = syntax.calls[call as usize];
        let callee = self
            .shared
            .tables
            .symbols
            .text(call.callee.symbol())
            .to_owned();
        if !callee.starts_with("user_") && !callee.starts_with("usrfun.") {
            let (first, last) = call.arguments;
            let arguments = &syntax.arguments[first as usize..last as usize];
            // What is handed over by its place may be changed.
            let shared = arguments.iter().any(|argument| {
                argument.leaf == SyntaxLeaf::NONE
                    || matches!(argument.leaf.kind(), LeafKind::Scalar(_))
            });
            self.unknown_call(&callee, (call.target.is_some(), shared), span);
            if let Some(LeafKind::Scalar(name)) = call.target.map(SyntaxLeaf::kind) {
                // One message about it is enough.
                self.missing_known.insert(name.symbol());
            }
            return;
        }
        let sources = self.sources(span);
        let (first, last) = call.arguments;
        let mut arguments = Vec::new();
        for argument in &syntax.arguments[first as usize..last as usize] {
            let text = &self.shared.text[argument.span.range()];
            arguments.push(text.split_whitespace().collect::<Vec<_>>().join(" "));
            if argument.leaf != SyntaxLeaf::NONE {
                self.argument(argument.leaf, argument.span);
            }
        }
        let result = call.target.map(|target| self.result(target, sources));
        self.function.boundaries.push(Boundary {
            callee,
            arguments,
            result,
            sources,
        });
    }

    fn argument(&mut self, leaf: SyntaxLeaf, span: SourceSpan) {
        match leaf.kind() {
            LeafKind::Scalar(name) => {
                let value = self.shared.definitions[name.symbol().index()];
                if self.storage.find(name).is_none()
                    && let Some(node) = value.value()
                    && self.passed_scalars.insert(name.symbol())
                {
                    let sources = self.function.node(node).sources;
                    self.scalar_output(name.symbol(), value, sources);
                }
            }
            LeafKind::Node(_) => self.errors.push(refusal(
                "a user function is called with an expression",
                span,
                "it has no name that could be passed",
                "assign it to a name first and pass that",
            )),
            LeafKind::Number(_) => {
                // The text goes into files of all languages.
                let text = &self.shared.text[span.range()];
                let plain = text.bytes().all(|byte| byte.is_ascii_digit());
                if !plain || (text.len() > 1 && text.starts_with('0')) {
                    self.errors.push(refusal(
                        "a user function is called with a number that is not a plain whole number",
                        span,
                        "the number of the call is expected here",
                        "write it in decimal digits, or assign another number to a name and pass that",
                    ));
                }
            }
            LeafKind::Element(_) => {}
        }
    }

    pub(super) fn scalar_output(&mut self, symbol: Symbol, operand: Operand, sources: SourceSet) {
        if !self.declared_outputs.insert(symbol) {
            self.both_scalar_and_array(symbol);
        }
        let array = self.function.add_output(symbol, Shape::Scalar);
        self.function.assign(Output(array.offset), operand, sources);
    }

    /// The input that holds the result of a call.
    fn result(&mut self, target: SyntaxLeaf, sources: SourceSet) -> String {
        match target.kind() {
            LeafKind::Element(element) => {
                let slot = self.shared.syntax.elements[element as usize].row;
                let (array, indices, rank) = self.storage.element(slot);
                let symbols = &mut self.shared.tables.symbols;
                let name = self
                    .names
                    .element(symbols, array.name.symbol(), &indices[..rank]);
                let operand = self.scalar_input(name.base);
                self.write(slot, operand, false, sources);
                self.shared.tables.symbols.text(name.base).to_owned()
            }
            LeafKind::Scalar(name) => {
                let symbol = name.symbol();
                if let Some(array) = self.storage.find(name) {
                    // A result that no equation reads is an input all the same.
                    self.declare_input(array);
                } else {
                    if self.names.is_defined(symbol) && self.crossing.is_none() {
                        self.defined_twice(symbol);
                    } else {
                        let _ = self.names.scalar(symbol);
                        self.scalar_input(symbol);
                    }
                }
                self.shared.tables.symbols.text(symbol).to_owned()
            }
            LeafKind::Node(_) | LeafKind::Number(_) => String::new(),
        }
    }

    /// Refuses a call whose result is read or which may change a number, and
    /// warns of others; `shared`: an array, structure or place is handed over.
    fn unknown_call(&mut self, callee: &str, (has_target, shared): (bool, bool), span: SourceSpan) {
        let message = matches!(
            callee,
            "mbs_msg"
                | "mbs_warning_msg"
                | "mbs_error_msg"
                | "printf"
                | "fprintf"
                | "print"
                | "disp"
                | "warning"
                | "error"
        );
        if has_target {
            self.errors.push(refusal(
                &format!("`{callee}` is not a function that can be compiled"),
                span,
                "called here",
                "known are sin, cos and sqrt, and user functions whose names start with `user_` or `usrfun.`",
            ));
        } else if shared && !message {
            self.errors.push(refusal(
                &format!("the call of `{callee}` may change what it is given"),
                span,
                "called here",
                "known are user functions whose names start with `user_` or `usrfun.`; remove the call, or write out what it computes",
            ));
        } else if !message {
            self.warnings.push(
                Diagnostic::warning()
                    .with_message(format!("the call of `{callee}` is left out"))
                    .with_labels(vec![Label::primary(0, span.range())])
                    .with_note("it has no result that an equation could read"),
            );
        }
    }
}
