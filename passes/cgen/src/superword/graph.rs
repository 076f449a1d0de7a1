//! A function as a graph of values and input elements.

use robovec_ir::{Function, Input, Operand, OperandKind, Operation, Value};

/// The number of a value or input element: values first.
pub(super) fn item(values: usize, operand: Operand) -> Option<usize> {
    match operand.kind() {
        OperandKind::Value(value) => Some(value.index()),
        OperandKind::Input(input) => Some(values + input.index()),
        OperandKind::Constant(_) | OperandKind::None => None,
    }
}

/// Operations that can be lanes of one superword.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum OperationClass {
    /// Sums and differences: a lane can subtract where another adds.
    Sum,
    Product,
    Quotient,
    Sign,
}

/// The values that are read or computed, and the inputs.
pub(super) struct DataGraph<'a> {
    pub(super) function: &'a Function,
    computed: &'a [bool],
    loaded: &'a [bool],
    /// For each value the longest path from the inputs; changes of sign do not
    /// count.
    pub(super) heights: Vec<u32>,
    /// For each item the values that read it, one after the other.
    users: Vec<Value>,
    first_user: Vec<u32>,
    is_read: Vec<bool>,
}

impl<'a> DataGraph<'a> {
    pub(super) fn new(
        function: &'a Function,
        computed: &'a [bool],
        loaded: &'a [bool],
    ) -> DataGraph<'a> {
        let mut graph = DataGraph {
            function,
            computed,
            loaded,
            heights: vec![0; computed.len()],
            users: Vec::new(),
            first_user: Vec::new(),
            is_read: Vec::new(),
        };
        graph.is_read = vec![false; graph.len()];
        let mut counts = vec![0u32; graph.len() + 1];
        for (value, node) in function.values() {
            let below = node.operands().iter().filter_map(|operand| operand.value());
            let below = below.map(|value| graph.heights[value.index()]);
            let own = u32::from(graph.class(value) != Some(OperationClass::Sign));
            graph.heights[value.index()] = below.fold(0, u32::max) + own;
            for &operand in graph.reads(value) {
                if let Some(item) = graph.item(operand) {
                    counts[item + 1] += 1;
                }
            }
            if graph.is_loaded(value) || graph.is_computed(value) {
                for &read in node.operands() {
                    if let Some(item) = graph.item(read) {
                        graph.is_read[item] = true;
                    }
                }
            }
        }
        for index in 1..counts.len() {
            counts[index] += counts[index - 1];
        }
        graph.users = vec![Value(0); counts[graph.len()] as usize];
        let mut next = counts.clone();
        for value in (0..computed.len() as u32).map(Value) {
            for &operand in graph.reads(value) {
                if let Some(item) = item(computed.len(), operand) {
                    graph.users[next[item] as usize] = value;
                    next[item] += 1;
                }
            }
        }
        graph.first_user = counts;
        graph
    }

    /// Number of values and input elements.
    pub(super) fn len(&self) -> usize {
        self.computed.len() + self.function.input_len()
    }

    /// Number of operations to be computed.
    pub(super) fn operations(&self) -> usize {
        self.computed.iter().filter(|computed| **computed).count()
    }

    /// True if an item is read by an operation, or by a sine in memory.
    pub(super) fn is_read(&self, operand: Operand) -> bool {
        self.item(operand).is_some_and(|item| self.is_read[item])
    }

    pub(super) fn item(&self, operand: Operand) -> Option<usize> {
        item(self.computed.len(), operand)
    }

    /// The value or input element with a number.
    pub(super) fn operand(&self, item: usize) -> Operand {
        match item.checked_sub(self.computed.len()) {
            None => Value(item as u32).into(),
            Some(input) => Input(input as u32).into(),
        }
    }

    /// The operands that are read when a value is computed.
    pub(super) fn reads(&self, value: Value) -> &'a [Operand] {
        if self.computed[value.index()] {
            self.function.node(value).operands()
        } else {
            &[]
        }
    }

    pub(super) fn is_computed(&self, value: Value) -> bool {
        self.computed[value.index()]
    }

    /// True for sines and cosines that are read from memory.
    pub(super) fn is_loaded(&self, value: Value) -> bool {
        self.loaded[value.index()]
    }

    /// True for sines and cosines that are read from memory or computed one by
    /// one.
    pub(super) fn is_circular(&self, value: Value) -> bool {
        let is_read = self.is_loaded(value) || self.is_computed(value);
        is_read && self.function.node(value).operation.is_trigonometric()
    }

    /// The values that read an item.
    pub(super) fn users(&self, item: usize) -> &[Value] {
        &self.users[self.first_user[item] as usize..self.first_user[item + 1] as usize]
    }

    /// The class of the operation of a value; none if it cannot be in a
    /// superword that computes.
    pub(super) fn class(&self, value: Value) -> Option<OperationClass> {
        if !self.computed[value.index()] {
            return None;
        }
        let node = self.function.node(value);
        match node.operation {
            _ if self.is_sign(value) => {
                // A sign of a sign would be of one height with it.
                let mut inner = node.operands().iter().filter_map(|operand| operand.value());
                let is_single = !inner.any(|value| self.is_sign(value));
                is_single.then_some(OperationClass::Sign)
            }
            Operation::Add | Operation::Sub => Some(OperationClass::Sum),
            Operation::Mul => Some(OperationClass::Product),
            Operation::Div => Some(OperationClass::Quotient),
            Operation::Neg
            | Operation::Copy
            | Operation::Sqrt
            | Operation::Sin
            | Operation::Cos
            | Operation::Fma
            | Operation::Fms
            | Operation::Fnma => None,
        }
    }

    /// True for a change of sign, written as a sign or as a difference from 0.
    fn is_sign(&self, value: Value) -> bool {
        let node = self.function.node(value);
        match node.operation {
            Operation::Neg => true,
            Operation::Sub => self.function.number(node.operands[0]) == Some(0.0),
            _ => false,
        }
    }
}
