//! Writing a function with its windows rewritten.

use super::alternatives::{AlternativeKind, all_negative};
use super::graph::FormMaker;
use super::round::Rewriting;
use crate::sums::earliest::TieOrder;
use crate::sums::groups::GroupFamily;
use crate::sums::writer::{SignedOperand, SumWriter, ValueNaming};
use robovec_analysis::critical_path::Weights;
use robovec_framework::rewrite::{owners, without_dead};
use robovec_ir::{Function, Name, Operand, Operation, SourceSet, Symbol, Tables};

struct RewritingWriter<'a> {
    old: &'a Function,
    writer: SumWriter,
    map: Vec<SignedOperand>,
    notes: Vec<(Name, FormMaker)>,
}

/// The function with the windows rewritten; equal operations are merged and
/// dead ones removed. Also who made which of the new values, where the
/// rewritings state it.
pub(crate) fn write(
    function: &Function,
    tables: &mut Tables,
    weights: &Weights,
    rewritings: &[Rewriting],
) -> (Function, Vec<(Name, FormMaker)>) {
    let owners = owners(tables, function);
    let mut writer = RewritingWriter {
        old: function,
        writer: SumWriter::new(function, function.level, *weights).sharing(),
        map: Vec::with_capacity(function.nodes().len()),
        notes: Vec::new(),
    };
    let mut next = rewritings.iter().peekable();
    for (value, node) in function.values() {
        let operand = match next.next_if(|rewriting| rewriting.root == value) {
            Some(rewriting) => {
                let sets: Vec<SourceSet> = rewriting
                    .window
                    .interior
                    .iter()
                    .map(|&inner| function.node(inner).sources)
                    .collect();
                let origin = (owners[value.index()], tables.sources.union(&sets));
                writer.rewriting(rewriting, node.name, origin)
            }
            None => {
                let operands = node.operands.map(|operand| writer.translate(operand));
                (writer.writer).write(node.operation, operands, node.name, node.sources)
            }
        };
        writer.map.push(writer.writer.signed(operand, false));
    }
    assert!(
        next.next().is_none(),
        "rewritings come in the order of their roots"
    );
    writer.finish(tables)
}

impl RewritingWriter<'_> {
    fn translate(&mut self, operand: Operand) -> Operand {
        self.writer.translate(self.old, &self.map, operand).operand
    }

    fn rewriting(
        &mut self,
        rewriting: &Rewriting,
        root: Name,
        (owner, sources): (Symbol, SourceSet),
    ) -> Operand {
        let mut values = vec![Operand::NONE; rewriting.alternatives.classes.len()];
        let mut makers = rewriting.makers.iter();
        for &class in &rewriting.cover.order {
            let first = self.writer.out.nodes().len();
            let place = class as usize;
            let index = rewriting.cover.choice[place] as usize;
            let form = &rewriting.alternatives.classes[place][index];
            let name = if class == rewriting.class {
                root
            } else {
                Name::NONE
            };
            let mut naming = ValueNaming::new(name, owner, sources);
            let children: Vec<Operand> = form
                .children
                .iter()
                .map(|&child| values[child as usize])
                .collect();
            assert!(
                !children.contains(&Operand::NONE),
                "a class is written before those that use it"
            );
            values[place] = match form.kind {
                AlternativeKind::Leaf(number) => {
                    self.translate(rewriting.window.leaves[number as usize])
                }
                AlternativeKind::Number(bits) => {
                    self.writer.out.constant(f64::from_bits(bits)).into()
                }
                AlternativeKind::Sum(signs) => {
                    self.bag(GroupFamily::Sum, signs, &children, &mut naming)
                }
                AlternativeKind::Product => {
                    self.bag(GroupFamily::Product, 0, &children, &mut naming)
                }
                AlternativeKind::Other(Operation::Neg) => {
                    self.bag(GroupFamily::Sum, 1, &children, &mut naming)
                }
                AlternativeKind::Other(operation) => {
                    assert_eq!(
                        children.len(),
                        operation.arity(),
                        "a form has the operands of its operation"
                    );
                    let mut operands = [Operand::NONE; Operand::MAX_COUNT];
                    operands[..children.len()].copy_from_slice(&children);
                    self.writer.push(operation, operands, true, &mut naming)
                }
            };
            if let Some(&Some(maker)) = makers.next() {
                let made = self.writer.out.nodes()[first..]
                    .iter()
                    .map(|node| node.name);
                self.notes.extend(made.map(|name| (name, maker)));
                self.notes.push((root, maker));
            }
        }
        values[rewriting.class as usize]
    }

    /// A sum or product, the two earliest operands first.
    fn bag(
        &mut self,
        family: GroupFamily,
        signs: u64,
        children: &[Operand],
        naming: &mut ValueNaming,
    ) -> Operand {
        let signed = |(place, &operand)| self.writer.signed(operand, signs >> place & 1 == 1);
        let mut parts: Vec<SignedOperand> = children.iter().enumerate().map(signed).collect();
        if family == GroupFamily::Sum && all_negative(signs, children.len() as u32) {
            parts.push(self.writer.number(0.0));
        }
        let order = (TieOrder::Written, false);
        self.writer.tree(family, parts, order, naming).operand
    }

    fn finish(mut self, tables: &mut Tables) -> (Function, Vec<(Name, FormMaker)>) {
        let (old, map) = (self.old, &self.map);
        self.writer.outputs(old, tables, |writer, place| {
            writer.translate(old, map, old.assignments[place].operand)
        });
        let (out, _) = self.writer.finish(tables);
        (without_dead(out), self.notes)
    }
}
