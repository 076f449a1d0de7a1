//! Mass matrices, forces and accelerations of trees of bodies.
//!
//! The reference is the recursion Robotran prints, in double-double numbers,
//! from the same inputs. Accelerations are measured as forward after inverse
//! dynamics: the forces `Qq` that a known `qdd` takes are computed in the
//! format, then `M x = Qq - c` is solved and `x` compared with `qdd`. The
//! solution is in double-double numbers: only the error of equations remains.

mod errors;
mod solution;

pub(super) use errors::{componentwise, normwise, sensitivity, worst};

use super::case::{Measured, Memo, StressBench, StressSubject};
use super::linear::solve;
use super::numbers::{WorkingPrecision, rounded};
use super::program::{ModelProgram, ProgramRecipe, shared};
use super::treatment::{BALANCED, PASSES};
use super::units::Units;
use super::{ProgramTreatment, StressError};
use errors::DynamicsErrors;
use robovec_dynamics::generate::{Formulation, MomentOrigin, PrefixNetwork};
use robovec_dynamics::kinematics::MotionState;
use robovec_ir::Format;
use robovec_ir::cost::OperationWork;
use robovec_model::Model;
use robovec_num::double_double::Double;
use robovec_robotran::FunctionKind;
use solution::Solution;
use std::sync::Arc;

/// Error that verdicts are about.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Metric {
    /// Of `M`, relative to its largest entry.
    Masses,
    /// Of `Qq` of the inverse dynamics, element by element.
    Forces,
    /// Of accelerations after inverse dynamics, relative to the largest.
    Accelerations,
}

/// A model in some states.
pub(super) struct DynamicsSubject {
    pub(super) model: Model,
    pub(super) states: Vec<MotionState>,
    pub(super) metric: Metric,
    /// Too long for a mass matrix: accelerations come from articulated bodies.
    pub(super) articulated: bool,
}

/// Joints of models of which every program is tried in every format.
const SMALL: usize = 8;

/// The largest matrix whose eigenvalues are computed by Jacobi's method.
const JACOBI: usize = 140;

impl DynamicsSubject {
    pub(super) fn new(model: Model, states: Vec<MotionState>, metric: Metric) -> DynamicsSubject {
        DynamicsSubject {
            model: shared_model(model),
            states: states.into_iter().map(shared_state).collect(),
            metric,
            articulated: false,
        }
    }
}

/// The model with every parameter rounded to binary32.
pub(super) fn shared_model(mut model: Model) -> Model {
    for body in &mut model.bodies {
        body.mass = shared(body.mass);
        body.center = body.center.map(shared);
        body.inertia = body.inertia.map(shared);
    }
    for point in &mut model.points {
        point.coordinates = point.coordinates.map(shared);
    }
    model.gravity = model.gravity.map(shared);
    model
}

/// The state with every number rounded to binary32.
pub(super) fn shared_state(mut state: MotionState) -> MotionState {
    for numbers in [&mut state.q, &mut state.qd, &mut state.qdd] {
        numbers.iter_mut().for_each(|x| *x = shared(*x));
    }
    state
}

/// The exact dynamics in a state.
struct ExactDynamics {
    mass: Vec<Double>,
    bias: Vec<Double>,
    forces: Vec<Double>,
}

struct DynamicsBench<'a> {
    subject: &'a DynamicsSubject,
    exact: Vec<ExactDynamics>,
    programs: Memo<ProgramKey, Arc<ModelProgram>>,
}

/// Function, formulation, passes, error of `mixed`, and computed array.
type ProgramKey = (
    FunctionKind,
    Formulation,
    &'static str,
    Option<f64>,
    Option<&'static str>,
);

impl StressSubject for DynamicsSubject {
    fn metric(&self) -> &'static str {
        match self.metric {
            Metric::Masses => "M, normwise",
            Metric::Forces => "Qq, componentwise",
            Metric::Accelerations => "FD o ID",
        }
    }

    fn untreated(&self) -> ProgramTreatment {
        let mut untreated = ProgramTreatment::default();
        if self.articulated {
            untreated.formulation = Formulation::Articulated;
        }
        untreated
    }

    fn programs(&self) -> Vec<ProgramTreatment> {
        let plain = self.untreated();
        if self.articulated {
            return Vec::new();
        }
        let mut formulations = vec![
            Formulation::Recursive,
            Formulation::Composite,
            Formulation::CompositeBase,
            Formulation::prefix(PrefixNetwork::Serial, MomentOrigin::Body),
            Formulation::prefix(PrefixNetwork::Serial, MomentOrigin::Base),
        ];
        if self.metric == Metric::Accelerations {
            formulations.push(Formulation::Articulated);
        }
        let passes = match self.is_small() {
            true => &PASSES[..],
            // Of large models the recursion decides.
            false => &PASSES[..2],
        };
        let programs = formulations
            .into_iter()
            .flat_map(|formulation| passes.iter().map(move |&passes| (formulation, passes)));
        programs
            .filter(|(formulation, passes)| {
                self.is_small() || passes.is_empty() || *formulation == Formulation::Recursive
            })
            .map(|program| plain.with(|it| (it.formulation, it.passes) = program))
            .collect()
    }

    fn candidates(&self) -> Vec<ProgramTreatment> {
        let plain = self.untreated();
        let mut list = vec![plain.with(|it| it.units = true)];
        if self.articulated {
            list.push(plain.with(|it| it.passes = BALANCED));
            let precise = plain.with(|it| it.forces = Some(Format::BINARY64));
            list.push(precise.clone());
            list.push(precise.with(|it| it.refinements = 3));
            return list;
        }
        let composite = plain.with(|it| it.formulation = Formulation::Composite);
        list.push(composite.with(|it| it.units = true));
        if self.metric == Metric::Accelerations {
            let precise = composite.with(|it| it.forces = Some(Format::BINARY64));
            for refinements in [0, 1, 2, 4] {
                for units in [false, true] {
                    list.push(precise.with(|it| (it.refinements, it.units) = (refinements, units)));
                }
            }
        }
        list
    }

    fn is_small(&self) -> bool {
        self.model.joints.len() <= SMALL
    }

    /// Accelerations are no single function whose errors the pass could weight.
    fn mixes(&self) -> bool {
        self.is_small() && self.metric != Metric::Accelerations
    }

    fn prepare(&self) -> Result<Box<dyn StressBench + '_>, StressError> {
        let mut bench = DynamicsBench {
            subject: self,
            exact: Vec::new(),
            programs: Memo::default(),
        };
        let plain = ProgramTreatment::default();
        for state in &self.states {
            let [mass, bias] = if self.articulated {
                [Vec::new(), Vec::new()]
            } else {
                bench.masses(state, &plain, WorkingPrecision::Reference)?
            };
            bench.exact.push(ExactDynamics {
                forces: bench.forces(state, &plain, WorkingPrecision::Reference)?,
                mass,
                bias,
            });
        }
        Ok(Box::new(bench))
    }
}

impl DynamicsBench<'_> {
    fn joints(&self) -> usize {
        self.subject.model.joints.len()
    }

    fn program(
        &self,
        kind: FunctionKind,
        treatment: &ProgramTreatment,
        only: Option<&'static str>,
    ) -> Result<Arc<ModelProgram>, StressError> {
        // Articulated bodies give accelerations alone.
        let formulation = if treatment.formulation.gives(kind) {
            treatment.formulation
        } else {
            Formulation::default()
        };
        let (passes, mixed) = (treatment.passes, treatment.mixed);
        let key = (kind, formulation, passes, mixed, only);
        self.programs.get(key, || {
            let recipe = ProgramRecipe {
                formulation,
                passes,
                mixed: mixed.map(|error| (error, &self.subject.states[..])),
                only,
            };
            ModelProgram::new(&self.subject.model, kind, recipe).map(Arc::new)
        })
    }

    fn units(&self, treatment: &ProgramTreatment) -> Units {
        if treatment.units {
            Units::of(&self.subject.model)
        } else {
            Units::SI
        }
    }

    /// `M`, row by row, and `c`.
    fn masses(
        &self,
        state: &MotionState,
        treatment: &ProgramTreatment,
        numbers: WorkingPrecision,
    ) -> Result<[Vec<Double>; 2], StressError> {
        let joints = self.joints();
        // Where forces come from elsewhere only M is computed.
        let only = treatment.forces.map(|_| "M");
        let program = self.program(FunctionKind::Dirdyna, treatment, only)?;
        let flat = program.evaluate(numbers, self.units(treatment), &program.inputs(state));
        let mass = program.array("M", &flat, joints * joints);
        Ok([mass, program.array("c", &flat, joints)])
    }

    /// The forces that the state's accelerations take.
    fn forces(
        &self,
        state: &MotionState,
        treatment: &ProgramTreatment,
        numbers: WorkingPrecision,
    ) -> Result<Vec<Double>, StressError> {
        let program = self.program(FunctionKind::Invdyna, treatment, None)?;
        let flat = program.evaluate(numbers, self.units(treatment), &program.inputs(state));
        Ok(program.array("Qq", &flat, self.joints()))
    }

    /// The forces, in their format of the treatment.
    fn treated_forces(
        &self,
        state: &MotionState,
        treatment: &ProgramTreatment,
    ) -> Result<Vec<Double>, StressError> {
        let format = treatment.force_format();
        self.forces(state, treatment, WorkingPrecision::In(format))
    }

    /// Accelerations for the forces that were computed for those of the state.
    fn accelerations(
        &self,
        state: &MotionState,
        treatment: &ProgramTreatment,
        masses: &[Vec<Double>; 2],
    ) -> Result<Vec<Double>, StressError> {
        let joints = self.joints();
        let forces = self.treated_forces(state, treatment)?;
        let failed = vec![Double::from(f64::NAN); joints];
        if treatment.formulation == Formulation::Articulated {
            return self.articulated(state, treatment, &forces);
        }
        let [mass, bias] = masses;
        let Some(format) = treatment.forces else {
            let right: Vec<Double> = (0..joints).map(|i| forces[i] - bias[i]).collect();
            return Ok(solve(joints, mass, &right).unwrap_or(failed));
        };
        // M in its format, with its factor; what is missing in the other.
        let mut guess = state.clone();
        guess.qdd = vec![0.0; joints];
        for _ in 0..=treatment.refinements {
            let reached = self.treated_forces(&guess, treatment)?;
            let missing: Vec<f64> = (0..joints)
                .map(|i| rounded((forces[i] - reached[i]).high, format))
                .collect();
            let solution = WorkingPrecision::In(treatment.format).work(Solution {
                size: joints,
                mass,
                right: &missing,
            });
            let Some(solution) = solution else {
                return Ok(failed);
            };
            assert_eq!(solution.len(), joints, "one step per joint");
            for (sum, step) in guess.qdd.iter_mut().zip(solution) {
                *sum = rounded(*sum + step, format);
            }
        }
        Ok(guess.qdd.into_iter().map(Double::from).collect())
    }

    /// Accelerations from articulated bodies, refined where that is requested.
    fn articulated(
        &self,
        state: &MotionState,
        treatment: &ProgramTreatment,
        forces: &[Double],
    ) -> Result<Vec<Double>, StressError> {
        let joints = self.joints();
        let program = self.program(FunctionKind::Accelred, treatment, None)?;
        let units = self.units(treatment);
        let run = |forces: &[f64]| {
            let mut state = state.clone();
            state.joint_forces = forces.to_vec();
            let inputs = program.inputs(&state);
            let numbers = WorkingPrecision::In(treatment.format);
            let flat = program.evaluate(numbers, units, &inputs);
            program.array("qdd", &flat, joints)
        };
        let given: Vec<f64> = forces.iter().map(|force| force.high).collect();
        let first = run(&given);
        if treatment.refinements == 0 {
            return Ok(first);
        }
        let format = treatment.force_format();
        // The program is affine in forces: the part without any is taken away.
        let idle = run(&vec![0.0; joints]);
        let mut guess = state.clone();
        guess.qdd = first.iter().map(|number| number.high).collect();
        for _ in 0..treatment.refinements {
            let reached = self.treated_forces(&guess, treatment)?;
            let missing: Vec<f64> = (0..joints)
                .map(|i| rounded((forces[i] - reached[i]).high, format))
                .collect();
            let step = run(&missing);
            for (joint, sum) in guess.qdd.iter_mut().enumerate() {
                *sum = rounded(*sum + (step[joint] - idle[joint]).high, format);
            }
        }
        Ok(guess.qdd.into_iter().map(Double::from).collect())
    }

    /// Cells of the operations in their formats.
    fn cost(&self, treatment: &ProgramTreatment) -> Result<f64, StressError> {
        let joints = self.joints() as f64;
        let cost = |kind, only, format: Format| -> Result<f64, StressError> {
            Ok(self.program(kind, treatment, only)?.cost(format))
        };
        let outer = treatment.force_format();
        if self.subject.metric == Metric::Forces {
            return cost(FunctionKind::Invdyna, None, outer);
        }
        let inverse = match treatment.forces {
            None if treatment.refinements == 0 => 0.0,
            _ => cost(FunctionKind::Invdyna, None, outer)?,
        };
        let repeats = f64::from(treatment.refinements);
        if treatment.formulation == Formulation::Articulated {
            let once = cost(FunctionKind::Accelred, None, treatment.format)?;
            return Ok(once * (1.0 + repeats) + inverse * repeats);
        }
        let only = treatment.forces.map(|_| "M");
        let mut once = cost(FunctionKind::Dirdyna, only, treatment.format)?;
        if self.subject.metric == Metric::Accelerations {
            // Cholesky's factorisation and two triangular systems.
            let factor = joints.powi(3) / 3.0;
            let substitutions = 2.0 * joints * joints * (1.0 + repeats);
            // As many products as sums.
            let half = (factor + substitutions) / 2.0;
            once += OperationWork::new(half, half).cost(treatment.format);
        }
        Ok(once + inverse * (1.0 + repeats))
    }

    fn outside(&self, treatment: &ProgramTreatment) -> Result<f64, StressError> {
        let units = self.units(treatment);
        let mut counts = [0, 0];
        let kinds = if self.subject.articulated {
            [FunctionKind::Accelred, FunctionKind::Invdyna]
        } else {
            [FunctionKind::Dirdyna, FunctionKind::Invdyna]
        };
        for kind in kinds {
            let program = self.program(kind, treatment, None)?;
            for state in &self.subject.states {
                let inputs = program.inputs(state);
                let [outside, all] = program.out_of_range(treatment.format, units, &inputs);
                counts[0] += outside;
                counts[1] += all;
            }
        }
        Ok(counts[0] as f64 / (counts[1].max(1)) as f64)
    }
}

impl StressBench for DynamicsBench<'_> {
    fn condition(&self) -> f64 {
        match self.subject.metric {
            Metric::Accelerations => self.mass_condition(),
            Metric::Masses | Metric::Forces => {
                let amount = Format::BINARY32.unit_roundoff();
                self.perturbed(amount) / amount
            }
        }
    }

    fn floor(&self, format: Format) -> f64 {
        match self.subject.metric {
            Metric::Accelerations if self.subject.articulated => {
                // The error of solving with a mass matrix rounded once.
                self.mass_condition() * format.unit_roundoff()
            }
            Metric::Accelerations => self.rounded_solution(format),
            Metric::Masses | Metric::Forces => self.perturbed(format.unit_roundoff()),
        }
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let mut most = DynamicsErrors::default();
        for (state, exact) in self.subject.states.iter().zip(&self.exact) {
            most.join(&self.errors(state, exact, treatment)?);
        }
        Ok(Measured {
            error: match self.subject.metric {
                Metric::Masses => most.masses,
                Metric::Forces => most.components,
                Metric::Accelerations => most.accelerations,
            },
            others: most.named(),
            outside: self.outside(treatment)?,
            consistent: !most.indefinite,
            cost: self.cost(treatment)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_model::family;

    #[test]
    fn all_ways_to_accelerations_agree_in_exact_numbers() {
        let model = family::serial(9, 2);
        let mut state = MotionState::initial(&model);
        for joint in 0..9 {
            state.qd[joint] = 0.5 - 0.1 * joint as f64;
            state.qdd[joint] = 0.3 * joint as f64 - 1.0;
        }
        let dynamics = DynamicsSubject::new(model, vec![state], Metric::Accelerations);
        let bench = dynamics.prepare().expect("it has equations");
        let treatments = dynamics.candidates().into_iter();
        for treatment in treatments.chain([ProgramTreatment::default()]) {
            let wide = ProgramTreatment {
                format: Format::BINARY64,
                ..treatment
            };
            let measured = bench.measure(&wide).expect("it has equations");
            assert!(measured.error < 1e-10, "{wide}: {:e}", measured.error);
            assert!(measured.cost > 0.0 && measured.consistent);
        }
    }
}
