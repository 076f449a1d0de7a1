//! Inputs of a function, and functions with other inputs.

use super::{Element, element};
use crate::model::{Joint, Model};
use crate::motion::parameter;
use robovec_ir::{Function, Input, Operand, OperandKind, Tables, Value};

/// True when an input is a constant zero for the model.
pub(super) fn is_zero(model: &Model, (array, indices): &Element) -> bool {
    let rank = indices.iter().filter(|&&index| index > 0).count();
    let symbol = |has: fn(&Joint) -> bool| {
        let joint = indices[0].checked_sub(1);
        joint
            .and_then(|joint| model.joints.get(joint as usize))
            .is_some_and(|joint| !has(joint))
    };
    match array.as_str() {
        "qd" => symbol(|joint| joint.has_velocity),
        "qdd" => symbol(|joint| joint.has_acceleration),
        _ => parameter(model, array, &indices[..rank]) == Some(0.0),
    }
}

/// Replaces the inputs that are zero for the model by zero.
pub(super) fn zero(model: &Model, tables: &Tables, function: &mut Function) {
    let zeros: Vec<bool> = (0..function.input_len() as u32)
        .map(|input| is_zero(model, &element(tables, function, Input(input))))
        .collect();
    let constant = Operand::from(function.constant(0.0));
    replace(function, |input| zeros[input.index()].then_some(constant));
}

/// Generator 6.6 calls the law of a link again wherever its force is used
/// once; the results of equal calls are equal.
pub(super) fn merge_calls(original: &Function, tables: &Tables, function: &mut Function) {
    let calls = &original.boundaries;
    let first_of = |name: &str| {
        let call = calls
            .iter()
            .find(|call| call.result.as_deref() == Some(name))?;
        let mut equal = calls
            .iter()
            .filter(|other| other.callee == call.callee && other.arguments == call.arguments);
        equal.find_map(|other| other.result.as_deref())
    };
    let places: Vec<Option<Operand>> = (0..function.input_len() as u32)
        .map(|input| {
            let (array, ..) = function.input_element(Input(input));
            let first = first_of(tables.symbols.text(array.name))?;
            let mut arrays = function.inputs().iter();
            let target = arrays.find(|other| tables.symbols.text(other.name) == first)?;
            let within = input - array.offset;
            let there = (within as usize) < target.shape.len();
            there.then(|| Input(target.offset + within).into())
        })
        .collect();
    replace(function, |input| places[input.index()]);
}

/// Replaces inputs wherever they are used.
pub(super) fn replace(function: &mut Function, by: impl Fn(Input) -> Option<Operand>) {
    let replaced = |operand: Operand| match operand.kind() {
        OperandKind::Input(input) => by(input).unwrap_or(operand),
        _ => operand,
    };
    for index in 0..function.nodes().len() {
        let node = function.node_mut(Value(index as u32));
        node.operands = node.operands.map(replaced);
    }
    for assignment in &mut function.assignments {
        assignment.operand = replaced(assignment.operand);
    }
}
