//! A run in time: steps, samples and what they say of the whole.

use super::MotionError;
use super::integrate::{dormand_prince, growth, runge_kutta};
use super::system::{Energy, MultibodySystem};
use crate::kinematics::MotionState;

/// How a step is made.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum IntegrationMethod {
    /// Classical Runge-Kutta of fourth order with a fixed step, s. The step
    /// is shortened to divide the interval between samples.
    RungeKutta {
        /// The largest step.
        step: f64,
    },
    /// Dormand and Prince's pair of orders 5 and 4 with steps that meet
    /// tolerances on positions and velocities.
    DormandPrince {
        /// Error per step, relative to the number.
        relative: f64,
        /// Error per step that is always accepted.
        absolute: f64,
    },
}

/// What is simulated.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SimulationPlan {
    /// How long, s.
    pub duration: f64,
    /// Number of samples after the first.
    pub samples: u32,
    /// How steps are made.
    pub method: IntegrationMethod,
    /// Steps, rejected ones included, after which the run is given up.
    pub step_limit: u64,
}

/// The system at a time.
#[derive(Clone, PartialEq, Debug)]
pub struct MotionSample {
    /// The state.
    pub state: MotionState,
    /// Its energies.
    pub energy: Energy,
    /// What dampers, constant forces and drives have put in since the start,
    /// J.
    pub work: f64,
    /// The largest residual of the constraints.
    pub gap: f64,
}

/// A run.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct SimulationRun {
    /// The samples, at equal intervals.
    pub samples: Vec<MotionSample>,
    /// Steps taken.
    pub steps: u64,
    /// Steps that missed the tolerance and were repeated.
    pub rejected: u64,
}

impl SimulationRun {
    /// The largest change of energy that no work explains, J.
    pub fn energy_drift(&self) -> f64 {
        let balance = |sample: &MotionSample| sample.energy.total() - sample.work;
        let start = self.samples.first().map_or(0.0, balance);
        let changes = self.samples.iter().map(|s| (balance(s) - start).abs());
        changes.fold(0.0, f64::max)
    }

    /// The range that kinetic energy went through, J: what a drift of energy
    /// is to be compared with.
    pub fn energy_scale(&self) -> f64 {
        let kinetic = self.samples.iter().map(|sample| sample.energy.kinetic);
        kinetic.fold(0.0, f64::max)
    }

    /// The largest distance between the positions of a joint, by index, in this
    /// run and another with samples at the same times, m or rad.
    pub fn distance(&self, other: &SimulationRun, joint: usize) -> f64 {
        let pairs = self.samples.iter().zip(&other.samples);
        let apart = pairs.map(|(a, b)| (a.state.q[joint] - b.state.q[joint]).abs());
        apart.fold(0.0, f64::max)
    }

    /// The largest residual of the constraints.
    pub fn largest_gap(&self) -> f64 {
        let gaps = self.samples.iter().map(|sample| sample.gap);
        gaps.fold(0.0, f64::max)
    }
}

/// The mean position of a joint, by index, over the samples of some runs, m or
/// rad.
pub fn mean_position(runs: &[SimulationRun], joint: usize) -> f64 {
    let positions = || {
        let samples = runs.iter().flat_map(|run| &run.samples);
        samples.map(|sample| sample.state.q[joint])
    };
    positions().sum::<f64>() / positions().count() as f64
}

/// Integrates a system from an initial state. `progress` is told the time
/// after every step.
///
/// # Errors
///
/// See [`MotionError`].
pub fn simulate(
    system: &mut MultibodySystem<'_>,
    initial: &MotionState,
    plan: &SimulationPlan,
    progress: &mut dyn FnMut(f64),
) -> Result<SimulationRun, MotionError> {
    let mut integrator = Integrator {
        system,
        plan,
        packed: MultibodySystem::pack(initial, 0.0),
        step: plan.duration / f64::from(plan.samples.max(1)) / 10.0,
        run: SimulationRun {
            samples: Vec::new(),
            steps: 0,
            rejected: 0,
        },
    };
    integrator.sample(initial.time)?;
    for sample in 1..=plan.samples {
        // Times are products, so that they do not drift.
        let at = |sample: u32| {
            initial.time + plan.duration * f64::from(sample) / f64::from(plan.samples)
        };
        let (from, to) = (at(sample - 1), at(sample));
        match plan.method {
            IntegrationMethod::RungeKutta { step } => integrator.fixed(from, to, step, progress)?,
            IntegrationMethod::DormandPrince { relative, absolute } => {
                integrator.adaptive(from, to, (relative, absolute), progress)?;
            }
        }
        integrator.sample(to)?;
    }
    Ok(integrator.run)
}

struct Integrator<'a, 's, 'm> {
    system: &'s mut MultibodySystem<'m>,
    plan: &'a SimulationPlan,
    packed: Vec<f64>,
    step: f64,
    run: SimulationRun,
}

impl Integrator<'_, '_, '_> {
    fn sample(&mut self, time: f64) -> Result<(), MotionError> {
        let state = self.system.unpack(time, &self.packed)?;
        self.run.samples.push(MotionSample {
            energy: self.system.energy(&state),
            work: self.work(),
            gap: self.system.gap(&state),
            state,
        });
        Ok(())
    }

    fn work(&self) -> f64 {
        work_of(&self.packed)
    }

    fn count(&mut self) -> Result<(), MotionError> {
        let count = self.run.steps + self.run.rejected;
        if count >= self.plan.step_limit {
            return Err(MotionError::TooManySteps(count));
        }
        Ok(())
    }

    /// Takes over the result of a step, with loops closed.
    fn accept(&mut self, time: f64, next: &[f64]) -> Result<(), MotionError> {
        let state = self.system.unpack(time, next)?;
        self.system.renew(&state);
        let work = work_of(next);
        self.packed = MultibodySystem::pack(&state, work);
        self.run.steps += 1;
        Ok(())
    }

    fn fixed(
        &mut self,
        from: f64,
        to: f64,
        step: f64,
        progress: &mut dyn FnMut(f64),
    ) -> Result<(), MotionError> {
        // A step that divides the interval up to rounding is not halved.
        let steps = ((to - from) / step - 1e-6).ceil().max(1.0);
        let step = (to - from) / steps;
        let mut done = 0.0;
        while done < steps {
            self.count()?;
            let time = from + step * done;
            let next = runge_kutta(time, &self.packed, step, |time, packed| {
                self.system.slope(time, packed)
            })?;
            done += 1.0;
            self.accept(from + step * done, &next)?;
            progress(from + step * done);
        }
        Ok(())
    }

    fn adaptive(
        &mut self,
        from: f64,
        to: f64,
        tolerance: (f64, f64),
        progress: &mut dyn FnMut(f64),
    ) -> Result<(), MotionError> {
        let smallest = 1e-14 * self.plan.duration;
        let mut time = from;
        while time < to {
            self.count()?;
            let last = self.step >= to - time;
            let step = if last { to - time } else { self.step };
            let attempt = dormand_prince(time, &self.packed, step, |time, packed| {
                self.system.slope(time, packed)
            });
            // A stage may leave what the loops allow: a shorter one may not.
            let (next, ratio, failure) = match attempt {
                Ok((next, error)) => {
                    let ratio = self.ratio(&next, &error, tolerance);
                    (next, ratio, None)
                }
                Err(failure) => (Vec::new(), f64::INFINITY, Some(failure)),
            };
            if ratio <= 1.0 {
                time = if last { to } else { time + step };
                self.accept(time, &next)?;
                progress(time);
            } else {
                self.run.rejected += 1;
            }
            // A last step says little about how long others may be.
            if !last || ratio > 1.0 {
                self.step = step * growth(ratio);
            }
            if self.step < smallest {
                let step = self.step;
                return Err(failure.unwrap_or(MotionError::StepTooSmall { time, step }));
            }
        }
        Ok(())
    }

    /// The largest error of a position or velocity over its tolerance.
    fn ratio(&self, next: &[f64], error: &[f64], (relative, absolute): (f64, f64)) -> f64 {
        let numbers = self.packed.iter().zip(next).zip(error);
        // The work, which comes last, follows from the motion.
        let count = self.packed.len() - 1;
        numbers
            .take(count)
            .fold(0.0, |most, ((before, next), error)| {
                let size = before.abs().max(next.abs());
                let ratio = error.abs() / (absolute + relative * size);
                if ratio.is_nan() {
                    f64::INFINITY
                } else {
                    ratio.max(most)
                }
            })
    }
}

/// The work that forces did, behind positions and velocities.
fn work_of(packed: &[f64]) -> f64 {
    *packed.last().expect("packed states end with the work")
}
