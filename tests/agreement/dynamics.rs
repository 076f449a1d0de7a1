//! Mass matrix, bias and joint forces.

use super::{Case, Outputs, PLAIN, each, requests};
use crate::reference::dynamics::{bias, cholesky, inverse_dynamics, mass_matrix};
use crate::reference::random::Recipe;
use robovec::align::align;
use robovec::generate::{Formulation, GenerationRequest};
use robovec::robotran::FunctionKind;
use robovec_analysis::class::NumericClass;
use robovec_framework::check::check;
use robovec_ir::View;
use robovec_ir::states::States;
use robovec_num::double_double::Double;

fn check_direct(case: &Case, request: &GenerationRequest, matrix: &[Double], forces: &[Double]) {
    let module = case.generate(request);
    let outputs = Outputs::of(case, &module, "dirdyna", &case.inputs());
    let none = vec![0.0; matrix.len()];
    case.compare("M", outputs.array("M").unwrap_or(&none), matrix);
    let none = vec![0.0; forces.len()];
    case.compare("c", outputs.array("c").unwrap_or(&none), forces);
}

#[test]
fn mass_matrix_and_bias_agree_in_every_formulation() {
    each(PLAIN, |case| {
        let (tree, state) = case.exact();
        let matrix = mass_matrix(&tree, &state).concat();
        let forces = bias(&tree, &state);
        for request in requests(FunctionKind::Dirdyna) {
            check_direct(case, &request, &matrix, &forces);
        }
    });
}

#[test]
fn inverse_dynamics_agree_in_every_formulation() {
    each(PLAIN, |case| {
        let (tree, state) = case.exact();
        let expected = inverse_dynamics(&tree, &state);
        for request in requests(FunctionKind::Invdyna) {
            let module = case.generate(&request);
            let outputs = Outputs::of(case, &module, "invdyna", &case.inputs());
            let none = vec![0.0; expected.len()];
            case.compare("Qq", outputs.array("Qq").unwrap_or(&none), &expected);
        }
    });
}

#[test]
fn the_mass_matrix_is_symmetric_and_positive_definite() {
    let recipe = Recipe {
        massless: false,
        ..PLAIN
    };
    each(recipe, |case| {
        for request in requests(FunctionKind::Dirdyna) {
            let module = case.generate(&request);
            let outputs = Outputs::of(case, &module, "dirdyna", &case.inputs());
            let n = case.model.joints.len();
            let flat = outputs.array("M").expect("bodies have mass");
            let mut rows: Vec<Vec<Double>> = flat
                .chunks(n)
                .map(|row| row.iter().map(|&x| Double::from(x)).collect())
                .collect();
            for (i, row) in rows.iter().enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    assert_eq!(entry.high, rows[j][i].high, "seed {}", case.seed);
                }
            }
            assert!(cholesky(&mut rows).is_some(), "seed {}", case.seed);
        }
    });
}

/// Formulations that are polynomials are the same one: their outputs agree at
/// random points of a prime field, where nothing is rounded.
#[test]
fn formulations_are_equal_over_the_real_numbers() {
    each(PLAIN, |case| {
        for function in [FunctionKind::Dirdyna, FunctionKind::Invdyna] {
            let mut first = case.generate(&GenerationRequest::new(function));
            let others = Formulation::ALL.into_iter().filter(|&formulation| {
                let needs = formulation.requirements(function);
                let polynomial = !needs.division && !needs.square_root;
                formulation.gives(function) && polynomial && formulation != Formulation::default()
            });
            for formulation in others {
                let mut other = case.generate(&GenerationRequest {
                    formulation,
                    ..GenerationRequest::new(function)
                });
                let (before, after) = align(
                    (&first.functions[0], &mut first.tables),
                    (&other.functions[0], &mut other.tables),
                );
                let views = [(&before, &first), (&after, &other)].map(|(function, module)| View {
                    tables: &module.tables,
                    function,
                });
                let verdict = check(
                    views[0],
                    views[1],
                    NumericClass::RealTrig,
                    &States::new(case.seed),
                    2,
                );
                assert!(
                    verdict.holds(),
                    "seed {}, {}: {verdict}",
                    case.seed,
                    formulation.name()
                );
            }
        }
    });
}
