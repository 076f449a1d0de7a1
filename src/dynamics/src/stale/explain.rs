//! Differences of a function from its model, and functions with other inputs.

use super::{ArrayElement, Comparison, element, extent, metadata, used};
use crate::kinematics::parameter;
use robovec_analysis::class::NumericClass;
use robovec_framework::check::check;
use robovec_ir::states::States;
use robovec_ir::{Function, Input, Module, Operand, Tables, View};
use robovec_model::{Joint, Model, ModelPoint};
use robovec_robotran::align::replace;

/// No more parameters than this are named in one message.
const NAMED: usize = 6;

/// True when a function depends on an input that it uses: terms may cancel.
fn depends(tables: &Tables, function: &Function, on: &ArrayElement) -> bool {
    let mut without = function.clone();
    let constant = Operand::from(without.constant(0.0));
    let named = |input| element(tables, function, input) == *on;
    replace(&mut without, |input| named(input).then_some(constant));
    let view = |function| View { tables, function };
    !check(
        view(function),
        view(&without),
        NumericClass::RealTrig,
        &States::new(1),
        1,
    )
    .holds()
}

/// A parameter in a user's terms.
fn describe(model: &Model, (array, indices): &ArrayElement) -> String {
    let [first, second] = *indices;
    let name = match second {
        0 => format!("{array}[{first}]"),
        _ => format!("{array}[{first},{second}]"),
    };
    let of_body = |joint: u32| {
        let body = (joint as usize).checked_sub(1);
        body.filter(|&joint| joint < model.joints.len())
            .and_then(|joint| model.body_of(joint))
            .map(|body| format!("body {}", body.name))
    };
    let owner = match array.as_str() {
        "dpt" => {
            let point = (second as usize).checked_sub(1);
            point
                .and_then(|point| model.points.get(point))
                .map(|point| {
                    let ModelPoint { name, body, .. } = point;
                    let body = model.body_name(*body);
                    format!("point {name} of {body}")
                })
        }
        "l" | "In" => of_body(second),
        "m" => of_body(first),
        _ => None,
    };
    match owner {
        Some(owner) => format!("{name} ({owner})"),
        None => name,
    }
}

fn describe_all<'a>(model: &Model, elements: impl Iterator<Item = &'a ArrayElement>) -> String {
    let all: Vec<String> = elements.map(|element| describe(model, element)).collect();
    match all.len().checked_sub(NAMED) {
        Some(more @ 1..) => format!("{} and {more} more", all[..NAMED].join(", ")),
        _ => all.join(", "),
    }
}

/// Reports why a function is not the model's.
pub(super) fn reasons(
    model: &Model,
    equations: &Module,
    function: &Function,
    expected: &Module,
    index: usize,
    output: &str,
    comparison: &mut Comparison,
) {
    let name = &function.name;
    let theirs = used(&equations.tables, function);
    let ours = used(&expected.tables, &expected.functions[index]);
    let expected_function = &expected.functions[index];
    let missing: Vec<&ArrayElement> = ours
        .keys()
        .filter(|key| extent(model, &key.0).is_some() || key.0 == "g")
        .filter(|key| !theirs.contains_key(key))
        .filter(|key| depends(&expected.tables, expected_function, key))
        .collect();
    let extra: Vec<&ArrayElement> = theirs
        .keys()
        .filter(|key| !ours.contains_key(key) && is_zero(model, key))
        .collect();
    let mut explained = false;
    if !missing.is_empty() {
        explained = true;
        comparison.stale(
            format!(
                "'{name}' does not use {}, which the model needs",
                describe_all(model, missing.iter().copied())
            ),
            None,
            "a parameter that is zero when equations are generated is left out of them: changing \
             it has no effect until the file is generated again",
        );
    }
    if let Some(first) = extra.first() {
        explained = true;
        comparison.remark(
            format!(
                "'{name}' uses {}, which the model sets to zero",
                describe_all(model, extra.iter().copied())
            ),
            theirs.get(*first).copied().flatten(),
            "it had another value when the file was generated",
        );
    }
    if !explained || missing.is_empty() {
        comparison.stale(
            format!("'{name}' is not the model's: {output} differs"),
            None,
            "both use the same parameters; the type or order of joints, a parent or a point \
             changed since; generate the file again",
        );
    }
}

/// Remarks on parameters that a right file uses without need.
pub(super) fn superfluous(
    model: &Model,
    equations: &Module,
    function: &Function,
    expected: &Function,
    comparison: &mut Comparison,
) {
    if metadata(expected, "all_parameter_symbols").is_some() {
        return;
    }
    let theirs = used(&equations.tables, function);
    let zeros: Vec<&ArrayElement> = theirs.keys().filter(|key| is_zero(model, key)).collect();
    if let Some(first) = zeros.first() {
        comparison.remark(
            format!(
                "'{}' is right, but longer than needed: it uses {}, which the model sets to zero",
                function.name,
                describe_all(model, zeros.iter().copied())
            ),
            theirs.get(*first).copied().flatten(),
            "generate the file again to drop them, unless they change at run time",
        );
    }
}

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
