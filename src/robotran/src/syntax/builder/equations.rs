//! Equations and calls.

use super::SyntaxBuilder;
use crate::literal::IntegerArithmetic;
use crate::syntax::{Argument, FunctionCall, LeafKind, StatementKind, SyntaxLeaf};
use crate::token::{RobotranName, SourceSpan};

impl SyntaxBuilder {
    /// The nodes since the last statement.
    pub(super) fn run(&self) -> (u32, u32) {
        let from_chain = self.syntax.statements[self.chain..].last();
        let first = match from_chain.map(|statement| statement.kind) {
            Some(StatementKind::Equation { end, .. }) => end,
            _ => self.complete[0] as u32,
        };
        (first, self.syntax.nodes.len() as u32)
    }

    fn push_equation(&mut self, start: u32, target: SyntaxLeaf, root: SyntaxLeaf) {
        let bits = self.whole_bits(root);
        if self.arithmetic == IntegerArithmetic::Python
            && bits > 0
            && let LeafKind::Scalar(name) = target.kind()
        {
            let known = self.whole_names.entry(name).or_insert(0);
            *known = bits.max(*known);
        }
        let (first, end) = self.run();
        let kind = StatementKind::Equation {
            target,
            root,
            first,
            end,
        };
        self.statement(kind, start, start);
    }

    pub(crate) fn chained(
        &mut self,
        start: u32,
        target: SyntaxLeaf,
        root: SyntaxLeaf,
    ) -> SyntaxLeaf {
        self.push_equation(start, target, root);
        target
    }

    pub(crate) fn equation(&mut self, start: u32, target: SyntaxLeaf, root: SyntaxLeaf, end: u32) {
        self.push_equation(start, target, root);
        for statement in &mut self.syntax.statements[self.chain..] {
            statement.span.end = end;
        }
        self.finish();
    }

    pub(crate) fn argument(&mut self, leaf: SyntaxLeaf, start: u32, end: u32) {
        let span = SourceSpan { start, end };
        self.syntax.arguments.push(Argument { leaf, span });
    }

    pub(crate) fn call(
        &mut self,
        start: u32,
        target: Option<SyntaxLeaf>,
        (callee, count): (RobotranName, u32),
        end: u32,
    ) {
        let last = self.syntax.arguments.len() as u32;
        let index = self.syntax.calls.len() as u32;
        self.syntax.calls.push(FunctionCall {
            target,
            callee,
            arguments: (last - count, last),
        });
        self.simple(StatementKind::Call(index), start, end);
    }
}
