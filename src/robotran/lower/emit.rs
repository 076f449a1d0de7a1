//! One straight-line function, written equation by equation.
//!
//! Invariant: the nodes of an equation are appended in the order of the
//! arena, so the node `first + k` of the arena is the value `base + k` of the
//! function.

use super::names::GivenNames;
use super::scan::{READ_BACK, REWRITTEN, Scan};
use crate::robotran::Language;
use crate::robotran::conventions::{INPUT_ORDER, SENSOR_FIELDS};
use crate::robotran::explain::refusal;
use crate::robotran::places::LineIndex;
use crate::robotran::storage::{Initial, Storage};
use crate::robotran::syntax::{LeafKind, StatementKind, SyntaxLeaf, SyntaxTree};
use crate::robotran::token::{RobotranName, SourceSpan};
use hashbrown::{HashMap, HashSet};
use robovec_ir::diagnostic::{Diagnostic, Label};
use robovec_ir::{
    Array, Assignment, Function, Input, Name, Node, Operand, Operation, Output, Shape, SourceSet,
    Symbol, Tables, Value,
};
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

/// What the head and the declarations of a function say.
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

/// What all functions of a file share.
pub(super) struct Shared<'a, 't> {
    pub(super) syntax: &'a SyntaxTree,
    pub(super) text: &'t str,
    pub(super) tables: &'a mut Tables,
    pub(super) places: &'a mut LineIndex<'t>,
    pub(super) language: Language,
    /// The definition of every scalar, by symbol; empty between functions.
    pub(super) definitions: Vec<Operand>,
}

/// Where the values of [`Later`] start to count, within each expression; no
/// function has as many nodes.
const LATER: u32 = 1 << 29;

/// The expressions of plain outputs. They are resolved where they stand in the
/// file but appended behind all definitions, where the representation wants
/// them.
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

    fn declare_inputs(&mut self) {
        let rank = |array: u32| {
            let text = match self.storage.arrays[array as usize].initial {
                Initial::Input(name) => self.shared.tables.symbols.text(name),
                Initial::Zero | Initial::Nothing => "",
            };
            let known = INPUT_ORDER.iter().position(|&known| known == text);
            known.unwrap_or(INPUT_ORDER.len())
        };
        let mut read: Vec<u32> = (0..self.storage.arrays.len() as u32)
            .filter(|&array| self.scan.read[array as usize])
            .collect();
        read.sort_by_key(|&array| rank(array));
        for array in read {
            self.declare_input(array);
        }
    }

    /// Declares the input that an array begins as, unless another array
    /// begins as the same.
    pub(super) fn declare_input(&mut self, number: u32) {
        let array = self.storage.arrays[number as usize];
        let Initial::Input(name) = array.initial else {
            return;
        };
        let known = self.declared.get(&name).copied();
        let input = known.unwrap_or_else(|| {
            let shape = self.storage.input_shape(name).unwrap_or(array.shape);
            self.function.add_input(name, shape)
        });
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
            let field = SENSOR_FIELDS.iter().position(|field| *field == text);
            (
                place.copied().unwrap_or(usize::MAX),
                field.unwrap_or(SENSOR_FIELDS.len()),
            )
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
            if self.errors.len() >= crate::robotran::ERROR_LIMIT {
                break;
            }
        }
    }

    pub(super) fn sources(&mut self, span: SourceSpan) -> SourceSet {
        let place = self.shared.places.place(span);
        self.shared.tables.sources.single(place)
    }

    fn equation(
        &mut self,
        target: SyntaxLeaf,
        root: SyntaxLeaf,
        run: Range<u32>,
        span: SourceSpan,
    ) {
        if let LeafKind::Scalar(name) = target.kind()
            && (self.signature.counters.contains(&name.symbol()) || self.is_flag(name))
        {
            return;
        }
        let sources = self.sources(span);
        let syntax = self.shared.syntax;
        let fresh = matches!(root.kind(), LeafKind::Node(_));
        let output = match target.kind() {
            LeafKind::Element(element) if fresh => {
                self.plain_output(syntax.elements[element as usize].row)
            }
            _ => None,
        };
        let base = match output {
            Some(_) => LATER,
            None => self.function.nodes().len() as u32,
        };
        let start = self.later.nodes.len();
        for node in &syntax.nodes[run.start as usize..run.end as usize] {
            let left = self.operand(node.operands[0], base, run.start);
            let right = match node.operation.arity() {
                2 => self.operand(node.operands[1], base, run.start),
                _ => Operand::NONE,
            };
            let node = Node {
                name: Name::NONE,
                sources,
                operands: Operand::list([left, right]),
                operation: node.operation,
            };
            match output {
                Some(_) => self.later.nodes.push(node),
                None => {
                    self.function.push(node);
                }
            }
        }
        if let Some(output) = output {
            self.later
                .trees
                .push((output, start..self.later.nodes.len()));
            return;
        }
        let operand = self.operand(root, base, run.start);
        match target.kind() {
            LeafKind::Scalar(name) => self.define(name, operand, fresh, sources),
            LeafKind::Element(element) => {
                let slot = syntax.elements[element as usize].row;
                self.write(slot, operand, fresh, sources);
            }
            LeafKind::Node(_) | LeafKind::Number(_) => {}
        }
    }

    /// `s->flag_stop = 1;` of a guard file.
    fn is_flag(&self, name: RobotranName) -> bool {
        name.is_of_data() && self.shared.tables.symbols.text(name.symbol()) == "flag_stop"
    }

    fn operand(&mut self, leaf: SyntaxLeaf, base: u32, first: u32) -> Operand {
        match leaf.kind() {
            LeafKind::Node(index) => Operand::from(Value(base + (index - first))),
            LeafKind::Number(index) => {
                let number = self.shared.syntax.numbers[index as usize].number();
                Operand::from(self.function.constant(number))
            }
            LeafKind::Scalar(name) => self.scalar(name),
            LeafKind::Element(element) => {
                let element = self.shared.syntax.elements[element as usize];
                self.element(element.row, element.column)
            }
        }
    }

    fn element(&mut self, slot: u32, array: u32) -> Operand {
        let value = self.elements[slot as usize];
        if !value.is_none() {
            return value;
        }
        let stored = self.storage.arrays[array as usize];
        match stored.initial {
            Initial::Input(_) => {
                let (indices, rank) = stored.shape.indices(slot - stored.offset);
                let input = self.inputs[array as usize];
                // The input is as large as all arrays that begin as it.
                let place = input.and_then(|input| {
                    let offset = input.shape.offset(&indices[..rank])?;
                    Some(Input(input.offset + offset))
                });
                match place {
                    Some(place) => Operand::from(place),
                    None => Operand::from(self.function.constant(0.0)),
                }
            }
            // Reading nothing is an error that the scan has reported.
            Initial::Zero | Initial::Nothing => Operand::from(self.function.constant(0.0)),
        }
    }

    fn scalar(&mut self, name: RobotranName) -> Operand {
        let symbol = name.symbol();
        let known = self.shared.definitions[symbol.index()];
        if !known.is_none() {
            if self.shared.language == Language::C && name.is_of_data() && known.input().is_none() {
                self.member_of_data(symbol);
            }
            return known;
        }
        if self.signature.counters.contains(&symbol) || self.signature.whole.contains(&name) {
            self.whole_number(symbol);
            return Operand::from(self.function.constant(0.0));
        }
        // The type of any other number of the structure is not known here.
        if self.shared.language == Language::C
            && name.is_of_data()
            && self.shared.tables.symbols.text(symbol) != "tsim"
        {
            self.member_of_data(symbol);
        }
        let given = name.is_of_data()
            || (self.parameters.contains_key(&name) && self.storage.find(name).is_none())
            || self
                .crossing
                .is_some_and(|crossing| crossing.inputs.contains(&symbol));
        if given {
            return self.scalar_input(symbol);
        }
        if self.missing_known.insert(symbol) {
            self.missing.push((symbol, self.statement));
        }
        Operand::from(self.function.constant(0.0))
    }

    pub(super) fn scalar_input(&mut self, symbol: Symbol) -> Operand {
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

    /// A number of the data structure that is not known to be a 64-bit float,
    /// or that a variable of the same name hides.
    fn member_of_data(&mut self, symbol: Symbol) {
        if !self.missing_known.insert(symbol) {
            return;
        }
        let text = self.shared.tables.symbols.text(symbol).to_owned();
        self.errors.push(refusal(
            &format!("`{text}` of the data structure is used as a number"),
            self.shared.syntax.statements[self.statement].span,
            "its type and its number are not known here",
            "the inputs of the equations are the arrays of the structure and the time `tsim`",
        ));
    }

    fn whole_number(&mut self, symbol: Symbol) {
        if !self.missing_known.insert(symbol) {
            return;
        }
        let text = self.shared.tables.symbols.text(symbol).to_owned();
        self.errors.push(refusal(
            &format!("`{text}` is a whole number and is read in an equation"),
            self.shared.syntax.statements[self.statement].span,
            "whole numbers are divided and rounded in another way",
            "declare it `double`, or write its number in its place",
        ));
    }

    pub(super) fn both_scalar_and_array(&mut self, symbol: Symbol) {
        let text = self.shared.tables.symbols.text(symbol).to_owned();
        self.errors.push(refusal(
            &format!("`{text}` is used as a number and as an array"),
            self.shared.syntax.statements[self.statement].span,
            "as a number here",
            "write the index, or give one of the two another name",
        ));
    }

    fn set_definition(&mut self, symbol: Symbol, operand: Operand) {
        if symbol.index() >= self.shared.definitions.len() {
            let length = symbol.index() + 1;
            self.shared.definitions.resize(length, Operand::NONE);
        }
        self.shared.definitions[symbol.index()] = operand;
        self.defined.push(symbol);
    }

    fn define(&mut self, name: RobotranName, operand: Operand, fresh: bool, sources: SourceSet) {
        let symbol = name.symbol();
        if self.shared.language == Language::C && name.is_of_data() {
            self.member_of_data(symbol);
            return;
        }
        if self.signature.given.contains(&name) && self.storage.find(name).is_none() {
            self.errors.push(refusal(
                "a parameter is assigned to",
                self.shared.syntax.statements[self.statement].span,
                "from here on it would be another number",
                "give the number another name",
            ));
            return;
        }
        if self.storage.find(name).is_some() {
            self.errors.push(refusal(
                "an array is assigned to without an index",
                self.shared.syntax.statements[self.statement].span,
                "which element is meant?",
                "write the index, or give the temporary another name",
            ));
            return;
        }
        if self.names.is_defined(symbol) && self.crossing.is_none() {
            self.defined_twice(symbol);
            return;
        }
        let name = self.names.scalar(symbol);
        let value = self.named(name, operand, fresh, sources);
        self.set_definition(symbol, value);
    }

    /// Names a value: a fresh node takes the name itself, anything else is
    /// copied.
    fn named(&mut self, name: Name, operand: Operand, fresh: bool, sources: SourceSet) -> Operand {
        if fresh && let Some(value) = operand.value() {
            self.function.node_mut(value).name = name;
            return operand;
        }
        Operand::from(self.function.push(Node {
            name,
            sources,
            operands: Operand::list([operand]),
            operation: Operation::Copy,
        }))
    }

    pub(super) fn defined_twice(&mut self, symbol: Symbol) {
        let text = self.shared.tables.symbols.text(symbol).to_owned();
        let again = self.shared.syntax.statements[self.statement].span;
        let first = self.first_definition(symbol).unwrap_or(again);
        self.errors.push(
            Diagnostic::error()
                .with_message(format!("`{text}` is defined twice"))
                .with_labels(vec![
                    Label::primary(0, again.range()).with_message("defined again here"),
                    Label::secondary(0, first.range()).with_message("first defined here"),
                ])
                .with_note("every temporary has one equation; rename or delete one of the two"),
        );
    }

    fn first_definition(&self, symbol: Symbol) -> Option<SourceSpan> {
        let mut statements = self.shared.syntax.statements[..self.statement].iter();
        let found = statements.rfind(|statement| match statement.kind {
            StatementKind::Equation { target, .. } => defines(Some(target), symbol),
            StatementKind::Call(call) => {
                defines(self.shared.syntax.calls[call as usize].target, symbol)
            }
            _ => false,
        });
        found.map(|statement| statement.span)
    }

    /// The output element of a slot that is written once and never read back.
    fn plain_output(&self, slot: u32) -> Option<Output> {
        let (array, _, _) = self.storage.element(slot);
        let output = self.outputs[self.storage.find(array.name)? as usize]?;
        let plain = self.scan.flags[slot as usize] & (REWRITTEN | READ_BACK) == 0;
        plain.then_some(Output(output.offset + (slot - array.offset)))
    }

    pub(super) fn write(&mut self, slot: u32, operand: Operand, fresh: bool, sources: SourceSet) {
        if let Some(output) = self.plain_output(slot) {
            self.function.assignments.push(Assignment {
                output,
                operand,
                sources,
            });
            return;
        }
        let (array, indices, rank) = self.storage.element(slot);
        let symbols = &mut self.shared.tables.symbols;
        let name = self
            .names
            .element(symbols, array.name.symbol(), &indices[..rank]);
        let value = self.named(name, operand, fresh, sources);
        if self.elements[slot as usize].is_none() {
            self.named_elements.push(slot);
        }
        self.elements[slot as usize] = value;
    }

    /// Appends the expressions that stand behind all definitions, in order of
    /// the outputs they give.
    fn append_trees(&mut self) {
        let Later { nodes, mut trees } = std::mem::take(&mut self.later);
        trees.sort_by_key(|&(output, _)| output);
        for (output, run) in trees {
            let base = self.function.nodes().len() as u32;
            let moved = |operand: Operand| match operand.value() {
                Some(Value(index)) if index >= LATER => Operand::from(Value(base + index - LATER)),
                Some(_) | None => operand,
            };
            let mut root = None;
            for node in &nodes[run] {
                root = Some(self.function.push(Node {
                    operands: node.operands.map(moved),
                    ..*node
                }));
            }
            if let Some(root) = root {
                self.function.assignments.push(Assignment {
                    output,
                    operand: Operand::from(root),
                    sources: self.function.node(root).sources,
                });
            }
        }
    }

    /// Finishes the function: the last value of every element that became a
    /// named value, and the scalars other parts read.
    pub(super) fn finish(mut self) -> EmittedFunction {
        for slot in std::mem::take(&mut self.named_elements) {
            let (array, _, _) = self.storage.element(slot);
            let number = self.storage.find(array.name).unwrap_or(0) as usize;
            let operand = self.elements[slot as usize];
            if let (Some(output), Some(node)) = (self.outputs[number], operand.value()) {
                let sources = self.function.node(node).sources;
                self.function.assignments.push(Assignment {
                    output: Output(output.offset + (slot - array.offset)),
                    operand,
                    sources,
                });
            }
        }
        if let Some(crossing) = self.crossing {
            let mut seen = SymbolSet::default();
            for symbol in self.defined.clone() {
                let operand = self.shared.definitions[symbol.index()];
                if crossing.outputs.contains(&symbol)
                    && seen.insert(symbol)
                    && let Some(node) = operand.value()
                {
                    let sources = self.function.node(node).sources;
                    self.scalar_output(symbol, operand, sources);
                }
            }
        }
        self.append_trees();
        self.function.sort_assignments();
        for symbol in self.defined {
            self.shared.definitions[symbol.index()] = Operand::NONE;
        }
        EmittedFunction {
            function: self.function,
            missing: self.missing,
            errors: self.errors,
            warnings: self.warnings,
        }
    }
}

/// True for the assignment to a scalar.
fn defines(target: Option<SyntaxLeaf>, symbol: Symbol) -> bool {
    let kind = target.map(SyntaxLeaf::kind);
    matches!(kind, Some(LeafKind::Scalar(name)) if name.symbol() == symbol)
}

/// A function that was written, and what was found wrong with it.
pub(super) struct EmittedFunction {
    pub(super) function: Function,
    pub(super) missing: Vec<(Symbol, usize)>,
    pub(super) errors: Vec<Diagnostic>,
    pub(super) warnings: Vec<Diagnostic>,
}
