//! Windows: small parts of a function around one late result.
//!
//! A window is grown from its root backwards, the latest operand first, since
//! only late values can be made earlier by a rewriting. Values that it does not
//! reach are its surroundings and become leaves with real arrival times. Values
//! of the window that others need too stay alive in any case, so they are
//! leaves as well, beside their definitions, and cost nothing.

use super::form::{ClassReference, EquivalentForm};
use super::graph::EquivalenceGraph;
use super::plain::plain_number;
use egg::Id;
use hashbrown::HashMap;
use robovec_ir::{Function, Operand, OperandKind, Operation, Value};
use rustc_hash::FxBuildHasher;
use std::collections::BinaryHeap;

/// A part of a function.
#[derive(Clone, Debug, Default)]
pub(crate) struct RewriteWindow {
    /// The operations rewritten, in program order; the last is the root.
    pub(crate) interior: Vec<Value>,
    /// The operands that the leaves of the e-graph represent.
    pub(crate) leaves: Vec<Operand>,
    /// Time at which each leaf is ready.
    pub(crate) times: Vec<u32>,
    /// Operations of the interior that have no other users.
    pub(crate) own: u32,
}

/// The facts about the function while its windows are chosen.
pub(crate) struct Surroundings<'a> {
    pub(crate) function: &'a Function,
    /// Time of each value, if known.
    pub(crate) times: &'a [u32],
    /// The number of reads of each value.
    pub(crate) uses: &'a [u32],
    /// The arguments of sines and cosines are of interest.
    pub(crate) trig: bool,
    /// Operations have two operands, as in the function, not bags.
    pub(crate) plain: bool,
}

fn is_sum(operation: Operation) -> bool {
    matches!(operation, Operation::Add | Operation::Sub)
}

/// True when two operations are parts of one bag.
pub(crate) fn is_one_bag(a: Operation, b: Operation) -> bool {
    is_sum(a) && is_sum(b) || a == Operation::Mul && b == Operation::Mul
}

impl RewriteWindow {
    /// The window of a root with at most this number of operations.
    pub(crate) fn grow(around: &Surroundings<'_>, root: Value, size: usize) -> Vec<Value> {
        let function = around.function;
        let mut interior: Vec<Value> = Vec::with_capacity(size);
        // The latest first; of equally late ones the last.
        let mut open: BinaryHeap<(u32, Value)> = BinaryHeap::new();
        open.push((u32::MAX, root));
        while let Some((_, value)) = open.pop() {
            if interior.contains(&value) {
                continue;
            }
            if interior.len() == size {
                break;
            }
            interior.push(value);
            for operand in function.node(value).operands() {
                if let Some(inner) = operand.value()
                    && !function.node(inner).operation.is_trigonometric()
                {
                    open.push((around.times[inner.index()], inner));
                }
            }
        }
        interior.sort_unstable();
        interior
    }

    /// Enters a window into an e-graph; also gives the class of its root.
    pub(crate) fn enter(
        around: &Surroundings<'_>,
        interior: Vec<Value>,
        graph: &mut EquivalenceGraph,
    ) -> (RewriteWindow, Id) {
        let mut entry = WindowImporter {
            around,
            graph,
            window: RewriteWindow::default(),
            numbers: HashMap::default(),
            inside: vec![0; interior.len()],
            interior: &interior,
            known: Vec::with_capacity(interior.len()),
            bags: Vec::with_capacity(interior.len()),
        };
        entry.count_uses();
        for place in 0..interior.len() {
            entry.node(place);
        }
        let root = *entry.known.last().expect("a window has a root");
        let mut window = entry.window;
        let root = graph.value(root);
        window.interior = interior;
        graph.egraph.rebuild();
        (window, graph.find(root))
    }
}

struct WindowImporter<'a, 'g> {
    around: &'a Surroundings<'a>,
    graph: &'g mut EquivalenceGraph,
    window: RewriteWindow,
    numbers: HashMap<Operand, u32, FxBuildHasher>,
    interior: &'a [Value],
    /// The number of reads of each interior value inside.
    inside: Vec<u32>,
    known: Vec<ClassReference>,
    /// The terms or factors of each interior value.
    bags: Vec<Vec<ClassReference>>,
}

impl WindowImporter<'_, '_> {
    fn place(&self, operand: Operand) -> Option<usize> {
        self.interior.binary_search(&operand.value()?).ok()
    }

    fn count_uses(&mut self) {
        for &value in self.interior {
            for &operand in self.around.function.node(value).operands() {
                if let Some(place) = self.place(operand) {
                    self.inside[place] += 1;
                }
            }
        }
    }

    fn leaf(&mut self, operand: Operand) -> Id {
        let next = self.window.leaves.len() as u32;
        let number = *self.numbers.entry(operand).or_insert(next);
        if number == next {
            let time = operand.entry_or_default(self.around.times);
            self.window.leaves.push(operand);
            self.window.times.push(time);
        }
        let leaf = self.graph.leaf(number);
        if number == next && self.around.trig {
            self.argument(operand, leaf);
        }
        leaf
    }

    /// Records of which angle a leaf is the sine or cosine.
    fn argument(&mut self, operand: Operand, leaf: Id) {
        let function = self.around.function;
        if let Some(value) = operand.value()
            && function.node(value).operation.is_trigonometric()
        {
            let node = *function.node(value);
            let argument = self.operand(node.operands[0]);
            let whole = self.graph.other(node.operation, &[argument]);
            self.graph.equate(leaf, whole);
        }
    }

    fn operand(&mut self, operand: Operand) -> ClassReference {
        if let Some(place) = self.place(operand) {
            return self.known[place];
        }
        match operand.kind() {
            OperandKind::Constant(constant) => {
                let number = self.around.function.constant_number(constant);
                // What is no number is nothing to calculate with.
                match number.is_finite() {
                    true if self.around.plain => self.graph.egraph.add(plain_number(number)).into(),
                    true => self.graph.number(number),
                    false => self.leaf(operand).into(),
                }
            }
            _ => self.leaf(operand).into(),
        }
    }

    /// The parts that an operand brings into a bag: itself, or its own parts
    /// when only this bag uses it.
    fn parts(&mut self, operation: Operation, operand: Operand) -> Vec<ClassReference> {
        if let Some(place) = self.place(operand) {
            let inner = self.interior[place];
            let other = self.around.function.node(inner).operation;
            if self.around.uses[inner.index()] == 1 && is_one_bag(operation, other) {
                return self.bags[place].clone();
            }
        }
        vec![self.operand(operand)]
    }

    fn node(&mut self, place: usize) {
        let value = self.interior[place];
        let node = *self.around.function.node(value);
        let mut bag = Vec::new();
        let known = match node.operation {
            operation if self.around.plain => {
                let operands = node.operands().iter();
                let operands = operands.map(|&operand| self.operand(operand).class);
                let form = EquivalentForm::Other(operation, operands.collect());
                Some(self.graph.egraph.add(form).into())
            }
            Operation::Add | Operation::Sub | Operation::Mul => {
                for (side, &operand) in node.operands().iter().enumerate() {
                    let minus = node.operation == Operation::Sub && side == 1;
                    let parts = self.parts(node.operation, operand);
                    bag.extend(parts.into_iter().map(|term| term.signed(minus)));
                }
                match node.operation {
                    Operation::Mul => self.graph.product(&bag),
                    _ => self.graph.sum(&bag),
                }
            }
            Operation::Copy => Some(self.operand(node.operands[0])),
            Operation::Neg => Some(self.operand(node.operands[0]).negated()),
            _ => {
                let operands: Vec<ClassReference> = node
                    .operands()
                    .iter()
                    .map(|&operand| self.operand(operand))
                    .collect();
                Some(self.graph.other(node.operation, &operands))
            }
        };
        // Too wide a bag stays what it is.
        let known = known.unwrap_or_else(|| self.leaf(value.into()).into());
        let is_root = place + 1 == self.interior.len();
        let outside = self.around.uses[value.index()] > self.inside[place];
        if !is_root && outside {
            let class = self.graph.value(known);
            let leaf = self.leaf(value.into());
            self.graph.egraph.union(class, leaf);
        } else {
            self.window.own += 1;
        }
        self.known.push(known);
        self.bags.push(bag);
    }
}
