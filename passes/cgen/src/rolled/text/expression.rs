//! Expressions: operations, and the places of their operands.

use super::super::program::{Index, LeafSource, SpaceElement, StorageSpace};
use super::super::statements::TemplateStep;
use super::RolledWriter;
use crate::emit::arrays::element;
use crate::emit::expression::{BoundText, Operands, apply, literal};

impl RolledWriter<'_> {
    /// The expression of a statement: its template applied to its leaves.
    pub(super) fn expression(&self, position: usize) -> String {
        let code = &self.program.codes[position];
        let mut leaves = code.sources.iter().map(|source| self.source_text(source));
        let mut stack: Vec<BoundText> = Vec::new();
        for step in &self.program.templates[code.template as usize].steps {
            let done = match *step {
                TemplateStep::Leaf => leaves
                    .next()
                    .expect("a statement has a source for each leaf"),
                TemplateStep::Apply(operation) => {
                    let operands = stack.split_off(stack.len() - operation.arity());
                    apply(operation, &operands, self.real, Operands::Numbers)
                }
            };
            stack.push(done);
        }
        stack.pop().expect("a template leaves one value").text
    }

    pub(super) fn source_text(&self, source: &LeafSource) -> BoundText {
        match source {
            LeafSource::Position(position) => BoundText::primary(&self.variables[*position]),
            LeafSource::Carried(carried) => BoundText::primary(&self.carried[*carried]),
            LeafSource::Place(place) => BoundText::primary(self.place(place)),
            LeafSource::Number(number) => literal(*number, self.real),
        }
    }

    pub(super) fn place(&self, place: &SpaceElement) -> String {
        self.at(
            place.space,
            &self.index(&place.row),
            &self.index(&place.column),
        )
    }

    pub(super) fn at(&self, space: StorageSpace, row: &str, column: &str) -> String {
        let (array, name, is_output) = match space {
            StorageSpace::Work => return format!("{}[{column}]", self.work),
            StorageSpace::Constants => return format!("{}[{column}]", self.constants),
            StorageSpace::Input(array) => {
                (&self.function.inputs()[array], &self.inputs[array], false)
            }
            StorageSpace::Output(array) => {
                (&self.function.outputs()[array], &self.outputs[array], true)
            }
        };
        element(name, array.shape, is_output, row, column)
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
        if index.base != 0 || (index.factors.is_empty() && index.table.is_none()) {
            term(index.base < 0, index.base.unsigned_abs().to_string());
        }
        text
    }
}
