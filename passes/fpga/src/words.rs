//! The instruction words of one element, cycle after cycle.
//!
//! Issues, buffer writes, memory writes and buffer reads each come in order
//! of cycle; the words are their merge, made one at a time.

use super::layout::{ISSUE, OPERATION, READ, WordLayout};
use super::manifest::InstructionField;
use super::traffic::{BufferRead, Traffic};
use robovec_ir::Value;
use robovec_ir::placement::{Bank, Element};
use std::iter::Peekable;

type PeekableGroups<'a, T> = Peekable<Box<dyn Iterator<Item = &'a [T]> + 'a>>;

/// An iterator over the words that are not zero.
pub(super) struct NonzeroWords<'a> {
    traffic: &'a Traffic<'a>,
    layout: &'a WordLayout,
    element: Element,
    issues: &'a [u32],
    /// The values that enter the buffer: a subsequence of the issues, since
    /// all results take equally long.
    buffered: &'a [u32],
    writes: PeekableGroups<'a, u32>,
    reads: PeekableGroups<'a, BufferRead>,
    limbs: Vec<u64>,
}

impl<'a> NonzeroWords<'a> {
    pub(super) fn new(
        traffic: &'a Traffic<'a>,
        element: Element,
        layout: &'a WordLayout,
    ) -> NonzeroWords<'a> {
        let issues = traffic.issues.of(element);
        let writes: Box<dyn Iterator<Item = &'a [u32]>> = Box::new(traffic.write_groups(element));
        let reads: Box<dyn Iterator<Item = &'a [BufferRead]>> =
            Box::new(traffic.buffer_groups(element));
        NonzeroWords {
            traffic,
            layout,
            element,
            issues,
            buffered: issues,
            writes: writes.peekable(),
            reads: reads.peekable(),
            limbs: vec![0; layout.width().div_ceil(64) as usize],
        }
    }

    /// The word last made.
    pub(super) fn word(&self) -> &[u64] {
        &self.limbs
    }

    /// Makes the next word that is not zero; its cycle.
    pub(super) fn advance(&mut self) -> Option<u32> {
        let traffic = self.traffic;
        while let Some((&first, rest)) = self.buffered.split_first()
            && traffic.placement.buffers[first as usize].is_none()
        {
            self.buffered = rest;
        }
        let issue = self.issues.first().map(|&value| self.issue_cycle(value));
        let buffered = self.buffered.first();
        // Traffic has checked that what is buffered is ready before the end.
        let ready = buffered.map(|&value| traffic.ready(value) as u32);
        let writes = &traffic.placement.writes;
        let write = self.writes.peek();
        let write = write.map(|group| writes[group[0] as usize].cycle);
        let read = self.reads.peek().map(|group| group[0].1);
        let cycle = [issue, ready, write, read].into_iter().flatten().min()?;
        self.limbs.fill(0);
        if issue == Some(cycle) {
            self.issue();
        }
        if ready == Some(cycle) {
            self.buffer_write();
        }
        self.memory_writes(cycle);
        if let Some(group) = self.reads.next_if(|group| group[0].1 == cycle) {
            for (port, &(_, _, word)) in (0u32..).zip(group) {
                self.set(self.layout.buffer_read(port), word.number());
            }
        }
        Some(cycle)
    }

    fn issue_cycle(&self, value: u32) -> u32 {
        self.traffic.schedule.slot(Value(value)).cycle
    }

    fn issue(&mut self) {
        let issued = self.issues.split_first();
        let (&value, rest) = issued.expect("a value is issued in this cycle");
        self.issues = rest;
        let traffic = self.traffic;
        let operation = traffic.view.function.node(Value(value)).operation;
        let mut codes = traffic.operations(self.element).iter();
        let code = codes.position(|name| name == operation.name());
        self.set(ISSUE, 1);
        let code = code.expect("traffic has checked that the element performs the operation");
        self.set(OPERATION, code as u32);
        let reads = traffic.placement.reads[value as usize];
        for (field, &address) in (READ..).zip(&reads[..operation.arity()]) {
            let address = address.expect("traffic has checked that every operand has one");
            self.set(field, address.number());
        }
    }

    fn buffer_write(&mut self) {
        let entering = self.buffered.split_first();
        let (&value, rest) = entering.expect("a value enters the buffer in this cycle");
        self.buffered = rest;
        let word = self.traffic.placement.buffers[value as usize];
        let field = self.layout.buffer_write();
        self.set(field, 1);
        let word = word.expect("only values with a word enter the buffer");
        self.set(field + 1, word.number());
    }

    /// All writes of a cycle, each through the next free port of its memory.
    fn memory_writes(&mut self, cycle: u32) {
        let traffic = self.traffic;
        let writes = &traffic.placement.writes;
        let now = |group: &&[u32]| writes[group[0] as usize].cycle == cycle;
        while let Some(group) = self.writes.next_if(now) {
            for (port, &index) in (0u32..).zip(group) {
                let word = writes[index as usize].word;
                let memory = u32::from(word.bank == Bank::Right);
                let field = self.layout.write(memory, port);
                let value = traffic.owners[index as usize];
                self.set(field, 1);
                self.set(field + 1, word.address.number());
                self.set(field + 2, traffic.select(value, cycle));
            }
        }
    }

    /// Sets a field, whose bits are zero before.
    fn set(&mut self, field: u32, content: u32) {
        let InstructionField { low, width, .. } = self.layout.fields()[field as usize];
        assert!(
            u64::from(content) >> width == 0,
            "the content of a field fits its bits"
        );
        if width == 0 {
            return;
        }
        let (limb, shift) = ((low / 64) as usize, low % 64);
        let content = u64::from(content);
        self.limbs[limb] |= content << shift;
        if shift + width > 64 {
            self.limbs[limb + 1] |= content >> (64 - shift);
        }
    }
}
