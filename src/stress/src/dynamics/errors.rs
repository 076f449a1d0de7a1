//! Errors of dynamics in a state, and the part that no computation could avoid.

use super::super::linear::{condition, estimated_condition, solve};
use super::super::numbers::{Draw, WorkingPrecision, rounded};
use super::super::program::{ModelProgram, ProgramRecipe};
use super::super::units::Units;
use super::super::{ProgramTreatment, StressError};
use super::{DynamicsBench, ExactDynamics, JACOBI, Metric, Solution};
use robovec_dynamics::generate::Formulation;
use robovec_dynamics::kinematics::MotionState;
use robovec_dynamics::kinematics::linear::DenseMatrix;
use robovec_ir::Format;
use robovec_num::double_double::Double;
use robovec_robotran::FunctionKind;

/// The largest difference over the largest magnitude of the reference.
pub(in super::super) fn normwise(found: &[Double], exact: &[Double]) -> f64 {
    assert_eq!(found.len(), exact.len(), "one reference per number");
    let size = exact.iter().fold(0.0f64, |most, x| most.max(x.high.abs()));
    let errors = found.iter().zip(exact).map(|(x, y)| (*x - *y).high.abs());
    worst(errors) / size
}

/// The largest relative difference of an element. Elements that are negligible
/// beside the largest one are zeros that the reference does not reach exactly.
pub(in super::super) fn componentwise(found: &[Double], exact: &[Double]) -> f64 {
    let size = exact.iter().fold(0.0f64, |most, x| most.max(x.high.abs()));
    let error = |(x, y): (&Double, &Double)| {
        let difference = (*x - *y).high.abs();
        if y.high.abs() > 1e-26 * size {
            difference / y.high.abs()
        } else {
            difference / size
        }
    };
    worst(found.iter().zip(exact).map(error))
}

/// The largest number; not a number when one is none.
pub(in super::super) fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |most: f64, error| {
        if error.is_nan() || most.is_nan() {
            f64::NAN
        } else {
            most.max(error)
        }
    })
}

#[derive(Default)]
pub(super) struct DynamicsErrors {
    pub(super) masses: f64,
    pub(super) entries: f64,
    pub(super) bias: f64,
    pub(super) forces: f64,
    pub(super) components: f64,
    pub(super) accelerations: f64,
    /// The matrix that was computed is not positive definite.
    pub(super) indefinite: bool,
    /// Cholesky's factorisation fails in the format.
    pub(super) no_factor: bool,
}

impl DynamicsErrors {
    /// Keeps the larger of two states' errors.
    pub(super) fn join(&mut self, other: &DynamicsErrors) {
        let pairs = [
            (&mut self.masses, other.masses),
            (&mut self.entries, other.entries),
            (&mut self.bias, other.bias),
            (&mut self.forces, other.forces),
            (&mut self.components, other.components),
            (&mut self.accelerations, other.accelerations),
        ];
        for (most, error) in pairs {
            *most = worst([*most, error].into_iter());
        }
        self.indefinite |= other.indefinite;
        self.no_factor |= other.no_factor;
    }

    pub(super) fn named(&self) -> Vec<(&'static str, f64)> {
        let truth = |fact: bool| if fact { 1.0 } else { 0.0 };
        vec![
            ("M normwise", self.masses),
            ("M componentwise", self.entries),
            ("c normwise", self.bias),
            ("Qq normwise", self.forces),
            ("Qq componentwise", self.components),
            ("FD o ID", self.accelerations),
            ("M indefinite", truth(self.indefinite)),
            ("Cholesky fails", truth(self.no_factor)),
        ]
    }
}

impl DynamicsBench<'_> {
    pub(super) fn errors(
        &self,
        state: &MotionState,
        exact: &ExactDynamics,
        treatment: &ProgramTreatment,
    ) -> Result<DynamicsErrors, StressError> {
        let numbers = WorkingPrecision::In(treatment.format);
        let forces = self.treated_forces(state, treatment)?;
        let mut errors = DynamicsErrors {
            forces: normwise(&forces, &exact.forces),
            components: componentwise(&forces, &exact.forces),
            ..DynamicsErrors::default()
        };
        let mut masses = [Vec::new(), Vec::new()];
        if !self.subject.articulated && treatment.formulation != Formulation::Articulated {
            masses = self.masses(state, treatment, numbers)?;
            let [mass, bias] = &masses;
            let size = self.joints();
            errors.masses = normwise(mass, &exact.mass);
            errors.entries = componentwise(mass, &exact.mass);
            if treatment.forces.is_none() {
                errors.bias = normwise(bias, &exact.bias);
            }
            let right = vec![0.0; size];
            let factor = |numbers: WorkingPrecision| {
                let right = &right;
                numbers.work(Solution { size, mass, right })
            };
            errors.no_factor = factor(numbers).is_none();
            errors.indefinite = errors.no_factor && factor(WorkingPrecision::Reference).is_none();
        }
        if self.subject.metric == Metric::Accelerations {
            let found = self.accelerations(state, treatment, &masses)?;
            let wanted: Vec<Double> = state.qdd.iter().copied().map(Double::from).collect();
            errors.accelerations = normwise(&found, &wanted);
        }
        Ok(errors)
    }

    /// The condition of the mass matrix in the worst state.
    pub(super) fn mass_condition(&self) -> f64 {
        let size = self.joints();
        let of_state = |index: usize| {
            if self.subject.articulated {
                let state = &self.subject.states[index];
                return self
                    .columns(state)
                    .map_or(f64::NAN, |entries| estimated_condition(size, &entries));
            }
            let mass = &self.exact[index].mass;
            if size > JACOBI {
                let entries: Vec<f64> = mass.iter().map(|number| number.high).collect();
                return estimated_condition(size, &entries);
            }
            let mut matrix = DenseMatrix::zeros(size, size);
            for (place, number) in mass.iter().enumerate() {
                matrix[(place / size, place % size)] = number.high;
            }
            condition(matrix)
        };
        worst((0..self.subject.states.len()).map(of_state))
    }

    /// Mass matrix by columns, from inverse dynamics at rest without gravity.
    fn columns(&self, state: &MotionState) -> Result<Vec<f64>, StressError> {
        let size = self.joints();
        let mut model = self.subject.model.clone();
        model.gravity = [0.0; 3];
        let recipe = ProgramRecipe::default();
        let program = ModelProgram::new(&model, FunctionKind::Invdyna, recipe)?;
        let mut entries = vec![0.0; size * size];
        let mut state = state.clone();
        state.qd = vec![0.0; size];
        for column in 0..size {
            state.qdd = vec![0.0; size];
            state.qdd[column] = 1.0;
            let numbers = WorkingPrecision::In(Format::BINARY64);
            let flat = program.evaluate(numbers, Units::SI, &program.inputs(&state));
            let forces = program.array("Qq", &flat, size);
            for (row, force) in forces.iter().enumerate() {
                entries[row * size + column] = force.high;
            }
        }
        Ok(entries)
    }

    /// Error of accelerations from exact `M`, `c` and `Qq`, each rounded once.
    pub(super) fn rounded_solution(&self, format: Format) -> f64 {
        let size = self.joints();
        let once = |numbers: &[Double]| -> Vec<Double> {
            let round = |number: &Double| Double::from(rounded(number.high, format));
            numbers.iter().map(round).collect()
        };
        let states = self.subject.states.iter().zip(&self.exact);
        worst(states.map(|(state, exact)| {
            let (forces, bias) = (once(&exact.forces), once(&exact.bias));
            let right: Vec<Double> = (0..size).map(|i| forces[i] - bias[i]).collect();
            let wanted: Vec<Double> = state.qdd.iter().copied().map(Double::from).collect();
            solve(size, &once(&exact.mass), &right).map_or(1.0, |found| normwise(&found, &wanted))
        }))
    }

    /// Distance that the exact result moves with inputs by a relative `amount`.
    pub(super) fn perturbed(&self, amount: f64) -> f64 {
        const DRAWS: u64 = 6;
        let (kind, name) = match self.subject.metric {
            Metric::Masses => (FunctionKind::Dirdyna, "M"),
            Metric::Forces | Metric::Accelerations => (FunctionKind::Invdyna, "Qq"),
        };
        let Ok(program) = self.program(kind, &ProgramTreatment::default(), None) else {
            return f64::NAN;
        };
        let states = self.subject.states.iter().zip(&self.exact);
        worst(states.map(|(state, exact)| {
            let exact = match self.subject.metric {
                Metric::Masses => &exact.mass,
                Metric::Forces | Metric::Accelerations => &exact.forces,
            };
            sensitivity(amount, DRAWS, &program.inputs(state), |inputs| {
                let flat = program.evaluate(WorkingPrecision::Reference, Units::SI, inputs);
                let found = program.array(name, &flat, exact.len());
                match self.subject.metric {
                    Metric::Masses => normwise(&found, exact),
                    Metric::Forces | Metric::Accelerations => componentwise(&found, exact),
                }
            })
        }))
    }
}

/// Largest error of draws in which every input moves by a relative `amount`.
pub(in super::super) fn sensitivity(
    amount: f64,
    draws: u64,
    inputs: &[f64],
    error: impl Fn(&[f64]) -> f64,
) -> f64 {
    // Inputs are binary64 numbers, which cannot move by less; the result
    // moves in proportion.
    let step = amount.max(2f64.powi(-30));
    let moved = (0..draws).map(|draw| error(&perturb(inputs, step, draw)));
    worst(moved) * amount / step
}

/// Inputs moved up or down by a relative amount.
fn perturb(inputs: &[f64], amount: f64, draw: u64) -> Vec<f64> {
    let mut draw = Draw::new(draw);
    let moved = inputs.iter().map(|&number| {
        let up = draw.bits() & 1 == 0;
        number * if up { 1.0 + amount } else { 1.0 - amount }
    });
    moved.collect()
}
