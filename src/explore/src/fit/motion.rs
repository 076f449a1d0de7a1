//! The error of a program over time: a motion with it beside one in binary64.

use crate::scene::{SceneFile, SceneMotion, SceneSubject, WatchedJoints};
use robovec_dynamics::motion::{
    EVENT_TOLERANCE, IntegrationMethod, Laws, MotionError, MultibodySystem, SimulationPlan,
    SimulationRun, simulate,
};
use robovec_ir::{Format, Machine, Module};
use robovec_robotran::FunctionKind;

/// Samples of a motion that are compared.
const SAMPLES: u32 = 500;

/// Steps between samples at first, the same ones for both motions.
const STEPS: u32 = 4;

/// Maximum number of steps of a motion, for every choice.
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
    /// The largest error of a watched joint, relative to its largest
    /// displacement; infinite where the motion fails.
    pub error: f64,
    /// Error that the scene allows.
    pub allowed: f64,
    /// The drift of energy, where the scene limits it.
    pub energy: Option<EnergyDrift>,
    /// Time of the motion, s.
    pub time: f64,
    /// Steps it was taken in: roundings add up with their number.
    pub steps: u64,
}

/// Change of energy that no work explains, relative to the largest kinetic one.
#[derive(Clone, Copy, PartialEq, Debug, serde::Serialize)]
pub struct EnergyDrift {
    /// The largest in the motion; infinite where the motion fails.
    pub drift: f64,
    /// Drift that the scene allows.
    pub allowed: f64,
}

impl MotionShare {
    /// True where the scene allows it.
    pub fn holds(&self) -> bool {
        self.used() <= 1.0
    }

    /// The largest ratio of its errors to the allowed ones.
    pub fn used(&self) -> f64 {
        let energy = self
            .energy
            .map_or(0.0, |energy| energy.drift / energy.allowed);
        (self.error / self.allowed).max(energy)
    }
}

/// The drift of energy of a run, relative to its largest kinetic energy.
fn drift(run: &SimulationRun) -> f64 {
    match run.energy_drift() {
        0.0 => 0.0,
        drift => drift / run.energy_scale(),
    }
}

impl<'a> MotionTolerance<'a> {
    /// Integrates a scene's motion in binary64, if it has one that moves.
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
        if !moves || wish.watch.is_empty() && wish.energy.is_none() {
            return Ok(None);
        }
        // Laws stay what they are where the model starts elsewhere.
        let laws = MultibodySystem::settled(&subject.model, laws)?;
        let run = |steps| run(file, wish, (&laws, machine), steps, None);
        // Steps are halved until that changes a tenth of the error allowed at
        // most, and they alone let a tenth of the energy allowed drift.
        let mut steps = STEPS;
        let mut coarse = run(steps);
        loop {
            steps *= 2;
            let fine = run(steps);
            if let (Ok(coarse), Ok(fine)) = (&coarse, &fine) {
                let runs = std::slice::from_ref(fine);
                let watched = WatchedJoints::new(&wish.watch, &subject.model, runs)?;
                let keeps = |allowed: f64| drift(fine) <= 0.1 * allowed;
                if watched.share(coarse, fine) <= 0.1 * wish.error && wish.energy.is_none_or(keeps)
                {
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

    /// Steps of a motion with a program.
    pub fn steps(&self) -> u64 {
        u64::from(SAMPLES) * u64::from(self.steps)
    }

    /// The error of a program in a format over time.
    pub fn of(&self, program: &Module, format: Format) -> MotionShare {
        let forces = (&self.laws, self.machine);
        let program = Some((program, format));
        let run = run(self.file, self.wish, forces, self.steps, program);
        let run = run.as_ref();
        let error = run.map_or(f64::INFINITY, |run| {
            self.watched.share(&self.reference, run)
        });
        let energy = self.wish.energy.map(|allowed| EnergyDrift {
            drift: run.map_or(f64::INFINITY, drift),
            allowed,
        });
        MotionShare {
            error,
            energy,
            allowed: self.wish.error,
            time: self.wish.time,
            steps: self.steps(),
        }
    }
}

/// A scene's motion with this number of steps from one sample to the next.
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
        event_tolerance: EVENT_TOLERANCE,
    };
    file.moving(forces, &wish.start(0), program, |system, initial| {
        simulate(system, initial, &plan, &mut |_| ())
    })
}
