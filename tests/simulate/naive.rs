//! Random functions, and a placement that is as simple as it can be: one
//! operation at a time, every word used once. It exercises every kind of
//! transfer without sharing an idea with the real placement.

use robovec_ir::machine::MemoryStyle;
use robovec_ir::placement::{
    Address, Bank, BufferWord, Element, ElementKind, Placement, Preload, Schedule, Slot, Word,
    Write,
};
use robovec_ir::{
    Assignment, Function, Input, Level, Machine, Module, Name, Node, Operand, Operation, Output,
    Shape, SourceSet, Value,
};
use robovec_num::random::Random;
use std::collections::BTreeMap;

/// A number between -2 and 2.
pub(crate) fn number(random: &mut Random) -> f64 {
    2.0 * random.signed()
}

/// An atomic function of some operations on 5 inputs, with sines and cosines
/// of two of them, and with outputs of every kind; with fused operations if
/// the machine has elements for them.
pub(crate) fn random_function(random: &mut Random, operations: usize, machine: &Machine) -> Module {
    let fused = machine.kind_of(Operation::Fma).is_some();
    let mut module = Module::new();
    let mut function = Function::new("random", Level::Atomic);
    let symbols = &mut module.tables.symbols;
    function.add_input(symbols.intern("q"), Shape::Vector(5));
    function.add_output(symbols.intern("out"), Shape::Vector(9));
    let (trigonometric, other) = (symbols.intern("C"), symbols.intern("x"));
    let mut known: Vec<Operand> = (0..5).map(|index| Input(index).into()).collect();
    for (count, operation) in [Operation::Sin, Operation::Cos].into_iter().enumerate() {
        let value = function.push(Node {
            name: Name {
                base: trigonometric,
                suffix: count as u32,
            },
            sources: SourceSet::EMPTY,
            operands: Operand::list([Input(count as u32 * 3).into()]),
            operation,
        });
        known.push(value.into());
    }
    known.push(function.constant(0.1).into());
    known.push(function.constant(-1.0).into());
    for count in 0..operations {
        let (operation, operands) = random_operation(random, fused, &known);
        let value = function.push(Node {
            name: Name {
                base: other,
                suffix: count as u32,
            },
            sources: SourceSet::EMPTY,
            operands,
            operation,
        });
        known.push(value.into());
    }
    let last = known.len() - 1;
    let outputs = [
        0,
        5,
        7,
        last,
        last - 1,
        last,
        9,
        last / 2,
        9 + operations / 3,
    ];
    function.assignments = (0u32..)
        .zip(outputs)
        .map(|(index, place)| Assignment {
            output: Output(index),
            operand: known[place.min(last)],
            sources: SourceSet::EMPTY,
        })
        .collect();
    module.functions.push(function);
    module
}

/// An operation of [`random_function`] on known operands: inputs, sines and
/// cosines, two constants, and earlier results.
fn random_operation(
    random: &mut Random,
    fused: bool,
    known: &[Operand],
) -> (Operation, [Operand; 3]) {
    let operation = [
        Operation::Add,
        Operation::Sub,
        Operation::Mul,
        Operation::Fma,
        Operation::Fms,
        Operation::Fnma,
    ][random.below(if fused { 6 } else { 3 })];
    let mut pick = || {
        let recent = random.below(3) > 0 && known.len() > 12;
        let from = if recent { known.len() - 12 } else { 0 };
        known[from + random.below(known.len() - from)]
    };
    // Factors below 1 keep long chains finite, so that bits say something.
    let operands = match operation {
        Operation::Add | Operation::Sub => Operand::list([pick(), pick()]),
        _ => {
            let (wide, addend) = (pick(), pick());
            let small = known[[7, 7, 5, 6][random.below(4)]];
            match operation {
                Operation::Mul => Operand::list([wide, small]),
                _ => [wide, small, addend],
            }
        }
    };
    (operation, operands)
}

/// Places a function of [`random_function`].
pub(crate) fn place(function: &mut Function, machine: &Machine, random: &mut Random) {
    let mut placer = Naive::new(function, machine);
    for index in 0..function.nodes().len() {
        placer.node(function, machine, Value(index as u32), random);
    }
    placer.finish(function, machine);
}

struct Naive {
    schedule: Schedule,
    reads: Vec<[Option<Address>; Operand::MAX_COUNT]>,
    buffers: Vec<Option<BufferWord>>,
    writes: Vec<Vec<Write>>,
    preloads: Vec<Preload>,
    /// Place of an operand in a memory.
    places: BTreeMap<(Element, Bank, Operand), u32>,
    /// The next free address of a memory.
    free: BTreeMap<(Element, Bank), u32>,
    issued: u32,
    step: u32,
}

impl Naive {
    fn new(function: &Function, machine: &Machine) -> Naive {
        let kinds = machine.elements.iter().map(|kind| ElementKind {
            name: kind.kind.clone(),
            count: kind.count,
        });
        let weights = machine.elements.iter().map(|kind| kind.weight());
        let count = function.nodes().len();
        Naive {
            schedule: Schedule {
                machine: machine.name.clone(),
                machine_hash: Some(machine.content_hash()),
                kinds: kinds.collect(),
                slots: Vec::new(),
                cycles: 0,
                lower_bound: 0,
            },
            reads: vec![[None; Operand::MAX_COUNT]; count],
            buffers: vec![None; count],
            writes: vec![Vec::new(); count],
            preloads: Vec::new(),
            places: BTreeMap::new(),
            free: BTreeMap::new(),
            issued: 0,
            step: weights.max().expect("a kind") + 4,
        }
    }

    fn node(&mut self, function: &Function, machine: &Machine, value: Value, random: &mut Random) {
        let node = *function.node(value);
        let Some(kind) = machine.kind_of(node.operation) else {
            self.schedule.slots.push(None);
            return;
        };
        let before: u32 = machine.elements[..kind].iter().map(|kind| kind.count).sum();
        let number = random.below(machine.elements[kind].count as usize) as u32;
        let element = Element::new(before + number);
        let cycle = self.issued * self.step;
        self.issued += 1;
        self.schedule.slots.push(Some(Slot { cycle, element }));
        let banks = match machine.memory.style {
            MemoryStyle::Unified | MemoryStyle::FourPort => [Bank::Unified; Operand::MAX_COUNT],
            MemoryStyle::SideSplit => [Bank::Left, Bank::Right, Bank::Left],
        };
        for (side, &operand) in node.operands().iter().enumerate() {
            let bank = banks[side];
            let word = self.bring(machine, operand, element, bank, random);
            self.reads[value.index()][side] = Some(word.address);
        }
    }

    /// The word of a memory that holds an operand, with its transfer.
    fn bring(
        &mut self,
        machine: &Machine,
        operand: Operand,
        element: Element,
        bank: Bank,
        random: &mut Random,
    ) -> Word {
        let free = self.free.entry((element, bank)).or_default();
        let address = *self
            .places
            .entry((element, bank, operand))
            .or_insert_with(|| {
                *free += 1;
                *free
            });
        let word = Word {
            element,
            bank,
            address: Address::new(address),
        };
        if address < *free || self.is_there(word) {
            return word;
        }
        match operand
            .value()
            .filter(|&value| !self.schedule.is_host(value))
        {
            None => self.preloads.push(Preload { word, operand }),
            Some(value) => {
                let slot = self.schedule.slot(value);
                let weight = weight_of(machine, slot.element);
                let delay = random.below(4) as u32;
                if delay > 0 {
                    self.buffers[value.index()] = Some(BufferWord::new(value.0 % 5));
                }
                let cycle = slot.cycle + weight - 1 + delay;
                self.writes[value.index()].push(Write { word, cycle });
            }
        }
        word
    }

    fn is_there(&self, word: Word) -> bool {
        self.preloads.iter().any(|load| load.word == word)
            || self.writes.iter().flatten().any(|write| write.word == word)
    }

    fn finish(mut self, function: &mut Function, machine: &Machine) {
        self.schedule.cycles = self.issued * self.step;
        let mut homes = Vec::new();
        for assignment in &function.assignments {
            let computed = assignment.operand.value();
            let home = computed.filter(|&value| !self.schedule.is_host(value));
            homes.push(home.map(|value| {
                let element = self.schedule.slot(value).element;
                let bank = match machine.memory.style {
                    MemoryStyle::Unified | MemoryStyle::FourPort => Bank::Unified,
                    MemoryStyle::SideSplit => Bank::Right,
                };
                self.bring(machine, value.into(), element, bank, &mut Random::new(1))
            }));
        }
        let mut placement = Placement {
            preloads: self.preloads,
            reads: self.reads,
            buffers: self.buffers,
            homes,
            write_starts: vec![0],
            writes: Vec::new(),
        };
        for mut writes in self.writes {
            writes.sort_by_key(|write| (write.cycle, write.word));
            placement.writes.extend(writes);
            placement.write_starts.push(placement.writes.len() as u32);
        }
        placement.preloads.sort_by_key(|load| load.word);
        function.level = Level::Placed;
        function.schedule = Some(self.schedule);
        function.placement = Some(placement);
    }
}

fn weight_of(machine: &Machine, element: Element) -> u32 {
    let mut first = 0;
    for kind in &machine.elements {
        first += kind.count;
        if element.number() < first {
            return kind.weight();
        }
    }
    panic!("no element {element}");
}
