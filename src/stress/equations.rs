//! Equations as text with given inputs.

use super::case::{Measured, StressBench, StressSubject};
use super::dynamics::{componentwise, normwise, perturb, worst};
use super::numbers::{Evaluation, WorkingPrecision};
use super::program::{evaluate_mixture, function_cost, is_normal, shared, text_program};
use super::treatment::PASSES;
use super::{ProgramTreatment, StressError};
use robovec_ir::evaluate::evaluate_nodes;
use robovec_ir::{Format, Module};
use robovec_num::arithmetic::Binary64;
use robovec_num::double_double::Double;
use std::sync::{Arc, Mutex};

/// Equations, and the inputs they are evaluated for.
pub(super) struct EquationsSubject {
    /// The equations that the case is about.
    plain: EquationsForm,
    /// Other ways to write them.
    forms: Vec<EquationsForm>,
    /// What they compute.
    result: &'static str,
}

/// One way to write equations.
struct EquationsForm {
    /// Its name; empty for the case itself.
    name: &'static str,
    /// A module of one function in the text form.
    text: String,
    /// Sets of inputs.
    inputs: Vec<Vec<f64>>,
    /// True when the inputs are others than those of the case: what the host
    /// made of its own numbers.
    prepared: bool,
}

impl EquationsSubject {
    /// Equations with inputs that binary32 holds.
    pub(super) fn new(text: String, inputs: Vec<Vec<f64>>) -> EquationsSubject {
        let share = |inputs: Vec<f64>| inputs.into_iter().map(shared).collect();
        EquationsSubject::of_host(text, inputs.into_iter().map(share).collect())
    }

    /// Equations with inputs that the host has in binary64: rounding them to
    /// a format is part of the error.
    pub(super) fn of_host(text: String, inputs: Vec<Vec<f64>>) -> EquationsSubject {
        EquationsSubject {
            plain: EquationsForm {
                name: "",
                text,
                inputs,
                prepared: false,
            },
            forms: Vec::new(),
            result: "sum",
        }
    }

    /// The same with a name for what is computed.
    pub(super) fn of(mut self, result: &'static str) -> EquationsSubject {
        self.result = result;
        self
    }

    /// The same with another way to write the equations, for the same inputs.
    pub(super) fn or(mut self, name: &'static str, text: String) -> EquationsSubject {
        self.forms.push(EquationsForm {
            name,
            text,
            inputs: self.plain.inputs.clone(),
            prepared: false,
        });
        self
    }

    /// The same with the equations in inputs that the host prepares.
    pub(super) fn or_prepared(
        mut self,
        name: &'static str,
        text: String,
        inputs: Vec<Vec<f64>>,
    ) -> EquationsSubject {
        self.forms.push(EquationsForm {
            name,
            text,
            inputs,
            prepared: true,
        });
        self
    }

    fn form(&self, name: &str) -> Result<&EquationsForm, StressError> {
        let mut forms = std::iter::once(&self.plain).chain(&self.forms);
        let found = forms.find(|form| form.name == name);
        found.ok_or_else(|| StressError::Passes(format!("there is no form '{name}'")))
    }

    /// Every list of passes over the forms that are chosen.
    fn treatments(&self, prepared: bool) -> Vec<ProgramTreatment> {
        let forms = std::iter::once(&self.plain).chain(&self.forms);
        let forms = forms.filter(|form| form.prepared == prepared);
        let treatments = forms.flat_map(|form| {
            PASSES.map(|passes| ProgramTreatment {
                passes,
                form: form.name,
                ..ProgramTreatment::default()
            })
        });
        treatments.collect()
    }
}

impl EquationsForm {
    fn module(&self, treatment: &ProgramTreatment) -> Result<Module, StressError> {
        text_program(&self.text, treatment, &self.inputs)
    }
}

struct EquationsBench<'a> {
    subject: &'a EquationsSubject,
    exact: Vec<Vec<Double>>,
    /// What was made, by the treatment that makes it in binary32: formats are
    /// tried one after the other.
    modules: Mutex<Vec<(ProgramTreatment, Arc<Module>)>>,
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
            modules: Mutex::default(),
        };
        let module = bench.module(&ProgramTreatment::default())?;
        let inputs = self.plain.inputs.iter();
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
        let key = ProgramTreatment {
            format: Format::BINARY32,
            ..treatment.clone()
        };
        // A thread that panicked left nothing half done here.
        let mut modules = self
            .modules
            .lock()
            .unwrap_or_else(|error| error.into_inner());
        if let Some((_, module)) = modules.iter().find(|(known, _)| *known == key) {
            return Ok(module.clone());
        }
        let module = Arc::new(self.subject.form(treatment.form)?.module(treatment)?);
        modules.push((key, module.clone()));
        Ok(module)
    }
}

impl StressBench for EquationsBench<'_> {
    fn condition(&self) -> f64 {
        let format = Format::BINARY32;
        self.floor(format) / format.unit_roundoff()
    }

    fn floor(&self, format: Format) -> f64 {
        const DRAWS: u64 = 8;
        let amount = format.unit_roundoff();
        let step = amount.max(2f64.powi(-30));
        let Ok(module) = self.module(&ProgramTreatment::default()) else {
            return f64::NAN;
        };
        let cases = self.subject.plain.inputs.iter().zip(&self.exact);
        let moved = cases.flat_map(|(inputs, exact)| {
            let module = &module;
            (0..DRAWS).map(move |draw| {
                let inputs = perturb(inputs, step, draw);
                let found = evaluate(module, WorkingPrecision::Reference, &inputs);
                componentwise(&found, exact)
            })
        });
        worst(moved) * amount / step
    }

    fn largest(&self, treatment: &ProgramTreatment) -> Option<f64> {
        let module = self.module(treatment).ok()?;
        let form = self.subject.form(treatment.form).ok()?;
        let values = form.inputs.iter().flat_map(|inputs| {
            let mut values = evaluate_nodes(&module.functions[0], &Binary64, inputs);
            values.extend(inputs);
            values
        });
        Some(values.fold(0.0, |most: f64, number| most.max(number.abs())))
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let module = self.module(treatment)?;
        let function = &module.functions[0];
        let form = self.subject.form(treatment.form)?;
        let (mut outside, mut all) = (0u32, 0u32);
        let (mut worst_component, mut worst_norm) = (0.0, 0.0);
        for (inputs, exact) in form.inputs.iter().zip(&self.exact) {
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
