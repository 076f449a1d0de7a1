//! Invariants 3, 6, 8 to 10 and 12: nodes, expressions, assignments.

use super::{ViolationCollector, ViolationSubject, describe_operand};
use crate::entity::{Operand, Output, Value};
use crate::function::{Array, Level, Node};
use crate::source::SourceSet;
use robovec_num::operation::Operation;

/// True when every operand exists.
pub(super) fn check(collector: &mut ViolationCollector<'_>) -> bool {
    let sound = operands(collector);
    let sound = assignments(collector) && sound;
    if !sound {
        return false;
    }
    if collector.view.function.level == Level::Equations {
        expressions(collector);
    } else {
        atomic(collector);
    }
    true
}

/// The limits for operands of a node.
struct Bounds {
    /// By kind, as [`Operand::parts`] numbers them; none has no index.
    limits: [usize; 4],
}

impl Bounds {
    fn of(collector: &ViolationCollector<'_>) -> Bounds {
        let function = collector.view.function;
        let (inputs, constants) = (function.input_len(), function.constants().len());
        Bounds {
            limits: [function.nodes().len(), inputs, constants, 0],
        }
    }

    /// Lets only the first values be operands.
    fn with_values(&mut self, values: usize) -> &Bounds {
        self.limits[0] = values;
        self
    }

    fn holds(&self, operand: Operand) -> bool {
        let (kind, index) = operand.parts();
        index < self.limits[kind]
    }
}

fn operands(collector: &mut ViolationCollector<'_>) -> bool {
    let mut bounds = Bounds::of(collector);
    let mut sound = true;
    for (value, node) in collector.view.function.values() {
        let earlier = bounds.with_values(value.index());
        let arity = node.operation.arity();
        let fits = |place: usize| {
            if place < arity {
                earlier.holds(node.operands[place])
            } else {
                node.operands[place].is_none()
            }
        };
        if !(0..Operand::MAX_COUNT).all(fits) {
            sound = false;
            let given = node.operands.iter().filter(|operand| !operand.is_none());
            let given: Vec<&Operand> = given.collect();
            let operation = node.operation.name();
            collector.value(value, || {
                format!(
                    "('{operation}') does not read {} earlier values, inputs or constants: {given:?}",
                    node.operation.arity()
                )
            });
        }
    }
    sound
}

fn assignments(collector: &mut ViolationCollector<'_>) -> bool {
    let bounds = Bounds::of(collector);
    let function = collector.view.function;
    let elements = function.output_len();
    let mut sound = true;
    let mut last: Option<Output> = None;
    for (index, assignment) in function.assignments.iter().enumerate() {
        if assignment.output.index() >= elements {
            sound = false;
            collector.assignment(index, || format!("is beyond the {elements} that exist"));
            continue;
        }
        if last == Some(assignment.output) {
            collector.assignment(index, || "is set twice".to_owned());
        } else if last > Some(assignment.output) {
            collector.assignment(index, || "is set out of order".to_owned());
        }
        last = Some(assignment.output);
        if !bounds.holds(assignment.operand) {
            sound = false;
            let operand = assignment.operand;
            collector.assignment(index, || {
                format!("is set to {operand:?}, which does not exist")
            });
        }
    }
    outputs(collector);
    sound
}

fn outputs(collector: &mut ViolationCollector<'_>) {
    let view = collector.view;
    let arrays = view.function.outputs();
    let end = |array: &Array| array.offset as usize + array.shape.len();
    let mut set = vec![false; arrays.len()];
    for assignment in &view.function.assignments {
        let element = assignment.output.index();
        let array = arrays.partition_point(|array| end(array) <= element);
        if let Some(set) = set.get_mut(array) {
            *set = true;
        }
    }
    for (index, array) in arrays.iter().enumerate() {
        if !set[index] && !array.shape.is_empty() && array.name.index() < view.tables.symbols.len()
        {
            let name = view.tables.symbols.text(array.name);
            let message = || format!("no element of the output array '{name}' is ever set");
            collector.add(ViolationSubject::Output(index), message);
        }
    }
}

fn atomic(collector: &mut ViolationCollector<'_>) {
    let level = collector.view.function.level;
    for (value, node) in collector.view.function.values() {
        if node.name.is_none() {
            collector.value(value, || {
                format!("has no name: at the level {level} a definition is one operation")
            });
        }
        match node.operation {
            Operation::Copy => collector.value(value, || {
                format!("is a copy, which the level {level} does not have")
            }),
            Operation::Neg => collector.value(value, || {
                format!("is a minus, which the level {level} does not have; it is written 0 - x")
            }),
            _ => {}
        }
    }
}

/// Checks inner nodes with a stack of those not yet used: the operands of an
/// operation must be on top, and a definition must leave the stack empty.
fn expressions(collector: &mut ViolationCollector<'_>) {
    let function = collector.view.function;
    let named: Vec<bool> = function
        .nodes()
        .iter()
        .map(|node| !node.name.is_none())
        .collect();
    let mut open: Vec<Value> = Vec::new();
    let mut first = 0;
    for (value, node) in function.values() {
        for &operand in node.operands().iter().rev() {
            if let Some(inner) = operand.value().filter(|inner| !named[inner.index()]) {
                take(collector, &mut open, inner, value);
            }
        }
        copy(collector, value, node, &named);
        if named[value.index()] {
            for left in open.drain(..) {
                collector.value(left, || "is not used by the definition after it".to_owned());
            }
            sources(collector, first..value.0, node.sources);
            first = value.0 + 1;
        } else {
            open.push(value);
        }
    }
    trees_of_assignments(collector, &open, &named, first);
}

fn take(collector: &mut ViolationCollector<'_>, open: &mut Vec<Value>, inner: Value, user: Value) {
    if open.last() == Some(&inner) {
        open.pop();
        return;
    }
    let view = collector.view;
    if let Some(at) = open.iter().rposition(|&other| other == inner) {
        open.remove(at);
        collector.value(inner, || {
            let user = super::describe(view, user);
            format!("is not in the order of evaluation of {user}")
        });
    } else {
        collector.value(inner, || {
            let user = super::describe(view, user);
            format!("is used more than once or by another definition, {user}")
        });
    }
}

fn copy(collector: &mut ViolationCollector<'_>, value: Value, node: &Node, named: &[bool]) {
    if node.operation != Operation::Copy {
        return;
    }
    let copied = node.operands[0];
    if !named[value.index()] {
        collector.value(value, || "is a copy, which must be a definition".to_owned());
    }
    if copied.value().is_some_and(|inner| !named[inner.index()]) {
        let view = collector.view;
        collector.value(value, || {
            format!("copies {}", describe_operand(view, copied))
        });
    }
}

fn sources(collector: &mut ViolationCollector<'_>, inner: std::ops::Range<u32>, set: SourceSet) {
    for value in inner.map(Value) {
        if collector.view.function.node(value).sources != set {
            collector.value(value, || {
                "has other sources than what it belongs to".to_owned()
            });
        }
    }
}

/// The expressions of assignments: the nodes still open after the definitions,
/// in the order of the assignments.
fn trees_of_assignments(
    collector: &mut ViolationCollector<'_>,
    open: &[Value],
    named: &[bool],
    mut first: u32,
) {
    let function = collector.view.function;
    let mut roots = open.iter().copied().peekable();
    for (index, assignment) in function.assignments.iter().enumerate() {
        let Some(root) = assignment.operand.value() else {
            continue;
        };
        if named[root.index()] {
            continue;
        }
        if roots.next_if_eq(&root).is_some() {
            sources(collector, first..root.0 + 1, assignment.sources);
            first = root.0 + 1;
        } else {
            collector.assignment(index, || {
                "is set to an expression that is not in the order of the outputs".to_owned()
            });
        }
    }
    for root in roots {
        collector.value(root, || "is used by nothing".to_owned());
    }
}
