//! The parts of a function that the levels `scheduled` and `placed` add.
//!
//! Cycle conventions, fixed here for the placer, the text form and the memory
//! images alike (facts of the pipeline, thesis 2.3 and Table 2.1): an operation
//! *issued* at cycle `t` on a processing element with `L` stages and a transfer
//! of 2 cycles has its result on the crossbar in cycle `t + L + 1` (its
//! *write-back* cycle) and can be read by an issue at `t + L + 2`, the weight
//! of the operation. A *direct* write happens in exactly the write-back cycle;
//! an *indirect* one goes through the element's buffer and happens in a later
//! cycle. A word written in cycle `w` can be read by an issue at `w + 1`. That
//! holds for a crossbar; over a network a write happens after the departure of
//! the word plus the cycles of its route ([`crate::machine::interconnect`]).

use crate::entity::{Operand, Value};
use crate::index_types;
use robovec_num::fnv::Fnv;

/// A group of equal processing elements, as scheduled.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ElementKind {
    /// The kind's name in the machine file (`add`, `multi`).
    pub name: String,
    /// Their number.
    pub count: u32,
}

index_types! {
    /// A processing element; counted over all kinds, kind after kind.
    pub struct Element;

    /// The address of a word in a memory of a processing element.
    pub struct Address;

    /// A word of a processing element's buffer.
    pub struct BufferWord;
}

/// Cycle and processing element of a node that the machine computes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Slot {
    /// The cycle of issue, from 0.
    pub cycle: u32,
    /// The element on which it is issued.
    pub element: Element,
}

/// Cycle and processing element of every node.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Schedule {
    /// Name of the machine.
    pub machine: String,
    /// Hash of the machine's content ([`crate::Machine::content_hash`]);
    /// absent in text that was written without it, which then represents the
    /// machine of the name.
    pub machine_hash: Option<Fnv>,
    /// The kinds of processing elements, with their counts.
    pub kinds: Vec<ElementKind>,
    /// One slot per node; `None` where the host evaluates the node before the
    /// run (sine and cosine of inputs), so that its value is initial data.
    pub slots: Vec<Option<Slot>>,
    /// Length: the first cycle in which every result can be read.
    pub cycles: u32,
    /// No schedule on this machine is shorter than this (proved).
    pub lower_bound: u32,
}

impl Schedule {
    /// True for a node the host evaluates.
    #[inline]
    pub fn is_host(&self, value: Value) -> bool {
        self.slots[value.index()].is_none()
    }

    /// The slot of a node that the machine computes.
    ///
    /// # Panics
    ///
    /// Panics when the host evaluates the node.
    #[inline]
    pub fn slot(&self, value: Value) -> Slot {
        self.slots[value.index()].expect("the machine computes the node")
    }

    /// The kind and the number within the kind, from 0, of an element.
    #[inline]
    pub fn element_name(&self, element: Element) -> (&str, u32) {
        let number = element.number();
        let mut first = 0;
        for kind in &self.kinds {
            if number < first + kind.count {
                return (&kind.name, number - first);
            }
            first += kind.count;
        }
        ("unknown", number)
    }

    /// The index of an element, the inverse of [`Schedule::element_name`].
    pub fn element(&self, kind: &str, number: u32) -> Option<Element> {
        let mut first = 0;
        for candidate in &self.kinds {
            if candidate.name == kind {
                return (number < candidate.count).then(|| Element::new(first + number));
            }
            first += candidate.count;
        }
        None
    }

    /// The number of processing elements of all kinds.
    pub fn element_count(&self) -> u32 {
        self.kinds.iter().map(|kind| kind.count).sum()
    }
}

/// The memory of a processing element that has an address.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Bank {
    /// The one memory of a true dual-port element.
    Unified,
    /// The memory of the left operand (side-split machines).
    Left,
    /// The memory of the right operand (side-split machines).
    Right,
}

/// A word of a processing element's memory.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Word {
    /// The processing element.
    pub element: Element,
    /// The memory of that element.
    pub bank: Bank,
    /// The address in that memory.
    pub address: Address,
}

/// A word filled before the run with an input, a constant or a value of the
/// host.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Preload {
    /// The word that is filled.
    pub word: Word,
    /// The operand that fills it.
    pub operand: Operand,
}

/// One write of a result into a memory.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Write {
    /// The word that is written.
    pub word: Word,
    /// The cycle at whose end it happens.
    pub cycle: u32,
}

/// Addresses and transfers of a scheduled function.
///
/// Every result has its list of writes; a write in the write-back cycle is
/// direct, a later one reads the buffer of the producing element.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct Placement {
    /// Initial data, in order of element, bank and address.
    pub preloads: Vec<Preload>,
    /// Read addresses of the operands, in the issuing element's memory (for
    /// a side-split element those of the left and right operand in its left
    /// and right memory); `None` where there is no operand. One entry per
    /// node.
    pub reads: Vec<[Option<Address>; Operand::MAX_COUNT]>,
    /// The buffer word of the producing element that holds the result from
    /// its write-back on, if it passes through the buffer. One entry per node.
    pub buffers: Vec<Option<BufferWord>>,
    /// For each node the range of its writes in [`Placement::writes`] is
    /// `write_starts[i]..write_starts[i + 1]`.
    pub write_starts: Vec<u32>,
    /// All writes, node after node, each node's in order of cycle and word.
    pub writes: Vec<Write>,
    /// For each assignment, in order, the word with its value at the end;
    /// `None` when it is an input, a constant or a value of the host.
    pub homes: Vec<Option<Word>>,
}

impl Placement {
    /// The writes of one node.
    #[inline]
    pub fn writes_of(&self, value: Value) -> &[Write] {
        let start = self.write_starts[value.index()] as usize;
        let end = self.write_starts[value.index() + 1] as usize;
        &self.writes[start..end]
    }
}
