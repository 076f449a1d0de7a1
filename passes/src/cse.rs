//! Common subexpressions are computed once.

use crate::declare_pass;
use crate::pass::{Context, Gives, Pass, PassError};
use crate::rewrite::Rewriter;
use hashbrown::HashMap;
use robovec_ir::{Function, Level, Node, Operand, Operation, SourceSet, Value};
use rustc_hash::FxBuildHasher;

declare_pass! {
    /// Computes equal operations on equal operands once.
    ///
    /// Sums and products count as equal when their operands are exchanged;
    /// nothing is reassociated, so not a bit changes. The first of several
    /// equal values stays and takes over the source places of the others.
    pub struct Cse("cse") {}
    takes: [Atomic],
    gives: Gives::Same,
    class: Exact,
    requires: [],
    sets: [Shared],
    destroys: [Timed],
}

/// An operation with its operands in canonical order: what two equal
/// computations have in common.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Key {
    operation: Operation,
    operands: [Operand; 2],
}

impl Key {
    /// The key of an operation.
    pub fn new(operation: Operation, operands: [Operand; 2]) -> Key {
        let [a, b] = operands;
        let operands = if operation.is_commutative() && b < a {
            [b, a]
        } else {
            operands
        };
        Key {
            operation,
            operands,
        }
    }
}

/// Values whose source sets grow by those of values merged into them.
///
/// Merging is put off to the end and done once per value, since a union per
/// merge would be quadratic where thousands of equal equations meet.
#[derive(Default)]
pub struct SourceMerges {
    merges: Vec<(Value, SourceSet)>,
}

impl SourceMerges {
    /// Notes that a value also comes from these places.
    pub fn add(&mut self, value: Value, sources: SourceSet) {
        self.merges.push((value, sources));
    }

    /// Gives every value the union of its sources.
    pub fn apply(mut self, function: &mut Function, tables: &mut robovec_ir::Tables) {
        self.merges.sort_by_key(|(value, _)| *value);
        for group in self.merges.chunk_by(|a, b| a.0 == b.0) {
            let value = group[0].0;
            let mut sets: Vec<SourceSet> = group.iter().map(|(_, set)| *set).collect();
            sets.push(function.node(value).sources);
            function.node_mut(value).sources = tables.sources.union(&sets);
        }
    }
}

impl Pass for Cse {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let mut rewriter = Rewriter::new(function, Level::Atomic);
        let mut known: HashMap<Key, Value, FxBuildHasher> =
            HashMap::with_capacity_and_hasher(function.nodes().len(), FxBuildHasher);
        let mut merges = SourceMerges::default();
        let mut merged = 0;
        for node in function.nodes() {
            let operands = rewriter.translate_operands(node);
            let key = Key::new(node.operation, operands);
            if let Some(&same) = known.get(&key) {
                merges.add(same, node.sources);
                rewriter.record(same.into());
                merged += 1;
            } else {
                let value = rewriter.keep(Node { operands, ..*node });
                known.insert(key, value);
            }
        }
        *function = rewriter.finish();
        merges.apply(function, context.tables);
        context.statistics.push(("operations merged", merged));
        Ok(())
    }
}
