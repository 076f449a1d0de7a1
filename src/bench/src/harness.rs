//! The main program around a C function.
//!
//! Inputs come from `inputs.bin`: for every state all input elements in order
//! of declaration, as doubles. Arrays that differ are kept for each state,
//! parameters once. Results are the assigned elements, in order.

use super::functions::is_varying;
use robovec_cgen::c::Real;
use robovec_framework::template::fill;
use robovec_ir::{Array, Shape, View};
use std::fmt::Write;

#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum CallingConvention {
    /// Arrays one after the other, inputs first.
    Plain,
    /// Runs of this number of states, with these parameters prepared once.
    Batch(u32, Vec<String>),
    /// Several states in sequence, in one call, with these parameters shared.
    States(u32, Vec<String>),
    /// Robotran's: some outputs, the data structure, some scalars.
    Robotran(Vec<Parameter>),
}

impl CallingConvention {
    pub(super) fn lanes(&self) -> u32 {
        match self {
            CallingConvention::Batch(lanes, _) | CallingConvention::States(lanes, _) => *lanes,
            CallingConvention::Plain | CallingConvention::Robotran(_) => 1,
        }
    }

    /// True when all states have an input array of this name in common.
    fn shares(&self, name: &str) -> bool {
        match self {
            CallingConvention::Batch(_, shared) | CallingConvention::States(_, shared) => {
                shared.iter().any(|known| known == name)
            }
            CallingConvention::Plain | CallingConvention::Robotran(_) => false,
        }
    }

    /// Place of an element, lane `l`, in an array of a group's lanes.
    fn place(&self, element: &str, extent: &str) -> String {
        match self {
            CallingConvention::States(..) => format!("l * {extent} + {element}"),
            _ => format!("({element}) * LANES + l"),
        }
    }
}

/// A parameter of a function as Robotran writes it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Parameter {
    /// An output array by its name.
    Output(String),
    /// The structure with all inputs.
    Data,
    /// A number that is an input of this name, or 0.
    Scalar(String),
}

/// The file that declares `MbsData` for a function's inputs and outputs.
pub(super) fn data_header(view: View<'_>) -> String {
    let mut text = String::from(
        "#ifndef ROBOVEC_BENCH_MBS_DATA_H\n#define ROBOVEC_BENCH_MBS_DATA_H\ntypedef struct {\n",
    );
    let mut names: Vec<&str> = Vec::new();
    for array in view.function.inputs().iter().chain(view.function.outputs()) {
        let name = view.tables.symbols.text(array.name);
        if names.contains(&name) {
            continue;
        }
        names.push(name);
        let stars = match array.shape {
            Shape::Scalar => "",
            Shape::Vector(_) => "*",
            Shape::Matrix(..) => "**",
        };
        let _ = writeln!(text, "    double {stars}{name};");
    }
    text + "    double **robovec_bench_;\n} MbsData;\ntypedef MbsData MBSdataStruct;\n#endif\n"
}

/// A function that a main program calls.
pub(super) struct Callee<'a> {
    /// The equations that it computes.
    pub(super) view: View<'a>,
    pub(super) real: Real,
    pub(super) call: &'a CallingConvention,
    pub(super) header: &'a str,
    pub(super) name: &'a str,
}

/// The text of the main program that calls a function in this number of states.
pub(super) fn main(callee: &Callee<'_>, states: u32) -> String {
    let &Callee {
        view,
        real,
        call,
        header,
        name,
    } = callee;
    let (lanes, real) = (call.lanes(), real.name());
    let mut writer = HarnessWriter {
        view,
        call,
        real,
        lanes,
        storage: String::new(),
        fill: String::new(),
        arguments: Vec::new(),
        shared: Vec::new(),
        bases: Vec::new(),
    };
    writer.inputs();
    if let CallingConvention::Batch(..) = call {
        writer.arguments.push("prepared".to_owned());
        writer.shared.push("prepared".to_owned());
        writer.storage +=
            &format!("static {real} prepared[{name}_PREPARED] __attribute__((aligned(64)));\n");
    }
    writer.outputs();
    let mut before = String::new();
    let body = match call {
        CallingConvention::Plain => format!("    {name}({});\n", writer.arguments.join(", ")),
        CallingConvention::Batch(..) => {
            before = format!("    {name}_prepare({});\n", writer.shared.join(", "));
            format!("    {name}_batch({});\n", writer.arguments.join(", "))
        }
        CallingConvention::States(..) => {
            let states = ["STATES".to_owned()];
            let arguments = [&states, writer.arguments.as_slice()].concat().join(", ");
            format!("    if ({name}_states({arguments})) bench_fail(\"there is no memory\");\n")
        }
        CallingConvention::Robotran(parameters) => writer.robotran(name, parameters),
    };
    let inputs = view.function.input_len();
    let outputs = view.function.assignments.len();
    let HarnessWriter {
        storage,
        fill: fill_lines,
        bases,
        ..
    } = writer;
    let place = call.place("output_list[i][1]", "output_list[i][2]");
    fill(
        include_str!("harness.c"),
        &[
            ("header", &header),
            ("real", &real),
            ("lanes", &lanes),
            ("states", &states),
            ("inputs", &inputs),
            ("outputs", &outputs),
            ("storage", &storage),
            ("fill", &fill_lines),
            ("body", &body),
            ("bases", &bases.join(", ")),
            ("place", &place),
            ("before", &before),
        ],
    )
}

struct HarnessWriter<'a> {
    view: View<'a>,
    call: &'a CallingConvention,
    real: &'static str,
    lanes: u32,
    storage: String,
    fill: String,
    arguments: Vec<String>,
    /// Arguments of the function that prepares shared parameters.
    shared: Vec<String>,
    /// Place where each output array of a group begins.
    bases: Vec<String>,
}

impl HarnessWriter<'_> {
    fn name(&self, array: &Array) -> &str {
        self.view.tables.symbols.text(array.name)
    }

    /// Writes the storage of the inputs, and the copying of a state into it.
    fn inputs(&mut self) {
        let robotran = matches!(self.call, CallingConvention::Robotran(_));
        if robotran {
            self.storage += "static MbsData data[STATES];\n";
        }
        for (index, array) in self.view.function.inputs().iter().enumerate() {
            let name = self.name(array).to_owned();
            let varying = is_varying(&name);
            let (states, group) = if varying {
                ("[STATES / LANES]", "[g]")
            } else {
                ("[1]", "[0]")
            };
            let extent = extent(array.shape);
            let shared = self.call.shares(&name);
            let lanes = if shared { 1 } else { self.lanes };
            let _ = writeln!(
                self.storage,
                "static {} i{index}{states}[{extent} * {lanes}] __attribute__((aligned(64)));",
                self.real
            );
            let offset = array.offset;
            let element = format!("i{index}{group}");
            let lane = match (varying, shared) {
                (true, _) => "1",
                (false, true) => "s == 0",
                (false, false) => "s < LANES",
            };
            let place = |own: &str| {
                if shared {
                    own.to_owned()
                } else {
                    self.call.place(own, &extent)
                }
            };
            let (loops, own, from) = match array.shape {
                Shape::Scalar => (String::new(), "0".to_owned(), String::new()),
                Shape::Vector(length) => (
                    format!("for (int k = 0; k < {length}; k++) "),
                    "k + 1".to_owned(),
                    " + k".to_owned(),
                ),
                Shape::Matrix(rows, columns) => (
                    format!(
                        "for (int r = 0; r < {rows}; r++) for (int k = 0; k < {columns}; k++)\n        "
                    ),
                    format!("(r + 1) * ({columns} + 1) + k + 1"),
                    format!(" + r * {columns} + k"),
                ),
            };
            let place = place(&own);
            let _ = writeln!(
                self.fill,
                "    if ({lane}) {loops}{element}[{place}] = in[{offset}{from}];"
            );
            if robotran {
                self.field(index, &name, array.shape, &element);
            } else {
                let argument = self.argument(&element, array.shape, true);
                // What prepares shared arrays is called on its own for batches.
                let apart = shared && matches!(self.call, CallingConvention::Batch(..));
                let list = if apart {
                    &mut self.shared
                } else {
                    &mut self.arguments
                };
                list.push(argument);
            }
        }
    }

    fn field(&mut self, index: usize, name: &str, shape: Shape, element: &str) {
        match shape {
            Shape::Scalar => {
                let _ = writeln!(self.fill, "    data[s].{name} = {element}[0];");
            }
            Shape::Vector(_) => {
                let _ = writeln!(self.fill, "    data[s].{name} = {element};");
            }
            Shape::Matrix(rows, columns) => {
                let states = if is_varying(name) { "[STATES]" } else { "[1]" };
                let state = if is_varying(name) { "[s]" } else { "[0]" };
                let _ = writeln!(self.storage, "static double *r{index}{states}[{rows} + 1];");
                let _ = writeln!(
                    self.fill,
                    "    for (int r = 0; r <= {rows}; r++) r{index}{state}[r] = {element} + r * ({columns} + 1);\n    data[s].{name} = r{index}{state};"
                );
            }
        }
    }

    fn argument(&self, element: &str, shape: Shape, input: bool) -> String {
        let constant = if input { "const " } else { "" };
        match (self.call, shape, input) {
            (CallingConvention::Plain, Shape::Scalar, true) => format!("{element}[0]"),
            (CallingConvention::Plain, Shape::Matrix(_, columns), _) => {
                format!("({constant}{} (*)[{columns} + 1]){element}", self.real)
            }
            _ => element.to_owned(),
        }
    }

    /// Storage of the outputs, and where each result is found.
    fn outputs(&mut self) {
        let function = self.view.function;
        for (index, array) in function.outputs().iter().enumerate() {
            let extent = extent(array.shape);
            let lanes = self.lanes;
            if let Some(input) = self.updated(array) {
                self.bases.push(input);
                continue;
            }
            let _ = writeln!(
                self.storage,
                "static {} o{index}[{extent} * {lanes}] __attribute__((aligned(64)));",
                self.real
            );
            let own = format!("o{index}");
            self.bases.push(own.clone());
            if !matches!(self.call, CallingConvention::Robotran(_)) {
                let argument = self.argument(&own, array.shape, false);
                self.arguments.push(argument);
            } else if self.is_in_data(array) {
                let name = self.name(array).to_owned();
                self.field(function.inputs().len() + index, &name, array.shape, &own);
            }
        }
        self.storage += "static const int output_list[][3] = {\n";
        for assignment in &function.assignments {
            let (array, indices, _) = function.output_element(assignment.output);
            let place = function.output_array(assignment.output);
            let offset = match array.shape {
                Shape::Scalar => 0,
                Shape::Vector(_) => indices[0],
                Shape::Matrix(_, columns) => indices[0] * (columns + 1) + indices[1],
            };
            let extent = extent(array.shape);
            let _ = writeln!(self.storage, "    {{ {place}, {offset}, {extent} }},");
        }
        self.storage += "};\n";
    }

    /// True for an output of a Robotran function in the data structure.
    fn is_in_data(&self, array: &Array) -> bool {
        let CallingConvention::Robotran(parameters) = self.call else {
            return false;
        };
        let mut parameters = parameters.iter();
        let name = self.name(array);
        !parameters.any(|known| matches!(known, Parameter::Output(own) if own == name))
    }

    /// Places of the elements of a group that are set in an input array.
    fn updated(&self, array: &Array) -> Option<String> {
        let mut inputs = self.view.function.inputs().iter();
        let index = inputs.position(|input| input.name == array.name)?;
        let group = if is_varying(self.name(array)) {
            "g"
        } else {
            "0"
        };
        self.is_in_data(array).then(|| format!("i{index}[{group}]"))
    }

    /// The call of a function as Robotran writes it.
    fn robotran(&mut self, name: &str, parameters: &[Parameter]) -> String {
        let function = self.view.function;
        let mut arguments = Vec::new();
        let mut rows = String::new();
        for parameter in parameters {
            arguments.push(match parameter {
                Parameter::Data => "&data[g]".to_owned(),
                Parameter::Scalar(_) => "0.0".to_owned(),
                Parameter::Output(wanted) => {
                    let found = function.outputs().iter().zip(0..);
                    let mut found = found.filter(|(array, _)| self.name(array) == wanted);
                    match found.next() {
                        None => "0".to_owned(),
                        Some((array, index)) => match array.shape {
                            Shape::Matrix(height, columns) => {
                                let _ = writeln!(
                                    rows,
                                    "    static double *rows{index}[{height} + 1];\n    if (!rows{index}[0]) for (int r = 0; r <= {height}; r++) rows{index}[r] = o{index} + r * ({columns} + 1);"
                                );
                                format!("rows{index}")
                            }
                            Shape::Scalar | Shape::Vector(_) => format!("o{index}"),
                        },
                    }
                }
            });
        }
        format!("{rows}    {name}({});\n", arguments.join(", "))
    }
}

/// The extent of an array that counts from 1.
fn extent(shape: Shape) -> String {
    match shape {
        Shape::Scalar => "1".to_owned(),
        Shape::Vector(length) => format!("({length} + 1)"),
        Shape::Matrix(rows, columns) => format!("({rows} + 1) * ({columns} + 1)"),
    }
}
