//! A main program that tries generated C, or compares it with others' C.
//!
//! It fills one state, calls every contestant, compares the outputs with those
//! of the evaluator at this state, and prints the differences; its exit code is
//! 0 when they agree. With the argument `time` it also measures: processor time
//! of the thread, least of many short windows, the contestants in turn, so that
//! a loaded machine affects all equally. With `print` it prints the outputs.
//!
//! **Distance.** An output is off by its difference relative to the largest
//! expected number of its array: elements that nearly cancel have no correct
//! digits to compare.

use super::interface::result;
use super::{Options, Real, Signature};
use crate::emit::arrays::{Rows, dimensions, parameter, rank};
use crate::emit::frame::ParameterList;
use crate::emit::names::is_word_letter;
use crate::kind::{EquationKind, ProjectStructure};
use robovec_framework::template::fill;
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Array, Input, View};
use robovec_num::arithmetic::Binary64;
use std::fmt::Write;

/// A state, and the outputs of a function there.
#[derive(Clone, PartialEq, Debug)]
pub struct TrialState {
    /// One number per input element, in order of declaration.
    pub inputs: Vec<f64>,
    /// One number per assignment of the function, in its order.
    pub expected: Vec<f64>,
    /// The largest distance that counts as agreement.
    pub tolerance: f64,
}

impl TrialState {
    /// A trial of a function at a state; the expected outputs come from the
    /// evaluator in binary64.
    pub fn new(view: View<'_>, inputs: Vec<f64>, tolerance: f64) -> TrialState {
        TrialState {
            expected: evaluate(view.function, &Binary64, &inputs),
            inputs,
            tolerance,
        }
    }
}

/// The text of a main program for functions of one signature: that of `view`
/// with these options. `contestants` are the names they are linked under;
/// ratios are relative to the first one.
pub fn trial_main(
    view: View<'_>,
    options: &Options,
    contestants: &[&str],
    trial: &TrialState,
) -> String {
    let main = Main {
        view,
        real: match options.signature {
            Signature::Robotran => Real::Double,
            Signature::Plain => options.real,
        },
        kind: match options.signature {
            Signature::Robotran => EquationKind::of(view.function).map(|(kind, _)| kind),
            Signature::Plain => None,
        },
        data: ProjectStructure::of(view.function),
        trial,
    };
    main.text(contestants)
}

/// A `mbs_data.h` with the parts of MBsysC's structure that functions use, to
/// compile them without MBsysC. MBsysC's own header has these members under the
/// same names. Gives its name and text.
pub fn minimal_data<'a>(views: impl IntoIterator<Item = View<'a>>) -> (String, String) {
    let vectors = ["q", "qd", "qdd", "Qq", "m", "g", "lrod"].map(|name| (name, 1));
    let matrices = ["dpt", "l", "In", "frc", "trq"].map(|name| (name, 2));
    let mut members: Vec<(&str, usize)> = vectors.into_iter().chain(matrices).collect();
    let mut views = views.into_iter().peekable();
    let first = views.peek().map(|view| ProjectStructure::of(view.function));
    let (header, name) = first.map_or(("mbs_data.h", "MbsData"), |data| (data.header, data.name));
    for view in views {
        for array in view.function.inputs().iter().chain(view.function.outputs()) {
            let name = view.tables.symbols.text(array.name);
            let is_word = name.chars().all(is_word_letter);
            if is_word && name != "tsim" && members.iter().all(|(known, _)| *known != name) {
                members.push((name, rank(array.shape)));
            }
        }
    }
    let guard = header.to_ascii_uppercase().replace('.', "_");
    let mut text = format!(
        "/* What generated functions reach of MBsysC's structure: enough to try them\n   \
         alone. In a project use MBsysC's own header. Arrays count from 1. */\n\
         #ifndef ROBOVEC_{guard}\n#define ROBOVEC_{guard}\n\ntypedef struct {name}\n{{\n",
    );
    for (member, rank) in members {
        let _ = writeln!(text, "    double {}{member};", "*".repeat(rank));
    }
    let _ = write!(text, "}} {name};\n\n#endif\n");
    (header.to_owned(), text)
}

/// An array that the program keeps.
struct Stored {
    /// The member or parameter.
    name: String,
    /// The name of its storage.
    storage: String,
    rows: u64,
    columns: u64,
    rank: usize,
}

impl Stored {
    /// The address of an element.
    fn place(&self, indices: [u32; 2], rank: usize) -> String {
        let [row, column] = indices;
        match rank {
            0 => format!("&{}[0]", self.storage),
            1 => format!("&{}[{row}]", self.storage),
            _ => format!("&{}[{row}][{column}]", self.storage),
        }
    }
}

/// Contents of a main program.
struct Main<'a> {
    view: View<'a>,
    real: Real,
    kind: Option<EquationKind>,
    /// The names of the project, for functions of a kind.
    data: ProjectStructure,
    trial: &'a TrialState,
}

impl Main<'_> {
    fn text(&self, contestants: &[&str]) -> String {
        let (stored, inputs, outputs) = self.storage();
        let (parameters, arguments) = (self.parameters(), self.arguments(&stored));
        let result = result(self.kind);
        let include = match self.kind {
            Some(_) => format!("#include \"{}\"\n", self.data.header),
            None => String::new(),
        };
        let declared = |name: &&str| format!("{result} {name}({parameters});\n");
        let clear = |Stored { storage, .. }: &Stored| {
            format!("    memset({storage}, 0, sizeof {storage});\n")
        };
        let call = |(number, name): (usize, &&str)| {
            format!("    case {number}: {name}({arguments}); break;\n")
        };
        let names: Vec<String> = contestants.iter().map(|n| format!("\"{n}\"")).collect();
        fill(
            include_str!("trial.c"),
            &[
                ("real", &self.real.name()),
                ("include", &include),
                ("storage", &self.declarations(&stored)),
                (
                    "contestants",
                    &contestants.iter().map(declared).collect::<String>(),
                ),
                ("given", &self.given(&stored, &inputs)),
                ("expected", &self.expected(&stored, &outputs)),
                ("tolerance", &format!("{:e}", self.trial.tolerance)),
                ("set_up", &self.set_up(&stored)),
                ("clear", &stored.iter().map(clear).collect::<String>()),
                (
                    "calls",
                    &contestants.iter().enumerate().map(call).collect::<String>(),
                ),
                ("count", &contestants.len()),
                ("names", &names.join(", ")),
            ],
        )
    }

    /// The arrays, and for every input and output array its storage.
    fn storage(&self) -> (Vec<Stored>, Vec<usize>, Vec<usize>) {
        let mut stored: Vec<Stored> = Vec::new();
        let mut add = |array: &Array, prefix: &str| {
            let mut name = self.view.tables.symbols.text(array.name).to_owned();
            if self.kind.is_some() && name == "Flnk" {
                "Flink".clone_into(&mut name);
            }
            // With Robotran's signature what is given and given back is one.
            let storage = match self.kind {
                Some(_) => format!("its_{name}"),
                None => format!("{prefix}_{}", stored.len()),
            };
            let [rows, columns] = dimensions(array.shape);
            if let Some(known) = stored.iter().position(|known| known.storage == storage) {
                stored[known].rows = stored[known].rows.max(rows);
                stored[known].columns = stored[known].columns.max(columns);
                return known;
            }
            stored.push(Stored {
                name,
                storage,
                rows,
                columns,
                rank: rank(array.shape),
            });
            stored.len() - 1
        };
        let function = self.view.function;
        let inputs = function
            .inputs()
            .iter()
            .map(|array| add(array, "given"))
            .collect();
        let outputs = function
            .outputs()
            .iter()
            .map(|array| add(array, "result"))
            .collect();
        for (name, rank) in self.kind.iter().flat_map(|kind| kind.outputs) {
            if stored.iter().all(|known| known.name != *name) {
                stored.push(Stored {
                    name: (*name).to_owned(),
                    storage: format!("its_{name}"),
                    rows: 1,
                    columns: 1,
                    rank: *rank,
                });
            }
        }
        (stored, inputs, outputs)
    }

    fn declarations(&self, stored: &[Stored]) -> String {
        let real = self.real.name();
        let mut text = String::new();
        for array in stored {
            let (storage, rows, columns) = (&array.storage, array.rows, array.columns);
            let rows_of = match array.rank {
                2 => format!("[{rows}]"),
                _ => String::new(),
            };
            let _ = writeln!(text, "static {real} {storage}{rows_of}[{columns}];");
            if array.rank == 2 && self.kind.is_some() {
                let _ = writeln!(text, "static double *rows_of_{}[{rows}];", array.name);
            }
        }
        if self.kind.is_some() {
            let _ = writeln!(text, "static {} data;", self.data.name);
        }
        text
    }

    fn parameters(&self) -> String {
        let mut list = ParameterList::default();
        if let Some(kind) = self.kind {
            for (name, rank) in kind.outputs {
                list.add(&format!("double {}", "*".repeat(*rank)), name);
            }
            list.add(&format!("{} *", self.data.name), "s");
            list.add("double ", "tsim");
            return list.declared();
        }
        let function = self.view.function;
        let inputs = function.inputs().iter().map(|array| (array.shape, false));
        let outputs = function.outputs().iter().map(|array| (array.shape, true));
        for (shape, is_output) in inputs.chain(outputs) {
            let declared = parameter(self.real, "", shape, is_output, Rows::Brackets);
            list.push(declared.trim_end().to_owned(), "");
        }
        list.declared()
    }

    /// The state, and its place.
    fn given(&self, stored: &[Stored], inputs: &[usize]) -> String {
        let function = self.view.function;
        assert_eq!(
            self.trial.inputs.len(),
            function.input_len(),
            "one number per input element"
        );
        let line = |(index, number): (u32, &f64)| {
            let at = function.input_array(Input(index));
            let (_, indices, rank) = function.input_element(Input(index));
            let place = stored[inputs[at]].place(indices, rank);
            format!("    {{{place}, {}}},\n", literal(*number))
        };
        (0u32..).zip(&self.trial.inputs).map(line).collect()
    }

    /// Expected results, and their places.
    fn expected(&self, stored: &[Stored], outputs: &[usize]) -> String {
        let function = self.view.function;
        assert_eq!(
            self.trial.expected.len(),
            function.assignments.len(),
            "one number per output"
        );
        let norms = self.norms();
        let mut text = String::new();
        for (assignment, number) in function.assignments.iter().zip(&self.trial.expected) {
            let at = function.output_array(assignment.output);
            let (array, indices, rank) = function.output_element(assignment.output);
            let place = stored[outputs[at]].place(indices, rank);
            let name = self.view.tables.symbols.text(array.name);
            let indices = indices[..rank].iter().map(|index| format!("[{index}]"));
            let name = name.to_owned() + &indices.collect::<String>();
            let (number, norm) = (literal(*number), literal(norms[at]));
            let _ = writeln!(text, "    {{{place}, {number}, {norm}, \"{name}\"}},");
        }
        text
    }

    /// For each output array the largest expected number, 1 when all are 0.
    fn norms(&self) -> Vec<f64> {
        let function = self.view.function;
        let mut norms = vec![0.0f64; function.outputs().len()];
        for (assignment, number) in function.assignments.iter().zip(&self.trial.expected) {
            let at = function.output_array(assignment.output);
            norms[at] = norms[at].max(number.abs());
        }
        norms
            .into_iter()
            .map(|norm| if norm > 0.0 { norm } else { 1.0 })
            .collect()
    }

    /// The lines that point the structure at the arrays.
    fn set_up(&self, stored: &[Stored]) -> String {
        let Some(kind) = self.kind else {
            return String::new();
        };
        let mut text = String::new();
        for array in stored {
            let (name, storage, rows) = (&array.name, &array.storage, array.rows);
            let is_member = kind.outputs.iter().all(|(known, _)| known != name)
                || matches!(name.as_str(), "frc" | "trq");
            let value = match array.rank {
                0 => format!("{storage}[0]"),
                1 => storage.clone(),
                _ => format!("rows_of_{name}"),
            };
            if array.rank == 2 {
                let _ = writeln!(
                    text,
                    "    for (int i = 0; i < {rows}; i++) {value}[i] = {storage}[i];"
                );
            }
            if is_member && name != "tsim" {
                let _ = writeln!(text, "    data.{name} = {value};");
            }
        }
        text
    }

    fn arguments(&self, stored: &[Stored]) -> String {
        let list: Vec<String> = match self.kind {
            Some(kind) => {
                let argument = |(name, rank): &(&str, usize)| match rank {
                    2 => format!("rows_of_{name}"),
                    _ => format!("its_{name}"),
                };
                let time = stored.iter().find(|array| array.name == "tsim");
                let time = time.map_or("0".to_owned(), |time| format!("{}[0]", time.storage));
                let outputs = kind.outputs.iter().map(argument);
                outputs.chain(["&data".to_owned(), time]).collect()
            }
            None => {
                let inputs = self.view.function.inputs().len();
                let argument = |(number, array): (usize, &Stored)| match array.rank {
                    0 if number < inputs => format!("{}[0]", array.storage),
                    2 if number < inputs => {
                        format!(
                            "(const {} (*)[{}]){}",
                            self.real.name(),
                            array.columns,
                            array.storage
                        )
                    }
                    _ => array.storage.clone(),
                };
                stored.iter().enumerate().map(argument).collect()
            }
        };
        list.join(", ")
    }
}

/// A number in decimal digits that read back as the same bits.
fn literal(number: f64) -> String {
    if number.is_nan() {
        return "NAN".to_owned();
    }
    if number.is_infinite() {
        return if number > 0.0 {
            "INFINITY"
        } else {
            "-INFINITY"
        }
        .to_owned();
    }
    format!("{number:e}")
}
