//! C in the form that CasADi's `external` loads: one file with a function, its
//! derivatives and the sparsities of all of them (CasADi's manual, section
//! "Using external functions"; the names of derivatives are those of CasADi
//! 3.6 and later).
//!
//! | function of the file | inputs | outputs |
//! |---|---|---|
//! | `F` | `x` | `F(x)` |
//! | `jac_F` | `x`, `out_y` | a block for every output and input |
//! | `fwd1_F` | `x`, `out_y`, `fwd_x` | Jacobian times direction |
//! | `adj1_F` | `x`, `out_y`, `adj_y` | transposed Jacobian times weights |
//! | `jac_adj1_F`, `fwd1_adj1_F` | those of `adj1_F` and more | second derivatives |
//! | `fwd1_fwd1_F`, `adj1_fwd1_F` | those of `fwd1_F` and more | second derivatives |
//! | `fwd1_jac_F`, `adj1_jac_F` | those of `jac_F` and more | second derivatives |
//!
//! All arrays of the equations are vectors, matrices column by column, so that
//! CasADi's memory is read and written directly. Results `out_y` that are given
//! are not needed, and their sparsity is empty.

use crate::c::layout;
use crate::c::{self, ElementOrder, Layout, Options, OutputLayout, Signature, Sines};
use robovec_ir::{Function, Tables, View};
use std::collections::BTreeMap;
use std::fmt::Write;

/// The part of the interface that some equations compute.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum CasadiRole {
    /// The function itself.
    Values,
    /// Its Jacobian.
    Jacobian,
    /// Its Jacobian times a direction of the inputs.
    Forward,
    /// Its transposed Jacobian times weights of the outputs.
    Adjoint,
    /// The Jacobian of [`CasadiRole::Adjoint`].
    AdjointJacobian,
    /// The Jacobian of [`CasadiRole::Adjoint`] times a direction.
    AdjointForward,
    /// The Jacobian of [`CasadiRole::Forward`] times a direction.
    ForwardForward,
    /// The transposed Jacobian of [`CasadiRole::Forward`] times weights.
    ForwardAdjoint,
    /// The Jacobian of [`CasadiRole::Jacobian`] times a direction.
    JacobianForward,
    /// The transposed Jacobian of [`CasadiRole::Jacobian`] times weights.
    JacobianAdjoint,
}

impl CasadiRole {
    /// The beginning of the name of the function in C.
    pub fn prefix(self) -> &'static str {
        match self {
            CasadiRole::Values => "",
            CasadiRole::Jacobian => "jac_",
            CasadiRole::Forward => "fwd1_",
            CasadiRole::Adjoint => "adj1_",
            CasadiRole::AdjointJacobian => "jac_adj1_",
            CasadiRole::AdjointForward => "fwd1_adj1_",
            CasadiRole::ForwardForward => "fwd1_fwd1_",
            CasadiRole::ForwardAdjoint => "adj1_fwd1_",
            CasadiRole::JacobianForward => "fwd1_jac_",
            CasadiRole::JacobianAdjoint => "adj1_jac_",
        }
    }
}

/// An array of the function as CasADi sees it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CasadiArray {
    /// Its name.
    pub name: String,
    /// Rows and columns; a vector is one column.
    pub extents: [u32; 2],
}

/// A function for CasADi.
#[derive(Debug)]
pub struct CasadiFunction {
    /// Its name.
    pub name: String,
    /// The inputs.
    pub inputs: Vec<CasadiArray>,
    /// The outputs.
    pub outputs: Vec<CasadiArray>,
    /// The equations of every role, in which arrays are vectors and those of
    /// a derivative have the order of `Differentiation::arrays`.
    pub parts: Vec<(CasadiRole, Function)>,
}

/// An input or output of a function of the interface.
struct CasadiPort {
    array: CasadiArray,
    /// Index of the array of the equations; `None` for one without elements.
    source: Option<usize>,
}

impl CasadiFunction {
    /// The C file, as (file name, text).
    pub fn file(&self, tables: &Tables, options: &Options) -> (String, String) {
        let mut writer = InterfaceWriter::default();
        for (role, function) in &self.parts {
            self.part(&mut writer, *role, View { tables, function }, options);
        }
        let text = format!(
            "/* {} for CasADi, by robovec: compile it into a library and load it with casadi.external. */\n\
             {HEAD}{}\nstatic const double robovec_zeros[{}] = {{0}};\n{}",
            self.name,
            writer.patterns,
            writer.zeros.max(1),
            writer.functions
        );
        (format!("{}_casadi.c", self.name), text)
    }

    /// The equations of another role, without zeros.
    fn equations(&self, wanted: CasadiRole) -> Function {
        let found = self.parts.iter().find(|(role, _)| *role == wanted);
        let (_, function) = found.expect("products come with what they are of");
        layout::without_zeros(function.clone())
    }

    /// Writes one function of the interface.
    fn part(
        &self,
        writer: &mut InterfaceWriter,
        role: CasadiRole,
        view: View<'_>,
        options: &Options,
    ) {
        let name = format!("{}{}", role.prefix(), self.name);
        let inner = layout::without_zeros(view.function.clone());
        // CasADi takes products with a Jacobian as dense as what they belong to.
        let (mut inner, is_sparse) = match role {
            CasadiRole::Values | CasadiRole::Jacobian | CasadiRole::AdjointJacobian => {
                (inner, true)
            }
            CasadiRole::Forward | CasadiRole::ForwardForward => {
                let values = self.equations(CasadiRole::Values);
                (layout::with_elements_of(inner, &values), true)
            }
            CasadiRole::JacobianForward => {
                let jacobian = self.equations(CasadiRole::Jacobian);
                (layout::with_elements_of(inner, &jacobian), true)
            }
            CasadiRole::Adjoint
            | CasadiRole::AdjointForward
            | CasadiRole::ForwardAdjoint
            | CasadiRole::JacobianAdjoint => (inner, false),
        };
        inner.name = format!("robovec_{name}");
        // The loop takes as long for one angle as for eight.
        let sines = match options.sines {
            Sines::Inline if c::angles(&inner) <= FEW_ANGLES => Sines::Library,
            sines => sines,
        };
        let options = Options {
            sines,
            signature: Signature::Plain,
            is_local: true,
            layout: Layout::FromZero {
                order: ElementOrder::Column,
                is_sparse,
            },
            ..options.clone()
        };
        let view = View {
            tables: view.tables,
            function: &inner,
        };
        let layouts = c::output_layouts(&inner, ElementOrder::Column, is_sparse);
        let [(_, source), _] = c::files(view, &options).expect("a plain signature");
        writer.functions.push('\n');
        writer.functions += &source;
        let called = c::function_name(view, &options);
        let ports = groups(role).map(|groups| self.ports(groups));
        writer.interface(&name, &called, &ports, &layouts);
    }

    /// Inputs or outputs in CasADi's order. The equations have theirs in the same
    /// order.
    fn ports(&self, groups: &str) -> Vec<CasadiPort> {
        let mut sources = 0..;
        let port = |(array, has_elements): (CasadiArray, bool)| CasadiPort {
            array,
            source: has_elements.then(|| sources.next()).flatten(),
        };
        self.arrays(groups).into_iter().map(port).collect()
    }

    /// The arrays of [`groups`], and for each a flag: true for one with elements.
    fn arrays(&self, groups: &str) -> Vec<(CasadiArray, bool)> {
        let given = |arrays: &[CasadiArray]| -> Vec<(CasadiArray, bool)> {
            arrays.iter().map(|array| (array.clone(), true)).collect()
        };
        let mut arrays = Vec::new();
        for group in groups.split(' ') {
            let is_empty = group.starts_with('(');
            let group = group.trim_matches(['(', ')']);
            let (prefix, kind) = group.split_at(group.len() - 1);
            let members = match kind {
                "x" => given(&self.inputs),
                "y" => given(&self.outputs),
                "J" => blocks(&self.arrays("y"), &self.arrays("x")),
                _ => blocks(&self.arrays("adj_x"), &self.arrays("x (out_y) adj_y")),
            };
            for (mut array, has_elements) in members {
                array.name.insert_str(0, prefix);
                arrays.push((array, has_elements && !is_empty));
            }
        }
        arrays
    }
}

/// The blocks of a Jacobian: for every row array one for each column array.
fn blocks(
    rows: &[(CasadiArray, bool)],
    columns: &[(CasadiArray, bool)],
) -> Vec<(CasadiArray, bool)> {
    let pairs = rows
        .iter()
        .flat_map(|row| columns.iter().map(move |column| (row, column)));
    let block = |((y, _), (x, is_there)): (&(CasadiArray, bool), &(CasadiArray, bool))| {
        let array = CasadiArray {
            name: format!("jac_{}_{}", y.name, x.name),
            extents: [y, x].map(|array| count(array.extents) as u32),
        };
        (array, *is_there)
    };
    pairs.map(block).collect()
}

/// The inputs and outputs of a role, in CasADi's order: groups of arrays with a
/// beginning of their names, which are the inputs `x`, the outputs `y`, the
/// blocks `J` of the Jacobian or those `H` of the Jacobian of the adjoint. The
/// equations do not have those in brackets, which have no elements.
fn groups(role: CasadiRole) -> [&'static str; 2] {
    match role {
        CasadiRole::Values => ["x", "y"],
        CasadiRole::Jacobian => ["x (out_y)", "J"],
        CasadiRole::Forward => ["x (out_y) fwd_x", "fwd_y"],
        CasadiRole::Adjoint => ["x (out_y) adj_y", "adj_x"],
        CasadiRole::AdjointJacobian => ["x (out_y) adj_y (out_adj_x)", "H"],
        CasadiRole::AdjointForward => [
            "x (out_y) adj_y (out_adj_x) fwd_x (fwd_out_y) fwd_adj_y",
            "fwd_adj_x",
        ],
        CasadiRole::ForwardForward => [
            "x (out_y) fwd_x (out_fwd_y) fwd2_x (fwd2_out_y) fwd2_fwd_x",
            "fwd2_fwd_y",
        ],
        CasadiRole::ForwardAdjoint => [
            "x (out_y) fwd_x (out_fwd_y) adj_fwd_y",
            "adj_x (adj_out_y) adj_fwd_x",
        ],
        CasadiRole::JacobianForward => ["x (out_y) (out_J) fwd_x (fwd_out_y)", "fwd_J"],
        CasadiRole::JacobianAdjoint => ["x (out_y) (out_J) adj_J", "adj_x (adj_out_y)"],
    }
}

fn count([rows, columns]: [u32; 2]) -> u64 {
    u64::from(rows) * u64::from(columns)
}

/// The text of the interface so far.
#[derive(Default)]
struct InterfaceWriter {
    functions: String,
    patterns: String,
    /// Elements of the largest input.
    zeros: u64,
    /// The number of every sparsity written.
    numbers: BTreeMap<Vec<u32>, usize>,
}

impl InterfaceWriter {
    /// Writes the functions that CasADi asks about one function, and itself.
    fn interface(
        &mut self,
        name: &str,
        called: &str,
        [inputs, outputs]: &[Vec<CasadiPort>; 2],
        layouts: &[OutputLayout],
    ) {
        let dense = |port: &CasadiPort| match port.source {
            Some(_) => compressed(port.array.extents, 0..count(port.array.extents)),
            None => compressed(port.array.extents, 0..0),
        };
        let given: Vec<usize> = inputs.iter().map(|port| self.number(dense(port))).collect();
        let kept = |port: &CasadiPort| port.source.map_or(&[][..], |source| &layouts[source].kept);
        let made: Vec<usize> = outputs
            .iter()
            .map(|port| {
                let rows = port
                    .source
                    .map_or(1, |source| u64::from(layouts[source].extents[0]));
                let places = kept(port).iter();
                let places = places.map(|&[row, column]| u64::from(column) * rows + u64::from(row));
                self.number(compressed(port.array.extents, places))
            })
            .collect();
        let mut scratch = 0;
        let mut arguments = vec![String::new(); inputs.iter().flat_map(|port| port.source).count()];
        for (index, port) in inputs.iter().enumerate() {
            if let Some(source) = port.source {
                self.zeros = self.zeros.max(count(port.array.extents));
                arguments[source] = format!("arg[{index}] ? arg[{index}] : robovec_zeros");
            }
        }
        let mut results = vec![String::new(); layouts.len()];
        for (index, port) in outputs.iter().enumerate() {
            if let Some(source) = port.source {
                results[source] = format!("res[{index}] ? res[{index}] : w + {scratch}");
                scratch += kept(port).len();
            }
        }
        let arguments = [arguments, results].concat().join(",\n        ");
        self.question(name, "in", inputs, &given);
        self.question(name, "out", outputs, &made);
        let (most_in, most_out) = (inputs.len(), outputs.len());
        let _ = write!(
            self.functions,
            "ROBOVEC_EXPORT int {name}_work(casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w)\n{{\n    \
             if (sz_arg) *sz_arg = {most_in};\n    if (sz_res) *sz_res = {most_out};\n    \
             if (sz_iw) *sz_iw = 0;\n    if (sz_w) *sz_w = {scratch};\n    return 0;\n}}\n\
             ROBOVEC_EXPORT int {name}(const double **arg, double **res, casadi_int *iw, double *w, int mem)\n{{\n    \
             (void)arg, (void)res, (void)iw, (void)w, (void)mem;\n    {called}({arguments});\n    return 0;\n}}\n"
        );
    }

    /// Writes number, names and sparsities of inputs or outputs.
    fn question(&mut self, name: &str, side: &str, ports: &[CasadiPort], patterns: &[usize]) {
        let names: Vec<String> = ports
            .iter()
            .map(|port| format!("\"{}\"", port.array.name))
            .collect();
        let patterns: Vec<String> = patterns
            .iter()
            .map(|number| format!("robovec_pattern_{number}"))
            .collect();
        let length = ports.len();
        let list = |items: &[String]| {
            if items.is_empty() {
                "0".to_owned()
            } else {
                items.join(", ")
            }
        };
        let _ = write!(
            self.functions,
            "ROBOVEC_EXPORT casadi_int {name}_n_{side}(void)\n{{\n    return {length};\n}}\n\
             ROBOVEC_EXPORT const char *{name}_name_{side}(casadi_int i)\n{{\n    \
             static const char *const names[] = {{{}}};\n    \
             return i >= 0 && i < {length} ? names[i] : 0;\n}}\n\
             ROBOVEC_EXPORT const casadi_int *{name}_sparsity_{side}(casadi_int i)\n{{\n    \
             static const casadi_int *const patterns[] = {{{}}};\n    \
             return i >= 0 && i < {length} ? patterns[i] : 0;\n}}\n",
            list(&names),
            list(&patterns)
        );
    }

    /// The number of a sparsity, which is written once.
    fn number(&mut self, pattern: Vec<u32>) -> usize {
        let next = self.numbers.len();
        if let Some(&number) = self.numbers.get(&pattern) {
            return number;
        }
        let numbers: Vec<String> = pattern.iter().map(u32::to_string).collect();
        let lines: Vec<String> = numbers.chunks(16).map(|line| line.join(", ")).collect();
        let _ = writeln!(
            self.patterns,
            "static const casadi_int robovec_pattern_{next}[] = {{{}}};",
            lines.join(",\n    ")
        );
        self.numbers.insert(pattern, next);
        next
    }
}

/// A sparsity in CasADi's compressed form, of elements given column by column
/// in rising order: rows, columns, where each column starts, the row of each
/// element; rows, columns and 1 for a dense matrix.
fn compressed([rows, columns]: [u32; 2], places: impl Iterator<Item = u64>) -> Vec<u32> {
    let places: Vec<u64> = places.collect();
    let mut pattern = vec![rows, columns];
    if !places.is_empty() && places.len() as u64 == count([rows, columns]) {
        pattern.push(1);
        return pattern;
    }
    let rows = u64::from(rows);
    let start = |column: u32| places.partition_point(|&place| place < u64::from(column) * rows);
    pattern.extend((0..=columns).map(|column| start(column) as u32));
    pattern.extend(places.iter().map(|place| (place % rows) as u32));
    pattern
}

/// Number of angles whose sines the C library computes faster than the loop.
const FEW_ANGLES: usize = 2;

/// The head of the file: the integers of CasADi, and what a library shows.
const HEAD: &str = "#ifndef casadi_int\n#define casadi_int long long int\n#endif\n\
    #ifndef ROBOVEC_EXPORT\n\
    #if defined(_WIN32)\n#define ROBOVEC_EXPORT __declspec(dllexport)\n\
    #elif defined(__GNUC__)\n#define ROBOVEC_EXPORT __attribute__((visibility(\"default\")))\n\
    #else\n#define ROBOVEC_EXPORT\n#endif\n#endif\n\n";
