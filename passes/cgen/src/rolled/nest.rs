//! Loops as written in the code.
//!
//! One loop of the code has a *visit* for every pass of the loop around it, and
//! passes in every visit; a *pass* is numbered over all visits. A *position* is
//! a statement of the code: it represents, pass by pass, a list of statements
//! of the program.
//!
//! Visit `k` of a loop belongs to pass `k` of the loop around it.

use super::repeat::{ProgramItem, Repeats};
use super::statements::{StatementTarget, Statements};
use robovec_ir::{Function, Value};

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum BodyElement {
    /// A statement of the code.
    Position(usize),
    /// A loop of the code.
    Loop(usize),
}

/// A statement of the code.
#[derive(Clone, Debug)]
pub(super) struct Position {
    /// The loop that contains it.
    pub(super) owner: Option<usize>,
    /// The statements it represents, one per pass.
    pub(super) statements: Vec<u32>,
}

/// A loop of the code.
#[derive(Clone, Debug)]
pub(super) struct NestLoop {
    /// The loop around it.
    pub(super) parent: Option<usize>,
    /// The number of loops it is in, itself included.
    pub(super) depth: usize,
    /// For each visit its first pass; one more at the end.
    pub(super) starts: Vec<u32>,
    /// For each pass its visit.
    pub(super) visits: Vec<u32>,
    /// The elements it repeats.
    pub(super) body: Vec<BodyElement>,
    /// True when no pass of a visit reads the result of another.
    pub(super) independent: bool,
    /// True for the loop of sines and cosines.
    pub(super) circular: bool,
}

impl NestLoop {
    /// The number of passes of all visits.
    pub(super) fn passes(&self) -> usize {
        self.visits.len()
    }

    /// The number of a pass within its visit.
    pub(super) fn iteration(&self, pass: usize) -> u32 {
        pass as u32 - self.starts[self.visits[pass] as usize]
    }
}

/// The code.
pub(super) struct Nest {
    pub(super) loops: Vec<NestLoop>,
    pub(super) positions: Vec<Position>,
    /// The program, element after element.
    pub(super) items: Vec<BodyElement>,
    /// For each value the position that computes it, if a statement does, and
    /// the pass.
    pub(super) producers: Vec<Option<(u32, u32)>>,
    /// For each position its element of the program.
    pub(super) tops: Vec<usize>,
}

impl Nest {
    /// Puts the runs of every loop together.
    pub(super) fn new(function: &Function, statements: &Statements, repeats: &Repeats) -> Nest {
        let mut nest = Nest {
            loops: Vec::new(),
            positions: Vec::new(),
            items: Vec::new(),
            producers: vec![None; function.nodes().len()],
            tops: Vec::new(),
        };
        for &item in &repeats.items {
            let top = nest.items.len();
            match item {
                ProgramItem::Statement(statement) => {
                    let position = nest.position(None, top, vec![statement]);
                    nest.items.push(position);
                }
                ProgramItem::Loop(run) => {
                    let number = nest.build(repeats, None, top, &[run]);
                    nest.items.push(BodyElement::Loop(number));
                }
                ProgramItem::Row => {}
            }
        }
        if repeats.circular
            && let Some(&BodyElement::Loop(first)) = nest.items.first()
        {
            nest.loops[first].circular = true;
        }
        nest.produce(statements);
        for number in 0..nest.loops.len() {
            nest.direct(function, statements, number);
        }
        nest.produce(statements);
        nest
    }

    fn position(&mut self, owner: Option<usize>, top: usize, statements: Vec<u32>) -> BodyElement {
        self.positions.push(Position { owner, statements });
        self.tops.push(top);
        BodyElement::Position(self.positions.len() - 1)
    }

    /// Appends a statement after everything.
    pub(super) fn append(&mut self, statement: u32) {
        let top = self.items.len();
        let position = self.position(None, top, vec![statement]);
        self.items.push(position);
    }

    /// Builds the loop that these runs are visits of. Loops nest a few deep,
    /// which bounds the recursion.
    fn build(
        &mut self,
        repeats: &Repeats,
        parent: Option<usize>,
        top: usize,
        runs: &[u32],
    ) -> usize {
        let number = self.loops.len();
        let depth = parent.map_or(0, |parent| self.loops[parent].depth) + 1;
        let runs: Vec<_> = runs
            .iter()
            .map(|&run| &repeats.runs[run as usize])
            .collect();
        let period = runs[0].period;
        assert!(
            (runs.iter()).all(|run| run.period == period && run.items.len() % period == 0),
            "all visits of a loop have the same period and whole passes"
        );
        let mut starts = vec![0];
        let mut visits = Vec::new();
        for (visit, run) in (0u32..).zip(&runs) {
            visits.extend(std::iter::repeat_n(visit, run.items.len() / period));
            starts.push(visits.len() as u32);
        }
        self.loops.push(NestLoop {
            parent,
            depth,
            starts,
            visits,
            body: Vec::new(),
            independent: false,
            circular: false,
        });
        for place in 0..period {
            let column = runs
                .iter()
                .flat_map(|run| run.items.iter().skip(place).step_by(period));
            let (mut inner, mut single) = (Vec::new(), Vec::new());
            for &item in column {
                match item {
                    ProgramItem::Statement(statement) => single.push(statement),
                    ProgramItem::Loop(run) => inner.push(run),
                    ProgramItem::Row => {}
                }
            }
            assert!(
                single.is_empty() || inner.is_empty(),
                "an element of a loop is a statement in all passes or a loop in all"
            );
            if !single.is_empty() {
                let element = self.position(Some(number), top, single);
                self.loops[number].body.push(element);
            } else if !inner.is_empty() {
                let inner = self.build(repeats, Some(number), top, &inner);
                self.loops[number].body.push(BodyElement::Loop(inner));
            }
        }
        number
    }

    fn produce(&mut self, statements: &Statements) {
        for (number, position) in (0u32..).zip(&self.positions) {
            for (pass, &statement) in (0u32..).zip(&position.statements) {
                if let StatementTarget::Value(value) = statements.list[statement as usize].target {
                    self.producers[value.index()] = Some((number, pass));
                }
            }
        }
    }

    /// Tests whether the passes of an innermost loop are independent, and
    /// reverses them if outputs are then written in ascending order, which
    /// compilers can vectorise.
    fn direct(&mut self, function: &Function, statements: &Statements, number: usize) {
        let body = self.loops[number].body.clone();
        let mut positions = Vec::new();
        for element in body {
            match element {
                BodyElement::Position(position) => positions.push(position),
                BodyElement::Loop(_) => return,
            }
        }
        let reads_others = positions.iter().any(|&position| {
            let passes = self.positions[position].statements.iter().enumerate();
            passes.into_iter().any(|(pass, &statement)| {
                statements.leaves(statement).iter().any(|leaf| {
                    leaf.value()
                        .is_some_and(|value| self.is_of_another_pass(number, pass, value.index()))
                })
            })
        });
        if reads_others {
            return;
        }
        self.loops[number].independent = true;
        let downwards = positions
            .iter()
            .any(|&position| self.writes_downwards(function, statements, number, position));
        if downwards {
            let starts = self.loops[number].starts.clone();
            for position in positions {
                for visit in starts.windows(2) {
                    self.positions[position].statements[visit[0] as usize..visit[1] as usize]
                        .reverse();
                }
            }
        }
    }

    /// The position and the pass that compute a value which statements read.
    pub(super) fn producer(&self, value: Value) -> (u32, u32) {
        self.producers[value.index()].expect("a value that a statement reads has a statement")
    }

    fn is_of_another_pass(&self, number: usize, pass: usize, value: usize) -> bool {
        let Some((position, other)) = self.producers[value] else {
            return false;
        };
        if self.positions[position as usize].owner != Some(number) {
            return false;
        }
        let visits = &self.loops[number].visits;
        visits[other as usize] == visits[pass] && other as usize != pass
    }

    fn writes_downwards(
        &self,
        function: &Function,
        statements: &Statements,
        number: usize,
        position: usize,
    ) -> bool {
        let output = |pass: usize| {
            let statement = self.positions[position].statements[pass];
            let output = match statements.list[statement as usize].target {
                StatementTarget::Value(value) => statements.primary(value),
                StatementTarget::Output(output) => Some(output),
            }?;
            let (array, indices, _) = function.output_element(output);
            Some((array.offset, indices))
        };
        let visits = &self.loops[number].visits;
        let mut steps = (0usize, 0usize);
        for pass in 1..visits.len() {
            if visits[pass] == visits[pass - 1]
                && let (Some(before), Some(after)) = (output(pass - 1), output(pass))
            {
                if after < before {
                    steps.0 += 1;
                } else {
                    steps.1 += 1;
                }
            }
        }
        steps.0 > steps.1
    }

    /// The pass of a loop around (or of the loop itself) that a pass of a
    /// loop belongs to; `None` when it is not in that loop.
    pub(super) fn enclosing(&self, from: usize, pass: usize, target: usize) -> Option<usize> {
        let (mut number, mut pass) = (from, pass);
        while number != target {
            pass = self.loops[number].visits[pass] as usize;
            number = self.loops[number].parent?;
        }
        Some(pass)
    }

    /// The loops around a place in the code, the outermost first, the place's
    /// own loop last.
    pub(super) fn around(&self, place: Option<usize>) -> Vec<usize> {
        let mut list = Vec::new();
        let mut next = place;
        while let Some(number) = next {
            list.push(number);
            next = self.loops[number].parent;
        }
        list.reverse();
        list
    }

    /// For every pass of a loop the pass numbers within the visits, of the
    /// loops around it and its own, the outermost first.
    pub(super) fn iterations(&self, number: usize) -> Vec<u32> {
        let depth = self.loops[number].depth;
        let mut list = vec![0; depth * self.loops[number].passes()];
        for (pass, row) in list.chunks_exact_mut(depth).enumerate() {
            let (mut number, mut pass) = (number, pass);
            for index in row.iter_mut().rev() {
                let place = &self.loops[number];
                *index = place.iteration(pass);
                pass = place.visits[pass] as usize;
                number = place.parent.unwrap_or(number);
            }
        }
        list
    }
}
