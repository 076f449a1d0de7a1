//! The function as a list of statements, each an instance of a template.
//!
//! A statement is an expression tree whose leaves are inputs, constants and
//! results of other statements. Two statements that differ in their leaves
//! alone have one template, and only such can be passes through one loop.

use crate::emit::inlining::{Inlining, assigned as assigned_values};
use hashbrown::HashMap;
use robovec_analysis::slice::live;
use robovec_ir::{Function, Level, Node, Operand, OperandKind, Operation, Output, Value};
use rustc_hash::FxBuildHasher;

/// A step of a template, in postfix order.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum TemplateStep {
    /// Takes the next leaf.
    Leaf,
    /// Applies an operation to the latest results.
    Apply(Operation),
}

/// The computation of a statement, with its leaves left open.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Template {
    pub(super) steps: Vec<TemplateStep>,
}

impl Template {
    /// The number of operations.
    pub(super) fn operations(&self) -> usize {
        let apply = |step: &&TemplateStep| matches!(step, TemplateStep::Apply(_));
        self.steps.iter().filter(apply).count()
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum StatementTarget {
    /// The value of a node, and the outputs that are assigned to it.
    Value(Value),
    /// An output that is set to an operand known elsewhere.
    Output(Output),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct RolledStatement {
    /// The template it is an instance of.
    pub(super) template: u32,
    /// The start of its leaves.
    start: u32,
    pub(super) target: StatementTarget,
}

/// The template of copies.
const COPY: u32 = 0;

/// All statements of a function, in program order; copies to outputs last.
pub(super) struct Statements {
    pub(super) templates: Vec<Template>,
    pub(super) list: Vec<RolledStatement>,
    leaves: Vec<Operand>,
    /// For each value the output elements assigned to it, in order: where
    /// they start in `assigned`.
    starts: Vec<u32>,
    assigned: Vec<Output>,
}

impl Statements {
    /// Splits a function into statements.
    pub(super) fn new(function: &Function) -> Statements {
        let live = live(function);
        let inlined = inlined(function);
        let (starts, assigned) = assigned(function);
        let mut builder = StatementBuilder {
            function,
            inlined: &inlined,
            index: HashMap::default(),
            statements: Statements {
                templates: vec![Template {
                    steps: vec![TemplateStep::Leaf],
                }],
                list: Vec::new(),
                leaves: Vec::new(),
                starts,
                assigned,
            },
        };
        for (value, _) in function.values() {
            if live[value.index()] && !inlined[value.index()] {
                builder.statement(value);
            }
        }
        let mut copies: Vec<(Output, Operand)> = Vec::new();
        for assignment in &function.assignments {
            let value = assignment.operand.value();
            let primary = value.map(|value| builder.statements.primary(value));
            if primary != Some(Some(assignment.output)) {
                copies.push((assignment.output, assignment.operand));
            }
        }
        copies.sort_unstable_by_key(|&(output, _)| output);
        for (output, operand) in copies {
            builder.statements.append(output, operand);
        }
        builder.statements
    }

    pub(super) fn leaves(&self, statement: u32) -> &[Operand] {
        let RolledStatement {
            start, template, ..
        } = self.list[statement as usize];
        let steps = &self.templates[template as usize].steps;
        let count = steps
            .iter()
            .filter(|step| **step == TemplateStep::Leaf)
            .count();
        &self.leaves[start as usize..start as usize + count]
    }

    /// The output that the statement of a value sets directly: the last one
    /// with that value, in the lower triangle of a symmetric matrix. The others
    /// are copies.
    pub(super) fn primary(&self, value: Value) -> Option<Output> {
        let range = self.starts[value.index()] as usize..self.starts[value.index() + 1] as usize;
        self.assigned[range].last().copied()
    }

    /// Appends a copy of an operand to an output.
    pub(super) fn append(&mut self, output: Output, operand: Operand) -> u32 {
        let start = self.leaves.len() as u32;
        self.leaves.push(operand);
        self.list.push(RolledStatement {
            template: COPY,
            start,
            target: StatementTarget::Output(output),
        });
        self.list.len() as u32 - 1
    }

    /// The number of operations of a statement.
    pub(super) fn operations(&self, statement: u32) -> usize {
        self.templates[self.list[statement as usize].template as usize].operations()
    }
}

struct StatementBuilder<'a> {
    function: &'a Function,
    inlined: &'a [bool],
    index: HashMap<Template, u32, FxBuildHasher>,
    statements: Statements,
}

impl StatementBuilder<'_> {
    fn statement(&mut self, value: Value) {
        let start = self.statements.leaves.len() as u32;
        // Postfix order, by taking the reverse of a walk that visits the
        // operation before its last operand.
        let mut steps = Vec::new();
        let mut leaves = Vec::new();
        let mut open: Vec<(Operand, bool)> = vec![(value.into(), true)];
        while let Some((operand, inner)) = open.pop() {
            match operand.kind() {
                OperandKind::Value(value) if inner => {
                    let node = self.function.node(value);
                    steps.push(TemplateStep::Apply(node.operation));
                    for &operand in node.operands() {
                        let inner = operand
                            .value()
                            .is_some_and(|value| self.inlined[value.index()]);
                        open.push((operand, inner));
                    }
                }
                _ => {
                    steps.push(TemplateStep::Leaf);
                    leaves.push(operand);
                }
            }
        }
        steps.reverse();
        self.statements.leaves.extend(leaves.iter().rev());
        self.push(steps, start, StatementTarget::Value(value));
    }

    fn push(&mut self, steps: Vec<TemplateStep>, start: u32, target: StatementTarget) {
        let next = self.statements.templates.len() as u32;
        let template = Template { steps };
        let number = *self.index.entry(template.clone()).or_insert(next);
        if number == next {
            self.statements.templates.push(template);
        }
        self.statements.list.push(RolledStatement {
            template: number,
            start,
            target,
        });
    }
}

/// For each value the start of its output elements in a list of all.
fn assigned(function: &Function) -> (Vec<u32>, Vec<Output>) {
    let mut pairs: Vec<(Value, Output)> = function
        .assignments
        .iter()
        .filter_map(|assignment| Some((assignment.operand.value()?, assignment.output)))
        .collect();
    pairs.sort_unstable();
    let mut starts = vec![0u32; function.nodes().len() + 1];
    for (value, _) in &pairs {
        starts[value.index() + 1] += 1;
    }
    for index in 1..starts.len() {
        starts[index] += starts[index - 1];
    }
    (
        starts,
        pairs.into_iter().map(|(_, output)| output).collect(),
    )
}

/// Marks nodes that are inlined. Where equations are kept as written, only
/// their own inner nodes are inside the expression of their reader, so that
/// similar equations stay similar.
fn inlined(function: &Function) -> Vec<bool> {
    let given = assigned_values(function);
    let written = function.level == Level::Equations;
    let may_stand =
        |value: Value, node: &Node| !given[value.index()] && (!written || node.name.is_none());
    Inlining::new(function, may_stand).inlined
}
