//! The work of a processor on straight-line code, estimated.
//!
//! Operations alone do not rank programs of nearly the same size: values that
//! find no register are stored and loaded again, a product that only one sum
//! reads is fused with it, and of a divisor, a root, a sine far more is done.
//! Registers are given to values in program order, and the one whose next use
//! is farthest is given up (Belady 1966, which has the fewest loads for one
//! order); compilers move operations, so this is an estimate that ranks, and
//! times decide.

use robovec_ir::{Function, Operand, OperandKind, Operation};
use std::collections::BTreeSet;

/// Registers for numbers of x86-64 and its successors without AVX-512, less
/// two that results and constants pass through.
const REGISTERS: usize = 14;
/// The work of a load, beside that of an addition: most are a part of the
/// operation that reads the number.
const LOAD: f64 = 0.5;
/// The work of a store.
const STORE: f64 = 1.0;

/// The work of an operation in additions.
fn weight(operation: Operation) -> f64 {
    match operation {
        Operation::Copy => 0.0,
        Operation::Div => 6.0,
        Operation::Sqrt => 8.0,
        // The two of an angle are computed together.
        Operation::Sin | Operation::Cos => 25.0,
        _ => 1.0,
    }
}

/// The estimated work of one evaluation, in additions.
pub fn processor_work(function: &Function) -> f64 {
    let counts = function.use_counts();
    let mut registers = Registers::of(function);
    let mut work = 0.0;
    for (value, node) in function.values() {
        work += weight(node.operation);
        let is_sum = matches!(node.operation, Operation::Add | Operation::Sub);
        let fused = node.values().any(|operand| {
            let product = function.node(operand).operation == Operation::Mul;
            product && counts[operand.index()] == 1
        });
        if is_sum && fused {
            work -= weight(Operation::Mul);
        }
        for &operand in node.operands() {
            work += registers.read(operand, value.0);
        }
        work += registers.hold(Place::Value(value.0));
    }
    work + STORE * function.assignments.len() as f64
}

/// The content of a register.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Place {
    Value(u32),
    Input(u32),
    Constant(u32),
}

/// The registers and their contents.
struct Registers {
    /// The uses of each place, the last first.
    uses: [Vec<Vec<u32>>; 3],
    /// Values in registers, by their next use.
    held: BTreeSet<(u32, Place)>,
    /// Values that lie in memory already.
    stored: Vec<bool>,
}

/// The next use of a value that is no longer used.
const NEVER: u32 = u32::MAX;

impl Registers {
    fn of(function: &Function) -> Registers {
        let constants = function.nodes().iter().flat_map(|node| node.operands());
        let constants = constants.filter_map(|operand| operand.constant());
        let constants = constants.map(|constant| constant.index() + 1);
        let mut registers = Registers {
            uses: [
                vec![Vec::new(); function.nodes().len()],
                vec![Vec::new(); function.input_len()],
                vec![Vec::new(); constants.fold(0, usize::max)],
            ],
            held: BTreeSet::new(),
            stored: vec![false; function.nodes().len()],
        };
        for (value, node) in function.values().rev() {
            for place in node.operands().iter().copied().filter_map(place) {
                registers.uses_of(place).push(value.0);
            }
        }
        registers
    }

    fn uses_of(&mut self, place: Place) -> &mut Vec<u32> {
        match place {
            Place::Value(index) => &mut self.uses[0][index as usize],
            Place::Input(index) => &mut self.uses[1][index as usize],
            Place::Constant(index) => &mut self.uses[2][index as usize],
        }
    }

    /// The work of reading an operand at a time.
    fn read(&mut self, operand: Operand, time: u32) -> f64 {
        let Some(place) = place(operand) else {
            return 0.0;
        };
        let was_held = self.held.remove(&(time, place));
        let uses = self.uses_of(place);
        // An operation may read one place twice.
        while uses.last() == Some(&time) {
            uses.pop();
        }
        let load = if was_held { 0.0 } else { LOAD };
        load + self.hold(place)
    }

    /// The work of keeping a value for later use: that of storing the value
    /// which leaves its register.
    fn hold(&mut self, place: Place) -> f64 {
        let next = self.uses_of(place).last().copied().unwrap_or(NEVER);
        if next == NEVER {
            return 0.0;
        }
        self.held.insert((next, place));
        if self.held.len() <= REGISTERS {
            return 0.0;
        }
        match self.held.pop_last() {
            Some((_, Place::Value(index))) if !self.stored[index as usize] => {
                self.stored[index as usize] = true;
                STORE
            }
            _ => 0.0,
        }
    }
}

fn place(operand: Operand) -> Option<Place> {
    match operand.kind() {
        OperandKind::Value(value) => Some(Place::Value(value.0)),
        OperandKind::Input(input) => Some(Place::Input(input.0)),
        OperandKind::Constant(constant) => Some(Place::Constant(constant.index() as u32)),
        OperandKind::None => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::{Input, Level, Name, Node, Shape, SourceSet, Symbols, Value};

    fn sums(count: u32, read_again: bool) -> Function {
        let mut function = Function::new("sums", Level::Atomic);
        function.add_input(Symbols::default().intern("x"), Shape::Vector(count + 1));
        let mut push = |a: Operand, b: Operand| {
            function.push(Node {
                name: Name::NONE,
                sources: SourceSet::EMPTY,
                operands: Operand::list([a, b]),
                operation: Operation::Add,
            })
        };
        let first: Vec<Value> = (0..count)
            .map(|index| push(Input(index).into(), Input(index + 1).into()))
            .collect();
        if read_again {
            for pair in first.windows(2) {
                push(pair[0].into(), pair[1].into());
            }
        }
        function
    }

    #[test]
    fn values_beyond_the_registers_are_stored_and_loaded() {
        // Each input is loaded once and read twice while it is held.
        assert_eq!(processor_work(&sums(8, false)), 8.0 + 9.0 * LOAD);
        let few = processor_work(&sums(8, true));
        assert_eq!(few, 8.0 + 7.0 + 9.0 * LOAD);
        let many = processor_work(&sums(40, true));
        let spilled = many - (40.0 + 39.0 + 41.0 * LOAD);
        assert!(spilled > 20.0 * STORE, "{spilled}");
    }
}
