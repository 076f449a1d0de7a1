//! Declarations of variables and arrays.

use super::{ParseFailure, SyntaxBuilder, refused};
use crate::robotran::literal::Literal;
use crate::robotran::syntax::{DeclaredArray, LeafKind, StatementKind, SyntaxLeaf};
use crate::robotran::token::{RobotranElement, RobotranName, SourceSpan, TypeWords};

impl SyntaxBuilder {
    pub(super) fn extent(&mut self, extent: DeclaredArray) -> StatementKind {
        let shift = u32::from(self.extents_from_zero);
        self.syntax.extents.push(DeclaredArray {
            rows: extent.rows.saturating_sub(shift),
            columns: extent.columns.saturating_sub(shift),
            ..extent
        });
        StatementKind::Extent(self.syntax.extents.len() as u32 - 1)
    }

    pub(in crate::robotran) fn zeros(
        &mut self,
        start: u32,
        target: SyntaxLeaf,
        (rows, columns): (u32, u32),
        end: u32,
    ) {
        if let LeafKind::Scalar(name) = target.kind() {
            let kind = self.extent(DeclaredArray {
                name,
                rows,
                columns,
                zeroed: true,
            });
            self.statement(kind, start, end);
        }
        self.finish();
    }

    pub(in crate::robotran) fn declare_scalar(&mut self, pointer: bool, name: RobotranName) {
        if pointer {
            self.pointers.push(name);
        }
        self.declared.push(name);
    }

    pub(in crate::robotran) fn declare_array(&mut self, element: RobotranElement, zeroed: bool) {
        let kind = self.extent(DeclaredArray {
            name: element.name,
            rows: element.row,
            columns: element.column,
            zeroed,
        });
        self.declares_array = true;
        self.statement(kind, 0, 0);
    }

    /// A first value of an array of C.
    pub(in crate::robotran) fn first_value(
        &mut self,
        start: u32,
        number: Literal,
        end: u32,
    ) -> Result<(), ParseFailure> {
        if number.number() == 0.0 {
            return Ok(());
        }
        Err(refused(
            SourceSpan { start, end },
            "an array with first values other than 0",
            "assign to its elements one by one",
        ))
    }

    /// `double *q = s->q` and `double *dpt1 = s->dpt[1]`, where a `pointer` is
    /// declared; else a number with its first value.
    pub(in crate::robotran) fn initialise(
        &mut self,
        pointer: bool,
        name: RobotranName,
        root: SyntaxLeaf,
    ) {
        if pointer
            && let LeafKind::Element(index) = root.kind()
            && let row = self.syntax.elements[index as usize]
            && row.column == 0
            && row.row > 0
            && index as usize + 1 == self.syntax.elements.len()
        {
            self.syntax.elements.pop();
            self.rows.insert(name, row);
            return;
        }
        self.initialised.push((name, root));
    }

    /// A name that the declaration declares and that is a parameter already:
    /// in an inner block it would be another variable.
    fn hidden_parameter(&self) -> bool {
        let Some(head) = self.syntax.heads.last() else {
            return false;
        };
        let arrays = self.syntax.statements[self.chain..].iter();
        let arrays = arrays.filter_map(|statement| match statement.kind {
            StatementKind::Extent(extent) => Some(self.syntax.extents[extent as usize].name),
            _ => None,
        });
        let initialised = self.initialised.iter().map(|&(name, _)| name);
        let mut names = self
            .declared
            .iter()
            .copied()
            .chain(initialised)
            .chain(arrays);
        names.any(|name| head.parameters.contains(&name))
    }

    pub(in crate::robotran) fn declaration(
        &mut self,
        start: u32,
        words: TypeWords,
        end: u32,
    ) -> Result<(), ParseFailure> {
        let span = SourceSpan { start, end };
        let double = words.is_double();
        if words.is_other_float() || (self.declares_array && !double) {
            return Err(refused(
                span,
                "variables of another type than `double`",
                "their numbers would be rounded; robovec computes in 64-bit floats: declare them `double`",
            ));
        }
        if self.hidden_parameter() {
            return Err(refused(
                span,
                "a parameter's name is declared once more",
                "the two would be different variables; give the new one another name",
            ));
        }
        let elements = self.syntax.elements.len() as u32;
        for statement in &mut self.syntax.statements[self.chain..] {
            statement.span = span;
            statement.elements = elements;
        }
        let mut first = self.complete[0] as u32;
        let last = self.syntax.nodes.len() as u32;
        for (name, root) in std::mem::take(&mut self.initialised) {
            if !double {
                self.statement(StatementKind::Counter(name), start, end);
                continue;
            }
            // The nodes of several initial values follow one another; each
            // root is the last of its own.
            let end_of_run = match root.kind() {
                LeafKind::Node(index) => index + 1,
                _ => first,
            };
            let kind = StatementKind::Equation {
                target: SyntaxLeaf::scalar(name),
                root,
                first,
                end: end_of_run.min(last),
            };
            first = end_of_run;
            self.statement(kind, start, end);
        }
        let declared = std::mem::take(&mut self.declared);
        for name in std::mem::take(&mut self.pointers) {
            self.statement(StatementKind::Pointer(name), start, end);
        }
        if !double {
            for name in declared {
                self.statement(StatementKind::Counter(name), start, end);
            }
        }
        self.declares_array = false;
        self.finish();
        Ok(())
    }
}
