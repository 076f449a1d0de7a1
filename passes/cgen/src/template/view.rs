//! The tree as a template reads it. Long lists make their items when the
//! template comes to them.

use super::tree::TargetTree;
use crate::c::layout::extents;
use minijinja::{Value as Seen, context};
use robovec_ir::{Input, Operand, OperandKind, Output, Shape};
use std::sync::Arc;

/// The names that a template finds.
pub(super) fn root(tree: TargetTree) -> Seen {
    let tree = &Arc::new(tree);
    let function = &tree.function;
    let arrays = function.inputs().iter().chain(function.outputs());
    let extent = arrays.flat_map(|array| extents(array.shape)).max();
    let side = |count: usize, is_output: bool| -> Seen {
        (0..count).map(|k| array(tree, is_output, k)).collect()
    };
    context! {
        name => tree.title.as_str(),
        source => function.name.as_str(),
        inputs => side(function.inputs().len(), false),
        outputs => side(function.outputs().len(), true),
        loads => list(tree, tree.read_inputs.len(), |tree, k| {
            let input = tree.read_inputs[k];
            let array = tree.function.input_array(input);
            let offset = input.0 - tree.function.inputs()[array].offset;
            element(tree, false, array, offset)
        }),
        constants => list(tree, tree.read_constants.len(), |tree, k| {
            let constant = tree.read_constants[k];
            context! {
                name => tree.constant_name(constant),
                number => tree.number(constant),
            }
        }),
        statements => list(tree, tree.statements.len(), statement),
        operations => tree.operations().into_iter().collect::<Seen>(),
        extent => extent.unwrap_or(1),
    }
}

/// A list of items made one by one.
fn list(
    tree: &Arc<TargetTree>,
    count: usize,
    item: impl Fn(&Arc<TargetTree>, usize) -> Seen + Copy + Send + Sync + 'static,
) -> Seen {
    let tree = Arc::clone(tree);
    Seen::make_iterable(move || {
        let tree = Arc::clone(&tree);
        (0..count).map(move |k| item(&tree, k))
    })
}

fn array(tree: &Arc<TargetTree>, is_output: bool, number: usize) -> Seen {
    let (arrays, names) = tree.arrays(is_output);
    let array = arrays[number];
    let [rows, columns] = extents(array.shape);
    context! {
        name => names[number].as_str(),
        shape => match array.shape {
            Shape::Scalar => "scalar",
            Shape::Vector(_) => "vector",
            Shape::Matrix(..) => "matrix",
        },
        rows,
        columns,
        count => array.shape.len(),
        offset => array.offset,
        elements => list(tree, array.shape.len(), move |tree, k| {
            element(tree, is_output, number, k as u32)
        }),
    }
}

fn element(tree: &Arc<TargetTree>, is_output: bool, number: usize, offset: u32) -> Seen {
    let all = tree.arrays(is_output).0[number].offset + offset;
    let [index, row, column] = tree.place(is_output, number, offset);
    let text = tree.element(is_output, number, offset);
    let array = array(tree, is_output, number);
    if is_output {
        let value = tree.operand(tree.assigned(Output(all))).text;
        let is_set = tree.set[all as usize].is_some();
        return context! { index, row, column, text, array, value, is_set };
    }
    let name = tree.element_name(Input(all));
    context! { index, row, column, text, array, name }
}

fn statement(tree: &Arc<TargetTree>, number: usize) -> Seen {
    let value = tree.statements[number];
    let node = tree.function.node(value);
    context! {
        name => tree.value_name(value),
        text => tree.expression(value).text,
        operation => node.operation.name(),
        operands => list(tree, node.operands().len(), move |tree, k| {
            operand(tree, tree.function.node(value).operands[k])
        }),
    }
}

fn operand(tree: &Arc<TargetTree>, operand: Operand) -> Seen {
    context! {
        text => tree.operand(operand).text,
        kind => match operand.kind() {
            OperandKind::Input(_) => "input",
            OperandKind::Constant(_) => "constant",
            OperandKind::Value(_) | OperandKind::None => "value",
        },
    }
}
