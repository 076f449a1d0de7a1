//! Repetitions in the order of the program.
//!
//! A program that was unrolled from a recursion repeats itself in the order in
//! which it was written. Statements become letters, equal for equal templates;
//! a stretch in which every letter equals the one a period later becomes a
//! loop, which is a letter again, for any number of passes. Short periods are
//! tried first, so inner loops are found before outer ones. There is no
//! reordering: the loops, run pass by pass, *are* the program in its order.

use super::statements::{StatementTarget, Statements, TemplateStep};
use hashbrown::{HashMap, HashSet};
use robovec_ir::{Array, Function, Operand, OperandKind, Operation, Shape};
use rustc_hash::FxBuildHasher;

/// An element of the program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum ProgramItem {
    /// A statement.
    Statement(u32),
    /// Beginning of a row of an output among the copies: nothing to do, but
    /// rows of different length repeat only if they end somewhere.
    Row,
    /// A loop.
    Loop(u32),
}

#[derive(Clone, Debug)]
pub(super) struct LoopRun {
    /// Elements of one pass.
    pub(super) period: usize,
    /// The elements of all passes, one pass after another.
    pub(super) items: Vec<ProgramItem>,
}

/// The program with its repetitions.
pub(super) struct Repeats {
    pub(super) items: Vec<ProgramItem>,
    pub(super) runs: Vec<LoopRun>,
    /// True when the first element is the loop of sines and cosines.
    pub(super) circular: bool,
}

/// Minimum number of passes of a loop over few statements: shorter repetitions
/// are better written out, and are then part of an outer repetition.
const SHORT_PASSES: usize = 8;
/// Below this number of statements a body counts as short.
const SHORT_BODY: usize = 8;
/// Fewest passes of any other loop.
const PASSES: usize = 3;
/// Most elements of a body.
const LONGEST: usize = 2048;
/// Comparisons spent on a program, which bounds the periods of long ones.
const COMPARISONS: usize = 200_000_000;
/// The number of searches for loops in the remainder of the last search.
const ROUNDS: usize = 3;

type Letter = (ProgramItem, u32);

/// Finds the repetitions.
pub(super) fn repeats(function: &Function, statements: &Statements) -> Repeats {
    let mut finder = Finder {
        letters: HashMap::default(),
        bodies: HashMap::default(),
        sizes: Vec::new(),
        runs: Vec::new(),
    };
    let circles = circles(statements);
    let mut program = finder.letters(function, statements);
    let taken: HashSet<u32, FxBuildHasher> = circles.iter().copied().collect();
    if !circles.is_empty() {
        let is_left = |item: &ProgramItem| !matches!(item, ProgramItem::Statement(one) if taken.contains(one));
        program.retain(|(item, _)| is_left(item));
    }
    for _ in 0..ROUNDS {
        let before = program.len();
        let longest = (COMPARISONS / program.len().max(1)).clamp(64, LONGEST);
        for period in 1..=longest.min(program.len() / PASSES) {
            finder.roll(&mut program, period);
        }
        if program.len() == before {
            break;
        }
    }
    let mut items: Vec<ProgramItem> = program.into_iter().map(|(item, _)| item).collect();
    let circular = !circles.is_empty();
    if circular {
        items.insert(0, ProgramItem::Loop(finder.runs.len() as u32));
        finder.runs.push(LoopRun {
            period: 2,
            items: circles.into_iter().map(ProgramItem::Statement).collect(),
        });
    }
    Repeats {
        items,
        runs: finder.runs,
        circular,
    }
}

/// Fewest angles whose sines and cosines are worth a loop.
const ANGLES: usize = 4;

/// The statements that are the sine and the cosine of an input, in the order of
/// the inputs, the sine first. They depend on inputs only, so they may precede
/// all other statements, and one call computes them all.
fn circles(statements: &Statements) -> Vec<u32> {
    let mut found: Vec<(Operand, bool, u32)> = Vec::new();
    for (number, statement) in (0u32..).zip(&statements.list) {
        let steps = &statements.templates[statement.template as usize].steps;
        let cosine = match steps.as_slice() {
            [TemplateStep::Leaf, TemplateStep::Apply(Operation::Sin)] => false,
            [TemplateStep::Leaf, TemplateStep::Apply(Operation::Cos)] => true,
            _ => continue,
        };
        let angle = statements.leaves(number)[0];
        if angle.input().is_some() {
            found.push((angle, cosine, number));
        }
    }
    found.sort_unstable();
    found.dedup_by_key(|&mut (angle, cosine, _)| (angle, cosine));
    let pairs: Vec<u32> = found
        .windows(2)
        .filter(|pair| pair[0].0 == pair[1].0)
        .flat_map(|pair| [pair[0].2, pair[1].2])
        .collect();
    if pairs.len() < 2 * ANGLES {
        return Vec::new();
    }
    pairs
}

struct Finder {
    letters: HashMap<Vec<u32>, u32, FxBuildHasher>,
    bodies: HashMap<Vec<u32>, u32, FxBuildHasher>,
    /// For each letter its number of statements in one pass.
    sizes: Vec<usize>,
    runs: Vec<LoopRun>,
}

impl Finder {
    fn letters(&mut self, function: &Function, statements: &Statements) -> Vec<Letter> {
        let mut program = Vec::with_capacity(statements.list.len());
        let mut row = None;
        for (number, statement) in (0u32..).zip(&statements.list) {
            let mut key = vec![statement.template];
            if let StatementTarget::Output(output) = statement.target {
                let (array, indices, _) = function.output_element(output);
                let here = (array.offset, row_of(array, indices));
                if row.replace(here) != Some(here) {
                    let letter = self.letter(vec![u32::MAX], 0);
                    program.push((ProgramItem::Row, letter));
                }
                key.push(array.offset);
            }
            for operand in statements.leaves(number) {
                match operand.kind() {
                    OperandKind::Input(input) => {
                        let (array, indices, _) = function.input_element(input);
                        key.extend([0, array.offset, row_of(array, indices)]);
                    }
                    OperandKind::Value(_) => key.push(1),
                    OperandKind::Constant(_) | OperandKind::None => key.push(2),
                }
            }
            let letter = self.letter(key, 1);
            program.push((ProgramItem::Statement(number), letter));
        }
        program
    }

    fn letter(&mut self, key: Vec<u32>, size: usize) -> u32 {
        let next = self.sizes.len() as u32;
        let letter = *self.letters.entry(key).or_insert(next);
        if letter == next {
            self.sizes.push(size);
        }
        letter
    }

    /// Makes loops of all stretches with this period.
    fn roll(&mut self, program: &mut Vec<Letter>, period: usize) {
        let length = program.len();
        let mut rolled: Vec<Letter> = Vec::new();
        let mut copied = 0;
        let mut at = 0;
        while at + period < length {
            let mut end = at;
            while end + period < length && program[end].1 == program[end + period].1 {
                end += 1;
            }
            let passes = (end + period - at) / period;
            if end > at && self.accepts(&program[at..at + period], passes) {
                rolled.extend_from_slice(&program[copied..at]);
                let stop = at + passes * period;
                rolled.push(self.run(&program[at..stop], period));
                copied = stop;
                at = stop;
            } else {
                at = end + 1;
            }
        }
        if copied > 0 {
            rolled.extend_from_slice(&program[copied..]);
            *program = rolled;
        }
    }

    fn accepts(&self, body: &[Letter], passes: usize) -> bool {
        let size: usize = body
            .iter()
            .map(|&(_, letter)| self.sizes[letter as usize])
            .sum();
        let least = if size < SHORT_BODY {
            SHORT_PASSES
        } else {
            PASSES
        };
        size > 0 && passes >= least
    }

    fn run(&mut self, items: &[Letter], period: usize) -> Letter {
        let body: Vec<u32> = items[..period].iter().map(|&(_, letter)| letter).collect();
        let size = body
            .iter()
            .map(|&letter| self.sizes[letter as usize])
            .sum::<usize>();
        let next = self.sizes.len() as u32;
        let letter = *self.bodies.entry(body).or_insert(next);
        if letter == next {
            // A loop counts as many statements: a loop around it is no
            // short one.
            self.sizes.push(size.max(SHORT_BODY));
        }
        let number = self.runs.len() as u32;
        self.runs.push(LoopRun {
            period,
            items: items.iter().map(|&(item, _)| item).collect(),
        });
        (ProgramItem::Loop(number), letter)
    }
}

/// The row of an element of a matrix, 0 for other arrays.
fn row_of(array: &Array, indices: [u32; 2]) -> u32 {
    match array.shape {
        Shape::Matrix(..) => indices[0],
        Shape::Scalar | Shape::Vector(_) => 0,
    }
}
