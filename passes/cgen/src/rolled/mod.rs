//! Rolled C: loops found in straight-line programs.
//!
//! A multibody program is an unrolled recursion. Straight-line code for 130
//! joints has 10^5 operations and more, and the time to fetch them exceeds the
//! time to execute them. The recursion is found again in the order of the
//! program ([`repeat`]), its loops are put together ([`nest`]), leaves become
//! variables, carried variables or elements of arrays (`resolve`), and arrays
//! are laid out so that loops read and write them in order ([`layout`]).
//! Statements that do not repeat are unchanged.
//!
//! No operation is reordered or changed, so results equal those of the
//! straight-line program bit for bit. The layout is also verified: every
//! program is unrolled again with names instead of numbers, and compared with
//! the function ([`unroll`]), before a line of C is written.

mod demote;
mod fit;
mod layout;
mod nest;
mod program;
mod repeat;
mod resolve;
mod statements;
#[cfg(test)]
mod tests;
mod text;
mod unroll;

pub use unroll::RolledDifference;

use super::emit::Real;
use demote::Outputs;
use layout::RolledLayout;
use nest::{BodyElement, Nest};
use program::{Carried, Code, LeafSource, RolledLoop, RolledProgram};
use repeat::repeats;
use resolve::{Resolution, parts, resolve};
use robovec_framework::option_words;
use robovec_ir::{Function, Operand, View};
use statements::Statements;

/// Operations of a part of straight-line code, as a bound for compilers.
const PART: usize = 500;

option_words! {
    /// The method by which sines and cosines are computed.
    #[derive(Default)]
    pub enum RolledCircular {
        /// Those of inputs together, by the kernel of
        /// [`sincos`](super::sincos): within 1 ulp.
        #[default]
        Vector = "vector",
        /// One by one, by the library.
        Library = "library",
    }
}

/// The options of rolled C code.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Options {
    /// The type it computes in.
    pub real: Real,
    /// Its sines and cosines.
    pub circular: RolledCircular,
}

impl From<Real> for Options {
    fn from(real: Real) -> Options {
        Options {
            real,
            ..Options::default()
        }
    }
}

/// The extent to which a function became loops.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct RolledSummary {
    /// Operations of the function.
    pub operations: usize,
    /// Operations of it that loops carry out.
    pub rolled: usize,
    /// Operations that are in the code, each once.
    pub written: usize,
    /// Loops in the code.
    pub loops: usize,
    /// Of these the loops whose passes do not depend on each other.
    pub independent: usize,
    /// Tables of addresses, and their entries.
    pub tables: usize,
    /// Entries of all tables.
    pub entries: usize,
    /// Words of the work array.
    pub work: usize,
}

impl RolledSummary {
    /// The counts with their names in reports.
    pub fn statistics(&self) -> [(&'static str, u64); 8] {
        [
            ("operations", self.operations as u64),
            ("rolled", self.rolled as u64),
            ("written", self.written as u64),
            ("loops", self.loops as u64),
            ("independent loops", self.independent as u64),
            ("tables", self.tables as u64),
            ("table entries", self.entries as u64),
            ("words", self.work as u64),
        ]
    }
}

/// Rolled C code.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Rolled {
    /// The source and then the header: file name and text.
    pub files: [(String, String); 2],
    /// The extent to which it was rolled.
    pub summary: RolledSummary,
}

/// The C source of a function with its recursions as loops, and the header
/// that declares it. Takes a function of any level; schedules and placements
/// play no part. The signature is that of [`c_files`](super::c::c_files), and
/// so are the results, bit for bit where sines and cosines are; but arrays
/// must not overlap.
///
/// # Errors
///
/// Fails when the loops, unrolled again, are not the function: a mistake of
/// ours, and no code is written.
pub fn rolled_files(
    view: View<'_>,
    options: impl Into<Options>,
) -> Result<Rolled, RolledDifference> {
    let (program, summary) = roll(view.function)?;
    let files = text::files(view, options.into(), &program);
    Ok(Rolled { files, summary })
}

/// The extent to which a function can be rolled.
///
/// # Errors
///
/// As [`rolled_files`].
pub fn summary(function: &Function) -> Result<RolledSummary, RolledDifference> {
    roll(function).map(|(_, summary)| summary)
}

/// The rolled program of a function, proved equal to it.
fn roll(function: &Function) -> Result<(RolledProgram, RolledSummary), RolledDifference> {
    let mut statements = Statements::new(function);
    let found = repeats(function, &statements);
    let mut nest = Nest::new(function, &statements, &found);
    let outputs = Outputs::new(function, &mut statements, &mut nest);
    let program = assemble(function, &statements, &nest, &outputs);
    unroll::unroll(&program, function, &statements)?;
    let summary = summarise(&statements, &nest, &program);
    Ok((program, summary))
}

fn assemble(
    function: &Function,
    statements: &Statements,
    nest: &Nest,
    outputs: &Outputs,
) -> RolledProgram {
    let parts = parts(nest, statements, PART);
    let resolved = resolve(nest, statements, &parts);
    let mut layout = RolledLayout::new(function, nest, statements, outputs, &resolved);
    let number = |operand: Operand| {
        let number = function.number(operand);
        number.expect("a leaf that is no result, input or output is a constant")
    };
    let source = |layout: &RolledLayout<'_>, resolution: Resolution| match resolution {
        Resolution::Position(position) => LeafSource::Position(position),
        Resolution::Carried(carried) => LeafSource::Carried(carried),
        Resolution::Constant(operand) => LeafSource::Number(number(operand)),
        Resolution::Access(access) => LeafSource::Place(layout.places[access].clone()),
    };
    let mut codes = Vec::with_capacity(nest.positions.len());
    for (number, position) in nest.positions.iter().enumerate() {
        let leaves = resolved.leaves[number].iter();
        codes.push(Code {
            template: statements.list[position.statements[0] as usize].template,
            sources: leaves.map(|&leaf| source(&layout, leaf)).collect(),
            stores: layout.stores(number),
        });
    }
    let carried: Vec<Carried> = resolved
        .carried
        .iter()
        .map(|carry| Carried {
            owner: carry.owner,
            position: carry.position,
            first: source(&layout, carry.first),
        })
        .collect();
    let mut carries = vec![Vec::new(); nest.loops.len()];
    for (number, carry) in carried.iter().enumerate() {
        carries[carry.owner].push(number);
    }
    let loops = nest
        .loops
        .iter()
        .map(|place| {
            let counts = place.starts.windows(2);
            let counts: Vec<i64> = counts.map(|pair| i64::from(pair[1] - pair[0])).collect();
            RolledLoop {
                count: layout.index(place.parent, &counts),
                body: place.body.clone(),
                independent: place.independent,
                circular: place.circular,
                counted: false,
            }
        })
        .collect();
    let copies = layout.copies();
    let mut program = RolledProgram {
        templates: statements.templates.clone(),
        items: nest.items.clone(),
        parts,
        loops,
        codes,
        carried,
        carries,
        copies,
        work: layout.work(),
        constants: layout.constants,
        tables: layout.tables,
    };
    program.count();
    program
}

fn summarise(statements: &Statements, nest: &Nest, program: &RolledProgram) -> RolledSummary {
    let mut summary = RolledSummary {
        loops: nest.loops.len(),
        independent: nest.loops.iter().filter(|place| place.independent).count(),
        tables: program.tables.len(),
        entries: program.tables.iter().map(Vec::len).sum(),
        work: program.work as usize,
        ..RolledSummary::default()
    };
    for position in &nest.positions {
        let one = statements.operations(position.statements[0]);
        let all = one * position.statements.len();
        summary.operations += all;
        summary.written += one;
        if position.owner.is_some() {
            summary.rolled += all;
        }
    }
    summary
}

impl RolledProgram {
    /// Marks the loops whose passes tables count.
    fn count(&mut self) {
        let mut counted: Vec<usize> = Vec::new();
        self.each_index(|index| counted.extend(index.table.map(|(_, number)| number)));
        for number in counted {
            self.loops[number].counted = true;
        }
    }

    fn each_index(&self, mut call: impl FnMut(&program::Index)) {
        let places = self
            .codes
            .iter()
            .flat_map(|code| code.sources.iter())
            .chain(self.carried.iter().map(|carry| &carry.first))
            .filter_map(|source| match source {
                LeafSource::Place(place) => Some(place),
                _ => None,
            })
            .chain(self.codes.iter().flat_map(|code| code.stores.iter()));
        for place in places {
            call(&place.row);
            call(&place.column);
        }
        for place in &self.loops {
            call(&place.count);
        }
    }

    /// The elements of a body and all below, loops before their content.
    fn below(&self, element: BodyElement, list: &mut Vec<BodyElement>) {
        let mut open = vec![element];
        while let Some(element) = open.pop() {
            list.push(element);
            if let BodyElement::Loop(number) = element {
                open.extend(self.loops[number].body.iter().rev());
            }
        }
    }
}
