//! Common parts of the cases of a sensor file.

use robovec_ir::{Function, Node, OperandKind, Operation};

/// Number of nodes at the start that are the same in all cases of a sensor
/// file: the part that Robotran computes before the switch. It ends after a
/// definition.
pub(super) fn common_prefix(functions: &[&Function]) -> usize {
    let Some((&first, others)) = functions.split_first() else {
        return 0;
    };
    if functions
        .iter()
        .any(|function| !function.boundaries.is_empty())
    {
        return 0;
    }
    let same = |index: usize, node: &Node| {
        others.iter().all(|&other| {
            let twin = other.nodes().get(index);
            twin.is_some_and(|twin| same_node(first, node, other, twin))
        })
    };
    let alike = |&(index, node): &(usize, &Node)| match others {
        // Of a single case only what Robotran always puts there.
        [] => matches!(node.operation, Operation::Sin | Operation::Cos) && !node.name.is_none(),
        _ => same(index, node),
    };
    let nodes = first.nodes().iter().enumerate();
    let end = nodes.take_while(alike).count();
    let named = first.nodes()[..end]
        .iter()
        .rposition(|node| !node.name.is_none());
    let end = named.map_or(0, |last| last + 1);
    // Inner nodes of outputs stand behind all definitions; a prefix that
    // holds one would cut its expression in two.
    let mut used = vec![false; end];
    for node in &first.nodes()[..end] {
        for value in node.operands().iter().filter_map(|operand| operand.value()) {
            used[value.index()] = true;
        }
    }
    let whole = |(node, used): (&Node, &bool)| *used || !node.name.is_none();
    if first.nodes()[..end].iter().zip(&used).all(whole) {
        end
    } else {
        0
    }
}

fn same_node(a: &Function, left: &Node, b: &Function, right: &Node) -> bool {
    let mut pairs = left.operands().iter().zip(right.operands());
    left.operation == right.operation
        && left.name == right.name
        && pairs.all(|(&x, &y)| match (x.kind(), y.kind()) {
            (OperandKind::Value(x), OperandKind::Value(y)) => x == y,
            (OperandKind::Constant(x), OperandKind::Constant(y)) => {
                a.constant_number(x).to_bits() == b.constant_number(y).to_bits()
            }
            (OperandKind::Input(x), OperandKind::Input(y)) => {
                let (left, i, m) = a.input_element(x);
                let (right, j, n) = b.input_element(y);
                left.name == right.name && i[..m] == j[..n]
            }
            _ => false,
        })
}
