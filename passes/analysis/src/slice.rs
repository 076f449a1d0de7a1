//! Backward slices: the values on which results depend.

use robovec_ir::{Function, Operand, Value};

/// For every node a flag: true when one of the operands depends on it, or a
/// kept node does; `keep` is called, from the last node to the first, for those
/// on which no operand depends. Linear in the length of the function.
pub fn needed(
    function: &Function,
    roots: impl IntoIterator<Item = Operand>,
    mut keep: impl FnMut(Value) -> bool,
) -> Vec<bool> {
    let mut needed = vec![false; function.nodes().len()];
    for root in roots.into_iter().filter_map(|root| root.value()) {
        needed[root.index()] = true;
    }
    for (value, node) in function.values().rev() {
        if needed[value.index()] || keep(value) {
            needed[value.index()] = true;
            for operand in node.operands().iter().filter_map(|operand| operand.value()) {
                needed[operand.index()] = true;
            }
        }
    }
    needed
}

/// For every node a flag: true when an output depends on it.
pub fn live(function: &Function) -> Vec<bool> {
    let outputs = function.assignments.iter();
    needed(
        function,
        outputs.map(|assignment| assignment.operand),
        |_| false,
    )
}

/// The values that the given operands depend on, themselves included, in
/// program order.
pub fn slice(function: &Function, roots: &[Operand]) -> Vec<Value> {
    let needed = needed(function, roots.iter().copied(), |_| false);
    function
        .values()
        .map(|(value, _)| value)
        .filter(|value| needed[value.index()])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::{Input, Level, Name, Node, Operation, Shape, SourceSet, Symbols};

    #[test]
    fn a_slice_holds_what_is_needed_and_nothing_else() {
        let mut function = Function::new("sample", Level::Atomic);
        function.add_input(Symbols::default().intern("x"), Shape::Scalar);
        let x = Operand::from(Input(0));
        let mut push = |a: Operand, b: Operand| {
            function.push(Node {
                name: Name::NONE,
                sources: SourceSet::EMPTY,
                operands: Operand::list([a, b]),
                operation: Operation::Mul,
            })
        };
        let first = push(x, x);
        let beside = push(x, first.into());
        let second = push(first.into(), first.into());
        push(beside.into(), second.into());
        assert_eq!(slice(&function, &[second.into(), x]), [first, second]);
        assert_eq!(slice(&function, &[x]), []);
    }
}
