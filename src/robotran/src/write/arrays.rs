//! The arrays of a file: where each lives, and how its elements are written.

use super::error::RobotranWriteError;
use super::file::EquationKind;
use super::names::is_array_name;
use crate::Language;
use hashbrown::HashMap;
use robovec_ir::{Array, Function, Input, OperandKind, Shape, Symbol, Symbols};
use rustc_hash::FxBuildHasher;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum ArrayRole {
    /// A parameter of the signature, or a return value of Matlab.
    Parameter,
    /// A field of the sensor.
    Sensor,
    /// A member of the model's data structure.
    Data,
    /// Filled here and handed to a user function.
    Argument,
    /// The result of a user function.
    Result,
}

/// An array of the file, under one name for its inputs and outputs.
#[derive(Clone, Debug)]
pub(super) struct FileArray {
    pub(super) name: String,
    pub(super) shape: Shape,
    pub(super) role: ArrayRole,
    pub(super) is_input: bool,
    pub(super) is_output: bool,
    /// Largest indices of its elements that are read or written; else zeros.
    pub(super) largest: (u32, u32),
}

/// The arrays of the functions that make up a file, in order of appearance.
#[derive(Debug)]
pub(super) struct FileArrays {
    pub(super) all: Vec<FileArray>,
    numbers: HashMap<Symbol, usize, FxBuildHasher>,
    by_name: HashMap<String, usize, FxBuildHasher>,
}

impl FileArrays {
    pub(super) fn new(
        functions: &[&Function],
        kind: EquationKind,
        symbols: &Symbols,
        language: Language,
    ) -> Result<FileArrays, RobotranWriteError> {
        let mut arrays = FileArrays {
            all: Vec::new(),
            numbers: HashMap::default(),
            by_name: HashMap::default(),
        };
        for function in functions {
            let roles = Roles::new(function, kind);
            check_sensor(function, kind, symbols)?;
            for (array, is_output) in (function.inputs().iter().map(|array| (array, false)))
                .chain(function.outputs().iter().map(|array| (array, true)))
            {
                let name = symbols.text(array.name);
                let role = roles.of(name, is_output);
                check(function, array, name, role, is_output, language)?;
                arrays.add(array, name, role, is_output);
            }
            arrays.note_uses(function);
        }
        Ok(arrays)
    }

    fn note_uses(&mut self, function: &Function) {
        let mut read = vec![false; function.input_len()];
        let nodes = function.nodes().iter().flat_map(|node| node.operands());
        let outputs = function.assignments.iter().map(|output| &output.operand);
        for operand in nodes.chain(outputs) {
            if let OperandKind::Input(input) = operand.kind() {
                read[input.index()] = true;
            }
        }
        let read = (0..read.len()).filter(|&place| read[place]);
        let read = read.map(|place| function.input_element(Input(place as u32)));
        let written = function.assignments.iter();
        let written = written.map(|assignment| function.output_element(assignment.output));
        for (array, indices, _) in read.chain(written) {
            let (rows, columns) = match array.shape {
                // A number has no indices, and is used all the same.
                Shape::Scalar => (1, 1),
                Shape::Vector(_) | Shape::Matrix(..) => (indices[0], indices[1]),
            };
            let known = &mut self.all[self.numbers[&array.name]].largest;
            *known = (known.0.max(rows), known.1.max(columns));
        }
    }

    fn add(&mut self, array: &Array, name: &str, role: ArrayRole, is_output: bool) {
        let next = self.all.len();
        let number = *self.numbers.entry(array.name).or_insert(next);
        if number == next {
            self.by_name.insert(name.to_owned(), number);
            self.all.push(FileArray {
                name: name.to_owned(),
                shape: array.shape,
                role,
                is_input: false,
                is_output: false,
                largest: (0, 0),
            });
        }
        let known = &mut self.all[number];
        known.shape = larger(known.shape, array.shape);
        known.is_input |= !is_output;
        known.is_output |= is_output;
    }

    /// The array of a symbol, which one of the functions has.
    pub(super) fn of(&self, symbol: Symbol) -> &FileArray {
        &self.all[self.numbers[&symbol]]
    }

    pub(super) fn find(&self, name: &str) -> Option<&FileArray> {
        self.by_name.get(name).map(|&number| &self.all[number])
    }
}

/// The extent that covers both.
fn larger(a: Shape, b: Shape) -> Shape {
    match (a, b) {
        (Shape::Vector(a), Shape::Vector(b)) => Shape::Vector(a.max(b)),
        (Shape::Matrix(a, b), Shape::Matrix(c, d)) => Shape::Matrix(a.max(c), b.max(d)),
        (a, _) => a,
    }
}

impl FileArray {
    /// Text of an input element, before the indices. Matlab reads all arrays
    /// but the coordinates from the structure, where each keeps its value.
    pub(super) fn input_text(&self, language: Language) -> String {
        let own = matches!(self.role, ArrayRole::Argument | ArrayRole::Result);
        let name = &self.name;
        match (self.shape, language) {
            _ if own => name.clone(),
            (Shape::Scalar, Language::C) => format!("s->{name}"),
            (Shape::Scalar, _) => format!("s.{name}"),
            // Where a parameter is given, it is the structure's own array.
            (_, Language::Python) if self.role == ArrayRole::Parameter => format!("s.{name}"),
            (_, Language::C | Language::Python) => self.output_text(language),
            (_, Language::Matlab) if self.has_alias(language) => name.clone(),
            (_, Language::Matlab) => format!("s.{name}"),
        }
    }

    /// Text of an output element, before the indices.
    pub(super) fn output_text(&self, language: Language) -> String {
        match language {
            Language::C => self.name.replace('.', "->"),
            Language::Matlab | Language::Python => self.name.clone(),
        }
    }

    /// True for a member of the data structure that gets its own name first.
    pub(super) fn has_alias(&self, language: Language) -> bool {
        let coordinates = matches!(self.name.as_str(), "q" | "qd" | "qdd");
        self.role == ArrayRole::Data
            && self.is_used()
            && self.shape != Shape::Scalar
            && (language != Language::Matlab || (coordinates && !self.is_output))
    }

    /// True when an element is read or written.
    pub(super) fn is_used(&self) -> bool {
        self.largest != (0, 0)
    }

    /// Number of indices.
    pub(super) fn rank(&self) -> usize {
        match self.shape {
            Shape::Scalar => 0,
            Shape::Vector(_) => 1,
            Shape::Matrix(..) => 2,
        }
    }
}

/// Facts that decide about the arrays of a function.
struct Roles<'a> {
    kind: EquationKind,
    arguments: hashbrown::HashSet<&'a str, FxBuildHasher>,
    results: hashbrown::HashSet<&'a str, FxBuildHasher>,
}

impl<'a> Roles<'a> {
    fn new(function: &'a Function, kind: EquationKind) -> Roles<'a> {
        let calls = &function.boundaries;
        Roles {
            kind,
            arguments: calls
                .iter()
                .flat_map(|call| call.arguments.iter().map(String::as_str))
                .collect(),
            results: calls
                .iter()
                .filter_map(|call| call.result.as_deref())
                .collect(),
        }
    }

    fn of(&self, name: &str, is_output: bool) -> ArrayRole {
        let parameter =
            |&(known, _): &(&str, usize)| name == known || (known, name) == ("Flink", "Flnk");
        if name.starts_with("sens.") && self.kind.is_sensor() {
            ArrayRole::Sensor
        } else if self.kind.outputs.iter().any(parameter) {
            ArrayRole::Parameter
        } else if is_output && self.arguments.contains(name) {
            ArrayRole::Argument
        } else if !is_output && self.results.contains(name) {
            ArrayRole::Result
        } else {
            ArrayRole::Data
        }
    }
}

/// Of a sensor's function Matlab gives back the sensor only.
fn check_sensor(
    function: &Function,
    kind: EquationKind,
    symbols: &Symbols,
) -> Result<(), RobotranWriteError> {
    let mut outputs = function.outputs().iter();
    let foreign = outputs.find(|array| !symbols.text(array.name).starts_with("sens."));
    match foreign {
        Some(array) if kind.is_sensor() => Err(RobotranWriteError::SensorOutput {
            function: function.name.clone(),
            output: symbols.text(array.name).to_owned(),
        }),
        Some(_) | None => Ok(()),
    }
}

fn check(
    function: &Function,
    array: &Array,
    name: &str,
    role: ArrayRole,
    is_output: bool,
    language: Language,
) -> Result<(), RobotranWriteError> {
    let word = match role {
        ArrayRole::Sensor => &name["sens.".len()..],
        _ => name,
    };
    // The time is the one number that every function is given beside arrays.
    let time = array.shape == Shape::Scalar && name == "tsim" && !is_output;
    if !time && !is_array_name(word) {
        return Err(RobotranWriteError::ArrayName {
            function: function.name.clone(),
            array: name.to_owned(),
            language: language.name(),
        });
    }
    if is_output && array.shape == Shape::Scalar && role != ArrayRole::Argument {
        return Err(RobotranWriteError::ScalarOutput {
            function: function.name.clone(),
            output: name.to_owned(),
        });
    }
    Ok(())
}
