//! The linearised graph of a function: the values that depend on the inputs of
//! differentiation and lead to the differentiated outputs, with the partial
//! derivative of every operation by every operand on the edges (Bauer 1974;
//! Griewank and Walther, *Evaluating Derivatives*, 2008, section 9.2).
//!
//! **Invariant.** Vertices are numbered in topological order, every vertex
//! lies on a path from an end to an end, and no edge has the weight zero.

use super::weights::{PartialOrigin, PathWeight, WeightWriter};
use robovec_ir::{Function, Node, Operand, OperandKind, Operation, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Meaning of a vertex.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Vertex {
    /// The direction, from which all columns are reached.
    Source,
    /// An input element, by its place among those differentiated by.
    Column(u32),
    /// An operation.
    Node(Value),
    /// An output, by the place of its assignment.
    Row(u32),
    /// The weighted sum of all rows.
    Sink,
}

/// Vertices and edges.
#[derive(Clone)]
pub(super) struct LinearisedGraph {
    pub(super) vertices: Vec<Vertex>,
    /// By vertex, the vertices before it with the weights of the edges.
    pub(super) into: Vec<BTreeMap<u32, PathWeight>>,
    /// By vertex, the vertices after it.
    pub(super) out: Vec<BTreeSet<u32>>,
}

/// Beginning and end of a graph.
pub(super) struct Ends<'a> {
    /// The input elements differentiated by.
    pub(super) columns: &'a [u32],
    /// The places of the assignments that are differentiated.
    pub(super) rows: &'a [u32],
    /// By column its element of the direction, when there is one.
    pub(super) direction: Option<&'a [Operand]>,
    /// By place in `rows` its weight, when there are any.
    pub(super) weights: Option<&'a [Operand]>,
}

impl LinearisedGraph {
    /// The graph of a function that a writer has copied, with the same values
    /// and assignments `set`. Partial derivatives that are no operands are
    /// written.
    pub(super) fn new(
        writer: &mut WeightWriter,
        set: &[Operand],
        ends: &Ends<'_>,
        origin: impl Fn(&Node) -> PartialOrigin,
    ) -> LinearisedGraph {
        let count = writer.len();
        let mut of_input = vec![None; writer.function.input_len()];
        for (column, &input) in ends.columns.iter().enumerate() {
            of_input[input as usize] = Some(column as u32);
        }
        let on_path = on_path(&writer.function, set, ends.rows, &of_input);
        let mut graph = LinearisedGraph {
            vertices: Vec::new(),
            into: Vec::new(),
            out: Vec::new(),
        };
        let source = ends.direction.map(|_| graph.vertex(Vertex::Source));
        let columns = ends.columns.len() as u32;
        let first_column = graph.vertices.len() as u32;
        for column in 0..columns {
            graph.vertex(Vertex::Column(column));
        }
        if let (Some(source), Some(direction)) = (source, ends.direction) {
            for (column, &element) in direction.iter().enumerate() {
                graph.edge(source, first_column + column as u32, writer, element);
            }
        }
        let mut of_value = vec![None; count];
        let vertex_of = |of_value: &[Option<u32>], operand: Operand| match operand.kind() {
            OperandKind::Value(value) => of_value[value.index()],
            OperandKind::Input(input) => {
                of_input[input.index()].map(|column| first_column + column)
            }
            OperandKind::Constant(_) | OperandKind::None => None,
        };
        for index in (0..count).filter(|&index| on_path[index]) {
            let value = Value(index as u32);
            let node = *writer.function.node(value);
            let vertex = graph.vertex(Vertex::Node(value));
            of_value[index] = Some(vertex);
            let origin = origin(&node);
            for (place, &operand) in node.operands().iter().enumerate() {
                let Some(from) = vertex_of(&of_value, operand) else {
                    continue;
                };
                if let Some(weight) = partial(writer, value, &node, place, origin) {
                    graph.add(from, vertex, weight, writer, origin);
                }
            }
        }
        let mut rows = Vec::new();
        for (place, &row) in ends.rows.iter().enumerate() {
            if let Some(from) = vertex_of(&of_value, set[row as usize]) {
                let vertex = graph.vertex(Vertex::Row(row));
                graph.into[vertex as usize].insert(from, PathWeight::ONE);
                graph.out[from as usize].insert(vertex);
                rows.push((vertex, place));
            }
        }
        if let Some(weights) = ends.weights {
            let sink = graph.vertex(Vertex::Sink);
            for (row, place) in rows {
                graph.edge(row, sink, writer, weights[place]);
            }
        }
        graph
    }

    fn vertex(&mut self, vertex: Vertex) -> u32 {
        self.vertices.push(vertex);
        self.into.push(BTreeMap::new());
        self.out.push(BTreeSet::new());
        self.vertices.len() as u32 - 1
    }

    fn edge(&mut self, from: u32, to: u32, writer: &mut WeightWriter, operand: Operand) {
        if let Some(weight) = writer.weight(operand) {
            self.into[to as usize].insert(from, weight);
            self.out[from as usize].insert(to);
        }
    }

    /// Adds a weight to an edge.
    pub(super) fn add(
        &mut self,
        from: u32,
        to: u32,
        weight: PathWeight,
        writer: &mut WeightWriter,
        origin: PartialOrigin,
    ) {
        let sum = match self.into[to as usize].get(&from) {
            None => Some(weight),
            Some(&known) => writer.sum(known, weight, origin),
        };
        match sum {
            Some(sum) => {
                self.into[to as usize].insert(from, sum);
                self.out[from as usize].insert(to);
            }
            None => {
                self.into[to as usize].remove(&from);
                self.out[from as usize].remove(&to);
            }
        }
    }
}

/// The operations on a path from a column to a row.
fn on_path(
    function: &Function,
    set: &[Operand],
    rows: &[u32],
    of_input: &[Option<u32>],
) -> Vec<bool> {
    let mut active = vec![false; function.nodes().len()];
    for (value, node) in function.values() {
        active[value.index()] = node.operands().iter().any(|operand| match operand.kind() {
            OperandKind::Value(operand) => active[operand.index()],
            OperandKind::Input(input) => of_input[input.index()].is_some(),
            OperandKind::Constant(_) | OperandKind::None => false,
        });
    }
    let mut needed = vec![false; active.len()];
    let roots = rows.iter().map(|&row| set[row as usize]);
    for value in roots.filter_map(|operand| operand.value()) {
        needed[value.index()] = true;
    }
    for (value, node) in function.values().rev() {
        let index = value.index();
        needed[index] &= active[index];
        if needed[index] {
            for operand in node.operands().iter().filter_map(|operand| operand.value()) {
                needed[operand.index()] = true;
            }
        }
    }
    needed
}

/// The partial derivative of an operation by one of its operands; `None` for
/// zero.
fn partial(
    writer: &mut WeightWriter,
    value: Value,
    node: &Node,
    place: usize,
    origin: PartialOrigin,
) -> Option<PathWeight> {
    let [a, b, _] = node.operands;
    let other = [b, a, Operand::NONE][place];
    match (node.operation, place) {
        (Operation::Copy | Operation::Add, _) | (Operation::Sub, 0) => Some(PathWeight::ONE),
        (Operation::Neg | Operation::Sub, _) => Some(PathWeight::ONE.flip(true)),
        (Operation::Mul, _) => writer.weight(other),
        (Operation::Fma | Operation::Fms, 0 | 1) => writer.weight(other),
        (Operation::Fnma, 0 | 1) => Some(writer.weight(other)?.flip(true)),
        (Operation::Fma | Operation::Fnma, _) => Some(PathWeight::ONE),
        (Operation::Fms, _) => Some(PathWeight::ONE.flip(true)),
        (Operation::Div, _) => {
            let inverse = inverse(writer, b, origin)?;
            if place == 0 {
                return Some(inverse);
            }
            // The derivative of a/b by b is -(a/b)/b.
            let quotient = writer.weight(value.into())?;
            Some(writer.product(quotient, inverse, origin).flip(true))
        }
        (Operation::Sin, _) => {
            let cosine = writer.operation(Operation::Cos, [a], origin);
            writer.weight(cosine)
        }
        (Operation::Cos, _) => {
            let sine = writer.operation(Operation::Sin, [a], origin);
            Some(writer.weight(sine)?.flip(true))
        }
        (Operation::Sqrt, _) => {
            let half = writer.function.constant(0.5).into();
            let weight = writer.operation(Operation::Div, [half, value.into()], origin);
            writer.weight(weight)
        }
    }
}

/// One over an operand.
fn inverse(
    writer: &mut WeightWriter,
    operand: Operand,
    origin: PartialOrigin,
) -> Option<PathWeight> {
    let number = writer.function.number(operand);
    if let Some(inverse) = crate::fold::known(Operation::Div, Some(1.0), number) {
        let constant = writer.function.constant(inverse).into();
        return writer.weight(constant);
    }
    let one = writer.function.constant(1.0).into();
    let inverse = writer.operation(Operation::Div, [one, operand], origin);
    writer.weight(inverse)
}
