//! An order of operations that keeps values in registers.
//!
//! Equations come in the order of a recursion: all bodies outwards, then all
//! inwards. Values made in the forward recursion are needed in the backward
//! one, and of a mass matrix of 23 joints 525 values are alive at once: with
//! eight states per value more than the nearest cache holds. The order is
//! made in two steps: a walk from the last outputs down to their operands, the
//! longer branch first, halves the number of live values. A second pass through
//! that order, with a model of the registers, prefers operations that are
//! ready, read registers, and end the lives of values there.

use super::{CodeStep, DepthWalk, Ties, follows_operands};
use crate::superword::Superwords;
use robovec_ir::{Function, Operand, OperandKind, Value};
use std::collections::BTreeSet;

/// Ready readers of one register that are considered; those that come first
/// in the walk.
const READERS: usize = 8;

/// Maximum number of readers of a result that are tested for readiness.
const FOLLOWERS: usize = 16;

/// The cost of a read of a value outside the registers, against the other
/// weights: found by measuring the mass matrices of trees of 23 joints.
const MISS: i64 = 40;
/// The worth of the end of a value's life.
const KILL: i64 = 30;
/// The worth of each operation that only waited for this one.
const ENABLE: i64 = 10;

/// All values that are marked in `computed`, each once and after its
/// operands, and all assignments, each right after its value. Operands that
/// are not marked are in memory from the start.
pub(crate) fn by_registers(
    function: &Function,
    computed: &[bool],
    registers: usize,
) -> Vec<CodeStep> {
    let walked = walk(function, computed);
    let values = RegisterSchedule::new(function, computed, &walked, registers).run();
    let mut setters: Vec<Vec<u32>> = vec![Vec::new(); function.nodes().len()];
    let mut steps = Vec::with_capacity(values.len() + function.assignments.len());
    for (index, assignment) in (0u32..).zip(&function.assignments) {
        match assignment.operand.value() {
            Some(value) if computed[value.index()] => setters[value.index()].push(index),
            _ => steps.push(CodeStep::Assign(index)),
        }
    }
    for value in values {
        steps.push(CodeStep::Define(value));
        steps.extend(setters[value.index()].iter().copied().map(CodeStep::Assign));
    }
    debug_assert!(
        follows_operands(function, computed, &steps, &Superwords::none()),
        "a value is computed once, before it is read"
    );
    steps
}

/// The values as a walk from the last outputs finds them, the operand with
/// the longest chain after it first.
fn walk(function: &Function, computed: &[bool]) -> Vec<Value> {
    let mut depths = vec![0u32; function.nodes().len()];
    for (value, node) in function.values() {
        let below = node.operands().iter().filter_map(|operand| operand.value());
        depths[value.index()] = below.fold(0, |most, v| most.max(depths[v.index()] + 1));
    }
    let none = Superwords::none();
    let mut walk = DepthWalk::new(function, &depths, Ties::RightFirst, &none);
    for (done, computed) in walk.done.iter_mut().zip(computed) {
        *done = !computed;
    }
    let mut walked = Vec::with_capacity(computed.len());
    let outputs = function.assignments.iter().rev();
    let outputs = outputs.map(|assignment| assignment.operand);
    let all = function.values().rev().map(|(value, _)| value.into());
    for root in outputs.chain(all) {
        walk.reach(root, &mut walked);
    }
    walked
}

/// List scheduling with a model of the registers.
struct RegisterSchedule<'a> {
    function: &'a Function,
    computed: &'a [bool],
    registers: usize,
    /// For each value that is walked its place in the walk.
    rank: Vec<u32>,
    walked: &'a [Value],
    /// For each value the number of operands still to be computed.
    waits: Vec<u32>,
    /// For each place (values, then inputs) the number of reads left.
    reads: Vec<u32>,
    /// For each value its readers.
    readers: Vec<Vec<u32>>,
    /// For each place the ready readers, by rank.
    ready_readers: Vec<BTreeSet<u32>>,
    /// The ready steps, by rank.
    ready: BTreeSet<u32>,
    /// Places in registers, with the time each was last touched.
    held: Vec<(usize, u32)>,
}

impl<'a> RegisterSchedule<'a> {
    fn new(
        function: &'a Function,
        computed: &'a [bool],
        walked: &'a [Value],
        registers: usize,
    ) -> RegisterSchedule<'a> {
        let count = function.nodes().len();
        let places = count + function.input_len();
        let mut schedule = RegisterSchedule {
            function,
            computed,
            registers: registers.max(1),
            rank: vec![0; count],
            walked,
            waits: vec![0; count],
            reads: vec![0; places],
            readers: vec![Vec::new(); count],
            ready_readers: vec![BTreeSet::new(); places],
            ready: BTreeSet::new(),
            held: Vec::new(),
        };
        for (rank, &value) in (0u32..).zip(walked) {
            schedule.rank[value.index()] = rank;
            for &operand in function.node(value).operands() {
                if let Some(place) = schedule.place(operand) {
                    schedule.reads[place] += 1;
                    if place < count && computed[place] {
                        schedule.waits[value.index()] += 1;
                        schedule.readers[place].push(value.0);
                    }
                }
            }
        }
        for &value in walked {
            if schedule.waits[value.index()] == 0 {
                schedule.becomes_ready(value);
            }
        }
        schedule
    }

    fn place(&self, operand: Operand) -> Option<usize> {
        match operand.kind() {
            OperandKind::Value(value) => Some(value.index()),
            OperandKind::Input(input) => Some(self.function.nodes().len() + input.index()),
            OperandKind::Constant(_) | OperandKind::None => None,
        }
    }

    fn becomes_ready(&mut self, value: Value) {
        let rank = self.rank[value.index()];
        self.ready.insert(rank);
        for &operand in self.function.node(value).operands() {
            if let Some(place) = self.place(operand) {
                self.ready_readers[place].insert(rank);
            }
        }
    }

    fn run(mut self) -> Vec<Value> {
        let mut values = Vec::with_capacity(self.walked.len());
        while let Some(&first) = self.ready.first() {
            let candidates = self.held.iter();
            let candidates =
                candidates.flat_map(|&(place, _)| self.ready_readers[place].iter().take(READERS));
            let costs = candidates
                .chain([&first])
                .map(|&rank| (self.cost(rank) + i64::from(rank - first), rank));
            let (_, best) = costs.min().expect("the first that is ready can be done");
            let value = self.walked[best as usize];
            values.push(value);
            self.take(value, best, values.len() as u32);
        }
        assert_eq!(
            values.len(),
            self.walked.len(),
            "every operation that is walked is done"
        );
        values
    }

    /// The cost of doing an operation next, beside keeping earlier ones
    /// waiting.
    fn cost(&self, rank: u32) -> i64 {
        let value = self.walked[rank as usize];
        let operands = self.function.node(value).operands();
        let mut cost = 0;
        for (index, &operand) in operands.iter().enumerate() {
            let Some(place) = self.place(operand) else {
                continue;
            };
            if operands[..index].contains(&operand) {
                continue;
            }
            if !self.held.iter().any(|&(held, _)| held == place) {
                cost += MISS;
            }
            let own = operands.iter().filter(|&&other| other == operand).count();
            if self.computed.get(place) == Some(&true) && self.reads[place] as usize == own {
                cost -= KILL;
            }
        }
        let followers = self.readers[value.index()].iter().take(FOLLOWERS);
        let freed = followers.filter(|&&reader| self.waits[reader as usize] == 1);
        cost - ENABLE * freed.take(2).count() as i64
    }

    /// Does an operation at a time.
    fn take(&mut self, value: Value, rank: u32, time: u32) {
        self.ready.remove(&rank);
        for &operand in self.function.node(value).operands() {
            if let Some(place) = self.place(operand) {
                self.ready_readers[place].remove(&rank);
                self.reads[place] -= 1;
                self.touch(place, time);
            }
        }
        self.touch(value.index(), time);
        while self.held.len() > self.registers {
            let oldest = (0..self.held.len()).min_by_key(|&index| self.held[index].1);
            let oldest = oldest.expect("more is held than there are registers");
            self.held.swap_remove(oldest);
        }
        let readers = std::mem::take(&mut self.readers[value.index()]);
        for reader in readers {
            self.waits[reader as usize] -= 1;
            if self.waits[reader as usize] == 0 {
                self.becomes_ready(Value(reader));
            }
        }
    }

    /// Records the time of the last read or write of a place; a value without
    /// further readers leaves its register.
    fn touch(&mut self, place: usize, time: u32) {
        self.held.retain(|&(held, _)| held != place);
        if self.reads[place] > 0 {
            self.held.push((place, time));
        }
    }
}
