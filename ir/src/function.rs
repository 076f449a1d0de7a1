//! A function: named arrays in, straight-line nodes, named arrays out.
//!
//! One structure serves every level. Nodes are in program order, which is
//! also a topological order: an operand is always an earlier node. At the
//! equations level the nodes without a name are the inner nodes of the
//! expression tree of the next named node (or output) that uses them.

use crate::entity::{Constant, Input, Operand, OperandKind, Output, Value};
use crate::history::Histories;
use crate::placement::{Placement, Schedule};
use crate::source::SourceSet;
use crate::symbol::{FreshNames, Name, Symbol};
use crate::value_formats::ValueFormats;
use hashbrown::HashMap;
use robovec_num::operation::Operation;
use rustc_hash::FxBuildHasher;
use std::fmt;

/// The maximum number of elements that all input arrays may have together:
/// every evaluation, check and placement keeps hundreds of bytes for each. A
/// model of 130 joints has a few thousand.
pub const MAX_INPUT_ELEMENTS: u64 = 1 << 20;

/// The maximum number of elements that all output arrays may have together: a
/// mass matrix of 2000 joints has four million, most of them zeros that cost
/// little.
pub const MAX_OUTPUT_ELEMENTS: u64 = 1 << 22;

robovec_num::named! {
    /// The degree to which a function has been lowered; each level is a property
    /// that the verifier checks, not another data structure.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
    pub enum Level {
        /// A definition is an expression tree, as Robotran prints it.
        Equations = "equations",
        /// A definition is one operation.
        Atomic = "atomic",
        /// Every operation has a cycle and a processing element.
        Scheduled = "scheduled",
        /// Addresses, transfers and buffers are decided as well.
        Placed = "placed",
    }
}

impl fmt::Display for Level {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// One operation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Node {
    /// The name, or [`Name::NONE`] for an inner node of an expression tree.
    pub name: Name,
    /// The equations the node comes from.
    pub sources: SourceSet,
    /// The operands, filled up with [`Operand::NONE`]; see [`Operand::list`].
    pub operands: [Operand; Operand::MAX_COUNT],
    /// The operation that is computed.
    pub operation: Operation,
}

impl Node {
    /// The operands that are present.
    #[inline]
    pub fn operands(&self) -> &[Operand] {
        &self.operands[..self.operation.arity()]
    }

    /// The operands that are values, in order.
    #[inline]
    pub fn values(&self) -> impl Iterator<Item = Value> + '_ {
        // All places are looked at: those behind the operands hold none, and
        // a loop of three is cheaper than one that asks how many there are.
        self.operands.iter().filter_map(|operand| operand.value())
    }
}

/// The extent of an array: a scalar, a vector `1..n` or a matrix
/// `1..rows, 1..columns`. Indices count from 1, as in Robotran.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Shape {
    /// A single number.
    Scalar,
    /// `1..n`.
    Vector(u32),
    /// `1..rows, 1..columns`, stored row by row.
    Matrix(u32, u32),
}

impl Shape {
    /// The number of elements; saturates instead of overflowing.
    pub fn len(self) -> usize {
        match self {
            Shape::Scalar => 1,
            Shape::Vector(length) => length as usize,
            Shape::Matrix(rows, columns) => (rows as usize).saturating_mul(columns as usize),
        }
    }

    /// True for an array without elements.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The place of an element, counted from 0, row by row; `None` when the
    /// number of indices is wrong or one is out of range.
    pub fn offset(self, indices: &[u32]) -> Option<u32> {
        match (self, indices) {
            (Shape::Scalar, []) => Some(0),
            (Shape::Vector(length), &[i]) if (1..=length).contains(&i) => Some(i - 1),
            (Shape::Matrix(rows, columns), &[i, j])
                if (1..=rows).contains(&i) && (1..=columns).contains(&j) =>
            {
                Some((i - 1) * columns + j - 1)
            }
            _ => None,
        }
    }

    /// The indices of an element, the inverse of [`Shape::offset`].
    pub fn indices(self, offset: u32) -> ([u32; 2], usize) {
        match self {
            Shape::Scalar => ([0, 0], 0),
            Shape::Vector(_) => ([offset + 1, 0], 1),
            Shape::Matrix(_, columns) => ([offset / columns + 1, offset % columns + 1], 2),
        }
    }
}

/// A named input or output array.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Array {
    /// The name in the user's file, without the structure it lives in.
    pub name: Symbol,
    /// Extent.
    pub shape: Shape,
    /// Index of its first element among the flattened inputs (or outputs).
    pub offset: u32,
}

impl Array {
    /// Name and extent.
    pub fn declaration(&self) -> (Symbol, Shape) {
        (self.name, self.shape)
    }
}

/// Places of the elements of arrays in other arrays: those with the same name
/// and indices, `None` where there is none.
pub fn places_by_name(old: &[Array], new: &[Array]) -> Vec<Option<u32>> {
    let elements = old.iter().flat_map(|array| {
        let target = new.iter().find(|other| other.name == array.name);
        (0..array.shape.len() as u32).map(move |offset| {
            let (indices, rank) = array.shape.indices(offset);
            let place = target?.shape.offset(&indices[..rank])?;
            Some(target?.offset + place)
        })
    });
    elements.collect()
}

/// The value of one output element.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Assignment {
    /// The element.
    pub output: Output,
    /// The operand it is set to.
    pub operand: Operand,
    /// The equation that sets it.
    pub sources: SourceSet,
}

/// A call of a user function (`user_ExtForces` and its like) in the middle of
/// a file. It cannot be compiled, so its arguments become outputs of the
/// function and its result an input: the caller evaluates up to the
/// arguments, calls, and evaluates the rest.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Boundary {
    /// The user's function.
    pub callee: String,
    /// The arguments as written; those that name an output array of this
    /// function contain its computed values.
    pub arguments: Vec<String>,
    /// The input array that holds the result; `None` for a call without one.
    pub result: Option<String>,
    /// The source places of the call.
    pub sources: SourceSet,
}

/// Earliest and latest times of an operation (thesis 2.2.1 and 2.2.2). All four
/// count from the start of the run to the moment the result is *available*:
/// inputs are available at 0.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Timing {
    /// Earliest, in operations.
    pub asap: u32,
    /// Latest that does not lengthen the longest path, in operations.
    pub alap: u32,
    /// Earliest, in cycles of the machine.
    pub asap_cycle: u32,
    /// Latest, in cycles of the machine.
    pub alap_cycle: u32,
}

impl Timing {
    /// The number of cycles the operation can wait without lengthening the
    /// longest path.
    pub fn mobility(self) -> u32 {
        self.alap_cycle - self.asap_cycle
    }
}

/// A straight-line function.
#[derive(Clone, Debug)]
pub struct Function {
    /// Its name (`dirdyna`; `sensor_3` for the third case of a sensor file).
    pub name: String,
    /// The present level of the function.
    pub level: Level,
    /// The entries of the file's header: `model`, `generator`, `joints` ….
    pub metadata: Vec<(String, String)>,
    /// User calls, in program order.
    pub boundaries: Vec<Boundary>,
    /// Output values, in order of the output elements.
    pub assignments: Vec<Assignment>,
    /// Earliest and latest times of every node, after `asap-alap`.
    pub timing: Option<Vec<Timing>>,
    /// Cycle and processing element of every node, from level `scheduled`.
    pub schedule: Option<Schedule>,
    /// Memory addresses and transfers, from level `placed`.
    pub placement: Option<Placement>,
    /// Number formats of single values, from level `atomic`; `None` for a
    /// function whose values all have that of the run.
    pub formats: Option<ValueFormats>,
    /// The histories of all values; kept only on request.
    pub histories: Option<Histories>,
    inputs: Vec<Array>,
    outputs: Vec<Array>,
    nodes: Vec<Node>,
    constants: Vec<f64>,
    constant_index: HashMap<u64, u32, FxBuildHasher>,
}

impl Function {
    /// An empty function of a level.
    pub fn new(name: &str, level: Level) -> Function {
        Function {
            name: name.to_owned(),
            level,
            metadata: Vec::new(),
            boundaries: Vec::new(),
            assignments: Vec::new(),
            timing: None,
            schedule: None,
            placement: None,
            formats: None,
            histories: None,
            inputs: Vec::new(),
            outputs: Vec::new(),
            nodes: Vec::new(),
            constants: Vec::new(),
            constant_index: HashMap::default(),
        }
    }

    /// A function with the same name, metadata and user calls, without arrays
    /// and body.
    pub fn header(&self, level: Level) -> Function {
        Function {
            metadata: self.metadata.clone(),
            boundaries: self.boundaries.clone(),
            ..Function::new(&self.name, level)
        }
    }

    /// A function with the same name, signature and metadata and no body: the
    /// start of a pass that rewrites the body. Properties of single nodes, such
    /// as their formats, must be copied by the pass.
    pub fn skeleton(&self, level: Level) -> Function {
        Function {
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            ..self.header(level)
        }
    }

    /// The function with these arrays declared; the caller keeps names unique.
    pub fn with_arrays(
        mut self,
        inputs: impl IntoIterator<Item = (Symbol, Shape)>,
        outputs: impl IntoIterator<Item = (Symbol, Shape)>,
    ) -> Function {
        for (name, shape) in inputs {
            self.add_input(name, shape);
        }
        for (name, shape) in outputs {
            self.add_output(name, shape);
        }
        self
    }

    /// The function with the arrays of another one, which has no body. Elements
    /// that are read or set move to those that `input` and `output` give;
    /// assignments without such an element are dropped. Values keep their
    /// numbers.
    pub fn moved_into(
        &self,
        mut new: Function,
        input: impl Fn(Input) -> Input,
        output: impl Fn(Output) -> Option<Output>,
    ) -> Function {
        let operand = |new: &mut Function, old: Operand| match old.kind() {
            OperandKind::Input(old) => input(old).into(),
            OperandKind::Constant(old) => new.constant(self.constant_number(old)).into(),
            OperandKind::Value(_) | OperandKind::None => old,
        };
        new.reserve(self.nodes.len());
        for node in &self.nodes {
            let operands = node.operands.map(|old| operand(&mut new, old));
            new.push(Node { operands, ..*node });
        }
        for set in &self.assignments {
            if let Some(output) = output(set.output) {
                let operand = operand(&mut new, set.operand);
                new.assignments.push(Assignment {
                    output,
                    operand,
                    ..*set
                });
            }
        }
        new.sort_assignments();
        new
    }

    /// Declares an input array; the caller keeps names unique.
    pub fn add_input(&mut self, name: Symbol, shape: Shape) -> Array {
        push_array(&mut self.inputs, name, shape)
    }

    /// Declares an output array; the caller keeps names unique.
    pub fn add_output(&mut self, name: Symbol, shape: Shape) -> Array {
        push_array(&mut self.outputs, name, shape)
    }

    /// The input arrays, in order of declaration.
    pub fn inputs(&self) -> &[Array] {
        &self.inputs
    }

    /// The output arrays, in order of declaration.
    pub fn outputs(&self) -> &[Array] {
        &self.outputs
    }

    /// Number of elements of all input arrays.
    pub fn input_len(&self) -> usize {
        flattened_len(&self.inputs)
    }

    /// Number of elements of all output arrays.
    pub fn output_len(&self) -> usize {
        flattened_len(&self.outputs)
    }

    /// The array of an input element and the element's indices.
    pub fn input_element(&self, input: Input) -> (&Array, [u32; 2], usize) {
        element(&self.inputs, input.0)
    }

    /// The array of an output element and the element's indices.
    pub fn output_element(&self, output: Output) -> (&Array, [u32; 2], usize) {
        element(&self.outputs, output.0)
    }

    /// The index of the input array that holds an element.
    pub fn input_array(&self, input: Input) -> usize {
        holder(&self.inputs, input.0)
    }

    /// The index of the output array that holds an element.
    pub fn output_array(&self, output: Output) -> usize {
        holder(&self.outputs, output.0)
    }

    /// The nodes, in program order.
    #[inline]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The node of a value.
    #[inline]
    pub fn node(&self, value: Value) -> &Node {
        &self.nodes[value.index()]
    }

    /// The node of a value, to be changed in place; its operands must stay
    /// earlier nodes.
    #[inline]
    pub fn node_mut(&mut self, value: Value) -> &mut Node {
        &mut self.nodes[value.index()]
    }

    /// The values with their nodes, in program order.
    pub fn values(&self) -> impl DoubleEndedIterator<Item = (Value, &Node)> + '_ {
        self.nodes
            .iter()
            .enumerate()
            .map(|(index, node)| (Value(index as u32), node))
    }

    /// Appends a node whose operands are earlier nodes.
    #[inline]
    pub fn push(&mut self, node: Node) -> Value {
        let value = Value(self.nodes.len() as u32);
        self.nodes.push(node);
        value
    }

    /// Appends an assignment.
    pub fn assign(&mut self, output: Output, operand: Operand, sources: SourceSet) {
        self.assignments.push(Assignment {
            output,
            operand,
            sources,
        });
    }

    /// Makes room for a number of nodes.
    pub fn reserve(&mut self, nodes: usize) {
        self.nodes.reserve(nodes);
    }

    /// The constant with this number; equal bits give equal constants.
    pub fn constant(&mut self, number: f64) -> Constant {
        let next = self.constants.len() as u32;
        let index = *self.constant_index.entry(number.to_bits()).or_insert(next);
        if index == next {
            self.constants.push(number);
        }
        Constant(index)
    }

    /// The table of constants.
    #[inline]
    pub fn constants(&self) -> &[f64] {
        &self.constants
    }

    /// The number of a constant.
    #[inline]
    pub fn constant_number(&self, constant: Constant) -> f64 {
        self.constants[constant.index()]
    }

    /// The number an operand represents, when it is a constant.
    #[inline]
    pub fn number(&self, operand: Operand) -> Option<f64> {
        operand
            .constant()
            .map(|constant| self.constant_number(constant))
    }

    /// The operands of all nodes, then those of the assignments.
    pub fn reads(&self) -> impl Iterator<Item = Operand> + '_ {
        let nodes = self.nodes.iter().flat_map(Node::operands);
        let outputs = self.assignments.iter().map(|output| &output.operand);
        nodes.chain(outputs).copied()
    }

    /// The number of reads of each value, by nodes and outputs together.
    pub fn use_counts(&self) -> Vec<u32> {
        let mut counts = vec![0; self.nodes.len()];
        for value in self.nodes.iter().flat_map(Node::values) {
            counts[value.index()] += 1;
        }
        let outputs = self.assignments.iter();
        for value in outputs.filter_map(|output| output.operand.value()) {
            counts[value.index()] += 1;
        }
        counts
    }

    /// A generator of names that no value of this function has.
    pub fn fresh_names(&self) -> FreshNames {
        FreshNames::new(self.nodes.iter().map(|node| node.name))
    }

    /// The metadata under a key.
    pub fn metadata(&self, key: &str) -> Option<&str> {
        self.metadata
            .iter()
            .find(|(name, _)| name == key)
            .map(|(_, text)| text.as_str())
    }

    /// Sorts the assignments by output element, the order of the text form.
    pub fn sort_assignments(&mut self) {
        self.assignments.sort_by_key(|assignment| assignment.output);
    }
}

fn push_array(arrays: &mut Vec<Array>, name: Symbol, shape: Shape) -> Array {
    let array = Array {
        name,
        shape,
        offset: flattened_len(arrays) as u32,
    };
    arrays.push(array);
    array
}

fn flattened_len(arrays: &[Array]) -> usize {
    arrays
        .last()
        .map_or(0, |array| array.offset as usize + array.shape.len())
}

/// The index of the array that holds an element. Empty arrays share their
/// offset with the next one, so it is the last that starts at or before the
/// element.
fn holder(arrays: &[Array], index: u32) -> usize {
    arrays.partition_point(|array| array.offset <= index) - 1
}

fn element(arrays: &[Array], index: u32) -> (&Array, [u32; 2], usize) {
    let array = &arrays[holder(arrays, index)];
    let (indices, rank) = array.shape.indices(index - array.offset);
    (array, indices, rank)
}
