//! Comparison of a file of equations with its model.
//!
//! Equations are generated from a model and then live on their own: the model
//! is changed, a point added or a zero filled in, and the old files compile as
//! before and give wrong results. The statements of such a file about itself
//! (project, number of joints) detect few of these cases. So the model's
//! equations are generated again and compared with the file's as functions, at
//! random points of a prime field with the model's zeros filled in: equal ones
//! are right for the model, from any writer. Only when they differ does the
//! comparison of used parameters show why.

mod explain;

pub use self::explain::zero;
use self::explain::{reasons, superfluous};
use crate::generate::{GenerationRequest, Options, generate};
use robovec_analysis::class::NumericClass;
use robovec_framework::check::check;
use robovec_ir::states::States;
use robovec_ir::{Function, Input, Module, OperandKind, SourcePlace, Tables, View};
use robovec_model::{CutKind, Model};
use robovec_robotran::FunctionKind;
use robovec_robotran::align::align;
use std::collections::BTreeMap;

/// Random points of the comparison, in each of two prime fields.
const POINTS: u32 = 2;

/// Something about a file of equations and a model.
#[derive(Clone, PartialEq, Debug)]
pub struct StaleFinding {
    /// True when the file must be generated again; false for a remark.
    pub stale: bool,
    /// Finding, one sentence.
    pub message: String,
    /// Place in the file of equations.
    pub place: Option<SourcePlace>,
    /// Meaning of it, or advice.
    pub help: String,
}

/// Result of comparing a file of equations with a model.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Comparison {
    /// Findings.
    pub findings: Vec<StaleFinding>,
    /// The functions that were proved to be those of the model.
    pub equal: Vec<String>,
}

impl Comparison {
    /// True when the file must be generated again.
    pub fn is_stale(&self) -> bool {
        self.findings.iter().any(|finding| finding.stale)
    }

    fn stale(&mut self, message: String, place: Option<SourcePlace>, help: &str) {
        self.findings.push(StaleFinding {
            stale: true,
            message,
            place,
            help: help.to_owned(),
        });
    }

    fn remark(&mut self, message: String, place: Option<SourcePlace>, help: &str) {
        self.findings.push(StaleFinding {
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

/// Identity that the file gives itself.
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
type ArrayElement = (String, [u32; 2]);

/// The input elements a function uses, each with the place of its first use.
fn used(tables: &Tables, function: &Function) -> BTreeMap<ArrayElement, Option<SourcePlace>> {
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

fn element(tables: &Tables, function: &Function, input: Input) -> ArrayElement {
    let (array, indices, _) = function.input_element(input);
    (tables.symbols.text(array.name).to_owned(), indices)
}

/// Meaning of the last index of an array, and its extent.
fn extent(model: &Model, array: &str) -> Option<(&'static str, usize)> {
    let rods = || {
        let rods = model.cuts.iter();
        rods.filter(|cut| matches!(cut.kind, CutKind::Rod(_)))
            .count()
    };
    Some(match array {
        "q" | "qd" | "qdd" | "l" | "m" | "In" | "frc" | "trq" => ("joint", model.joints.len()),
        "dpt" => ("point", model.points.len()),
        "lrod" => ("rod", rods()),
        _ => return None,
    })
}

/// False, with a finding, when the function uses an element the model lacks.
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
    if kind == FunctionKind::Accelred {
        // Its calls of the user's functions differ from generator to generator.
        return;
    }
    let request = GenerationRequest {
        options: Options {
            all_parameters: metadata(function, "all_parameter_symbols").is_some(),
            ..Options::default()
        },
        ..GenerationRequest::new(kind)
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
            format!("the model has no equations for '{}'", function.name),
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

/// The first output unlike the expected one, both with the model's zeros.
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
        aligned
            .assignments
            .retain(|_| keep.next().expect("every assignment has an entry"));
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
        &States::new(1),
        POINTS,
    );
    verdict.failure.map(|failure| failure.name)
}

#[cfg(test)]
mod tests;
