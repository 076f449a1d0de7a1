//! A function made ready to be evaluated many times.
//!
//! [`evaluate`](crate::evaluate::evaluate) keeps the value of every node, which
//! for wide numbers (batches of double-double, derivatives) is far more memory
//! than a processor's caches hold. A [`EvaluationPlan`] keeps a place for a
//! value only until its last read, as a compiler allocates registers: the
//! working set is that of the values alive at a time, and places are reused
//! from one evaluation to the next. It also leaves out values on which no
//! wanted output depends.
//!
//! **Invariant.** A place is written by a step only after the last step that
//! reads its earlier content; places of inputs, literals and outputs are never
//! reused.

use crate::entity::{Operand, OperandKind, Value};
use crate::function::Function;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::operation::Operation;

/// The steps of a function with places for its values.
#[derive(Clone, Debug)]
pub struct EvaluationPlan {
    steps: Vec<EvaluationStep>,
    /// Number of input elements; their places come first.
    inputs: usize,
    /// Literals, after the inputs; the last is a zero for absent operands.
    literals: Vec<f64>,
    /// Places of all kinds.
    places: usize,
    /// The places of the wanted outputs, in order of the assignments.
    outputs: Vec<u32>,
}

/// One operation.
#[derive(Clone, Copy, Debug)]
struct EvaluationStep {
    operation: Operation,
    operands: [u32; 3],
    result: u32,
}

/// Lifetime of a value.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lifetime {
    /// No requested value needs it.
    Unused,
    /// Until this node, the last that reads it.
    Until(Value),
    /// To the end: it is an output.
    Forever,
}

impl EvaluationPlan {
    /// The plan of all outputs.
    pub fn new(function: &Function) -> EvaluationPlan {
        EvaluationPlan::of(function, |_| true)
    }

    /// The plan of the assignments, counted from 0, that are wanted.
    pub fn of(function: &Function, wanted: impl Fn(usize) -> bool) -> EvaluationPlan {
        let assignments = function.assignments.iter().enumerate();
        let wanted: Vec<Operand> = assignments
            .filter(|(index, _)| wanted(*index))
            .map(|(_, assignment)| assignment.operand)
            .collect();
        let lifetimes = lifetimes(function, &wanted);
        let mut literals: Vec<f64> = function.constants().to_vec();
        literals.push(0.0);
        let inputs = function.input_len();
        let fixed = inputs + literals.len();
        let mut plan = EvaluationPlan {
            steps: Vec::with_capacity(function.nodes().len()),
            inputs,
            literals,
            places: fixed,
            outputs: Vec::new(),
        };
        let mut free: Vec<u32> = Vec::new();
        let mut place: Vec<Option<u32>> = vec![None; function.nodes().len()];
        for (value, node) in function.values() {
            if lifetimes[value.index()] == Lifetime::Unused {
                continue;
            }
            let operands = node.operands.map(|operand| plan.place(&place, operand));
            for (position, operand) in node.operands().iter().enumerate() {
                let Some(read) = operand.value() else {
                    continue;
                };
                // An operand that is read twice by one step is freed once.
                let again = node.operands()[..position].contains(operand);
                if lifetimes[read.index()] == Lifetime::Until(value) && !again {
                    free.extend(place[read.index()]);
                }
            }
            let result = free.pop().unwrap_or_else(|| {
                plan.places += 1;
                plan.places as u32 - 1
            });
            assert!(
                result as usize >= fixed,
                "inputs and literals keep their places"
            );
            place[value.index()] = Some(result);
            plan.steps.push(EvaluationStep {
                operation: node.operation,
                operands,
                result,
            });
        }
        plan.outputs = wanted
            .iter()
            .map(|&operand| plan.place(&place, operand))
            .collect();
        plan
    }

    fn place(&self, places: &[Option<u32>], operand: Operand) -> u32 {
        match operand.kind() {
            OperandKind::Value(value) => {
                places[value.index()].expect("an operand has a place before it is read")
            }
            OperandKind::Input(input) => input.0,
            OperandKind::Constant(constant) => self.inputs as u32 + constant.0,
            OperandKind::None => (self.inputs + self.literals.len()) as u32 - 1,
        }
    }

    /// The number of operations.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// True when nothing is computed.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// The values of the wanted outputs. The memory is reused when it is
    /// handed in again, and need not be that of the same plan.
    ///
    /// # Panics
    ///
    /// Panics when `inputs` is not as long as the function's inputs.
    pub fn run<A: Arithmetic>(
        &self,
        arithmetic: &A,
        inputs: &[A::Number],
        memory: &mut Vec<A::Number>,
    ) -> Vec<A::Number> {
        let literals = self.literals.iter();
        let literals = literals.map(|&number| arithmetic.literal(number));
        self.run_numbers(arithmetic, inputs, literals, memory)
    }

    /// The numbers of the literals that an evaluation needs.
    pub fn literals(&self) -> &[f64] {
        &self.literals
    }

    /// The values of the wanted outputs as in [`EvaluationPlan::run`], with
    /// numbers for the [literals](EvaluationPlan::literals).
    ///
    /// # Panics
    ///
    /// Panics when there are not as many inputs as the function has, or not as
    /// many literals.
    pub fn run_numbers<A: Arithmetic>(
        &self,
        arithmetic: &A,
        inputs: &[A::Number],
        literals: impl Iterator<Item = A::Number>,
        memory: &mut Vec<A::Number>,
    ) -> Vec<A::Number> {
        memory.clear();
        memory.extend_from_slice(inputs);
        self.steps(inputs.len(), literals, memory, |operation, operands| {
            arithmetic.apply_read(operation, operands)
        })
    }

    /// The values of the wanted outputs in numbers that are not copied, such as
    /// those of arbitrary precision: `literal` makes the number of an input or
    /// literal, `apply` does an operation on its operands.
    ///
    /// # Panics
    ///
    /// Panics when `inputs` is not as long as the function's inputs.
    pub fn run_with<T: Clone>(
        &self,
        inputs: &[f64],
        mut literal: impl FnMut(f64) -> T,
        apply: impl FnMut(Operation, [&T; 3]) -> T,
    ) -> Vec<T> {
        let mut memory: Vec<T> = inputs.iter().map(|&number| literal(number)).collect();
        let literals = self.literals.iter().map(|&number| literal(number));
        self.steps(inputs.len(), literals, &mut memory, apply)
    }

    /// Carries out all steps in a memory that holds the inputs.
    #[inline]
    fn steps<T: Clone>(
        &self,
        inputs: usize,
        literals: impl Iterator<Item = T>,
        memory: &mut Vec<T>,
        mut apply: impl FnMut(Operation, [&T; 3]) -> T,
    ) -> Vec<T> {
        assert_eq!(inputs, self.inputs, "one number per input element");
        memory.extend(literals);
        let fixed = self.inputs + self.literals.len();
        assert_eq!(memory.len(), fixed, "one number per literal");
        // Any number; a place is written before it is read.
        memory.resize(self.places, memory[fixed - 1].clone());
        for step in &self.steps {
            let operands = step.operands.map(|place| &memory[place as usize]);
            memory[step.result as usize] = apply(step.operation, operands);
        }
        let outputs = self.outputs.iter();
        outputs
            .map(|&place| memory[place as usize].clone())
            .collect()
    }
}

/// Lifetime of the value of each node.
fn lifetimes(function: &Function, wanted: &[Operand]) -> Vec<Lifetime> {
    let mut lifetimes = vec![Lifetime::Unused; function.nodes().len()];
    for value in wanted.iter().filter_map(|operand| operand.value()) {
        lifetimes[value.index()] = Lifetime::Forever;
    }
    for (reader, node) in function.values().rev() {
        if lifetimes[reader.index()] == Lifetime::Unused {
            continue;
        }
        for value in node.operands().iter().filter_map(|operand| operand.value()) {
            let lifetime = &mut lifetimes[value.index()];
            if *lifetime == Lifetime::Unused {
                *lifetime = Lifetime::Until(reader);
            }
        }
    }
    lifetimes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::evaluate;
    use crate::parse::parse_module;
    use robovec_num::arithmetic::Binary64;

    const TEXT: &str = "function f atomic {
      in x[1..3]
      out o[1..5]
      %a = x[1]*x[2]
      %b = %a+%a
      %c = %b*x[3]
      %d = sin(%c)
      %e = %d*%d
      %f = %e-0.25
      %g = fma(%f, %c, %b)
      %h = %a/%g
      %dead = %h*%h
      %i = sqrt(%e)
      o[1] = %g
      o[2] = %i
      o[3] = x[2]
      o[4] = 1.5
      o[5] = %g
    }";

    #[test]
    fn a_plan_computes_what_the_evaluator_does_in_fewer_places() {
        let module = parse_module("plan", TEXT).expect("it is well formed");
        let function = &module.functions[0];
        let inputs = [0.75, -1.25, 3.0];
        let expected = evaluate(function, &Binary64, &inputs);
        let plan = EvaluationPlan::new(function);
        let mut memory = Vec::new();
        assert_eq!(plan.run(&Binary64, &inputs, &mut memory), expected);
        assert_eq!(plan.run(&Binary64, &inputs, &mut memory), expected);
        let owned = plan.run_with(
            &inputs,
            |number| number,
            |operation, [a, b, c]| match operation {
                Operation::Add => a + b,
                Operation::Sub => a - b,
                Operation::Mul => a * b,
                Operation::Sin => a.sin(),
                Operation::Sqrt => a.sqrt(),
                Operation::Fma => a.mul_add(*b, *c),
                other => unreachable!("{other:?} is not in the function"),
            },
        );
        assert_eq!(owned, expected);
        // Neither the quotient nor its square is needed.
        assert_eq!(plan.len(), function.nodes().len() - 2);
        assert!(plan.places < 3 + 2 + 6);
    }

    #[test]
    fn a_plan_of_some_outputs_leaves_out_the_rest() {
        let module = parse_module("plan", TEXT).expect("it is well formed");
        let function = &module.functions[0];
        let inputs = [0.75, -1.25, 3.0];
        let expected = evaluate(function, &Binary64, &inputs);
        let plan = EvaluationPlan::of(function, |index| index == 1 || index == 3);
        let outputs = plan.run(&Binary64, &inputs, &mut Vec::new());
        assert_eq!(outputs, [expected[1], expected[3]]);
        assert_eq!(plan.len(), 6);
        let nothing = EvaluationPlan::of(function, |index| index == 2);
        assert!(nothing.is_empty());
        assert_eq!(
            nothing.run(&Binary64, &inputs, &mut Vec::new()),
            [expected[2]]
        );
    }
}
