//! In which order statements stand.
//!
//! A processor has some thirty registers; a value that is read long after it
//! was made has been to memory and back. Walking from each output down to
//! what it needs, and making the operand that needs most registers first
//! (Sethi and Ullman, 1970), puts values close to where they are read; what
//! is shared stands where it is read first. Outputs are taken from the last to
//! the first: those of the last bodies come first in a recursion from the
//! leaves of a tree to its root, which is what most of the operations are.

use super::Order;
use super::parts::Statement;
use robovec_ir::{Function, Operand, Value};

/// The statements of a function: definitions of the values that are live and
/// not inlined, and outputs. With `outputs_last` no output is written before
/// everything is computed.
pub(super) fn order(
    function: &Function,
    live: &[bool],
    inlined: &[bool],
    order: Order,
    outputs_last: bool,
) -> Vec<Statement> {
    let outputs = 0..function.assignments.len() as u32;
    match order {
        Order::Program => {
            let values = function.values().map(|(value, _)| value);
            let values = values.filter(|value| live[value.index()] && !inlined[value.index()]);
            let definitions = values.map(Statement::Define);
            definitions.chain(outputs.map(Statement::Assign)).collect()
        }
        Order::Depth => {
            let mut walk = Walk::new(function, inlined);
            for output in outputs.clone().rev() {
                walk.reach(function.assignments[output as usize].operand);
                if !outputs_last {
                    walk.statements.push(Statement::Assign(output));
                }
            }
            if outputs_last {
                walk.statements.extend(outputs.map(Statement::Assign));
            }
            walk.statements
        }
    }
}

/// A walk from outputs to what they need.
struct Walk<'a> {
    function: &'a Function,
    inlined: &'a [bool],
    /// For each value about how many registers its expression needs.
    needs: Vec<u32>,
    done: Vec<bool>,
    statements: Vec<Statement>,
    open: Vec<(Value, bool)>,
}

impl<'a> Walk<'a> {
    fn new(function: &'a Function, inlined: &'a [bool]) -> Walk<'a> {
        Walk {
            function,
            inlined,
            needs: needs(function),
            done: vec![false; inlined.len()],
            statements: Vec::with_capacity(inlined.len()),
            open: Vec::new(),
        }
    }

    /// Puts all that an operand needs behind the statements so far.
    fn reach(&mut self, operand: Operand) {
        self.open
            .extend(operand.value().map(|value| (value, false)));
        while let Some((value, entered)) = self.open.pop() {
            if self.done[value.index()] {
                continue;
            }
            if entered {
                self.done[value.index()] = true;
                if !self.inlined[value.index()] {
                    self.statements.push(Statement::Define(value));
                }
                continue;
            }
            self.open.push((value, true));
            let operands = self.function.node(value).operands().iter();
            let mut values: Vec<Value> = operands.filter_map(|operand| operand.value()).collect();
            // The last one pushed is walked first; among equals the left one.
            values.reverse();
            values.sort_by_key(|value| self.needs[value.index()]);
            self.open
                .extend(values.into_iter().map(|value| (value, false)));
        }
    }
}

/// About how many registers the expression of each value needs, as if nothing
/// were shared.
fn needs(function: &Function) -> Vec<u32> {
    let mut needs: Vec<u32> = Vec::with_capacity(function.nodes().len());
    for node in function.nodes() {
        let mut own: [u32; Operand::MOST] = [0; Operand::MOST];
        for (need, operand) in own.iter_mut().zip(node.operands()) {
            *need = operand.value().map_or(0, |value| needs[value.index()]);
        }
        own.sort_unstable_by(|a, b| b.cmp(a));
        let held = (0u32..).zip(own).filter(|&(_, need)| need > 0);
        needs.push(
            held.map(|(place, need)| place + need)
                .max()
                .unwrap_or(0)
                .max(1),
        );
    }
    needs
}
