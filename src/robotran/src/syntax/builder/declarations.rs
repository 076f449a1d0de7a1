//! Declarations of variables and arrays.

use super::{ParseFailure, SyntaxBuilder, refused};
use crate::literal::Literal;
use crate::syntax::{DeclaredArray, LeafKind, StatementKind, SyntaxLeaf};
use crate::token::{RobotranElement, RobotranName, SourceSpan, TypeWords};

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

    pub(crate) fn zeros(
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

    pub(crate) fn declare_scalar(&mut self, pointer: bool, name: RobotranName) {
        if pointer {
            self.pointers.push(name);
        }
        self.declared.push(name);
    }

    pub(crate) fn declare_array(&mut self, element: RobotranElement, zeroed: bool) {
        let kind = self.extent(DeclaredArray {
            name: element.name,
            rows: element.row,
            columns: element.column,
            zeroed,
        });
        self.declares_array = true;
        self.statement(kind, 0, 0);
    }

    /// An initial value of an array of C.
    pub(crate) fn first_value(&mut self, start: u32, number: Literal) {
        self.values.push((start, number));
    }

    /// The end of a list of initial values whose brace is at `start`.
    pub(crate) fn value_row(&mut self, start: u32) {
        let row = std::mem::take(&mut self.values);
        self.value_rows.push((start, row));
    }

    /// `double PxF1[4] = {3.0, 0.0, 1.5, 0.0}`: zeros, and equations for other
    /// values. Elements 0 are Robotran's own, which no equation reads.
    pub(crate) fn initialise_array(
        &mut self,
        start: u32,
        element: RobotranElement,
        end: u32,
    ) -> Result<(), ParseFailure> {
        self.declare_array(element, true);
        let mut rows = std::mem::take(&mut self.value_rows);
        let is_zero =
            |row: &(u32, Vec<(u32, Literal)>)| row.1.iter().all(|(_, v)| v.number() == 0.0);
        if rows.iter().all(is_zero) {
            return Ok(());
        }
        // The outer braces of a matrix end last, hence its row is the last one,
        // and it must hold no values.
        let is_matrix = element.column > 0;
        let outer = if is_matrix { rows.pop() } else { None };
        let is_mixed =
            |(brace, row): &(u32, Vec<(u32, Literal)>)| row.iter().any(|(at, _)| at < brace);
        let (row_count, row_length) = if is_matrix {
            (element.row as usize, element.column as usize)
        } else {
            (1, element.row as usize)
        };
        let fits = rows.len() <= row_count
            && outer.is_none_or(|(_, row)| row.is_empty())
            && !rows.iter().any(is_mixed)
            && rows.iter().all(|(_, row)| row.len() <= row_length);
        if !fits {
            return Err(refused(
                SourceSpan { start, end },
                "first values that are not those of the array's elements",
                "assign to its elements one by one",
            ));
        }
        for (row, (_, values)) in rows.into_iter().enumerate() {
            for (column, (_, value)) in values.into_iter().enumerate() {
                let place = if is_matrix {
                    [row as u32, column as u32]
                } else {
                    [column as u32, 0]
                };
                let is_unused = place[0] == 0 || is_matrix && place[1] == 0;
                if is_unused || value.number() == 0.0 {
                    continue;
                }
                let index = self.syntax.elements.len() as u32;
                self.syntax.elements.push(RobotranElement {
                    name: element.name,
                    row: place[0],
                    column: place[1],
                });
                let nodes = self.syntax.nodes.len() as u32;
                let root = self.number(value);
                let kind = StatementKind::Equation {
                    target: SyntaxLeaf::element(index),
                    root,
                    first: nodes,
                    end: nodes,
                };
                self.statement(kind, start, end);
            }
        }
        Ok(())
    }

    /// `double *q = s->q` and `double *dpt1 = s->dpt[1]`, where a `pointer` is
    /// declared; else a number with its first value.
    pub(crate) fn initialise(&mut self, pointer: bool, name: RobotranName, root: SyntaxLeaf) {
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

    /// True when the declaration hides the name of a parameter.
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

    pub(crate) fn declaration(
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
                "the name of a parameter is declared again",
                "the two would be different variables; give the new one another name",
            ));
        }
        for statement in &mut self.syntax.statements[self.chain..] {
            statement.span = span;
        }
        let mut first = self.complete[0] as u32;
        let last = self.syntax.nodes.len() as u32;
        for (name, root) in std::mem::take(&mut self.initialised) {
            if !double {
                self.statement(StatementKind::Counter(name), start, end);
                continue;
            }
            // Nodes of several initial values follow one another, roots last.
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
