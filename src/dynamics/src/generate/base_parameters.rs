//! Base parameters of a model: the fewest combinations of the inertial
//! parameters of its bodies that determine the forces of its joints.
//!
//! The columns of the regressor `Y` at random states are taken in their order.
//! The *remainder* of a column is the part at right angles to all columns kept
//! so far. A column that has one is kept. Any other is a combination of columns
//! before it, so its parameter is added to theirs: `Y p = Yb K p` with the kept
//! columns `Yb` (Gautier, "Numerical calculation of the base inertial parameters
//! of robots", Journal of Robotic Systems 8, 1991). Columns and `K` are verified
//! at other states. Loops are open.

use super::grouping::GroupedInertia;
use super::regressor::{MOMENTS, NUMBERS};
use super::{GenerateError, GenerationRequest, Options, ParameterBinding, generate_asked};
use crate::kinematics::linear::{dot, largest};
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Function, Module, Shape};
use robovec_model::Model;
use robovec_num::arithmetic::Binary64;
use robovec_num::random::Random;
use robovec_robotran::FunctionKind;
use std::f64::consts::PI;
use thiserror::Error;

/// Numbers of states; the second where the first one's result fails elsewhere.
const STATES: [usize; 2] = [40, 160];

/// Number of states at which a result is verified.
const VERIFIED: usize = 20;

/// Maximum relative change of a factor that is rounded to a short decimal.
const ROUNDING: f64 = 1e-13;

/// Minimum remainder of an independent column, relative to the longest column.
const INDEPENDENT: f64 = 1e-7;

/// Maximum remainder of a dependent column, and size of a zero factor.
const DEPENDENT: f64 = 1e-11;

/// Rounding errors of columns, relative to the longest of all.
const NOISE: f64 = 1e-14;

/// Maximum difference of `Y` and `Yb K`, relative to the column of `Y`.
const TOLERANCE: f64 = 1e-10;

/// Maximum number of joints; the time grows with the cube.
const JOINTS: usize = 150;

/// Reason why the base parameters are not known.
#[derive(Clone, PartialEq, Error, Debug)]
pub enum BaseParameterError {
    /// No regressor.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// Too many joints.
    #[error("base parameters are computed for at most {JOINTS} joints, and the model has {0}")]
    TooLarge(usize),
    /// A column is neither dependent nor independent.
    #[error(
        "{parameter} has almost no effect beside the parameters before it, {effect:.1e} of the \
         largest: less than {INDEPENDENT:e} is too little to identify it, and more than {NOISE:e} \
         is no rounding error"
    )]
    Undecided {
        /// The name of the parameter.
        parameter: String,
        /// The remainder of its column, relative to the longest column.
        effect: f64,
    },
    /// The map does not hold at other states.
    #[error("the base parameters found differ by {0:.1e} at other states")]
    Unverified(f64),
}

/// A base parameter: a sum of parameters.
#[derive(Clone, PartialEq, Debug)]
pub struct BaseParameter {
    /// Columns of the regressor, from 0, and factors; first the kept one's, 1.
    pub terms: Vec<(usize, f64)>,
    /// The value in the model.
    pub value: f64,
}

/// The base parameters of a model.
#[derive(Clone, PartialEq, Debug)]
pub struct BaseParameters {
    /// The base parameters, in the order of the columns that are kept.
    pub parameters: Vec<BaseParameter>,
    /// Columns of bodies without any effect, from 0.
    pub without_effect: Vec<usize>,
    /// Smallest remainder of a column that is kept, relative to the longest one.
    pub least_kept: f64,
    /// Largest remainder of a column that is left out.
    pub most_left_out: f64,
    /// Largest difference of `Y` and `Yb K` elsewhere, relative to `Y`.
    pub difference: f64,
}

impl BaseParameters {
    /// Finds the base parameters of a model.
    pub fn new(model: &Model, options: &Options) -> Result<BaseParameters, BaseParameterError> {
        if model.joints.len() > JOINTS {
            return Err(BaseParameterError::TooLarge(model.joints.len()));
        }
        let mut request = GenerationRequest::new(FunctionKind::Regressor);
        request.options = Options {
            parameters: ParameterBinding::Numbers,
            base_columns: Vec::new(),
            ..options.clone()
        };
        let module = generate_asked(model, &request)?;
        let mut random = Random::new(1);
        let mut difference = 0.0;
        for states in STATES {
            let mut found = BaseParameters::of(&columns(&module, states, &mut random))?;
            difference = found.compare(&columns(&module, VERIFIED, &mut random));
            if difference <= TOLERANCE {
                found.difference = difference;
                let has_body = |column: &usize| model.body_of(column / NUMBERS).is_some();
                found.without_effect.retain(has_body);
                let values = values(model);
                for base in &mut found.parameters {
                    let products = base.terms.iter().map(|&(at, factor)| factor * values[at]);
                    base.value = products.sum();
                }
                return Ok(found);
            }
        }
        Err(BaseParameterError::Unverified(difference))
    }

    /// The columns of the regressor that are kept, from 0, ascending.
    pub fn columns(&self) -> Vec<usize> {
        let all = self.parameters.iter();
        let columns: Vec<usize> = all.map(|base| base.terms[0].0).collect();
        assert!(columns.is_sorted(), "columns ascend");
        columns
    }

    /// Reduces columns, whose parameters have no values yet.
    fn of(columns: &[Vec<f64>]) -> Result<BaseParameters, BaseParameterError> {
        let most = columns.iter().map(|column| length(column));
        let most = most.fold(0.0, f64::max);
        let mut found = BaseParameters {
            parameters: Vec::new(),
            without_effect: Vec::new(),
            least_kept: 1.0,
            most_left_out: 0.0,
            difference: 0.0,
        };
        // Directions at right angles, and the columns kept as sums of them.
        let (mut directions, mut kept) = (Vec::<Vec<f64>>::new(), Vec::<Vec<f64>>::new());
        let mut lengths = Vec::new();
        for (place, column) in columns.iter().enumerate() {
            let size = length(column);
            if size <= NOISE * most {
                found.without_effect.push(place);
                continue;
            }
            let mut rest: Vec<f64> = column.iter().map(|entry| entry / size).collect();
            let mut along = vec![0.0; directions.len()];
            // The second round removes the rounding errors of the first.
            for _ in 0..2 {
                for (along, direction) in along.iter_mut().zip(&directions) {
                    let part = dot(direction, &rest);
                    *along += part;
                    for (rest, entry) in rest.iter_mut().zip(direction) {
                        *rest -= part * entry;
                    }
                }
            }
            let remainder = length(&rest);
            let effect = remainder * size / most;
            if effect >= INDEPENDENT {
                found.least_kept = found.least_kept.min(effect);
                rest.iter_mut().for_each(|entry| *entry /= remainder);
                directions.push(rest);
                along.push(remainder);
                kept.push(along);
                lengths.push(size);
                found.parameters.push(BaseParameter {
                    terms: vec![(place, 1.0)],
                    value: 0.0,
                });
            } else if remainder <= DEPENDENT || effect <= NOISE {
                found.most_left_out = found.most_left_out.max(effect);
                // Back substitution: kept columns are triangular in the directions.
                for base in (0..kept.len()).rev() {
                    let share = along[base] / kept[base][base];
                    for (along, entry) in along.iter_mut().zip(&kept[base]) {
                        *along -= share * entry;
                    }
                    if share.abs() > DEPENDENT {
                        let factor = rounded(share * size / lengths[base]);
                        found.parameters[base].terms.push((place, factor));
                    }
                }
            } else {
                return Err(BaseParameterError::Undecided {
                    parameter: parameter_name(place),
                    effect,
                });
            }
        }
        Ok(found)
    }

    /// Largest difference of columns from the kept ones' combination, relative.
    fn compare(&self, columns: &[Vec<f64>]) -> f64 {
        let mut rest = columns.to_vec();
        for base in &self.parameters {
            let kept = &columns[base.terms[0].0];
            for &(place, factor) in &base.terms {
                for (rest, entry) in rest[place].iter_mut().zip(kept) {
                    *rest -= factor * entry;
                }
            }
        }
        let most = columns.iter().map(|column| largest(column));
        let most = most.fold(0.0, f64::max);
        let pairs = rest.iter().zip(columns).enumerate();
        let differences = pairs.map(|(place, (rest, column))| {
            let is_zero = self.without_effect.contains(&place);
            largest(rest) / if is_zero { most } else { largest(column) }
        });
        differences.fold(0.0, f64::max)
    }
}

/// The name of a parameter by its column, from 0, with the number of its joint:
/// the mass, the first moment, a moment of inertia about the origin.
pub fn parameter_name(column: usize) -> String {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let joint = column / NUMBERS + 1;
    match column % NUMBERS {
        0 => format!("m[{joint}]"),
        number @ 1..=3 => format!("m{}[{joint}]", AXES[number - 1]),
        number => {
            let (row, column) = MOMENTS[number - 4];
            format!("I{}{}[{joint}]", AXES[row], AXES[column])
        }
    }
}

fn values(model: &Model) -> Vec<f64> {
    let of_joint = |joint| {
        let body = model.body_of(joint);
        let inertia = body.map_or_else(GroupedInertia::default, |body| {
            GroupedInertia::of_body(body.mass, body.center, body.inertia_matrix())
        });
        let moments = MOMENTS.map(|(row, column)| inertia.moments[row][column]);
        let first = [inertia.mass].into_iter().chain(inertia.first);
        first.chain(moments).collect::<Vec<f64>>()
    };
    (0..model.joints.len()).flat_map(of_joint).collect()
}

/// The columns of a regressor at random states, those of one after the other.
fn columns(module: &Module, states: usize, random: &mut Random) -> Vec<Vec<f64>> {
    let function = &module.functions[0];
    let Shape::Matrix(joints, width) = function.outputs()[0].shape else {
        unreachable!("a regressor is a matrix")
    };
    let (joints, width) = (joints as usize, width as usize);
    let mut columns = vec![vec![0.0; states * joints]; width];
    for state in 0..states {
        let inputs = inputs(module, function, random);
        let numbers = evaluate(function, &Binary64, &inputs);
        for (set, number) in function.assignments.iter().zip(numbers) {
            let (row, column) = (set.output.index() / width, set.output.index() % width);
            columns[column][state * joints + row] = number;
        }
    }
    columns
}

/// Random positions, velocities and accelerations, and an attitude.
fn inputs(module: &Module, function: &Function, random: &mut Random) -> Vec<f64> {
    let mut inputs: Vec<f64> = (0..function.input_len())
        .map(|_| PI * random.signed())
        .collect();
    for array in function.inputs() {
        if module.tables.symbols.text(array.name) == "quat" {
            let quat = &mut inputs[array.offset as usize..][..array.shape.len()];
            let size = length(quat);
            quat.iter_mut().for_each(|entry| *entry /= size);
        }
    }
    inputs
}

fn length(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

/// The shortest decimal of a number within its rounding errors, or the number.
fn rounded(number: f64) -> f64 {
    (0..12)
        .filter_map(|digits| format!("{number:.digits$e}").parse::<f64>().ok())
        .find(|short| (short - number).abs() <= ROUNDING * number.abs())
        .unwrap_or(number)
}
