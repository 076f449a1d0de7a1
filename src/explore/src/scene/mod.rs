//! Scene files: the intended use of a program, as a user writes it.
//!
//! The scene itself is [`robovec_framework::scene::Scene`]; here it is read,
//! joined with its model or its equations ([`SceneSubject`]), and every mistake is
//! reported with its place. docs/scenes.md is the manual.

mod arrays;
mod document;
mod effect;
mod inputs;
mod known;
mod motion;
mod read;

pub use effect::{PIPELINE, SceneEffect, USUAL, effects};
pub use motion::{NeglectKind, NeglectWish, SceneMotion, WatchedJoints};
pub use read::read;

use known::{ElementKnowledge, ElementStatements};
use robovec_dynamics::generate::{
    Formulation, GenerateError, GenerationRequest, Options, generate_asked,
};
use robovec_dynamics::kinematics;
use robovec_framework::scene::{HeldJoint, Hold, Scene};
use robovec_io::files::limited;
use robovec_io::sources;
use robovec_ir::Module;
use robovec_ir::diagnostic::Report;
use robovec_model::{Model, Nature};
use robovec_num::limits::NumberLimit;
use robovec_robotran::FunctionKind;
use std::path::Path;

/// The time allowed, in microseconds.
const DEADLINE: NumberLimit = NumberLimit::real(
    1e-6,
    1e12,
    "no machine has a shorter cycle, and every program is done in 11 days",
);

/// The error allowed, in the unit of its measure.
const ERROR: NumberLimit = NumberLimit::real(
    1e-30,
    1e30,
    "no program is free of rounding errors, and a larger error allows everything",
);

/// The size an error is measured by at least, in the unit of the output.
const SCALE: NumberLimit = NumberLimit::real(
    1e-30,
    1e30,
    "a smaller scale has no effect, and no output is larger",
);

/// Numbers of inputs, in SI units.
const INPUT: NumberLimit = NumberLimit::real(
    -1e30,
    1e30,
    "products of such numbers must be numbers of binary64",
);

/// The limits of the numbers of a scene: name, limit, and default.
pub const FIELDS: &[(&str, NumberLimit, &str)] = &[
    ("deadline", DEADLINE, "none"),
    ("output.error", ERROR, "none"),
    ("output.scale", SCALE, "usual size"),
    ("bind", INPUT, ""),
    ("range", INPUT, ""),
    ("locked", INPUT, ""),
    ("motion.time", motion::TIME, "10"),
    ("motion.error", ERROR, "0.01"),
    ("motion.energy", ERROR, "none"),
    ("motion.start", INPUT, "the model's"),
];

/// A scene with its model or equations.
#[derive(Debug)]
pub struct SceneFile {
    /// Scene.
    pub scene: Scene,
    /// The model or the equations.
    pub subject: SceneSubject,
    /// Warnings about the model.
    pub warnings: Report,
    /// The motion that programs are judged by.
    pub motion: Option<SceneMotion>,
    /// Parts that may be left out.
    pub neglect: NeglectWish,
}

impl SceneFile {
    /// Reads a scene file (`*.scene.toml`) and the files it names.
    ///
    /// # Errors
    ///
    /// Messages that point into the scene, or into the file it names.
    pub fn load(path: &Path) -> Result<SceneFile, Report> {
        let text = sources::text(path, &limited::SCENE)?;
        let name = path.file_name().unwrap_or(path.as_os_str());
        let folder = path.parent().unwrap_or(Path::new(""));
        read(&name.to_string_lossy(), &text, folder)
    }

    /// The function of the scene, in its formulation, before any entry of the
    /// scene is used except fixed joints.
    pub fn module(&self) -> Result<Module, GenerateError> {
        match &self.subject {
            SceneSubject::Equations(module) => Ok((**module).clone()),
            SceneSubject::Model(subject) => subject.equations(self.formulation()),
        }
    }

    /// The same function with no inputs known, every joint moving, all outputs.
    pub fn general(&self) -> Result<Module, GenerateError> {
        match &self.subject {
            SceneSubject::Equations(module) => Ok((**module).clone()),
            SceneSubject::Model(subject) => subject.generate(&subject.general, self.formulation()),
        }
    }

    /// Watches the joints of needed accelerations where none is watched.
    fn watch_what_is_needed(&mut self) {
        let (Some(motion), SceneSubject::Model(subject)) = (&mut self.motion, &self.subject) else {
            return;
        };
        if motion.watch.is_empty() {
            let needed = |joint: &usize| {
                let mut outputs = self.scene.outputs.iter();
                outputs.any(|need| need.pattern.matches("qdd", &[*joint as u32 + 1]))
            };
            let joints = 0..subject.general.joints.len();
            motion.watch = joints.filter(needed).collect();
        }
    }

    /// The formulation the scene wishes for, else the generator's default.
    pub fn formulation(&self) -> Formulation {
        match &self.scene.formulation {
            None => Formulation::default(),
            Some(wished) => Formulation::from_name(wished)
                .expect("a scene wishes for a formulation that there is, its reader checks it"),
        }
    }
}

/// Subject of a scene.
#[derive(Debug)]
pub enum SceneSubject {
    /// A model and a function of it.
    Model(Box<ModelSubject>),
    /// Equations as read: the one function of the scene.
    Equations(Box<Module>),
}

/// A model and a function of it.
#[derive(Clone, Debug)]
pub struct ModelSubject {
    /// The model as read.
    pub general: Model,
    /// The model with joints held as in the scene: driven ones at rest.
    pub model: Model,
    /// The function.
    pub function: FunctionKind,
    /// The name of the one function wanted of those generated (`sensor_2`).
    pub name: String,
    /// Way in which equations are generated.
    pub options: Options,
}

impl ModelSubject {
    /// The function in a formulation, with joints held.
    pub fn equations(&self, formulation: Formulation) -> Result<Module, GenerateError> {
        self.generate(&self.model, formulation)
    }

    fn generate(&self, model: &Model, formulation: Formulation) -> Result<Module, GenerateError> {
        let request = GenerationRequest {
            function: self.function,
            formulation,
            options: self.options.clone(),
        };
        let mut module = generate_asked(model, &request)?;
        if module.functions.len() > 1 {
            module
                .functions
                .retain(|function| function.name == self.name);
        }
        Ok(module)
    }

    fn hold(&mut self, joints: &[HeldJoint]) {
        for held in joints {
            let joint = &mut self.model.joints[held.number as usize - 1];
            joint.nature = Nature::Driven;
            match held.hold {
                Hold::Driven => {
                    joint.has_velocity = true;
                    joint.has_acceleration = true;
                }
                Hold::Locked(position) => {
                    joint.has_velocity = false;
                    joint.has_acceleration = false;
                    joint.initial = [position, 0.0, 0.0];
                }
            }
        }
    }

    /// Keeps the symbols of parameters that are zero in the model alone.
    fn keep_needed_symbols(&mut self, words: &ElementStatements) {
        self.options.all_parameters = words.said().any(|(array, indices, known)| {
            let present = indices.iter().take_while(|&&index| index > 0).count();
            kinematics::parameter(&self.general, array, &indices[..present]) == Some(0.0)
                && known != ElementKnowledge::Bound(0.0)
        });
    }
}
