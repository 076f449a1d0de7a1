//! Whether a file of equations still belongs to its model.
//!
//! Equations are generated from a model and then live on their own: the model
//! is changed, a point added or a zero filled in, and the old files compile as
//! before and give wrong results. What such a file says about itself (project,
//! number of joints) catches few of these cases. So the model's equations are
//! generated again and compared with the file's as functions, at random points
//! of a prime field with the model's zeros filled in: equal ones are right for
//! the model whoever wrote them. Only when they differ does the comparison of
//! used parameters say why.

use crate::align::align;
use crate::generate::{FunctionKind, Options, Request, generate};
use crate::model::{Model, Point};
use crate::motion::parameter;
use robovec_ir::{Function, Input, Module, Operand, OperandKind, Place, Tables, Value, View};
use robovec_passes::NumericClass;
use robovec_passes::check::check;
use std::collections::BTreeMap;

/// Random points of the comparison. A wrong function passes one with a
/// probability of the equations' degree in 2^61.
const POINTS: u32 = 2;

/// No more parameters than this are named in one message.
const NAMED: usize = 6;

/// Something about a file of equations and a model.
#[derive(Clone, PartialEq, Debug)]
pub struct Finding {
    /// True when the file must be generated again; false for a remark.
    pub stale: bool,
    /// What was found, one sentence.
    pub message: String,
    /// Where it shows in the file of equations.
    pub place: Option<Place>,
    /// What it means, or what to do.
    pub help: String,
}

/// What is known of a file of equations after comparing it with a model.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Comparison {
    /// What was found.
    pub findings: Vec<Finding>,
    /// The functions that were proved to be those of the model.
    pub equal: Vec<String>,
}

impl Comparison {
    /// True when the file must be generated again.
    pub fn is_stale(&self) -> bool {
        self.findings.iter().any(|finding| finding.stale)
    }

    fn stale(&mut self, message: String, place: Option<Place>, help: &str) {
        self.findings.push(Finding {
            stale: true,
            message,
            place,
            help: help.to_owned(),
        });
    }

    fn remark(&mut self, message: String, place: Option<Place>, help: &str) {
        self.findings.push(Finding {
            stale: false,
            message,
            place,
            help: help.to_owned(),
        });
    }
}

/// Compares the functions of a file, as read, with a model.
pub fn compare(model: &Model, equations: &Module) -> Comparison {
    let mut comparison = Comparison::default();
    let Some(first) = equations.functions.first() else {
        return comparison;
    };
    identity(model, first, &mut comparison);
    if comparison.is_stale() {
        return comparison;
    }
    let mut cases = 0;
    for function in &equations.functions {
        if !in_range(model, equations, function, &mut comparison) {
            continue;
        }
        cases += 1;
        body(model, equations, function, &mut comparison);
    }
    let asked = model.sensors.len() + model.forces.len();
    if kind_of(first) == Some(FunctionKind::Sensor) && cases < asked && !comparison.is_stale() {
        comparison.stale(
            format!("the file has {cases} sensors, the model {asked}"),
            None,
            "sensors were added since; generate the file again",
        );
    }
    comparison
}

fn metadata<'a>(function: &'a Function, key: &str) -> Option<&'a str> {
    let found = function.metadata.iter().find(|(name, _)| name == key);
    found.map(|(_, value)| value.as_str())
}

fn kind_of(function: &Function) -> Option<FunctionKind> {
    FunctionKind::from_name(metadata(function, "kind")?)
}

/// What the file says about itself.
fn identity(model: &Model, function: &Function, comparison: &mut Comparison) {
    if let Some(name) = metadata(function, "model")
        && name != model.name
    {
        comparison.remark(
            format!(
                "the file belongs to project '{name}', the model is called '{}'",
                model.name
            ),
            None,
            "give the files of the model's own project, if there are any",
        );
    }
    let joints = metadata(function, "joints").and_then(|joints| joints.parse().ok());
    if let Some(joints) = joints.filter(|&joints: &usize| joints != model.joints.len()) {
        comparison.stale(
            format!(
                "the file is for {joints} joints, the model has {}",
                model.joints.len()
            ),
            None,
            "generate the file again",
        );
    }
}

/// An element of an array: name and indices from 1, absent ones 0.
type Element = (String, [u32; 2]);

/// The input elements that a function uses, each with the first place where it
/// does.
fn used(tables: &Tables, function: &Function) -> BTreeMap<Element, Option<Place>> {
    let mut used = BTreeMap::new();
    let operands = function.nodes().iter().flat_map(|node| {
        let sources = node.sources;
        node.operands()
            .iter()
            .map(move |&operand| (operand, sources))
    });
    let assigned = function.assignments.iter();
    let assigned = assigned.map(|assignment| (assignment.operand, assignment.sources));
    for (operand, sources) in operands.chain(assigned) {
        if let OperandKind::Input(input) = operand.kind() {
            let element = element(tables, function, input);
            let place = tables.sources.first(sources);
            used.entry(element).or_insert(place);
        }
    }
    used
}

fn element(tables: &Tables, function: &Function, input: Input) -> Element {
    let (array, indices, _) = function.input_element(input);
    (tables.symbols.text(array.name).to_owned(), indices)
}

/// What the last index of an array counts, and how many of them there are.
fn extent(model: &Model, array: &str) -> Option<(&'static str, usize)> {
    let rods = || {
        let rods = model.cuts.iter();
        rods.filter(|cut| matches!(cut.kind, crate::model::CutKind::Rod(_)))
            .count()
    };
    Some(match array {
        "q" | "qd" | "qdd" | "l" | "m" | "In" | "frc" | "trq" => ("joint", model.joints.len()),
        "dpt" => ("point", model.points.len()),
        "lrod" => ("rod", rods()),
        _ => return None,
    })
}

/// False, with a finding, when the function uses what the model does not have.
fn in_range(
    model: &Model,
    equations: &Module,
    function: &Function,
    comparison: &mut Comparison,
) -> bool {
    let used = used(&equations.tables, function);
    let beyond = used.iter().filter_map(|((array, indices), place)| {
        let (noun, count) = extent(model, array)?;
        let index = match *indices {
            [only, 0] => only,
            [_, last] => last,
        } as usize;
        (index > count).then_some((array, noun, index, count, *place))
    });
    let farthest = beyond.max_by_key(|&(_, _, index, count, _)| index - count);
    let Some((array, noun, index, count, place)) = farthest else {
        return true;
    };
    comparison.stale(
        format!(
            "'{}' uses {noun} {index} in {array}, but the model has {count}",
            function.name
        ),
        place,
        "generate the file again",
    );
    false
}

/// Generates the function again and compares.
fn body(model: &Model, equations: &Module, function: &Function, comparison: &mut Comparison) {
    let Some(kind) = kind_of(function) else {
        return;
    };
    let request = Request {
        options: Options {
            all_parameters: metadata(function, "all_parameter_symbols").is_some(),
            ..Options::default()
        },
        ..Request::new(kind)
    };
    let Ok(mut expected) = generate(model, &request) else {
        return;
    };
    // Python calls both kinds of sensor functions `sensor`.
    let case = metadata(function, "case");
    let found = expected
        .functions
        .iter()
        .position(|other| metadata(other, "case") == case);
    let Some(index) = found else {
        comparison.stale(
            format!("the model has nothing for '{}'", function.name),
            None,
            "a sensor was removed since; generate the file again",
        );
        return;
    };
    if function.nodes().is_empty() && function.assignments.is_empty() {
        if !expected.functions[index].assignments.is_empty() {
            comparison.stale(
                format!(
                    "'{}' is empty, but the model has equations for it",
                    function.name
                ),
                None,
                "something was added since; generate the file again",
            );
        }
        return;
    }
    match difference(model, equations, function, &mut expected, index) {
        None => {
            comparison.equal.push(function.name.clone());
            superfluous(
                model,
                equations,
                function,
                &expected.functions[index],
                comparison,
            );
        }
        Some(output) => reasons(
            model, equations, function, &expected, index, &output, comparison,
        ),
    }
}

/// The first output in which a function differs from the one expected; both
/// with the model's zeros filled in.
fn difference(
    model: &Model,
    equations: &Module,
    function: &Function,
    expected: &mut Module,
    index: usize,
) -> Option<String> {
    let mut tables = equations.tables.clone();
    let (mut one, mut other) = align(
        (function, &mut tables),
        (&expected.functions[index], &mut expected.tables),
    );
    merge_calls(function, &tables, &mut one);
    zero(model, &tables, &mut one);
    zero(model, &expected.tables, &mut other);
    // What only one of them has has nothing to be compared with: generator
    // 6.6 calls the forces of links otherwise.
    let declared = |tables: &Tables, function: &Function| -> Vec<String> {
        let outputs = function.outputs().iter();
        outputs
            .map(|array| tables.symbols.text(array.name).to_owned())
            .collect()
    };
    let common = declared(&equations.tables, function);
    let other_common = declared(&expected.tables, &expected.functions[index]);
    for (tables, aligned) in [(&tables, &mut one), (&expected.tables, &mut other)] {
        let outputs: Vec<bool> = aligned
            .assignments
            .iter()
            .map(|assignment| {
                let (array, ..) = aligned.output_element(assignment.output);
                let name = tables.symbols.text(array.name).to_owned();
                common.contains(&name) && other_common.contains(&name)
            })
            .collect();
        let mut keep = outputs.into_iter();
        aligned.assignments.retain(|_| keep.next().unwrap_or(true));
    }
    let verdict = check(
        View {
            tables: &tables,
            function: &one,
        },
        View {
            tables: &expected.tables,
            function: &other,
        },
        NumericClass::RealTrig,
        POINTS,
        1,
    );
    verdict.failure.map(|failure| failure.name)
}

/// True when an input is a constant zero for the model.
fn is_zero(model: &Model, (array, indices): &Element) -> bool {
    let rank = indices.iter().filter(|&&index| index > 0).count();
    let symbol = |has: fn(&crate::model::Joint) -> bool| {
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
fn zero(model: &Model, tables: &Tables, function: &mut Function) {
    let zeros: Vec<bool> = (0..function.input_len() as u32)
        .map(|input| is_zero(model, &element(tables, function, Input(input))))
        .collect();
    let constant = Operand::from(function.constant(0.0));
    replace(function, |input| zeros[input.index()].then_some(constant));
}

/// Generator 6.6 calls the law of a link again wherever its force is used
/// once; the results of equal calls are equal.
fn merge_calls(original: &Function, tables: &Tables, function: &mut Function) {
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
fn replace(function: &mut Function, by: impl Fn(Input) -> Option<Operand>) {
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

/// True when a function depends on an input that it uses: terms may cancel.
fn depends(tables: &Tables, function: &Function, on: &Element) -> bool {
    let mut without = function.clone();
    let constant = Operand::from(without.constant(0.0));
    let named = |input| element(tables, function, input) == *on;
    replace(&mut without, |input| named(input).then_some(constant));
    let view = |function| View { tables, function };
    !check(view(function), view(&without), NumericClass::RealTrig, 1, 1).holds()
}

/// A parameter as a user knows it.
fn describe(model: &Model, (array, indices): &Element) -> String {
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
                    let Point { name, body, .. } = point;
                    let body = body.map_or("base", |body| &model.bodies[body].name);
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

fn describe_all<'a>(model: &Model, elements: impl Iterator<Item = &'a Element>) -> String {
    let all: Vec<String> = elements.map(|element| describe(model, element)).collect();
    match all.len().checked_sub(NAMED) {
        Some(more @ 1..) => format!("{} and {more} more", all[..NAMED].join(", ")),
        _ => all.join(", "),
    }
}

/// Says why a function is not the model's.
fn reasons(
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
    let missing: Vec<&Element> = ours
        .keys()
        .filter(|key| !theirs.contains_key(key))
        .collect();
    let extra: Vec<&Element> = theirs
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
fn superfluous(
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
    let zeros: Vec<&Element> = theirs.keys().filter(|key| is_zero(model, key)).collect();
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

#[cfg(test)]
mod tests;
