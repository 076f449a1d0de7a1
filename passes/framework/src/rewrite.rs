//! Rewriting a function: the common part of all passes that change the body.

use crate::rewrite_limit::RewriteLimit;
use robovec_analysis::slice::needed;
use robovec_ir::{
    Assignment, Function, Level, Node, Operand, OperandKind, Output, SourceSet, Symbol, Tables,
    Value, ValueFormats, View, print,
};

/// A function being written from another one, with the translation of the
/// old values.
pub struct Rewriter<'a> {
    /// The function read.
    pub old: &'a Function,
    /// The function written.
    pub new: Function,
    map: Vec<Operand>,
}

impl<'a> Rewriter<'a> {
    /// Starts an empty body at a level.
    pub fn new(old: &'a Function, level: Level) -> Rewriter<'a> {
        let mut new = old.skeleton(level);
        new.reserve(old.nodes().len());
        Rewriter {
            old,
            new,
            map: Vec::with_capacity(old.nodes().len()),
        }
    }

    /// As [`Rewriter::new`]; the values that are [kept](Rewriter::keep) keep
    /// their number formats too. For passes under which a format still means
    /// the same: without this the formats are gone, which the manager refuses.
    pub fn with_formats(old: &'a Function, level: Level) -> Rewriter<'a> {
        let mut rewriter = Rewriter::new(old, level);
        rewriter.new.formats = old.formats.as_ref().map(|_| ValueFormats::new(0));
        rewriter
    }

    /// As [`Rewriter::new`], for writing in another order: the translations
    /// are filled in by the caller ([`Rewriter::amend`]).
    pub fn unmapped(old: &'a Function, level: Level) -> Rewriter<'a> {
        let mut rewriter = Rewriter::new(old, level);
        rewriter.map = vec![Operand::NONE; old.nodes().len()];
        rewriter
    }

    /// The operand that an old one has become. Values must have been recorded.
    pub fn translate(&mut self, operand: Operand) -> Operand {
        match operand.kind() {
            OperandKind::Value(value) => {
                let known = self.map[value.index()];
                assert!(!known.is_none(), "an operand that is read was recorded");
                known
            }
            OperandKind::Constant(constant) => {
                let number = self.old.constant_number(constant);
                self.new.constant(number).into()
            }
            OperandKind::Input(_) | OperandKind::None => operand,
        }
    }

    /// The operands of a node, translated.
    pub fn translate_operands(&mut self, node: &Node) -> [Operand; Operand::MAX_COUNT] {
        // Written out: `map` of an array is a call for each operand.
        let [a, b, c] = node.operands;
        [self.translate(a), self.translate(b), self.translate(c)]
    }

    /// Records the successor of the next old value; called once per value, in
    /// order.
    pub fn record(&mut self, operand: Operand) {
        assert!(
            self.map.len() < self.old.nodes().len(),
            "every old value is recorded once"
        );
        self.map.push(operand);
    }

    /// Replaces the recorded successor of an old value.
    pub fn amend(&mut self, value: Value, operand: Operand) {
        self.map[value.index()] = operand;
    }

    /// The translation of an old value.
    pub fn known(&self, value: Value) -> Operand {
        self.map[value.index()]
    }

    /// Appends a node and records it for the next old value.
    pub fn keep(&mut self, node: Node) -> Value {
        let value = self.new.push(node);
        if let (Some(old), Some(new)) = (&self.old.formats, &mut self.new.formats) {
            new.resize(value.index() + 1);
            new.set(value, old.get(Value(self.map.len() as u32)));
        }
        self.record(value.into());
        value
    }

    /// Translates the outputs and gives up the new function.
    pub fn finish(mut self) -> Function {
        assert_eq!(
            self.map.len(),
            self.old.nodes().len(),
            "every old value was recorded"
        );
        let assignments: Vec<Assignment> = self
            .old
            .assignments
            .iter()
            .map(|&assignment| Assignment {
                operand: self.translate(assignment.operand),
                ..assignment
            })
            .collect();
        self.new.assignments = assignments;
        self.new
    }
}

/// The symbol an operation made for an output is named after: `M_1_2` for
/// `M[1,2]`, `sens_P_1` for `sens.P[1]`.
pub fn output_symbol(tables: &mut Tables, function: &Function, output: Output) -> Symbol {
    let symbol = output_name(View { tables, function }, output);
    tables.symbols.intern(&symbol)
}

/// The text of [`output_symbol`].
pub fn output_name(view: View<'_>, output: Output) -> String {
    let text = print::print_output(view, output);
    let mut symbol = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '[' | ',' | '.' => symbol.push('_'),
            ']' => {}
            other => symbol.push(other),
        }
    }
    symbol
}

/// For every node the symbol that its derived names start with: that of the
/// definition or output to whose expression it belongs.
pub fn owners(tables: &mut Tables, function: &Function) -> Vec<Symbol> {
    let unknown = Symbol(u32::MAX);
    let mut owners: Vec<Symbol> = function.nodes().iter().map(|node| node.name.base).collect();
    if !owners.contains(&unknown) {
        return owners;
    }
    for assignment in &function.assignments {
        if let Some(value) = assignment.operand.value()
            && owners[value.index()] == unknown
        {
            owners[value.index()] = output_symbol(tables, function, assignment.output);
        }
    }
    for (value, node) in function.values().rev() {
        for operand in node.operands().iter().filter_map(|operand| operand.value()) {
            if owners[operand.index()] == unknown {
                owners[operand.index()] = owners[value.index()];
            }
        }
    }
    owners
}

/// Puts the nodes of a function at the equations level in the order its text
/// implies: before each definition the inner nodes of its tree, left operand
/// before right, and those of the outputs at the end. Inner nodes take over
/// the sources of the definition or output they belong to.
pub fn lay_out(function: &Function) -> Function {
    let mut layout = ExpressionLayout {
        rewriter: Rewriter::unmapped(function, Level::Equations),
        open: Vec::new(),
    };
    for (value, node) in function.values() {
        if !node.name.is_none() {
            layout.tree(value, node.sources);
        }
    }
    for assignment in &function.assignments {
        if let Some(value) = assignment.operand.value()
            && function.node(value).name.is_none()
        {
            layout.tree(value, assignment.sources);
        }
    }
    layout.rewriter.finish()
}

struct ExpressionLayout<'a> {
    rewriter: Rewriter<'a>,
    /// Nodes to write, with a flag: true when their operands are written.
    open: Vec<(Value, bool)>,
}

impl ExpressionLayout<'_> {
    fn tree(&mut self, root: Value, sources: SourceSet) {
        self.open.push((root, false));
        while let Some((value, ready)) = self.open.pop() {
            let node = self.rewriter.old.node(value);
            if ready {
                let operands = self.rewriter.translate_operands(node);
                let written = self.rewriter.new.push(Node {
                    operands,
                    sources,
                    ..*node
                });
                self.rewriter.map[value.index()] = written.into();
                continue;
            }
            self.open.push((value, true));
            for operand in node.operands().iter().rev() {
                if let Some(inner) = operand.value()
                    && self.rewriter.old.node(inner).name.is_none()
                {
                    self.open.push((inner, false));
                }
            }
        }
    }
}

/// The function without the operations no output depends on.
pub fn without_dead(function: Function) -> Function {
    match remove_dead(&function, &RewriteLimit::default()) {
        Some((live, _)) => live,
        None => function,
    }
}

/// The function without the operations on which no output depends, and their
/// number; `None` when there are none. Tests before each removal.
pub fn remove_dead(function: &Function, rewrites: &RewriteLimit) -> Option<(Function, u64)> {
    let outputs = function.assignments.iter();
    let live = needed(
        function,
        outputs.map(|assignment| assignment.operand),
        |value| {
            let name = function.node(value).name;
            !name.is_none() && !rewrites.allow(name, "dead")
        },
    );
    let dead = live.iter().filter(|&&live| !live).count();
    if dead == 0 {
        return None;
    }
    let mut rewriter = Rewriter::with_formats(function, function.level);
    for (value, node) in function.values() {
        if live[value.index()] {
            let operands = rewriter.translate_operands(node);
            rewriter.keep(Node { operands, ..*node });
        } else {
            rewriter.record(Operand::NONE);
        }
    }
    Some((rewriter.finish(), dead as u64))
}
