//! Subject of a scene: a model whose equations are made, or equations.

use super::known::{ElementKnowledge, ElementStatements};
use robovec_dynamics::generate::{
    Formulation, GenerateError, GenerationRequest, Options, generate_asked,
};
use robovec_dynamics::kinematics;
use robovec_framework::scene::{HeldJoint, Hold};
use robovec_ir::Module;
use robovec_model::{Model, Nature};
use robovec_robotran::FunctionKind;

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
    /// The model with its joints held as in the scene: locked joints are driven
    /// ones without velocity and acceleration.
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
    ///
    /// # Errors
    ///
    /// Errors of the generator.
    pub fn equations(&self, formulation: Formulation) -> Result<Module, GenerateError> {
        self.generate(&self.model, formulation)
    }

    /// The function of a model in a formulation.
    pub(super) fn generate(
        &self,
        model: &Model,
        formulation: Formulation,
    ) -> Result<Module, GenerateError> {
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

    pub(super) fn hold(&mut self, joints: &[HeldJoint]) {
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

    /// Keeps the symbols of parameters that are zero in the model but not in
    /// the scene.
    pub(super) fn keep_needed_symbols(&mut self, words: &ElementStatements) {
        self.options.all_parameters = words.said().any(|(array, indices, known)| {
            let present = indices.iter().take_while(|&&index| index > 0).count();
            kinematics::parameter(&self.general, array, &indices[..present]) == Some(0.0)
                && known != ElementKnowledge::Bound(0.0)
        });
    }
}
