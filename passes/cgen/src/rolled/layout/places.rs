//! The addresses of accesses, once every value has its word: arrays, constants,
//! affine addresses and tables.

use super::super::fit::{AffineFit, exact, fit};
use super::super::program::{Copy, Index, SpaceElement, StorageSpace, coordinates};
use super::super::resolve::MemoryRead;
use super::super::statements::StatementTarget;
use super::{INTERLEAVED, JUNK, MARGIN, RolledLayout};
use robovec_ir::{Operand, OperandKind};

impl RolledLayout<'_> {
    /// The output array that contains all elements read by a copy.
    pub(super) fn output_of(&self, access: &MemoryRead) -> Option<usize> {
        if !access.copies {
            return None;
        }
        let mut arrays = access
            .operands
            .iter()
            .map(|operand| Some(self.outputs.element(operand.value()?)?.0));
        let first = arrays.next()??;
        arrays.all(|array| array == Some(first)).then_some(first)
    }

    pub(super) fn place(&mut self, number: usize, access: &MemoryRead) -> SpaceElement {
        if let Some(array) = self.output_of(access) {
            let element = |operand: &Operand| {
                let element = operand
                    .value()
                    .and_then(|value| self.outputs.element(value));
                element.expect("a copy of outputs reads outputs").1
            };
            let elements: Vec<[i64; 2]> = access.operands.iter().map(element).collect();
            return self.elements(StorageSpace::Output(array), access.owner, &elements);
        }
        if let Some((array, elements)) = self.inputs(access) {
            return self.elements(StorageSpace::Input(array), access.owner, &elements);
        }
        if let Some(numbers) = self.numbers(access) {
            let start = self.constants(&numbers) as i64;
            let words: Vec<i64> = (start..).take(numbers.len()).collect();
            return self.words(StorageSpace::Constants, access.owner, &words);
        }
        let words: Vec<i64> = access
            .operands
            .iter()
            .map(|&operand| {
                let word = match self.moved[number].get(&operand) {
                    Some(&word) => word,
                    None => match self.word(operand) {
                        Some(word) => word,
                        None => {
                            let word = self.allocate(1, 0);
                            self.apply(number, access, &[(operand, word)]);
                            word
                        }
                    },
                };
                i64::from(word)
            })
            .collect();
        self.words(StorageSpace::Work, access.owner, &words)
    }

    /// The input array that an access reads alone, and the elements.
    pub(super) fn inputs(&self, access: &MemoryRead) -> Option<(usize, Vec<[i64; 2]>)> {
        let elements = access.operands.iter().map(|operand| {
            let input = operand.input()?;
            let (array, indices, _) = self.function.input_element(input);
            Some((
                self.function.input_array(input),
                coordinates(array, indices),
            ))
        });
        let elements: Vec<(usize, [i64; 2])> = elements.collect::<Option<_>>()?;
        let array = elements.first()?.0;
        let same = elements.iter().all(|&(place, _)| place == array);
        same.then(|| (array, elements.into_iter().map(|(_, at)| at).collect()))
    }

    fn numbers(&self, access: &MemoryRead) -> Option<Vec<f64>> {
        let numbers = access.operands.iter();
        numbers
            .map(|&operand| self.function.number(operand))
            .collect()
    }

    /// The place of numbers in the table of constants.
    fn constants(&mut self, numbers: &[f64]) -> usize {
        let key = numbers.iter().map(|number| number.to_bits()).collect();
        let next = self.constants.len();
        let start = *self.constant_index.entry(key).or_insert(next);
        if start == next {
            self.constants.extend_from_slice(numbers);
        }
        start
    }

    fn words(&mut self, space: StorageSpace, owner: Option<usize>, words: &[i64]) -> SpaceElement {
        SpaceElement {
            space,
            row: Index::fixed(0),
            column: self.index(owner, words),
        }
    }

    fn elements(
        &mut self,
        space: StorageSpace,
        owner: Option<usize>,
        elements: &[[i64; 2]],
    ) -> SpaceElement {
        let rows: Vec<i64> = elements.iter().map(|element| element[0]).collect();
        let columns: Vec<i64> = elements.iter().map(|element| element[1]).collect();
        SpaceElement {
            space,
            row: self.index(owner, &rows),
            column: self.index(owner, &columns),
        }
    }

    /// An index with these values in the passes of a loop.
    pub(in super::super) fn index(&mut self, owner: Option<usize>, values: &[i64]) -> Index {
        let (Some(owner), true) = (owner, values.len() > 1) else {
            return Index::fixed(values.first().copied().unwrap_or(0));
        };
        let around = self.nest.around(Some(owner));
        let depth = around.len();
        if let Some(line) = exact(depth, &self.iterations[owner], values) {
            return affine(&around, &line);
        }
        let place = &self.nest.loops[owner];
        let known: Vec<Option<i64>> = values.iter().map(|&value| Some(value)).collect();
        let factor = fit(depth, &self.iterations[owner], &known).factors[depth - 1];
        let base = |pass: usize| values[pass] - factor * i64::from(place.iteration(pass));
        if let Some(parent) = place.parent
            && (0..values.len())
                .all(|pass| base(pass) == base(place.starts[place.visits[pass] as usize] as usize))
        {
            let starts = &place.starts[..place.starts.len() - 1];
            let bases: Vec<i64> = starts.iter().map(|&start| base(start as usize)).collect();
            let factors = if factor == 0 {
                Vec::new()
            } else {
                vec![(owner, factor)]
            };
            let (base, table) = self.table(&bases);
            return Index {
                base,
                factors,
                table: Some((table, parent)),
            };
        }
        let (base, table) = self.table(values);
        Index {
            base,
            factors: Vec::new(),
            table: Some((table, owner)),
        }
    }

    /// A table with these numbers, less their smallest.
    fn table(&mut self, values: &[i64]) -> (i64, usize) {
        let base = values.iter().copied().min();
        let base = base.expect("a table has entries");
        let entries: Vec<u32> = values.iter().map(|value| (value - base) as u32).collect();
        let next = self.tables.len();
        let number = *self.table_index.entry(entries.clone()).or_insert(next);
        if number == next {
            self.tables.push(entries);
        }
        (base, number)
    }

    /// The place where a position stores its results.
    pub(in super::super) fn stores(&mut self, position: usize) -> Vec<SpaceElement> {
        let owner = self.nest.positions[position].owner;
        let statements = &self.nest.positions[position].statements;
        let mut stores = Vec::new();
        let targets: Vec<StatementTarget> = statements
            .iter()
            .map(|&statement| self.statements.list[statement as usize].target)
            .collect();
        let elements: Option<Vec<(usize, [i64; 2])>> = targets
            .iter()
            .map(|target| match *target {
                StatementTarget::Value(value) => self.outputs.element(value),
                StatementTarget::Output(output) => {
                    Some(super::super::demote::element(self.function, output))
                }
            })
            .collect();
        if let Some(elements) = elements
            && let Some(&(array, _)) = elements.first()
        {
            let elements: Vec<[i64; 2]> = elements.into_iter().map(|(_, at)| at).collect();
            stores.push(self.elements(StorageSpace::Output(array), owner, &elements));
        }
        let values = self.values(position);
        let known: Vec<Option<i64>> = values
            .iter()
            .map(|&value| self.word(value.into()).map(i64::from))
            .collect();
        if known.iter().any(|word| word.is_some()) {
            let words = self.complete(owner, &known);
            stores.push(self.words(StorageSpace::Work, owner, &words));
        }
        stores
    }

    /// Words for all results of a position, where some of them are not read.
    fn complete(&mut self, owner: Option<usize>, known: &[Option<i64>]) -> Vec<i64> {
        let Some(owner) = owner else {
            return known.iter().copied().flatten().collect();
        };
        let depth = self.nest.loops[owner].depth;
        let line = fit(depth, &self.iterations[owner], known);
        let mut words = Vec::with_capacity(known.len());
        for (pass, word) in known.iter().enumerate() {
            let wanted = line.at(&self.iterations[owner][pass * depth..(pass + 1) * depth]);
            words.push(match word {
                Some(word) => *word,
                None if self.is_free(wanted) => {
                    self.occupied[wanted as usize] = true;
                    wanted
                }
                None => i64::from(JUNK),
            });
        }
        words
    }

    /// The copies, those that follow each other put together.
    pub(in super::super) fn copies(&mut self) -> Vec<(usize, Copy)> {
        let mut copied = std::mem::take(&mut self.copied);
        copied.sort_by_key(|&(top, _, word)| (top, word));
        let mut copies: Vec<(usize, Copy)> = Vec::new();
        for (top, operand, word) in copied {
            let (space, from) = self.origin(operand);
            let one = Copy {
                count: 1,
                space,
                from,
                step: [0, 0],
                to: i64::from(word),
                advance: 0,
            };
            // Two positions that take turns give two runs that interleave.
            let open = copies.len().saturating_sub(INTERLEAVED);
            let joined = copies[open..]
                .iter_mut()
                .rev()
                .any(|(last, run)| *last == top && joins(run, &one));
            if !joined {
                copies.push((top, one));
            }
        }
        copies
    }

    fn origin(&mut self, operand: Operand) -> (StorageSpace, [i64; 2]) {
        match operand.kind() {
            OperandKind::Input(input) => {
                let (array, indices, _) = self.function.input_element(input);
                let place = self.function.input_array(input);
                (StorageSpace::Input(place), coordinates(array, indices))
            }
            OperandKind::Value(value) => {
                let word = self.home[value.index()];
                let word = word.expect("a value that is read from the work array has a word");
                (StorageSpace::Work, [0, i64::from(word)])
            }
            OperandKind::Constant(constant) => {
                let number = self.function.constant_number(constant);
                (
                    StorageSpace::Constants,
                    [0, self.constants(&[number]) as i64],
                )
            }
            OperandKind::None => (StorageSpace::Work, [0, i64::from(JUNK)]),
        }
    }
}

/// Appends one copy to a run that continues with it.
fn joins(run: &mut Copy, one: &Copy) -> bool {
    let count = i64::from(run.count);
    if run.space != one.space {
        return false;
    }
    let step = [0, 1].map(|axis| one.from[axis] - run.from[axis]);
    let advance = one.to - run.to;
    if count == 1 {
        if step
            .iter()
            .chain([&advance])
            .any(|step| step.abs() > i64::from(MARGIN))
        {
            return false;
        }
        run.step = step;
        run.advance = advance;
    } else if advance != run.advance * count
        || (0..2).any(|axis| step[axis] != run.step[axis] * count)
    {
        return false;
    }
    run.count += 1;
    true
}

fn affine(around: &[usize], line: &AffineFit) -> Index {
    let factors = around.iter().copied().zip(line.factors.iter().copied());
    Index {
        base: line.base,
        factors: factors.filter(|&(_, factor)| factor != 0).collect(),
        table: None,
    }
}
