//! A file as the grammar sees it: a flat arena of expression nodes and a flat
//! list of statements.
//!
//! Invariant: the nodes of an expression stand in one run of the arena, every
//! operand before its user. Lowering is therefore one loop over the run.

use super::literal::{IntegerArithmetic, Literal, Unkept};
use super::token::{RobotranElement, RobotranName, SourceSpan, TypeWords};
use super::tokens::LexicalError;
use hashbrown::HashMap;
use robovec_ir::{Operation, Symbol};
use rustc_hash::FxBuildHasher;

/// What an expression reads, packed into 32 bits.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct SyntaxLeaf(u32);

/// A [`SyntaxLeaf`] taken apart.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum LeafKind {
    /// The result of a node of the arena.
    Node(u32),
    /// An entry of [`SyntaxTree::elements`].
    Element(u32),
    /// An entry of [`SyntaxTree::numbers`].
    Number(u32),
    /// A bare name.
    Scalar(RobotranName),
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

impl SyntaxLeaf {
    /// The absent second operand.
    pub(super) const NONE: SyntaxLeaf = SyntaxLeaf(u32::MAX);

    pub(super) fn scalar(name: RobotranName) -> SyntaxLeaf {
        let of_data = if name.is_of_data() { SCALAR_OF_DATA } else { 0 };
        SyntaxLeaf(SCALAR | of_data | name.symbol().0)
    }

    pub(super) fn node(index: u32) -> SyntaxLeaf {
        SyntaxLeaf(index)
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
                    RobotranName::local(symbol)
                } else {
                    RobotranName::of_data(symbol)
                })
            }
        }
    }
}

/// One operation of an expression.
#[derive(Clone, Copy, Debug)]
pub(super) struct SyntaxNode {
    pub(super) operands: [SyntaxLeaf; 2],
    pub(super) operation: Operation,
    /// It stands in parentheses.
    pub(super) grouped: bool,
    /// In Python: how many bits it may have as a whole number; 0 for a float.
    pub(super) whole_bits: u8,
}

impl SyntaxNode {
    pub(super) fn operands(&self) -> &[SyntaxLeaf] {
        &self.operands[..self.operation.arity()]
    }
}

/// A statement and where it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct SyntaxStatement {
    pub(super) kind: StatementKind,
    pub(super) span: SourceSpan,
    /// How many [`SyntaxTree::elements`] stand before it and in it.
    pub(super) elements: u32,
}

/// What a statement says.
#[derive(Clone, Copy, Debug)]
pub(super) enum StatementKind {
    /// `target = root`, whose nodes are the run from `first` to `end`.
    Equation {
        target: SyntaxLeaf,
        root: SyntaxLeaf,
        first: u32,
        end: u32,
    },
    /// An entry of [`SyntaxTree::calls`].
    Call(u32),
    /// An entry of [`SyntaxTree::extents`]: `M = zeros(6,6)` or `double P[4];`.
    Extent(u32),
    /// An integer variable of the solver: `int iter = 0;`.
    Counter(RobotranName),
    /// A pointer of C that is declared and points at nothing yet.
    Pointer(RobotranName),
    /// A whole-array assignment such as `q = s->q;`, already taken in.
    Prologue,
    /// An entry of [`SyntaxTree::heads`].
    Head(u32),
    BlockOpen,
    BlockClose,
    Switch(RobotranName),
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
pub(super) struct FunctionCall {
    pub(super) target: Option<SyntaxLeaf>,
    pub(super) callee: RobotranName,
    /// First and last-but-one entry of [`SyntaxTree::arguments`].
    pub(super) arguments: (u32, u32),
}

/// An argument of a call; [`SyntaxLeaf::NONE`] when it is no expression.
#[derive(Clone, Copy, Debug)]
pub(super) struct Argument {
    pub(super) leaf: SyntaxLeaf,
    pub(super) span: SourceSpan,
}

/// An array of known extent.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeclaredArray {
    pub(super) name: RobotranName,
    pub(super) rows: u32,
    pub(super) columns: u32,
    /// True for `zeros`, which also gives values.
    pub(super) zeroed: bool,
}

/// The head of a function.
#[derive(Clone, Debug)]
pub(super) struct FunctionHeader {
    pub(super) name: Symbol,
    pub(super) parameters: Vec<RobotranName>,
    /// The parameters of C that are whole numbers.
    pub(super) whole: Vec<RobotranName>,
    /// What a Matlab function returns.
    pub(super) outputs: Vec<RobotranName>,
    /// The first entry of [`SyntaxTree::elements`] that belongs to the function.
    pub(super) first_element: u32,
}

/// A file.
#[derive(Default, Debug)]
pub(super) struct SyntaxTree {
    pub(super) nodes: Vec<SyntaxNode>,
    pub(super) elements: Vec<RobotranElement>,
    pub(super) numbers: Vec<Literal>,
    pub(super) statements: Vec<SyntaxStatement>,
    pub(super) calls: Vec<FunctionCall>,
    pub(super) arguments: Vec<Argument>,
    pub(super) extents: Vec<DeclaredArray>,
    pub(super) heads: Vec<FunctionHeader>,
}

/// What an action of the grammar refuses with.
pub(super) type ParseFailure =
    lalrpop_util::ParseError<u32, super::token::RobotranToken, LexicalError>;

fn refused(span: SourceSpan, message: &'static str, note: &'static str) -> ParseFailure {
    let error = LexicalError {
        span,
        message,
        note,
    };
    lalrpop_util::ParseError::User { error }
}

fn unkept(Unkept { message, note }: Unkept, span: SourceSpan) -> ParseFailure {
    refused(span, message, note)
}

/// What the actions of the grammar write to.
#[derive(Default, Debug)]
pub(super) struct SyntaxBuilder {
    pub(super) syntax: SyntaxTree,
    /// One past the number of `zeros` and declared extents: C and Python
    /// count from 0 and leave element 0 unused.
    pub(super) extents_from_zero: bool,
    /// Whose whole numbers the literals are.
    pub(super) arithmetic: IntegerArithmetic,
    /// Lengths of the arenas behind the last complete statement.
    complete: [usize; 4],
    /// Where the statements of the current chained assignment start.
    chain: usize,
    outputs: Vec<RobotranName>,
    parameters: Vec<RobotranName>,
    parameter: Option<RobotranName>,
    parameter_types: TypeWords,
    whole_parameters: Vec<RobotranName>,
    initialised: Vec<(RobotranName, SyntaxLeaf)>,
    declared: Vec<RobotranName>,
    pointers: Vec<RobotranName>,
    /// Arrays among the declarators of a statement of C.
    declares_array: bool,
    /// Rows of matrices that have names of their own in C
    /// (`double *dpt1 = s->dpt[1];`): the matrix and the row.
    rows: HashMap<RobotranName, RobotranElement, FxBuildHasher>,
    /// Names that are whole numbers in Python, with their bits.
    whole_names: HashMap<RobotranName, u8, FxBuildHasher>,
}

impl SyntaxBuilder {
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
        self.parameter_types = TypeWords::default();
        self.whole_parameters.clear();
        self.initialised.clear();
        self.declared.clear();
        self.pointers.clear();
        self.declares_array = false;
        self.chain = statements;
    }

    fn finish(&mut self) {
        self.complete = self.lengths();
        self.chain = self.syntax.statements.len();
    }

    fn statement(&mut self, kind: StatementKind, start: u32, end: u32) {
        let span = SourceSpan { start, end };
        let elements = self.syntax.elements.len() as u32;
        self.syntax.statements.push(SyntaxStatement {
            kind,
            span,
            elements,
        });
    }

    fn simple(&mut self, kind: StatementKind, start: u32, end: u32) {
        self.statement(kind, start, end);
        self.finish();
    }

    fn push_node(
        &mut self,
        operation: Operation,
        left: SyntaxLeaf,
        right: SyntaxLeaf,
    ) -> SyntaxLeaf {
        let index = self.syntax.nodes.len() as u32;
        self.syntax.nodes.push(SyntaxNode {
            operands: [left, right],
            operation,
            grouped: false,
            whole_bits: 0,
        });
        SyntaxLeaf::node(index)
    }

    /// How many bits an operand may have as a whole number of Python, and 0
    /// for a float. Names stand for whole numbers where any equation says so.
    fn whole_bits(&self, leaf: SyntaxLeaf) -> u8 {
        match leaf.kind() {
            LeafKind::Node(index) => self.syntax.nodes[index as usize].whole_bits,
            LeafKind::Number(index) => match self.syntax.numbers[index as usize] {
                Literal::Whole { value, .. } => (64 - value.abs().leading_zeros() as u8).max(1),
                Literal::Single(_) | Literal::Double(_) => 0,
            },
            LeafKind::Scalar(name) => self.whole_names.get(&name).copied().unwrap_or(0),
            LeafKind::Element(_) => 0,
        }
    }

    /// An operation on whole numbers of Python: exact there, and in a 64-bit
    /// float up to 53 bits.
    fn exact(
        &self,
        operation: Operation,
        left: SyntaxLeaf,
        right: SyntaxLeaf,
    ) -> Result<u8, Unkept> {
        let (a, b) = (self.whole_bits(left), self.whole_bits(right));
        if a == 0 || b == 0 {
            return Ok(0);
        }
        let bits = match operation {
            Operation::Add | Operation::Sub => a.max(b) + 1,
            Operation::Mul => a + b,
            _ => return Ok(0),
        };
        if bits > 53 {
            return Err(Unkept {
                message: "whole numbers that may be too large for a 64-bit float",
                note: "Python computes them exactly; write them with decimal points",
            });
        }
        Ok(bits)
    }

    /// The literal that an operand is.
    fn literal(&self, leaf: SyntaxLeaf) -> Option<Literal> {
        match leaf.kind() {
            LeafKind::Number(index) => Some(self.syntax.numbers[index as usize]),
            LeafKind::Node(_) | LeafKind::Element(_) | LeafKind::Scalar(_) => None,
        }
    }

    /// An operation on two operands. Literals that are not both 64-bit floats
    /// are combined here, as the language combines them.
    pub(super) fn node(
        &mut self,
        operation: Operation,
        (start, left): (u32, SyntaxLeaf),
        (right, end): (SyntaxLeaf, u32),
    ) -> Result<SyntaxLeaf, ParseFailure> {
        if let (Some(a), Some(b)) = (self.literal(left), self.literal(right)) {
            let span = SourceSpan { start, end };
            let combined = a
                .combined(operation, b, self.arithmetic)
                .map_err(|error| unkept(error, span))?;
            if let Some(number) = combined {
                return Ok(self.number(number));
            }
        }
        let whole_bits = match self.arithmetic {
            IntegerArithmetic::Python => self
                .exact(operation, left, right)
                .map_err(|error| unkept(error, SourceSpan { start, end }))?,
            IntegerArithmetic::C | IntegerArithmetic::Floats => 0,
        };
        let node = self.push_node(operation, left, right);
        if let Some(last) = self.syntax.nodes.last_mut() {
            last.whole_bits = whole_bits;
        }
        Ok(node)
    }

    /// The sine, cosine or root of an operand.
    pub(super) fn apply(&mut self, function: Operation, argument: SyntaxLeaf) -> SyntaxLeaf {
        self.push_node(function, argument, SyntaxLeaf::NONE)
    }

    /// A minus before an operand, which may be a product.
    pub(super) fn negated(
        &mut self,
        start: u32,
        operand: SyntaxLeaf,
        end: u32,
    ) -> Result<SyntaxLeaf, ParseFailure> {
        if let Some(number) = self.literal(operand) {
            let span = SourceSpan { start, end };
            if let Some(negative) = number.negative().map_err(|error| unkept(error, span))? {
                return Ok(self.number(negative));
            }
        }
        // The minus belongs to the first factor, and a whole 0 has no sign.
        let mut first = operand;
        while let LeafKind::Node(index) = first.kind() {
            let node = self.syntax.nodes[index as usize];
            if node.grouped || !matches!(node.operation, Operation::Mul | Operation::Div) {
                break;
            }
            first = node.operands[0];
        }
        if first != operand && self.literal(first).is_some_and(Literal::is_whole_zero) {
            return Ok(operand);
        }
        let whole_bits = self.whole_bits(operand);
        let node = self.push_node(Operation::Neg, operand, SyntaxLeaf::NONE);
        if let Some(last) = self.syntax.nodes.last_mut() {
            last.whole_bits = whole_bits;
        }
        Ok(node)
    }

    /// An expression in parentheses.
    pub(super) fn grouped(&mut self, leaf: SyntaxLeaf) -> SyntaxLeaf {
        if let LeafKind::Node(index) = leaf.kind() {
            self.syntax.nodes[index as usize].grouped = true;
        }
        leaf
    }

    /// C's conversion to another type; every operand but a literal is a
    /// 64-bit float already.
    pub(super) fn converted(
        &mut self,
        start: u32,
        words: TypeWords,
        operand: SyntaxLeaf,
        end: u32,
    ) -> Result<SyntaxLeaf, ParseFailure> {
        if !words.is_double() {
            return Err(refused(
                SourceSpan { start, end },
                "a conversion to another type than `double`",
                "it would round the number; write the rounded number, or leave the conversion out",
            ));
        }
        Ok(match self.literal(operand) {
            Some(number) => self.number(Literal::Double(number.number())),
            None => operand,
        })
    }

    pub(super) fn element(&mut self, element: RobotranElement) -> SyntaxLeaf {
        let element = match self.rows.get(&element.name) {
            Some(row) if element.column == 0 && element.row > 0 => RobotranElement {
                column: element.row,
                ..*row
            },
            Some(_) | None => element,
        };
        let index = self.syntax.elements.len() as u32;
        self.syntax.elements.push(element);
        SyntaxLeaf(ELEMENT | index)
    }

    /// What a pointer of C points at.
    pub(super) fn pointed_at(&mut self, name: RobotranName) -> SyntaxLeaf {
        self.element(RobotranElement {
            name,
            row: 0,
            column: 0,
        })
    }

    pub(super) fn number(&mut self, number: Literal) -> SyntaxLeaf {
        let index = self.syntax.numbers.len() as u32;
        self.syntax.numbers.push(number);
        SyntaxLeaf(NUMBER | index)
    }

    /// The nodes since the last statement.
    fn run(&self) -> (u32, u32) {
        let from_chain = self.syntax.statements[self.chain..].last();
        let first = match from_chain.map(|statement| statement.kind) {
            Some(StatementKind::Equation { end, .. }) => end,
            _ => self.complete[0] as u32,
        };
        (first, self.syntax.nodes.len() as u32)
    }

    fn push_equation(&mut self, start: u32, target: SyntaxLeaf, root: SyntaxLeaf) {
        let bits = self.whole_bits(root);
        if self.arithmetic == IntegerArithmetic::Python
            && bits > 0
            && let LeafKind::Scalar(name) = target.kind()
        {
            let known = self.whole_names.entry(name).or_insert(0);
            *known = bits.max(*known);
        }
        let (first, end) = self.run();
        let kind = StatementKind::Equation {
            target,
            root,
            first,
            end,
        };
        self.statement(kind, start, start);
    }

    pub(super) fn chained(
        &mut self,
        start: u32,
        target: SyntaxLeaf,
        root: SyntaxLeaf,
    ) -> SyntaxLeaf {
        self.push_equation(start, target, root);
        target
    }

    pub(super) fn equation(&mut self, start: u32, target: SyntaxLeaf, root: SyntaxLeaf, end: u32) {
        self.push_equation(start, target, root);
        for statement in &mut self.syntax.statements[self.chain..] {
            statement.span.end = end;
        }
        self.finish();
    }

    pub(super) fn argument(&mut self, leaf: SyntaxLeaf, start: u32, end: u32) {
        let span = SourceSpan { start, end };
        self.syntax.arguments.push(Argument { leaf, span });
    }

    pub(super) fn call(
        &mut self,
        start: u32,
        target: Option<SyntaxLeaf>,
        (callee, count): (RobotranName, u32),
        end: u32,
    ) {
        let last = self.syntax.arguments.len() as u32;
        let index = self.syntax.calls.len() as u32;
        self.syntax.calls.push(FunctionCall {
            target,
            callee,
            arguments: (last - count, last),
        });
        self.simple(StatementKind::Call(index), start, end);
    }

    fn extent(&mut self, extent: DeclaredArray) -> StatementKind {
        let shift = u32::from(self.extents_from_zero);
        self.syntax.extents.push(DeclaredArray {
            rows: extent.rows.saturating_sub(shift),
            columns: extent.columns.saturating_sub(shift),
            ..extent
        });
        StatementKind::Extent(self.syntax.extents.len() as u32 - 1)
    }

    pub(super) fn zeros(
        &mut self,
        start: u32,
        target: SyntaxLeaf,
        (rows, columns): (u32, u32),
        end: u32,
    ) {
        if let LeafKind::Scalar(name) = target.kind() {
            let kind = self.extent(DeclaredArray {
                name,
                rows,
                columns,
                zeroed: true,
            });
            self.statement(kind, start, end);
        }
        self.finish();
    }

    pub(super) fn declare_scalar(&mut self, pointer: bool, name: RobotranName) {
        if pointer {
            self.pointers.push(name);
        }
        self.declared.push(name);
    }

    pub(super) fn declare_array(&mut self, element: RobotranElement, zeroed: bool) {
        let kind = self.extent(DeclaredArray {
            name: element.name,
            rows: element.row,
            columns: element.column,
            zeroed,
        });
        self.declares_array = true;
        self.statement(kind, 0, 0);
    }

    /// A first value of an array of C.
    pub(super) fn first_value(
        &mut self,
        start: u32,
        number: Literal,
        end: u32,
    ) -> Result<(), ParseFailure> {
        if number.number() == 0.0 {
            return Ok(());
        }
        Err(refused(
            SourceSpan { start, end },
            "an array with first values other than 0",
            "assign to its elements one by one",
        ))
    }

    /// `double *q = s->q` and `double *dpt1 = s->dpt[1]`, where a `pointer` is
    /// declared; else a number with its first value.
    pub(super) fn initialise(&mut self, pointer: bool, name: RobotranName, root: SyntaxLeaf) {
        if pointer
            && let LeafKind::Element(index) = root.kind()
            && let row = self.syntax.elements[index as usize]
            && row.column == 0
            && row.row > 0
            && index as usize + 1 == self.syntax.elements.len()
        {
            self.syntax.elements.pop();
            self.rows.insert(name, row);
            return;
        }
        self.initialised.push((name, root));
    }

    /// A name that the declaration declares and that is a parameter already:
    /// in an inner block it would be another variable.
    fn hidden_parameter(&self) -> bool {
        let Some(head) = self.syntax.heads.last() else {
            return false;
        };
        let arrays = self.syntax.statements[self.chain..].iter();
        let arrays = arrays.filter_map(|statement| match statement.kind {
            StatementKind::Extent(extent) => Some(self.syntax.extents[extent as usize].name),
            _ => None,
        });
        let initialised = self.initialised.iter().map(|&(name, _)| name);
        let mut names = self
            .declared
            .iter()
            .copied()
            .chain(initialised)
            .chain(arrays);
        names.any(|name| head.parameters.contains(&name))
    }

    pub(super) fn declaration(
        &mut self,
        start: u32,
        words: TypeWords,
        end: u32,
    ) -> Result<(), ParseFailure> {
        let span = SourceSpan { start, end };
        let double = words.is_double();
        if words.is_other_float() || (self.declares_array && !double) {
            return Err(refused(
                span,
                "variables of another type than `double`",
                "their numbers would be rounded; robovec computes in 64-bit floats: declare them `double`",
            ));
        }
        if self.hidden_parameter() {
            return Err(refused(
                span,
                "a parameter's name is declared once more",
                "the two would be different variables; give the new one another name",
            ));
        }
        let elements = self.syntax.elements.len() as u32;
        for statement in &mut self.syntax.statements[self.chain..] {
            statement.span = span;
            statement.elements = elements;
        }
        let mut first = self.complete[0] as u32;
        let last = self.syntax.nodes.len() as u32;
        for (name, root) in std::mem::take(&mut self.initialised) {
            if !double {
                self.statement(StatementKind::Counter(name), start, end);
                continue;
            }
            // The nodes of several initial values follow one another; each
            // root is the last of its own.
            let end_of_run = match root.kind() {
                LeafKind::Node(index) => index + 1,
                _ => first,
            };
            let kind = StatementKind::Equation {
                target: SyntaxLeaf::scalar(name),
                root,
                first,
                end: end_of_run.min(last),
            };
            first = end_of_run;
            self.statement(kind, start, end);
        }
        let declared = std::mem::take(&mut self.declared);
        for name in std::mem::take(&mut self.pointers) {
            self.statement(StatementKind::Pointer(name), start, end);
        }
        if !double {
            for name in declared {
                self.statement(StatementKind::Counter(name), start, end);
            }
        }
        self.declares_array = false;
        self.finish();
        Ok(())
    }

    pub(super) fn output(&mut self, name: RobotranName) {
        self.outputs.push(name);
    }

    pub(super) fn parameter_word(&mut self, name: RobotranName) {
        self.parameter = Some(name);
    }

    pub(super) fn parameter_type(&mut self, words: TypeWords) {
        self.parameter_types = self.parameter_types.and(words);
    }

    pub(super) fn parameter_end(&mut self, start: u32, end: u32) -> Result<(), ParseFailure> {
        let words = std::mem::take(&mut self.parameter_types);
        if words.is_other_float() {
            return Err(refused(
                SourceSpan { start, end },
                "a parameter of another type than `double`",
                "its numbers would be rounded; robovec computes in 64-bit floats",
            ));
        }
        if words.is_whole() {
            self.whole_parameters.extend(self.parameter);
        }
        self.parameters.extend(self.parameter.take());
        Ok(())
    }

    pub(super) fn head(&mut self, start: u32, name: RobotranName, end: u32) {
        let head = FunctionHeader {
            name: name.symbol(),
            parameters: std::mem::take(&mut self.parameters),
            whole: std::mem::take(&mut self.whole_parameters),
            outputs: std::mem::take(&mut self.outputs),
            first_element: self.syntax.elements.len() as u32,
        };
        self.rows.clear();
        let index = self.syntax.heads.len() as u32;
        self.syntax.heads.push(head);
        self.simple(StatementKind::Head(index), start, end);
    }

    pub(super) fn block_open(&mut self, start: u32) {
        self.simple(StatementKind::BlockOpen, start, start + 1);
    }

    pub(super) fn block_close(&mut self, start: u32, length: u32) {
        self.simple(StatementKind::BlockClose, start, start + length);
    }

    pub(super) fn switch(&mut self, start: u32, name: RobotranName, end: u32) {
        self.simple(StatementKind::Switch(name), start, end);
    }

    pub(super) fn case(
        &mut self,
        start: u32,
        number: Literal,
        end: u32,
    ) -> Result<(), ParseFailure> {
        let whole = number.number();
        // Exact below 2^32, and nothing else is the number of a sensor.
        if whole.fract() != 0.0 || !(0.0..4e9).contains(&whole) {
            return Err(refused(
                SourceSpan { start, end },
                "a case that is not a whole number",
                "the cases of a sensor file are the numbers of sensors",
            ));
        }
        self.simple(StatementKind::Case(whole as u32), start, end);
        Ok(())
    }

    pub(super) fn default_case(&mut self, start: u32, end: u32) {
        self.simple(StatementKind::DefaultCase, start, end);
    }

    pub(super) fn leave(&mut self, start: u32, end: u32) {
        self.simple(StatementKind::Break, start, end);
    }

    pub(super) fn give_back(&mut self, start: u32, end: u32) {
        self.simple(StatementKind::Return, start, end);
    }

    pub(super) fn repeat(&mut self, start: u32, end: u32) {
        self.simple(StatementKind::While, start, end);
    }

    pub(super) fn condition(&mut self, start: u32, end: u32) {
        self.simple(StatementKind::If, start, end);
    }

    pub(super) fn other_condition(&mut self, start: u32, end: u32) {
        self.simple(StatementKind::ElseIf, start, end);
    }

    pub(super) fn otherwise(&mut self, start: u32, end: u32) {
        self.simple(StatementKind::Else, start, end);
    }
}
