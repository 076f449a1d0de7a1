//! The text of a function while it is written.

use super::expression::Printer;
use super::text::FileText;
use crate::Language;
use hashbrown::HashSet;
use robovec_ir::{Function, Node, OperandKind, Operation};
use rustc_hash::FxBuildHasher;

/// The text being written, with its running counts.
pub(super) struct FunctionText {
    pub(super) text: FileText,
    pub(super) printer: Printer,
    /// C's declarations of the temporaries, in order.
    pub(super) declarations: String,
    /// Definitions that several cases of a sensor file may have.
    known: HashSet<Box<str>, FxBuildHasher>,
    pub(super) section: BodySection,
}

/// Section under the title printed last.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Debug)]
pub(super) enum BodySection {
    Start,
    Trigonometry,
    Main,
    Outputs,
}

impl FunctionText {
    pub(super) fn new(language: Language) -> FunctionText {
        FunctionText {
            text: FileText::new(language),
            printer: Printer::default(),
            declarations: String::new(),
            known: HashSet::default(),
            section: BodySection::Start,
        }
    }

    /// Declares a temporary, for the header of C.
    pub(super) fn declare(&mut self, name: &str) {
        if self.text.language == Language::C {
            self.declarations.push_str("double    ");
            self.declarations.push_str(name);
            self.declarations.push_str(";\n");
        }
    }

    /// As [`FunctionText::declare`], for names that may be declared already.
    pub(super) fn declare_once(&mut self, name: &str) {
        if self.text.language == Language::C && !self.known.contains(name) {
            self.known.insert(name.into());
            self.declare(name);
        }
    }
}

/// Number of first nodes that all cases of a sensor file share, which Robotran
/// computes before the switch. It ends after a definition.
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
    // Inner nodes of outputs come after definitions; no prefix may cut them.
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
