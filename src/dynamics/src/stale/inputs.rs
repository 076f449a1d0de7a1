//! Inputs of a function, and functions with other inputs.

use super::{ArrayElement, element};
use crate::kinematics::parameter;
use robovec_ir::{Function, Input, Operand, Tables};
use robovec_model::{Joint, Model};
use robovec_robotran::align::replace;

/// True when an input is a constant zero for the model.
pub(super) fn is_zero(model: &Model, (array, indices): &ArrayElement) -> bool {
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
pub fn zero(model: &Model, tables: &Tables, function: &mut Function) {
    let zeros: Vec<bool> = (0..function.input_len() as u32)
        .map(|input| is_zero(model, &element(tables, function, Input(input))))
        .collect();
    let constant = Operand::from(function.constant(0.0));
    replace(function, |input| zeros[input.index()].then_some(constant));
}
