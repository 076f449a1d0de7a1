//! The parts of the text: the operations that become statements, the statements
//! of each part, and the values that cross from part to part.

use super::sines::Slots;
use super::{Options, Sines, StatementOrder};
use crate::emit::crossing::{Crossing, PartValues};
use crate::emit::inlining::{Inlining, assigned};
use crate::emit::order::{CodeStep, depth_first, program};
use crate::superword::Superwords;
use robovec_analysis::slice::{live, needed};
use robovec_ir::{Function, Operand, Value};

/// A statement of the generated function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum CodeStatement {
    /// Defines a variable or sets an output element.
    Step(CodeStep),
    /// Puts an angle in its slot.
    Angle(u32),
}

/// Some statements that follow each other.
#[derive(Clone, Default, Debug)]
pub(super) struct CodePart {
    pub(super) statements: Vec<CodeStatement>,
}

/// The plan of a generated function.
pub(super) struct CodePlan {
    /// For each node: whether its operation is inside the expression of
    /// its only user.
    inlined: Vec<bool>,
    pub(super) parts: Vec<CodePart>,
    /// The number of parts before the sines are computed.
    pub(super) head: usize,
    /// True when all parts are in one function.
    pub(super) is_flat: bool,
    pub(super) slots: Slots,
    pub(super) superwords: Superwords,
    crossing: Crossing,
    /// The crossing of superwords, by the values of their first lanes.
    word_crossing: Crossing,
}

impl CodePlan {
    /// Plans a function. With `outputs_last` no output is written before all
    /// values are computed.
    pub(super) fn new(function: &Function, options: &Options, outputs_last: bool) -> CodePlan {
        let live = live(function);
        let slots = match options.sines {
            Sines::Inline => Slots::new(function, &live),
            Sines::Library => Slots::none(function),
        };
        let early = needed(function, slots.angles().iter().copied(), |_| false);
        let superwords = superwords(function, options, &live, &slots, &early);
        let Inlining { inlined, sizes } = inlining(function, outputs_last, &superwords);
        assert_eq!(live.len(), inlined.len(), "every node is inlined or not");
        let computed: Vec<bool> = (function.values())
            .map(|(value, _)| {
                let index = value.index();
                live[index] && !inlined[index] && superwords.leader(value) == value
            })
            .collect();
        let ordered = match options.order {
            StatementOrder::Program => program(function, &computed),
            StatementOrder::Depth => depth_first(function, &computed, outputs_last, &superwords),
        };
        let (head, body) = apart(ordered, &slots, &early);
        let size = |statement: &CodeStatement| {
            let operand = match *statement {
                CodeStatement::Step(CodeStep::Define(value)) => return sizes[value.index()],
                CodeStatement::Angle(slot) => slots.angles()[slot as usize],
                CodeStatement::Step(CodeStep::Assign(index)) => {
                    function.assignments[index as usize].operand
                }
            };
            let value = operand.value().filter(|value| inlined[value.index()]);
            value.map_or(1, |value| sizes[value.index()])
        };
        let head = cut(head, options.part, size);
        let body = cut(body, options.part, size);
        let mut plan = CodePlan {
            is_flat: head.len() <= 1 && body.len() <= 1,
            inlined,
            head: head.len(),
            parts: head.into_iter().chain(body).collect(),
            crossing: Crossing::new(0, &[], 0, |_| 0..0),
            word_crossing: Crossing::new(0, &[], 0, |_| 0..0),
            slots,
            superwords,
        };
        plan.cross(function);
        plan
    }

    /// True when the node's operation is in its user's expression.
    pub(super) fn is_inlined(&self, value: Value) -> bool {
        self.inlined[value.index()]
    }

    /// The word of the work array a value travels in.
    pub(super) fn word(&self, value: Value) -> Option<u32> {
        self.crossing.word(value)
    }

    /// The word of the work array a value has to be fetched from in a part.
    pub(super) fn load(&self, value: Value, part: usize) -> Option<u32> {
        self.slots.of(value).or(self.crossing.load(value, part))
    }

    /// Length of the work array.
    pub(super) fn work(&self) -> u32 {
        self.crossing.length
    }

    /// The element of the array of superwords that one travels in.
    pub(super) fn vector(&self, leader: Value) -> Option<u32> {
        self.word_crossing.word(leader)
    }

    /// The element of the array of superwords to fetch one from in a part.
    pub(super) fn load_vector(&self, leader: Value, part: usize) -> Option<u32> {
        self.word_crossing.load(leader, part)
    }

    /// Number of operations on superwords.
    pub(super) fn vector_operations(&self) -> usize {
        let parts = self.parts.iter().flat_map(|part| &part.statements);
        let vectors = parts.filter(|statement| match statement {
            CodeStatement::Step(CodeStep::Define(value)) => {
                self.superwords.computing(*value).is_some()
            }
            CodeStatement::Step(CodeStep::Assign(_)) | CodeStatement::Angle(_) => false,
        });
        vectors.count()
    }

    /// Length of the array of superwords.
    pub(super) fn vectors(&self) -> u32 {
        self.word_crossing.length
    }

    /// Finds the values that cross from part to part; none does when all
    /// are in one function.
    fn cross(&mut self, function: &Function) {
        let parts = if self.is_flat { &[] } else { &*self.parts };
        let (traffic, word_traffic): (Vec<PartValues>, Vec<PartValues>) = parts
            .iter()
            .map(|part| self.traffic(function, part))
            .unzip();
        // Angles are not read again once their sines are there.
        let freed = |part| {
            if part == self.head {
                self.slots.angle_words()
            } else {
                0..0
            }
        };
        let values = self.inlined.len();
        self.crossing = Crossing::new(values, &traffic, self.slots.words(), freed);
        self.word_crossing = Crossing::new(values, &word_traffic, 0, |_| 0..0);
    }

    /// The values, and the superwords by their first lanes, that a part defines
    /// and reads.
    fn traffic(&self, function: &Function, part: &CodePart) -> (PartValues, PartValues) {
        let mut values = PartValues::default();
        let mut words = PartValues::default();
        let is_vector = |value| self.superwords.computing(value).is_some();
        for &statement in &part.statements {
            if let CodeStatement::Step(CodeStep::Define(value)) = statement {
                let own = if is_vector(value) {
                    &mut words
                } else {
                    &mut values
                };
                own.defined.push(value);
            }
            self.leaves(function, statement, |operand| match operand.value() {
                Some(value) if is_vector(value) => {
                    words.read.push(self.superwords.leader(value));
                }
                // Sines have words of their own.
                Some(value) if self.slots.of(value).is_none() => values.read.push(value),
                _ => {}
            });
        }
        values.read.sort_unstable();
        words.read.sort_unstable();
        (values, words)
    }

    /// Calls for every variable, input and constant in a statement's
    /// expression.
    fn leaves(&self, function: &Function, statement: CodeStatement, mut call: impl FnMut(Operand)) {
        let mut open: Vec<Operand> = match statement {
            CodeStatement::Step(step) => step.all_reads(function, &self.superwords),
            CodeStatement::Angle(slot) => vec![self.slots.angles()[slot as usize]],
        };
        while let Some(operand) = open.pop() {
            match operand.value() {
                Some(value) if self.is_inlined(value) => {
                    open.extend(function.node(value).operands());
                }
                Some(_) | None => call(operand),
            }
        }
    }
}

/// The superwords of the operations after the sines.
fn superwords(
    function: &Function,
    options: &Options,
    live: &[bool],
    slots: &Slots,
    early: &[bool],
) -> Superwords {
    let loaded: Vec<bool> = (function.values())
        .map(|(value, _)| live[value.index()] && slots.of(value).is_some())
        .collect();
    let computed: Vec<bool> = (live.iter().zip(early).zip(&loaded))
        .map(|((live, early), loaded)| *live && !early && !loaded)
        .collect();
    match options.order {
        StatementOrder::Depth => Superwords::find(function, &computed, &loaded, options.superwords),
        // In the function's order lanes are too far apart.
        StatementOrder::Program => Superwords::none(),
    }
}

/// The operations before the sines, angles last, and those after them.
fn apart(
    ordered: Vec<CodeStep>,
    slots: &Slots,
    early: &[bool],
) -> (Vec<CodeStatement>, Vec<CodeStatement>) {
    let mut head = Vec::new();
    let mut body = Vec::with_capacity(ordered.len());
    for step in ordered {
        match step {
            CodeStep::Define(value) if slots.of(value).is_some() => {}
            CodeStep::Define(value) if early[value.index()] => head.push(CodeStatement::Step(step)),
            CodeStep::Define(_) | CodeStep::Assign(_) => body.push(CodeStatement::Step(step)),
        }
    }
    head.extend((0..slots.angles().len() as u32).map(CodeStatement::Angle));
    (head, body)
}

/// Cuts statements into parts of about this number of operations, all of one
/// size.
fn cut(
    statements: Vec<CodeStatement>,
    part: u32,
    size: impl Fn(&CodeStatement) -> u32,
) -> Vec<CodePart> {
    let total: u64 = statements
        .iter()
        .map(|statement| u64::from(size(statement)))
        .sum();
    let count = total.div_ceil(u64::from(part.max(1))).max(1);
    let share = total.div_ceil(count);
    let mut parts: Vec<CodePart> = Vec::new();
    let mut done = share;
    for statement in statements {
        if done >= share {
            parts.push(CodePart::default());
            done = 0;
        }
        done += u64::from(size(&statement));
        let part = parts.last_mut().expect("the first statement begins a part");
        part.statements.push(statement);
    }
    parts
}

/// Unnamed operations are inside their user's expression. With outputs last,
/// the assigned value is a variable, so that it is computed before.
fn inlining(function: &Function, outputs_last: bool, words: &Superwords) -> Inlining {
    let given = assigned(function);
    Inlining::new(function, |value, node| {
        let is_last = outputs_last && given[value.index()];
        node.name.is_none() && !is_last && words.computing(value).is_none()
    })
}
