//! Generated equations against an independent account of the dynamics, on
//! random trees of all six kinds of joints.
//!
//! `ROBOVEC_TREES=2000 cargo test --workspace --test all agreement::` tries
//! more trees.

mod accelerations;
mod closing;
mod derivatives;
mod devices;
mod differentiated;
mod dynamics;
mod linearised;
mod loops;
mod standing;
mod turn;
mod user_constraints;

use crate::reference::random::{self, Recipe};
use crate::reference::{State, Tree};
use robovec::generate::{
    Formulation, GenerationRequest, Options, ParameterBinding, TermOrder, generate,
};
use robovec::kinematics;
use robovec::model::Model;
use robovec::robotran::FunctionKind;
use robovec_ir::Module;
use robovec_ir::evaluate::evaluate;
use robovec_num::arithmetic::Binary64;
use robovec_num::double_double::Double;
use robovec_num::random::Random;

/// The largest accepted difference, relative to the largest entry of the
/// array.
pub(crate) const TOLERANCE: f64 = 1e-12;

/// A random model with a state, and the reference's inputs.
pub(crate) struct Case {
    pub(crate) seed: u64,
    pub(crate) model: Model,
    pub(crate) state: State<f64>,
}

impl Case {
    /// The reference's view of the case, in numbers that leave no doubt about
    /// the last digits of binary64.
    pub(crate) fn exact(&self) -> (Tree<Double>, State<Double>) {
        (Tree::new(&self.model), self.state.convert(Double::from))
    }

    /// The state from which the equations' inputs are taken.
    pub(crate) fn inputs(&self) -> kinematics::MotionState {
        let mut inputs = kinematics::MotionState::initial(&self.model);
        inputs.q.clone_from(&self.state.q);
        inputs.qd.clone_from(&self.state.qd);
        inputs.qdd.clone_from(&self.state.qdd);
        inputs.frc.clone_from(&self.state.frc);
        inputs.trq.clone_from(&self.state.trq);
        inputs
    }

    /// Generates a function.
    pub(crate) fn generate(&self, request: &GenerationRequest) -> Module {
        generate(&self.model, request)
            .unwrap_or_else(|error| panic!("seed {}, {request:?}: {error}", self.seed))
    }

    /// Compares an output array with the expected one.
    pub(crate) fn compare(&self, what: &str, found: &[f64], expected: &[Double]) {
        assert_eq!(found.len(), expected.len(), "seed {}: {what}", self.seed);
        // What cancels to nothing keeps the rounding of its terms, which are
        // of the order of 1.
        let size = expected
            .iter()
            .fold(0.1f64, |size, x| size.max(x.high.abs()));
        for (index, (&found, &expected)) in found.iter().zip(expected).enumerate() {
            let error = expected.distance(found);
            assert!(
                error <= TOLERANCE * size,
                "seed {}: {what}, element {index}: {found} instead of {} (array up to {size})",
                self.seed,
                expected.high
            );
        }
    }
}

/// Number of random trees a test tries: a few, or `ROBOVEC_TREES`.
fn trees() -> u64 {
    std::env::var("ROBOVEC_TREES")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(10)
}

/// Runs a test on random models of 1 to 12 bodies.
pub(crate) fn each(recipe: Recipe, test: impl Fn(&Case)) {
    for seed in 1..=trees() {
        let mut random = Random::new(seed);
        let recipe = Recipe {
            bodies: recipe.bodies.max(1 + random.below(12)),
            // Every other model has no zeros at all.
            zeros: recipe.zeros * (seed % 2) as f64,
            placed: seed % 3 == 0,
            ..recipe
        };
        let model = random::model(&mut random, &recipe);
        let state = random::state(&mut random, &model);
        test(&Case { seed, model, state });
    }
}

/// The recipe of trees without loops and devices.
pub(crate) const PLAIN: Recipe = Recipe {
    bodies: 1,
    zeros: 0.5,
    massless: true,
    driven: true,
    placed: false,
    cuts: 0,
    devices: 0,
};

/// All requests for a function: every formulation of the dynamics, and each
/// option that changes the equations.
pub(crate) fn requests(function: FunctionKind) -> Vec<GenerationRequest> {
    let default = Options::default();
    let options = [
        default.clone(),
        Options {
            all_parameters: true,
            ..default.clone()
        },
        Options {
            parameters: ParameterBinding::Numbers,
            ..default.clone()
        },
        Options {
            order: TermOrder::ChildFirst,
            leading_signs: true,
            expanded: true,
            true_angles: false,
            ..default
        },
    ];
    // Of everything but the dynamics there is one form.
    let forms = match function {
        FunctionKind::Dirdyna | FunctionKind::Invdyna => Formulation::ALL.len(),
        _ => 1,
    };
    let formulations = Formulation::ALL.into_iter().take(forms);
    formulations
        .filter(|formulation| formulation.gives(function))
        .flat_map(|formulation| {
            options.iter().map(move |options| GenerationRequest {
                function,
                formulation,
                options: Options {
                    true_angles: options.true_angles
                        || formulation.requirements(function).true_sin_cos,
                    ..options.clone()
                },
            })
        })
        .collect()
}

/// The outputs of a function by array, in full: unassigned elements are zero.
pub(crate) struct Outputs {
    arrays: Vec<(String, Vec<f64>)>,
    /// Array, place in it and number of each assignment.
    assigned: Vec<(String, usize, f64)>,
}

impl Outputs {
    /// Evaluates a function of a module.
    pub(crate) fn of(
        case: &Case,
        module: &Module,
        name: &str,
        inputs: &kinematics::MotionState,
    ) -> Outputs {
        Outputs::with_numbers(case, module, (name, inputs), |_, _| None)
    }

    /// Evaluates a function of a module that has inputs beside those of models.
    pub(crate) fn with_numbers(
        case: &Case,
        module: &Module,
        (name, inputs): (&str, &kinematics::MotionState),
        numbers: impl Fn(&str, &[u32]) -> Option<f64>,
    ) -> Outputs {
        let function = module
            .function(name)
            .unwrap_or_else(|| panic!("seed {}: no function {name}", case.seed));
        let view = robovec_ir::View {
            tables: &module.tables,
            function,
        };
        let sources = kinematics::InputSources::with_numbers(&case.model, view, numbers)
            .unwrap_or_else(|name| panic!("seed {}: no input {name}", case.seed));
        let numbers = evaluate(function, &Binary64, &sources.gather(inputs));
        let mut flat = vec![0.0; function.output_len()];
        let mut assigned = Vec::new();
        for (assignment, number) in function.assignments.iter().zip(numbers) {
            let place = assignment.output.index();
            flat[place] = number;
            let (array, ..) = function.output_element(assignment.output);
            let name = module.tables.symbols.text(array.name).to_owned();
            assigned.push((name, place - array.offset as usize, number));
        }
        let arrays = function.outputs().iter().map(|array| {
            let start = array.offset as usize;
            (
                module.tables.symbols.text(array.name).to_owned(),
                flat[start..start + array.shape.len()].to_vec(),
            )
        });
        Outputs {
            arrays: arrays.collect(),
            assigned,
        }
    }

    /// The places and numbers of an array's elements that the function sets.
    pub(crate) fn assigned<'a>(&'a self, name: &'a str) -> impl Iterator<Item = (usize, f64)> + 'a {
        let elements = self.assigned.iter().filter(move |entry| entry.0 == name);
        elements.map(|&(_, place, number)| (place, number))
    }

    /// The elements of an array, row by row; `None` when the function has no
    /// such output.
    pub(crate) fn array(&self, name: &str) -> Option<&[f64]> {
        self.arrays
            .iter()
            .find(|(array, _)| array == name)
            .map(|(_, numbers)| numbers.as_slice())
    }
}
