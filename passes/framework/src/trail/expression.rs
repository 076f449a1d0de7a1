//! The computation of a value as one expression.
//!
//! From the atomic level on a definition is one operation, which states little.
//! So the values that belong to the same equation by their names and are used
//! nowhere else are written out, up to a length that can be read.

use hashbrown::HashMap;
use robovec_ir::print::{print_definition, print_output};
use robovec_ir::{Function, Level, Name, Node, Operand, Operation, SourceSet, Symbol, Value, View};
use rustc_hash::FxBuildHasher;

/// Number of named values that are written out at most.
const MAX_EXPANDED: usize = 40;

/// A definition with its values expanded.
pub(super) struct WrittenExpression {
    /// `%OM16 = q[1]*%C2 + %S`.
    pub(super) text: String,
    /// The names of the values written out, the outermost first.
    pub(super) inside: Vec<Name>,
}

/// The definition of a named value; `uses` are the function's
/// [`Function::use_counts`].
pub(super) fn of_value(view: View<'_>, uses: &[u32], value: Value) -> WrittenExpression {
    let node = view.function.node(value);
    let head = format!("%{}", node.name.display(&view.tables.symbols));
    ExpressionSketch::new(view, uses, node.name.base).write(&head, value.into())
}

/// The expression of an output; the value named after it is expanded.
pub(super) fn of_output(view: View<'_>, uses: &[u32], index: usize) -> WrittenExpression {
    let assignment = view.function.assignments[index];
    let head = print_output(view, assignment.output);
    let symbol = crate::rewrite::output_name(view, assignment.output);
    let symbol = view.tables.symbols.find(&symbol);
    let symbol = symbol.unwrap_or(Name::NONE.base);
    let own = assignment.operand.value().is_some_and(|value| {
        let name = view.function.node(value).name;
        name.is_none() || name.base == symbol
    });
    let sketch = ExpressionSketch::new(view, uses, symbol);
    if own {
        return sketch.write(&head, assignment.operand);
    }
    let operand = robovec_ir::print::print_operand(view, assignment.operand);
    WrittenExpression {
        text: format!("{head} = {operand}"),
        inside: Vec::new(),
    }
}

/// A function that consists of one expression, for the printer.
struct ExpressionSketch<'a> {
    view: View<'a>,
    uses: &'a [u32],
    /// The equation whose values are written out.
    symbol: Symbol,
    function: Function,
    map: HashMap<Value, Value, FxBuildHasher>,
}

impl<'a> ExpressionSketch<'a> {
    fn new(view: View<'a>, uses: &'a [u32], symbol: Symbol) -> ExpressionSketch<'a> {
        ExpressionSketch {
            view,
            uses,
            symbol,
            function: view.function.skeleton(Level::Equations),
            map: HashMap::default(),
        }
    }

    fn write(mut self, head: &str, root: Operand) -> WrittenExpression {
        let mut inside = Vec::new();
        if let Some(root) = root.value() {
            let mut order = self.tree(root, &mut inside);
            // Outermost first, left before right: reversed, operands come
            // before what reads them.
            order.reverse();
            for value in order {
                self.copy(value, Name::NONE);
            }
        }
        let operand = self.operand(root);
        let top = self.function.push(Node {
            name: Name::plain(Symbol(0)),
            sources: SourceSet::EMPTY,
            operands: Operand::list([operand]),
            operation: Operation::Copy,
        });
        let view = self.view.tables.view(&self.function);
        let printed = print_definition(view, top);
        let (_, expression) = printed
            .split_once(" = ")
            .expect("a printed definition has an equals sign");
        WrittenExpression {
            text: format!("{head} = {expression}"),
            inside,
        }
    }

    /// The values written out. Breadth first, so that a limit of the length
    /// removes the deepest parts.
    fn tree(&self, root: Value, inside: &mut Vec<Name>) -> Vec<Value> {
        let function = self.view.function;
        let mut order = vec![root];
        let mut next = 0;
        while let Some(&value) = order.get(next) {
            next += 1;
            for operand in function.node(value).operands() {
                let Some(inner) = operand.value() else {
                    continue;
                };
                let name = function.node(inner).name;
                let own = name.base == self.symbol && self.uses[inner.index()] == 1;
                if name.is_none() {
                    order.push(inner);
                } else if own && inside.len() < MAX_EXPANDED {
                    inside.push(name);
                    order.push(inner);
                }
            }
        }
        order
    }

    fn copy(&mut self, value: Value, name: Name) {
        let node = *self.view.function.node(value);
        let operands = node.operands.map(|operand| self.operand(operand));
        let copy = self.function.push(Node {
            name,
            sources: SourceSet::EMPTY,
            operands,
            operation: node.operation,
        });
        self.map.insert(value, copy);
    }

    /// An operand in the sketch; a value that is not written out is there
    /// under its name.
    fn operand(&mut self, operand: Operand) -> Operand {
        if let Some(number) = self.view.function.number(operand) {
            return self.function.constant(number).into();
        }
        let Some(value) = operand.value() else {
            return operand;
        };
        if let Some(&known) = self.map.get(&value) {
            return known.into();
        }
        let nothing = Operand::from(self.function.constant(0.0));
        let leaf = self.function.push(Node {
            name: self.view.function.node(value).name,
            sources: SourceSet::EMPTY,
            operands: Operand::list([nothing]),
            operation: Operation::Copy,
        });
        self.map.insert(value, leaf);
        leaf.into()
    }
}
