//! Differential equations as text, integrated step after step.
//!
//! The reference takes the same steps in double-double numbers, so that only
//! rounding errors remain, without the error of the method.

use super::case::{Measured, Memo, StressBench, StressSubject};
use super::dynamics::{sensitivity, worst};
use super::forms::{TextForm, TextForms};
use super::numbers::{Wide, Work, WorkingPrecision};
use super::program::{largest, shared, text_program};
use super::treatment::PASSES;
use super::{ProgramTreatment, StressError};
use robovec_dynamics::motion::integrate::{IntegratedState, TimeStep, change_work};
use robovec_ir::cost::function_cost;
use robovec_ir::evaluate::{evaluate, evaluate_mixed};
use robovec_ir::{Format, Function, Module};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::Double;
use std::sync::Arc;

/// Differential equations with their start: functions of a state array and a
/// parameter array, which give the state's slopes, then monitored numbers.
pub(super) struct StepsSubject {
    forms: TextForms<MotionStart>,
    /// s.
    step: f64,
    steps: u64,
}

#[derive(Clone)]
pub(super) struct MotionStart {
    pub(super) state: Vec<f64>,
    pub(super) parameters: Vec<f64>,
}

impl MotionStart {
    /// Inputs of the function: the state, then the parameters.
    fn inputs(&self) -> Vec<f64> {
        [&self.state[..], &self.parameters].concat()
    }
}

/// Number of samples of the watched numbers.
const SAMPLES: u64 = 50;

impl StepsSubject {
    /// The motion of the equations, in this number of steps (s).
    pub(super) fn new(
        text: &str,
        mut start: MotionStart,
        (step, steps): (f64, u64),
    ) -> StepsSubject {
        for numbers in [&mut start.state, &mut start.parameters] {
            numbers.iter_mut().for_each(|x| *x = shared(*x));
        }
        StepsSubject {
            forms: TextForms::new(text, start),
            step,
            steps,
        }
    }

    /// The same with another form, of the same parameters and its own start.
    pub(super) fn or(mut self, mut form: TextForm<MotionStart>) -> StepsSubject {
        let parameters = form.numbers.parameters.iter_mut();
        parameters.for_each(|x| *x = shared(*x));
        self.forms.push(form);
        self
    }

    /// The selected forms, each unchanged, balanced, and with accurate sums.
    fn treatments(&self, prepared: bool) -> Vec<ProgramTreatment> {
        let passes = [PASSES[0], PASSES[1], PASSES[6]];
        self.forms.treatments(prepared, &passes, &self.untreated())
    }
}

struct StepsBench<'a> {
    subject: &'a StepsSubject,
    /// Watched numbers, and the state, sample after sample.
    exact: Vec<Vec<Double>>,
    modules: Memo<ProgramTreatment, Arc<Module>>,
}

impl StressSubject for StepsSubject {
    fn metric(&self) -> &'static str {
        "force in time"
    }

    fn untreated(&self) -> ProgramTreatment {
        ProgramTreatment::default().with(|it| it.step = Some(self.step))
    }

    fn programs(&self) -> Vec<ProgramTreatment> {
        self.treatments(false)
    }

    fn candidates(&self) -> Vec<ProgramTreatment> {
        let mut list = self.treatments(true);
        for form in self.forms.all() {
            let plain = self.untreated().with(|it| it.form = form.name);
            list.push(plain.with(|it| it.compensated = true));
            list.push(plain.with(|it| it.state = Some(Format::BINARY64)));
        }
        list
    }

    fn is_small(&self) -> bool {
        true
    }

    fn mixes(&self) -> bool {
        true
    }

    fn prepare(&self) -> Result<Box<dyn StressBench + '_>, StressError> {
        let mut bench = StepsBench {
            subject: self,
            exact: Vec::new(),
            modules: Memo::default(),
        };
        bench.exact = bench.exactly(&self.forms.plain.numbers.inputs())?;
        Ok(Box::new(bench))
    }
}

/// A function integrated over time steps from one state.
struct FormRun<'a> {
    function: &'a Function,
    /// The state at the start, then the parameters.
    numbers: &'a [f64],
    states: usize,
    how: TimeStep,
    steps: u64,
    /// Format of the state, if it differs from that of the slopes.
    state: Option<Format>,
}

/// The slopes of a state, and the monitored numbers.
type SlopesAndWatched<N> = [Vec<N>; 2];

/// The same, for any format of its state.
struct KeptRun<'a, A> {
    run: FormRun<'a>,
    slopes: &'a A,
}

impl FormRun<'_> {
    /// Integrates with a function that gives slopes and watched numbers.
    fn integrate<A: Arithmetic<Number: Wide>>(
        &self,
        a: &A,
        evaluate: impl Fn(&[A::Number]) -> SlopesAndWatched<A::Number>,
    ) -> Vec<Vec<Double>> {
        let mut state = IntegratedState::new(a, &self.numbers[..self.states]);
        let mut seen = Vec::new();
        let mut done = 0;
        for sample in 0..=SAMPLES {
            while done < self.steps * sample / SAMPLES {
                state.step(a, self.how, &mut |numbers| {
                    let [slopes, _] = evaluate(numbers);
                    slopes
                });
                done += 1;
            }
            let [_, watched] = evaluate(&state.numbers);
            let numbers = watched.iter().chain(&state.numbers);
            seen.push(numbers.map(|number| number.wide()).collect());
        }
        seen
    }

    /// The flattened outputs for a state, slopes first.
    fn outputs<A: Arithmetic<Number: Wide>>(
        &self,
        a: &A,
        state: &[A::Number],
    ) -> SlopesAndWatched<A::Number> {
        let parameters = &self.numbers[self.states..];
        let found = if self.function.formats.is_some() {
            let mut inputs: Vec<f64> = state.iter().map(|number| number.wide().high).collect();
            inputs.extend(parameters);
            let found = evaluate_mixed(self.function, Format::BINARY64, &inputs);
            found.into_iter().map(|number| a.literal(number)).collect()
        } else {
            let mut inputs = state.to_vec();
            inputs.extend(parameters.iter().map(|&number| a.literal(number)));
            evaluate(self.function, a, &inputs)
        };
        let mut slopes = vec![a.literal(0.0); self.function.output_len()];
        for (assignment, number) in self.function.assignments.iter().zip(found) {
            slopes[assignment.output.index()] = number;
        }
        let watched = slopes.split_off(self.states);
        [slopes, watched]
    }
}

impl Work for FormRun<'_> {
    type Result = Vec<Vec<Double>>;

    fn run<A: Arithmetic<Number: Wide>>(self, slopes: &A) -> Self::Result {
        match self.state {
            None => self.integrate(slopes, |state| self.outputs(slopes, state)),
            Some(format) => WorkingPrecision::In(format).work(KeptRun { run: self, slopes }),
        }
    }
}

impl<A: Arithmetic<Number: Wide>> Work for KeptRun<'_, A> {
    type Result = Vec<Vec<Double>>;

    fn run<S: Arithmetic<Number: Wide>>(self, kept: &S) -> Self::Result {
        // Formats hold binary64 numbers, so that the high part is all.
        self.run.integrate(kept, |state: &[S::Number]| {
            let narrow = |number: &S::Number| self.slopes.literal(number.wide().high);
            let state: Vec<A::Number> = state.iter().map(narrow).collect();
            let widened = |numbers: Vec<A::Number>| {
                let wide = |number: A::Number| kept.literal(number.wide().high);
                numbers.into_iter().map(wide).collect()
            };
            self.run.outputs(self.slopes, &state).map(widened)
        })
    }
}

impl StepsBench<'_> {
    fn module(&self, treatment: &ProgramTreatment) -> Result<Arc<Module>, StressError> {
        let key = ProgramTreatment {
            form: treatment.form,
            passes: treatment.passes,
            mixed: treatment.mixed,
            ..ProgramTreatment::default()
        };
        self.modules.get(key, || {
            let form = self.subject.forms.named(treatment.form)?;
            // Only formats of values depend on states.
            let states = match treatment.mixed {
                Some(_) => self.visited(treatment.form)?,
                None => vec![form.numbers.inputs()],
            };
            text_program(&form.text, treatment, &states).map(Arc::new)
        })
    }

    /// The inputs of a form along its run in binary64.
    fn visited(&self, name: &'static str) -> Result<Vec<Vec<f64>>, StressError> {
        let form = self.subject.forms.named(name)?;
        let treatment = self.subject.untreated().with(|it| it.form = name);
        let numbers = form.numbers.inputs();
        let run = self.run(&treatment, &numbers, WorkingPrecision::In(Format::BINARY64))?;
        let inputs = run.iter().map(|sample| {
            let state = &sample[self.watched()..];
            let state = state.iter().map(|number| number.high);
            state
                .chain(form.numbers.parameters.iter().copied())
                .collect()
        });
        Ok(inputs.collect())
    }

    fn watched(&self) -> usize {
        let all = self
            .exact
            .first()
            .expect("the reference was computed")
            .len();
        all - self.subject.forms.plain.numbers.state.len()
    }

    fn run(
        &self,
        treatment: &ProgramTreatment,
        numbers: &[f64],
        precision: WorkingPrecision,
    ) -> Result<Vec<Vec<Double>>, StressError> {
        let module = self.module(treatment)?;
        let form = self.subject.forms.named(treatment.form)?;
        Ok(precision.work(FormRun {
            function: &module.functions[0],
            numbers,
            states: form.numbers.state.len(),
            how: TimeStep {
                step: self.subject.step,
                compensated: treatment.compensated,
            },
            steps: self.subject.steps,
            state: treatment.state,
        }))
    }

    fn exactly(&self, numbers: &[f64]) -> Result<Vec<Vec<Double>>, StressError> {
        let untreated = self.subject.untreated();
        self.run(&untreated, numbers, WorkingPrecision::Reference)
    }

    /// Largest distance from the reference, relative to each number's size.
    fn distance(&self, found: &[Vec<Double>]) -> f64 {
        assert_eq!(
            found.len(),
            self.exact.len(),
            "every run has the same samples"
        );
        worst((0..self.watched()).map(|place| {
            let sizes = self.exact.iter().map(|sample| sample[place].high.abs());
            let size = worst(sizes);
            let pairs = found.iter().zip(&self.exact);
            let errors = pairs.map(|(found, exact)| (found[place] - exact[place]).high.abs());
            worst(errors) / size
        }))
    }
}

impl StressBench for StepsBench<'_> {
    /// Effect of moving the start and the parameters once on the run.
    fn floor(&self, format: Format) -> f64 {
        const DRAWS: u64 = 3;
        let numbers = self.subject.forms.plain.numbers.inputs();
        sensitivity(format.unit_roundoff(), DRAWS, &numbers, |numbers| {
            self.exactly(numbers)
                .map_or(f64::NAN, |found| self.distance(&found))
        })
    }

    fn largest(&self, treatment: &ProgramTreatment) -> Option<f64> {
        let module = self.module(treatment).ok()?;
        let visited = self.visited(treatment.form).ok()?;
        Some(largest(&module.functions[0], &visited))
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let form = self.subject.forms.named(treatment.form)?;
        let numbers = form.numbers.inputs();
        let precision = WorkingPrecision::In(treatment.format);
        let found = self.run(treatment, &numbers, precision)?;
        let module = self.module(treatment)?;
        let steps = self.subject.steps as f64;
        let slopes = 4.0 * function_cost(&module.functions[0], treatment.format);
        let state = treatment.state_format();
        let change = change_work(form.numbers.state.len(), treatment.compensated).cost(state);
        Ok(Measured {
            error: self.distance(&found),
            others: Vec::new(),
            outside: 0.0,
            consistent: true,
            cost: steps * (slopes + change),
        })
    }
}
