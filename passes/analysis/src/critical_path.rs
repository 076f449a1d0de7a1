//! The longest chain of operations.
//!
//! Whatever the number of processing elements, a program takes as long as its
//! longest chain of dependent operations. Counted in operations its length is
//! the thesis' ASAP, counted in cycles of a machine its ASAPCycle (thesis
//! 2.2.1). Times follow the convention of [`robovec_ir::Timing`]: the moment
//! a result is *available*, inputs and constants being available at 0. Sine,
//! cosine and copies weigh nothing, a minus weighs as the subtraction it
//! becomes ([`Machine::weight`]). Everything here is one sweep over the
//! function; sums saturate instead of overflowing.

use robovec_ir::{Function, Machine, Operation};

/// The weights that operations add to a chain.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Weights([u32; Operation::ALL.len()]);

impl Weights {
    /// Weights in cycles of a machine.
    pub fn cycles(machine: &Machine) -> Weights {
        Weights(Operation::ALL.map(|operation| machine.weight(operation)))
    }

    /// Weight 1 for every operation of a processing element, 0 for copies, sine
    /// and cosine.
    pub fn operations() -> Weights {
        Weights(Operation::ALL.map(|operation| match operation {
            Operation::Copy | Operation::Sin | Operation::Cos => 0,
            _ => 1,
        }))
    }

    /// The same, but additions and subtractions both have the weight of the
    /// slower of them: for sums whose signs are not decided yet.
    pub fn with_equal_sums(mut self) -> Weights {
        let [add, sub] = [Operation::Add, Operation::Sub].map(|operation| operation as usize);
        let weight = self.0[add].max(self.0[sub]);
        (self.0[add], self.0[sub]) = (weight, weight);
        self
    }

    /// The weight of one operation.
    #[inline]
    pub fn of(&self, operation: Operation) -> u32 {
        self.0[operation as usize]
    }
}

/// The length of the longest chain.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct CriticalPath {
    /// In operations.
    pub asap: u32,
    /// In cycles of the machine: when the last result is available.
    pub asap_cycle: u32,
}

/// The longest chain of a function, over all its nodes.
pub fn critical_path(function: &Function, machine: &Machine) -> CriticalPath {
    let path = |weights| longest(&arrivals(function, &weights));
    CriticalPath {
        asap: path(Weights::operations()),
        asap_cycle: path(Weights::cycles(machine)),
    }
}

/// The latest of some moments; 0 of none.
pub fn longest(moments: &[u32]) -> u32 {
    moments.iter().copied().fold(0, u32::max)
}

/// For each node the earliest moment its result is available.
pub fn arrivals(function: &Function, weights: &Weights) -> Vec<u32> {
    let mut arrivals: Vec<u32> = Vec::with_capacity(function.nodes().len());
    for node in function.nodes() {
        let ready = node
            .operands
            .map(|operand| operand.entry(&arrivals).copied());
        // What is no value is there from the start.
        let ready = ready.map(Option::unwrap_or_default);
        let ready = ready.into_iter().fold(0, u32::max);
        arrivals.push(ready.saturating_add(weights.of(node.operation)));
    }
    arrivals
}

/// For each node the longest chain that follows it, from the end of its
/// operation to the last result that depends on it. A node that nothing reads
/// has tail 0. The longest chain through a node is its arrival plus its tail.
pub fn tails(function: &Function, weights: &Weights) -> Vec<u32> {
    let mut tails = vec![0u32; function.nodes().len()];
    for (value, node) in function.values().rev() {
        let through = tails[value.index()].saturating_add(weights.of(node.operation));
        for operand in node.values() {
            let tail = &mut tails[operand.index()];
            *tail = (*tail).max(through);
        }
    }
    tails
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::{Input, Level, Name, Node, Operand, Shape, SourceSet, Symbols, Value};

    fn push(function: &mut Function, operation: Operation, a: Operand, b: Operand) -> Value {
        function.push(Node {
            name: Name::NONE,
            sources: SourceSet::EMPTY,
            operands: Operand::list([a, b]),
            operation,
        })
    }

    /// `-(sin(x)*y + x)`, and `x*y` beside it.
    fn sample() -> Function {
        let mut symbols = Symbols::default();
        let mut function = Function::new("sample", Level::Equations);
        function.add_input(symbols.intern("x"), Shape::Vector(2));
        let (x, y) = (Operand::from(Input(0)), Operand::from(Input(1)));
        let sine = push(&mut function, Operation::Sin, x, Operand::NONE);
        let product = push(&mut function, Operation::Mul, sine.into(), y);
        let sum = push(&mut function, Operation::Add, product.into(), x);
        push(&mut function, Operation::Neg, sum.into(), Operand::NONE);
        push(&mut function, Operation::Mul, x, y);
        function
    }

    #[test]
    fn the_longest_chain_weighs_sines_nothing_and_a_minus_as_a_subtraction() {
        let machine = Machine::built_in("thesis").expect("it ships");
        let path = critical_path(&sample(), &machine);
        assert_eq!((path.asap, path.asap_cycle), (3, 7 + 12 + 12));
    }

    #[test]
    fn arrivals_and_tails_meet_on_the_longest_chain() {
        let machine = Machine::built_in("thesis").expect("it ships");
        let weights = Weights::cycles(&machine);
        assert_eq!(arrivals(&sample(), &weights), [0, 7, 19, 31, 7]);
        assert_eq!(tails(&sample(), &weights), [31, 24, 12, 0, 0]);
    }

    #[test]
    fn an_empty_function_takes_no_time() {
        let machine = Machine::built_in("thesis").expect("it ships");
        let path = critical_path(&Function::new("empty", Level::Atomic), &machine);
        assert_eq!(path, CriticalPath::default());
    }
}
