//! Graphs of equal terms, for experiments with rules.
//!
//! A thin layer over egg: patterns become terms and rewrites. Budgets count
//! nodes and iterations, never seconds, so that an experiment has the same
//! outcome everywhere. Conditions of rules are assumed to hold: a graph here
//! shows how rules grow and what they derive, and rewrites no program.

use super::pattern::{Pattern, PatternNode};
use super::rule::Rule;
use egg::{
    EGraph, ENodeOrVar, Id, Language, RecExpr, Rewrite, Runner, SimpleScheduler, StopReason, Var,
};
use robovec_ir::Operation;
use std::fmt;
use std::time::Duration;

/// A node of a graph.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(super) enum GraphTerm {
    /// A value without known properties.
    Leaf(u32),
    /// A number, by its bits.
    Number(u64),
    /// An operation on one operand.
    Unary(Operation, [Id; 1]),
    /// An operation on two operands.
    Binary(Operation, [Id; 2]),
}

impl fmt::Display for GraphTerm {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GraphTerm::Leaf(leaf) => write!(formatter, "x{leaf}"),
            GraphTerm::Number(bits) => write!(formatter, "{}", f64::from_bits(*bits)),
            GraphTerm::Unary(operation, _) | GraphTerm::Binary(operation, _) => {
                formatter.write_str(operation.name())
            }
        }
    }
}

impl Language for GraphTerm {
    type Discriminant = (u8, u64);

    fn discriminant(&self) -> (u8, u64) {
        match self {
            GraphTerm::Leaf(leaf) => (0, u64::from(*leaf)),
            GraphTerm::Number(bits) => (1, *bits),
            GraphTerm::Unary(operation, _) => (2, *operation as u64),
            GraphTerm::Binary(operation, _) => (3, *operation as u64),
        }
    }

    fn matches(&self, other: &GraphTerm) -> bool {
        self.discriminant() == other.discriminant()
    }

    fn children(&self) -> &[Id] {
        match self {
            GraphTerm::Leaf(_) | GraphTerm::Number(_) => &[],
            GraphTerm::Unary(_, children) => children,
            GraphTerm::Binary(_, children) => children,
        }
    }

    fn children_mut(&mut self) -> &mut [Id] {
        match self {
            GraphTerm::Leaf(_) | GraphTerm::Number(_) => &mut [],
            GraphTerm::Unary(_, children) => children,
            GraphTerm::Binary(_, children) => children,
        }
    }
}

fn operation(operation: Operation, operands: [u32; 2]) -> GraphTerm {
    let [a, b] = operands.map(|operand| Id::from(operand as usize));
    match operation.arity() {
        1 => GraphTerm::Unary(operation, [a]),
        _ => GraphTerm::Binary(operation, [a, b]),
    }
}

/// A pattern as a term: its variables become leaves.
pub(super) fn term(pattern: &Pattern) -> RecExpr<GraphTerm> {
    let nodes = pattern.nodes.iter().map(|node| match *node {
        PatternNode::Variable(variable) => GraphTerm::Leaf(variable),
        PatternNode::Number(number) => GraphTerm::Number(number.to_bits()),
        PatternNode::Operation(kind, operands) => operation(kind, operands),
    });
    nodes.collect::<Vec<GraphTerm>>().into()
}

fn side(pattern: &Pattern) -> egg::Pattern<GraphTerm> {
    let nodes = pattern.nodes.iter().map(|node| match *node {
        PatternNode::Variable(variable) => ENodeOrVar::Var(Var::from_u32(variable)),
        PatternNode::Number(number) => ENodeOrVar::ENode(GraphTerm::Number(number.to_bits())),
        PatternNode::Operation(kind, operands) => ENodeOrVar::ENode(operation(kind, operands)),
    });
    let nodes: RecExpr<ENodeOrVar<GraphTerm>> = nodes.collect::<Vec<_>>().into();
    egg::Pattern::new(nodes)
}

/// The rewrites of a rule: one for each direction.
pub(super) fn rewrites(rule: &Rule) -> Vec<Rewrite<GraphTerm, ()>> {
    let directed = rule.directed().into_iter();
    directed
        .map(|rule| {
            Rewrite::new(rule.name.as_str(), side(&rule.left), side(&rule.right))
                .expect("rules that were read have no unbound variable")
        })
        .collect()
}

/// The limits on growing a graph.
#[derive(Clone, Copy, Debug)]
pub(super) struct GraphBudget {
    pub(super) nodes: usize,
    pub(super) iterations: usize,
}

pub(super) struct Grown {
    pub(super) graph: EGraph<GraphTerm, ()>,
    /// The class of each term it was grown from.
    pub(super) roots: Vec<Id>,
    /// True when no rule can add a form.
    pub(super) saturated: bool,
}

/// Grows a graph from terms by rewrites, whose names must differ.
pub(super) fn grow(
    terms: &[RecExpr<GraphTerm>],
    rewrites: &[Rewrite<GraphTerm, ()>],
    budget: GraphBudget,
) -> Grown {
    run(runner(terms, budget), rewrites)
}

/// Tests whether two terms become equal in a graph grown from them; growth
/// stops when they do.
pub(super) fn are_equal(
    terms: &[RecExpr<GraphTerm>; 2],
    rewrites: &[Rewrite<GraphTerm, ()>],
    budget: GraphBudget,
) -> bool {
    let merged = |runner: &Runner<GraphTerm, ()>| {
        let [one, other] = [0, 1].map(|term| runner.egraph.find(runner.roots[term]));
        one == other
    };
    let runner = runner(terms, budget).with_hook(move |runner| {
        if merged(runner) {
            Err("equal".to_owned())
        } else {
            Ok(())
        }
    });
    let grown = run(runner, rewrites);
    grown.graph.find(grown.roots[0]) == grown.graph.find(grown.roots[1])
}

fn runner(terms: &[RecExpr<GraphTerm>], budget: GraphBudget) -> Runner<GraphTerm, ()> {
    let mut runner = Runner::<GraphTerm, ()>::new(())
        .with_scheduler(SimpleScheduler)
        .with_iter_limit(budget.iterations)
        .with_node_limit(budget.nodes)
        .with_time_limit(Duration::MAX);
    for term in terms {
        runner = runner.with_expr(term);
    }
    runner
}

fn run(runner: Runner<GraphTerm, ()>, rewrites: &[Rewrite<GraphTerm, ()>]) -> Grown {
    let runner = runner.run(rewrites);
    Grown {
        saturated: matches!(runner.stop_reason, Some(StopReason::Saturated)),
        roots: runner.roots,
        graph: runner.egraph,
    }
}
