//! A scene in motion: its equations under laws of forces, from a start.

use super::{PIPELINE, SceneFile, SceneSubject};
use robovec_dynamics::kinematics::MotionState;
use robovec_dynamics::motion::{
    EquationSetting, Laws, MotionError, MultibodySystem, SimulationRun, mean_position,
};
use robovec_framework::scene::Scene;
use robovec_ir::{Format, Machine, Module};
use robovec_model::{Model, Nature};
use robovec_passes::registry::REGISTRY;
use robovec_robotran::FunctionKind;

/// A watched joint that moves by less, m or rad, is at rest.
const REST: f64 = 1e-9;

impl SceneFile {
    /// Does something with the scene's model as it starts: its equations of
    /// motion in binary64 by the usual pipeline for the scene, those of its
    /// outputs that a program computes by the program in its format. `start`
    /// holds positions of joints, by index, that differ from the model's.
    ///
    /// # Errors
    ///
    /// See [`MotionError`].
    ///
    /// # Panics
    ///
    /// Panics for a scene of equations, which has no motion.
    pub fn moving<T>(
        &self,
        (laws, machine): (&Laws, &Machine),
        start: &[(usize, f64)],
        program: Option<(&Module, Format)>,
        action: impl FnOnce(&mut MultibodySystem<'_>, &MotionState) -> Result<T, MotionError>,
    ) -> Result<T, MotionError> {
        let SceneSubject::Model(subject) = &self.subject else {
            unreachable!("the reader of scenes refuses [motion] without a model");
        };
        let mut model = subject.model.clone();
        for &(joint, position) in start {
            if model.joints[joint].nature != Nature::Driven {
                model.joints[joint].initial[0] = position;
            }
        }
        // The integrator needs every acceleration, not those of the scene only.
        let scene = Scene {
            outputs: Vec::new(),
            ..self.scene.clone()
        };
        let pipeline = REGISTRY
            .pipeline(PIPELINE)
            .expect("the usual pipeline is well formed");
        let setting = EquationSetting {
            formulation: self.formulation(),
            passes: Some((&pipeline, machine)),
            format: Format::BINARY64,
            accelerations: subject.function == FunctionKind::Accelred,
            whole_step: false,
            scene: Some((&scene, &subject.options)),
            program,
        };
        // What a run of `sim` looks out for does not end the motions of scenes.
        let laws = Laws {
            events: Vec::new(),
            ..laws.clone()
        };
        let (mut system, initial) = MultibodySystem::new(&model, laws, &setting)?;
        action(&mut system, &initial)
    }
}

/// Joints of interest, with the range of motion of each.
pub struct WatchedJoints {
    joints: Vec<usize>,
    /// The largest displacement of each from its mean, m or rad.
    pub scales: Vec<f64>,
}

impl WatchedJoints {
    /// Measures the range of motion of joints, by index, over all given runs.
    ///
    /// # Errors
    ///
    /// [`MotionError::Still`] where one of them does not move.
    pub fn new(
        joints: &[usize],
        model: &Model,
        runs: &[SimulationRun],
    ) -> Result<WatchedJoints, MotionError> {
        let scale = |&joint: &usize| {
            let mean = mean_position(runs, joint);
            let samples = runs.iter().flat_map(|run| &run.samples);
            let away = samples.map(|sample| (sample.state.q[joint] - mean).abs());
            away.fold(0.0, f64::max)
        };
        let scales: Vec<f64> = joints.iter().map(scale).collect();
        if let Some(still) = scales.iter().position(|&scale| scale < REST) {
            let name = model.joints[joints[still]].name.clone();
            return Err(MotionError::Still(name));
        }
        Ok(WatchedJoints {
            joints: joints.to_vec(),
            scales,
        })
    }

    /// The largest distance of one of them between two runs, relative to its
    /// largest displacement.
    pub fn share(&self, one: &SimulationRun, other: &SimulationRun) -> f64 {
        let watched = self.joints.iter().zip(&self.scales);
        let parts = watched.map(|(&joint, scale)| one.distance(other, joint) / scale);
        parts.fold(0.0, f64::max)
    }
}
