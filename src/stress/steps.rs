//! Differential equations as text, integrated step after step.
//!
//! The reference takes the same steps in double-double numbers, so that what
//! shows is rounding alone and not what the method leaves out.

use super::case::{Measured, StressBench, StressSubject};
use super::dynamics::{perturb, worst};
use super::numbers::{Wide, Work, WorkingPrecision};
use super::program::{function_cost, shared, text_program};
use super::runge_kutta::{IntegratedState, TimeStep};
use super::treatment::PASSES;
use super::{ProgramTreatment, StressError};
use robovec_ir::cost::OperationWork;
use robovec_ir::evaluate::{evaluate, evaluate_mixed, evaluate_nodes};
use robovec_ir::{Format, Function, Module};
use robovec_num::arithmetic::{Arithmetic, Binary64};
use robovec_num::double_double::Double;
use std::sync::{Arc, Mutex};

/// Differential equations with their start.
pub(super) struct StepsSubject {
    /// The equations that the case is about.
    plain: MotionForm,
    /// The same motion in other coordinates.
    forms: Vec<MotionForm>,
    /// s.
    step: f64,
    steps: u64,
}

/// One way to write the differential equations: a function of one array of
/// state numbers and one of parameters, which gives the slopes of the state
/// and then what is watched.
pub(super) struct MotionForm {
    /// Its name; empty for the case itself.
    pub(super) name: &'static str,
    /// A module of one function in the text form.
    pub(super) text: String,
    /// The state at the start.
    pub(super) start: Vec<f64>,
    pub(super) parameters: Vec<f64>,
    /// True when the state is another one than that of the case: what the
    /// host made of its own numbers.
    pub(super) prepared: bool,
}

/// How often the watched numbers are looked at.
const SAMPLES: u64 = 50;

impl StepsSubject {
    /// The motion of a form, in so many steps (s).
    pub(super) fn new(mut plain: MotionForm, (step, steps): (f64, u64)) -> StepsSubject {
        for numbers in [&mut plain.start, &mut plain.parameters] {
            numbers.iter_mut().for_each(|x| *x = shared(*x));
        }
        StepsSubject {
            plain,
            forms: Vec::new(),
            step,
            steps,
        }
    }

    /// The same with another form; its parameters are shared, its start is
    /// the host's.
    pub(super) fn or(mut self, mut form: MotionForm) -> StepsSubject {
        form.parameters.iter_mut().for_each(|x| *x = shared(*x));
        self.forms.push(form);
        self
    }

    fn form(&self, name: &str) -> Result<&MotionForm, StressError> {
        let mut forms = std::iter::once(&self.plain).chain(&self.forms);
        let found = forms.find(|form| form.name == name);
        found.ok_or_else(|| StressError::Passes(format!("there is no form '{name}'")))
    }

    /// The forms that are chosen, as they come and with what compensates.
    fn treatments(&self, prepared: bool) -> Vec<ProgramTreatment> {
        let forms = std::iter::once(&self.plain).chain(&self.forms);
        let forms = forms.filter(|form| form.prepared == prepared);
        let treatments = forms.flat_map(|form| {
            [PASSES[0], PASSES[1], PASSES[6]].map(|passes| ProgramTreatment {
                passes,
                form: form.name,
                ..self.untreated()
            })
        });
        treatments.collect()
    }
}

struct StepsBench<'a> {
    subject: &'a StepsSubject,
    /// What is watched, and the state, sample after sample.
    exact: Vec<Vec<Double>>,
    /// What was made, by the treatment that makes it in binary32: formats are
    /// tried one after the other.
    modules: Mutex<Vec<(ProgramTreatment, Arc<Module>)>>,
}

impl StressSubject for StepsSubject {
    fn metric(&self) -> &'static str {
        "force in time"
    }

    fn untreated(&self) -> ProgramTreatment {
        ProgramTreatment {
            step: Some(self.step),
            ..ProgramTreatment::default()
        }
    }

    fn programs(&self) -> Vec<ProgramTreatment> {
        self.treatments(false)
    }

    fn candidates(&self) -> Vec<ProgramTreatment> {
        let mut list = self.treatments(true);
        for form in std::iter::once(&self.plain).chain(&self.forms) {
            let plain = ProgramTreatment {
                form: form.name,
                ..self.untreated()
            };
            list.push(ProgramTreatment {
                compensated: true,
                ..plain.clone()
            });
            list.push(ProgramTreatment {
                state: Some(Format::BINARY64),
                ..plain
            });
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
            modules: Mutex::default(),
        };
        let start = [&self.plain.start[..], &self.plain.parameters].concat();
        bench.exact = bench.exactly(&start)?;
        Ok(Box::new(bench))
    }
}

/// A run: what is watched at its samples, with the state behind.
struct FormRun<'a> {
    function: &'a Function,
    /// The state at the start, then the parameters.
    numbers: &'a [f64],
    states: usize,
    how: TimeStep,
    steps: u64,
    /// What the state is kept in, where that is not what slopes are computed
    /// in.
    state: Option<Format>,
}

/// The slopes of a state, and what is watched.
type SlopesAndWatched<N> = [Vec<N>; 2];

/// The same, for whatever its state is kept in.
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
        // A thread that panicked left nothing half done here.
        let lock = || {
            self.modules
                .lock()
                .unwrap_or_else(|error| error.into_inner())
        };
        if let Some((_, module)) = lock().iter().find(|(known, _)| *known == key) {
            return Ok(module.clone());
        }
        let form = self.subject.form(treatment.form)?;
        // Only formats of values depend on states.
        let states = match treatment.mixed {
            Some(_) => self.visited(treatment.form)?,
            None => vec![[&form.start[..], &form.parameters].concat()],
        };
        let module = Arc::new(text_program(&form.text, treatment, &states)?);
        lock().push((key, module.clone()));
        Ok(module)
    }

    /// The inputs of a form along its run in binary64.
    fn visited(&self, name: &'static str) -> Result<Vec<Vec<f64>>, StressError> {
        let form = self.subject.form(name)?;
        let treatment = ProgramTreatment {
            form: name,
            ..self.subject.untreated()
        };
        let numbers = [&form.start[..], &form.parameters].concat();
        let run = self.run(&treatment, &numbers, WorkingPrecision::In(Format::BINARY64))?;
        let inputs = run.iter().map(|sample| {
            let state = &sample[self.watched()..];
            let state = state.iter().map(|number| number.high);
            state.chain(form.parameters.iter().copied()).collect()
        });
        Ok(inputs.collect())
    }

    /// How many numbers are watched.
    fn watched(&self) -> usize {
        let all = self.exact.first().map_or(0, Vec::len);
        all - self.subject.plain.start.len()
    }

    /// The run of a treatment from given numbers.
    fn run(
        &self,
        treatment: &ProgramTreatment,
        numbers: &[f64],
        precision: WorkingPrecision,
    ) -> Result<Vec<Vec<Double>>, StressError> {
        let module = self.module(treatment)?;
        let form = self.subject.form(treatment.form)?;
        Ok(precision.work(FormRun {
            function: &module.functions[0],
            numbers,
            states: form.start.len(),
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

    /// The largest distance from the reference, every watched number relative
    /// to its largest size in the run.
    fn distance(&self, found: &[Vec<Double>]) -> f64 {
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
    fn condition(&self) -> f64 {
        let format = Format::BINARY32;
        self.floor(format) / format.unit_roundoff()
    }

    /// What moving the start and the parameters once does to the run.
    fn floor(&self, format: Format) -> f64 {
        const DRAWS: u64 = 3;
        let amount = format.unit_roundoff();
        let step = amount.max(2f64.powi(-30));
        let form = &self.subject.plain;
        let numbers = [&form.start[..], &form.parameters].concat();
        let moved = (0..DRAWS).map(|draw| {
            let numbers = perturb(&numbers, step, draw);
            self.exactly(&numbers)
                .map_or(f64::NAN, |found| self.distance(&found))
        });
        worst(moved) * amount / step
    }

    fn largest(&self, treatment: &ProgramTreatment) -> Option<f64> {
        let module = self.module(treatment).ok()?;
        let visited = self.visited(treatment.form).ok()?;
        let values = visited.into_iter().flat_map(|inputs| {
            let mut values = evaluate_nodes(&module.functions[0], &Binary64, &inputs);
            values.extend(inputs);
            values
        });
        Some(values.fold(0.0, |most: f64, number| most.max(number.abs())))
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let form = self.subject.form(treatment.form)?;
        let numbers = [&form.start[..], &form.parameters].concat();
        let precision = WorkingPrecision::In(treatment.format);
        let found = self.run(treatment, &numbers, precision)?;
        let module = self.module(treatment)?;
        let steps = self.subject.steps as f64;
        let slopes = 4.0 * function_cost(&module.functions[0], treatment.format);
        let state = treatment.state.unwrap_or(treatment.format);
        let change = change_work(form.start.len(), treatment.compensated).cost(state);
        Ok(Measured {
            error: self.distance(&found),
            others: Vec::new(),
            outside: 0.0,
            consistent: true,
            cost: steps * (slopes + change),
        })
    }
}

/// The operations of one step of Runge-Kutta besides its slopes: four stages
/// of a product and a sum, four more sums and two products for the change;
/// three sums more to compensate.
pub(super) fn change_work(numbers: usize, compensated: bool) -> OperationWork {
    let sums = if compensated { 11.0 } else { 8.0 };
    OperationWork::new(6.0, sums) * numbers as f64
}
