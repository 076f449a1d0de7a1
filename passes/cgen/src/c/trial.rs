//! A main program that tries generated C, or compares it with others' C.
//!
//! It fills one state, calls every contestant, compares the outputs with
//! what the evaluator gave at this state, and says how far they are off; its
//! exit code says whether they agree. With the argument `time` it also
//! measures: processor time of the thread, least of many short windows, the
//! contestants in turn, so that a loaded machine disturbs all alike. With
//! `print` it prints the outputs.
//!
//! **Distance.** An output is off by its difference relative to the largest
//! expected number of its array: elements that nearly cancel have no digits
//! of their own to agree in.

use super::{Options, Real, Signature};
use crate::emit::arrays::{Rows, dimensions, parameter, rank};
use crate::emit::frame::parameters;
use crate::emit::names::is_word_letter;
use crate::kind::{EquationKind, ProjectStructure};
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Array, Input, View};
use robovec_num::arithmetic::Binary64;
use std::fmt::Write;

/// A state, and what a function gives there.
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
    /// A trial of a function at a state; what is expected comes from the
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
/// the first one is what ratios are told against.
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
        contestants,
        trial,
    };
    main.text()
}

/// A `mbs_data.h` that declares what functions reach in MBsysC's structure and
/// little else, to compile them without MBsysC. MBsysC's own
/// header has these members under the same names. Gives its name and text.
pub fn minimal_data<'a>(views: impl IntoIterator<Item = View<'a>>) -> (String, String) {
    let mut members: Vec<(String, usize)> = [
        ("q", 1),
        ("qd", 1),
        ("qdd", 1),
        ("Qq", 1),
        ("m", 1),
        ("g", 1),
        ("lrod", 1),
        ("dpt", 2),
        ("l", 2),
        ("In", 2),
        ("frc", 2),
        ("trq", 2),
    ]
    .into_iter()
    .map(|(name, rank)| (name.to_owned(), rank))
    .collect();
    let mut views = views.into_iter().peekable();
    let first = views.peek().map(|view| ProjectStructure::of(view.function));
    let (header, name) = first.map_or(("mbs_data.h", "MbsData"), |data| (data.header, data.name));
    for view in views {
        for array in view.function.inputs().iter().chain(view.function.outputs()) {
            let name = view.tables.symbols.text(array.name);
            let is_word = name.chars().all(is_word_letter);
            if is_word && name != "tsim" && members.iter().all(|(known, _)| known != name) {
                members.push((name.to_owned(), rank(array.shape)));
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

struct Main<'a> {
    view: View<'a>,
    real: Real,
    kind: Option<EquationKind>,
    contestants: &'a [&'a str],
    trial: &'a TrialState,
}

impl Main<'_> {
    fn text(&self) -> String {
        let (stored, inputs, outputs) = self.storage();
        let mut text = String::from(
            "#define _POSIX_C_SOURCE 199309L\n#include <math.h>\n#include <stdio.h>\n\
             #include <string.h>\n#include <time.h>\n",
        );
        if self.kind.is_some() {
            let _ = writeln!(
                text,
                "#include \"{}\"",
                ProjectStructure::of(self.view.function).header
            );
        }
        text.push('\n');
        self.declarations(&mut text, &stored);
        self.tables(&mut text, &stored, &inputs, &outputs);
        self.calls(&mut text, &stored);
        text.push_str(&DRIVER.replace("REAL", self.real.name()));
        text
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

    fn declarations(&self, text: &mut String, stored: &[Stored]) {
        let real = self.real.name();
        for array in stored {
            let (storage, rows, columns) = (&array.storage, array.rows, array.columns);
            let extent = match (array.rank, self.kind) {
                (2, _) => format!("[{rows}][{columns}]"),
                (_, _) => format!("[{columns}]"),
            };
            let _ = writeln!(text, "static {real} {storage}{extent};");
            if array.rank == 2 && self.kind.is_some() {
                let _ = writeln!(text, "static double *rows_of_{}[{rows}];", array.name);
            }
        }
        if self.kind.is_some() {
            let _ = writeln!(
                text,
                "static {} data;",
                ProjectStructure::of(self.view.function).name
            );
        }
        text.push('\n');
        for name in self.contestants {
            let parameters = self.parameters();
            let result = match self.kind {
                Some(kind) if kind.has_status() => "int",
                Some(_) | None => "void",
            };
            let _ = writeln!(text, "{result} {name}({parameters});");
        }
        text.push('\n');
    }

    fn parameters(&self) -> String {
        if let Some(kind) = self.kind {
            let outputs = kind.outputs.iter();
            let mut list: Vec<String> = outputs
                .map(|(name, rank)| format!("double {}{name}", "*".repeat(*rank)))
                .collect();
            let data = ProjectStructure::of(self.view.function).name;
            list.extend([format!("{data} *s"), "double tsim".to_owned()]);
            return list.join(", ");
        }
        let function = self.view.function;
        let inputs = function.inputs().iter().map(|array| (array.shape, false));
        let outputs = function.outputs().iter().map(|array| (array.shape, true));
        let list = inputs.chain(outputs).map(|(shape, is_output)| {
            let declared = parameter(self.real, "", shape, is_output, Rows::Brackets);
            declared.trim_end().to_owned()
        });
        parameters(list)
    }

    /// The state, what is expected, and where both are.
    fn tables(&self, text: &mut String, stored: &[Stored], inputs: &[usize], outputs: &[usize]) {
        let function = self.view.function;
        let place = |array: &Array, number: usize, offset: u32| {
            let (indices, rank) = array.shape.indices(offset);
            match rank {
                0 => format!("&{}[0]", stored[number].storage),
                1 => format!("&{}[{}]", stored[number].storage, indices[0]),
                _ => format!(
                    "&{}[{}][{}]",
                    stored[number].storage, indices[0], indices[1]
                ),
            }
        };
        let real = self.real.name();
        text.push_str("/* The state. */\n");
        let _ = writeln!(
            text,
            "static const struct {{ {real} *place; double number; }} given[] = {{"
        );
        for (index, number) in (0u32..).zip(&self.trial.inputs) {
            let at = function.input_array(Input(index));
            let (array, _, _) = function.input_element(Input(index));
            let place = place(array, inputs[at], index - array.offset);
            let _ = writeln!(text, "    {{{place}, {}}},", literal(*number));
        }
        text.push_str("    {0, 0}\n};\n\n/* What comes of it. */\n");
        let _ = writeln!(
            text,
            "static const struct {{ {real} *place; double number, norm; const char *name; }} expected[] = {{"
        );
        let norms = self.norms();
        for (assignment, number) in function.assignments.iter().zip(&self.trial.expected) {
            let at = function.output_array(assignment.output);
            let (array, indices, rank) = function.output_element(assignment.output);
            let place = place(array, outputs[at], assignment.output.0 - array.offset);
            let mut name = self.view.tables.symbols.text(array.name).to_owned();
            for index in &indices[..rank] {
                let _ = write!(name, "[{index}]");
            }
            let (number, norm) = (literal(*number), literal(norms[at]));
            let _ = writeln!(text, "    {{{place}, {number}, {norm}, \"{name}\"}},");
        }
        let tolerance = self.trial.tolerance;
        let _ = writeln!(
            text,
            "    {{0, 0, 1, 0}}\n}};\n\nstatic const double tolerance = {tolerance:e};\n"
        );
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

    /// Functions that point the structure at the arrays, clear the outputs,
    /// and call a contestant.
    fn calls(&self, text: &mut String, stored: &[Stored]) {
        text.push_str("static void set_up(void)\n{\n");
        if let Some(kind) = self.kind {
            for array in stored {
                let (name, storage) = (&array.name, &array.storage);
                let is_member = kind.outputs.iter().all(|(known, _)| known != name)
                    || matches!(name.as_str(), "frc" | "trq");
                if array.rank == 2 {
                    let rows = array.rows;
                    let _ = writeln!(
                        text,
                        "    for (int i = 0; i < {rows}; i++) rows_of_{name}[i] = {storage}[i];"
                    );
                    if is_member {
                        let _ = writeln!(text, "    data.{name} = rows_of_{name};");
                    }
                } else if is_member && name != "tsim" {
                    let value = if array.rank == 0 {
                        format!("{storage}[0]")
                    } else {
                        storage.clone()
                    };
                    let _ = writeln!(text, "    data.{name} = {value};");
                }
            }
        }
        text.push_str("}\n\nstatic void clear(void)\n{\n");
        for array in stored {
            let _ = writeln!(text, "    memset({0}, 0, sizeof {0});", array.storage);
        }
        text.push_str("}\n\nstatic void call(int contestant)\n{\n    switch (contestant) {\n");
        let arguments = self.arguments(stored);
        for (number, name) in self.contestants.iter().enumerate() {
            let _ = writeln!(text, "    case {number}: {name}({arguments}); break;");
        }
        let names: Vec<String> = self
            .contestants
            .iter()
            .map(|name| format!("\"{name}\""))
            .collect();
        let _ = write!(
            text,
            "    }}\n}}\n\nenum {{ CONTESTANTS = {} }};\nstatic const char *const names[] = {{{}}};\n",
            self.contestants.len(),
            names.join(", ")
        );
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

/// The part that does not depend on the function.
const DRIVER: &str = r#"
static void fill(void)
{
    clear();
    for (int i = 0; given[i].place; i++)
        *given[i].place = (REAL)given[i].number;
}

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec * 1e9 + (double)time.tv_nsec;
}

/* Processor time of a call, in nanoseconds: the least of many windows. */
static void measure(double *best)
{
    long calls[CONTESTANTS];
    for (int k = 0; k < CONTESTANTS; k++) {
        calls[k] = 1;
        best[k] = INFINITY;
        for (;;) {
            const double start = now();
            for (long i = 0; i < calls[k]; i++) call(k);
            if (now() - start > 3e5) break;
            calls[k] *= 2;
        }
    }
    for (int window = 0; window < 200; window++)
        for (int k = 0; k < CONTESTANTS; k++) {
            const double start = now();
            for (long i = 0; i < calls[k]; i++) call(k);
            const double time = (now() - start) / (double)calls[k];
            if (time < best[k]) best[k] = time;
        }
}

int main(int count, char **arguments)
{
    const int prints = count > 1 && !strcmp(arguments[1], "print");
    const int times = count > 1 && !strcmp(arguments[1], "time");
    int differs = 0;
    set_up();
    for (int k = 0; k < CONTESTANTS; k++) {
        double worst = 0;
        const char *where = "";
        fill();
        set_up();
        call(k);
        for (int i = 0; expected[i].place; i++) {
            const double off = fabs((double)*expected[i].place - expected[i].number) / expected[i].norm;
            if (prints) printf("%s %s %.17g %.17g\n", names[k], expected[i].name,
                (double)*expected[i].place, expected[i].number);
            /* A NaN stays the worst. */
            if (worst == worst && !(off <= worst)) {
                worst = off;
                where = expected[i].name;
            }
        }
        printf("%s off by %.2e %s\n", names[k], worst, where);
        if (!(worst <= tolerance)) differs = 1;
    }
    if (times) {
        double best[CONTESTANTS];
        fill();
        set_up();
        measure(best);
        for (int k = 0; k < CONTESTANTS; k++)
            printf("%s ns %.1f ratio %.3f\n", names[k], best[k], best[0] / best[k]);
    }
    return differs;
}
"#;
