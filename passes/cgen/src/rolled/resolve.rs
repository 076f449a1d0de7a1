//! The sources of the leaves of statements, before memory is laid out.
//!
//! A leaf that is in every pass the result of one position in that pass is
//! that position's variable. One that is the result of the pass before is a
//! carried variable. One that never changes is read once. All others are read
//! from memory, and their values need a home there.

use super::nest::{BodyElement, Nest};
use super::statements::Statements;
use hashbrown::HashMap;
use robovec_ir::{Operand, OperandKind};
use rustc_hash::FxBuildHasher;

/// The resolution of a leaf.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Resolution {
    /// The result of a position in the same pass.
    Position(usize),
    /// A carried variable.
    Carried(usize),
    /// A constant that never changes.
    Constant(Operand),
    /// Read from memory.
    Access(usize),
}

#[derive(Clone, Debug)]
pub(super) struct MemoryRead {
    /// The loop it happens in.
    pub(super) owner: Option<usize>,
    /// The operands it reads, pass by pass; a single one when it never changes.
    pub(super) operands: Vec<Operand>,
    /// The element of the program it happens in.
    pub(super) top: usize,
    /// True for the source of a copy to an output.
    pub(super) copies: bool,
}

/// A carried variable.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carry {
    pub(super) owner: usize,
    pub(super) position: usize,
    pub(super) first: Resolution,
}

/// The resolutions of all leaves.
pub(super) struct Resolved {
    /// For each position its leaves.
    pub(super) leaves: Vec<Vec<Resolution>>,
    pub(super) accesses: Vec<MemoryRead>,
    pub(super) carried: Vec<Carry>,
}

/// Resolves all leaves. `parts` states for each element of the program which
/// part it belongs to: within one, results are variables.
pub(super) fn resolve(nest: &Nest, statements: &Statements, parts: &[u32]) -> Resolved {
    let mut resolver = Resolver {
        nest,
        parts,
        resolved: Resolved {
            leaves: Vec::with_capacity(nest.positions.len()),
            accesses: Vec::new(),
            carried: Vec::new(),
        },
        carried: HashMap::default(),
    };
    for (number, position) in nest.positions.iter().enumerate() {
        let lists: Vec<&[Operand]> = position
            .statements
            .iter()
            .map(|&statement| statements.leaves(statement))
            .collect();
        let width = lists.first().map_or(0, |list| list.len());
        let copies = position.statements.first().is_some_and(|&statement| {
            let target = statements.list[statement as usize].target;
            matches!(target, super::statements::StatementTarget::Output(_))
        });
        let leaves = (0..width)
            .map(|leaf| {
                let operands = lists.iter().map(|list| list[leaf]).collect();
                resolver.leaf(position.owner, operands, nest.tops[number], copies)
            })
            .collect();
        resolver.resolved.leaves.push(leaves);
    }
    resolver.resolved
}

struct Resolver<'a> {
    nest: &'a Nest,
    parts: &'a [u32],
    resolved: Resolved,
    carried: HashMap<(usize, usize, Vec<Operand>), usize, FxBuildHasher>,
}

impl Resolver<'_> {
    /// A leaf read in a loop, with its operand in every pass. The recursion is
    /// as deep as loops nest.
    fn leaf(
        &mut self,
        owner: Option<usize>,
        mut operands: Vec<Operand>,
        top: usize,
        copies: bool,
    ) -> Resolution {
        if let Some(position) = self.same_pass(owner, &operands, top) {
            return Resolution::Position(position);
        }
        let uniform = operands.windows(2).all(|pair| pair[0] == pair[1]);
        if uniform {
            operands.truncate(1);
            if let Some(&operand) = operands.first()
                && matches!(operand.kind(), OperandKind::Constant(_))
            {
                return Resolution::Constant(operand);
            }
        } else if let Some(carried) = self.carried(owner, &operands, top) {
            return Resolution::Carried(carried);
        }
        self.resolved.accesses.push(MemoryRead {
            owner,
            operands,
            top,
            copies,
        });
        Resolution::Access(self.resolved.accesses.len() - 1)
    }

    fn producer(&self, operand: Operand) -> Option<(usize, usize)> {
        let (position, pass) = self.nest.producers[operand.value()?.index()]?;
        Some((position as usize, pass as usize))
    }

    fn same_pass(&self, owner: Option<usize>, operands: &[Operand], top: usize) -> Option<usize> {
        let (position, _) = self.producer(*operands.first()?)?;
        let Some(target) = self.nest.positions[position].owner else {
            // A statement outside of loops, in the same part.
            let part = self.parts[self.nest.tops[position]];
            let here = owner.is_none() && part == self.parts[top];
            return here.then_some(position);
        };
        let owner = owner?;
        let is_same = |(pass, &operand): (usize, &Operand)| {
            let there = self.nest.enclosing(owner, pass, target);
            self.producer(operand).map(|(p, pass)| (p, Some(pass))) == Some((position, there))
                && there.is_some()
        };
        operands.iter().enumerate().all(is_same).then_some(position)
    }

    fn carried(&mut self, owner: Option<usize>, operands: &[Operand], top: usize) -> Option<usize> {
        let owner = owner?;
        let (position, _) = self.producer(*operands.last()?)?;
        let target = self.nest.positions[position].owner?;
        let place = &self.nest.loops[target];
        let mut first = vec![Operand::NONE; place.starts.len() - 1];
        for (pass, &operand) in operands.iter().enumerate() {
            let pass = self.nest.enclosing(owner, pass, target)?;
            if place.iteration(pass) == 0 {
                let first = &mut first[place.visits[pass] as usize];
                if *first != Operand::NONE && *first != operand {
                    return None;
                }
                *first = operand;
            } else if self.producer(operand) != Some((position, pass - 1)) {
                return None;
            }
        }
        // What is computed in the loop itself is not there when it begins.
        let is_inside = |operand: &Operand| {
            self.producer(*operand).is_some_and(|(position, _)| {
                let around = self.nest.around(self.nest.positions[position].owner);
                around.contains(&target)
            })
        };
        if first.contains(&Operand::NONE) || first.iter().any(is_inside) {
            return None;
        }
        let key = (target, position, first.clone());
        if let Some(&known) = self.carried.get(&key) {
            return Some(known);
        }
        let parent = place.parent;
        let first = self.leaf(parent, first, top, false);
        self.resolved.carried.push(Carry {
            owner: target,
            position,
            first,
        });
        let number = self.resolved.carried.len() - 1;
        self.carried.insert(key, number);
        Some(number)
    }
}

/// The part of every element of the program: a loop is its own part,
/// statements outside of loops share parts of bounded length.
pub(super) fn parts(nest: &Nest, statements: &Statements, longest: usize) -> Vec<u32> {
    let mut parts = Vec::with_capacity(nest.items.len());
    let (mut part, mut length, mut open) = (0u32, 0, false);
    for item in &nest.items {
        match item {
            BodyElement::Position(position) => {
                let cost = 1 + statements.operations(nest.positions[*position].statements[0]);
                if !open || length + cost > longest {
                    part += 1;
                    length = 0;
                    open = true;
                }
                length += cost;
            }
            BodyElement::Loop(_) => {
                part += 1;
                open = false;
            }
        }
        parts.push(part);
    }
    parts
}
