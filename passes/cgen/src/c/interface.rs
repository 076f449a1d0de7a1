//! The interface of a C function: its signature, and its access to the elements
//! of its arrays.

use super::layout::{self, ElementOrder, Layout, OutputLayout, OutputLayouts};
use super::{Options, Real, Signature};
use crate::emit::arrays::{self, Rows};
use crate::emit::frame::ParameterList;
use crate::emit::names::{CNames, is_word_letter};
use crate::kind::{EquationKind, Generation, ProjectStructure, file_stem, model_name};
use hashbrown::HashMap;
use robovec_ir::{Array, Function, Input, Operand, Output, Shape, View};
use rustc_hash::FxBuildHasher;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// The reason why a function cannot have the signature of Robotran's.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum SignatureError {
    /// The function is of no kind that Robotran writes.
    #[error("'{0}' is not a function that Robotran writes (dirdyna, invdyna, cons_hJ, …)")]
    Kind(String),
    /// The function is one case of a file of sensors.
    #[error("'{0}' is one of the sensors of a file, which are written together")]
    Sensor(String),
    /// The function is a piece of one with loops.
    #[error("'{0}' is one part of a function with loops; the loops themselves are not there")]
    Part(String),
    /// User functions are called in the middle.
    #[error("'{function}' calls the user's '{callee}', which is written in one piece only")]
    Call {
        /// The function.
        function: String,
        /// The user's function.
        callee: String,
    },
    /// The function's project uses another signature for it.
    #[error(
        "generator 6.6 gives '{0}' the accelerations of independent joints to fill, but these equations have no partition of joints"
    )]
    OldStatus(String),
    /// An array cannot have its name in C.
    #[error("the array '{array}' of '{function}' has a name that is not allowed in C: rename it")]
    ArrayName {
        /// The function.
        function: String,
        /// The array.
        array: String,
    },
    /// An output is a single number.
    #[error(
        "the output '{output}' of '{function}' is a single number; Robotran's functions return arrays only"
    )]
    ScalarOutput {
        /// The function.
        function: String,
        /// The output.
        output: String,
    },
}

/// An element in C, and the local pointer it is reached by, if any.
pub(super) struct ElementExpression {
    pub(super) text: String,
    pub(super) pointer: Option<usize>,
}

/// A pointer that a part declares when it uses it.
pub(super) struct Pointer {
    pub(super) name: String,
    pub(super) declaration: String,
}

/// The way in which an array is reached.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum ArrayReach {
    /// A parameter with indices, or a number given by value.
    Parameter,
    /// A parameter that points to a number.
    Target,
    /// A parameter whose rows have pointers.
    Rows,
    /// A parameter that counts from 0, with one index.
    FromZero,
    /// A member of the model's data structure.
    Member,
}

struct ArrayAccess {
    name: String,
    reach: ArrayReach,
    /// The array is both given and given back.
    is_shared: bool,
}

/// The interface of a generated function.
pub(super) struct Interface<'a> {
    function: &'a Function,
    /// Robotran's kind; `None` with the plain signature.
    kind: Option<EquationKind>,
    /// The arrangement of arrays that count from 0.
    layout: Option<(ElementOrder, OutputLayouts)>,
    name: String,
    file: String,
    inputs: Vec<ArrayAccess>,
    outputs: Vec<ArrayAccess>,
    pub(super) pointers: Vec<Pointer>,
    by_row: HashMap<(bool, usize, u32), usize, FxBuildHasher>,
    /// The parameters of the function.
    pub(super) parameters: ParameterList,
    /// Parameters of the parts, except for the work array.
    pub(super) inner: ParameterList,
    /// All names in use so far.
    names: CNames,
}

impl<'a> Interface<'a> {
    pub(super) fn new(view: View<'a>, options: &Options) -> Result<Interface<'a>, SignatureError> {
        let mut interface = Interface {
            function: view.function,
            kind: None,
            layout: match (options.signature, options.layout) {
                (Signature::Plain, Layout::FromZero { order, is_sparse }) => {
                    Some((order, OutputLayouts::new(view.function, order, is_sparse)))
                }
                _ => None,
            },
            name: String::new(),
            file: String::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            pointers: Vec::new(),
            by_row: HashMap::default(),
            parameters: ParameterList::default(),
            inner: ParameterList::default(),
            names: CNames::new(),
        };
        match options.signature {
            Signature::Plain => interface.plain(view, options.real),
            Signature::Robotran => interface.robotran(view)?,
        }
        Ok(interface)
    }

    fn plain(&mut self, view: View<'_>, real: Real) {
        let symbols = &view.tables.symbols;
        self.name = self.names.take(&view.function.name);
        self.file.clone_from(&self.name);
        for (arrays, is_output) in [
            (view.function.inputs(), false),
            (view.function.outputs(), true),
        ] {
            for array in arrays {
                let name = self.names.take(symbols.text(array.name));
                let rows = match self.layout {
                    Some(_) => Rows::None,
                    None => Rows::Brackets,
                };
                let declaration = arrays::parameter(real, &name, array.shape, is_output, rows);
                let reach = match array.shape {
                    Shape::Scalar if is_output => ArrayReach::Target,
                    Shape::Scalar => ArrayReach::Parameter,
                    _ if self.layout.is_some() => ArrayReach::FromZero,
                    Shape::Vector(_) | Shape::Matrix(..) => ArrayReach::Parameter,
                };
                self.parameters.push(declaration, &name);
                let access = ArrayAccess {
                    name,
                    reach,
                    is_shared: false,
                };
                if is_output {
                    self.outputs.push(access);
                } else {
                    self.inputs.push(access);
                }
            }
        }
        self.inner.clone_from(&self.parameters);
    }

    fn robotran(&mut self, view: View<'_>) -> Result<(), SignatureError> {
        let function = view.function;
        let kind = robotran_kind(function)?;
        let model = model_name(function);
        self.kind = Some(kind);
        self.name = self.names.take(&format!(
            "{}{}",
            ProjectStructure::of(function).prefix,
            kind.name
        ));
        self.file = format!("mbs_{}_{}", kind.name, file_stem(model));
        for (name, _) in kind.outputs {
            self.names.take(name);
        }
        let data = ProjectStructure::of(function).name;
        for name in ["s", "tsim", data] {
            self.names.take(name);
        }
        for &(name, rank) in kind.outputs {
            let given = function
                .outputs()
                .iter()
                .chain(function.inputs())
                .any(|array| robotran_name(view.tables.symbols.text(array.name)) == name);
            let kind = format!("double {}", "*".repeat(rank));
            if given {
                self.inner.add(&kind, name);
            }
            self.parameters.add(&kind, name);
        }
        self.inner.add(&format!("const {data} *"), "s");
        self.parameters.add(&format!("{data} *"), "s");
        self.parameters.add("double ", "tsim");
        for array in function.inputs() {
            let access = self.access(view, array, kind, false)?;
            if access.reach == ArrayReach::Parameter {
                self.inner.add("double ", "tsim");
            }
            self.inputs.push(access);
        }
        for array in function.outputs() {
            let access = self.access(view, array, kind, true)?;
            self.outputs.push(access);
        }
        self.find_pointers();
        Ok(())
    }

    fn access(
        &self,
        view: View<'_>,
        array: &Array,
        kind: EquationKind,
        is_output: bool,
    ) -> Result<ArrayAccess, SignatureError> {
        let name = view.tables.symbols.text(array.name);
        let function = || view.function.name.clone();
        if !is_word(name) {
            return Err(SignatureError::ArrayName {
                function: function(),
                array: name.to_owned(),
            });
        }
        if is_output && array.shape == Shape::Scalar {
            return Err(SignatureError::ScalarOutput {
                function: function(),
                output: name.to_owned(),
            });
        }
        let others = if is_output {
            view.function.inputs()
        } else {
            view.function.outputs()
        };
        let name = robotran_name(name);
        let parameter = kind.outputs.iter().find(|(known, _)| *known == name);
        let reach = match (parameter, array.shape) {
            (None, Shape::Scalar) if name == "tsim" => ArrayReach::Parameter,
            (Some((_, 2)), _) => ArrayReach::Rows,
            (Some(_), _) => ArrayReach::Target,
            (None, _) => ArrayReach::Member,
        };
        Ok(ArrayAccess {
            name: name.to_owned(),
            reach,
            is_shared: others.iter().any(|other| other.name == array.name),
        })
    }

    /// Gives every vector and every row that is used a pointer.
    fn find_pointers(&mut self) {
        let mut rows = BTreeSet::new();
        let read = self.function.reads().filter_map(Operand::input);
        rows.extend(read.map(|input| (false, self.place(false, input.0))));
        let outputs = self.function.assignments.iter();
        rows.extend(outputs.map(|assignment| (true, self.place(true, assignment.output.0))));
        for (is_output, (number, indices, rank)) in rows {
            let (access, row) = self.row(is_output, number, indices, rank);
            let key = (is_output, number, row);
            let needs_none = rank == 0 || (rank == 1 && access.reach != ArrayReach::Member);
            if needs_none || self.by_row.contains_key(&key) {
                continue;
            }
            let source = match (access.reach, rank) {
                (ArrayReach::Member, 1) => format!("s->{}", access.name),
                (ArrayReach::Member, _) => format!("s->{}[{row}]", access.name),
                (_, _) => format!("{}[{row}]", access.name),
            };
            let qualifiers = match (is_output, access.is_shared) {
                (_, true) => ("", ""),
                (false, false) => ("const ", "restrict "),
                (true, false) => ("", "restrict "),
            };
            let wanted = match rank {
                1 => access.name.clone(),
                _ => format!("{}{row}", access.name),
            };
            let name = self.names.take(&wanted);
            let (constant, restrict) = qualifiers;
            self.by_row.insert(key, self.pointers.len());
            self.pointers.push(Pointer {
                declaration: format!("{constant}double *{restrict}{name} = {source};"),
                name,
            });
        }
    }

    /// Access to an array, and the row of an element in it.
    fn row(
        &self,
        is_output: bool,
        number: usize,
        indices: [u32; 2],
        rank: usize,
    ) -> (&ArrayAccess, u32) {
        let arrays = if is_output {
            &self.outputs
        } else {
            &self.inputs
        };
        (&arrays[number], if rank == 2 { indices[0] } else { 0 })
    }

    fn place(&self, is_output: bool, element: u32) -> (usize, [u32; 2], usize) {
        let (input, output) = (Input(element), Output(element));
        let function = self.function;
        let (number, (_, indices, rank)) = if is_output {
            (
                function.output_array(output),
                function.output_element(output),
            )
        } else {
            (function.input_array(input), function.input_element(input))
        };
        (number, indices, rank)
    }

    /// The text of an input (or output) element.
    pub(super) fn element(&self, is_output: bool, element: u32) -> ElementExpression {
        let (number, indices, rank) = self.place(is_output, element);
        let (access, row) = self.row(is_output, number, indices, rank);
        if let (ArrayReach::FromZero, Some((order, outputs))) = (access.reach, &self.layout) {
            let place = if is_output {
                let place = outputs.place(Output(element));
                place.expect("only elements that are kept are written")
            } else {
                let array = &self.function.inputs()[number];
                layout::place(array, element - array.offset, *order)
            };
            return ElementExpression {
                text: format!("{}[{place}]", access.name),
                pointer: None,
            };
        }
        let pointer = self.by_row.get(&(is_output, number, row)).copied();
        let text = match (pointer, rank) {
            (Some(pointer), _) => {
                format!("{}[{}]", self.pointers[pointer].name, indices[rank - 1])
            }
            (None, 0) => match access.reach {
                ArrayReach::Target => format!("*{}", access.name),
                ArrayReach::Member => format!("s->{}", access.name),
                ArrayReach::Parameter | ArrayReach::Rows | ArrayReach::FromZero => {
                    access.name.clone()
                }
            },
            (None, 1) => format!("{}[{}]", access.name, indices[0]),
            (None, _) => format!("{}[{}][{}]", access.name, indices[0], indices[1]),
        };
        ElementExpression { text, pointer }
    }

    /// The function without assignments of elements that the layout drops.
    pub(super) fn written<'f>(&self, function: &'f Function) -> Cow<'f, Function> {
        match &self.layout {
            Some((_, outputs)) if !function.assignments.iter().all(|set| outputs.keeps(set)) => {
                let mut written = function.clone();
                written.assignments.retain(|set| outputs.keeps(set));
                Cow::Owned(written)
            }
            _ => Cow::Borrowed(function),
        }
    }

    /// The outputs that count from 0, by the names of their parameters.
    pub(super) fn layouts(&self) -> Option<(ElementOrder, Vec<(&str, &OutputLayout)>)> {
        let (order, outputs) = self.layout.as_ref()?;
        let names = self.outputs.iter().map(|access| access.name.as_str());
        Some((*order, names.zip(&outputs.arrays).collect()))
    }

    /// True when writing an output may change an input.
    pub(super) fn overwrites(&self) -> bool {
        self.outputs.iter().any(|access| access.is_shared)
    }

    pub(super) fn is_robotran(&self) -> bool {
        self.kind.is_some()
    }

    /// The result type of the function.
    pub(super) fn result(&self) -> &'static str {
        result(self.kind)
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The name of the files, without extension.
    pub(super) fn file(&self) -> &str {
        &self.file
    }

    /// The header of the data structure.
    pub(super) fn data_header(&self) -> Option<&'static str> {
        self.kind
            .map(|_| ProjectStructure::of(self.function).header)
    }

    /// The names in use, for those that come.
    pub(super) fn names(&self) -> CNames {
        self.names.clone()
    }
}

/// The result type of a function of a kind.
pub(super) fn result(kind: Option<EquationKind>) -> &'static str {
    match kind {
        Some(kind) if kind.has_status() => "int",
        Some(_) | None => "void",
    }
}

/// The kind of a function that one bounded C function can represent.
fn robotran_kind(function: &Function) -> Result<EquationKind, SignatureError> {
    let name = || function.name.clone();
    if function.metadata("part").is_some() {
        return Err(SignatureError::Part(name()));
    }
    let (kind, _) = EquationKind::of(function).ok_or_else(|| SignatureError::Kind(name()))?;
    if kind.is_sensor() {
        return Err(SignatureError::Sensor(name()));
    }
    match function.boundaries.first() {
        None if kind.has_status() && Generation::of(function) == Generation::Old => {
            Err(SignatureError::OldStatus(name()))
        }
        None => Ok(kind),
        Some(call) => Err(SignatureError::Call {
            function: name(),
            callee: call.callee.clone(),
        }),
    }
}

/// The name of an array today.
fn robotran_name(name: &str) -> &str {
    if name == "Flnk" { "Flink" } else { name }
}

fn is_word(name: &str) -> bool {
    let mut characters = name.chars();
    characters
        .next()
        .is_some_and(|first| first.is_ascii_alphabetic())
        && characters.all(is_word_letter)
        && CNames::is_free(name)
}
