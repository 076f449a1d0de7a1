//! Values that are used before they are defined, or never defined.
//!
//! Which of the two is known at the end of the function. Then a name gets one
//! message: a later definition, a circular definition (with the circle), or a
//! similar name.

use super::builder::ModuleBuilder;
use super::parts::{FastMap, Span};
use super::problems::{also, error};
use crate::diagnostic::{Diagnostic, clip, did_you_mean};
use crate::entity::Value;
use crate::symbol::Name;
use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use std::collections::VecDeque;

/// The largest number of definitions of a circle that are shown.
const MAX_SHOWN: usize = 6;

/// The largest number of names compared with a misspelt one.
const MAX_COMPARED: usize = 20_000;

/// A definition that reads a value defined later.
struct Forward {
    user: Value,
    used: Value,
    span: Span,
}

impl ModuleBuilder<'_> {
    /// Reports the undefined names of the function being read.
    pub(super) fn report_undefined(&mut self) {
        let uses = std::mem::take(&mut self.open.undefined.uses);
        if uses.is_empty() || self.is_full() {
            return;
        }
        let mut seen: FastMap<&str, ()> = FastMap::default();
        let mut forward: Vec<Forward> = Vec::new();
        let roots = self.next_definitions();
        for (span, node) in uses {
            let text = self.slice(span);
            let first = seen.insert(text, ()).is_none();
            match (
                self.find_name(text),
                self.definition_around(span, roots.get(node as usize)),
            ) {
                (None, _) if first => self.report_unknown(span),
                (None, _) => {}
                (Some(used), Some(user)) => forward.push(Forward { user, used, span }),
                (Some(used), None) if first => self.report_later(span, used),
                (Some(_), None) => {}
            }
        }
        if !forward.is_empty() && !self.is_full() {
            self.report_forward(&forward);
        }
    }

    fn find_name(&self, text: &str) -> Option<Value> {
        let (base, suffix) = Name::split(&text[1..]);
        let base = self.module.tables.symbols.find(base)?;
        self.names.get(Name { base, suffix })
    }

    /// For every node the first definition at or after it, if any.
    fn next_definitions(&self) -> Vec<Option<Value>> {
        let mut next = None;
        let nodes = self.open.function.values().rev();
        let mut roots: Vec<Option<Value>> = nodes
            .map(|(value, node)| {
                if !node.name.is_none() {
                    next = Some(value);
                }
                next
            })
            .collect();
        roots.reverse();
        roots
    }

    /// The definition whose expression holds a use, given the next one after
    /// it; `None` in an assignment.
    fn definition_around(&self, span: Span, root: Option<&Option<Value>>) -> Option<Value> {
        let root = (*root?)?;
        let around = self.open.spans[root.index()];
        (around.start <= span.start && span.end <= around.end).then_some(root)
    }

    fn report_later(&mut self, span: Span, used: Value) {
        let definition = self.open.name_span(used, self.text);
        let message = format!("{} is used before it is defined", clip(self.slice(span)));
        self.problems.push(
            error(span, message)
                .with_label(also(definition, "defined here"))
                .with_note("help: move the definition up: a value is defined before its first use"),
        );
    }

    fn report_unknown(&mut self, span: Span) {
        if self.is_full() {
            return;
        }
        let text = self.slice(span);
        let name = &text[1..];
        let (base, _) = Name::split(name);
        let message = format!("{} is not defined", clip(text));
        let mut diagnostic = error(span, message);
        let symbols = &self.module.tables.symbols;
        let last = symbols.find(base).and_then(|base| self.names.last_of(base));
        if let Some(last) = last {
            let last_name = self.open.function.node(last).name;
            let note = if last_name.is_none() {
                format!("help: there is %{}", clip(base))
            } else {
                format!(
                    "help: the last value of that name is %{}",
                    last_name.display(symbols)
                )
            };
            diagnostic = diagnostic.with_note(note);
        } else if self.open.inputs.contains_key(name) {
            diagnostic =
                diagnostic.with_note(format!("help: '{name}' is an input: inputs have no %"));
        } else if let Some(nearest) = self.nearest(base) {
            diagnostic = diagnostic.with_note(format!("help: did you mean %{nearest}?"));
        }
        self.problems.push(diagnostic);
    }

    /// The name among those defined that is most like a misspelt one.
    fn nearest(&self, word: &str) -> Option<String> {
        let letters = letter_set(word);
        let nodes = self.open.function.nodes().iter();
        let bases = nodes
            .filter(|node| !node.name.is_none() && node.name.suffix == 0)
            .map(|node| self.module.tables.symbols.text(node.name.base))
            // One edit changes at most two bits of the set.
            .filter(|candidate| (letter_set(candidate) ^ letters).count_ones() <= 6)
            .filter(|candidate| candidate.len().abs_diff(word.len()) <= 3)
            .take(MAX_COMPARED);
        did_you_mean(word, bases).map(str::to_owned)
    }

    /// Uses of values that are defined later, circles once each.
    fn report_forward(&mut self, forward: &[Forward]) {
        let graph = self.dependence_graph(forward);
        let mut component = vec![0u32; graph.node_count()];
        for (number, members) in kosaraju_scc(&graph).iter().enumerate() {
            for member in members {
                component[member.index()] = number as u32;
            }
        }
        let mut shown: FastMap<u32, ()> = FastMap::default();
        let mut reported: FastMap<Value, ()> = FastMap::default();
        for &Forward { user, used, span } in forward {
            let number = component[user.index()];
            if number != component[used.index()] {
                if reported.insert(used, ()).is_none() {
                    self.report_later(span, used);
                }
            } else if shown.insert(number, ()).is_none() {
                let circle = self.circle(&graph, user, used);
                self.report_circle(span, &circle);
            }
        }
    }

    /// An edge from every node to each node it reads.
    fn dependence_graph(&self, forward: &[Forward]) -> DiGraph<(), ()> {
        let function = &self.open.function;
        let mut graph = DiGraph::with_capacity(function.nodes().len(), 2 * function.nodes().len());
        for _ in function.nodes() {
            graph.add_node(());
        }
        let index = |value: Value| NodeIndex::new(value.index());
        for (value, node) in function.values() {
            for operand in node.operands().iter().filter_map(|operand| operand.value()) {
                graph.add_edge(index(value), index(operand), ());
            }
        }
        for &Forward { user, used, .. } in forward {
            graph.add_edge(index(user), index(used), ());
        }
        graph
    }

    /// The definitions on a shortest way from `used` back to `user`, which
    /// reads `used`; `user` comes first.
    fn circle(&self, graph: &DiGraph<(), ()>, user: Value, used: Value) -> Vec<Value> {
        let (goal, start) = (NodeIndex::new(user.index()), NodeIndex::new(used.index()));
        let mut came_from: Vec<Option<NodeIndex>> = vec![None; graph.node_count()];
        let mut queue = VecDeque::from([start]);
        while let Some(node) = queue.pop_front() {
            if node == goal {
                break;
            }
            for next in graph.neighbors(node) {
                if came_from[next.index()].is_none() && next != start {
                    came_from[next.index()] = Some(node);
                    queue.push_back(next);
                }
            }
        }
        let mut way = Vec::new();
        let mut at = goal;
        loop {
            way.push(Value(at.index() as u32));
            match came_from[at.index()] {
                Some(before) if at != start => at = before,
                Some(_) | None => break,
            }
        }
        // Read backwards the way leads from the goal to what reads it.
        way[1..].reverse();
        way.retain(|&value| !self.open.function.node(value).name.is_none());
        way
    }

    fn report_circle(&mut self, span: Span, circle: &[Value]) {
        let symbols = &self.module.tables.symbols;
        let name =
            |value: &Value| format!("%{}", self.open.function.node(*value).name.display(symbols));
        let diagnostic: Diagnostic = if circle.len() < 2 {
            error(
                span,
                format!("{} needs its own value", clip(self.slice(span))),
            )
        } else {
            let mut way: Vec<String> = circle.iter().take(MAX_SHOWN).map(name).collect();
            if circle.len() > MAX_SHOWN {
                way.push(format!("{} more", circle.len() - MAX_SHOWN));
            }
            way.push(name(&circle[0]));
            let labels = circle[1..]
                .iter()
                .take(MAX_SHOWN - 1)
                .map(|&value| also(self.open.name_span(value, self.text), "in the circle"));
            error(span, "these definitions form a circle")
                .with_labels_iter(labels)
                .with_note(way.join(" needs "))
        };
        self.problems.push(diagnostic);
    }
}

fn letter_set(word: &str) -> u64 {
    word.bytes().fold(0, |set, byte| set | 1 << (byte & 63))
}
