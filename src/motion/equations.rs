//! The equations of a model, evaluated: what the generator writes, what
//! passes make of it, in the arithmetic of a target.

use super::linear::DenseMatrix;
use super::{InputSources, MotionError, MotionState};
use crate::generate::{Formulation, FunctionKind, GenerationRequest, Options, generate};
use crate::model::Model;
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::Pipeline;
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Format, Function, Machine, Module, Shape, View};
use robovec_num::arithmetic::{Arithmetic, Binary32, Binary64};
use robovec_num::soft_float::FormatArithmetic;

/// A function of the model, ready to be evaluated.
struct Compiled {
    function: Function,
    inputs: InputSources,
    outputs: Vec<(String, usize, Shape)>,
}

/// How equations are made and evaluated.
#[derive(Clone, Copy)]
pub struct EquationSetting<'a> {
    /// How they are generated.
    pub formulation: Formulation,
    /// What is done to them, and the machine it is done for.
    pub passes: Option<(&'a Pipeline, &'a Machine)>,
    /// The numbers they are evaluated in. What surrounds them (linear
    /// solutions, integration) stays in binary64.
    pub format: Format,
    /// Take accelerations from the function `accelred` instead of solving
    /// `M qdd + c = Qq`. Formulations that give nothing else are taken so
    /// whatever is asked.
    pub accelerations: bool,
}

impl Default for EquationSetting<'_> {
    fn default() -> Self {
        EquationSetting {
            formulation: Formulation::default(),
            passes: None,
            format: Format::BINARY64,
            accelerations: false,
        }
    }
}

/// The equations of a model.
pub struct MotionEquations {
    format: Format,
    joints: usize,
    dynamics: Compiled,
    position: Option<Compiled>,
    acceleration: Option<Compiled>,
    solved: Option<Compiled>,
    links: Option<Compiled>,
    forces: Option<Compiled>,
    /// The cut of each row of the constraints.
    row_cuts: Vec<usize>,
}

/// The outputs of one evaluation.
struct EvaluatedOutputs<'a> {
    compiled: &'a Compiled,
    flat: Vec<f64>,
}

impl MotionEquations {
    /// Generates the equations of a model and runs the passes over them.
    ///
    /// # Errors
    ///
    /// [`MotionError::Generate`], [`MotionError::Passes`] and
    /// [`MotionError::Element`].
    pub fn new(
        model: &Model,
        setting: &EquationSetting<'_>,
    ) -> Result<MotionEquations, MotionError> {
        let compiled = |function| compile(model, function, setting);
        let (mut position, mut acceleration) = (None, None);
        let mut row_cuts = Vec::new();
        if !model.cuts.is_empty() {
            row_cuts = cuts_of_rows(model)?;
            position = Some(compiled(FunctionKind::ConsHJ)?);
            acceleration = Some(compiled(FunctionKind::ConsJdqd)?);
        }
        let given = setting.formulation.gives(FunctionKind::Dirdyna);
        // The mass matrix still tells what drives have to do.
        let dynamics = EquationSetting {
            formulation: if given {
                setting.formulation
            } else {
                Formulation::default()
            },
            ..*setting
        };
        let optional = |needed: bool, function| {
            let function = needed.then(|| compiled(function));
            function.transpose()
        };
        Ok(MotionEquations {
            links: optional(!model.links.is_empty(), FunctionKind::Link)?,
            forces: optional(!model.forces.is_empty(), FunctionKind::Extforces)?,
            format: setting.format,
            joints: model.joints.len(),
            dynamics: compile(model, FunctionKind::Dirdyna, &dynamics)?,
            solved: optional(setting.accelerations || !given, FunctionKind::Accelred)?,
            position,
            acceleration,
            row_cuts,
        })
    }

    /// The relative distance of neighbours of the numbers the equations are
    /// evaluated in: twice the unit roundoff.
    pub fn epsilon(&self) -> f64 {
        2.0 * self.format.unit_roundoff()
    }

    /// The number of constraint rows.
    pub fn rows(&self) -> usize {
        self.row_cuts.len()
    }

    /// The cut, from 0, that a row of the constraints belongs to.
    pub fn cut_of(&self, row: usize) -> usize {
        self.row_cuts[row]
    }

    /// `M` and `c` of `M qdd + c = Qq`.
    pub fn dynamics(&self, state: &MotionState) -> (DenseMatrix, Vec<f64>) {
        let outputs = self.evaluate(&self.dynamics, state);
        (
            outputs.matrix("M", self.joints, self.joints),
            outputs.vector("c", self.joints),
        )
    }

    /// The accelerations of all joints but the driven ones, which keep those
    /// of the state; `None` when they are to be solved for.
    pub fn accelerations(&self, state: &MotionState) -> Option<Vec<f64>> {
        let outputs = self.evaluate(self.solved.as_ref()?, state);
        let mut accelerations = state.qdd.clone();
        let array = outputs
            .compiled
            .outputs
            .iter()
            .find(|array| array.0 == "qdd")?;
        for assignment in &outputs.compiled.function.assignments {
            let place = assignment.output.index();
            let joint = place.checked_sub(array.1);
            if let Some(joint) = joint.filter(|&joint| joint < array.2.len().min(self.joints)) {
                accelerations[joint] = outputs.flat[place];
            }
        }
        Some(accelerations)
    }

    /// The residual `h` of the constraints and their Jacobian `Jac`.
    pub fn constraints(&self, state: &MotionState) -> (Vec<f64>, DenseMatrix) {
        match &self.position {
            None => (Vec::new(), DenseMatrix::zeros(0, self.joints)),
            Some(compiled) => {
                let outputs = self.evaluate(compiled, state);
                (
                    outputs.vector("h", self.rows()),
                    outputs.matrix("Jac", self.rows(), self.joints),
                )
            }
        }
    }

    /// `Jdqd`: the second derivative of the constraints without
    /// accelerations.
    pub fn quadratic(&self, state: &MotionState) -> Vec<f64> {
        match &self.acceleration {
            None => Vec::new(),
            Some(compiled) => self.evaluate(compiled, state).vector("Jdqd", self.rows()),
        }
    }

    /// The length of each link and its rate.
    pub fn link_lengths(&self, state: &MotionState) -> Vec<[f64; 2]> {
        let Some(compiled) = &self.links else {
            return Vec::new();
        };
        let outputs = self.evaluate(compiled, state);
        let count = state.links.len();
        let (lengths, rates) = (outputs.vector("Z", count), outputs.vector("Zd", count));
        lengths
            .into_iter()
            .zip(rates)
            .map(<[f64; 2]>::from)
            .collect()
    }

    /// Position, velocity and angular velocity of the point of each external
    /// force, in the base frame.
    pub fn force_motion(&self, state: &MotionState) -> Vec<[[f64; 3]; 3]> {
        let Some(compiled) = &self.forces else {
            return Vec::new();
        };
        let outputs = self.evaluate(compiled, state);
        let vector = |prefix: &str, number: usize| {
            let vector = outputs.vector(&format!("{prefix}{number}"), 3);
            [vector[0], vector[1], vector[2]]
        };
        (1..=state.external.len())
            .map(|number| ["PxF", "VxF", "OMxF"].map(|prefix| vector(prefix, number)))
            .collect()
    }

    /// Adds the forces of links to the forces and torques on bodies.
    pub fn add_links(&self, state: &mut MotionState) {
        if let Some(compiled) = &self.links {
            let outputs = self.evaluate(compiled, state);
            outputs.loads(state);
        }
    }

    /// Adds external forces to the forces and torques on bodies.
    pub fn add_forces(&self, state: &mut MotionState) {
        if let Some(compiled) = &self.forces {
            let outputs = self.evaluate(compiled, state);
            outputs.loads(state);
        }
    }

    fn evaluate<'a>(&self, compiled: &'a Compiled, state: &MotionState) -> EvaluatedOutputs<'a> {
        let inputs = compiled.inputs.gather(state);
        let numbers = match self.format {
            Format::BINARY32 => numbers(compiled, &Binary32, &inputs),
            Format::BINARY64 => numbers(compiled, &Binary64, &inputs),
            format => numbers(compiled, &FormatArithmetic::new(format), &inputs),
        };
        let mut flat = vec![0.0; compiled.function.output_len()];
        for (assignment, number) in compiled.function.assignments.iter().zip(numbers) {
            flat[assignment.output.index()] = number;
        }
        EvaluatedOutputs { compiled, flat }
    }
}

/// The outputs in binary64, computed in an arithmetic.
fn numbers<A>(compiled: &Compiled, arithmetic: &A, inputs: &[f64]) -> Vec<f64>
where
    A: Arithmetic<Number: Into<f64>>,
{
    let literals: Vec<A::Number> = inputs
        .iter()
        .map(|&number| arithmetic.literal(number))
        .collect();
    let outputs = evaluate(&compiled.function, arithmetic, &literals);
    outputs.into_iter().map(Into::into).collect()
}

impl EvaluatedOutputs<'_> {
    /// An array; empty where the function does not have it, as everything in
    /// it is zero.
    fn array(&self, name: &str) -> (Shape, &[f64]) {
        let found = self.compiled.outputs.iter().find(|array| array.0 == name);
        found.map_or((Shape::Vector(0), &[]), |&(_, offset, shape)| {
            (shape, &self.flat[offset..offset + shape.len()])
        })
    }

    fn vector(&self, name: &str, length: usize) -> Vec<f64> {
        let mut vector = self.array(name).1.to_vec();
        vector.resize(length, 0.0);
        vector
    }

    /// Takes over the columns of `frc` and `trq` that the function sets.
    fn loads(&self, state: &mut MotionState) {
        let arrays = [("frc", &mut state.frc), ("trq", &mut state.trq)];
        for (name, columns) in arrays {
            let Some(array) = self.compiled.outputs.iter().find(|array| array.0 == name) else {
                continue;
            };
            for assignment in &self.compiled.function.assignments {
                let place = assignment.output.index();
                let Some(offset) = place.checked_sub(array.1) else {
                    continue;
                };
                if offset < array.2.len() {
                    let ([component, joint], _) = array.2.indices(offset as u32);
                    columns[joint as usize - 1][component as usize - 1] = self.flat[place];
                }
            }
        }
    }

    fn matrix(&self, name: &str, rows: usize, columns: usize) -> DenseMatrix {
        let mut matrix = DenseMatrix::zeros(rows, columns);
        let (shape, entries) = self.array(name);
        if let Shape::Matrix(_, stride) = shape {
            for (place, &entry) in entries.iter().enumerate() {
                let (row, column) = (place / stride as usize, place % stride as usize);
                if row < rows && column < columns {
                    matrix[(row, column)] = entry;
                }
            }
        }
        matrix
    }
}

fn request(function: FunctionKind, formulation: Formulation) -> GenerationRequest {
    GenerationRequest {
        function,
        formulation,
        options: Options::default(),
    }
}

fn compile(
    model: &Model,
    kind: FunctionKind,
    setting: &EquationSetting<'_>,
) -> Result<Compiled, MotionError> {
    let mut module = generate(model, &request(kind, setting.formulation))?;
    if let Some((pipeline, machine)) = setting.passes {
        // Remarks of passes are of no interest here.
        let mut log = std::io::sink();
        manager::run(&mut module, pipeline, Config::new(machine, &mut log))
            .map_err(|error| MotionError::Passes(error.to_string()))?;
    }
    let Module {
        tables,
        mut functions,
    } = module;
    let Some(function) = functions.pop() else {
        let reason = format!("no function {} was left", kind.name());
        return Err(MotionError::Passes(reason));
    };
    let view = View {
        tables: &tables,
        function: &function,
    };
    let inputs = InputSources::new(model, view).map_err(|element| MotionError::Element {
        function: kind.name().to_owned(),
        element,
    })?;
    let outputs = function.outputs().iter().map(|array| {
        let name = tables.symbols.text(array.name).to_owned();
        (name, array.offset as usize, array.shape)
    });
    let outputs = outputs.collect();
    Ok(Compiled {
        outputs,
        function,
        inputs,
    })
}

/// The cut of each row. The equations leave out rows that no joint changes;
/// how many a cut keeps is seen when it stands alone.
fn cuts_of_rows(model: &Model) -> Result<Vec<usize>, MotionError> {
    let mut alone = model.clone();
    let mut cuts = Vec::new();
    for (index, cut) in model.cuts.iter().enumerate() {
        alone.cuts = vec![cut.clone()];
        let request = request(FunctionKind::ConsHJ, Formulation::default());
        let module = generate(&alone, &request)?;
        let rows = module.functions.iter().flat_map(|function| {
            let arrays = function.outputs().iter();
            arrays.filter(|array| module.tables.symbols.text(array.name) == "h")
        });
        let count = rows.map(|array| array.shape.len()).sum();
        cuts.extend(std::iter::repeat_n(index, count));
    }
    Ok(cuts)
}
