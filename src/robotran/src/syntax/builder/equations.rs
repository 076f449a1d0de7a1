//! Equations and calls, heads of functions, and cases of sensors.

use super::{ParseFailure, SyntaxBuilder, refused};
use crate::literal::{IntegerArithmetic, Literal};
use crate::syntax::{Argument, FunctionCall, FunctionHeader, LeafKind, StatementKind, SyntaxLeaf};
use crate::token::{RobotranName, SourceSpan, TypeWords};

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

impl SyntaxBuilder {
    pub(crate) fn output(&mut self, name: RobotranName) {
        self.outputs.push(name);
    }

    pub(crate) fn parameter_word(&mut self, name: RobotranName) {
        self.parameter = Some(name);
    }

    pub(crate) fn parameter_type(&mut self, words: TypeWords) {
        self.parameter_types = self.parameter_types.and(words);
    }

    pub(crate) fn parameter_end(&mut self, start: u32, end: u32) -> Result<(), ParseFailure> {
        let words = std::mem::take(&mut self.parameter_types);
        if words.is_other_float() {
            return Err(refused(
                SourceSpan { start, end },
                "a parameter of another type than `double`",
                "its numbers would be rounded; robovec computes in 64-bit floats",
            ));
        }
        if words.is_whole() {
            self.whole_parameters.extend(self.parameter);
        }
        self.parameters.extend(self.parameter.take());
        Ok(())
    }

    pub(crate) fn head(&mut self, start: u32, name: RobotranName, end: u32) {
        let head = FunctionHeader {
            name: name.symbol(),
            parameters: std::mem::take(&mut self.parameters),
            whole: std::mem::take(&mut self.whole_parameters),
            outputs: std::mem::take(&mut self.outputs),
            first_element: self.syntax.elements.len() as u32,
        };
        self.rows.clear();
        let index = self.syntax.heads.len() as u32;
        self.syntax.heads.push(head);
        self.simple(StatementKind::Head(index), start, end);
    }

    pub(crate) fn case(
        &mut self,
        start: u32,
        number: Literal,
        end: u32,
    ) -> Result<(), ParseFailure> {
        let whole = number.number();
        if whole.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&whole) {
            return Err(refused(
                SourceSpan { start, end },
                "a case that is not the number of a sensor",
                "the cases of a sensor file are the numbers of sensors",
            ));
        }
        self.simple(StatementKind::Case(whole as u32), start, end);
        Ok(())
    }
}
