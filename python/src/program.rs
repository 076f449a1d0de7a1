//! A function with its tables, as Python sees it.

use crate::Error;
use crate::values;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use robovec::generate::{
    Formulation, GenerationRequest, ParameterBinding, case_name, fewest, generate_asked,
    index_names, with_jacobians,
};
use robovec::kinematics::parameter;
use robovec::model::Model;
use robovec::model::robot::{RobotBase, RobotReading};
use robovec::report::{ModuleReport, PassRunRecord, ReadCounts, ReportOptions};
use robovec::robotran::FunctionKind;
use robovec::sources;
use robovec::view::{ModelText, ViewedRun, place_lines};
use robovec_framework::manager::{self, Config};
use robovec_framework::trail::Trail;
use robovec_ir::count::Counts;
use robovec_ir::diagnostic::Report;
use robovec_ir::print::print_file;
use robovec_ir::states::States;
use robovec_ir::{Array, Function, Module, Shape, View, parse};
use robovec_passes::registry::REGISTRY;
use std::path::Path;
use std::sync::Arc;

/// Options of functions of models, by their names in Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ModelOptions {
    formulation: String,
    numbers: bool,
    forces: bool,
    jacobians: bool,
    floating: bool,
    quaternion: bool,
    right_angles: f64,
}

/// One function, and the model that gives its parameters.
#[pyclass(frozen, name = "Program", module = "robovec._robovec")]
pub(crate) struct PythonProgram {
    module: Module,
    model: Option<Arc<Model>>,
    passes: Vec<PassRunRecord>,
    /// The counts of the function as it was read.
    read: Vec<ReadCounts>,
    /// Remarks of readers, as printed by the command line.
    remarks: String,
}

fn refused(report: &Report) -> PyErr {
    Error::new_err(report.render_plain())
}

fn plain(error: impl std::fmt::Display) -> PyErr {
    Error::new_err(error.to_string())
}

#[pymethods]
impl PythonProgram {
    /// Reads a file of equations, or makes a function of a model.
    #[staticmethod]
    #[pyo3(signature = (path, function, options, model))]
    fn load(
        py: Python<'_>,
        path: &str,
        function: Option<&str>,
        options: ModelOptions,
        model: Option<&str>,
    ) -> PyResult<PythonProgram> {
        py.detach(|| {
            let path = Path::new(path);
            if sources::is_model_path(path) {
                return generated(path, function.unwrap_or("dirdyna"), &options);
            }
            let read = sources::equations(path, None, function).map_err(|error| refused(&error))?;
            let model = model
                .map(|path| sources::model(Path::new(path)))
                .transpose();
            let model = model.map_err(|error| refused(&error))?;
            let mut remarks = read.warnings.render_plain();
            if let Some(read) = &model {
                remarks += &read.warnings.render_plain();
            }
            let model = model.map(|read| Arc::new(read.model));
            Ok(PythonProgram {
                remarks,
                ..single(read.module, function, model)?
            })
        })
    }

    /// Reads robovec's own text.
    #[staticmethod]
    fn parse(py: Python<'_>, text: &str, function: Option<&str>) -> PyResult<PythonProgram> {
        py.detach(|| {
            let module = parse::parse_module("<text>", text).map_err(|diagnostics| {
                refused(&Report::of("<text>", text.to_owned(), diagnostics))
            })?;
            single(module, function, None)
        })
    }

    /// The function after a pipeline of passes.
    fn run(
        &self,
        py: Python<'_>,
        passes: &str,
        machine: &str,
        check: Option<u32>,
    ) -> PyResult<PythonProgram> {
        py.detach(|| {
            let (module, records, _) = self.transformed(passes, machine, check, None)?;
            Ok(PythonProgram {
                module,
                model: self.model.clone(),
                remarks: String::new(),
                passes: records,
                read: self.read.clone(),
            })
        })
    }

    /// The files that a pipeline ending in `codegen` writes: name and text.
    fn files(
        &self,
        py: Python<'_>,
        passes: &str,
        machine: &str,
    ) -> PyResult<Vec<(String, String)>> {
        py.detach(|| Ok(self.transformed(passes, machine, None, None)?.2))
    }

    /// The same function under another name.
    fn renamed(&self, name: &str) -> PyResult<PythonProgram> {
        let mut letters = name.chars();
        let is_word = letters
            .next()
            .is_some_and(|first| first.is_ascii_alphabetic())
            && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
        if !is_word {
            return Err(plain(format!(
                "'{name}' is not a name: letters, digits and _"
            )));
        }
        let mut module = self.module.clone();
        name.clone_into(&mut module.functions[0].name);
        Ok(PythonProgram {
            module,
            model: self.model.clone(),
            passes: self.passes.clone(),
            read: self.read.clone(),
            remarks: self.remarks.clone(),
        })
    }

    /// The name of the function.
    #[getter]
    fn name(&self) -> &str {
        &self.function().name
    }

    /// Remarks of readers; empty for none.
    #[getter]
    fn remarks(&self) -> &str {
        &self.remarks
    }

    /// Input arrays in order: name and extents, none for a scalar.
    #[getter]
    fn inputs(&self) -> Vec<(String, Vec<usize>)> {
        self.described(self.function().inputs())
    }

    /// Output arrays in order: name and extents, none for a scalar.
    #[getter]
    fn outputs(&self) -> Vec<(String, Vec<usize>)> {
        self.described(self.function().outputs())
    }

    /// Names of the joints in the order of `q`; none without a model.
    #[getter]
    fn joints(&self) -> Vec<String> {
        let joints = self.model.iter().flat_map(|model| &model.joints);
        joints.map(|joint| joint.name.clone()).collect()
    }

    /// Names of the frames that functions `frame_NAME` are about.
    #[getter]
    fn frames(&self) -> Vec<String> {
        let frames = self.model.iter().flat_map(|model| &model.frames);
        frames.map(|frame| frame.name.clone()).collect()
    }

    /// Names along the two axes of an array of the model; `None` for an axis
    /// without names.
    fn labels(&self, array: &str) -> [Option<Vec<String>>; 2] {
        let Some(model) = &self.model else {
            return [None, None];
        };
        let symbols = &self.module.tables.symbols;
        let mut inputs = self.function().inputs().iter();
        let quaternion = inputs.any(|input| symbols.text(input.name) == "quat");
        index_names(model, array, quaternion)
            .map(|names| names.map(|names| names.into_iter().map(str::to_owned).collect()))
    }

    /// Operations: everything but sines, cosines and copies.
    #[getter]
    fn operations(&self) -> usize {
        Counts::of(self.function()).operations
    }

    /// The text form of the function.
    fn text(&self, py: Python<'_>) -> String {
        py.detach(|| print_file(self.view()))
    }

    /// The numbers that the model gives an input array, row by row; `None`
    /// when it gives none.
    fn parameters(&self, array: &str) -> Option<Vec<f64>> {
        let model = self.model.as_deref()?;
        let tables = &self.module.tables;
        let mut inputs = self.function().inputs().iter();
        let found = inputs.find(|input| tables.symbols.text(input.name) == array)?;
        let offsets = 0..found.shape.len() as u32;
        let numbers = offsets.map(|offset| {
            let (indices, rank) = found.shape.indices(offset);
            parameter(model, array, &indices[..rank])
        });
        numbers.collect()
    }

    /// Outputs at states, in a number format: flat lists of binary64 as bytes,
    /// one state after the other, elements that are not set as zero.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        inputs: &[u8],
        number: &str,
        threads: usize,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let format = number.parse().map_err(plain)?;
        let outputs =
            py.detach(|| values::evaluate_states(self.function(), inputs, format, threads))?;
        Ok(PyBytes::new(py, &outputs))
    }

    /// The report of the compilation for a machine, as JSON.
    fn report(&self, py: Python<'_>, machine: &str) -> PyResult<String> {
        py.detach(|| {
            let machine = sources::machine(machine).map_err(|error| refused(&error))?;
            let options = ReportOptions {
                read: self.read.clone(),
                ..ReportOptions::default()
            };
            let report = ModuleReport::collect(&self.module, &machine, &self.passes, &options);
            Ok(report.to_json())
        })
    }

    /// The page of `robovec view`, for a pipeline that starts with this function.
    fn page(&self, py: Python<'_>, passes: &str, machine: &str) -> PyResult<String> {
        py.detach(|| {
            let name = format!("equations of {}", self.name());
            let module = parse::parse_module(&name, &print_file(self.view()));
            let mut module = module.expect("a printed function is read");
            let text = place_lines(&mut module, &name).unwrap_or_default();
            let shown = single(module, None, None)?;
            let mut trail = Trail::new();
            let (module, passes_run, _) =
                shown.transformed(passes, machine, None, Some(&mut trail))?;
            let model = self.model.as_deref().map(|model| ModelText {
                name: model.name.clone(),
                text: String::new(),
                joints: self.joints(),
            });
            Ok(robovec::view::page(&ViewedRun {
                module: &module,
                trail: &trail,
                passes: &passes_run,
                machine: &sources::machine(machine).map_err(|error| refused(&error))?,
                states: &States::new(1),
                files: &[(name, text)],
                model: model.as_ref(),
                pipeline: passes,
                read: shown.read,
            }))
        })
    }

    /// Cycles and elements of a placed function: the elements by name, and of
    /// every operation its name, element and cycle; `None` before `place`.
    #[allow(clippy::type_complexity)]
    fn schedule(&self) -> Option<(Vec<String>, Vec<(String, u32, u32)>, u32)> {
        let function = self.function();
        let schedule = function.schedule.as_ref()?;
        let elements = (0..schedule.element_count()).map(|number| {
            let element = robovec_ir::placement::Element::new(number);
            let (kind, number) = schedule.element_name(element);
            format!("{kind}{number}")
        });
        let symbols = &self.module.tables.symbols;
        let operations = function.values().filter_map(|(value, node)| {
            let slot = schedule.slots[value.index()]?;
            Some((
                node.name.display(symbols),
                slot.element.number(),
                slot.cycle,
            ))
        });
        Some((elements.collect(), operations.collect(), schedule.cycles))
    }
}

impl PythonProgram {
    fn function(&self) -> &Function {
        &self.module.functions[0]
    }

    fn view(&self) -> View<'_> {
        self.module.tables.view(self.function())
    }

    fn described(&self, arrays: &[Array]) -> Vec<(String, Vec<usize>)> {
        let extents = |shape: Shape| match shape {
            Shape::Scalar => Vec::new(),
            Shape::Vector(length) => vec![length as usize],
            Shape::Matrix(rows, columns) => vec![rows as usize, columns as usize],
        };
        let name = |array: &Array| self.module.tables.symbols.text(array.name).to_owned();
        arrays
            .iter()
            .map(|array| (name(array), extents(array.shape)))
            .collect()
    }

    #[allow(clippy::type_complexity)]
    fn transformed(
        &self,
        passes: &str,
        machine: &str,
        check: Option<u32>,
        trail: Option<&mut Trail>,
    ) -> PyResult<(Module, Vec<PassRunRecord>, Vec<(String, String)>)> {
        let pipeline = REGISTRY
            .pipeline(passes)
            .map_err(|error| refused(&error.0))?;
        let machine = sources::machine(machine).map_err(|error| refused(&error))?;
        let mut module = self.module.clone();
        let mut log = Vec::new();
        let config = Config {
            check_each: check,
            rounding: trail.is_some().then_some(0),
            trail,
            ..Config::new(&machine, &mut log)
        };
        let outcome = manager::run(&mut module, &pipeline, config).map_err(plain)?;
        let mut records = self.passes.clone();
        records.extend(PassRunRecord::of(&outcome));
        let files = outcome.artifacts.into_iter();
        let files = files.map(|file| (file.name, file.text));
        Ok((module, records, files.collect()))
    }
}

/// A function of a model.
fn generated(path: &Path, function: &str, options: &ModelOptions) -> PyResult<PythonProgram> {
    let robot = RobotReading {
        base: match options.floating {
            true => RobotBase::Floating,
            false => RobotBase::Fixed,
        },
        right_angle: options.right_angles,
    };
    let read = sources::model_as(path, robot).map_err(|error| refused(&error))?;
    let known = FunctionKind::ALL.map(FunctionKind::name).join(", ");
    let kind = FunctionKind::with_name(function)
        .ok_or_else(|| plain(format!("no function '{function}'; there are {known}")))?;
    let mut request = GenerationRequest::new(kind);
    if options.numbers {
        request.options.parameters = ParameterBinding::Numbers;
    }
    request.options.external_forces = options.forces;
    request.options.quaternion = options.quaternion;
    request.formulation = match options.formulation.as_str() {
        "fewest" => fewest(&read.model, kind, &request.options),
        name => Formulation::from_name(name).ok_or_else(|| {
            let known = Formulation::names().join(", ");
            plain(format!(
                "no formulation '{name}'; there are fewest, {known}"
            ))
        })?,
    };
    let module = match options.jacobians {
        true => with_jacobians(&read.model, &request),
        false => generate_asked(&read.model, &request),
    };
    let module = module.map_err(plain)?;
    // The name of a kind stands for all its cases, `sensor` for `sensor_1`.
    let case = (function != kind.name()).then(|| case_name(&read.model, function));
    let remarks = read.warnings_for(kind).render_plain();
    let model = Arc::new(read.model);
    Ok(PythonProgram {
        remarks,
        ..single(module, case.as_deref(), Some(model))?
    })
}

/// The only function of a name; without a name the only one of the program.
fn single(
    mut module: Module,
    function: Option<&str>,
    model: Option<Arc<Model>>,
) -> PyResult<PythonProgram> {
    let names: Vec<String> = module.functions.iter().map(|f| f.name.clone()).collect();
    if let Some(name) = function {
        module.functions.retain(|function| function.name == name);
    }
    match module.functions.len() {
        1 => Ok(PythonProgram {
            read: ReadCounts::of(&module),
            module,
            model,
            passes: Vec::new(),
            remarks: String::new(),
        }),
        0 if names.is_empty() => Err(plain("the text holds no function")),
        0 => Err(plain(format!(
            "there is no such function; there are: {}",
            names.join(", ")
        ))),
        _ => Err(plain(format!(
            "name one of the functions with function=…: {}",
            names.join(", ")
        ))),
    }
}
