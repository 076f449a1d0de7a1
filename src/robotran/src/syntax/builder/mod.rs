//! Builder that the actions of the grammar write to.
//!
//! Invariant: every entry after the lengths in `complete` belongs to the
//! statement that is being read, and is removed when it cannot be read.

mod declarations;
mod equations;
mod expressions;

use super::{StatementKind, SyntaxLeaf, SyntaxStatement, SyntaxTree};
use crate::literal::{IntegerArithmetic, Literal, Unkept};
use crate::token::{
    LexicalError, RobotranElement, RobotranName, RobotranToken, SourceSpan, TypeWords,
};
use hashbrown::HashMap;
use rustc_hash::FxBuildHasher;

/// Error of an action of the grammar.
pub(crate) type ParseFailure = lalrpop_util::ParseError<u32, RobotranToken, LexicalError>;

pub(super) fn refused(span: SourceSpan, message: &'static str, note: &'static str) -> ParseFailure {
    let error = LexicalError::new(span, message, note);
    lalrpop_util::ParseError::User { error }
}

pub(super) fn unkept(Unkept { message, note }: Unkept, span: SourceSpan) -> ParseFailure {
    refused(span, message, note)
}

/// Builder that the actions of the grammar write to.
#[derive(Default, Debug)]
pub(crate) struct SyntaxBuilder {
    pub(crate) syntax: SyntaxTree,
    /// One past `zeros` and declared extents: C and Python leave element 0.
    pub(crate) extents_from_zero: bool,
    /// The language of the literals' integer arithmetic.
    pub(crate) arithmetic: IntegerArithmetic,
    /// Lengths of the arenas after the last complete statement.
    complete: [usize; 5],
    /// Beginning of the statements of the current chained assignment.
    chain: usize,
    outputs: Vec<RobotranName>,
    parameters: Vec<RobotranName>,
    parameter: Option<RobotranName>,
    parameter_types: TypeWords,
    whole_parameters: Vec<RobotranName>,
    initialised: Vec<(RobotranName, SyntaxLeaf)>,
    declared: Vec<RobotranName>,
    pointers: Vec<RobotranName>,
    /// First values of an array of C, with their places: of the innermost list,
    /// and of the lists that have ended, with the places of their braces.
    values: Vec<(u32, Literal)>,
    value_rows: Vec<(u32, Vec<(u32, Literal)>)>,
    /// Arrays among the declarators of a statement of C.
    declares_array: bool,
    /// Rows of matrices that have their own names in C
    /// (`double *dpt1 = s->dpt[1];`): the matrix and the row.
    rows: HashMap<RobotranName, RobotranElement, FxBuildHasher>,
    /// Names that are whole numbers in Python, with their bits.
    whole_names: HashMap<RobotranName, u8, FxBuildHasher>,
}

impl SyntaxBuilder {
    fn lengths(&self) -> [usize; 5] {
        let syntax = &self.syntax;
        [
            syntax.nodes.len(),
            syntax.elements.len(),
            syntax.statements.len(),
            syntax.arguments.len(),
            syntax.numbers.len(),
        ]
    }

    /// Forgets the parts of a statement that could not be read.
    pub(crate) fn abandon_statement(&mut self) {
        self.values.clear();
        self.value_rows.clear();
        let [nodes, elements, statements, arguments, numbers] = self.complete;
        self.syntax.nodes.truncate(nodes);
        self.syntax.elements.truncate(elements);
        self.syntax.statements.truncate(statements);
        self.syntax.arguments.truncate(arguments);
        self.syntax.numbers.truncate(numbers);
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

    pub(super) fn finish(&mut self) {
        debug_assert!(
            self.complete
                .iter()
                .zip(self.lengths())
                .all(|(before, now)| *before <= now),
            "    what is complete stays"
        );
        self.complete = self.lengths();
        self.chain = self.syntax.statements.len();
    }

    pub(super) fn statement(&mut self, kind: StatementKind, start: u32, end: u32) {
        let span = SourceSpan { start, end };
        let elements = self.syntax.elements.len() as u32;
        self.syntax.statements.push(SyntaxStatement {
            kind,
            span,
            elements,
        });
    }

    /// Adds a statement that needs no further parts.
    pub(crate) fn simple(&mut self, kind: StatementKind, start: u32, end: u32) {
        self.statement(kind, start, end);
        self.finish();
    }
}
