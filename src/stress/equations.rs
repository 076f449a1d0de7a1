//! Equations as text with given inputs.

use super::case::{Measured, StressBench, StressSubject};
use super::dynamics::{componentwise, normwise, perturb, worst};
use super::numbers::{Evaluation, WorkingPrecision};
use super::program::{is_normal, run_passes, shared};
use super::treatment::PASSES;
use super::{ProgramTreatment, StressError};
use robovec_framework::scene::Scene;
use robovec_ir::cost::OperationWork;
use robovec_ir::evaluate::evaluate_nodes;
use robovec_ir::parse::parse_module;
use robovec_ir::states::Ranges;
use robovec_ir::{Format, Input, Module};
use robovec_num::arithmetic::Binary64;
use robovec_num::double_double::Double;

/// Equations, and the inputs they are evaluated for.
pub(super) struct EquationsSubject {
    /// A module of one function in the text form.
    pub(super) text: String,
    /// Sets of inputs.
    pub(super) inputs: Vec<Vec<f64>>,
}

impl EquationsSubject {
    pub(super) fn new(text: String, inputs: Vec<Vec<f64>>) -> EquationsSubject {
        let share = |inputs: Vec<f64>| inputs.into_iter().map(shared).collect();
        EquationsSubject {
            text,
            inputs: inputs.into_iter().map(share).collect(),
        }
    }

    fn module(&self, passes: &str) -> Result<Module, StressError> {
        let mut module = parse_module("case", &self.text)
            .map_err(|report| StressError::Passes(format!("{report:?}")))?;
        if !passes.is_empty() {
            let scene = self.scene(&module);
            run_passes(&mut module, passes, Some(&scene))?;
        }
        Ok(module)
    }

    /// What the inputs can be: a pass that looks at states sees those of the
    /// case.
    fn scene(&self, module: &Module) -> Scene {
        let mut ranges = Ranges::default();
        let function = &module.functions[0];
        for place in 0..function.input_len() {
            let (array, indices, _) = function.input_element(Input(place as u32));
            let numbers = self.inputs.iter().map(|inputs| inputs[place]);
            let start = [f64::INFINITY, f64::NEG_INFINITY];
            let [low, high] = numbers.fold(start, |[low, high], x| [low.min(x), high.max(x)]);
            ranges.set(module.tables.symbols.text(array.name), indices, low, high);
        }
        Scene {
            ranges,
            ..Scene::default()
        }
    }
}

struct EquationsBench<'a> {
    subject: &'a EquationsSubject,
    module: Module,
    exact: Vec<Vec<Double>>,
}

impl StressSubject for EquationsSubject {
    fn metric(&self) -> &'static str {
        "sum"
    }

    fn programs(&self) -> Vec<ProgramTreatment> {
        let treatment = |passes| ProgramTreatment {
            passes,
            ..ProgramTreatment::default()
        };
        PASSES.map(treatment).to_vec()
    }

    fn is_small(&self) -> bool {
        true
    }

    fn prepare(&self) -> Result<Box<dyn StressBench + '_>, StressError> {
        let module = self.module("")?;
        let exact = self
            .inputs
            .iter()
            .map(|inputs| evaluate(&module, WorkingPrecision::Reference, inputs))
            .collect();
        Ok(Box::new(EquationsBench {
            subject: self,
            module,
            exact,
        }))
    }
}

fn evaluate(module: &Module, numbers: WorkingPrecision, inputs: &[f64]) -> Vec<Double> {
    let function = &module.functions[0];
    numbers.work(Evaluation { function, inputs })
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
        let cases = self.subject.inputs.iter().zip(&self.exact);
        let moved = cases.flat_map(|(inputs, exact)| {
            (0..DRAWS).map(move |draw| {
                let inputs = perturb(inputs, step, draw);
                let found = evaluate(&self.module, WorkingPrecision::Reference, &inputs);
                componentwise(&found, exact)
            })
        });
        worst(moved) * amount / step
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let module = self.subject.module(treatment.passes)?;
        let function = &module.functions[0];
        let (mut outside, mut all) = (0u32, 0u32);
        let (mut worst_component, mut worst_norm) = (0.0, 0.0);
        for (inputs, exact) in self.subject.inputs.iter().zip(&self.exact) {
            let found = evaluate(&module, WorkingPrecision::In(treatment.format), inputs);
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
            cost: OperationWork::of(function).cost(treatment.format),
        })
    }
}
