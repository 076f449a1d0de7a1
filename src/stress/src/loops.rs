//! Accelerations of closed loops.

use super::case::{Measured, Memo, StressBench, StressSubject};
use super::dynamics::{normwise, sensitivity, shared_model, shared_state, worst};
use super::linear::eigenvalues;
use super::numbers::WorkingPrecision;
use super::program::ProgramRecipe;
use super::treatment::PASSES;
use super::whole_step::LoopProgram;
use super::{ProgramTreatment, StressError};
use robovec_dynamics::generate::{Formulation, MomentOrigin, PrefixNetwork};
use robovec_dynamics::kinematics::MotionState;
use robovec_dynamics::kinematics::linear::{DenseMatrix, dot};
use robovec_dynamics::motion::{EquationSetting, MotionEquations};
use robovec_ir::Format;
use robovec_model::{Model, Nature};
use robovec_num::double_double::Double;
use std::sync::Arc;

/// Models with closed loops.
pub(super) struct LoopsSubject {
    closed: Vec<Closed>,
}

/// A model in a state that closes its loops.
struct Closed {
    model: Model,
    state: MotionState,
    /// Closes the loops as well, from the positions of the independent joints.
    whole: bool,
}

impl LoopsSubject {
    /// Models, closed in their initial states.
    pub(super) fn new(models: impl IntoIterator<Item = Model>) -> LoopsSubject {
        let models = models.into_iter();
        LoopsSubject::in_states(models.map(|model| {
            let state = MotionState::initial(&model);
            (model, state)
        }))
    }

    /// Models with states that close their loops. The generator eliminates by
    /// pivots that are good in the initial states of the models.
    pub(super) fn in_states(
        models: impl IntoIterator<Item = (Model, MotionState)>,
    ) -> LoopsSubject {
        let closed = models.into_iter().map(|(model, state)| Closed {
            state: shared_state(state),
            model: shared_model(model),
            whole: false,
        });
        let closed = closed.collect();
        LoopsSubject { closed }
    }

    /// The same with the whole step measured: positions and velocities of
    /// dependent joints are computed from the others, in the same numbers as
    /// accelerations. Each partition is compared with its own exact results.
    pub(super) fn whole_step(mut self) -> LoopsSubject {
        for closed in &mut self.closed {
            closed.whole = true;
        }
        self
    }
}

impl Closed {
    /// The program for a treatment, if its partition has equations.
    fn program(&self, treatment: &ProgramTreatment) -> Result<LoopProgram, StressError> {
        if !treatment.independent.is_empty() {
            let plain = treatment.with(|it| it.independent.clear());
            let divided = Closed {
                model: divided(&self.model, &treatment.independent),
                state: self.state.clone(),
                whole: self.whole,
            };
            let program = divided.program(&plain);
            return program.map_err(|error| StressError::Passes(error.to_string()));
        }
        let recipe = ProgramRecipe {
            formulation: treatment.formulation,
            passes: treatment.passes,
            mixed: treatment
                .mixed
                .map(|error| (error, std::slice::from_ref(&self.state))),
            only: None,
        };
        LoopProgram::new(&self.model, self.whole, recipe)
    }

    fn accelerations(
        &self,
        program: &LoopProgram,
        numbers: WorkingPrecision,
        inputs: &[f64],
    ) -> Vec<Double> {
        program.accelerations(numbers, inputs, self.model.joints.len())
    }

    fn exact(&self, program: &LoopProgram, inputs: &[f64]) -> Vec<Double> {
        self.accelerations(program, WorkingPrecision::Reference, inputs)
    }
}

/// The model with these joints independent, of those that are not driven.
fn divided(model: &Model, independent: &[String]) -> Model {
    let mut model = model.clone();
    for joint in &mut model.joints {
        joint.nature = match joint.nature {
            Nature::Driven => Nature::Driven,
            _ if independent.contains(&joint.name) => Nature::Independent,
            _ => Nature::Dependent,
        };
    }
    model
}

/// The maximum number of partitions that are tried.
const PARTITIONS: usize = 16;

/// Other partitions of coordinates: one independent joint exchanged.
fn partitions(model: &Model) -> Vec<Vec<String>> {
    let of = |nature: Nature| {
        let joints = model
            .joints
            .iter()
            .filter(move |joint| joint.nature == nature);
        joints.map(|joint| joint.name.clone())
    };
    let independent: Vec<String> = of(Nature::Independent).collect();
    let exchanged = of(Nature::Dependent).flat_map(|dependent| {
        let independent = independent.clone();
        (0..independent.len()).map(move |place| {
            let mut names = independent.clone();
            names[place] = dependent.clone();
            names
        })
    });
    exchanged.take(PARTITIONS).collect()
}

struct LoopsBench<'a> {
    models: Vec<PreparedLoop<'a>>,
}

/// A model with its reference.
struct PreparedLoop<'a> {
    subject: &'a Closed,
    plain: LoopProgram,
    exact: Vec<Double>,
    equations: MotionEquations,
    programs: Memo<ProgramTreatment, Arc<LoopProgram>>,
}

impl StressSubject for LoopsSubject {
    fn metric(&self) -> &'static str {
        "qdd"
    }

    fn programs(&self) -> Vec<ProgramTreatment> {
        let formulations = [
            Formulation::Recursive,
            Formulation::Composite,
            Formulation::CompositeBase,
            Formulation::prefix(PrefixNetwork::Serial, MomentOrigin::Body),
        ];
        // All models of a case have the same joints.
        let others = self.closed.first().map(|closed| partitions(&closed.model));
        let mut choices = vec![Vec::new()];
        choices.extend(others.into_iter().flatten());
        let mut programs = Vec::new();
        for independent in &choices {
            for formulation in formulations {
                for passes in PASSES {
                    programs.push(ProgramTreatment {
                        formulation,
                        passes,
                        independent: independent.clone(),
                        ..ProgramTreatment::default()
                    });
                }
            }
        }
        programs
    }

    fn is_small(&self) -> bool {
        let joints = self.closed.iter().map(|closed| closed.model.joints.len());
        joints.max().is_none_or(|most| most <= SMALL)
    }

    fn mixes(&self) -> bool {
        self.is_small() && !self.closed.iter().any(|closed| closed.whole)
    }

    fn prepare(&self) -> Result<Box<dyn StressBench + '_>, StressError> {
        let models: Result<_, _> = self.closed.iter().map(PreparedLoop::new).collect();
        Ok(Box::new(LoopsBench { models: models? }))
    }
}

/// Joints of models of which every program is tried in every format.
const SMALL: usize = 8;

/// Relative size of an eigenvalue below which its row is redundant.
const REDUNDANT: f64 = 1e-13;

impl StressBench for LoopsBench<'_> {
    fn condition(&self) -> f64 {
        worst(self.models.iter().map(PreparedLoop::condition))
    }

    fn floor(&self, format: Format) -> f64 {
        worst(self.models.iter().map(|model| model.floor(format)))
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let results: Result<Vec<Measured>, StressError> = self
            .models
            .iter()
            .map(|model| model.measure(treatment))
            .collect();
        let results = results?;
        let residuals = results.iter().flat_map(|result| &result.others);
        let most = |of: fn(&Measured) -> f64| worst(results.iter().map(of));
        Ok(Measured {
            error: most(|result| result.error),
            others: vec![(
                "J qdd + Jdqd",
                worst(residuals.map(|(_, residual)| *residual)),
            )],
            outside: most(|result| result.outside),
            consistent: true,
            cost: results.iter().map(|result| result.cost).sum(),
        })
    }
}

impl<'a> PreparedLoop<'a> {
    fn new(subject: &'a Closed) -> Result<PreparedLoop<'a>, StressError> {
        let plain = subject.program(&ProgramTreatment::default())?;
        let inputs = plain.inputs(&subject.state);
        Ok(PreparedLoop {
            exact: subject.exact(&plain, &inputs),
            equations: MotionEquations::new(&subject.model, &EquationSetting::default())?,
            subject,
            plain,
            programs: Memo::default(),
        })
    }

    /// The program for a treatment, made once for all formats.
    fn program(&self, treatment: &ProgramTreatment) -> Result<Arc<LoopProgram>, StressError> {
        self.programs.get(treatment.in_binary32(), || {
            self.subject.program(treatment).map(Arc::new)
        })
    }

    /// The exact accelerations. In a whole step the independent joints decide
    /// the position of the loop, so each partition has its own reference.
    fn exact(&self, treatment: &ProgramTreatment) -> Result<Vec<Double>, StressError> {
        if !self.subject.whole || treatment.independent.is_empty() {
            return Ok(self.exact.clone());
        }
        let program = self.program(&ProgramTreatment {
            independent: treatment.independent.clone(),
            ..ProgramTreatment::default()
        })?;
        let inputs = program.inputs(&self.subject.state);
        Ok(self.subject.exact(&program, &inputs))
    }

    /// Of `[M J'; J 0]` of accelerations and multipliers without redundancy.
    fn condition(&self) -> f64 {
        let joints = self.subject.model.joints.len();
        let (mass, _) = self.equations.dynamics(&self.subject.state);
        let (_, jacobian) = self.equations.constraints().evaluate(&self.subject.state);
        let size = joints + jacobian.rows();
        let mut matrix = DenseMatrix::zeros(size, size);
        for i in 0..joints {
            for j in 0..joints {
                matrix[(i, j)] = mass[(i, j)];
            }
            for row in 0..jacobian.rows() {
                matrix[(joints + row, i)] = jacobian[(row, i)];
                matrix[(i, joints + row)] = jacobian[(row, i)];
            }
        }
        let sizes: Vec<f64> = eigenvalues(matrix).into_iter().map(f64::abs).collect();
        let most = sizes.iter().fold(0.0f64, |most, &x| most.max(x));
        let kept = sizes.into_iter().filter(|&x| x > REDUNDANT * most);
        most / kept.fold(f64::INFINITY, f64::min)
    }

    fn floor(&self, format: Format) -> f64 {
        const DRAWS: u64 = 8;
        let inputs = self.plain.inputs(&self.subject.state);
        sensitivity(format.unit_roundoff(), DRAWS, &inputs, |inputs| {
            normwise(&self.subject.exact(&self.plain, inputs), &self.exact)
        })
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let program = self.program(treatment)?;
        let state = &self.subject.state;
        let inputs = program.inputs(state);
        let numbers = WorkingPrecision::In(treatment.format);
        let found = self.subject.accelerations(&program, numbers, &inputs);
        let error = normwise(&found, &self.exact(treatment)?);
        // All rows, those that were left out as redundant included.
        let accelerations: Vec<f64> = found.iter().map(|number| number.high).collect();
        let (_, jacobian) = self.equations.constraints().evaluate(state);
        let quadratic = self.equations.quadratic(state);
        let residuals = (0..jacobian.rows())
            .map(|row| (dot(jacobian.row(row), &accelerations) + quadratic[row]).abs());
        let size = accelerations
            .iter()
            .fold(1e-300f64, |most, x| most.max(x.abs()));
        let [outside, all] = program.out_of_range(treatment.format, &inputs);
        Ok(Measured {
            error,
            others: vec![("J qdd + Jdqd", worst(residuals) / size)],
            outside: outside as f64 / all.max(1) as f64,
            consistent: true,
            cost: program.cost(treatment.format),
        })
    }
}
