//! Common subexpressions are computed once.

mod lookalikes;

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;
use lookalikes::Lookalikes;
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::Rewriter;
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_framework::trail::{Notes, equal_to};
use robovec_ir::{Function, Node, Operand, Operation, SourceSet, Tables, Value};
use rustc_hash::FxBuildHasher;
use smallvec::SmallVec;
use std::hash::BuildHasher;

declare_pass! {
    /// Computes equal operations on equal operands once.
    ///
    /// Sums and products count as equal when their operands are exchanged; no
    /// term is reassociated, so no bit changes. The first of several equal
    /// values stays and takes over the source places of the others. Values of
    /// different number formats are not equal.
    pub struct Cse("cse") {}
    takes: [Atomic],
    gives: Gives::Same,
    class: Exact,
    sets: [Shared],
    destroys: [Timed],
}

/// An operation with its operands in canonical order: the common key of equal
/// computations.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Key {
    operation: Operation,
    operands: [Operand; Operand::MAX_COUNT],
}

impl Key {
    /// The key of an operation.
    pub fn new<const COUNT: usize>(operation: Operation, operands: [Operand; COUNT]) -> Key {
        let mut operands = Operand::list(operands);
        if operation.is_commutative() && operands[1] < operands[0] {
            operands.swap(0, 1);
        }
        Key {
            operation,
            operands,
        }
    }

    fn of(node: &Node) -> Key {
        Key::new(node.operation, node.operands)
    }

    fn hash(self) -> u64 {
        FxBuildHasher.hash_one((
            u64::from(self.operation as u32) << 32 | u64::from(self.operands[2].bits()),
            u64::from(self.operands[0].bits()) << 32 | u64::from(self.operands[1].bits()),
        ))
    }
}

/// Finds the value of a function that computes a given operation.
///
/// Holds value numbers only and compares with the function's nodes, four
/// bytes per operation.
#[derive(Clone, Default)]
pub struct KnownValues {
    table: HashTable<Value>,
}

impl KnownValues {
    /// An empty table with room for a number of values.
    pub fn with_capacity(values: usize) -> KnownValues {
        KnownValues {
            table: HashTable::with_capacity(values),
        }
    }

    /// The value of the function with this key, if it was inserted.
    pub fn find(&self, function: &Function, key: Key) -> Option<Value> {
        self.table
            .find(key.hash(), |&value| Key::of(function.node(value)) == key)
            .copied()
    }

    /// The value of the function with this key; when there is none, `next` is
    /// entered, which has this key, at the latest when the next one is looked
    /// for.
    pub fn find_or_insert(&mut self, function: &Function, key: Key, next: Value) -> Option<Value> {
        let same = |&value: &Value| Key::of(function.node(value)) == key;
        let rehash = |&other: &Value| Key::of(function.node(other)).hash();
        match self.table.entry(key.hash(), same, rehash) {
            Entry::Occupied(known) => Some(*known.get()),
            Entry::Vacant(place) => {
                place.insert(next);
                None
            }
        }
    }

    /// Adds a value of the function that is not in the table yet.
    pub fn insert(&mut self, function: &Function, value: Value) {
        let hash = Key::of(function.node(value)).hash();
        self.table
            .insert_unique(hash, value, |&other| Key::of(function.node(other)).hash());
    }
}

/// Values whose source sets are extended by those of merged values.
///
/// Merging is delayed to the end and done once per value, since a union per
/// merge would be quadratic where thousands of equal equations are merged.
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
    pub fn apply(mut self, function: &mut Function, tables: &mut Tables) {
        self.merges.sort_by_key(|(value, _)| *value);
        for group in self.merges.chunk_by(|a, b| a.0 == b.0) {
            let value = group[0].0;
            let mut sets: SmallVec<[SourceSet; 8]> = group.iter().map(|(_, set)| *set).collect();
            sets.push(function.node(value).sources);
            function.node_mut(value).sources = tables.sources.union(&sets);
        }
    }
}

/// The function with equal operations merged, and the number of merges; `None`
/// when there are none. Tests before each merge, and notes the merged values.
pub fn merge_equal(
    function: &Function,
    tables: &mut Tables,
    rewrites: &RewriteLimit,
    notes: &mut Notes,
) -> Option<(Function, u64)> {
    // Mostly there is nothing to merge, and then nothing need be written.
    let lookalikes = Lookalikes::find(function);
    let count = lookalikes.count();
    if !some_are_equal(function, &lookalikes, count) {
        return None;
    }
    let mut rewriter = Rewriter::with_formats(function, function.level);
    let mut known = KnownValues::with_capacity(count);
    let mut merges = SourceMerges::default();
    let mut merged = 0;
    for (value, node) in function.values() {
        let operands = rewriter.translate_operands(node);
        if !lookalikes.has(value) {
            rewriter.keep(Node { operands, ..*node });
            continue;
        }
        let key = Key::new(node.operation, operands);
        let format = |function: &Function, value| function.formats.as_ref()?.get(value);
        let next = Value(rewriter.new.nodes().len() as u32);
        let found = known.find_or_insert(&rewriter.new, key, next);
        let same = found.filter(|&same| format(&rewriter.new, same) == format(function, value));
        if let Some(same) = same.filter(|_| rewrites.allow(node.name, "equal operations")) {
            merges.add(same, node.sources);
            if notes.are_wanted() {
                let gone = format!("%{}", node.name.display(&tables.symbols));
                notes.note(rewriter.new.node(same).name, &equal_to(&gone));
            }
            rewriter.record(same.into());
            merged += 1;
        } else {
            let value = rewriter.keep(Node { operands, ..*node });
            // The same operation in another format is a value of its own.
            if found.is_some() && same.is_none() {
                known.insert(&rewriter.new, value);
            }
        }
    }
    if merged == 0 {
        return None;
    }
    let mut new = rewriter.finish();
    merges.apply(&mut new, tables);
    Some((new, merged))
}

/// True when two operations have the same operands: until a merge, operands do
/// not change.
fn some_are_equal(function: &Function, lookalikes: &Lookalikes, count: usize) -> bool {
    let mut known = KnownValues::with_capacity(count);
    let mut values = function
        .values()
        .filter(|&(value, _)| lookalikes.has(value));
    values.any(|(value, node)| {
        let same = known.find_or_insert(function, Key::of(node), value);
        same.is_some()
    })
}

impl Pass for Cse {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let mut count = 0;
        let (rewrites, notes) = (context.rewrites, &mut *context.notes);
        if let Some((new, merged)) = merge_equal(function, context.tables, rewrites, notes) {
            *function = new;
            count = merged;
        }
        context.count("operations merged", count);
        Ok(())
    }
}
