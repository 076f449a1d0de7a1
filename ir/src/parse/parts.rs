//! Parts of a function while it is read: places, the statement being read with
//! its attributes, and the parts that are processed at the end of the function.

use crate::entity::{Operand, Output};
use crate::function::Timing;
use crate::history::History;
use crate::placement::{Address, BufferWord, Slot, Word};
use crate::source::SourceSet;
use crate::symbol::Name;
use hashbrown::HashMap;
use robovec_num::format::Format;
use rustc_hash::FxBuildHasher;
use std::ops::Range;

pub(super) type FastMap<Key, Content> = HashMap<Key, Content, FxBuildHasher>;

/// Bytes of the text.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub(super) struct Span {
    pub(super) start: u32,
    pub(super) end: u32,
}

impl Span {
    pub(super) fn new(start: u32, end: u32) -> Span {
        Span { start, end }
    }

    pub(super) fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// The indices of an element, or the extents of an array.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct Indices {
    /// The first two.
    pub(super) values: [u32; 2],
    /// Their number.
    pub(super) count: u32,
    /// Their place, brackets included.
    pub(super) span: Span,
}

impl Indices {
    pub(super) fn and(mut self, value: u32) -> Indices {
        if let Some(place) = self.values.get_mut(self.count as usize) {
            *place = value;
        }
        self.count = self.count.saturating_add(1);
        self
    }

    pub(super) fn at(self, span: Span) -> Indices {
        Indices { span, ..self }
    }

    /// The indices kept.
    pub(super) fn list(&self) -> &[u32] {
        &self.values[..(self.count as usize).min(2)]
    }
}

/// The statement being read.
#[derive(Clone, Copy, Default, Debug)]
pub(super) enum Head {
    /// Neither of the two.
    #[default]
    Other,
    /// `%x =`: the name and its place.
    Definition(Name, Span),
    /// `M[1,2] =`: the element, when it exists, and its place.
    Assignment(Option<Output>, Span),
}

/// An assignment, before they are sorted.
pub(super) struct PendingAssignment {
    pub(super) output: Output,
    pub(super) operand: Operand,
    pub(super) sources: SourceSet,
    pub(super) home: Option<Word>,
    pub(super) history: History,
    pub(super) span: Span,
    /// The nodes of its expression.
    pub(super) nodes: Range<u32>,
}

/// An initial word, before values have names.
pub(super) struct PendingPreload {
    pub(super) word: Word,
    pub(super) operand: Result<Operand, Span>,
    pub(super) span: Span,
}

/// The attributes of one statement, each with its place.
#[derive(Clone, Default)]
pub(super) struct Attributes {
    pub(super) sources: Option<(SourceSet, Span)>,
    pub(super) slot: Option<(Option<Slot>, Span)>,
    pub(super) reads: Option<([Option<Address>; Operand::MAX_COUNT], Span)>,
    pub(super) buffer: Option<(BufferWord, Span)>,
    pub(super) write: Option<Span>,
    pub(super) home: Option<(Word, Span)>,
    pub(super) timing: Option<(Timing, Span)>,
    pub(super) history: Option<(History, Span)>,
    pub(super) format: Option<(Format, Span)>,
    pub(super) entries: [Option<u32>; 5],
}

impl Attributes {
    pub(super) fn sources(&self) -> SourceSet {
        self.sources.map_or(SourceSet::EMPTY, |(set, _)| set)
    }
}

/// Uses beyond this number are not considered.
const MAX_USES: usize = 100_000;

/// Uses of names that no value bore when they were read.
#[derive(Default)]
pub(super) struct Undefined {
    /// The place of the name, and the number of nodes before its statement's
    /// root, at most.
    pub(super) uses: Vec<(Span, u32)>,
}

impl Undefined {
    pub(super) fn push(&mut self, span: Span, node: u32) {
        if self.uses.len() < MAX_USES {
            self.uses.push((span, node));
        }
    }
}
