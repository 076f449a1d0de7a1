//! A file as the grammar sees it: a flat arena of expression nodes and a flat
//! list of statements.
//!
//! Invariant: the nodes of an expression stand in one run of the arena, every
//! operand before its user. Lowering is therefore one loop over the run.

use super::token::{Element, Name, Span};
use robovec_ir::{Operation, Symbol};

/// What an expression reads, packed into 32 bits.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Leaf(u32);

/// A [`Leaf`] taken apart.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum LeafKind {
    /// The result of a node of the arena.
    Node(u32),
    /// An entry of [`Syntax::elements`].
    Element(u32),
    /// An entry of [`Syntax::numbers`].
    Number(u32),
    /// A bare name.
    Scalar(Name),
}

const KIND_SHIFT: u32 = 30;
const PAYLOAD: u32 = (1 << KIND_SHIFT) - 1;
const ELEMENT: u32 = 1 << KIND_SHIFT;
const NUMBER: u32 = 2 << KIND_SHIFT;
const SCALAR: u32 = 3 << KIND_SHIFT;
const SCALAR_OF_DATA: u32 = 1 << 29;

/// The largest number of nodes, elements, literals or names of a file; a text
/// within the size limit of the reader has fewer.
pub(super) const CAPACITY: usize = 1 << 29;

impl Leaf {
    /// The absent second operand.
    pub(super) const NONE: Leaf = Leaf(u32::MAX);

    pub(super) fn scalar(name: Name) -> Leaf {
        let of_data = if name.is_of_data() { SCALAR_OF_DATA } else { 0 };
        Leaf(SCALAR | of_data | name.symbol().0)
    }

    pub(super) fn node(index: u32) -> Leaf {
        Leaf(index)
    }

    pub(super) fn kind(self) -> LeafKind {
        let payload = self.0 & PAYLOAD;
        match self.0 & !PAYLOAD {
            0 => LeafKind::Node(payload),
            ELEMENT => LeafKind::Element(payload),
            NUMBER => LeafKind::Number(payload),
            _ => {
                let symbol = Symbol(payload & !SCALAR_OF_DATA);
                LeafKind::Scalar(if payload & SCALAR_OF_DATA == 0 {
                    Name::local(symbol)
                } else {
                    Name::of_data(symbol)
                })
            }
        }
    }
}

/// One operation of an expression.
#[derive(Clone, Copy, Debug)]
pub(super) struct SyntaxNode {
    pub(super) operands: [Leaf; 2],
    pub(super) operation: Operation,
}

impl SyntaxNode {
    pub(super) fn operands(&self) -> &[Leaf] {
        &self.operands[..self.operation.arity()]
    }
}

/// A statement and where it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Statement {
    pub(super) kind: Kind,
    pub(super) span: Span,
}

/// What a statement says.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// `target = root`, whose nodes are the run from `first` to `end`.
    Equation {
        target: Leaf,
        root: Leaf,
        first: u32,
        end: u32,
    },
    /// An entry of [`Syntax::calls`].
    Call(u32),
    /// An entry of [`Syntax::extents`]: `M = zeros(6,6)` or `double P[4];`.
    Extent(u32),
    /// An integer variable of the solver: `int iter = 0;`.
    Counter(Name),
    /// A whole-array assignment such as `q = s->q;`, already taken in.
    Prologue,
    /// An entry of [`Syntax::heads`].
    Head(u32),
    BlockOpen,
    BlockClose,
    Switch(Name),
    Case(u32),
    DefaultCase,
    Break,
    Return,
    While,
    If,
    ElseIf,
    Else,
}

/// A call of a function that is not one of the three known ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct Call {
    pub(super) target: Option<Leaf>,
    pub(super) callee: Name,
    /// First and last-but-one entry of [`Syntax::arguments`].
    pub(super) arguments: (u32, u32),
}

/// An argument of a call; [`Leaf::NONE`] when it is no expression.
#[derive(Clone, Copy, Debug)]
pub(super) struct Argument {
    pub(super) leaf: Leaf,
    pub(super) span: Span,
}

/// An array of known extent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) name: Name,
    pub(super) rows: u32,
    pub(super) columns: u32,
    /// True for `zeros`, which also gives values.
    pub(super) zeroed: bool,
}

/// The head of a function.
#[derive(Clone, Debug)]
pub(super) struct Head {
    pub(super) name: Symbol,
    pub(super) parameters: Vec<Name>,
    /// What a Matlab function returns.
    pub(super) outputs: Vec<Name>,
    /// The first entry of [`Syntax::elements`] that belongs to the function.
    pub(super) first_element: u32,
}

/// A file.
#[derive(Default, Debug)]
pub(super) struct Syntax {
    pub(super) nodes: Vec<SyntaxNode>,
    pub(super) elements: Vec<Element>,
    pub(super) numbers: Vec<f64>,
    pub(super) statements: Vec<Statement>,
    pub(super) calls: Vec<Call>,
    pub(super) arguments: Vec<Argument>,
    pub(super) extents: Vec<Extent>,
    pub(super) heads: Vec<Head>,
}

/// What the actions of the grammar write to.
#[derive(Default, Debug)]
pub(super) struct Builder {
    pub(super) syntax: Syntax,
    /// One past the number of `zeros` and declared extents: C and Python
    /// count from 0 and leave element 0 unused.
    pub(super) extents_from_zero: bool,
    /// Lengths of the arenas behind the last complete statement.
    complete: [usize; 4],
    /// Where the statements of the current chained assignment start.
    chain: usize,
    outputs: Vec<Name>,
    parameters: Vec<Name>,
    parameter: Option<Name>,
    initialised: Vec<(Name, Leaf)>,
    declared: Vec<Name>,
    pub(super) floats: Vec<Name>,
}

impl Builder {
    fn lengths(&self) -> [usize; 4] {
        let syntax = &self.syntax;
        [
            syntax.nodes.len(),
            syntax.elements.len(),
            syntax.statements.len(),
            syntax.arguments.len(),
        ]
    }

    /// Forgets the parts of a statement that could not be read.
    pub(super) fn abandon_statement(&mut self) {
        let [nodes, elements, statements, arguments] = self.complete;
        self.syntax.nodes.truncate(nodes);
        self.syntax.elements.truncate(elements);
        self.syntax.statements.truncate(statements);
        self.syntax.arguments.truncate(arguments);
        self.outputs.clear();
        self.parameters.clear();
        self.parameter = None;
        self.initialised.clear();
        self.declared.clear();
        self.chain = statements;
    }

    fn finish(&mut self) {
        self.complete = self.lengths();
        self.chain = self.syntax.statements.len();
    }

    fn statement(&mut self, kind: Kind, start: u32, end: u32) {
        let span = Span { start, end };
        self.syntax.statements.push(Statement { kind, span });
    }

    fn simple(&mut self, kind: Kind, start: u32, end: u32) {
        self.statement(kind, start, end);
        self.finish();
    }

    pub(super) fn node(&mut self, operation: Operation, left: Leaf, right: Leaf) -> Leaf {
        let index = self.syntax.nodes.len() as u32;
        self.syntax.nodes.push(SyntaxNode {
            operands: [left, right],
            operation,
        });
        Leaf::node(index)
    }

    pub(super) fn element(&mut self, element: Element) -> Leaf {
        let index = self.syntax.elements.len() as u32;
        self.syntax.elements.push(element);
        Leaf(ELEMENT | index)
    }

    pub(super) fn number(&mut self, number: f64) -> Leaf {
        let index = self.syntax.numbers.len() as u32;
        self.syntax.numbers.push(number);
        Leaf(NUMBER | index)
    }

    /// The nodes since the last statement.
    fn run(&self) -> (u32, u32) {
        let from_chain = self.syntax.statements[self.chain..].last();
        let first = match from_chain.map(|statement| statement.kind) {
            Some(Kind::Equation { end, .. }) => end,
            _ => self.complete[0] as u32,
        };
        (first, self.syntax.nodes.len() as u32)
    }

    fn push_equation(&mut self, start: u32, target: Leaf, root: Leaf) {
        let (first, end) = self.run();
        let kind = Kind::Equation {
            target,
            root,
            first,
            end,
        };
        self.statement(kind, start, start);
    }

    pub(super) fn chained(&mut self, start: u32, target: Leaf, root: Leaf) -> Leaf {
        self.push_equation(start, target, root);
        target
    }

    pub(super) fn equation(&mut self, start: u32, target: Leaf, root: Leaf, end: u32) {
        self.push_equation(start, target, root);
        for statement in &mut self.syntax.statements[self.chain..] {
            statement.span.end = end;
        }
        self.finish();
    }

    pub(super) fn argument(&mut self, leaf: Leaf, start: u32, end: u32) {
        let span = Span { start, end };
        self.syntax.arguments.push(Argument { leaf, span });
    }

    pub(super) fn call(
        &mut self,
        start: u32,
        target: Option<Leaf>,
        (callee, count): (Name, u32),
        end: u32,
    ) {
        let last = self.syntax.arguments.len() as u32;
        let index = self.syntax.calls.len() as u32;
        self.syntax.calls.push(Call {
            target,
            callee,
            arguments: (last - count, last),
        });
        self.simple(Kind::Call(index), start, end);
    }

    fn extent(&mut self, extent: Extent) -> Kind {
        let shift = u32::from(self.extents_from_zero);
        self.syntax.extents.push(Extent {
            rows: extent.rows.saturating_sub(shift),
            columns: extent.columns.saturating_sub(shift),
            ..extent
        });
        Kind::Extent(self.syntax.extents.len() as u32 - 1)
    }

    pub(super) fn zeros(
        &mut self,
        start: u32,
        target: Leaf,
        (rows, columns): (u32, u32),
        end: u32,
    ) {
        if let LeafKind::Scalar(name) = target.kind() {
            let kind = self.extent(Extent {
                name,
                rows,
                columns,
                zeroed: true,
            });
            self.statement(kind, start, end);
        }
        self.finish();
    }

    pub(super) fn declare_scalar(&mut self, name: Name) {
        self.declared.push(name);
    }

    pub(super) fn declare_array(&mut self, element: Element) {
        let kind = self.extent(Extent {
            name: element.name,
            rows: element.row,
            columns: element.column,
            zeroed: false,
        });
        self.statement(kind, 0, 0);
    }

    pub(super) fn initialise(&mut self, name: Name, root: Leaf) {
        self.initialised.push((name, root));
    }

    pub(super) fn declaration(&mut self, start: u32, float: bool, end: u32) {
        for statement in &mut self.syntax.statements[self.chain..] {
            statement.span = Span { start, end };
        }
        let mut first = self.complete[0] as u32;
        let last = self.syntax.nodes.len() as u32;
        for (name, root) in std::mem::take(&mut self.initialised) {
            if !float {
                self.statement(Kind::Counter(name), start, end);
                continue;
            }
            // The nodes of several initial values follow one another; each
            // root is the last of its own.
            let end_of_run = match root.kind() {
                LeafKind::Node(index) => index + 1,
                _ => first,
            };
            let kind = Kind::Equation {
                target: Leaf::scalar(name),
                root,
                first,
                end: end_of_run.min(last),
            };
            first = end_of_run;
            self.statement(kind, start, end);
        }
        let declared = std::mem::take(&mut self.declared);
        if float {
            self.floats.extend(declared);
        } else {
            for name in declared {
                self.statement(Kind::Counter(name), start, end);
            }
        }
        self.finish();
    }

    pub(super) fn output(&mut self, name: Name) {
        self.outputs.push(name);
    }

    pub(super) fn parameter_word(&mut self, name: Name) {
        self.parameter = Some(name);
    }

    pub(super) fn parameter_end(&mut self) {
        self.parameters.extend(self.parameter.take());
    }

    pub(super) fn head(&mut self, start: u32, name: Name, end: u32) {
        let head = Head {
            name: name.symbol(),
            parameters: std::mem::take(&mut self.parameters),
            outputs: std::mem::take(&mut self.outputs),
            first_element: self.syntax.elements.len() as u32,
        };
        let index = self.syntax.heads.len() as u32;
        self.syntax.heads.push(head);
        self.simple(Kind::Head(index), start, end);
    }

    pub(super) fn block_open(&mut self, start: u32) {
        self.simple(Kind::BlockOpen, start, start + 1);
    }

    pub(super) fn block_close(&mut self, start: u32, length: u32) {
        self.simple(Kind::BlockClose, start, start + length);
    }

    pub(super) fn switch(&mut self, start: u32, name: Name, end: u32) {
        self.simple(Kind::Switch(name), start, end);
    }

    pub(super) fn case(&mut self, start: u32, number: f64, end: u32) {
        // Saturates; a case that is no whole number names no sensor.
        self.simple(Kind::Case(number as u32), start, end);
    }

    pub(super) fn default_case(&mut self, start: u32, end: u32) {
        self.simple(Kind::DefaultCase, start, end);
    }

    pub(super) fn leave(&mut self, start: u32, end: u32) {
        self.simple(Kind::Break, start, end);
    }

    pub(super) fn give_back(&mut self, start: u32, end: u32) {
        self.simple(Kind::Return, start, end);
    }

    pub(super) fn repeat(&mut self, start: u32, end: u32) {
        self.simple(Kind::While, start, end);
    }

    pub(super) fn condition(&mut self, start: u32, end: u32) {
        self.simple(Kind::If, start, end);
    }

    pub(super) fn other_condition(&mut self, start: u32, end: u32) {
        self.simple(Kind::ElseIf, start, end);
    }

    pub(super) fn otherwise(&mut self, start: u32, end: u32) {
        self.simple(Kind::Else, start, end);
    }
}
