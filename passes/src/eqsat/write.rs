//! Writing a function with its windows rewritten.

use super::alternatives::{AlternativeKind, all_negative};
use super::graph::FormMaker;
use super::round::Rewriting;
use crate::cse::{Key, KnownValues, SourceMerges};
use crate::sums::earliest::{TieOrder, join_earliest};
use robovec_analysis::critical_path::Weights;
use robovec_framework::rewrite::{owners, remove_dead};
use robovec_ir::{
    FreshNames, Function, Name, Node, Operand, OperandKind, Operation, SourceSet, Symbol, Tables,
};

/// An operand with a sign, while its sum is being combined.
#[derive(Clone, Copy)]
struct SumOperand {
    arrival: u32,
    operand: Operand,
    negative: bool,
}

struct RewritingWriter<'a> {
    old: &'a Function,
    weights: &'a Weights,
    out: Function,
    known: KnownValues,
    merges: SourceMerges,
    arrivals: Vec<u32>,
    map: Vec<Operand>,
    names: FreshNames,
    notes: Vec<(Name, FormMaker)>,
}

/// Names and sources of the operations of one rewriting.
struct RewritingOrigin {
    owner: Symbol,
    sources: SourceSet,
}

/// The function with the windows rewritten; equal operations are merged and
/// dead ones removed. Also who made which of the new values, where the
/// rewritings say so.
pub(crate) fn write(
    function: &Function,
    tables: &mut Tables,
    weights: &Weights,
    rewritings: &[Rewriting],
) -> (Function, Vec<(Name, FormMaker)>) {
    let owners = owners(tables, function);
    let count = function.nodes().len();
    let mut writer = RewritingWriter {
        old: function,
        weights,
        out: function.skeleton(function.level),
        known: KnownValues::with_capacity(count),
        merges: SourceMerges::default(),
        arrivals: Vec::with_capacity(count),
        map: Vec::with_capacity(count),
        names: function.fresh_names(),
        notes: Vec::new(),
    };
    writer.out.reserve(count);
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
                let origin = RewritingOrigin {
                    owner: owners[value.index()],
                    sources: tables.sources.union(&sets),
                };
                writer.rewriting(rewriting, node.name, &origin)
            }
            None => {
                let operands = node.operands.map(|operand| writer.translate(operand));
                writer.emit(node.operation, operands, node.sources, |_| node.name)
            }
        };
        writer.map.push(operand);
    }
    assert!(
        next.next().is_none(),
        "rewritings come in the order of their roots"
    );
    writer.finish(tables)
}

impl RewritingWriter<'_> {
    fn translate(&mut self, operand: Operand) -> Operand {
        match operand.kind() {
            OperandKind::Value(value) => self.map[value.index()],
            OperandKind::Constant(constant) => {
                let number = self.old.constant_number(constant);
                self.out.constant(number).into()
            }
            OperandKind::Input(_) | OperandKind::None => operand,
        }
    }

    fn arrival(&self, operand: Operand) -> u32 {
        operand
            .value()
            .map_or(0, |value| self.arrivals[value.index()])
    }

    fn emit<const COUNT: usize>(
        &mut self,
        operation: Operation,
        operands: [Operand; COUNT],
        sources: SourceSet,
        name: impl FnOnce(&mut FreshNames) -> Name,
    ) -> Operand {
        if let Some(same) = self.known.find(&self.out, Key::new(operation, operands)) {
            self.merges.add(same, sources);
            return same.into();
        }
        let ready = operands.iter().map(|&operand| self.arrival(operand));
        let ready = ready.max().unwrap_or(0);
        let name = name(&mut self.names);
        let value = self.out.push(Node {
            name,
            sources,
            operands: Operand::list(operands),
            operation,
        });
        let weight = self.weights.of(operation);
        self.arrivals.push(ready.saturating_add(weight));
        self.known.insert(&self.out, value);
        value.into()
    }

    fn rewriting(
        &mut self,
        rewriting: &Rewriting,
        root: Name,
        origin: &RewritingOrigin,
    ) -> Operand {
        let mut values = vec![Operand::NONE; rewriting.alternatives.classes.len()];
        let mut makers = rewriting.makers.iter();
        for &class in &rewriting.cover.order {
            let first = self.out.nodes().len();
            let place = class as usize;
            let index = rewriting.cover.choice[place] as usize;
            let form = &rewriting.alternatives.classes[place][index];
            let name = match class == rewriting.class {
                true => root,
                false => Name::NONE,
            };
            let children: Vec<Operand> = form
                .children
                .iter()
                .map(|&child| values[child as usize])
                .collect();
            debug_assert!(
                !children.contains(&Operand::NONE),
                "a class is written before those that use it"
            );
            values[place] = match form.kind {
                AlternativeKind::Leaf(number) => {
                    self.translate(rewriting.window.leaves[number as usize])
                }
                AlternativeKind::Number(bits) => self.out.constant(f64::from_bits(bits)).into(),
                AlternativeKind::Sum(signs) => {
                    self.bag(Operation::Add, signs, &children, name, origin)
                }
                AlternativeKind::Product => self.bag(Operation::Mul, 0, &children, name, origin),
                AlternativeKind::Other(Operation::Neg) => {
                    self.bag(Operation::Add, 1, &children, name, origin)
                }
                AlternativeKind::Other(operation) => {
                    assert_eq!(
                        children.len(),
                        operation.arity(),
                        "a form has the operands of its operation"
                    );
                    let mut operands = [Operand::NONE; Operand::MAX_COUNT];
                    operands[..children.len()].copy_from_slice(&children);
                    self.emit(operation, operands, origin.sources, |names| {
                        named(names, name, origin)
                    })
                }
            };
            if let Some(&Some(maker)) = makers.next() {
                let made = self.out.nodes()[first..].iter().map(|node| node.name);
                self.notes.extend(made.map(|name| (name, maker)));
                self.notes.push((root, maker));
            }
        }
        values[rewriting.class as usize]
    }

    /// A sum or product, the two earliest operands first.
    fn bag(
        &mut self,
        operation: Operation,
        signs: u64,
        children: &[Operand],
        root: Name,
        origin: &RewritingOrigin,
    ) -> Operand {
        let mut parts: Vec<SumOperand> = Vec::with_capacity(children.len() + 1);
        for (place, &operand) in children.iter().enumerate() {
            parts.push(SumOperand {
                arrival: self.arrival(operand),
                operand,
                negative: signs >> place & 1 == 1,
            });
        }
        if operation == Operation::Add && all_negative(signs, children.len() as u32) {
            parts.push(SumOperand {
                arrival: 0,
                operand: self.out.constant(0.0).into(),
                negative: false,
            });
        }
        let arrival = |part: &SumOperand| part.arrival;
        let tree = join_earliest(parts, TieOrder::Written, arrival, |[a, b], last| {
            let (operation, operands, negative) = match (operation, a.negative, b.negative) {
                (Operation::Add, false, true) => (Operation::Sub, [a.operand, b.operand], false),
                (Operation::Add, true, false) => (Operation::Sub, [b.operand, a.operand], false),
                (other, negative, _) => (other, [a.operand, b.operand], negative),
            };
            let name = if last { root } else { Name::NONE };
            let operand = self.emit(operation, operands, origin.sources, |names| {
                named(names, name, origin)
            });
            SumOperand {
                arrival: self.arrival(operand),
                operand,
                negative,
            }
        });
        tree.expect("a sum or product has operands").operand
    }

    fn finish(mut self, tables: &mut Tables) -> (Function, Vec<(Name, FormMaker)>) {
        let mut assignments = self.old.assignments.clone();
        for assignment in &mut assignments {
            assignment.operand = self.translate(assignment.operand);
        }
        self.out.assignments = assignments;
        self.merges.apply(&mut self.out, tables);
        match remove_dead(&self.out) {
            Some((live, _)) => (live, self.notes),
            None => (self.out, self.notes),
        }
    }
}

fn named(names: &mut FreshNames, name: Name, origin: &RewritingOrigin) -> Name {
    if name.is_none() {
        names.fresh(origin.owner)
    } else {
        name
    }
}
