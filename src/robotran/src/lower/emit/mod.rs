//! One straight-line function, written equation by equation.
//!
//! Invariant: the nodes of an equation are appended in the order of the
//! arena, so the node `first + k` of the arena is the value `base + k` of the
//! function.

mod declarations;
mod equations;
mod refusals;
mod writing;

use super::names::GivenNames;
use super::scan::Scan;
use crate::Language;
use crate::places::LineIndex;
use crate::storage::Storage;
use crate::syntax::{StatementKind, SyntaxTree};
use crate::token::{RobotranName, SourceSpan};
use hashbrown::{HashMap, HashSet};
use robovec_ir::diagnostic::Diagnostic;
use robovec_ir::{Array, Function, Node, Operand, Output, SourceSet, Symbol, Tables};
use rustc_hash::FxBuildHasher;
use std::ops::Range;

/// A set of names.
pub(super) type SymbolSet = HashSet<Symbol, FxBuildHasher>;

/// The scalars that pass between the parts of a function with loops.
#[derive(Default, Debug)]
pub(super) struct CrossingScalars {
    pub(super) inputs: SymbolSet,
    pub(super) outputs: SymbolSet,
}

/// Head and declarations of a function.
#[derive(Debug)]
pub(super) struct FunctionSignature {
    /// Results and parameters, under the names the equations use.
    pub(super) parameters: Vec<RobotranName>,
    /// Whole numbers declared in the function.
    pub(super) counters: SymbolSet,
    /// The parameters as the head names them, and those of whole numbers.
    pub(super) given: Vec<RobotranName>,
    pub(super) whole: Vec<RobotranName>,
}

/// Data that all functions of a file share.
pub(super) struct Shared<'a, 't> {
    pub(super) syntax: &'a SyntaxTree,
    pub(super) text: &'t str,
    pub(super) tables: &'a mut Tables,
    pub(super) places: &'a mut LineIndex<'t>,
    pub(super) language: Language,
    /// The definition of every scalar, by symbol; empty between functions.
    pub(super) definitions: Vec<Operand>,
}

/// Beginning of the values of [`Later`], within each expression; above the
/// number of nodes of any function.
const LATER: u32 = 1 << 29;

/// The expressions of plain outputs. They are resolved at their place in the
/// file but appended after all definitions, as the representation requires.
#[derive(Default, Debug)]
pub(super) struct Later {
    nodes: Vec<Node>,
    trees: Vec<(Output, Range<usize>)>,
}

/// Writes one function.
pub(super) struct FunctionEmitter<'e, 'a, 't> {
    pub(super) shared: &'e mut Shared<'a, 't>,
    pub(super) storage: &'e Storage,
    pub(super) scan: &'e Scan,
    pub(super) parameters: HashMap<RobotranName, usize, FxBuildHasher>,
    pub(super) signature: &'e FunctionSignature,
    /// `None` for a whole function.
    pub(super) crossing: Option<&'e CrossingScalars>,
    pub(super) function: Function,
    pub(super) later: Later,
    pub(super) names: GivenNames,
    /// The input and output array of every stored array.
    pub(super) declared: HashMap<Symbol, Array, FxBuildHasher>,
    pub(super) inputs: Vec<Option<Array>>,
    pub(super) outputs: Vec<Option<Array>>,
    pub(super) declared_outputs: SymbolSet,
    /// The value of every element, [`Operand::NONE`] before it is written.
    pub(super) elements: Vec<Operand>,
    /// The elements that became named values, in order of first writing.
    pub(super) named_elements: Vec<u32>,
    pub(super) defined: Vec<Symbol>,
    pub(super) passed_scalars: SymbolSet,
    /// Scalars read without a definition, with the statement.
    pub(super) missing: Vec<(Symbol, usize)>,
    pub(super) missing_known: SymbolSet,
    pub(super) errors: Vec<Diagnostic>,
    pub(super) warnings: Vec<Diagnostic>,
    pub(super) statement: usize,
}

impl<'e, 'a, 't> FunctionEmitter<'e, 'a, 't> {
    pub(super) fn new(
        function: Function,
        shared: &'e mut Shared<'a, 't>,
        storage: &'e Storage,
        scan: &'e Scan,
        signature: &'e FunctionSignature,
        crossing: Option<&'e CrossingScalars>,
    ) -> FunctionEmitter<'e, 'a, 't> {
        assert_eq!(
            scan.flags.len(),
            storage.len,
            "the scan is of these elements"
        );
        assert_eq!(
            scan.written.len(),
            storage.arrays.len(),
            "the scan is of these arrays"
        );
        let arrays = storage.arrays.len();
        let known = shared.tables.symbols.len();
        let mut emitter = FunctionEmitter {
            shared,
            storage,
            scan,
            parameters: signature.parameters.iter().copied().zip(0..).collect(),
            signature,
            crossing,
            function,
            later: Later::default(),
            names: GivenNames::new(known),
            declared: HashMap::default(),
            inputs: vec![None; arrays],
            outputs: vec![None; arrays],
            declared_outputs: SymbolSet::default(),
            elements: vec![Operand::NONE; storage.len],
            named_elements: Vec::new(),
            defined: Vec::new(),
            passed_scalars: SymbolSet::default(),
            missing: Vec::new(),
            missing_known: SymbolSet::default(),
            errors: Vec::new(),
            warnings: Vec::new(),
            statement: 0,
        };
        emitter.function.reserve(scan.nodes + scan.equations / 4);
        emitter.declare_inputs();
        emitter.declare_outputs();
        emitter
    }

    /// Lowers the statements.
    pub(super) fn run(&mut self, runs: &[Range<usize>]) {
        for index in runs.iter().cloned().flatten() {
            self.statement = index;
            let statement = self.shared.syntax.statements[index];
            match statement.kind {
                StatementKind::Equation {
                    target,
                    root,
                    first,
                    end,
                } => self.equation(target, root, first..end, statement.span),
                StatementKind::Call(call) => self.call(call, statement.span),
                _ => {}
            }
            if self.errors.len() >= crate::ERROR_LIMIT {
                break;
            }
        }
    }

    pub(super) fn sources(&mut self, span: SourceSpan) -> SourceSet {
        let place = self.shared.places.place(span);
        self.shared.tables.sources.single(place)
    }
}

/// A function that was written, and the mistakes found in it.
pub(super) struct EmittedFunction {
    pub(super) function: Function,
    pub(super) missing: Vec<(Symbol, usize)>,
    pub(super) errors: Vec<Diagnostic>,
    pub(super) warnings: Vec<Diagnostic>,
}
