//! Uses of the arrays of a function, found before it is lowered.
//!
//! Lowering must know beforehand which arrays become inputs and outputs, and
//! which elements are read back or written again: an element written once and
//! never read back is an output, any other a named value.

use crate::explain::refusal;
use crate::storage::{Initial, Storage};
use crate::syntax::{LeafKind, StatementKind, SyntaxLeaf, SyntaxTree};
use crate::token::SourceSpan;
use robovec_ir::diagnostic::Diagnostic;
use std::ops::Range;

/// The element is written.
pub(super) const WRITTEN: u8 = 1;
/// It is written more than once.
pub(super) const REWRITTEN: u8 = 2;
/// It is read after it was written.
pub(super) const READ_BACK: u8 = 4;

/// The use of every element and array.
#[derive(Debug)]
pub(super) struct Scan {
    /// Per element: [`WRITTEN`] and its like.
    pub(super) flags: Vec<u8>,
    /// Per array: its first values are read.
    pub(super) read: Vec<bool>,
    /// Per array: an element is written.
    pub(super) written: Vec<bool>,
    /// Per array: it is an argument of a user function.
    pub(super) passed: Vec<bool>,
    pub(super) equations: usize,
    pub(super) nodes: usize,
    pub(super) errors: Vec<Diagnostic>,
}

struct Scanner<'a> {
    syntax: &'a SyntaxTree,
    storage: &'a Storage,
    scan: Scan,
    /// Per array: the result of a call that is still to come.
    awaited: Vec<bool>,
}

/// Scans the statements of a function; calls of a `part` may be in another.
pub(super) fn scan(
    syntax: &SyntaxTree,
    storage: &Storage,
    runs: &[Range<usize>],
    part: bool,
) -> Scan {
    debug_assert!(
        runs.is_sorted_by(|one, next| one.end <= next.start),
        "runs are in the order of the file"
    );
    let arrays = storage.arrays.len();
    let mut scanner = Scanner {
        syntax,
        storage,
        scan: Scan {
            flags: vec![0; storage.len],
            read: vec![false; arrays],
            written: vec![false; arrays],
            passed: vec![false; arrays],
            equations: 0,
            nodes: 0,
            errors: Vec::new(),
        },
        awaited: vec![false; arrays],
    };
    if !part && !syntax.calls.is_empty() {
        scanner.await_results(runs);
    }
    for index in runs.iter().cloned().flatten() {
        let statement = syntax.statements[index];
        match statement.kind {
            StatementKind::Equation {
                target,
                root,
                first,
                end,
            } => {
                scanner.scan.equations += 1;
                scanner.scan.nodes += (end - first) as usize;
                for node in &syntax.nodes[first as usize..end as usize] {
                    for &leaf in node.operands() {
                        scanner.read(leaf, statement.span);
                    }
                }
                scanner.read(root, statement.span);
                scanner.write(target, statement.span);
            }
            StatementKind::Call(call) => scanner.call(call, statement.span),
            _ => {}
        }
    }
    scanner.scan
}

impl Scanner<'_> {
    fn await_results(&mut self, runs: &[Range<usize>]) {
        for index in runs.iter().cloned().flatten() {
            if let StatementKind::Call(call) = self.syntax.statements[index].kind
                && let Some(LeafKind::Scalar(name)) = self.syntax.calls[call as usize]
                    .target
                    .map(SyntaxLeaf::kind)
                && let Some(array) = self.storage.find(name)
            {
                self.awaited[array as usize] = true;
            }
        }
    }

    #[inline]
    fn read(&mut self, leaf: SyntaxLeaf, span: SourceSpan) {
        // Nearly all that is read is no element.
        if let LeafKind::Element(element) = leaf.kind() {
            self.read_element(element, span);
        }
    }

    fn read_element(&mut self, element: u32, span: SourceSpan) {
        let element = self.syntax.elements[element as usize];
        let flags = &mut self.scan.flags[element.row as usize];
        if *flags & WRITTEN != 0 {
            *flags |= READ_BACK;
            return;
        }
        let array = element.column as usize;
        if self.awaited[array] {
            self.awaited[array] = false;
            self.scan.errors.push(refusal(
                "the result of a user function is read before the call",
                span,
                "read here",
                "move the call before this equation",
            ));
        }
        let stored = &self.storage.arrays[array];
        match stored.initial {
            Initial::Input(_) => {
                if !stored.known && !self.scan.read[array] {
                    self.scan.errors.push(refusal(
                        "an element of an array is read that nothing gives a number",
                        span,
                        "read here",
                        "declare the array a parameter, take it from the structure `s`, or assign to its elements first",
                    ));
                }
                self.scan.read[array] = true;
            }
            Initial::Zero => {
                let (indices, rank) = stored.shape.indices(element.row - stored.offset);
                let column = if rank == 2 { indices[1] } else { 1 };
                if indices[0] > stored.held.0 || column > stored.held.1 {
                    self.scan.errors.push(refusal(
                        "an element outside the zeros of its array is read",
                        span,
                        "read here",
                        "make the array of zeros large enough, or correct the index",
                    ));
                }
            }
            Initial::Nothing => self.scan.errors.push(refusal(
                "an element of a local array is read before it is written",
                span,
                "read here",
                "its value would be whatever the memory holds; write it first",
            )),
        }
    }

    fn write(&mut self, target: SyntaxLeaf, span: SourceSpan) {
        let LeafKind::Element(element) = target.kind() else {
            return;
        };
        let element = self.syntax.elements[element as usize];
        let flags = &mut self.scan.flags[element.row as usize];
        *flags |= if *flags & WRITTEN == 0 {
            WRITTEN
        } else {
            REWRITTEN
        };
        let array = element.column as usize;
        self.scan.written[array] = true;
        if self.scan.passed[array] {
            self.scan.errors.push(refusal(
                "an argument of a user function changes after the call",
                span,
                "written here",
                "the call would see the new value; write it before the call",
            ));
        }
    }

    fn call(&mut self, call: u32, span: SourceSpan) {
        let call = self.syntax.calls[call as usize];
        let (first, last) = call.arguments;
        for argument in &self.syntax.arguments[first as usize..last as usize] {
            if argument.leaf == SyntaxLeaf::NONE {
                continue;
            }
            match argument.leaf.kind() {
                LeafKind::Scalar(name) => {
                    if let Some(array) = self.storage.find(name) {
                        self.scan.passed[array as usize] = true;
                    }
                }
                LeafKind::Element(_) => self.read(argument.leaf, span),
                LeafKind::Node(_) | LeafKind::Number(_) => {}
            }
        }
        let Some(target) = call.target else { return };
        match target.kind() {
            LeafKind::Scalar(name) => {
                if let Some(array) = self.storage.find(name) {
                    self.awaited[array as usize] = false;
                }
            }
            LeafKind::Element(_) => self.write(target, span),
            LeafKind::Node(_) | LeafKind::Number(_) => {}
        }
    }
}
