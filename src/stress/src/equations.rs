//! Equations as text with given inputs.

use super::case::{Measured, Memo, StressBench, StressSubject};
use super::dynamics::{componentwise, normwise, sensitivity, worst};
use super::forms::{TextForm, TextForms};
use super::numbers::{Evaluation, WorkingPrecision};
use super::program::{evaluate_mixture, is_normal, largest, shared, text_program};
use super::treatment::PASSES;
use super::{ProgramTreatment, StressError};
use robovec_ir::cost::function_cost;
use robovec_ir::evaluate::evaluate_nodes;
use robovec_ir::{Format, Module};
use robovec_num::arithmetic::Binary64;
use robovec_num::double_double::Double;
use std::sync::Arc;

/// Equations, and the sets of inputs they are evaluated for.
pub(super) struct EquationsSubject {
    forms: TextForms<Vec<Vec<f64>>>,
    /// Result that they compute.
    result: &'static str,
}

impl EquationsSubject {
    /// Equations with inputs of binary32.
    pub(super) fn new(text: impl Into<String>, inputs: Vec<Vec<f64>>) -> EquationsSubject {
        let share = |inputs: Vec<f64>| inputs.into_iter().map(shared).collect();
        EquationsSubject::of_host(text, inputs.into_iter().map(share).collect())
    }

    /// Equations with binary64 inputs, whose rounding is part of the error.
    pub(super) fn of_host(text: impl Into<String>, inputs: Vec<Vec<f64>>) -> EquationsSubject {
        EquationsSubject {
            forms: TextForms::new(text, inputs),
            result: "sum",
        }
    }

    /// The same with a name for the computed result.
    pub(super) fn of(mut self, result: &'static str) -> EquationsSubject {
        self.result = result;
        self
    }

    /// The same with another form of the equations, for the same inputs.
    pub(super) fn or(mut self, name: &'static str, text: &str) -> EquationsSubject {
        let inputs = self.forms.plain.numbers.clone();
        self.forms.push(TextForm::given(name, text, inputs));
        self
    }

    /// The same with the equations in inputs that the host prepares.
    pub(super) fn or_prepared(
        mut self,
        name: &'static str,
        text: &str,
        inputs: Vec<Vec<f64>>,
    ) -> EquationsSubject {
        self.forms.push(TextForm::prepared(name, text, inputs));
        self
    }

    /// Every list of passes over the forms that are chosen.
    fn treatments(&self, prepared: bool) -> Vec<ProgramTreatment> {
        self.forms.treatments(prepared, &PASSES, &self.untreated())
    }
}

struct EquationsBench<'a> {
    subject: &'a EquationsSubject,
    exact: Vec<Vec<Double>>,
    modules: Memo<ProgramTreatment, Arc<Module>>,
}

impl StressSubject for EquationsSubject {
    fn metric(&self) -> &'static str {
        self.result
    }

    fn programs(&self) -> Vec<ProgramTreatment> {
        self.treatments(false)
    }

    fn candidates(&self) -> Vec<ProgramTreatment> {
        self.treatments(true)
    }

    fn is_small(&self) -> bool {
        true
    }

    fn mixes(&self) -> bool {
        true
    }

    fn prepare(&self) -> Result<Box<dyn StressBench + '_>, StressError> {
        let mut bench = EquationsBench {
            subject: self,
            exact: Vec::new(),
            modules: Memo::default(),
        };
        let module = bench.module(&ProgramTreatment::default())?;
        let inputs = self.forms.plain.numbers.iter();
        let exact = inputs.map(|inputs| evaluate(&module, WorkingPrecision::Reference, inputs));
        bench.exact = exact.collect();
        Ok(Box::new(bench))
    }
}

fn evaluate(module: &Module, numbers: WorkingPrecision, inputs: &[f64]) -> Vec<Double> {
    let function = &module.functions[0];
    numbers.work(Evaluation { function, inputs })
}

impl EquationsBench<'_> {
    /// The program for a treatment, made once for all formats.
    fn module(&self, treatment: &ProgramTreatment) -> Result<Arc<Module>, StressError> {
        self.modules.get(treatment.in_binary32(), || {
            let form = self.subject.forms.named(treatment.form)?;
            text_program(&form.text, treatment, &form.numbers).map(Arc::new)
        })
    }
}

impl StressBench for EquationsBench<'_> {
    fn floor(&self, format: Format) -> f64 {
        const DRAWS: u64 = 8;
        let Ok(module) = self.module(&ProgramTreatment::default()) else {
            return f64::NAN;
        };
        assert_eq!(
            self.exact.len(),
            self.subject.forms.plain.numbers.len(),
            "every case has exact results"
        );
        let cases = self.subject.forms.plain.numbers.iter().zip(&self.exact);
        worst(cases.map(|(inputs, exact)| {
            sensitivity(format.unit_roundoff(), DRAWS, inputs, |inputs| {
                let found = evaluate(&module, WorkingPrecision::Reference, inputs);
                componentwise(&found, exact)
            })
        }))
    }

    fn largest(&self, treatment: &ProgramTreatment) -> Option<f64> {
        let module = self.module(treatment).ok()?;
        let form = self.subject.forms.named(treatment.form).ok()?;
        Some(largest(&module.functions[0], &form.numbers))
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let module = self.module(treatment)?;
        let function = &module.functions[0];
        let form = self.subject.forms.named(treatment.form)?;
        let (mut outside, mut all) = (0u32, 0u32);
        let (mut worst_component, mut worst_norm) = (0.0, 0.0);
        assert_eq!(
            form.numbers.len(),
            self.exact.len(),
            "every form has the same cases"
        );
        for (inputs, exact) in form.numbers.iter().zip(&self.exact) {
            let found = match function.formats {
                None => evaluate(&module, WorkingPrecision::In(treatment.format), inputs),
                Some(_) => evaluate_mixture(function, inputs),
            };
            let errors = [worst_component, componentwise(&found, exact)];
            worst_component = worst(errors.into_iter());
            worst_norm = worst([worst_norm, normwise(&found, exact)].into_iter());
            let values = evaluate_nodes(function, &Binary64, inputs);
            for number in inputs.iter().chain(&values).filter(|x| **x != 0.0) {
                all += 1;
                outside += u32::from(!is_normal(*number, treatment.format));
            }
        }
        Ok(Measured {
            error: worst_component,
            others: vec![("normwise", worst_norm)],
            outside: f64::from(outside) / f64::from(all.max(1)),
            consistent: true,
            cost: function_cost(function, treatment.format),
        })
    }
}
