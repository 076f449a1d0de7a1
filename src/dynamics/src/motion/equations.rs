//! The equations of a model, evaluated after passes, as on a target.

use super::MotionError;
use super::generated_loops::GeneratedLoops;
use super::varied::PointMotion;
use crate::generate::{Formulation, GenerationRequest, Options, cuts_of_rows, generate};
use crate::kinematics::linear::DenseMatrix;
use crate::kinematics::{CompiledFunction, EvaluatedOutputs, LoopConstraints, MotionState};
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::Pipeline;
use robovec_framework::scene::Scene;
use robovec_ir::{Format, Machine, Module};
use robovec_model::Model;
use robovec_robotran::FunctionKind;

/// Way in which equations are made and evaluated.
#[derive(Clone, Copy)]
pub struct EquationSetting<'a> {
    /// Way in which they are generated.
    pub formulation: Formulation,
    /// Passes that are run over them, and their machine.
    pub passes: Option<(&'a Pipeline, &'a Machine)>,
    /// The numbers they are evaluated in. The surrounding computations (linear
    /// solutions, integration) are in binary64.
    pub format: Format,
    /// Take accelerations from the function `accelred` instead of solving `M
    /// qdd + c = Qq`. Formulations that give nothing else are used without
    /// linear solutions for any request.
    pub accelerations: bool,
    /// Take the loops' positions and velocities and all accelerations from the
    /// generated functions of the whole step (`loop_positions`,
    /// `loop_velocities`, `accelred`). Monitored quantities (residuals, work of
    /// drives) then come from generated equations, in binary64.
    pub whole_step: bool,
    /// A scene that the passes use in the equations of motion (`dirdyna`,
    /// `accelred`), and the options with which these are generated for it.
    /// Positions, loops and links stay those of the model.
    pub scene: Option<(&'a Scene, &'a Options)>,
    /// A program that gives some of the outputs of the equations of motion in
    /// separate numbers; the others are unchanged.
    pub program: Option<(&'a Module, Format)>,
}

impl Default for EquationSetting<'_> {
    fn default() -> Self {
        EquationSetting {
            formulation: Formulation::default(),
            passes: None,
            format: Format::BINARY64,
            accelerations: false,
            whole_step: false,
            scene: None,
            program: None,
        }
    }
}

/// The equations of a model.
pub struct MotionEquations {
    joints: usize,
    constraints: LoopConstraints,
    loops: Option<GeneratedLoops>,
    dynamics: CompiledFunction,
    acceleration: Option<CompiledFunction>,
    solved: Option<CompiledFunction>,
    program: Option<CompiledFunction>,
    links: Option<CompiledFunction>,
    forces: Option<CompiledFunction>,
}

impl MotionEquations {
    /// Generates the equations of a model and runs the passes over them.
    ///
    /// # Errors
    ///
    /// [`MotionError::Generate`], [`MotionError::Passes`] and
    /// [`StateError::Element`](crate::kinematics::StateError::Element).
    pub fn new(
        model: &Model,
        setting: &EquationSetting<'_>,
    ) -> Result<MotionEquations, MotionError> {
        let compiled = |function| compile(model, function, setting);
        // What only watches a whole step is not what is watched.
        let around = if setting.whole_step {
            EquationSetting {
                passes: None,
                format: Format::BINARY64,
                ..*setting
            }
        } else {
            *setting
        };
        let (mut constraints, mut loops, mut acceleration) =
            (LoopConstraints::none(model, around.format), None, None);
        if !model.cuts.is_empty() {
            let row_cuts = cuts_of_rows(model)?;
            let position = compile(model, FunctionKind::ConsHJ, &around)?;
            constraints = LoopConstraints::new(model, around.format, position, row_cuts);
            if setting.whole_step {
                let functions = [FunctionKind::LoopPositions, FunctionKind::LoopVelocities];
                let [positions, velocities] = functions.map(compiled);
                let epsilon = 2.0 * setting.format.unit_roundoff();
                loops = Some(GeneratedLoops::new([positions?, velocities?], epsilon));
            } else {
                acceleration = Some(compiled(FunctionKind::ConsJdqd)?);
            }
        }
        let given = setting.formulation.gives(FunctionKind::Dirdyna);
        // The mass matrix still tells what drives have to do.
        let dynamics = EquationSetting {
            formulation: if given {
                setting.formulation
            } else {
                Formulation::default()
            },
            ..around
        };
        let optional = |needed: bool, function| {
            let function = needed.then(|| compiled(function));
            function.transpose()
        };
        Ok(MotionEquations {
            links: optional(!model.links.is_empty(), FunctionKind::Link)?,
            forces: optional(!model.forces.is_empty(), FunctionKind::Extforces)?,
            joints: model.joints.len(),
            dynamics: compile(model, FunctionKind::Dirdyna, &dynamics)?,
            solved: optional(
                setting.accelerations || setting.whole_step || !given,
                FunctionKind::Accelred,
            )?,
            loops,
            program: setting
                .program
                .map(|given| program(model, given))
                .transpose()?,
            constraints,
            acceleration,
        })
    }

    /// Relative distance of neighbouring numbers: twice the unit roundoff.
    pub fn epsilon(&self) -> f64 {
        self.constraints.epsilon()
    }

    /// The constraints of the loops.
    pub fn constraints(&self) -> &LoopConstraints {
        &self.constraints
    }

    /// The generated functions that close the loops, if they do.
    pub(super) fn generated_loops(&self) -> Option<&GeneratedLoops> {
        self.loops.as_ref()
    }

    /// `M` and `c` of `M qdd + c = Qq`.
    pub fn dynamics(&self, state: &MotionState) -> (DenseMatrix, Vec<f64>) {
        let outputs = self.dynamics.evaluate(state);
        let mut matrix = outputs.matrix("M", self.joints, self.joints);
        let mut bias = outputs.vector("c", self.joints);
        if let Some(program) = &self.program {
            let outputs = program.evaluate(state);
            outputs.take_entries("M", &mut matrix);
            outputs.take_joints("c", &mut bias);
        }
        (matrix, bias)
    }

    /// The accelerations of all joints but the driven ones, which keep those
    /// of the state; `None` when they are to be solved for.
    pub fn accelerations(&self, state: &MotionState) -> Option<Vec<f64>> {
        let outputs = self.solved.as_ref()?.evaluate(state);
        let mut accelerations = state.qdd.clone();
        let given = outputs.take_joints("qdd", &mut accelerations);
        if let Some(program) = &self.program {
            program
                .evaluate(state)
                .take_joints("qdd", &mut accelerations);
        }
        given.then_some(accelerations)
    }

    /// `Jdqd`: second derivative of the constraints without accelerations.
    pub fn quadratic(&self, state: &MotionState) -> Vec<f64> {
        match &self.acceleration {
            None => Vec::new(),
            Some(compiled) => compiled
                .evaluate(state)
                .vector("Jdqd", self.constraints.rows()),
        }
    }

    /// The length of each link and its rate.
    pub fn link_lengths(&self, state: &MotionState) -> Vec<[f64; 2]> {
        let Some(compiled) = &self.links else {
            return Vec::new();
        };
        let outputs = compiled.evaluate(state);
        let count = state.links.len();
        let (lengths, rates) = (outputs.vector("Z", count), outputs.vector("Zd", count));
        lengths
            .into_iter()
            .zip(rates)
            .map(<[f64; 2]>::from)
            .collect()
    }

    /// Motion of the point of each external force.
    pub fn force_motion(&self, state: &MotionState) -> Vec<PointMotion> {
        let Some(compiled) = &self.forces else {
            return Vec::new();
        };
        point_motions(&compiled.evaluate(state), state.external.len())
    }

    /// Adds the forces of links to the forces and torques on bodies.
    pub fn add_links(&self, state: &mut MotionState) {
        if let Some(compiled) = &self.links {
            let outputs = compiled.evaluate(state);
            outputs.take_loads(state);
        }
    }

    /// Adds external forces to the forces and torques on bodies.
    pub fn add_forces(&self, state: &mut MotionState) {
        if let Some(compiled) = &self.forces {
            let outputs = compiled.evaluate(state);
            outputs.take_loads(state);
        }
    }

    /// The derivatives of `M` and `c` along a direction.
    pub(super) fn dynamics_along(
        &self,
        state: &MotionState,
        direction: &MotionState,
    ) -> (DenseMatrix, Vec<f64>) {
        let outputs = self.dynamics.evaluate_along(state, direction);
        (
            outputs.matrix("M", self.joints, self.joints),
            outputs.vector("c", self.joints),
        )
    }

    /// The derivative of `Jdqd` along a direction.
    pub(super) fn quadratic_along(&self, state: &MotionState, direction: &MotionState) -> Vec<f64> {
        let rows = self.constraints.rows();
        match &self.acceleration {
            None => vec![0.0; rows],
            Some(compiled) => compiled
                .evaluate_along(state, direction)
                .vector("Jdqd", rows),
        }
    }

    /// The derivatives of the links' lengths and their rates.
    pub(super) fn link_lengths_along(
        &self,
        state: &MotionState,
        direction: &MotionState,
    ) -> Vec<[f64; 2]> {
        let Some(compiled) = &self.links else {
            return Vec::new();
        };
        let outputs = compiled.evaluate_along(state, direction);
        let count = state.links.len();
        let (lengths, rates) = (outputs.vector("Z", count), outputs.vector("Zd", count));
        let pairs = lengths.into_iter().zip(rates);
        pairs.map(<[f64; 2]>::from).collect()
    }

    /// The derivatives of the motion of the points of external forces.
    pub(super) fn force_motion_along(
        &self,
        state: &MotionState,
        direction: &MotionState,
    ) -> Vec<PointMotion> {
        let Some(compiled) = &self.forces else {
            return Vec::new();
        };
        point_motions(
            &compiled.evaluate_along(state, direction),
            state.external.len(),
        )
    }

    /// Adds the derivatives of link forces to those of loads on bodies.
    pub(super) fn add_links_along(&self, state: &MotionState, direction: &mut MotionState) {
        if let Some(compiled) = &self.links {
            let outputs = compiled.evaluate_along(state, direction);
            outputs.take_loads(direction);
        }
    }

    /// Adds the derivatives of external forces to those of loads on bodies.
    pub(super) fn add_forces_along(&self, state: &MotionState, direction: &mut MotionState) {
        if let Some(compiled) = &self.forces {
            let outputs = compiled.evaluate_along(state, direction);
            outputs.take_loads(direction);
        }
    }
}

fn point_motions(outputs: &EvaluatedOutputs<'_>, count: usize) -> Vec<PointMotion> {
    let motion = |number: usize| {
        let vector = |prefix: &str| {
            let vector = outputs.vector(&format!("{prefix}{number}"), 3);
            [vector[0], vector[1], vector[2]]
        };
        let axes = outputs.matrix(&format!("RxF{number}"), 3, 3);
        PointMotion {
            place: vector("PxF"),
            velocity: vector("VxF"),
            spin: vector("OMxF"),
            axes: std::array::from_fn(|row| std::array::from_fn(|column| axes[(row, column)])),
        }
    };
    (1..=count).map(motion).collect()
}

/// A program evaluated in its own numbers.
fn program(
    model: &Model,
    (module, format): (&Module, Format),
) -> Result<CompiledFunction, MotionError> {
    let function = module.functions[0].clone();
    let name = function.name.clone();
    let compiled = CompiledFunction::new(model, &name, &module.tables, function, format)?;
    Ok(compiled)
}

fn compile(
    model: &Model,
    kind: FunctionKind,
    setting: &EquationSetting<'_>,
) -> Result<CompiledFunction, MotionError> {
    let moves = matches!(kind, FunctionKind::Dirdyna | FunctionKind::Accelred);
    let scene = setting.scene.filter(|_| moves);
    let request = GenerationRequest {
        function: kind,
        formulation: setting.formulation,
        options: match scene {
            Some((_, options)) => options.clone(),
            None => Options::default(),
        },
    };
    let mut module = generate(model, &request)?;
    if let Some((pipeline, machine)) = setting.passes {
        // Remarks of passes are of no interest here.
        let mut log = std::io::sink();
        let config = Config {
            scene: scene.map(|(scene, _)| scene),
            ..Config::new(machine, &mut log)
        };
        manager::run(&mut module, pipeline, config)
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
    let name = kind.name();
    Ok(CompiledFunction::new(
        model,
        name,
        &tables,
        function,
        setting.format,
    )?)
}
