//! Single operations become equations again.

use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::{Rewriter, lay_out, output_symbol};
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_ir::{
    Function, Level, Name, Node, Operand, Operation, SourceSet, Symbol, Tables, Value,
};
use robovec_num::limits::NumberLimit;

declare_pass! {
    /// Substitutes values that are used once into the equation that uses them.
    ///
    /// The inverse of `atomise`: no operation is changed, moved past another
    /// in its expression or computed twice, so not a bit changes; `0 - x` is
    /// written as the minus it was. Values used several times, sines and
    /// cosines, and the values of outputs keep their equations, as in
    /// Robotran's files; a value that is only named after its output (`c_5`)
    /// becomes the right side of that output.
    ///
    /// Two limits keep the equations within what compilers and people can
    /// read: Robotran's longest equation has 289 operations, and C promises
    /// no more than 63 nested parentheses.
    pub struct Inline("inline") {
        /// No equation gets more operations than this.
        pub operations: u32 = 280 => NumberLimit::whole(
            1, 1_000_000, "an equation is read, printed and compiled as a whole"),
        /// Nor deeper parentheses.
        pub nesting: u32 = 60 => NumberLimit::whole(
            1, 1_000, "readers and compilers keep every open parenthesis"),
    }
    takes: [Equations, Atomic],
    gives: Gives::Level(Level::Equations),
    class: Exact,
    destroys: [Timed],
}

impl Pass for Inline {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let choice = InliningChoice::new(function, context.tables, context.rewrites, self);
        let substituted = choice.count();
        let new = choice.apply();
        *function = lay_out(&with_sources(new, context.tables));
        context.count("values substituted", substituted);
        Ok(())
    }
}

/// The extent of a printed expression: its size and depth.
#[derive(Clone, Copy, Default)]
struct ExpressionExtent {
    operations: u32,
    nesting: u32,
}

/// The choice of the values that lose their names.
struct InliningChoice<'a> {
    function: &'a Function,
    rewrites: &'a RewriteLimit,
    /// Inner nodes: those the function came with, and those chosen.
    inner: Vec<bool>,
    /// Copies that are replaced by their originals.
    skipped: Vec<bool>,
    extents: Vec<ExpressionExtent>,
}

impl<'a> InliningChoice<'a> {
    fn new(
        function: &'a Function,
        tables: &mut Tables,
        rewrites: &'a RewriteLimit,
        limits: &Inline,
    ) -> InliningChoice<'a> {
        let nodes = function.nodes();
        let mut choice = InliningChoice {
            function,
            rewrites,
            inner: nodes.iter().map(|node| node.name.is_none()).collect(),
            skipped: vec![false; nodes.len()],
            extents: Vec::with_capacity(nodes.len()),
        };
        let mut free = substitutable(function);
        for (value, node) in function.values() {
            if node.operation == Operation::Copy && free[value.index()] {
                // The copy has the extent of what stands in its place.
                choice.skipped[value.index()] = true;
                let source = node.operands[0].value();
                free[value.index()] =
                    source.is_some_and(|source| std::mem::take(&mut free[source.index()]));
                let extent = node.operands[0].entry_or_default(&choice.extents);
                choice.extents.push(extent);
                continue;
            }
            let extent = choice.substitute(node, &free, limits);
            choice.extents.push(extent);
        }
        choice.take_outputs(tables, &free);
        choice
    }

    /// Substitutes fitting operands into a node, the smallest first, and
    /// returns the extent of its expression.
    fn substitute(&mut self, node: &Node, free: &[bool], limits: &Inline) -> ExpressionExtent {
        let mut candidates: Vec<Value> = Vec::new();
        if node.operation != Operation::Copy {
            let values = node.operands().iter().filter_map(|operand| operand.value());
            candidates.extend(values.filter(|value| free[value.index()]));
        }
        candidates.sort_by_key(|value| self.extents[value.index()].operations);
        let mut extent = self.extent(node);
        for value in candidates {
            let target = self.target(value);
            self.inner[target.index()] = true;
            let larger = self.extent(node);
            let fits = larger.operations <= limits.operations && larger.nesting <= limits.nesting;
            let name = self.function.node(target).name;
            if !fits || !self.rewrites.allow(name, "used once") {
                self.inner[target.index()] = false;
            } else {
                extent = larger;
            }
        }
        extent
    }

    /// The replacement of a value, through skipped copies.
    fn target(&self, value: Value) -> Value {
        let mut value = value;
        while self.skipped[value.index()]
            && let Some(source) = self.function.node(value).operands[0].value()
        {
            value = source;
        }
        value
    }

    /// The extent of the expression whose root a node is.
    fn extent(&self, node: &Node) -> ExpressionExtent {
        let (operation, operands) = shape(self.function, node);
        let mut extent = ExpressionExtent {
            operations: u32::from(operation != Operation::Copy),
            nesting: 0,
        };
        for (place, operand) in operands.iter().enumerate() {
            let Some(value) = operand.value().map(|value| self.target(value)) else {
                continue;
            };
            if !self.inner[value.index()] {
                continue;
            }
            let inner = self.extents[value.index()];
            let (inside, _) = shape(self.function, self.function.node(value));
            let parentheses = u32::from(binding(inside) < needed(operation, place));
            extent.operations = extent.operations.saturating_add(inner.operations);
            extent.nesting = extent.nesting.max(inner.nesting + parentheses);
        }
        extent
    }

    /// A value named after the only output it has becomes its right side.
    fn take_outputs(&mut self, tables: &mut Tables, free: &[bool]) {
        for assignment in &self.function.assignments {
            let Some(value) = assignment.operand.value() else {
                continue;
            };
            let (_, _, rank) = self.function.output_element(assignment.output);
            let node = self.function.node(value);
            let own = |tables: &mut Tables, symbol: Symbol| {
                output_symbol(tables, self.function, assignment.output) == symbol
            };
            if rank > 0
                && free[value.index()]
                && !self.skipped[value.index()]
                && own(tables, node.name.base)
            {
                self.inner[value.index()] = true;
            }
        }
    }

    fn count(&self) -> u64 {
        let nodes = self
            .function
            .nodes()
            .iter()
            .zip(&self.inner)
            .zip(&self.skipped);
        let chosen =
            nodes.filter(|((node, inner), skipped)| **skipped || (**inner && !node.name.is_none()));
        chosen.count() as u64
    }

    /// The function with the chosen values unnamed, in the old order.
    fn apply(&self) -> Function {
        let mut rewriter = Rewriter::new(self.function, Level::Equations);
        for (value, node) in self.function.values() {
            if self.skipped[value.index()] {
                let operand = rewriter.translate(node.operands[0]);
                rewriter.record(operand);
                continue;
            }
            let (operation, operands) = shape(self.function, node);
            let operands = operands.map(|operand| rewriter.translate(operand));
            let name = if self.inner[value.index()] {
                Name::NONE
            } else {
                node.name
            };
            rewriter.keep(Node {
                name,
                operands,
                operation,
                ..*node
            });
        }
        rewriter.finish()
    }
}

/// The values whose single reader may contain them: not sines and cosines, and
/// of those assigned to outputs only the ones that `take_outputs` finds.
fn substitutable(function: &Function) -> Vec<bool> {
    let counts = function.use_counts();
    let free = function.values().map(|(value, node)| {
        counts[value.index()] == 1 && !node.name.is_none() && !node.operation.is_trigonometric()
    });
    let mut free: Vec<bool> = free.collect();
    for assignment in &function.assignments {
        if let Some(value) = assignment.operand.value()
            && function.node(value).operation == Operation::Copy
        {
            free[value.index()] = false;
        }
    }
    free
}

/// The operation and operands that a node becomes: `0 - x` is a minus, unless
/// `x` is a number.
fn shape(function: &Function, node: &Node) -> (Operation, [Operand; Operand::MAX_COUNT]) {
    let [left, right, _] = node.operands;
    let zero = function
        .number(left)
        .is_some_and(|number| number.to_bits() == 0);
    if node.operation == Operation::Sub && zero && right.constant().is_none() {
        return (Operation::Neg, Operand::list([right]));
    }
    (node.operation, node.operands)
}

/// The binding strength of an operation, as in Robotran's files: a minus
/// includes the product after it.
fn binding(operation: Operation) -> u8 {
    match operation {
        Operation::Add | Operation::Sub | Operation::Neg => 1,
        Operation::Mul | Operation::Div => 2,
        Operation::Copy
        | Operation::Sin
        | Operation::Cos
        | Operation::Sqrt
        | Operation::Fma
        | Operation::Fms
        | Operation::Fnma => 3,
    }
}

/// The binding strength with which an operand is without parentheses.
fn needed(operation: Operation, place: usize) -> u8 {
    match (operation, place) {
        (Operation::Add | Operation::Sub, 0) | (Operation::Copy, _) => 1,
        (Operation::Add | Operation::Sub, _) | (Operation::Neg, _) => 2,
        (Operation::Mul | Operation::Div, 0) => 2,
        (Operation::Mul | Operation::Div, _) => 3,
        // The argument of a function stands in its parentheses.
        (
            Operation::Sin
            | Operation::Cos
            | Operation::Sqrt
            | Operation::Fma
            | Operation::Fms
            | Operation::Fnma,
            _,
        ) => 4,
    }
}

/// Gives every definition and output the sources of all its inner nodes.
fn with_sources(mut function: Function, tables: &mut Tables) -> Function {
    let nodes = function.nodes();
    let definitions = nodes.len();
    let mut roots: Vec<usize> = (0..definitions).collect();
    for (index, assignment) in function.assignments.iter().enumerate() {
        if let Some(value) = assignment.operand.value()
            && nodes[value.index()].name.is_none()
        {
            roots[value.index()] = definitions + index;
        }
    }
    let mut found: Vec<(usize, SourceSet)> = Vec::new();
    for (value, node) in function.values().rev() {
        let root = roots[value.index()];
        found.push((root, node.sources));
        for inner in node.operands().iter().filter_map(|operand| operand.value()) {
            if nodes[inner.index()].name.is_none() {
                roots[inner.index()] = root;
            }
        }
    }
    // Stable, so that the unions are made in the same order every time.
    found.sort_by_key(|&(root, _)| root);
    let groups = found.chunk_by(|a, b| a.0 == b.0);
    for group in groups.filter(|group| group.len() > 1 || group[0].0 >= definitions) {
        let root = group[0].0;
        let mut sets: Vec<SourceSet> = group.iter().map(|&(_, set)| set).collect();
        sets.dedup();
        if root < definitions {
            let sources = tables.sources.union(&sets);
            function.node_mut(Value(root as u32)).sources = sources;
        } else {
            let assignment = &mut function.assignments[root - definitions];
            sets.push(assignment.sources);
            assignment.sources = tables.sources.union(&sets);
        }
    }
    function
}
