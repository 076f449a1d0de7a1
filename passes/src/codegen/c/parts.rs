//! What becomes a statement, which statements form a part, and which values
//! cross from part to part.

use super::order::order;
use super::sines::Slots;
use super::{Options, Sines};
use robovec_analysis::slice::live;
use robovec_ir::{Function, Operand, Value};

/// Most operations of one expression.
const EXPRESSION: u32 = 24;

/// A statement of the generated function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Statement {
    /// Defines a variable with the value of a node.
    Define(Value),
    /// Puts an angle in its slot.
    Angle(u32),
    /// Sets an output element: the place among the assignments.
    Assign(u32),
}

/// Some statements that follow each other.
#[derive(Clone, Default, Debug)]
pub(super) struct Part {
    pub(super) statements: Vec<Statement>,
}

/// The plan of a generated function.
pub(super) struct Plan {
    /// For each node: whether its operation stands inside the expression of
    /// its only user.
    inlined: Vec<bool>,
    pub(super) parts: Vec<Part>,
    /// How many parts stand before the sines are computed.
    pub(super) head: usize,
    /// True when all parts stand in one function.
    pub(super) is_flat: bool,
    pub(super) slots: Slots,
    /// For each node the word of the work array it travels in, or `NO_WORD`.
    words: Vec<u32>,
    /// For each node the number of the function it is defined in.
    defined: Vec<u32>,
    /// Length of the work array.
    pub(super) work: u32,
}

const NO_WORD: u32 = u32::MAX;

impl Plan {
    /// Plans a function. With `outputs_last` no output is written before
    /// everything is computed.
    pub(super) fn new(function: &Function, options: &Options, outputs_last: bool) -> Plan {
        let live = live(function);
        let (inlined, sizes) = inlined(function, outputs_last);
        let slots = match options.sines {
            Sines::Inline => Slots::new(function, &live),
            Sines::Library => Slots::none(function),
        };
        let ordered = order(function, &live, &inlined, options.order, outputs_last);
        let mut early = vec![false; inlined.len()];
        for &angle in slots.angles() {
            mark(function, angle, &mut early);
        }
        let mut head = Vec::new();
        let mut body = Vec::with_capacity(ordered.len());
        for statement in ordered {
            match statement {
                Statement::Define(value) if slots.of(value).is_some() => {}
                Statement::Define(value) if early[value.index()] => head.push(statement),
                _ => body.push(statement),
            }
        }
        head.extend((0..slots.angles().len() as u32).map(Statement::Angle));
        let size = |statement: &Statement| {
            let operand = match *statement {
                Statement::Define(value) => return sizes[value.index()],
                Statement::Angle(slot) => slots.angles()[slot as usize],
                Statement::Assign(index) => function.assignments[index as usize].operand,
            };
            let value = operand.value().filter(|value| inlined[value.index()]);
            value.map_or(1, |value| sizes[value.index()])
        };
        let head = cut(head, options.part, size);
        let body = cut(body, options.part, size);
        let mut plan = Plan {
            words: vec![NO_WORD; inlined.len()],
            defined: vec![NO_WORD; inlined.len()],
            is_flat: head.len() <= 1 && body.len() <= 1,
            inlined,
            head: head.len(),
            parts: head.into_iter().chain(body).collect(),
            work: slots.words(),
            slots,
        };
        plan.cross(function);
        plan
    }

    /// True when the node's operation stands in its user's expression.
    pub(super) fn is_inlined(&self, value: Value) -> bool {
        self.inlined[value.index()]
    }

    /// The word of the work array a value travels in.
    pub(super) fn word(&self, value: Value) -> Option<u32> {
        let word = self.words[value.index()];
        (word != NO_WORD).then_some(word)
    }

    /// True when a value has to be fetched from the work array in a part.
    pub(super) fn is_foreign(&self, value: Value, part: usize) -> bool {
        self.defined[value.index()] != self.function_of(part)
    }

    fn function_of(&self, part: usize) -> u32 {
        if self.is_flat { 0 } else { part as u32 }
    }

    /// Finds the values that cross from part to part and gives them words,
    /// which are free again after the last part that reads them.
    fn cross(&mut self, function: &Function) {
        let nodes = function.nodes().len();
        let mut last = vec![0u32; nodes];
        let mut loads: Vec<Vec<Value>> = Vec::with_capacity(self.parts.len());
        for number in 0..self.parts.len() {
            let here = self.function_of(number);
            let mut reads = Vec::new();
            for index in 0..self.parts[number].statements.len() {
                let statement = self.parts[number].statements[index];
                if let Statement::Define(value) = statement {
                    self.defined[value.index()] = here;
                }
                self.leaves(function, statement, |operand| reads.extend(operand.value()));
            }
            // Sines have words of their own.
            reads.retain(|&value| {
                self.slots.of(value).is_none() && self.defined[value.index()] != here
            });
            reads.sort_unstable();
            reads.dedup();
            for value in &reads {
                last[value.index()] = here;
            }
            loads.push(reads);
        }
        // Angles are not read again once their sines are there.
        let mut free: Vec<u32> = Vec::new();
        for (number, reads) in loads.into_iter().enumerate() {
            if number == self.head {
                free.extend(self.slots.angle_words());
            }
            for &statement in &self.parts[number].statements {
                if let Statement::Define(value) = statement
                    && last[value.index()] > self.function_of(number)
                {
                    self.words[value.index()] = free.pop().unwrap_or_else(|| {
                        self.work += 1;
                        self.work - 1
                    });
                }
            }
            let ended = reads
                .iter()
                .filter(|value| last[value.index()] == number as u32);
            free.extend(ended.map(|value| self.words[value.index()]));
        }
    }

    /// Calls for every variable, input and constant in a statement's
    /// expression.
    fn leaves(&self, function: &Function, statement: Statement, mut call: impl FnMut(Operand)) {
        let mut open: Vec<Operand> = match statement {
            Statement::Define(value) => function.node(value).operands().to_vec(),
            Statement::Angle(slot) => vec![self.slots.angles()[slot as usize]],
            Statement::Assign(index) => vec![function.assignments[index as usize].operand],
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

/// Cuts statements into parts of about so many operations, all of one size.
fn cut(statements: Vec<Statement>, part: u32, size: impl Fn(&Statement) -> u32) -> Vec<Part> {
    let total: u64 = statements
        .iter()
        .map(|statement| u64::from(size(statement)))
        .sum();
    let count = total.div_ceil(u64::from(part.max(1))).max(1);
    let share = total.div_ceil(count);
    let mut parts: Vec<Part> = Vec::new();
    let mut done = share;
    for statement in statements {
        if done >= share {
            parts.push(Part::default());
            done = 0;
        }
        done += u64::from(size(&statement));
        if let Some(part) = parts.last_mut() {
            part.statements.push(statement);
        }
    }
    parts
}

/// Marks a value and everything it needs.
fn mark(function: &Function, operand: Operand, marked: &mut [bool]) {
    let mut open: Vec<Value> = operand.value().into_iter().collect();
    while let Some(value) = open.pop() {
        if !std::mem::replace(&mut marked[value.index()], true) {
            let operands = function.node(value).operands().iter();
            open.extend(operands.filter_map(|operand| operand.value()));
        }
    }
}

/// For each node whether it stands inside its user's expression, and how many
/// operations the expression that ends in it has. What outputs are set to is
/// a variable when outputs stand last, so that it is computed before.
fn inlined(function: &Function, outputs_last: bool) -> (Vec<bool>, Vec<u32>) {
    let uses = function.use_counts();
    let mut inlined = vec![false; uses.len()];
    let mut sizes = vec![0u32; uses.len()];
    let mut given = vec![false; uses.len()];
    for assignment in function.assignments.iter().filter(|_| outputs_last) {
        if let Some(value) = assignment.operand.value() {
            given[value.index()] = true;
        }
    }
    for (value, node) in function.values() {
        let inner = node.operands().iter().filter_map(|operand| operand.value());
        let inner = inner.filter(|value| inlined[value.index()]);
        let size = 1 + inner.map(|value| sizes[value.index()]).sum::<u32>();
        sizes[value.index()] = size;
        inlined[value.index()] = node.name.is_none()
            && uses[value.index()] == 1
            && size <= EXPRESSION
            && !given[value.index()];
    }
    (inlined, sizes)
}
