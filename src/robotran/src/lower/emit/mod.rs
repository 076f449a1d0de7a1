//! One straight-line function, written equation by equation.
//!
//! Invariant: nodes are appended in the order of the arena, so the node `first
//! + k` of the arena is the value `base + k` of the function.

mod equations;
mod writing;

use super::names::GivenNames;
use super::scan::Scan;
use crate::Language;
use crate::conventions::{INPUT_ORDER, SENSOR_FIELDS};
use crate::places::LineIndex;
use crate::storage::{Initial, Storage};
use crate::syntax::{StatementKind, SyntaxTree};
use crate::token::{RobotranName, SourceSpan};
use hashbrown::{HashMap, HashSet};
use robovec_ir::diagnostic::Diagnostic;
use robovec_ir::{Array, Function, Input, Node, Operand, Output, Shape, SourceSet, Symbol, Tables};
use rustc_hash::FxBuildHasher;
use std::ops::Range;

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

/// Beginning of the values of [`Later`] in each expression, above all nodes.
const LATER: u32 = 1 << 29;

/// The expressions of plain outputs, which come after all definitions.
#[derive(Default, Debug)]
pub(super) struct Later {
    nodes: Vec<Node>,
    trees: Vec<(Output, Range<usize>)>,
}

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

impl<'e, 'a, 't> FunctionEmitter<'e, 'a, 't> {
    fn declare_inputs(&mut self) {
        let rank = |array: u32| {
            let text = match self.storage.arrays[array as usize].initial {
                Initial::Input(name) => self.shared.tables.symbols.text(name),
                Initial::Zero | Initial::Nothing => "",
            };
            let before = INPUT_ORDER.iter().take_while(|&&known| known != text);
            before.count()
        };
        let mut read: Vec<u32> = (0..self.storage.arrays.len() as u32)
            .filter(|&array| self.scan.read[array as usize])
            .collect();
        read.sort_by_key(|&array| rank(array));
        for array in read {
            self.declare_input(array);
        }
    }

    /// Declares the input that an array begins as, unless another one does.
    pub(in crate::lower) fn declare_input(&mut self, number: u32) {
        let array = self.storage.arrays[number as usize];
        let Initial::Input(name) = array.initial else {
            return;
        };
        let input = match self.declared.get(&name) {
            Some(&known) => known,
            None => {
                let shape = self.storage.input_shapes.get(&name).unwrap_or(&array.shape);
                self.function.add_input(name, *shape)
            }
        };
        self.declared.insert(name, input);
        self.inputs[number as usize] = Some(input);
    }

    /// Outputs in the order of the signature, then of first appearance.
    fn declare_outputs(&mut self) {
        let rank = |array: &u32| {
            let name = self.storage.arrays[*array as usize].name;
            let place = self.parameters.get(&name);
            // The fields of a sensor stand in the order of its structure, so
            // that no case of a file depends on what the others ask for.
            let text = self.shared.tables.symbols.text(name.symbol());
            let before = SENSOR_FIELDS.iter().take_while(|&&field| field != text);
            (place.copied().unwrap_or(usize::MAX), before.count())
        };
        let mut written: Vec<u32> = (0..self.storage.arrays.len() as u32)
            .filter(|&array| {
                let number = array as usize;
                let visible = !self.storage.arrays[number].local
                    || self.scan.passed[number]
                    || self.crossing.is_some();
                self.scan.written[number] && visible
            })
            .collect();
        written.sort_by_key(rank);
        for number in written {
            let array = self.storage.arrays[number as usize];
            let output = self.function.add_output(array.name.symbol(), array.shape);
            self.declared_outputs.insert(output.name);
            self.outputs[number as usize] = Some(output);
        }
    }

    pub(in crate::lower) fn scalar_input(&mut self, symbol: Symbol) -> Operand {
        match self.declared.get(&symbol).map(|array| array.shape) {
            None => {}
            Some(Shape::Scalar) => self.defined_twice(symbol),
            Some(Shape::Vector(_) | Shape::Matrix(..)) => self.both_scalar_and_array(symbol),
        }
        let array = self.function.add_input(symbol, Shape::Scalar);
        self.declared.insert(symbol, array);
        let operand = Operand::from(Input(array.offset));
        self.set_definition(symbol, operand);
        operand
    }
}
