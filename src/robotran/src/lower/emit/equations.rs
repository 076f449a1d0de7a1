//! Equations: their nodes, and the operands of these.

use super::{FunctionEmitter, LATER};
use crate::Language;
use crate::storage::Initial;
use crate::syntax::{LeafKind, SyntaxLeaf};
use crate::token::{RobotranName, SourceSpan};
use robovec_ir::{Input, Name, Node, Operand, Value};
use std::ops::Range;

impl<'e, 'a, 't> FunctionEmitter<'e, 'a, 't> {
    pub(super) fn equation(
        &mut self,
        target: SyntaxLeaf,
        root: SyntaxLeaf,
        run: Range<u32>,
        span: SourceSpan,
    ) {
        if let LeafKind::Scalar(name) = target.kind()
            && (self.signature.counters.contains(&name.symbol()) || self.is_flag(name))
        {
            return;
        }
        let sources = self.sources(span);
        let syntax = self.shared.syntax;
        let fresh = matches!(root.kind(), LeafKind::Node(_));
        let output = match target.kind() {
            LeafKind::Element(element) if fresh => {
                self.plain_output(syntax.elements[element as usize].row)
            }
            _ => None,
        };
        let base = match output {
            Some(_) => LATER,
            None => self.function.nodes().len() as u32,
        };
        let start = self.later.nodes.len();
        for node in &syntax.nodes[run.start as usize..run.end as usize] {
            let left = self.operand(node.operands[0], base, run.start);
            let right = match node.operation.arity() {
                2 => self.operand(node.operands[1], base, run.start),
                _ => Operand::NONE,
            };
            let node = Node {
                name: Name::NONE,
                sources,
                operands: Operand::list([left, right]),
                operation: node.operation,
            };
            match output {
                Some(_) => self.later.nodes.push(node),
                None => {
                    self.function.push(node);
                }
            }
        }
        if let Some(output) = output {
            self.later
                .trees
                .push((output, start..self.later.nodes.len()));
            return;
        }
        let operand = self.operand(root, base, run.start);
        match target.kind() {
            LeafKind::Scalar(name) => self.define(name, operand, fresh, sources),
            LeafKind::Element(element) => {
                let slot = syntax.elements[element as usize].row;
                self.write(slot, operand, fresh, sources);
            }
            LeafKind::Node(_) | LeafKind::Number(_) => {}
        }
    }

    /// `s->flag_stop = 1;` of a guard file.
    fn is_flag(&self, name: RobotranName) -> bool {
        name.is_of_data() && self.shared.tables.symbols.text(name.symbol()) == "flag_stop"
    }

    pub(super) fn operand(&mut self, leaf: SyntaxLeaf, base: u32, first: u32) -> Operand {
        match leaf.kind() {
            LeafKind::Node(index) => {
                debug_assert!(index >= first, "an expression is one run of the arena");
                Operand::from(Value(base + (index - first)))
            }
            LeafKind::Number(index) => {
                let number = self.shared.syntax.numbers[index as usize].number();
                Operand::from(self.function.constant(number))
            }
            LeafKind::Scalar(name) => self.scalar(name),
            LeafKind::Element(element) => {
                let element = self.shared.syntax.elements[element as usize];
                self.element(element.row, element.column)
            }
        }
    }

    pub(super) fn element(&mut self, slot: u32, array: u32) -> Operand {
        let value = self.elements[slot as usize];
        if !value.is_none() {
            return value;
        }
        let stored = self.storage.arrays[array as usize];
        match stored.initial {
            Initial::Input(_) => {
                let (indices, rank) = stored.shape.indices(slot - stored.offset);
                let input = self.inputs[array as usize];
                // The input is as large as all arrays that begin as it.
                let place = input.and_then(|input| {
                    let offset = input.shape.offset(&indices[..rank])?;
                    Some(Input(input.offset + offset))
                });
                match place {
                    Some(place) => Operand::from(place),
                    None => Operand::from(self.function.constant(0.0)),
                }
            }
            // Reading nothing is an error that the scan has reported.
            Initial::Zero | Initial::Nothing => Operand::from(self.function.constant(0.0)),
        }
    }

    pub(super) fn scalar(&mut self, name: RobotranName) -> Operand {
        let symbol = name.symbol();
        let known = self.shared.definitions[symbol.index()];
        if !known.is_none() {
            if self.shared.language == Language::C && name.is_of_data() && known.input().is_none() {
                self.member_of_data(symbol);
            }
            return known;
        }
        if self.signature.counters.contains(&symbol) || self.signature.whole.contains(&name) {
            self.whole_number(symbol);
            return Operand::from(self.function.constant(0.0));
        }
        // The type of any other number of the structure is not known here.
        if self.shared.language == Language::C
            && name.is_of_data()
            && self.shared.tables.symbols.text(symbol) != "tsim"
        {
            self.member_of_data(symbol);
        }
        let given = name.is_of_data()
            || (self.parameters.contains_key(&name) && self.storage.find(name).is_none())
            || self
                .crossing
                .is_some_and(|crossing| crossing.inputs.contains(&symbol));
        if given {
            return self.scalar_input(symbol);
        }
        if self.missing_known.insert(symbol) {
            self.missing.push((symbol, self.statement));
        }
        Operand::from(self.function.constant(0.0))
    }
}
