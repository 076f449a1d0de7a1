//! The order of statements.
//!
//! A processor has some thirty registers; a value that is read long after it
//! was made has been to memory and back. Three orders:
//!
//! * that of the function ([`program`]);
//! * a walk from each output down to what it needs ([`depth_first`]), which
//!   makes the operand that needs most registers first (Sethi and Ullman,
//!   1970): values are close to where they are read, and what is shared
//!   where it is read first;
//! * that of a model of the registers ([`by_registers`]).
//!
//! Only the order changes, so results are equal bit for bit.

mod registers;
#[cfg(test)]
mod tests;

pub(crate) use registers::by_registers;

use crate::superword::Superwords;
use robovec_ir::{Function, Operand, Value};

/// A step of straight-line code.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum CodeStep {
    /// Computes a value, or the superword whose first lane it is.
    Define(Value),
    /// Sets an output element: the place among the assignments.
    Assign(u32),
}

impl CodeStep {
    pub(crate) fn reads(self, function: &Function) -> &[Operand] {
        match self {
            CodeStep::Define(value) => function.node(value).operands(),
            CodeStep::Assign(index) => {
                std::slice::from_ref(&function.assignments[index as usize].operand)
            }
        }
    }
}

impl CodeStep {
    /// The operands that are read, those of all lanes of a superword.
    pub(crate) fn all_reads(self, function: &Function, words: &Superwords) -> Vec<Operand> {
        match self {
            CodeStep::Define(value) => words.reads(function, value).collect(),
            CodeStep::Assign(_) => self.reads(function).to_vec(),
        }
    }
}

/// The values that are marked in `computed`, in the function's order, and then
/// all assignments.
pub(crate) fn program(function: &Function, computed: &[bool]) -> Vec<CodeStep> {
    let values = function.values().map(|(value, _)| value);
    let values = values.filter(|value| computed[value.index()]);
    let outputs = 0..function.assignments.len() as u32;
    let definitions = values.map(CodeStep::Define);
    definitions.chain(outputs.map(CodeStep::Assign)).collect()
}

/// The values that are marked in `computed`, each once and after its operands,
/// and all assignments. With `outputs_last` no output is written before all
/// values are computed. A superword is computed in place of the value
/// in its first lane, which alone is marked.
///
/// Outputs are taken from the last to the first: most operations belong to a
/// recursion from the leaves of a tree to its root, in which those of the last
/// bodies come first.
pub(crate) fn depth_first(
    function: &Function,
    computed: &[bool],
    outputs_last: bool,
    words: &Superwords,
) -> Vec<CodeStep> {
    let needs = needs(function);
    let mut walk = DepthWalk::new(function, &needs, Ties::LeftFirst, words);
    let mut steps = Vec::with_capacity(computed.len());
    let outputs = 0..function.assignments.len() as u32;
    let mut found = Vec::new();
    for output in outputs.clone().rev() {
        let root = function.assignments[output as usize].operand;
        found.clear();
        walk.reach(root, &mut found);
        let defined = found.iter().filter(|value| computed[value.index()]);
        steps.extend(defined.copied().map(CodeStep::Define));
        if !outputs_last {
            steps.push(CodeStep::Assign(output));
        }
    }
    if outputs_last {
        steps.extend(outputs.map(CodeStep::Assign));
    }
    debug_assert!(
        follows_operands(function, computed, &steps, words),
        "a value is computed once, before it is read"
    );
    steps
}

/// True when every value is computed at most once, and the values that are
/// marked in `computed` before they are read.
fn follows_operands(
    function: &Function,
    computed: &[bool],
    steps: &[CodeStep],
    words: &Superwords,
) -> bool {
    let mut defined = vec![false; computed.len()];
    steps.iter().all(|step| {
        let reads = step.all_reads(function, words).into_iter();
        let mut reads = reads.filter_map(|read| read.value().map(|read| words.leader(read)));
        let is_ready = reads.all(|read| defined[read.index()] || !computed[read.index()]);
        match step {
            CodeStep::Define(value) => {
                is_ready && !std::mem::replace(&mut defined[value.index()], true)
            }
            CodeStep::Assign(_) => is_ready,
        }
    })
}

/// The rule for which of two operands with equal keys is walked first.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Ties {
    LeftFirst,
    RightFirst,
}

/// A walk from roots to their operands, the operand with the largest key first.
struct DepthWalk<'a> {
    function: &'a Function,
    keys: &'a [u32],
    ties: Ties,
    words: &'a Superwords,
    /// For each value whether it was found, or shall not be.
    done: Vec<bool>,
    /// The work left; true when all operands were found.
    open: Vec<(Value, bool)>,
}

impl<'a> DepthWalk<'a> {
    fn new(
        function: &'a Function,
        keys: &'a [u32],
        ties: Ties,
        words: &'a Superwords,
    ) -> DepthWalk<'a> {
        DepthWalk {
            function,
            keys,
            ties,
            words,
            done: vec![false; keys.len()],
            open: Vec::new(),
        }
    }

    /// Appends the values that a root depends on and that were not found
    /// before, and the root.
    fn reach(&mut self, root: Operand, found: &mut Vec<Value>) {
        let root = root.value().map(|value| self.words.leader(value));
        self.open.extend(root.map(|value| (value, false)));
        while let Some((value, entered)) = self.open.pop() {
            if entered {
                found.push(value);
                continue;
            }
            if std::mem::replace(&mut self.done[value.index()], true) {
                continue;
            }
            self.open.push((value, true));
            let first = self.open.len();
            let operands = self.words.reads(self.function, value);
            let values = operands.filter_map(|operand| operand.value());
            let values = values.map(|value| (self.words.leader(value), false));
            self.open.extend(values);
            // The last one is walked first.
            let below = &mut self.open[first..];
            if self.ties == Ties::LeftFirst {
                below.reverse();
            }
            below.sort_by_key(|(value, _)| self.keys[value.index()]);
        }
    }
}

/// Approximate number of registers for the expression of each value, without
/// sharing.
fn needs(function: &Function) -> Vec<u32> {
    let mut needs: Vec<u32> = Vec::with_capacity(function.nodes().len());
    for node in function.nodes() {
        let values = node.operands().iter().filter_map(|operand| operand.value());
        let mut own = [0; Operand::MAX_COUNT];
        for (need, value) in own.iter_mut().zip(values) {
            *need = needs[value.index()];
        }
        own.sort_unstable_by(|a, b| b.cmp(a));
        let held = (0u32..).zip(own).filter(|&(_, need)| need > 0);
        needs.push(held.fold(1, |most, (place, need)| most.max(place + need)));
    }
    needs
}
