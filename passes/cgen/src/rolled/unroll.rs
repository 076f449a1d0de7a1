//! Unrolling back: the proof that a rolled program is the function.
//!
//! The program is run with names instead of numbers: every word of memory has
//! the name of its value. A statement that applies its template to the words it
//! reads must be a statement of the function, whose value is then stored. At
//! the end every output must have the value that the function assigns to it. No
//! arithmetic is involved, so agreement is exact in every bit.

use super::nest::BodyElement;
use super::program::{Index, LeafSource, RolledProgram, SpaceElement, StorageSpace};
use super::statements::{StatementTarget, Statements};
use hashbrown::HashMap;
use robovec_ir::{Array, Constant, Function, Input, Operand, Output, Shape};
use rustc_hash::FxBuildHasher;

/// The reason why a rolled program is not the function it was made from.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum RolledDifference {
    /// A statement computes a value that the function does not have.
    #[error(
        "statement {position} of the loops computes what the function does not, in pass {pass}"
    )]
    Foreign {
        /// The statement, counted from 0.
        position: usize,
        /// The number of times it had been run.
        pass: usize,
    },
    /// A word is read that was not written before, or does not exist.
    #[error("statement {position} of the loops reads what is not there")]
    Missing {
        /// The statement, counted from 0.
        position: usize,
    },
    /// A loop has no number of passes.
    #[error("loop {number} has no number of passes")]
    Passes {
        /// The loop, counted from 0.
        number: usize,
    },
    /// An output has a wrong value.
    #[error("output element {output} has another value after the loops")]
    Output {
        /// The element of the flattened outputs, counted from 0.
        output: u32,
    },
}

/// Runs the program with names and compares.
pub(super) fn unroll(
    program: &RolledProgram,
    function: &Function,
    statements: &Statements,
) -> Result<(), RolledDifference> {
    let mut machine = RolledInterpreter::new(program, function, statements);
    let mut copies = program.copies.iter().peekable();
    for (top, &item) in program.items.iter().enumerate() {
        while let Some((_, copy)) = copies.next_if(|(before, _)| *before == top) {
            for pass in 0..i64::from(copy.count) {
                let [row, column] = [0, 1].map(|axis| copy.from[axis] + pass * copy.step[axis]);
                let operand = machine.load(copy.space, row, column);
                let word = copy.to + pass * copy.advance;
                let stored =
                    operand.and_then(|operand| machine.store(StorageSpace::Work, 0, word, operand));
                stored.ok_or(RolledDifference::Missing { position: 0 })?;
            }
        }
        machine.element(item)?;
    }
    for assignment in &function.assignments {
        let expected = machine.canonical(assignment.operand);
        if machine.outputs[assignment.output.index()] != Some(expected) {
            return Err(RolledDifference::Output {
                output: assignment.output.0,
            });
        }
    }
    Ok(())
}

struct RolledInterpreter<'a> {
    program: &'a RolledProgram,
    function: &'a Function,
    /// For each value the first that is computed in the same way.
    first: Vec<Operand>,
    known: HashMap<(u32, Vec<Operand>), Operand, FxBuildHasher>,
    numbers: HashMap<u64, Operand, FxBuildHasher>,
    work: Vec<Option<Operand>>,
    outputs: Vec<Option<Operand>>,
    results: Vec<Option<Operand>>,
    carried: Vec<Option<Operand>>,
    iterations: Vec<i64>,
    passes: Vec<usize>,
    runs: Vec<usize>,
}

impl<'a> RolledInterpreter<'a> {
    fn new(
        program: &'a RolledProgram,
        function: &'a Function,
        statements: &Statements,
    ) -> RolledInterpreter<'a> {
        let numbers = function.constants().iter().zip(0..);
        let mut machine = RolledInterpreter {
            program,
            function,
            first: (0..function.nodes().len())
                .map(|value| robovec_ir::Value(value as u32).into())
                .collect(),
            known: HashMap::default(),
            numbers: numbers
                .map(|(number, index)| (number.to_bits(), Constant(index).into()))
                .collect(),
            work: vec![None; program.work as usize],
            outputs: vec![None; function.output_len()],
            results: vec![None; program.codes.len()],
            carried: vec![None; program.carried.len()],
            iterations: vec![0; program.loops.len()],
            passes: vec![0; program.loops.len()],
            runs: vec![0; program.codes.len()],
        };
        for (number, statement) in (0u32..).zip(&statements.list) {
            if let StatementTarget::Value(value) = statement.target {
                let leaves = statements.leaves(number).iter();
                let leaves = leaves.map(|&leaf| machine.canonical(leaf)).collect();
                let key = (statement.template, leaves);
                let first = *machine.known.entry(key).or_insert_with(|| value.into());
                machine.first[value.index()] = first;
            }
        }
        machine
    }

    fn canonical(&self, operand: Operand) -> Operand {
        operand
            .value()
            .map_or(operand, |value| self.first[value.index()])
    }

    fn element(&mut self, element: BodyElement) -> Result<(), RolledDifference> {
        let number = match element {
            BodyElement::Position(position) => return self.statement(position),
            BodyElement::Loop(number) => number,
        };
        let program = self.program;
        let place = &program.loops[number];
        for &carried in &program.carries[number] {
            let position = program.carried[carried].position;
            let first = self.source(&program.carried[carried].first);
            self.carried[carried] = Some(first.ok_or(RolledDifference::Missing { position })?);
        }
        let count = self.index(&place.count);
        let count = count.ok_or(RolledDifference::Passes { number })?;
        for iteration in 0..count {
            self.iterations[number] = iteration;
            // Loops nest a few deep, which bounds the recursion.
            for &inner in &place.body {
                self.element(inner)?;
            }
            for &carried in &program.carries[number] {
                self.carried[carried] = self.results[program.carried[carried].position];
            }
            self.passes[number] += 1;
        }
        Ok(())
    }

    fn statement(&mut self, position: usize) -> Result<(), RolledDifference> {
        let program = self.program;
        let code = &program.codes[position];
        let missing = RolledDifference::Missing { position };
        let leaves = code.sources.iter().map(|source| self.source(source));
        let leaves: Option<Vec<Operand>> = leaves.collect();
        let leaves = leaves.ok_or(missing.clone())?;
        let pass = self.runs[position];
        self.runs[position] += 1;
        let result = match program.templates[code.template as usize].operations() {
            0 => leaves[0],
            _ => *self
                .known
                .get(&(code.template, leaves))
                .ok_or(RolledDifference::Foreign { position, pass })?,
        };
        self.results[position] = Some(result);
        for store in &code.stores {
            let (row, column) = (self.index(&store.row), self.index(&store.column));
            let stored = match (row, column) {
                (Some(row), Some(column)) => self.store(store.space, row, column, result),
                _ => None,
            };
            stored.ok_or(missing.clone())?;
        }
        Ok(())
    }

    fn source(&self, source: &LeafSource) -> Option<Operand> {
        match source {
            LeafSource::Position(position) => self.results[*position],
            LeafSource::Carried(carried) => self.carried[*carried],
            LeafSource::Number(number) => self.numbers.get(&number.to_bits()).copied(),
            LeafSource::Place(SpaceElement { space, row, column }) => {
                self.load(*space, self.index(row)?, self.index(column)?)
            }
        }
    }

    fn index(&self, index: &Index) -> Option<i64> {
        let factors = index.factors.iter();
        let terms = factors.map(|&(number, factor)| factor * self.iterations[number]);
        let entry = match index.table {
            Some((table, number)) => {
                let entry = self.program.tables[table].get(self.passes[number])?;
                i64::from(*entry)
            }
            None => 0,
        };
        Some(index.base + terms.sum::<i64>() + entry)
    }

    fn load(&self, space: StorageSpace, row: i64, column: i64) -> Option<Operand> {
        match space {
            StorageSpace::Work => *self.work.get(usize::try_from(column).ok()?)?,
            StorageSpace::Constants => {
                let number = self.program.constants.get(usize::try_from(column).ok()?)?;
                self.numbers.get(&number.to_bits()).copied()
            }
            StorageSpace::Input(array) => {
                let offset = flattened(&self.function.inputs()[array], row, column)?;
                Some(Input(offset).into())
            }
            StorageSpace::Output(array) => {
                let offset = flattened(&self.function.outputs()[array], row, column)?;
                self.outputs[Output(offset).index()]
            }
        }
    }

    fn store(
        &mut self,
        space: StorageSpace,
        row: i64,
        column: i64,
        operand: Operand,
    ) -> Option<()> {
        let word = match space {
            StorageSpace::Work => self.work.get_mut(usize::try_from(column).ok()?)?,
            StorageSpace::Output(array) => {
                let offset = flattened(&self.function.outputs()[array], row, column)?;
                &mut self.outputs[offset as usize]
            }
            StorageSpace::Input(_) | StorageSpace::Constants => return None,
        };
        *word = Some(operand);
        Some(())
    }
}

fn flattened(array: &Array, row: i64, column: i64) -> Option<u32> {
    let (row, column) = (u32::try_from(row).ok()?, u32::try_from(column).ok()?);
    let offset = match array.shape {
        Shape::Scalar => array.shape.offset(&[]),
        Shape::Vector(_) => array.shape.offset(&[column]),
        Shape::Matrix(..) => array.shape.offset(&[row, column]),
    }?;
    Some(array.offset + offset)
}
