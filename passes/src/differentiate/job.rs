//! The writing of one derivative of one function.

use super::DerivativeMode;
use super::eliminate::{Elimination, EliminationLimit, EliminationOrder, TooMuchWork, parts};
use super::graph::{Ends, LinearisedGraph, Vertex};
use super::weights::{PartialOrigin, PathWeight, WeightWriter};
use robovec_framework::differentiation::{DerivativeArrays, DerivativeResult};
use robovec_framework::pass::{Context, PassError};
use robovec_framework::rewrite::output_symbol;
use robovec_ir::{
    Assignment, Function, Input, Operand, Operation, Output, SourceSet, Symbol, Tables,
};

/// The maximum number of operations a function may get: the text of more is
/// larger than any file that is read.
const MAX_OPERATIONS: usize = 1 << 24;

/// The maximum number of products of weights in one order.
const MAX_PRODUCTS: u64 = 1 << 26;

/// Number of roots that are named in a remark.
const NAMED_ROOTS: usize = 4;

/// One derivative of one function.
pub(super) struct DerivativeJob<'a> {
    old: &'a Function,
    arrays: DerivativeArrays,
    result: DerivativeResult,
    /// The function after, with the operations of the function before.
    start: Function,
    /// Operands that the assignments of the function before are set to, in the
    /// function after.
    set: Vec<Operand>,
    columns: Vec<u32>,
    /// Places of the assignments that are differentiated.
    rows: Vec<u32>,
    /// By assignment the base of its derivatives' names.
    row_names: Vec<Symbol>,
}

impl<'a> DerivativeJob<'a> {
    pub(super) fn new(
        old: &'a Function,
        arrays: DerivativeArrays,
        result: DerivativeResult,
        tables: &mut Tables,
    ) -> DerivativeJob<'a> {
        let signature = signature(old, &arrays, tables);
        let mut start = old.moved_into(signature, |input| input, |_| None);
        let assignments = old.assignments.iter();
        let set = assignments.map(|set| match old.number(set.operand) {
            Some(number) => start.constant(number).into(),
            None => set.operand,
        });
        let set = set.collect();
        let wanted = arrays.rows();
        let rows = (0..old.assignments.len() as u32).filter(|&place| {
            let output = old.assignments[place as usize].output;
            wanted.binary_search(&output.0).is_ok()
        });
        let names = old.assignments.iter();
        let row_names = names.map(|row| output_symbol(tables, old, row.output));
        DerivativeJob {
            rows: rows.collect(),
            row_names: row_names.collect(),
            columns: arrays.columns(),
            start,
            set,
            old,
            arrays,
            result,
        }
    }

    /// The function with its derivative, and the rules of new values.
    pub(super) fn write(
        mut self,
        mode: DerivativeMode,
        context: &mut Context<'_>,
    ) -> Result<WeightWriter, PassError> {
        let mut writer = WeightWriter::new(std::mem::replace(
            &mut self.start,
            self.old.skeleton(self.old.level),
        ));
        let own = writer.len();
        let [direction, weights] = self.seeds();
        let graph = LinearisedGraph::new(
            &mut writer,
            &self.set,
            &Ends {
                columns: &self.columns,
                rows: &self.rows,
                direction: direction.as_deref(),
                weights: weights.as_deref(),
            },
            |node| PartialOrigin {
                base: node.name.base,
                sources: node.sources,
                rule: "partial derivative",
            },
        );
        self.tell(&graph, context);
        let parts = parts(&graph);
        let orders = match mode {
            DerivativeMode::Forward => vec![EliminationOrder::Forward; parts.len()],
            DerivativeMode::Reverse => vec![EliminationOrder::Reverse; parts.len()],
            DerivativeMode::Mixed => self.cheapest(&graph, &writer, &parts, context)?,
        };
        let (old, names, tables) = (self.old, &self.row_names, &mut *context.tables);
        let mut origin = |own: Vertex, next: Vertex| {
            let of = |vertex: Vertex| match vertex {
                Vertex::Node(value) => {
                    let node = old.node(value);
                    Some((node.name.base, node.sources))
                }
                Vertex::Row(row) => {
                    Some((names[row as usize], old.assignments[row as usize].sources))
                }
                Vertex::Source | Vertex::Column(_) | Vertex::Sink => None,
            };
            let known: Vec<(Symbol, SourceSet)> = [next, own].into_iter().filter_map(of).collect();
            let sets: Vec<SourceSet> = known.iter().map(|(_, sources)| *sources).collect();
            PartialOrigin {
                // A column that is eliminated leads to an operation or a row.
                base: known.first().expect("an edge has an end inside").0,
                sources: tables.sources.union(&sets),
                rule: "chain rule",
            }
        };
        let mut elimination = Elimination {
            graph,
            writer,
            limit: full_limit(),
            origin: &mut origin,
        };
        for (part, &order) in parts.iter().zip(&orders) {
            let done = elimination.part(part, order);
            done.map_err(|TooMuchWork| too_large())?;
        }
        let Elimination {
            graph, mut writer, ..
        } = elimination;
        let assigned = self.assign(&graph, &mut writer);
        let added = (writer.len() - own) as u64;
        context.count("elements set", assigned);
        context.count("operations added", added);
        Ok(writer)
    }

    /// The new inputs that represent directions and weights.
    fn seeds(&self) -> [Option<Vec<Operand>>; 2] {
        let first = self.old.input_len() as u32;
        let element = |place: u32| Operand::from(Input(first + place));
        match self.result {
            DerivativeResult::Jacobian => [None, None],
            DerivativeResult::Direction => {
                let columns = 0..self.columns.len() as u32;
                [Some(columns.map(element).collect()), None]
            }
            DerivativeResult::Gradient => {
                let wanted = self.arrays.rows();
                let places = self.rows.iter().map(|&row| {
                    let output = self.old.assignments[row as usize].output.0;
                    let place = wanted.binary_search(&output);
                    element(place.expect("a row is a wanted output") as u32)
                });
                [None, Some(places.collect())]
            }
        }
    }

    /// Remarks on missing or incomplete derivatives.
    fn tell(&self, graph: &LinearisedGraph, context: &mut Context<'_>) {
        let symbols = &context.tables.symbols;
        let roots = graph.vertices.iter().filter_map(|&vertex| match vertex {
            Vertex::Node(value) => Some(self.old.node(value)),
            _ => None,
        });
        let mut roots: Vec<String> = roots
            .filter(|node| node.operation == Operation::Sqrt)
            .map(|node| format!("%{}", node.name.display(symbols)))
            .collect();
        let unnamed = roots.len().saturating_sub(NAMED_ROOTS);
        roots.truncate(NAMED_ROOTS);
        if unnamed > 0 {
            roots.push(format!("{unnamed} more"));
        }
        if !roots.is_empty() {
            let roots = roots.join(", ");
            let remark = format!("there is no derivative where a root is zero: {roots}");
            context.remarks.push(remark);
        }
        let by = self.arrays.by.iter().map(|array| symbols.text(array.name));
        let by: Vec<&str> = by.collect();
        for boundary in &self.old.boundaries {
            if let Some(result) = &boundary.result
                && !by.contains(&result.as_str())
            {
                context.remarks.push(format!(
                    "the result {result} of {} counts as constant; 'by' can name it",
                    boundary.callee
                ));
            }
        }
    }

    /// The cheapest order for every part, each tried on a copy.
    fn cheapest(
        &self,
        graph: &LinearisedGraph,
        writer: &WeightWriter,
        parts: &[Vec<u32>],
        context: &mut Context<'_>,
    ) -> Result<Vec<EliminationOrder>, PassError> {
        // Nobody reads the names of a copy.
        let mut origin = |_, _| PartialOrigin {
            base: Symbol(0),
            sources: SourceSet::EMPTY,
            rule: "",
        };
        let mut best: Vec<Option<(usize, EliminationOrder)>> = vec![None; parts.len()];
        for order in EliminationOrder::ALL {
            let mut trial = Elimination {
                graph: graph.clone(),
                writer: writer.clone(),
                limit: full_limit(),
                origin: &mut origin,
            };
            let mut is_whole = true;
            for (part, best) in parts.iter().zip(&mut best) {
                let start = trial.writer.len();
                let most = best.map_or(MAX_OPERATIONS, |(cost, _)| start + cost);
                trial.limit.operations = most.min(MAX_OPERATIONS);
                let done = trial.part(part, order).is_ok();
                let cost = trial.writer.len() - start;
                is_whole &= done;
                if done && best.is_none_or(|(known, _)| cost < known) {
                    *best = Some((cost, order));
                }
            }
            if is_whole {
                let count = (trial.writer.len() - writer.len()) as u64;
                context.count(order.count_name(), count);
            }
        }
        let orders = best.into_iter();
        let orders = orders.map(|best| best.map(|(_, order)| order).ok_or_else(too_large));
        orders.collect()
    }

    /// Sets the outputs that are kept and those of the derivative; the number
    /// of the latter.
    fn assign(&self, graph: &LinearisedGraph, writer: &mut WeightWriter) -> u64 {
        let mut first = 0;
        for array in &self.arrays.kept {
            for (set, &operand) in self.old.assignments.iter().zip(&self.set) {
                let place = set.output.0.wrapping_sub(array.offset);
                if (place as usize) < array.shape.len() {
                    writer.function.assignments.push(Assignment {
                        output: Output(first + place),
                        operand,
                        ..*set
                    });
                }
            }
            first += array.shape.len() as u32;
        }
        let kept = writer.function.assignments.len();
        let wanted = self.arrays.rows();
        let jacobian: Vec<Vec<u32>> = match self.result {
            DerivativeResult::Jacobian => self.arrays.jacobian().map(Iterator::collect).collect(),
            _ => Vec::new(),
        };
        for (vertex, &kind) in graph.vertices.iter().enumerate() {
            let row = match kind {
                Vertex::Row(row) => Some(row as usize),
                Vertex::Sink => None,
                _ => continue,
            };
            let place = row.map(|row| {
                let output = self.old.assignments[row].output.0;
                let place = wanted.binary_search(&output);
                place.expect("a row is a wanted output")
            });
            for (&from, &weight) in &graph.into[vertex] {
                let output = match (graph.vertices[from as usize], place) {
                    (Vertex::Column(column), Some(place)) if !jacobian.is_empty() => {
                        jacobian[place][column as usize]
                    }
                    (Vertex::Source, Some(place)) => first + place as u32,
                    (Vertex::Column(column), None) => first + column,
                    // A row is no end when weights lead on to the sink.
                    _ => continue,
                };
                self.set_output(writer, Output(output), weight, row);
            }
        }
        self.set_empty_arrays(writer);
        writer.function.sort_assignments();
        (writer.function.assignments.len() - kept) as u64
    }

    /// An array whose elements are all zero by structure gets an assignment of
    /// its first element, since a function sets an element of every output.
    fn set_empty_arrays(&self, writer: &mut WeightWriter) {
        let function = &mut writer.function;
        let mut is_set = vec![false; function.outputs().len()];
        for assignment in &function.assignments {
            is_set[function.output_array(assignment.output)] = true;
        }
        let zero = Operand::from(function.constant(0.0));
        let derivatives = self.arrays.kept.len()..is_set.len();
        for array in derivatives.filter(|&array| !is_set[array]) {
            let array = function.outputs()[array];
            if !array.shape.is_empty() {
                function.assign(Output(array.offset), zero, SourceSet::EMPTY);
            }
        }
    }

    fn set_output(
        &self,
        writer: &mut WeightWriter,
        output: Output,
        weight: PathWeight,
        row: Option<usize>,
    ) {
        let row = row.or(self.rows.first().map(|&row| row as usize));
        let row = row.expect("an edge leads to a row");
        let sources = self.old.assignments[row].sources;
        let origin = PartialOrigin {
            base: self.row_names[row],
            sources,
            rule: "chain rule",
        };
        let operand = writer.signed(weight, origin);
        writer.function.assign(output, operand, sources);
    }
}

/// The function after, without a body.
fn signature(old: &Function, arrays: &DerivativeArrays, tables: &mut Tables) -> Function {
    let mut new = old.header(old.level);
    new.reserve(2 * old.nodes().len());
    for array in old.inputs() {
        new.add_input(array.name, array.shape);
    }
    for (name, shape) in &arrays.inputs {
        new.add_input(tables.symbols.intern(name), *shape);
    }
    for array in &arrays.kept {
        new.add_output(array.name, array.shape);
    }
    for (name, shape) in &arrays.outputs {
        new.add_output(tables.symbols.intern(name), *shape);
    }
    new
}

fn full_limit() -> EliminationLimit {
    EliminationLimit {
        operations: MAX_OPERATIONS,
        products: MAX_PRODUCTS,
    }
}

fn too_large() -> PassError {
    let message = format!(
        "the derivative has more than {MAX_OPERATIONS} operations, or needs more than \
         {MAX_PRODUCTS} products"
    );
    PassError::new(message).help(
        "choose fewer arrays with 'of' and 'by', or 'result=direction' or 'result=gradient', which \
         cost a few times the function itself",
    )
}
