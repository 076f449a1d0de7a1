//! A function of a model, compiled and ready to be evaluated in any numbers.

use super::numbers::{Evaluation, WorkingPrecision, flattened, rounded};
use super::units::{Dimension, Units};
use super::{ProgramTreatment, StressError};
use robovec_dynamics::generate::{Formulation, GenerationRequest, Options, generate};
use robovec_dynamics::kinematics::{InputSources, MotionState};
use robovec_framework::manager::{self, Config};
use robovec_framework::scene::Scene;
use robovec_ir::cost::{OperationWork, function_cost};
use robovec_ir::evaluate::{evaluate_mixed, evaluate_nodes};
use robovec_ir::parse::parse_module;
use robovec_ir::states::Ranges;
use robovec_ir::{Format, Function, Input, Machine, Module, Operand, Output};
use robovec_model::Model;
use robovec_num::NumberFormat;
use robovec_num::arithmetic::Binary64;
use robovec_num::double_double::Double;
use robovec_passes::registry::REGISTRY;
use robovec_robotran::FunctionKind;

#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub(super) struct ProgramRecipe<'a> {
    /// The recursion.
    pub(super) formulation: Formulation,
    /// The passes that are run over it; none when empty.
    pub(super) passes: &'a str,
    /// Only the outputs of this array.
    pub(super) only: Option<&'a str>,
    /// A format for every value: the allowed error and the states of its tests.
    pub(super) mixed: Option<(f64, &'a [MotionState])>,
}

pub(super) struct ModelProgram {
    pub(super) function: Function,
    inputs: InputSources,
    /// The elements of inputs and outputs, as `q[3]`.
    pub(super) input_names: Vec<String>,
    pub(super) output_names: Vec<String>,
    input_dimensions: Vec<Dimension>,
    outputs: Vec<(String, usize, usize)>,
    output_dimensions: Vec<Dimension>,
    /// Its operations; the host prepares sines and cosines.
    pub(super) work: OperationWork,
}

impl ModelProgram {
    /// Generates a function and runs passes over it.
    pub(super) fn new(
        model: &Model,
        kind: FunctionKind,
        recipe: ProgramRecipe<'_>,
    ) -> Result<ModelProgram, StressError> {
        let request = GenerationRequest {
            function: kind,
            formulation: recipe.formulation,
            options: Options::default(),
        };
        let mut module = generate(model, &request)?;
        if let Some(only) = recipe.only {
            // Of an equation cut off before, nothing would tell the name.
            run_passes(&mut module, "atomise", None)?;
            keep(&mut module, only);
            run_passes(&mut module, "dce", None)?;
        }
        if !recipe.passes.is_empty() {
            run_passes(&mut module, recipe.passes, None)?;
        }
        ModelProgram::of_module(model, module, recipe)
    }

    /// The program of a function that has gone through its passes but `mixed`.
    fn of_module(
        model: &Model,
        mut module: Module,
        recipe: ProgramRecipe<'_>,
    ) -> Result<ModelProgram, StressError> {
        let sources = |module: &Module| {
            let Some(function) = module.functions.last() else {
                return Err(StressError::Passes("no function was left".to_owned()));
            };
            let view = module.tables.view(function);
            InputSources::new(model, view).map_err(StressError::Passes)
        };
        let inputs = sources(&module)?;
        if let Some((error, states)) = recipe.mixed {
            let first = if recipe.passes.is_empty() {
                "atomise,"
            } else {
                ""
            };
            let numbers: Vec<Vec<f64>> = states.iter().map(|state| inputs.gather(state)).collect();
            let scene = scene_between(&module, &numbers);
            run_passes(
                &mut module,
                &format!("{first}{}", mixed(error)),
                Some(&scene),
            )?;
        }
        let Module {
            tables,
            mut functions,
        } = module;
        let Some(function) = functions.pop() else {
            return Err(StressError::Passes("no function was left".to_owned()));
        };
        let dimension = |(array, indices, rank): (&robovec_ir::Array, [u32; 2], usize)| {
            Dimension::of(model, tables.symbols.text(array.name), &indices[..rank])
        };
        let element = |(array, indices, rank): (&robovec_ir::Array, [u32; 2], usize)| {
            let name = tables.symbols.text(array.name);
            format!("{name}{:?}", &indices[..rank])
        };
        let of_input = |index: usize| function.input_element(Input(index as u32));
        let of_output = |index: usize| function.output_element(Output(index as u32));
        let (all_inputs, all_outputs) = (0..function.input_len(), 0..function.output_len());
        let input_names = all_inputs.clone().map(of_input).map(element).collect();
        let output_names = all_outputs.clone().map(of_output).map(element).collect();
        let input_dimensions = all_inputs.map(of_input).map(dimension).collect();
        let output_dimensions = all_outputs.map(of_output).map(dimension).collect();
        let outputs = function.outputs().iter().map(|array| {
            let name = tables.symbols.text(array.name).to_owned();
            (name, array.offset as usize, array.shape.len())
        });
        Ok(ModelProgram {
            outputs: outputs.collect(),
            work: OperationWork::of(&function),
            function,
            inputs,
            input_names,
            output_names,
            input_dimensions,
            output_dimensions,
        })
    }

    /// The flattened inputs in a state. Models and states are rounded
    /// beforehand ([`shared`]); results of other programs are not.
    pub(super) fn inputs(&self, state: &MotionState) -> Vec<f64> {
        self.inputs.gather(state)
    }

    /// Flattened outputs for given inputs, in SI units, computed in others.
    pub(super) fn evaluate(
        &self,
        numbers: WorkingPrecision,
        units: Units,
        inputs: &[f64],
    ) -> Vec<Double> {
        let function = &self.function;
        if function.formats.is_some() {
            return evaluate_mixture(function, inputs);
        }
        if units == Units::SI {
            return numbers.work(Evaluation { function, inputs });
        }
        let outputs = numbers.work(Evaluation {
            function,
            inputs: &self.stored(units, inputs),
        });
        assert_eq!(
            outputs.len(),
            self.output_dimensions.len(),
            "every output has a dimension"
        );
        outputs
            .into_iter()
            .zip(&self.output_dimensions)
            .map(|(number, &dimension)| Double {
                high: units.meant(number.high, dimension),
                low: units.meant(number.low, dimension),
            })
            .collect()
    }

    fn stored(&self, units: Units, inputs: &[f64]) -> Vec<f64> {
        let dimensions = &self.input_dimensions;
        assert_eq!(
            inputs.len(),
            dimensions.len(),
            "every input has a dimension"
        );
        let pairs = inputs.iter().zip(dimensions);
        let stored = pairs.map(|(&number, &dimension)| units.stored(number, dimension));
        stored.collect()
    }

    /// Cells of its operations, each in the format of its value if it has one.
    pub(super) fn cost(&self, format: Format) -> f64 {
        function_cost(&self.function, format)
    }

    /// An output array of [`ModelProgram::evaluate`]; zeros without it.
    pub(super) fn array(&self, name: &str, flat: &[Double], length: usize) -> Vec<Double> {
        let found = self.outputs.iter().find(|(array, ..)| array == name);
        let mut array = match found {
            Some(&(_, offset, length)) => flat[offset..offset + length].to_vec(),
            None => Vec::new(),
        };
        array.resize(length, Double::from(0.0));
        array
    }

    /// Number of inputs and values, if not zero, that are not normal numbers.
    pub(super) fn out_of_range(&self, format: Format, units: Units, inputs: &[f64]) -> [usize; 2] {
        let scaled = self.stored(units, inputs);
        let values = evaluate_nodes(&self.function, &Binary64, &scaled);
        let numbers = scaled.iter().chain(&values);
        let (mut outside, mut all) = (0, 0);
        for number in numbers.filter(|number| **number != 0.0) {
            all += 1;
            outside += usize::from(!is_normal(*number, format));
        }
        [outside, all]
    }
}

/// Sets all but one array to zero.
fn keep(module: &mut Module, only: &str) {
    let Module { tables, functions } = module;
    for function in functions {
        let zero = Operand::from(function.constant(0.0));
        let dropped: Vec<bool> = function
            .assignments
            .iter()
            .map(|assignment| {
                let (array, ..) = function.output_element(assignment.output);
                tables.symbols.text(array.name) != only
            })
            .collect();
        for (assignment, dropped) in function.assignments.iter_mut().zip(dropped) {
            if dropped {
                assignment.operand = zero;
            }
        }
    }
}

/// Runs a pipeline over a module, for a scene if given.
pub(super) fn run_passes(
    module: &mut Module,
    passes: &str,
    scene: Option<&Scene>,
) -> Result<(), StressError> {
    let failed = |error: String| StressError::Passes(format!("{passes}: {error}"));
    let pipeline = REGISTRY
        .pipeline(passes)
        .map_err(|error| failed(format!("{error:?}")))?;
    let machine =
        Machine::built_in("thesis").ok_or_else(|| failed("there is no machine".to_owned()))?;
    // Remarks of passes are of no interest here.
    let mut log = std::io::sink();
    let config = Config {
        scene,
        ..Config::new(&machine, &mut log)
    };
    manager::run(module, &pipeline, config).map_err(|error| failed(error.to_string()))?;
    Ok(())
}

/// The pass `mixed` for an error, with mantissas of 18 to 52 bits.
fn mixed(error: f64) -> String {
    format!("mixed{{error={error:e} narrow=\"float(11,18)\" between=10}}")
}

/// The largest number among the inputs and values of a function.
pub(super) fn largest(function: &Function, inputs: &[Vec<f64>]) -> f64 {
    let numbers = inputs.iter().flat_map(|inputs| {
        let values = evaluate_nodes(function, &Binary64, inputs);
        values.into_iter().chain(inputs.iter().copied())
    });
    numbers.fold(0.0, |most, number| number.abs().max(most))
}

/// The flattened outputs of a function in which each value has its own format.
pub(super) fn evaluate_mixture(function: &Function, inputs: &[f64]) -> Vec<Double> {
    flattened(function, evaluate_mixed(function, Format::BINARY64, inputs))
}

/// Equations as text, after passes, with states between the given inputs.
pub(super) fn text_program(
    text: &str,
    treatment: &ProgramTreatment,
    inputs: &[Vec<f64>],
) -> Result<Module, StressError> {
    let mut module =
        parse_module("case", text).map_err(|report| StressError::Passes(format!("{report:?}")))?;
    let mut passes = treatment.passes.to_owned();
    if let Some(error) = treatment.mixed {
        let first = if passes.is_empty() {
            "atomise"
        } else {
            &passes
        };
        passes = format!("{first},{}", mixed(error));
    }
    if !passes.is_empty() {
        let scene = scene_between(&module, inputs);
        run_passes(&mut module, &passes, Some(&scene))?;
    }
    Ok(module)
}

/// The scene of states between given ones.
fn scene_between(module: &Module, inputs: &[Vec<f64>]) -> Scene {
    let mut ranges = Ranges::default();
    let function = &module.functions[0];
    for place in 0..function.input_len() {
        let (array, indices, _) = function.input_element(Input(place as u32));
        let numbers = inputs.iter().map(|inputs| inputs[place]);
        let start = [f64::INFINITY, f64::NEG_INFINITY];
        let [low, high] = numbers.fold(start, |[low, high], x| [low.min(x), high.max(x)]);
        ranges.set(module.tables.symbols.text(array.name), indices, low, high);
    }
    Scene {
        ranges,
        ..Scene::default()
    }
}

/// The binary32 number next to a number, or the number itself where binary32
/// has no normal number for it: so that the reference and every format from
/// binary32 on start from the same numbers, and leaving the range still shows.
pub(super) fn shared(number: f64) -> f64 {
    if is_normal(number, Format::BINARY32) {
        rounded(number, Format::BINARY32)
    } else {
        number
    }
}

/// True for a normal number of a format.
pub(super) fn is_normal(number: f64, format: Format) -> bool {
    let size = number.abs();
    match format {
        Format::Float(float) => {
            // The largest finite number of the format lies just below this
            // power; that of binary64 is not representable.
            let large = |float: NumberFormat| 2f64.powi(float.largest_exponent());
            size >= 2f64.powi(float.smallest_exponent()) && size / 2.0 < large(float)
        }
        Format::Fixed(fixed) => {
            size >= 2f64.powi(-(fixed.fraction as i32)) && size < 2f64.powi(fixed.integer as i32)
        }
    }
}
