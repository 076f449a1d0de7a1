//! The verifier: the invariants of every function, after every pass.
//!
//! [`verify`] collects all violations instead of stopping at the first. It runs
//! after every pass, so it takes linear time (sorting aside) and few
//! allocations. Rules that depend on the machine are checked by
//! [`verify_placement`].
//!
//! # Invariants
//!
//! At every level:
//!
//! 1. The name of the function, the keys of its metadata and the names of its
//!    arrays are words: ASCII letters, digits and underscores, in parts
//!    joined by dots, not beginning with a digit.
//! 2. Input arrays have different names, and so have output arrays; inputs
//!    and outputs have at most 2^28 elements each.
//! 3. A node has as many operands as its operation takes; an operand is an
//!    earlier node, an input element or a constant that exists.
//! 4. Names are different; the symbol of a name is a word that does not
//!    itself end like a derived name (`x.1`), and its number is at most
//!    999,999,999.
//! 5. Constants are finite.
//! 6. Assignments are in order of the output elements, each assigned once; the
//!    assigned values exist. An output array with elements has at least one
//!    that is set.
//! 7. The result of a user call is an input array.
//!
//! At the level `equations`:
//!
//! 8. Nodes without a name are inner nodes of one expression: each is used
//!    exactly once, and they are in the order of evaluation, left operand
//!    first, right before the definition they belong to; those that belong
//!    to assignments are after all definitions. So the text determines
//!    the order of the nodes.
//! 9. An inner node has the sources of the definition or assignment that it
//!    belongs to.
//! 10. A copy is a definition, and copies no inner node.
//! 11. There are no times.
//!
//! From the level `atomic` on:
//!
//! 12. Every node has a name; there is no copy and no minus (`0 - x` instead).
//! 13. Times, when present, are there for every node; none is earlier than
//!     its operands allow or later than its users allow, and earliest does
//!     not come after latest.
//!
//! At the levels `scheduled` and `placed`, and only there:
//!
//! 14. There is a schedule with a slot for every node; the kinds of
//!     processing elements have different names of lower-case letters, none
//!     of them `host`.
//! 15. No processing element starts two operations in one cycle; an operation
//!     starts after those whose results it reads; the host evaluates nothing
//!     that needs a result of a processing element, and sine and cosine are
//!     evaluated by nothing else.
//! 16. All operations start before the end of the schedule, and the proved
//!     bound does not exceed its length.
//!
//! At the level `placed`, and only there:
//!
//! 17. There is a placement with addresses for every operand, writes for
//!     results of processing elements only, in order and after their issue,
//!     and with a buffer word only for a result that is written later than
//!     its first write could be.
//! 18. Words belong to processing elements; initial data is in order, one
//!     datum to a word, and known before the run.
//! 19. An output that is a result of a processing element has a word where it
//!     stays, and no other output has one.
//!
//! At every level:
//!
//! 20. Histories, when present, are there for every node and assignment and
//!     in the table of steps, and inner nodes of expressions have none.
//! 21. Formats of values, when present, are there for every node, are ones
//!     that can be computed in, and are not there at the level `equations`.

mod body;
mod formats;
mod header;
mod history;
mod names;
mod network;
mod placed;
mod placement;
mod replay;
mod schedule;
mod timing;

use crate::entity::{Constant, Operand, Value};
use crate::function::Level;
use crate::machine::Machine;
use crate::module::{Module, View};
use crate::print;
use placement::PlacementCheck;

/// The number of violations that are described; the rest is counted.
const MAX_DESCRIBED: usize = 100;

/// The subject of a violation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ViolationSubject {
    /// The function as a whole.
    Function,
    /// An input array, by its index in [`crate::Function::inputs`].
    Input(usize),
    /// An output array, by its index in [`crate::Function::outputs`].
    Output(usize),
    /// A user call, by its index in [`crate::Function::boundaries`].
    Boundary(usize),
    /// A constant.
    Constant(Constant),
    /// A node.
    Value(Value),
    /// An assignment, by its index in [`crate::Function::assignments`].
    Assignment(usize),
    /// A preload, by its index in [`crate::placement::Placement::preloads`].
    Preload(usize),
    /// The schedule as a whole.
    Schedule,
}

/// A broken invariant.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Violation {
    /// The subject.
    pub subject: ViolationSubject,
    /// A sentence that names it.
    pub message: String,
}

impl Violation {}

/// True when every function of a module is well-formed.
pub fn is_valid(module: &Module) -> bool {
    let tables = &module.tables;
    let mut functions = module.functions.iter();
    functions.all(|function| verify(View { tables, function }).is_empty())
}

/// Checks the invariants of the function's level. The result is empty for a
/// well-formed function. It holds at most 100 violations; when there are more,
/// a last entry gives their number.
pub fn verify(view: View<'_>) -> Vec<Violation> {
    let mut collector = ViolationCollector::new(view);
    header::check(&mut collector);
    if !body::check(&mut collector) {
        // With operands that do not exist nothing else can be looked up.
        return collector.finish();
    }
    names::check(&mut collector);
    timing::check(&mut collector);
    history::check(&mut collector);
    formats::check(&mut collector);
    let function = view.function;
    let level = function.level;
    if function.schedule.is_some() != (level >= Level::Scheduled) {
        let message = if level >= Level::Scheduled {
            format!("a function of the level {level} needs a schedule")
        } else {
            format!("a function of the level {level} has no schedule")
        };
        collector.add(ViolationSubject::Function, || message);
    }
    if function.placement.is_some() != (level == Level::Placed) {
        let message = if level == Level::Placed {
            "a placed function needs a placement".to_owned()
        } else {
            format!("a function of the level {level} has no placement")
        };
        collector.add(ViolationSubject::Function, || message);
    }
    if let Some(schedule) = &function.schedule
        && schedule::check(&mut collector, schedule)
        && let Some(placement) = &function.placement
    {
        placed::check(&mut collector, schedule, placement);
    }
    collector.finish()
}

/// Checks a placed function against its machine, after [`verify`] finds
/// nothing; the form of the result is the same.
///
/// 1. Every operation is on a kind of element that performs it, of the
///    machine's stages; memories have the machine's style.
/// 2. A result departs in its write-back cycle (`issue + stages + 1`) or,
///    if it is in a buffer, later, and is written as long after that as it
///    takes to the memory, over a crossbar at once; it is in a buffer only if
///    it departs later for one of its writes.
/// 3. Every operand is read from a word that holds it when the operation
///    starts, and every output stays in a word that holds it at the end.
/// 4. No memory takes more words in a cycle than the machine writes, and no
///    word is written twice in a cycle.
/// 5. A buffer word is not taken again before the cycle after its last read,
///    and a buffer hands out no more words in a cycle than the machine reads.
/// 6. No link of a network carries more words in a cycle than it can.
/// 7. Addresses and buffer words lie within the memories and buffers.
pub fn verify_placement(view: View<'_>, machine: &Machine) -> Vec<Violation> {
    let violations = verify(view);
    if !violations.is_empty() {
        return violations;
    }
    let mut collector = ViolationCollector::new(view);
    let function = view.function;
    let (Some(schedule), Some(placement)) = (&function.schedule, &function.placement) else {
        let message = || "only a placed function can be checked against a machine".to_owned();
        collector.add(ViolationSubject::Function, message);
        return collector.finish();
    };
    if let Some(check) = PlacementCheck::new(view, (schedule, placement), machine, &mut collector) {
        check.preloads(&mut collector);
        check.values(&mut collector);
        replay::check(&check, &mut collector);
        check.links(&mut collector);
    }
    collector.finish()
}

/// Violations up to the limit, and their number.
struct ViolationCollector<'a> {
    view: View<'a>,
    list: Vec<Violation>,
    total: usize,
}

impl<'a> ViolationCollector<'a> {
    fn new(view: View<'a>) -> ViolationCollector<'a> {
        ViolationCollector {
            view,
            list: Vec::new(),
            total: 0,
        }
    }

    fn add(&mut self, subject: ViolationSubject, message: impl FnOnce() -> String) {
        self.total += 1;
        if self.list.len() < MAX_DESCRIBED {
            let message = message();
            self.list.push(Violation { subject, message });
        }
    }

    /// A violation about a node; the message follows its name.
    fn value(&mut self, value: Value, message: impl FnOnce() -> String) {
        let view = self.view;
        self.add(ViolationSubject::Value(value), || {
            format!("{} {}", describe(view, value), message())
        });
    }

    /// A violation about an assignment; the message follows its output.
    fn assignment(&mut self, index: usize, message: impl FnOnce() -> String) {
        let view = self.view;
        self.add(ViolationSubject::Assignment(index), || {
            let output = view.function.assignments[index].output;
            let name = if output.index() < view.function.output_len() {
                print::print_output(view, output)
            } else {
                format!("output element {}", output.0)
            };
            format!("{name} {}", message())
        });
    }

    fn finish(mut self) -> Vec<Violation> {
        if self.total > self.list.len() {
            let rest = self.total - self.list.len();
            self.list.push(Violation {
                subject: ViolationSubject::Function,
                message: format!("{rest} further violations are not shown"),
            });
        }
        self.list
    }
}

/// True when no number occurs twice; all are below a bound.
fn all_differ(numbers: impl Iterator<Item = usize>, bound: usize) -> bool {
    let mut seen = vec![0u64; bound.div_ceil(64)];
    for number in numbers {
        let (word, bit) = (&mut seen[number / 64], 1 << (number % 64));
        if *word & bit != 0 {
            return false;
        }
        *word |= bit;
    }
    true
}

/// A value for a message: its name, or that of the definition that contains it.
fn describe(view: View<'_>, value: Value) -> String {
    let symbols = &view.tables.symbols;
    let name = |value: Value| {
        let name = view.function.node(value).name;
        if name.base.index() < symbols.len() {
            format!("%{}", name.display(symbols))
        } else {
            format!("node {}", value.0)
        }
    };
    if !view.function.node(value).name.is_none() {
        return name(value);
    }
    let count = view.function.nodes().len() as u32;
    let root = (value.0..count)
        .map(Value)
        .find(|&later| !view.function.node(later).name.is_none());
    let operation = view.function.node(value).operation.name();
    match root {
        Some(root) => format!("an inner '{operation}' before {}", name(root)),
        None => format!("an inner '{operation}' after all definitions"),
    }
}

/// An operand for a message.
fn describe_operand(view: View<'_>, operand: Operand) -> String {
    match operand.value() {
        Some(value) => describe(view, value),
        None => print::print_operand(view, operand),
    }
}

#[cfg(test)]
mod tests;
