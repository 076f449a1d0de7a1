//! Long simulations in one arithmetic.

use super::case::{Measured, Memo, StressBench, StressSubject};
use super::dynamics::{shared_model, shared_state};
use super::numbers::{Wide, Work, WorkingPrecision};
use super::{ProgramTreatment, StressError};
use robovec_dynamics::generate::{Formulation, GenerationRequest, generate};
use robovec_dynamics::kinematics::MotionState;
use robovec_dynamics::motion::integrate::{TimeStep, change_work};
use robovec_dynamics::motion::{Calculus, Drift, FreeMotion, Stepping};
use robovec_ir::Format;
use robovec_ir::cost::OperationWork;
use robovec_model::Model;
use robovec_num::arithmetic::Arithmetic;
use robovec_robotran::FunctionKind;
use std::convert::Infallible;
use std::ops::Add;

/// Conserved quantity.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kept {
    Energy,
    /// Linear and angular momentum.
    Momentum,
}

/// A model left to itself.
pub(super) struct Long {
    model: Model,
    initial: MotionState,
    kept: Kept,
    /// s.
    duration: f64,
    /// s.
    step: f64,
}

impl Long {
    pub(super) fn new(
        model: Model,
        initial: MotionState,
        kept: Kept,
        [duration, step]: [f64; 2],
    ) -> Long {
        Long {
            initial: shared_state(initial),
            model: shared_model(model),
            kept,
            duration,
            step,
        }
    }

    fn steps(&self, step: f64) -> u64 {
        (self.duration / step).round() as u64
    }
}

/// More steps than this are not repeated for format after format.
const MANY_STEPS: u64 = 500_000;

impl StressSubject for Long {
    fn metric(&self) -> &'static str {
        match self.kept {
            Kept::Energy => "energy drift",
            Kept::Momentum => "momentum drift",
        }
    }

    fn untreated(&self) -> ProgramTreatment {
        ProgramTreatment::default().with(|it| it.step = Some(self.step))
    }

    fn candidates(&self) -> Vec<ProgramTreatment> {
        let plain = self.untreated();
        let compensated = plain.with(|it| it.compensated = true);
        let precise = plain.with(|it| it.state = Some(Format::BINARY64));
        // Other steps, and how far they bring binary32.
        let steps = [1e-2, 1e-3].into_iter().filter(|step| *step > self.step);
        let others = steps.map(|step| compensated.with(|it| it.step = Some(step)));
        [compensated.clone(), precise]
            .into_iter()
            .chain(others)
            .collect()
    }

    fn rounds(&self) -> bool {
        self.steps(self.step) < MANY_STEPS
    }

    fn prepare(&self) -> Result<Box<dyn StressBench + '_>, StressError> {
        let request = GenerationRequest::new(FunctionKind::Accelred);
        let module = generate(&self.model, &request)?;
        let work = module.functions.iter().map(OperationWork::of);
        Ok(Box::new(LongBench {
            work: work.fold(OperationWork::default(), Add::add),
            known: Memo::default(),
            motion: FreeMotion::new(&self.model, Formulation::default())?,
            subject: self,
        }))
    }
}

struct LongBench<'a> {
    subject: &'a Long,
    motion: FreeMotion<'a>,
    work: OperationWork,
    /// Runs take long: none is made twice.
    known: Memo<ProgramTreatment, Drift>,
}

/// A run, for any arithmetic of its slopes.
struct Slopes<'a> {
    bench: &'a LongBench<'a>,
    state: WorkingPrecision,
    stepping: Stepping,
}

/// The same, for any format of its state.
struct WithSlopes<'a, A> {
    bench: &'a LongBench<'a>,
    slopes: &'a A,
    stepping: Stepping,
}

impl Work for Slopes<'_> {
    type Result = Drift;

    fn run<A: Arithmetic<Number: Wide>>(self, slopes: &A) -> Drift {
        self.state.work(WithSlopes {
            bench: self.bench,
            slopes,
            stepping: self.stepping,
        })
    }
}

impl<A: Arithmetic<Number: Wide>> Work for WithSlopes<'_, A> {
    type Result = Drift;

    fn run<S: Arithmetic<Number: Wide>>(self, state: &S) -> Drift {
        let slopes = Calculus {
            arithmetic: self.slopes,
            read: |number: A::Number| number.wide().high,
        };
        let state = Calculus {
            arithmetic: state,
            read: |number: S::Number| number.wide().high,
        };
        let bench = self.bench;
        bench
            .motion
            .drift(slopes, state, &bench.subject.initial, self.stepping)
    }
}

impl StressBench for LongBench<'_> {
    /// Of a motion there is no one number.
    fn condition(&self) -> f64 {
        f64::NAN
    }

    /// Errors of the method at this step, and of the energy by the format.
    fn floor(&self, format: Format) -> f64 {
        let treatment = self.subject.untreated();
        let treatment = treatment.with(|it| it.format = Format::BINARY64);
        self.error(&treatment).0.max(format.unit_roundoff())
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let (error, other) = self.error(treatment);
        let name = match self.subject.kept {
            Kept::Energy => "momentum drift",
            Kept::Momentum => "energy drift",
        };
        let steps = self.subject.steps(treatment.step_or(self.subject.step)) as f64;
        let state = treatment.state_format();
        let numbers = 2 * self.subject.model.joints.len();
        let slopes = (self.work * 4.0).cost(treatment.format);
        let change = change_work(numbers, treatment.compensated).cost(state);
        Ok(Measured {
            error,
            others: vec![(name, other)],
            outside: 0.0,
            consistent: true,
            cost: steps * (slopes + change),
        })
    }
}

impl LongBench<'_> {
    /// The drift that verdicts are about, and the other one.
    fn error(&self, treatment: &ProgramTreatment) -> (f64, f64) {
        let drift = self.drift(treatment);
        match self.subject.kept {
            Kept::Energy => (drift.energy, drift.momentum),
            Kept::Momentum => (drift.momentum, drift.energy),
        }
    }

    fn drift(&self, treatment: &ProgramTreatment) -> Drift {
        let step = treatment.step_or(self.subject.step);
        let stepping = Stepping {
            how: TimeStep {
                step,
                compensated: treatment.compensated,
            },
            steps: self.subject.steps(step),
            samples: 200,
        };
        let slopes = Slopes {
            bench: self,
            state: WorkingPrecision::In(treatment.state_format()),
            stepping,
        };
        let Ok(drift) = self.known.get(treatment.clone(), || {
            Ok::<Drift, Infallible>(WorkingPrecision::In(treatment.format).work(slopes))
        });
        drift
    }
}
