//! A run in time: its steps, its samples and a summary.

use super::events::{EventBracket, EventRecord, EventWatch, Signal};
use super::integrate::{dormand_prince, growth, runge_kutta};
use super::system::{EvaluationWork, MultibodySystem};
use super::{Energy, MotionError};
use crate::kinematics::MotionState;

/// Way in which a step is made.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum IntegrationMethod {
    /// Classical Runge-Kutta of fourth order with a fixed step, s. The step
    /// is shortened to divide the interval between samples.
    RungeKutta {
        /// The largest step.
        step: f64,
    },
    /// Dormand and Prince's pair of orders 5 and 4, with steps by tolerances.
    DormandPrince {
        /// Error per step, relative to the number.
        relative: f64,
        /// Error per step that is always accepted.
        absolute: f64,
    },
}

/// Plan of a simulation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SimulationPlan {
    /// Simulated time, s.
    pub duration: f64,
    /// Number of samples after the first.
    pub samples: u32,
    /// Way in which steps are made.
    pub method: IntegrationMethod,
    /// Maximum number of steps of a run, rejected and locating ones included.
    pub step_limit: u64,
    /// Precision of the times of events, s.
    pub event_tolerance: f64,
}

/// The system at a time.
#[derive(Clone, PartialEq, Debug)]
pub struct MotionSample {
    /// The state.
    pub state: MotionState,
    /// Its energies.
    pub energy: Energy,
    /// Work of dampers, constant forces and drives since the start, J.
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
    /// Steps that looked for the times of events.
    pub searched: u64,
    /// Total evaluations.
    pub work: EvaluationWork,
    /// The events of the laws that happened, in time.
    pub events: Vec<EventRecord>,
    /// Number of times contacts opened or closed.
    pub contacts: u64,
    /// Time of the event that ended the run, s.
    pub stopped: Option<f64>,
}

impl SimulationRun {
    /// The largest change of energy that no work explains, J.
    pub fn energy_drift(&self) -> f64 {
        let balance = |sample: &MotionSample| sample.energy.total() - sample.work;
        let start = balance(self.samples.first().expect("a run begins with a sample"));
        let changes = self.samples.iter().map(|s| (balance(s) - start).abs());
        changes.fold(0.0, f64::max)
    }

    /// The range of the kinetic energy, J: the scale for a drift of energy.
    pub fn energy_scale(&self) -> f64 {
        let kinetic = self.samples.iter().map(|sample| sample.energy.kinetic);
        kinetic.fold(0.0, f64::max)
    }

    /// The largest distance between the positions of a joint, by index, in this
    /// run and another with samples at the same times, m or rad.
    pub fn distance(&self, other: &SimulationRun, joint: usize) -> f64 {
        assert_eq!(
            self.samples.len(),
            other.samples.len(),
            "both runs have samples at the same times"
        );
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

/// Mean position of a joint, by index, over the samples of runs, m or rad.
pub fn mean_position(runs: &[SimulationRun], joint: usize) -> f64 {
    let positions = || {
        let samples = runs.iter().flat_map(|run| &run.samples);
        samples.map(|sample| sample.state.q[joint])
    };
    assert!(positions().next().is_some(), "a run begins with a sample");
    positions().sum::<f64>() / positions().count() as f64
}

/// Integrates a system from a state; `progress` gets the time after a step.
pub fn simulate(
    system: &mut MultibodySystem<'_>,
    initial: &MotionState,
    plan: &SimulationPlan,
    progress: &mut dyn FnMut(f64),
) -> Result<SimulationRun, MotionError> {
    let before = system.work;
    let mut integrator = Integrator {
        watch: EventWatch::new(&system.laws),
        signals: Vec::new(),
        system,
        plan,
        packed: MultibodySystem::pack(initial, 0.0),
        step: plan.duration / f64::from(plan.samples.max(1)) / 10.0,
        run: SimulationRun::default(),
    };
    integrator.sample(initial.time)?;
    integrator.look(initial);
    for sample in 1..=plan.samples {
        // Times are products, so that they do not drift.
        let at = |sample: u32| {
            initial.time + plan.duration * f64::from(sample) / f64::from(plan.samples)
        };
        let (from, to) = (at(sample - 1), at(sample));
        match plan.method {
            IntegrationMethod::RungeKutta { step } => integrator.fixed(from, to, step, progress)?,
            IntegrationMethod::DormandPrince { .. } => integrator.adaptive(from, to, progress)?,
        }
        if let Some(stopped) = integrator.run.stopped {
            integrator.sample(stopped)?;
            break;
        }
        integrator.sample(to)?;
    }
    let after = integrator.system.work;
    integrator.run.work = EvaluationWork {
        slopes: after.slopes - before.slopes,
        rounds: after.rounds - before.rounds,
    };
    Ok(integrator.run)
}

struct Integrator<'a, 's, 'm> {
    system: &'s mut MultibodySystem<'m>,
    plan: &'a SimulationPlan,
    packed: Vec<f64>,
    step: f64,
    run: SimulationRun,
    watch: EventWatch,
    /// Watched values, in the state the run has reached.
    signals: Vec<Signal>,
}

struct TriedStep {
    /// Length of the step, s.
    length: f64,
    next: Vec<f64>,
    /// Its error over the tolerance; none where steps are fixed.
    ratio: f64,
}

impl Integrator<'_, '_, '_> {
    fn sample(&mut self, time: f64) -> Result<(), MotionError> {
        let state = self.system.unpack(time, &self.packed)?;
        assert!(
            (self.run.samples.last()).is_none_or(|last| last.state.time <= time),
            "samples are in the order of time"
        );
        self.run.samples.push(MotionSample {
            energy: self.system.energy(&state),
            work: work_of(&self.packed),
            gap: self.system.gap(&state),
            state,
        });
        Ok(())
    }

    fn count(&mut self) -> Result<(), MotionError> {
        let count = self.run.steps + self.run.rejected + self.run.searched;
        if count >= self.plan.step_limit {
            return Err(MotionError::TooManySteps(count));
        }
        Ok(())
    }

    /// Takes over the result of a step, loops closed where they are projected.
    fn accept(&mut self, time: f64, next: &[f64]) -> Result<(), MotionError> {
        let state = self.system.unpack(time, next)?;
        self.system.renew(&state)?;
        let work = work_of(next);
        self.packed = MultibodySystem::pack(&state, work);
        self.run.steps += 1;
        self.look(&state);
        Ok(())
    }

    /// Evaluates the monitored quantities in a state that the run has reached.
    fn look(&mut self, state: &MotionState) {
        if self.watch.is_empty() {
            return;
        }
        self.signals = self.signals(state);
        let reached = self.watch.reach(state.time, &self.signals);
        self.run.events.extend(reached.records);
        self.run.contacts += reached.contacts;
        if reached.stop {
            self.run.stopped = Some(state.time);
        }
    }

    fn signals(&self, state: &MotionState) -> Vec<Signal> {
        let system = &*self.system;
        self.watch.signals(system.model, &system.laws, state)
    }

    /// Tries a step from the present state of the run.
    fn attempt(&mut self, time: f64, length: f64) -> Result<TriedStep, MotionError> {
        let slope = |time: f64, packed: &[f64]| self.system.slope(time, packed);
        let (next, ratio) = match self.plan.method {
            IntegrationMethod::RungeKutta { .. } => {
                (runge_kutta(time, &self.packed, length, slope)?, 0.0)
            }
            IntegrationMethod::DormandPrince { relative, absolute } => {
                let (next, error) = dormand_prince(time, &self.packed, length, slope)?;
                let ratio = self.ratio(&next, &error, (relative, absolute));
                (next, ratio)
            }
        };
        Ok(TriedStep {
            length,
            next,
            ratio,
        })
    }

    /// Watched values after a step.
    fn after(&mut self, time: f64, tried: &TriedStep) -> Result<Vec<Signal>, MotionError> {
        let state = self.system.unpack(time + tried.length, &tried.next)?;
        Ok(self.signals(&state))
    }

    /// The step, or the shorter one to just after the first event in it.
    fn cut(&mut self, time: f64, whole: TriedStep) -> Result<TriedStep, MotionError> {
        if self.watch.is_empty() {
            return Ok(whole);
        }
        let mut ends = self.after(time, &whole)?;
        let mut last = whole;
        if self.watch.passed(&ends).is_empty() {
            let part = self.watch.dip(last.length, &self.signals, &ends);
            let Some(length) = part.map(|part| part * last.length).filter(|&x| x > 0.0) else {
                return Ok(last);
            };
            let (tried, signals) = self.search(time, length)?;
            if self.watch.passed(&signals).is_empty() {
                return Ok(last);
            }
            (last, ends) = (tried, signals);
        }
        let tolerance = self.plan.event_tolerance;
        let mut bracket = EventBracket::new(last.length);
        let mut starts = self.signals.clone();
        while !bracket.is_narrow(tolerance) {
            let passed = self.watch.passed(&ends);
            let of = |&place: &usize| [starts[place].value, ends[place].value];
            let length = bracket.next(tolerance, passed.first().map(of));
            let (tried, signals) = self.search(time, length)?;
            if self.watch.passed(&signals).is_empty() {
                (bracket.from, starts) = (length, signals);
            } else {
                (bracket.to, last, ends) = (length, tried, signals);
            }
        }
        Ok(last)
    }

    /// A step that looks for an event.
    fn search(&mut self, time: f64, length: f64) -> Result<(TriedStep, Vec<Signal>), MotionError> {
        self.count()?;
        self.run.searched += 1;
        let tried = self.attempt(time, length)?;
        let signals = self.after(time, &tried)?;
        Ok((tried, signals))
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
            let (mut time, mut rest) = (from + step * done, step);
            done += 1.0;
            let end = from + step * done;
            while rest > 0.0 {
                self.count()?;
                let whole = self.attempt(time, rest)?;
                let tried = self.cut(time, whole)?;
                time = if tried.length < rest {
                    time + tried.length
                } else {
                    end
                };
                self.accept(time, &tried.next)?;
                rest = end - time;
                if self.run.stopped.is_some() {
                    return Ok(());
                }
            }
            progress(end);
        }
        Ok(())
    }

    fn adaptive(
        &mut self,
        from: f64,
        to: f64,
        progress: &mut dyn FnMut(f64),
    ) -> Result<(), MotionError> {
        let smallest = 1e-14 * self.plan.duration;
        let mut time = from;
        while time < to && self.run.stopped.is_none() {
            self.count()?;
            let last = self.step >= to - time;
            let step = if last { to - time } else { self.step };
            // A stage may leave what the loops allow: a shorter one may not.
            let (ratio, failure) = match self.attempt(time, step) {
                Ok(whole) if whole.ratio <= 1.0 => {
                    let ratio = whole.ratio;
                    let tried = self.cut(time, whole)?;
                    let cut = tried.length < step;
                    time = if last && !cut {
                        to
                    } else {
                        time + tried.length
                    };
                    self.accept(time, &tried.next)?;
                    progress(time);
                    (ratio, None)
                }
                Ok(missed) => (missed.ratio, None),
                Err(failure) => (f64::INFINITY, Some(failure)),
            };
            if ratio > 1.0 {
                self.run.rejected += 1;
            }
            // A last step says little about how long others may be.
            if !last || ratio > 1.0 {
                self.step = step * growth(ratio);
            }
            if self.step < smallest {
                let failure = match failure {
                    Some(failure) => failure,
                    None => self.too_short(time)?,
                };
                return Err(failure);
            }
        }
        Ok(())
    }

    /// Reason why steps have become too short, such as a dead point.
    fn too_short(&mut self, time: f64) -> Result<MotionError, MotionError> {
        let state = self.system.unpack(time, &self.packed)?;
        let step = self.step;
        let dead = self.system.dead_point(&state);
        Ok(dead.unwrap_or(MotionError::StepTooSmall { time, step }))
    }

    /// The largest error of a position or velocity over its tolerance.
    fn ratio(&self, next: &[f64], error: &[f64], (relative, absolute): (f64, f64)) -> f64 {
        assert_eq!(
            next.len(),
            self.packed.len(),
            "a step keeps the numbers of a state"
        );
        assert_eq!(error.len(), self.packed.len(), "one error per number");
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

/// The work that forces did, after positions and velocities.
fn work_of(packed: &[f64]) -> f64 {
    *packed.last().expect("packed states end with the work")
}
