//! Backward slices: what a result depends on.

use robovec_ir::{Function, Operand, Value};

/// The values that the given operands depend on, themselves included, in
/// program order. Linear in the length of the function.
pub fn slice(function: &Function, roots: &[Operand]) -> Vec<Value> {
    let mut needed = vec![false; function.nodes().len()];
    for root in roots.iter().filter_map(|root| root.value()) {
        needed[root.index()] = true;
    }
    for (value, node) in function.values().rev() {
        if needed[value.index()] {
            for operand in node.operands().iter().filter_map(|operand| operand.value()) {
                needed[operand.index()] = true;
            }
        }
    }
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
        function.add_input(Symbols::new().intern("x"), Shape::Scalar);
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
