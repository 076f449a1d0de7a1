//! What becomes a statement, which statements form a part, and which values
//! cross from part to part.

use robovec_ir::{Array, Function, Operand, Value};

/// Operations per part.
const PART: u32 = 500;

/// Most operations of one expression.
const EXPRESSION: u32 = 24;

/// A statement of the generated function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Statement {
    /// Defines a variable with the value of a node.
    Define(Value),
    /// Sets an output element: the place among the assignments.
    Assign(u32),
}

/// A part: some statements, and the values it takes from earlier parts.
#[derive(Clone, Default, Debug)]
pub(super) struct Part {
    pub(super) statements: Vec<Statement>,
    /// Values of earlier parts it reads, each once, in order.
    pub(super) loads: Vec<Value>,
}

/// The plan of a generated function.
pub(super) struct Plan {
    /// For each node: whether its operation stands inside the expression of
    /// its only user.
    inlined: Vec<bool>,
    pub(super) parts: Vec<Part>,
    /// For each node the word of the work array it travels in, or `NO_WORD`.
    words: Vec<u32>,
    /// Length of the work array.
    pub(super) work: u32,
}

const NO_WORD: u32 = u32::MAX;

impl Plan {
    /// Plans a function.
    pub(super) fn new(function: &Function) -> Plan {
        let live = live(function);
        let (inlined, sizes) = inlined(function);
        let mut statements: Vec<(Statement, u32)> = function
            .values()
            .map(|(value, _)| value)
            .filter(|value| live[value.index()] && !inlined[value.index()])
            .map(|value| (Statement::Define(value), sizes[value.index()]))
            .collect();
        for (index, assignment) in (0u32..).zip(&function.assignments) {
            let value = assignment.operand.value();
            let size = value.filter(|value| inlined[value.index()]);
            let size = size.map_or(1, |value| sizes[value.index()]);
            statements.push((Statement::Assign(index), size));
        }
        let mut plan = Plan {
            words: vec![NO_WORD; inlined.len()],
            inlined,
            parts: Vec::new(),
            work: 0,
        };
        let mut size = PART;
        for (statement, cost) in statements {
            if size >= PART {
                plan.parts.push(Part::default());
                size = 0;
            }
            size += cost;
            if let Some(part) = plan.parts.last_mut() {
                part.statements.push(statement);
            }
        }
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

    /// Finds the values that cross from part to part and gives them words,
    /// which are free again after the last part that reads them.
    fn cross(&mut self, function: &Function) {
        let mut defined = vec![NO_WORD; function.nodes().len()];
        let mut last = vec![0u32; function.nodes().len()];
        let mut reads = Vec::new();
        for number in 0..self.parts.len() {
            reads.clear();
            for &statement in &self.parts[number].statements {
                if let Statement::Define(value) = statement {
                    defined[value.index()] = number as u32;
                }
                self.reads_of(function, statement, &mut reads);
            }
            reads.retain(|value| defined[value.index()] != number as u32);
            reads.sort_unstable();
            reads.dedup();
            for value in &reads {
                last[value.index()] = number as u32;
            }
            self.parts[number].loads = reads.clone();
        }
        let mut free: Vec<u32> = Vec::new();
        for number in 0..self.parts.len() {
            for &statement in &self.parts[number].statements {
                if let Statement::Define(value) = statement
                    && last[value.index()] > number as u32
                {
                    self.words[value.index()] = free.pop().unwrap_or_else(|| {
                        self.work += 1;
                        self.work - 1
                    });
                }
            }
            for value in &self.parts[number].loads {
                if last[value.index()] == number as u32 {
                    free.push(self.words[value.index()]);
                }
            }
        }
    }

    /// The variables that a statement's expression reads.
    fn reads_of(&self, function: &Function, statement: Statement, reads: &mut Vec<Value>) {
        self.leaves(function, statement, |operand| reads.extend(operand.value()));
    }

    /// Calls for every variable, input and constant in a statement's
    /// expression.
    fn leaves(&self, function: &Function, statement: Statement, mut call: impl FnMut(Operand)) {
        let mut open: Vec<Operand> = match statement {
            Statement::Define(value) => function.node(value).operands().to_vec(),
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

    /// For each input and then each output array whether a part touches it.
    pub(super) fn used_arrays(&self, function: &Function, part: &Part) -> Vec<bool> {
        let inputs = function.inputs().len();
        let mut used = vec![false; inputs + function.outputs().len()];
        for &statement in &part.statements {
            if let Statement::Assign(index) = statement {
                let output = function.assignments[index as usize].output;
                let (array, _, _) = function.output_element(output);
                used[inputs + place(function.outputs(), array)] = true;
            }
            self.leaves(function, statement, |operand| {
                if let Some(input) = operand.input() {
                    let (array, _, _) = function.input_element(input);
                    used[place(function.inputs(), array)] = true;
                }
            });
        }
        used
    }
}

/// Which of the arrays one with elements is: the last that starts where it
/// does, since those before it at the same offset are empty.
pub(super) fn place(arrays: &[Array], array: &Array) -> usize {
    arrays.partition_point(|known| known.offset <= array.offset) - 1
}

/// The nodes that an output needs.
fn live(function: &Function) -> Vec<bool> {
    let mut live = vec![false; function.nodes().len()];
    for assignment in &function.assignments {
        if let Some(value) = assignment.operand.value() {
            live[value.index()] = true;
        }
    }
    for (value, node) in function.values().rev() {
        if live[value.index()] {
            for operand in node.operands() {
                if let Some(operand) = operand.value() {
                    live[operand.index()] = true;
                }
            }
        }
    }
    live
}

/// For each node whether it stands inside its user's expression, and how many
/// operations the expression that ends in it has.
fn inlined(function: &Function) -> (Vec<bool>, Vec<u32>) {
    let uses = function.use_counts();
    let mut inlined = vec![false; uses.len()];
    let mut sizes = vec![0u32; uses.len()];
    for (value, node) in function.values() {
        let inner = node.operands().iter().filter_map(|operand| operand.value());
        let inner = inner.filter(|value| inlined[value.index()]);
        let size = 1 + inner.map(|value| sizes[value.index()]).sum::<u32>();
        sizes[value.index()] = size;
        inlined[value.index()] =
            node.name.is_none() && uses[value.index()] == 1 && size <= EXPRESSION;
    }
    (inlined, sizes)
}
