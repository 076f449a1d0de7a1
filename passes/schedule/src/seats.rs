//! The seats of operations that are not issued yet, and claims on words there
//! (see `ahead`).

use super::locations::{Entry, Memory};
use robovec_ir::placement::Element;

/// Elements of operations that are not issued yet.
#[derive(Clone, Debug)]
pub(super) struct Ahead {
    /// The seat that each node is bound to.
    bound: Vec<Option<Seat>>,
    /// Operations bound to each element and not issued yet.
    pub(super) load: Vec<u32>,
    /// For each entry, the operations that have a claim on it.
    claims: Vec<u32>,
    banks: usize,
}

/// An operation's element: its number, and a flag for exchanged operands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Seat {
    pub(super) element: Element,
    pub(super) swapped: bool,
}

impl Ahead {
    /// No seats reserved.
    pub(super) fn new(nodes: usize, elements: usize, banks: usize) -> Ahead {
        Ahead {
            bound: vec![None; nodes],
            load: vec![0; elements],
            claims: Vec::new(),
            banks,
        }
    }

    /// The seat a node is bound to.
    pub(super) fn seat(&self, node: usize) -> Option<Seat> {
        self.bound[node]
    }

    /// Binds a node, or unbinds it.
    pub(super) fn bind(&mut self, node: usize, seat: Option<Seat>) {
        if let Some(old) = self.seat(node) {
            self.load[old.element.index()] -= 1;
        }
        if let Some(new) = seat {
            self.load[new.element.index()] += 1;
        }
        self.bound[node] = seat;
    }

    /// The memory in which a node at a seat reads an operand.
    pub(super) fn memory(&self, seat: Seat, operand: usize) -> Memory {
        let side = match operand {
            2 => 2,
            _ => operand ^ usize::from(seat.swapped),
        };
        // Machines with a memory per side have no third operand.
        let memory = seat.element.index() * self.banks + side.min(self.banks - 1);
        Memory::new(memory as u32)
    }

    pub(super) fn claim(&mut self, entry: Entry, more: bool) -> u32 {
        let index = entry.index();
        if self.claims.len() <= index {
            self.claims.resize(index + 1, 0);
        }
        let claims = &mut self.claims[index];
        *claims = if more {
            *claims + 1
        } else {
            claims.saturating_sub(1)
        };
        *claims
    }
}
