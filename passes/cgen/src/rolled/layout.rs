//! The layout of all numbers: from resolved leaves to a program.
//!
//! Values that one part hands to another, or one pass to a later one, have a
//! word of the work array. The loops with the most reads decide first: the
//! independent loops, whose operands become contiguous so that compilers make
//! vectors of them; then the loops that compute values, which store them pass
//! by pass; then all others, which use the existing layout. Where an address is
//! affine except for a few passes, at the ends of a chain, the few values move;
//! where it is not affine, a table has the addresses.

mod places;

use super::demote::Outputs;
use super::fit::{exact, fit};
use super::nest::Nest;
use super::program::SpaceElement;
use super::resolve::{MemoryRead, Resolved};
use super::statements::{StatementTarget, Statements};
use hashbrown::{HashMap, HashSet};
use robovec_ir::{Function, Operand, Value};
use rustc_hash::FxBuildHasher;

type Map<K, V> = HashMap<K, V, FxBuildHasher>;

/// Free words around every array, for elements that are added later.
const MARGIN: u32 = 8;
/// Fewer than one in this number of results of a loop are few.
const FEW: usize = 2;
/// Most runs of copies that interleave.
const INTERLEAVED: usize = 3;
/// A word for values that are never read.
const JUNK: u32 = 0;

/// The layout of all numbers.
pub(super) struct RolledLayout<'a> {
    function: &'a Function,
    nest: &'a Nest,
    statements: &'a Statements,
    outputs: &'a Outputs,
    iterations: Vec<Vec<u32>>,
    /// For each value a flag: true when it is read from the work array.
    needed: Vec<bool>,
    /// For each value its word, once it has one.
    home: Vec<Option<u32>>,
    occupied: Vec<bool>,
    /// For each access the words that it reads instead of the values' own.
    moved: Vec<Map<Operand, u32>>,
    /// The copies, with the element of the program they are before.
    copied: Vec<(usize, Operand, u32)>,
    table_index: HashMap<Vec<u32>, usize, FxBuildHasher>,
    constant_index: HashMap<Vec<u64>, usize, FxBuildHasher>,
    pub(super) constants: Vec<f64>,
    pub(super) tables: Vec<Vec<u32>>,
    /// For each access the word that it reads.
    pub(super) places: Vec<SpaceElement>,
}

impl<'a> RolledLayout<'a> {
    /// Lays a program out.
    pub(super) fn new(
        function: &'a Function,
        nest: &'a Nest,
        statements: &'a Statements,
        outputs: &'a Outputs,
        resolved: &Resolved,
    ) -> RolledLayout<'a> {
        let values = function.nodes().len();
        let mut layout = RolledLayout {
            function,
            nest,
            statements,
            outputs,
            iterations: (0..nest.loops.len())
                .map(|number| nest.iterations(number))
                .collect(),
            needed: vec![false; values],
            home: vec![None; values],
            occupied: vec![true; 1],
            moved: vec![Map::default(); resolved.accesses.len()],
            copied: Vec::new(),
            table_index: HashMap::default(),
            constant_index: HashMap::default(),
            constants: Vec::new(),
            tables: Vec::new(),
            places: Vec::new(),
        };
        for access in &resolved.accesses {
            if layout.output_of(access).is_none() {
                for value in access.operands.iter().filter_map(|operand| operand.value()) {
                    layout.needed[value.index()] = true;
                }
            }
        }
        layout.circles(resolved);
        layout.contiguous(resolved);
        for position in 0..nest.positions.len() {
            layout.result(position);
        }
        layout.align(resolved);
        layout.loose(resolved);
        for (number, access) in resolved.accesses.iter().enumerate() {
            let place = layout.place(number, access);
            layout.places.push(place);
        }
        layout
    }

    /// Words of the work array.
    pub(super) fn work(&self) -> u32 {
        self.occupied.len() as u32
    }

    fn allocate(&mut self, length: usize, margin: u32) -> u32 {
        let start = self.occupied.len() as u32 + margin;
        // Vectors are loaded faster when they do not straddle lines.
        let start = if margin > 0 {
            start.next_multiple_of(8)
        } else {
            start
        };
        let end = start as usize + length + margin as usize;
        self.occupied.resize(end, false);
        start
    }

    fn settle(&mut self, value: Value, word: u32) {
        self.home[value.index()] = Some(word);
        self.occupied[word as usize] = true;
    }

    fn is_free(&self, word: i64) -> bool {
        usize::try_from(word).is_ok_and(|word| word < self.occupied.len() && !self.occupied[word])
    }

    fn word(&self, operand: Operand) -> Option<u32> {
        self.home[operand.value()?.index()]
    }

    /// True when an operand is known before an element of the program begins.
    fn is_known_before(&self, operand: Operand, top: usize) -> bool {
        operand.value().is_none_or(|value| {
            let (position, _) = self.nest.producer(value);
            self.nest.tops[position as usize] < top
        })
    }

    /// The operands of independent loops, in the order of their passes.
    fn contiguous(&mut self, resolved: &Resolved) {
        let mut order: Vec<usize> = (0..resolved.accesses.len())
            .filter(|&number| {
                let access = &resolved.accesses[number];
                access.operands.len() > 1
                    && access
                        .owner
                        .is_some_and(|owner| self.nest.loops[owner].independent)
                    && self.output_of(access).is_none()
            })
            .collect();
        order.sort_by_key(|&number| std::cmp::Reverse(resolved.accesses[number].operands.len()));
        let mut chains: Vec<usize> = Vec::new();
        for number in order {
            let access = &resolved.accesses[number];
            self.keep(access);
            if access
                .operands
                .iter()
                .any(|operand| operand.value().is_some())
                && !self.extend(number, access, true)
                && !self.share(number, access, &chains, resolved)
                && self.chain(number, access)
            {
                chains.push(number);
            }
        }
    }

    /// Uses the words of an access in their present places, if they lie on an
    /// affine function except for a few that can be moved. `contiguous`
    /// requires neighbours in neighbouring passes.
    fn extend(&mut self, number: usize, access: &MemoryRead, contiguous: bool) -> bool {
        let Some(owner) = access.owner else {
            return true;
        };
        let depth = self.nest.loops[owner].depth;
        let known: Vec<Option<i64>> = access
            .operands
            .iter()
            .map(|&operand| self.word(operand).map(i64::from))
            .collect();
        if known.iter().all(|word| word.is_none()) {
            return false;
        }
        let line = fit(depth, &self.iterations[owner], &known);
        if contiguous && line.factors[depth - 1].abs() > 1 {
            return false;
        }
        let mut moves: Map<Operand, u32> = Map::default();
        let mut taken: Map<u32, Operand> = Map::default();
        let mut copies = 0;
        for (pass, &operand) in access.operands.iter().enumerate() {
            let wanted = line.at(&self.iterations[owner][pass * depth..(pass + 1) * depth]);
            if known[pass] == Some(wanted) {
                continue;
            }
            let word = match u32::try_from(wanted) {
                Ok(word) if taken.get(&word) == Some(&operand) => continue,
                Ok(word) if self.is_free(wanted) && !taken.contains_key(&word) => word,
                _ => return false,
            };
            let settles = operand.value().is_some() && known[pass].is_none();
            if moves.insert(operand, word).is_some()
                || !(settles || self.is_known_before(operand, access.top))
            {
                return false;
            }
            taken.insert(word, operand);
            copies += usize::from(!settles);
        }
        if copies > 8.max(access.operands.len() / 8) {
            return false;
        }
        let mut moves: Vec<(Operand, u32)> = moves.into_iter().collect();
        moves.sort_unstable_by_key(|&(_, word)| word);
        self.apply(number, access, &moves);
        true
    }

    /// Reads the copy laid out for another access before the same element of
    /// the program, if that has all values in order.
    fn share(
        &mut self,
        number: usize,
        access: &MemoryRead,
        chains: &[usize],
        resolved: &Resolved,
    ) -> bool {
        let Some(owner) = access.owner else {
            return false;
        };
        let depth = self.nest.loops[owner].depth;
        for &other in chains {
            if resolved.accesses[other].top != access.top {
                continue;
            }
            let words = access.operands.iter().map(|operand| {
                let moved = self.moved[other].get(operand).copied();
                moved.or_else(|| self.word(*operand)).map(i64::from)
            });
            let words: Option<Vec<i64>> = words.collect();
            let line = words.and_then(|words| exact(depth, &self.iterations[owner], &words));
            if line.is_some_and(|line| line.factors[depth - 1].abs() <= 1) {
                self.moved[number] = self.moved[other].clone();
                return true;
            }
        }
        false
    }

    /// Gives words to the operands of an access: values that have one keep it,
    /// others are copied.
    fn apply(&mut self, number: usize, access: &MemoryRead, moves: &[(Operand, u32)]) {
        for &(operand, word) in moves {
            match operand.value() {
                Some(value) if self.home[value.index()].is_none() => self.settle(value, word),
                _ => {
                    self.occupied[word as usize] = true;
                    self.moved[number].insert(operand, word);
                    self.copied.push((access.top, operand, word));
                }
            }
        }
    }

    /// Lays the operands of an access out one after another, in the order in
    /// which all visits of its loop read them, if they agree on one.
    fn chain(&mut self, number: usize, access: &MemoryRead) -> bool {
        let Some(owner) = access.owner else {
            return false;
        };
        let place = &self.nest.loops[owner];
        let mut next: Map<Operand, Operand> = Map::default();
        let mut has_one_before: HashSet<Operand, FxBuildHasher> = HashSet::default();
        for pass in 1..access.operands.len() {
            if place.visits[pass] != place.visits[pass - 1] {
                continue;
            }
            let (before, after) = (access.operands[pass - 1], access.operands[pass]);
            match next.insert(before, after) {
                Some(other) if other != after => return false,
                Some(_) => {}
                None if has_one_before.insert(after) => {}
                None => return false,
            }
        }
        let mut seen: HashSet<Operand, FxBuildHasher> = HashSet::default();
        let distinct: Vec<Operand> = (access.operands.iter().copied())
            .filter(|&operand| seen.insert(operand))
            .collect();
        let is_copied =
            |operand: &&Operand| operand.value().is_none() || self.word(**operand).is_some();
        let mut copies = distinct.iter().filter(is_copied);
        let count = copies.clone().count();
        if count * 4 > access.operands.len()
            || !copies.all(|&operand| self.is_known_before(operand, access.top))
        {
            return false;
        }
        let mut chains: Vec<Vec<Operand>> = Vec::new();
        for &start in distinct
            .iter()
            .filter(|operand| !has_one_before.contains(*operand))
        {
            let mut chain = vec![start];
            let mut at = start;
            while let Some(&after) = next.get(&at) {
                chain.push(after);
                at = after;
            }
            chains.push(chain);
        }
        if chains.iter().map(Vec::len).sum::<usize>() != distinct.len() {
            return false;
        }
        let visits = place.starts.len() - 1;
        let longest = chains.iter().map(Vec::len).fold(0, usize::max);
        let pitch = (chains.len() == visits && visits > 1).then_some(longest);
        let length = pitch.map_or(distinct.len(), |pitch| pitch * chains.len());
        let mut word = self.allocate(length, MARGIN);
        for chain in chains {
            let moves: Vec<(Operand, u32)> = chain.iter().copied().zip(word..).collect();
            self.apply(number, access, &moves);
            word += pitch.unwrap_or(chain.len()) as u32;
        }
        true
    }

    /// The loop of sines and cosines reads its angles, and writes its
    /// results, one after the other.
    fn circles(&mut self, resolved: &Resolved) {
        let Some(circles) = self.nest.loops.iter().position(|place| place.circular) else {
            return;
        };
        for position in 0..self.nest.positions.len() {
            if self.nest.positions[position].owner == Some(circles) {
                for value in self.values(position) {
                    self.needed[value.index()] = true;
                }
                self.result(position);
            }
        }
        for (number, access) in resolved.accesses.iter().enumerate() {
            if access.owner != Some(circles) || !self.moved[number].is_empty() {
                continue;
            }
            let in_order = self.inputs(access).is_some_and(|(_, elements)| {
                elements
                    .windows(2)
                    .all(|pair| pair[0][0] == pair[1][0] && pair[0][1] + 1 == pair[1][1])
            });
            if !in_order {
                let start = self.allocate(access.operands.len(), MARGIN);
                let moves: Vec<_> = access.operands.iter().copied().zip(start..).collect();
                self.apply(number, access, &moves);
            }
        }
    }

    /// The results of a position in a loop.
    fn result(&mut self, number: usize) {
        let position = &self.nest.positions[number];
        let Some(owner) = position.owner else {
            return;
        };
        let values = self.values(number);
        if !values.iter().any(|value| self.needed[value.index()]) {
            return;
        }
        let place = &self.nest.loops[owner];
        let known: Vec<Option<i64>> = values
            .iter()
            .map(|&value| self.word(value.into()).map(i64::from))
            .collect();
        if known.iter().all(|word| word.is_none()) {
            let visits = place.starts.windows(2).map(|pair| pair[1] - pair[0]);
            let pitch = visits.max().expect("a loop has a visit");
            let start = self.allocate(pitch as usize * (place.starts.len() - 1), MARGIN);
            for (pass, &value) in values.iter().enumerate() {
                let word = start + place.visits[pass] * pitch + place.iteration(pass);
                self.settle(value, word);
            }
            return;
        }
        let depth = place.depth;
        let line = fit(depth, &self.iterations[owner], &known);
        for (pass, &value) in values.iter().enumerate() {
            let word = line.at(&self.iterations[owner][pass * depth..(pass + 1) * depth]);
            if known[pass].is_none() && self.needed[value.index()] && self.is_free(word) {
                self.settle(value, word as u32);
            }
        }
    }

    /// Keeps results together of which an access reads but a few: those are
    /// copied, instead of being stored apart from the rest.
    fn keep(&mut self, access: &MemoryRead) {
        let mut counts: Map<u32, usize> = Map::default();
        let mut seen: HashSet<Operand, FxBuildHasher> = HashSet::default();
        for value in access
            .operands
            .iter()
            .filter(|&&operand| seen.insert(operand))
        {
            if let Some(value) = value.value() {
                let (position, _) = self.nest.producer(value);
                *counts.entry(position).or_default() += 1;
            }
        }
        let mut few: Vec<usize> = counts
            .into_iter()
            .map(|(position, count)| (position as usize, count))
            .filter(|&(position, count)| {
                count * FEW < self.nest.positions[position].statements.len()
                    && self.nest.tops[position] < access.top
            })
            .map(|(position, _)| position)
            .collect();
        few.sort_unstable();
        for position in few {
            self.result(position);
        }
    }

    /// The values of a position, pass by pass; none for copies.
    fn values(&self, position: usize) -> Vec<Value> {
        let target = |&statement: &u32| match self.statements.list[statement as usize].target {
            StatementTarget::Value(value) => Some(value),
            StatementTarget::Output(_) => None,
        };
        let statements = &self.nest.positions[position].statements;
        statements.iter().filter_map(target).collect()
    }

    /// Places values outside of loops where loops expect them.
    fn align(&mut self, resolved: &Resolved) {
        for (number, access) in resolved.accesses.iter().enumerate() {
            if access.operands.len() > 1
                && self.moved[number].is_empty()
                && self.output_of(access).is_none()
                && access
                    .operands
                    .iter()
                    .any(|operand| operand.value().is_some())
            {
                self.extend(number, access, false);
            }
        }
    }

    /// Words for the values that have none yet. Words that only statements
    /// outside of loops read are freed after the last of them.
    fn loose(&mut self, resolved: &Resolved) {
        let mut last = vec![0usize; self.home.len()];
        for access in &resolved.accesses {
            let until = if access.owner.is_some() {
                usize::MAX
            } else {
                access.top
            };
            for value in access.operands.iter().filter_map(|operand| operand.value()) {
                last[value.index()] = last[value.index()].max(until);
            }
        }
        let mut ends: Vec<Vec<u32>> = vec![Vec::new(); self.nest.items.len() + 1];
        let mut free: Vec<u32> = Vec::new();
        assert_eq!(
            self.nest.tops.len(),
            self.nest.positions.len(),
            "every position lies below an item"
        );
        let mut by_top: Vec<(usize, usize)> = self.nest.tops.iter().copied().zip(0..).collect();
        by_top.sort_unstable();
        let mut now = 0;
        for (top, position) in by_top {
            while now < top {
                free.append(&mut ends[now]);
                now += 1;
            }
            let in_loop = self.nest.positions[position].owner.is_some();
            for value in self.values(position) {
                if !self.needed[value.index()] || self.home[value.index()].is_some() {
                    continue;
                }
                let until = last[value.index()];
                let returns = !in_loop && until != usize::MAX;
                let word = match free.pop() {
                    Some(word) if returns => word,
                    other => {
                        free.extend(other);
                        self.allocate(1, 0)
                    }
                };
                self.settle(value, word);
                if returns {
                    ends[until].push(word);
                }
            }
        }
    }
}
