//! Reasons why an equation is refused.

use super::FunctionEmitter;
use crate::explain::refusal;
use crate::syntax::{LeafKind, StatementKind, SyntaxLeaf};
use crate::token::SourceSpan;
use robovec_ir::Symbol;
use robovec_ir::diagnostic::{Diagnostic, Label};

impl<'e, 'a, 't> FunctionEmitter<'e, 'a, 't> {
    /// A number of the data structure that is not known to be a 64-bit float,
    /// or that a variable of the same name hides.
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
