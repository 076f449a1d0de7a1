//! Programs and a replay for the tests of placement.

use robovec_ir::machine::MemoryStyle;
use robovec_ir::placement::{Bank, BufferWord, Element, Placement, Schedule, Word};
use robovec_ir::{
    Function, Level, Machine, Name, Node, Operand, Operation, Output, Shape, SourceSet, Symbol,
    Value,
};
use robovec_num::random::Random;
use std::collections::{BTreeMap, BTreeSet};

/// A function under construction.
pub(super) struct TestFunctionBuilder {
    pub(super) function: Function,
    inputs: u32,
}

impl TestFunctionBuilder {
    /// A function with this number of inputs and outputs.
    pub(super) fn new(inputs: u32, outputs: u32) -> TestFunctionBuilder {
        let mut function = Function::new("test", Level::Atomic);
        function.add_input(Symbol(0), Shape::Vector(inputs));
        function.add_output(Symbol(1), Shape::Vector(outputs));
        TestFunctionBuilder { function, inputs }
    }

    /// The input element with this number, from 0.
    pub(super) fn input(&self, number: u32) -> Operand {
        assert!(number < self.inputs);
        Operand::from(robovec_ir::Input(number))
    }

    /// Appends an operation.
    pub(super) fn push(&mut self, operation: Operation, left: Operand, right: Operand) -> Operand {
        let suffix = self.function.nodes().len() as u32;
        let value = self.function.push(Node {
            name: Name {
                base: Symbol(2),
                suffix,
            },
            sources: SourceSet::EMPTY,
            operands: Operand::list([left, right]),
            operation,
        });
        Operand::from(value)
    }

    /// Sets an output element, from 0.
    pub(super) fn output(&mut self, number: u32, operand: Operand) {
        self.function
            .assign(Output(number), operand, SourceSet::EMPTY);
    }
}

/// A random program: mostly near operands, some far, some initial; every
/// twentieth result is an output.
pub(super) fn random_function(operations: usize, near: usize, seed: u64) -> Function {
    let mut random = Random::new(seed);
    let inputs = 8;
    let mut builder = TestFunctionBuilder::new(inputs, operations as u32);
    let zero = Operand::from(builder.function.constant(0.0));
    let mut values: Vec<Operand> = (0..inputs).map(|input| builder.input(input)).collect();
    values.push(zero);
    values.push(builder.push(Operation::Sin, values[0], Operand::NONE));
    values.push(builder.push(Operation::Cos, values[1], Operand::NONE));
    for _ in 0..operations {
        let pick = |random: &mut Random| match random.below(10) {
            0..7 => values[values.len() - 1 - random.below(near.min(values.len()))],
            _ => values[random.below(values.len())],
        };
        let (left, right) = (pick(&mut random), pick(&mut random));
        let operation = match random.below(10) {
            0..2 => Operation::Add,
            2..4 => Operation::Sub,
            _ => Operation::Mul,
        };
        values.push(builder.push(operation, left, right));
    }
    let mut outputs = 0;
    for (index, &value) in values.iter().enumerate() {
        if index % 20 == 0 || index + 1 == values.len() {
            builder.output(outputs, value);
            outputs += 1;
        }
    }
    builder.function
}

/// The program with an addend for every second product: an earlier value, an
/// input, or one of the factors.
pub(super) fn with_fused(mut function: Function, seed: u64) -> Function {
    let mut random = Random::new(seed);
    for index in 0..function.nodes().len() {
        let node = function.node_mut(Value(index as u32));
        if node.operation != Operation::Mul || random.below(2) == 0 {
            continue;
        }
        let fused = [Operation::Fma, Operation::Fms, Operation::Fnma];
        node.operation = fused[random.below(3)];
        node.operands[2] = match random.below(6) {
            0 => node.operands[0],
            1 => Operand::from(robovec_ir::Input(random.below(8) as u32)),
            _ if index == 0 => node.operands[1],
            _ => Operand::from(Value((index - 1 - random.below(index.min(30))) as u32)),
        };
    }
    function
}

/// A random program with quotients and roots as well.
pub(super) fn random_function_with_roots(operations: usize, seed: u64) -> Function {
    let mut random = Random::new(seed);
    let mut builder = TestFunctionBuilder::new(3, 2);
    let mut values: Vec<Operand> = (0..3).map(|input| builder.input(input)).collect();
    for _ in 0..operations {
        let pick =
            |random: &mut Random| values[values.len() - 1 - random.below(values.len().min(25))];
        let (left, right) = (pick(&mut random), pick(&mut random));
        let operations = [
            Operation::Add,
            Operation::Sub,
            Operation::Mul,
            Operation::Mul,
            Operation::Div,
            Operation::Sqrt,
        ];
        let operation = operations[random.below(operations.len())];
        let right = if operation.arity() == 1 {
            Operand::NONE
        } else {
            right
        };
        values.push(builder.push(operation, left, right));
    }
    builder.output(0, values[values.len() - 1]);
    builder.output(1, values[values.len() / 2]);
    builder.function
}

/// A shipped machine with other numbers of elements.
pub(super) fn machine(name: &str, adders: u32, multipliers: u32) -> Machine {
    let mut machine = Machine::built_in(name).expect("it ships");
    machine.elements[0].count = adders;
    machine.elements[1].count = multipliers;
    machine
}

/// Replays a placed function cycle by cycle and refuses every breach of the
/// rules of the machine; the sentence shows which.
pub(super) fn replay(function: &Function, machine: &Machine) -> Result<(), String> {
    TestReplay::new(function, machine)?.run()
}

struct TestReplay<'a> {
    function: &'a Function,
    machine: &'a Machine,
    placement: &'a Placement,
    schedule: &'a Schedule,
    memory: BTreeMap<Word, Operand>,
    unread: BTreeSet<Word>,
    issues: BTreeMap<u32, Vec<usize>>,
    writes: BTreeMap<u32, Vec<(usize, Word)>>,
}

impl<'a> TestReplay<'a> {
    fn new(function: &'a Function, machine: &'a Machine) -> Result<TestReplay<'a>, String> {
        let schedule = function.schedule.as_ref().ok_or("no schedule")?;
        let placement = function.placement.as_ref().ok_or("no placement")?;
        let mut replay = TestReplay {
            function,
            machine,
            placement,
            schedule,
            memory: BTreeMap::new(),
            unread: BTreeSet::new(),
            issues: BTreeMap::new(),
            writes: BTreeMap::new(),
        };
        if schedule.lower_bound > schedule.cycles {
            return Err("below the bound".to_owned());
        }
        for preload in &placement.preloads {
            replay.check_word(preload.word)?;
            if replay
                .memory
                .insert(preload.word, preload.operand)
                .is_some()
            {
                return Err(format!("{:?} preloaded twice", preload.word));
            }
        }
        for (value, node) in function.values() {
            let Some(slot) = schedule.slots[value.index()] else {
                assert!(node.operation.is_trigonometric());
                continue;
            };
            let kind = machine.kind_of(node.operation).ok_or("no kind")?;
            if schedule.element_name(slot.element).0 != machine.elements[kind].kind {
                return Err(format!("{value:?} on a wrong element"));
            }
            replay
                .issues
                .entry(slot.cycle)
                .or_default()
                .push(value.index());
            for write in placement.writes_of(value) {
                replay.check_word(write.word)?;
                let at = replay.writes.entry(write.cycle).or_default();
                at.push((value.index(), write.word));
            }
        }
        Ok(replay)
    }

    fn check_word(&self, word: Word) -> Result<(), String> {
        let split = self.machine.memory.style == MemoryStyle::SideSplit;
        if split == (word.bank == Bank::Unified) {
            return Err(format!("{word:?} in a bank the machine lacks"));
        }
        match self.machine.memory.words {
            Some(words) if word.address.number() >= words => {
                Err(format!("{word:?} beyond the memory"))
            }
            _ => Ok(()),
        }
    }

    fn back(&self, node: usize) -> u32 {
        let operation = self.function.nodes()[node].operation;
        self.schedule.slot(Value(node as u32)).cycle + self.machine.weight(operation) - 1
    }

    fn run(mut self) -> Result<(), String> {
        self.check_buffers()?;
        let mut events: BTreeSet<u32> = self.issues.keys().copied().collect();
        events.extend(self.writes.keys().copied());
        let mut finish = 0;
        for cycle in events {
            let issues = self.issues.remove(&cycle).unwrap_or_default();
            let mut busy = BTreeSet::new();
            for node in issues {
                if !busy.insert(self.schedule.slot(Value(node as u32)).element) {
                    return Err(format!("two issues at {cycle} on one element"));
                }
                finish = finish.max(self.back(node) + 1);
                self.check_reads(node)?;
            }
            let writes = self.writes.remove(&cycle).unwrap_or_default();
            if !writes.is_empty() {
                finish = finish.max(cycle + 1);
            }
            self.write_all(cycle, &writes)?;
        }
        if finish != self.schedule.cycles {
            return Err(format!(
                "ends at {finish}, expected {}",
                self.schedule.cycles
            ));
        }
        for (assignment, home) in self.function.assignments.iter().zip(&self.placement.homes) {
            let computed = assignment
                .operand
                .value()
                .is_some_and(|value| !self.schedule.is_host(value));
            let right = match home {
                Some(word) => computed && self.memory.get(word) == Some(&assignment.operand),
                None => !computed,
            };
            if let Some(word) = home {
                self.unread.remove(word);
            }
            if !right {
                return Err(format!("{assignment:?} is not at home in {home:?}"));
            }
        }
        match self.unread.first() {
            Some(word) => Err(format!("{word:?} is never read")),
            None => Ok(()),
        }
    }

    fn check_reads(&mut self, node: usize) -> Result<(), String> {
        let operands = self.function.nodes()[node].operands();
        for (side, operand) in operands.iter().enumerate() {
            let bank = match (self.machine.memory.style, side) {
                (MemoryStyle::Unified | MemoryStyle::FourPort, _) => Bank::Unified,
                (MemoryStyle::SideSplit, 0) => Bank::Left,
                (MemoryStyle::SideSplit, _) => Bank::Right,
            };
            let word = Word {
                element: self.schedule.slot(Value(node as u32)).element,
                bank,
                address: self.placement.reads[node][side].ok_or("no address")?,
            };
            self.unread.remove(&word);
            if self.memory.get(&word) != Some(operand) {
                return Err(format!("{node} finds no {operand:?} in {word:?}"));
            }
        }
        Ok(())
    }

    fn write_all(&mut self, cycle: u32, writes: &[(usize, Word)]) -> Result<(), String> {
        let mut per_memory: BTreeMap<(Element, Bank), u32> = BTreeMap::new();
        let mut from_buffer: BTreeMap<Element, BTreeSet<usize>> = BTreeMap::new();
        let mut written = BTreeSet::new();
        for &(node, word) in writes {
            *per_memory.entry((word.element, word.bank)).or_default() += 1;
            if !written.insert(word) {
                return Err(format!("{word:?} written twice at {cycle}"));
            }
            if cycle < self.back(node) {
                return Err(format!("{node} written before it is there"));
            }
            if cycle > self.back(node) {
                let element = self.schedule.slot(Value(node as u32)).element;
                from_buffer.entry(element).or_default().insert(node);
            }
            let value = robovec_ir::Value(node as u32);
            self.memory.insert(word, Operand::from(value));
            if !self.unread.insert(word) {
                return Err(format!("{word:?} overwritten at {cycle} before it is read"));
            }
        }
        let limit = self.machine.memory.write_limit();
        if let Some((memory, count)) = per_memory.iter().find(|(_, count)| **count > limit) {
            return Err(format!("{count} writes at {cycle} into {memory:?}"));
        }
        let limit = match self.machine.buffer {
            None => 0,
            Some(buffer) => buffer.read_limit() as usize,
        };
        match from_buffer.iter().find(|(_, nodes)| nodes.len() > limit) {
            Some((element, _)) => Err(format!("buffer of {element} read too often at {cycle}")),
            None => Ok(()),
        }
    }

    fn check_buffers(&self) -> Result<(), String> {
        let mut stays: BTreeMap<(Element, BufferWord), Vec<(u32, u32)>> = BTreeMap::new();
        for (node, &word) in self.placement.buffers.iter().enumerate() {
            let value = Value(node as u32);
            if self.schedule.is_host(value) {
                continue;
            }
            let last = self
                .placement
                .writes_of(value)
                .iter()
                .map(|write| write.cycle);
            let last = last.max().filter(|&last| last > self.back(node));
            match (word, last) {
                (None, None) => {}
                (None, Some(_)) | (Some(_), None) => {
                    return Err(format!("{node} in buffer {word:?} until {last:?}"));
                }
                (Some(word), Some(last)) => {
                    let limit = self.machine.buffer.and_then(|buffer| buffer.words);
                    if limit.is_some_and(|limit| word.number() >= limit) {
                        return Err(format!("{node} beyond its buffer"));
                    }
                    let key = (self.schedule.slot(Value(node as u32)).element, word);
                    stays.entry(key).or_default().push((self.back(node), last));
                }
            }
        }
        for (key, stays) in &mut stays {
            stays.sort_unstable();
            if stays.windows(2).any(|pair| pair[1].0 <= pair[0].1) {
                return Err(format!("buffer word {key:?} overwritten"));
            }
        }
        Ok(())
    }
}
