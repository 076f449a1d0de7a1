//! Mass matrix, bias and joint forces.

use super::{Case, Outputs, PLAIN, each, requests};
use crate::reference::dynamics::{bias, cholesky, inverse_dynamics, mass_matrix};
use crate::reference::random::Recipe;
use robovec::generate::{FunctionKind, Request};
use robovec_ir::double_double::Double;

fn check_direct(case: &Case, request: &Request) {
    let (tree, state) = case.exact();
    let module = case.generate(request);
    let outputs = Outputs::of(case, &module, "dirdyna", &case.inputs());
    let matrix = mass_matrix(&tree, &state).concat();
    let none = vec![0.0; matrix.len()];
    case.compare("M", outputs.array("M").unwrap_or(&none), &matrix);
    let expected = bias(&tree, &state);
    let none = vec![0.0; expected.len()];
    case.compare("c", outputs.array("c").unwrap_or(&none), &expected);
}

#[test]
fn mass_matrix_and_bias_agree_in_every_formulation() {
    each(PLAIN, |case| {
        for request in requests(FunctionKind::Dirdyna) {
            check_direct(case, &request);
        }
    });
}

#[test]
fn inverse_dynamics_agree_in_every_formulation() {
    each(PLAIN, |case| {
        let (tree, state) = case.exact();
        for request in requests(FunctionKind::Invdyna) {
            let module = case.generate(&request);
            let outputs = Outputs::of(case, &module, "invdyna", &case.inputs());
            let expected = inverse_dynamics(&tree, &state);
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
