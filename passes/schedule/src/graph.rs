//! The function as a graph for the scheduler: readers, kinds of elements, and
//! the lengths of the chains before and after each operation.

use super::error::PlaceError;
use robovec_ir::{
    Constant, Function, Input, Level, Machine, Node, Operand, OperandKind, Operation, Value,
    index_types,
};

/// The kind of a node the host evaluates.
pub(super) const HOST: u8 = u8::MAX;

/// No schedule is longer than this: numbers of cycles then fit `u32` with
/// room for sums of three.
const LONGEST: u64 = 1 << 30;

index_types! {
    /// Datum that an operation reads: below the number of nodes a node, from
    /// there on an input or constant of [`DependenceGraph::initial`].
    pub(super) struct Datum;
}

impl From<Value> for Datum {
    fn from(value: Value) -> Datum {
        Datum::new(value.0)
    }
}

/// A kind of processing element.
#[derive(Clone, Copy, Debug)]
pub(super) struct SchedulingKind {
    /// Cycles from an issue to the first issue that can read the result.
    pub(super) weight: u32,
    /// The number of elements.
    pub(super) count: u32,
    /// The first of them, over all kinds.
    pub(super) first: u32,
}

/// The dependences of a function.
#[derive(Clone, Debug)]
pub(super) struct DependenceGraph {
    /// The kinds of elements, in the order of the machine file.
    pub(super) kinds: Vec<SchedulingKind>,
    /// The kind that performs each node, or [`HOST`].
    pub(super) kind: Vec<u8>,
    /// `users[user_starts[i]..user_starts[i + 1]]` are the nodes that read
    /// node `i`, in program order, twice when they read it twice.
    pub(super) user_starts: Vec<u32>,
    /// See [`DependenceGraph::user_starts`].
    pub(super) users: Vec<u32>,
    /// The number of operands of each node that the machine computes.
    pub(super) computed_operands: Vec<u8>,
    /// The earliest issue of each node with elements without number.
    pub(super) head: Vec<u32>,
    /// The longest chain from the issue of each node to the end of the
    /// program, its own weight included.
    pub(super) tail: Vec<u32>,
    /// The longest chain of the program.
    pub(super) path: u32,
    /// Datum number of each input and constant; 0 for unread ones.
    inputs: Vec<u32>,
    /// See [`DependenceGraph::inputs`].
    constants: Vec<u32>,
    /// The inputs and constants that are read, in order.
    pub(super) initial: Vec<Operand>,
}

impl DependenceGraph {
    /// Builds the graph.
    ///
    /// # Errors
    ///
    /// Fails when the function is not atomic, the machine cannot perform an
    /// operation, or the longest chain does not fit.
    pub(super) fn new(
        function: &Function,
        machine: &Machine,
    ) -> Result<DependenceGraph, PlaceError> {
        if function.level == Level::Equations {
            return Err(PlaceError::NotAtomic {
                level: function.level,
            });
        }
        let kind = kinds_of(function, machine)?;
        let mut first = 0;
        let kinds: Vec<SchedulingKind> = machine
            .elements
            .iter()
            .map(|element| {
                first += element.count;
                SchedulingKind {
                    weight: element.weight(),
                    count: element.count,
                    first: first - element.count,
                }
            })
            .collect();
        let mut graph = DependenceGraph {
            kinds,
            computed_operands: vec![0; kind.len()],
            head: vec![0; kind.len()],
            tail: vec![0; kind.len()],
            user_starts: vec![0; kind.len() + 1],
            users: Vec::new(),
            kind,
            path: 0,
            inputs: vec![0; function.input_len()],
            constants: vec![0; function.constants().len()],
            initial: Vec::new(),
        };
        graph.number_data(function);
        graph.link_users(function);
        graph.measure(function)?;
        Ok(graph)
    }

    /// The weight of a node; the host costs nothing.
    pub(super) fn weight(&self, node: usize) -> u32 {
        match self.kind[node] {
            HOST => 0,
            kind => self.kinds[kind as usize].weight,
        }
    }

    /// The nodes that read a node.
    pub(super) fn users_of(&self, node: usize) -> &[u32] {
        &self.users[self.user_starts[node] as usize..self.user_starts[node + 1] as usize]
    }

    /// The number of nodes that read a node, one that reads it twice counted
    /// twice.
    pub(super) fn user_count(&self, node: usize) -> u32 {
        self.user_starts[node + 1] - self.user_starts[node]
    }

    /// The latest issue of a node that does not lengthen the longest chain.
    pub(super) fn latest(&self, node: usize) -> u32 {
        self.path - self.tail[node]
    }

    /// The largest weight of any kind.
    pub(super) fn largest_weight(&self) -> u32 {
        self.kinds.iter().map(|kind| kind.weight).fold(0, u32::max)
    }

    /// The operations the machine performs.
    pub(super) fn operations(&self) -> usize {
        self.kind.iter().filter(|&&kind| kind != HOST).count()
    }

    /// The number of data: nodes, and inputs and constants that are read.
    pub(super) fn data_len(&self) -> usize {
        self.kind.len() + self.initial.len()
    }

    /// The operand that is a datum the machine does not compute.
    pub(super) fn initial_operand(&self, datum: Datum) -> Operand {
        match datum.index().checked_sub(self.kind.len()) {
            None => Operand::from(Value(datum.number())),
            Some(index) => self.initial[index],
        }
    }

    /// The machine computes the datum.
    pub(super) fn is_computed(&self, datum: Datum) -> bool {
        self.kind
            .get(datum.index())
            .is_some_and(|&kind| kind != HOST)
    }

    /// Frees the tables that only scheduling uses.
    pub(super) fn release_links(&mut self) {
        self.user_starts = Vec::new();
        self.users = Vec::new();
        self.computed_operands = Vec::new();
        self.head = Vec::new();
        self.tail = Vec::new();
    }

    /// The data a node reads.
    #[inline]
    pub(super) fn data_of(&self, node: &Node) -> [Option<Datum>; Operand::MAX_COUNT] {
        // Written out: `map` of an array is a call for each operand.
        let [a, b, c] = node.operands;
        [self.datum(a), self.datum(b), self.datum(c)]
    }

    #[inline]
    fn datum(&self, operand: Operand) -> Option<Datum> {
        match operand.kind() {
            OperandKind::Value(value) => Some(Datum::from(value)),
            OperandKind::Input(input) => Some(Datum::new(self.inputs[input.index()])),
            OperandKind::Constant(constant) => Some(Datum::new(self.constants[constant.index()])),
            OperandKind::None => None,
        }
    }

    /// Numbers the inputs and constants that are read after the values, in
    /// the order of operands.
    fn number_data(&mut self, function: &Function) {
        for operand in function.nodes().iter().flat_map(|node| node.operands()) {
            match operand.kind() {
                OperandKind::Input(input) => self.inputs[input.index()] = 1,
                OperandKind::Constant(constant) => self.constants[constant.index()] = 1,
                OperandKind::Value(_) | OperandKind::None => {}
            }
        }
        let values = self.kind.len() as u32;
        let mut number = |places: &mut [u32], operand: &dyn Fn(u32) -> Operand| {
            for (index, place) in (0..).zip(places) {
                if *place != 0 {
                    *place = values + self.initial.len() as u32;
                    self.initial.push(operand(index));
                }
            }
        };
        number(&mut self.inputs, &|index| Input(index).into());
        number(&mut self.constants, &|index| Constant(index).into());
    }

    fn link_users(&mut self, function: &Function) {
        for node in function.nodes() {
            for value in node.values() {
                self.user_starts[value.index() + 1] += 1;
            }
        }
        for index in 1..self.user_starts.len() {
            self.user_starts[index] += self.user_starts[index - 1];
        }
        let count = *self
            .user_starts
            .last()
            .expect("there is a start after the last node");
        self.users = vec![0; count as usize];
        let mut next = self.user_starts.clone();
        for (index, node) in function.nodes().iter().enumerate() {
            for value in node.values() {
                assert!(value.index() < index, "an operand is an earlier node");
                let slot = &mut next[value.index()];
                self.users[*slot as usize] = index as u32;
                *slot += 1;
                self.computed_operands[index] += u8::from(self.kind[value.index()] != HOST);
            }
        }
    }

    fn measure(&mut self, function: &Function) -> Result<(), PlaceError> {
        let mut longest = 0_u64;
        for (index, node) in function.nodes().iter().enumerate() {
            let ready = |value: Value| self.head[value.index()] + self.weight(value.index());
            let start = node.values().map(ready).fold(0, u32::max);
            let end = u64::from(start) + u64::from(self.weight(index));
            if end > LONGEST {
                return Err(PlaceError::TooLong {
                    path: end,
                    limit: LONGEST,
                });
            }
            self.head[index] = start;
            longest = longest.max(end);
        }
        // Below LONGEST, checked above.
        self.path = longest as u32;
        for index in (0..self.kind.len()).rev() {
            let after = self
                .users_of(index)
                .iter()
                .map(|&user| self.tail[user as usize])
                .fold(0, u32::max);
            self.tail[index] = after + self.weight(index);
            assert!(
                self.head[index] + self.tail[index] <= self.path,
                "no chain is longer than the longest"
            );
        }
        Ok(())
    }
}

/// The kind of every node, and the errors of those that have none.
fn kinds_of(function: &Function, machine: &Machine) -> Result<Vec<u8>, PlaceError> {
    let performers = Operation::ALL.map(|operation| {
        let kind = machine.kind_of(operation);
        kind.and_then(|kind| u8::try_from(kind).ok())
            .filter(|&kind| kind != HOST)
    });
    let mut kinds: Vec<u8> = Vec::with_capacity(function.nodes().len());
    for (value, node) in function.values() {
        let operation = node.operation;
        if operation.is_trigonometric() {
            let computed = node.operands().iter().any(|operand| match operand.kind() {
                OperandKind::Value(Value(argument)) => kinds[argument as usize] != HOST,
                OperandKind::Input(_) | OperandKind::Constant(_) | OperandKind::None => false,
            });
            if computed {
                return Err(PlaceError::ComputedAngle {
                    value,
                    operation: operation.name(),
                });
            }
            kinds.push(HOST);
        } else if let Some(kind) = performers[operation as usize] {
            kinds.push(kind);
        } else {
            return Err(PlaceError::NotPerformed {
                value,
                operation: operation.name(),
                machine: machine.name.clone(),
            });
        }
    }
    Ok(kinds)
}
