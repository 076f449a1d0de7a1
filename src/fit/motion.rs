//! The error of a program over time: a motion with it beside the same motion in
//! binary64.

use crate::generate::{Formulation, Options};
use crate::model::{Model, Nature};
use crate::motion::{
    EquationSetting, IntegrationMethod, Laws, MotionError, MultibodySystem, SimulationPlan,
    SimulationRun, simulate,
};
use crate::robotran::FunctionKind;
use crate::scene::{PIPELINE, SceneFile, SceneMotion, SceneSubject};
use robovec_framework::scene::Scene;
use robovec_ir::{Format, Machine, Module};
use robovec_passes::registry::REGISTRY;

/// Samples of a motion that are compared.
const SAMPLES: u32 = 500;

/// The step of the integrator, in samples. It is fixed, so that both motions
/// take the same steps and differ by rounding alone.
const STEPS: u32 = 4;

/// Steps that a motion may take: every choice is tried with as many.
const STEP_LIMIT: u64 = 100_000;

/// A scene's motion in binary64, which that with a program is compared with.
pub struct MotionTolerance<'a> {
    wish: &'a SceneMotion,
    machine: &'a Machine,
    /// The model with its joints held, at the start.
    model: Model,
    laws: Laws,
    scene: Scene,
    options: Options,
    formulation: Formulation,
    accelerations: bool,
    /// Samples of every step: more where the motion is stiff.
    steps: u32,
    reference: SimulationRun,
    /// The largest displacement of every watched joint from its mean.
    scales: Vec<f64>,
}

/// The error of a program over time.
#[derive(Clone, PartialEq, Debug, serde::Serialize)]
pub struct MotionShare {
    /// The largest error of a watched joint, in parts of its largest
    /// displacement; infinite where the motion fails.
    pub error: f64,
    /// What the scene allows.
    pub allowed: f64,
    /// How long the motion lasts, s.
    pub time: f64,
}

impl MotionShare {
    /// True where the scene allows it.
    pub fn holds(&self) -> bool {
        self.error <= self.allowed
    }
}

impl<'a> MotionTolerance<'a> {
    /// Integrates a scene's motion in binary64; `None` where the scene has
    /// none, or needs nothing that moves.
    ///
    /// # Errors
    ///
    /// See [`MotionError`].
    pub fn new(
        file: &'a SceneFile,
        laws: Laws,
        machine: &'a Machine,
    ) -> Result<Option<MotionTolerance<'a>>, MotionError> {
        let (Some(wish), SceneSubject::Model(subject)) = (&file.motion, &file.subject) else {
            return Ok(None);
        };
        let moves = matches!(
            subject.function,
            FunctionKind::Dirdyna | FunctionKind::Accelred
        );
        if !moves || wish.watch.is_empty() {
            return Ok(None);
        }
        let mut tolerance = MotionTolerance {
            wish,
            machine,
            model: subject.model.clone(),
            laws: laws.clone(),
            scene: Scene {
                outputs: Vec::new(),
                ..file.scene.clone()
            },
            options: subject.options.clone(),
            formulation: file.formulation(),
            accelerations: subject.function == FunctionKind::Accelred,
            steps: STEPS,
            reference: SimulationRun::default(),
            scales: Vec::new(),
        };
        // Laws stay what they are where the model starts elsewhere.
        let setting = EquationSetting::default();
        let (system, _) = MultibodySystem::new(&subject.model, laws, &setting)?;
        tolerance.laws = system.settled_laws();
        for (joint, position) in wish.start(0) {
            if tolerance.model.joints[joint].nature != Nature::Driven {
                tolerance.model.joints[joint].initial[0] = position;
            }
        }
        tolerance.settle()?;
        Ok(Some(tolerance))
    }

    /// Makes the reference with steps so small that halving them changes a
    /// tenth of the error allowed at most.
    fn settle(&mut self) -> Result<(), MotionError> {
        let mut coarse = self.run(None);
        loop {
            self.steps *= 2;
            let fine = self.run(None);
            if let (Ok(coarse), Ok(fine)) = (&coarse, &fine) {
                self.scales = self.scales_of(fine);
                if let Some(still) = self.scales.iter().position(|&scale| scale < 1e-9) {
                    let joint = self.wish.watch[still];
                    let name = self.model.joints[joint].name.clone();
                    return Err(MotionError::Still(name));
                }
                if self.share(coarse, fine) <= 0.1 * self.wish.error {
                    self.reference = fine.clone();
                    return Ok(());
                }
            }
            let steps = u64::from(2 * self.steps) * u64::from(SAMPLES);
            if steps > STEP_LIMIT {
                fine?;
                return Err(MotionError::TooManySteps(steps));
            }
            coarse = fine;
        }
    }

    fn scales_of(&self, run: &SimulationRun) -> Vec<f64> {
        let positions = |joint: usize| run.samples.iter().map(move |sample| sample.state.q[joint]);
        let count = run.samples.len() as f64;
        let scale = |&joint: &usize| {
            let mean = positions(joint).sum::<f64>() / count;
            let away = positions(joint).map(|position| (position - mean).abs());
            away.fold(f64::MIN_POSITIVE, f64::max)
        };
        self.wish.watch.iter().map(scale).collect()
    }

    fn share(&self, one: &SimulationRun, other: &SimulationRun) -> f64 {
        let watched = self.wish.watch.iter().zip(&self.scales);
        let parts = watched.map(|(&joint, scale)| one.distance(other, joint) / scale);
        parts.fold(0.0, f64::max)
    }

    /// The error of a program in a format over time.
    pub fn of(&self, program: &Module, format: Format) -> MotionShare {
        let run = self.run(Some((program, format)));
        let error = run.map_or(f64::INFINITY, |run| self.share(&self.reference, &run));
        MotionShare {
            error,
            allowed: self.wish.error,
            time: self.wish.time,
        }
    }

    fn run(&self, program: Option<(&Module, Format)>) -> Result<SimulationRun, MotionError> {
        let pipeline = REGISTRY
            .pipeline(PIPELINE)
            .expect("the usual pipeline is well formed");
        let setting = EquationSetting {
            formulation: self.formulation,
            passes: Some((&pipeline, self.machine)),
            format: Format::BINARY64,
            accelerations: self.accelerations,
            scene: Some((&self.scene, &self.options)),
            program,
        };
        let (mut system, initial) = MultibodySystem::new(&self.model, self.laws.clone(), &setting)?;
        let plan = SimulationPlan {
            duration: self.wish.time,
            samples: SAMPLES,
            method: IntegrationMethod::RungeKutta {
                step: self.wish.time / f64::from(SAMPLES * self.steps),
            },
            step_limit: STEP_LIMIT,
        };
        simulate(&mut system, &initial, &plan, &mut |_| ())
    }
}
