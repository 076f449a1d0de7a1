//! Closed loops in time, and the drift of their residuals.
//!
//! Accelerations and the forces of the loops are solved for together,
//! `[M J'; J 0]` with `J qdd = -Jdqd`, so that positions and velocities agree
//! with the loops only as well as they were integrated. Everything is computed
//! in the format: the generated equations, the elimination, the steps.

use super::case::{Measured, Memo, StressBench, StressSubject};
use super::dynamics::{shared_model, shared_state, worst};
use super::linear::eliminate;
use super::numbers::{Evaluation, Wide, Work, WorkingPrecision};
use super::program::{ModelProgram, ProgramRecipe};
use super::treatment::LoopStabilisation;
use super::units::Units;
use super::{ProgramTreatment, StressError};
use robovec_dynamics::generate::cuts_of_rows;
use robovec_dynamics::kinematics::MotionState;
use robovec_dynamics::motion::integrate::{IntegratedState, TimeStep, change_work};
use robovec_ir::Format;
use robovec_ir::cost::OperationWork;
use robovec_model::Model;
use robovec_num::arithmetic::Arithmetic;
use robovec_robotran::FunctionKind;
use std::convert::Infallible;

/// More steps than this are not repeated for format after format.
const FEW_STEPS: u64 = 500;

/// A model with closed loops, left to itself.
pub(super) struct DriftSubject {
    model: Model,
    initial: MotionState,
    /// s.
    step: f64,
    steps: u64,
}

impl DriftSubject {
    /// A model from its initial state on, in this number of steps (s).
    pub(super) fn new(model: Model, (step, steps): (f64, u64)) -> DriftSubject {
        DriftSubject {
            initial: shared_state(MotionState::initial(&model)),
            model: shared_model(model),
            step,
            steps,
        }
    }

    fn step_of(&self, treatment: &ProgramTreatment) -> (f64, u64) {
        let step = treatment.step_or(self.step);
        let steps = (self.step * self.steps as f64 / step).round();
        (step, steps as u64)
    }
}

impl StressSubject for DriftSubject {
    fn metric(&self) -> &'static str {
        "gap of the loop"
    }

    fn untreated(&self) -> ProgramTreatment {
        ProgramTreatment::default().with(|it| it.step = Some(self.step))
    }

    /// The loops projected, which keeps them closed to all digits.
    fn standard(&self) -> ProgramTreatment {
        self.untreated().with(|it| {
            it.format = Format::BINARY64;
            it.stabilisation = LoopStabilisation::Projection;
        })
    }

    fn programs(&self) -> Vec<ProgramTreatment> {
        let kinds = [LoopStabilisation::Baumgarte, LoopStabilisation::Projection];
        let program = |kind| self.untreated().with(|it| it.stabilisation = kind);
        kinds.map(program).to_vec()
    }

    fn candidates(&self) -> Vec<ProgramTreatment> {
        let mut list = self.programs();
        for program in std::iter::once(self.untreated()).chain(self.programs()) {
            list.push(program.with(|it| it.compensated = true));
            list.push(program.with(|it| it.format = Format::BINARY64));
            list.push(program.with(|it| it.state = Some(Format::BINARY64)));
        }
        list
    }

    fn is_small(&self) -> bool {
        true
    }

    /// Of long runs only the formats above are tried.
    fn rounds(&self) -> bool {
        self.steps <= FEW_STEPS
    }

    fn prepare(&self) -> Result<Box<dyn StressBench + '_>, StressError> {
        let program = |kind| {
            let recipe = ProgramRecipe::default();
            ModelProgram::new(&self.model, kind, recipe)
        };
        Ok(Box::new(DriftBench {
            subject: self,
            dynamics: program(FunctionKind::Dirdyna)?,
            position: program(FunctionKind::ConsHJ)?,
            acceleration: program(FunctionKind::ConsJdqd)?,
            rows: cuts_of_rows(&self.model)?.len(),
            known: Memo::default(),
        }))
    }
}

struct DriftBench<'a> {
    subject: &'a DriftSubject,
    dynamics: ModelProgram,
    position: ModelProgram,
    acceleration: ModelProgram,
    /// Of the loops.
    rows: usize,
    /// Runs take long: none is made twice.
    known: Memo<ProgramTreatment, f64>,
}

/// A run, for any format of its state.
struct DriftRun<'a> {
    bench: &'a DriftBench<'a>,
    treatment: &'a ProgramTreatment,
}

/// The slope of a state, in any arithmetic.
struct LoopSlope<'a> {
    bench: &'a DriftBench<'a>,
    state: &'a MotionState,
    /// Rate at which the residual decreases, 1/s; zero without stabilisation.
    rate: f64,
}

/// Joints projected onto the loops by the smallest changes, to first order.
struct LoopCorrection<'a> {
    bench: &'a DriftBench<'a>,
    state: &'a MotionState,
    /// Velocities, or else positions.
    velocities: bool,
}

/// The number of steps in which the residual decreases by a factor of e.
const CLOSING_STEPS: f64 = 5.0;

/// Number of corrections of positions after a step; each squares the residual.
const CORRECTIONS: u32 = 2;

impl DriftBench<'_> {
    /// An array of a function in some arithmetic.
    fn array<A: Arithmetic<Number: Wide>>(
        a: &A,
        program: &ModelProgram,
        state: &MotionState,
        (name, length): (&str, usize),
    ) -> Vec<A::Number> {
        let inputs = program.inputs(state);
        let evaluation = Evaluation {
            function: &program.function,
            inputs: &inputs,
        };
        let found = program.array(name, &evaluation.run(a), length);
        // Formats hold binary64 numbers, so that the high part is all.
        found.iter().map(|x| a.literal(x.high)).collect()
    }

    /// The state of the integrator's numbers.
    fn state(&self, numbers: &[f64]) -> MotionState {
        let mut state = self.subject.initial.clone();
        let joints = state.q.len();
        state.q.copy_from_slice(&numbers[..joints]);
        state.qd.copy_from_slice(&numbers[joints..]);
        state
    }

    /// The largest residual of the loops, m, exactly.
    fn gap(&self, state: &MotionState) -> f64 {
        let inputs = self.position.inputs(state);
        let numbers = WorkingPrecision::Reference;
        let flat = self.position.evaluate(numbers, Units::SI, &inputs);
        let residuals = self.position.array("h", &flat, self.rows);
        worst(residuals.iter().map(|x| x.high.abs()))
    }

    /// The longest coordinate of the model, m.
    fn size(&self) -> f64 {
        let points = self.subject.model.points.iter();
        let coordinates = points.flat_map(|point| point.coordinates);
        coordinates.fold(0.0, |most: f64, x| most.max(x.abs()))
    }

    fn error(&self, treatment: &ProgramTreatment) -> f64 {
        let kept = WorkingPrecision::In(treatment.state_format());
        let Ok(error) = self.known.get(treatment.clone(), || {
            Ok::<f64, Infallible>(kept.work(DriftRun {
                bench: self,
                treatment,
            }))
        });
        error
    }
}

impl Work for DriftRun<'_> {
    /// The largest gap, relative to the size of the model.
    type Result = f64;

    fn run<S: Arithmetic<Number: Wide>>(self, kept: &S) -> f64 {
        let (bench, treatment) = (self.bench, self.treatment);
        let (step, steps) = bench.subject.step_of(treatment);
        let how = TimeStep {
            step,
            compensated: treatment.compensated,
        };
        let computed = WorkingPrecision::In(treatment.format);
        let rate = match treatment.stabilisation {
            LoopStabilisation::Baumgarte => 1.0 / (CLOSING_STEPS * step),
            _ => 0.0,
        };
        let initial = &bench.subject.initial;
        let mut state = IntegratedState::new(kept, &[&initial.q[..], &initial.qd].concat());
        let read = |numbers: &[S::Number]| -> MotionState {
            let numbers: Vec<f64> = numbers.iter().map(|x| x.wide().high).collect();
            bench.state(&numbers)
        };
        let mut gap = 0.0f64;
        for _ in 0..steps {
            state.step(kept, how, &mut |numbers| {
                let state = read(numbers);
                let slope = computed.work(LoopSlope {
                    bench,
                    state: &state,
                    rate,
                });
                slope.iter().map(|&x| kept.literal(x)).collect()
            });
            if treatment.stabilisation == LoopStabilisation::Projection {
                let corrections = (0..CORRECTIONS).map(|_| false).chain([true]);
                for velocities in corrections {
                    let place = read(&state.numbers);
                    let change = computed.work(LoopCorrection {
                        bench,
                        state: &place,
                        velocities,
                    });
                    let first = if velocities { initial.q.len() } else { 0 };
                    for (number, change) in state.numbers[first..].iter_mut().zip(change) {
                        *number = kept.add(*number, kept.literal(change));
                    }
                }
            }
            let open = bench.gap(&read(&state.numbers));
            if !open.is_finite() {
                return f64::NAN;
            }
            gap = gap.max(open);
        }
        gap / bench.size()
    }
}

impl Work for LoopSlope<'_> {
    /// Velocities, then accelerations; NaN where loops do not determine them.
    type Result = Vec<f64>;

    fn run<A: Arithmetic<Number: Wide>>(self, a: &A) -> Vec<f64> {
        let (bench, state) = (self.bench, self.state);
        let (joints, rows) = (state.q.len(), bench.rows);
        let array = |program, name, length| DriftBench::array(a, program, state, (name, length));
        let mass = array(&bench.dynamics, "M", joints * joints);
        let bias = array(&bench.dynamics, "c", joints);
        let jacobian = array(&bench.position, "Jac", rows * joints);
        let quadratic = array(&bench.acceleration, "Jdqd", rows);
        let size = joints + rows;
        let mut matrix = vec![a.literal(0.0); size * size];
        let mut right: Vec<A::Number> = bias.into_iter().map(|x| a.neg(x)).collect();
        right.extend(quadratic.into_iter().map(|x| a.neg(x)));
        for i in 0..joints {
            matrix[i * size..i * size + joints].copy_from_slice(&mass[i * joints..][..joints]);
            for row in 0..rows {
                matrix[(joints + row) * size + i] = jacobian[row * joints + i];
                matrix[i * size + joints + row] = jacobian[row * joints + i];
            }
        }
        if self.rate != 0.0 {
            let open = array(&bench.position, "h", rows);
            let [twice, square] = [2.0 * self.rate, self.rate * self.rate].map(|x| a.literal(x));
            for row in 0..rows {
                let rate = moving(a, &jacobian[row * joints..][..joints], &state.qd);
                let back = a.add(a.mul(twice, rate), a.mul(square, open[row]));
                right[joints + row] = a.sub(right[joints + row], back);
            }
        }
        let mut slope = state.qd.clone();
        match eliminate(a, size, matrix, right) {
            Some(found) => slope.extend(found[..joints].iter().map(|x| x.wide().high)),
            None => slope.extend(vec![f64::NAN; joints]),
        }
        slope
    }
}

impl Work for LoopCorrection<'_> {
    type Result = Vec<f64>;

    fn run<A: Arithmetic<Number: Wide>>(self, a: &A) -> Vec<f64> {
        let (bench, state) = (self.bench, self.state);
        let (joints, rows) = (state.q.len(), bench.rows);
        let array = |name, length| DriftBench::array(a, &bench.position, state, (name, length));
        let jacobian = array("Jac", rows * joints);
        let open = if self.velocities {
            (0..rows)
                .map(|row| moving(a, &jacobian[row * joints..][..joints], &state.qd))
                .collect()
        } else {
            array("h", rows)
        };
        // J J' x = what is open, and -J' x is the change.
        let of_row = |row: usize| &jacobian[row * joints..][..joints];
        let entry = |place: usize| product(a, of_row(place / rows), of_row(place % rows));
        let matrix = (0..rows * rows).map(entry).collect();
        let Some(parts) = eliminate(a, rows, matrix, open) else {
            return vec![f64::NAN; joints];
        };
        let change = |joint: usize| {
            let column: Vec<A::Number> = (0..rows).map(|row| of_row(row)[joint]).collect();
            -product(a, &column, &parts).wide().high
        };
        (0..joints).map(change).collect()
    }
}

fn product<A: Arithmetic>(a: &A, x: &[A::Number], y: &[A::Number]) -> A::Number {
    debug_assert_eq!(x.len(), y.len(), "vectors of one length");
    let pairs = x.iter().zip(y);
    pairs.fold(a.literal(0.0), |sum, (&x, &y)| a.add(sum, a.mul(x, y)))
}

/// Velocity at which a row of the loops opens.
fn moving<A: Arithmetic>(a: &A, row: &[A::Number], velocities: &[f64]) -> A::Number {
    let velocities: Vec<A::Number> = velocities.iter().map(|&x| a.literal(x)).collect();
    product(a, row, &velocities)
}

/// Operations of an elimination with one right-hand side, half of them sums.
fn elimination(size: usize) -> OperationWork {
    let size = size as f64;
    let half = size.powi(3) / 3.0 + size * size;
    OperationWork::new(half, half)
}

impl StressBench for DriftBench<'_> {
    /// Of a motion there is no one number.
    fn condition(&self) -> f64 {
        f64::NAN
    }

    /// Gap that rounding the state once to the format opens.
    fn floor(&self, format: Format) -> f64 {
        format.unit_roundoff()
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let joints = self.subject.model.joints.len();
        let rows = self.rows;
        let mut slope = self.dynamics.work + self.position.work + self.acceleration.work;
        slope = slope + elimination(joints + rows);
        let mut after = OperationWork::default();
        let pairs = (rows * joints) as f64;
        match treatment.stabilisation {
            LoopStabilisation::None => {}
            LoopStabilisation::Baumgarte => {
                let ends = 2.0 * rows as f64;
                slope = slope + OperationWork::new(pairs + ends, pairs + ends);
            }
            LoopStabilisation::Projection => {
                // J J', its elimination, J' x, and J qd for the velocities.
                let times = f64::from(CORRECTIONS) + 1.0;
                let products = pairs * (rows as f64 + 1.0);
                let once = self.position.work
                    + elimination(rows)
                    + OperationWork::new(products, products + joints as f64);
                after = once * times + OperationWork::new(pairs, pairs);
            }
        }
        let computed = (slope * 4.0 + after).cost(treatment.format);
        let kept = treatment.state_format();
        let change = change_work(2 * joints, treatment.compensated).cost(kept);
        let (_, steps) = self.subject.step_of(treatment);
        Ok(Measured {
            error: self.error(treatment),
            others: Vec::new(),
            outside: 0.0,
            consistent: true,
            cost: steps as f64 * (computed + change),
        })
    }
}
