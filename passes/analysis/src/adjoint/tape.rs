//! The tape: a function as a list of operations over numbered slots.
//!
//! Nodes, inputs and constants lie after one another in one vector of
//! *slots*, so that a sweep over the function in either direction fetches an
//! operand with one index and no branch. A tape depends on the function alone
//! and serves any number of states.

use robovec_ir::{Constant, Function, Input, Operand, OperandKind, Operation, Value};
use robovec_num::arithmetic::Arithmetic;

/// A function as operations over slots.
#[derive(Clone, Debug)]
pub struct Tape {
    operations: Vec<Operation>,
    operands: Vec<[u32; 3]>,
    outputs: Vec<u32>,
    constants: Vec<f64>,
    inputs: usize,
}

/// The content of a slot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TapeSlot {
    /// The result of a node.
    Value(Value),
    /// An input element.
    Input(Input),
    /// A literal.
    Constant(Constant),
    /// The slot after all others, which absent operands refer to.
    Nothing,
}

impl Tape {
    /// The tape of a function of any level.
    ///
    /// # Panics
    ///
    /// Panics when the function is not well formed (the verifier accepts only
    /// those that are).
    pub fn new(function: &Function) -> Tape {
        let mut tape = Tape {
            operations: Vec::with_capacity(function.nodes().len()),
            operands: Vec::with_capacity(function.nodes().len()),
            outputs: Vec::with_capacity(function.assignments.len()),
            constants: function.constants().to_vec(),
            inputs: function.input_len(),
        };
        let nodes = function.nodes().len();
        let (inputs, total) = (tape.inputs, nodes + tape.inputs + tape.constants.len());
        let slot = |operand: Operand| -> u32 {
            let index = match operand.kind() {
                OperandKind::Value(value) => value.index(),
                OperandKind::Input(input) => nodes + input.index(),
                OperandKind::Constant(constant) => nodes + inputs + constant.index(),
                OperandKind::None => total,
            };
            // Entities are numbers below 2³⁰, so the sum of three fits.
            index as u32
        };
        for (index, node) in function.nodes().iter().enumerate() {
            let operands = node.operands.map(slot);
            let earlier = |&operand: &u32| (operand as usize) < index || operand as usize >= nodes;
            assert!(operands.iter().all(earlier), "operands are earlier nodes");
            tape.operations.push(node.operation);
            tape.operands.push(operands);
        }
        let assignments = function.assignments.iter();
        let outputs = assignments.map(|assignment| slot(assignment.operand));
        tape.outputs.extend(outputs);
        tape
    }

    /// The number of nodes of the function: their slots come first.
    #[inline]
    pub fn nodes(&self) -> usize {
        self.operations.len()
    }

    /// The number of input elements.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// The number of assignments.
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// The number of slots: nodes, inputs, constants, and one for absent
    /// operands, which always holds 0.
    #[inline]
    pub fn slots(&self) -> usize {
        self.nodes() + self.inputs + self.constants.len() + 1
    }

    /// The slot of an input element.
    pub fn input_slot(&self, input: Input) -> usize {
        self.nodes() + input.index()
    }

    /// The slot of a constant.
    pub fn constant_slot(&self, constant: Constant) -> usize {
        self.nodes() + self.inputs + constant.index()
    }

    /// The slot that an assignment reads, by its place in
    /// [`Function::assignments`].
    #[inline]
    pub fn output_slot(&self, assignment: usize) -> usize {
        self.outputs[assignment] as usize
    }

    /// The content of a slot.
    pub fn slot(&self, slot: usize) -> TapeSlot {
        let nodes = self.nodes();
        if slot < nodes {
            TapeSlot::Value(Value(slot as u32))
        } else if slot < nodes + self.inputs {
            TapeSlot::Input(Input((slot - nodes) as u32))
        } else if slot < self.slots() - 1 {
            TapeSlot::Constant(Constant((slot - nodes - self.inputs) as u32))
        } else {
            TapeSlot::Nothing
        }
    }

    /// The operation of a node.
    #[inline]
    pub fn operation(&self, node: usize) -> Operation {
        self.operations[node]
    }

    /// The slots that a node reads; absent operands read the last slot.
    #[inline]
    pub fn operands(&self, node: usize) -> [usize; 3] {
        self.operands[node].map(|operand| operand as usize)
    }

    /// The numbers of the literals, in order of their slots.
    pub fn constants(&self) -> &[f64] {
        &self.constants
    }

    /// The number in every slot, inputs and literals converted.
    ///
    /// # Panics
    ///
    /// Panics when there is not one number per input element.
    pub fn evaluate<A: Arithmetic>(&self, arithmetic: &A, inputs: &[f64]) -> Vec<A::Number> {
        let inputs = inputs.iter().map(|&number| arithmetic.literal(number));
        let literals = self.constants.iter();
        let literals = literals.map(|&number| arithmetic.literal(number));
        self.evaluate_numbers(arithmetic, inputs, literals)
    }

    /// The number in every slot, given those of the inputs and literals.
    ///
    /// # Panics
    ///
    /// Panics when there is not one number per input element and literal.
    pub fn evaluate_numbers<A: Arithmetic>(
        &self,
        arithmetic: &A,
        inputs: impl Iterator<Item = A::Number>,
        literals: impl Iterator<Item = A::Number>,
    ) -> Vec<A::Number> {
        let mut slots = Vec::with_capacity(self.slots());
        slots.resize(self.nodes(), arithmetic.literal(0.0));
        slots.extend(inputs);
        assert_eq!(
            slots.len(),
            self.nodes() + self.inputs,
            "one number per input element"
        );
        slots.extend(literals);
        slots.push(arithmetic.literal(0.0));
        assert_eq!(slots.len(), self.slots(), "one number per literal");
        for (node, (&operation, operands)) in self.operations.iter().zip(&self.operands).enumerate()
        {
            let operands = operands.map(|operand| slots[operand as usize]);
            slots[node] = arithmetic.apply(operation, operands);
        }
        slots
    }
}
