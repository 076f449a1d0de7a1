//! The whole step of a closed loop in one arithmetic: rounds of Newton's
//! method, velocities of dependent joints, accelerations.

use super::StressError;
use super::numbers::{Wide, Work, WorkingPrecision, flattened};
use super::program::{ModelProgram, ProgramRecipe};
use super::units::Units;
use robovec_dynamics::kinematics::MotionState;
use robovec_ir::Format;
use robovec_ir::evaluate::evaluate;
use robovec_model::Model;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::Double;
use robovec_robotran::FunctionKind;

/// Number of Newton's rounds, from a state that is closed up to rounding.
const ROUNDS: usize = 3;

/// Program for the accelerations of a model with loops.
pub(super) enum LoopProgram {
    /// `accelred`, in a closed state.
    Accelerations(Box<ModelProgram>),
    /// All functions of a step.
    Whole(Box<StepProgram>),
}

/// `loop_positions`, `loop_velocities` and `accelred` one after the other.
pub(super) struct StepProgram {
    parts: [ModelProgram; 3],
    /// For each part the places of its inputs among those of the step.
    places: [Vec<usize>; 3],
    /// For functions of loops, pairs of an output and the input it replaces.
    results: [Vec<(usize, usize)>; 2],
    /// For each input of the step, a part that reads it and its place there.
    origins: Vec<(usize, usize)>,
}

impl LoopProgram {
    /// Generates the functions and runs passes over them.
    pub(super) fn new(
        model: &Model,
        whole: bool,
        recipe: ProgramRecipe<'_>,
    ) -> Result<LoopProgram, StressError> {
        let part = |kind| ModelProgram::new(model, kind, recipe);
        let accelerations = part(FunctionKind::Accelred)?;
        if !whole {
            return Ok(LoopProgram::Accelerations(Box::new(accelerations)));
        }
        let positions = part(FunctionKind::LoopPositions)?;
        let velocities = part(FunctionKind::LoopVelocities)?;
        let step = StepProgram::new([positions, velocities, accelerations]);
        Ok(LoopProgram::Whole(Box::new(step)))
    }

    pub(super) fn inputs(&self, state: &MotionState) -> Vec<f64> {
        match self {
            LoopProgram::Accelerations(program) => program.inputs(state),
            LoopProgram::Whole(step) => {
                let parts = step.parts.each_ref().map(|part| part.inputs(state));
                let origins = step.origins.iter();
                origins.map(|&(part, place)| parts[part][place]).collect()
            }
        }
    }

    pub(super) fn accelerations(
        &self,
        numbers: WorkingPrecision,
        inputs: &[f64],
        joints: usize,
    ) -> Vec<Double> {
        match self {
            LoopProgram::Accelerations(program) => {
                let flat = program.evaluate(numbers, Units::SI, inputs);
                program.array("qdd", &flat, joints)
            }
            LoopProgram::Whole(step) => {
                let flat = numbers.work(StepEvaluation { step, inputs });
                step.parts[2].array("qdd", &flat, joints)
            }
        }
    }

    /// Cells of all operations of a step.
    pub(super) fn cost(&self, format: Format) -> f64 {
        match self {
            LoopProgram::Accelerations(program) => program.cost(format),
            LoopProgram::Whole(step) => {
                let [positions, velocities, accelerations] =
                    step.parts.each_ref().map(|part| part.cost(format));
                ROUNDS as f64 * positions + velocities + accelerations
            }
        }
    }

    /// Number of values of `accelred` that are not normal, and of all others.
    pub(super) fn out_of_range(&self, format: Format, inputs: &[f64]) -> [usize; 2] {
        match self {
            LoopProgram::Accelerations(program) => program.out_of_range(format, Units::SI, inputs),
            LoopProgram::Whole(step) => {
                let own: Vec<f64> = step.places[2].iter().map(|&place| inputs[place]).collect();
                step.parts[2].out_of_range(format, Units::SI, &own)
            }
        }
    }
}

impl StepProgram {
    fn new(parts: [ModelProgram; 3]) -> StepProgram {
        let mut names: Vec<&str> = Vec::new();
        let mut origins = Vec::new();
        let mut places = [const { Vec::new() }; 3];
        for (part, program) in parts.iter().enumerate() {
            for (place, name) in program.input_names.iter().enumerate() {
                let known = names.iter().position(|known| known == name);
                if known.is_none() {
                    names.push(name);
                    origins.push((part, place));
                }
                places[part].push(match known {
                    Some(known) => known,
                    None => names.len() - 1,
                });
            }
        }
        let results = [0, 1].map(|part: usize| {
            let outputs = parts[part].output_names.iter().enumerate();
            let known = |name: &String| names.iter().position(|known| known == name);
            let results = outputs.filter_map(|(place, name)| Some((place, known(name)?)));
            results.collect()
        });
        StepProgram {
            parts,
            places,
            results,
            origins,
        }
    }
}

struct StepEvaluation<'a> {
    step: &'a StepProgram,
    inputs: &'a [f64],
}

impl Work for StepEvaluation<'_> {
    type Result = Vec<Double>;

    fn run<A: Arithmetic<Number: Wide>>(self, arithmetic: &A) -> Vec<Double> {
        let step = self.step;
        assert_eq!(
            self.inputs.len(),
            step.origins.len(),
            "one number per input of the step"
        );
        let literals = self.inputs.iter().map(|&number| arithmetic.literal(number));
        let mut numbers: Vec<A::Number> = literals.collect();
        let evaluated = |part: usize, numbers: &[A::Number]| {
            let own: Vec<A::Number> = step.places[part].iter().map(|&at| numbers[at]).collect();
            evaluate(&step.parts[part].function, arithmetic, &own)
        };
        for part in std::iter::repeat_n(0, ROUNDS).chain([1]) {
            let found = evaluated(part, &numbers);
            let assignments = &step.parts[part].function.assignments;
            for (assignment, number) in assignments.iter().zip(found) {
                let output = assignment.output.index();
                let set = step.results[part]
                    .iter()
                    .find(|(place, _)| *place == output);
                if let Some(&(_, input)) = set {
                    numbers[input] = number;
                }
            }
        }
        flattened(&step.parts[2].function, evaluated(2, &numbers))
    }
}

#[cfg(test)]
mod tests {
    use super::super::cases::four_bar;
    use super::*;
    use robovec_dynamics::kinematics::linear::{DenseMatrix, dot, solve_square};
    use robovec_dynamics::motion::{EquationSetting, MotionEquations};

    /// Closes the four-bar by triangles: a crank of 0.3 m and a coupler of
    /// 0.8 m reach the tip of a rocker of 0.6 m on a pivot 0.9 m away. Hinges
    /// turn the other way.
    fn closed(rocker: f64) -> [f64; 2] {
        let (x, y) = (0.9 + 0.6 * (-rocker).cos(), 0.6 * (-rocker).sin());
        let cosine = (x * x + y * y - 0.3f64.powi(2) - 0.8f64.powi(2)) / (2.0 * 0.3 * 0.8);
        let bend = cosine.acos();
        let lean = (0.8 * bend.sin()).atan2(0.3 + 0.8 * bend.cos());
        [lean - y.atan2(x), -bend]
    }

    fn column(numbers: Vec<f64>) -> DenseMatrix {
        let mut column = DenseMatrix::zeros(numbers.len(), 1);
        for (row, number) in numbers.into_iter().enumerate() {
            column[(row, 0)] = number;
        }
        column
    }

    #[test]
    fn the_reference_of_a_step_is_what_triangles_and_dense_matrices_give() {
        let model = four_bar(0.3);
        let mut state = MotionState::initial(&model);
        // Joints in the order crank, coupler, rocker; the rocker elsewhere.
        state.q[2] += 1e-3;
        let program = LoopProgram::new(&model, true, ProgramRecipe::default()).expect("it closes");
        let inputs = program.inputs(&state);
        let found = program.accelerations(WorkingPrecision::Reference, &inputs, 3);
        [state.q[0], state.q[1]] = closed(state.q[2]);
        let equations = MotionEquations::new(&model, &EquationSetting::default()).expect("it does");
        let (residual, jacobian) = equations.constraints().evaluate(&state);
        assert!(residual.iter().all(|gap| gap.abs() < 1e-14), "{residual:?}");
        let square = jacobian.select(&[0, 1], &[0, 1]);
        let right = (0..2)
            .map(|row| -jacobian[(row, 2)] * state.qd[2])
            .collect();
        let rates = solve_square(square, column(right)).expect("no dead point");
        (state.qd[0], state.qd[1]) = (rates[(0, 0)], rates[(1, 0)]);
        let (mass, bias) = equations.dynamics(&state);
        let mut matrix = DenseMatrix::zeros(5, 5);
        for i in 0..3 {
            for j in 0..3 {
                matrix[(i, j)] = mass[(i, j)];
            }
            for row in 0..2 {
                matrix[(i, 3 + row)] = -jacobian[(row, i)];
                matrix[(3 + row, i)] = jacobian[(row, i)];
            }
        }
        let mut right: Vec<f64> = bias.iter().map(|force| -force).collect();
        right.extend(equations.quadratic(&state).into_iter().map(|part| -part));
        let expected = solve_square(matrix, column(right)).expect("it moves");
        let size = (0..3).fold(0.0f64, |most, joint| most.max(expected[(joint, 0)].abs()));
        for (joint, number) in found.iter().enumerate() {
            let error = (number.high - expected[(joint, 0)]).abs();
            assert!(error < 1e-10 * size, "{joint}: {error:e} of {size:e}");
        }
        let moved = dot(&state.q, &state.q);
        assert!(moved > 0.1, "the loop is somewhere else than at zero");
    }
}
