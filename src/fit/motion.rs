//! The error of a program over time: a motion with it beside the same motion in
//! binary64.

use crate::motion::{
    IntegrationMethod, Laws, MotionError, MultibodySystem, SimulationPlan, SimulationRun, simulate,
};
use crate::robotran::FunctionKind;
use crate::scene::{SceneFile, SceneMotion, SceneSubject, WatchedJoints};
use robovec_ir::{Format, Machine, Module};

/// Samples of a motion that are compared.
const SAMPLES: u32 = 500;

/// Steps from one sample to the next, at first. Both motions take the same
/// steps, so that they differ by rounding alone.
const STEPS: u32 = 4;

/// Steps that a motion may take: every choice is tried with as many.
const STEP_LIMIT: u64 = 100_000;

/// A scene's motion in binary64, which that with a program is compared with.
pub struct MotionTolerance<'a> {
    file: &'a SceneFile,
    wish: &'a SceneMotion,
    machine: &'a Machine,
    laws: Laws,
    /// Steps from one sample to the next: more where the motion is stiff.
    steps: u32,
    reference: SimulationRun,
    watched: WatchedJoints,
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
        // Laws stay what they are where the model starts elsewhere.
        let laws = MultibodySystem::settled(&subject.model, laws)?;
        let run = |steps| run(file, wish, (&laws, machine), steps, None);
        // Steps are halved until that changes a tenth of the error allowed at
        // most.
        let mut steps = STEPS;
        let mut coarse = run(steps);
        loop {
            steps *= 2;
            let fine = run(steps);
            if let (Ok(coarse), Ok(fine)) = (&coarse, &fine) {
                let runs = std::slice::from_ref(fine);
                let watched = WatchedJoints::new(&wish.watch, &subject.model, runs)?;
                if watched.share(coarse, fine) <= 0.1 * wish.error {
                    return Ok(Some(MotionTolerance {
                        file,
                        wish,
                        machine,
                        steps,
                        reference: fine.clone(),
                        watched,
                        laws,
                    }));
                }
            }
            let next = u64::from(2 * steps) * u64::from(SAMPLES);
            if next > STEP_LIMIT {
                fine?;
                return Err(MotionError::TooManySteps(next));
            }
            coarse = fine;
        }
    }

    /// The error of a program in a format over time.
    pub fn of(&self, program: &Module, format: Format) -> MotionShare {
        let forces = (&self.laws, self.machine);
        let program = Some((program, format));
        let run = run(self.file, self.wish, forces, self.steps, program);
        let error = run.map_or(f64::INFINITY, |run| {
            self.watched.share(&self.reference, &run)
        });
        MotionShare {
            error,
            allowed: self.wish.error,
            time: self.wish.time,
        }
    }
}

/// A scene's motion with so many steps from one sample to the next.
fn run(
    file: &SceneFile,
    wish: &SceneMotion,
    forces: (&Laws, &Machine),
    steps: u32,
    program: Option<(&Module, Format)>,
) -> Result<SimulationRun, MotionError> {
    let plan = SimulationPlan {
        duration: wish.time,
        samples: SAMPLES,
        method: IntegrationMethod::RungeKutta {
            step: wish.time / f64::from(SAMPLES * steps),
        },
        step_limit: STEP_LIMIT,
    };
    file.moving(forces, &wish.start(0), program, |system, initial| {
        simulate(system, initial, &plan, &mut |_| ())
    })
}
