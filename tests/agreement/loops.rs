//! Constraints of loops.

use super::{Case, Outputs, PLAIN, each, requests};
use crate::reference::loops::constraints;
use crate::reference::random::{self, Recipe};
use robovec::robotran::FunctionKind;
use robovec_num::double_double::Double;
use robovec_num::random::Random;

/// The rows that some joint changes. The equations may leave the others out,
/// and do so where the structure shows them.
fn changing(case: &Case) -> Vec<bool> {
    let mut changing = Vec::new();
    for seed in 0..3 {
        let state = random::state(&mut Random::new(seed), &case.model);
        let rows = constraints(&case.model, &state).jacobian;
        changing.resize(rows.len(), false);
        for (changing, row) in changing.iter_mut().zip(rows) {
            *changing |= row.iter().any(|entry| entry.abs() > 1e-12);
        }
    }
    changing
}

/// The rows that the equations contain, given their results: all that change,
/// and of the others those that are present with their residual and a row of
/// zeros in the Jacobian.
pub(super) fn held(case: &Case, expected: &[Double], outputs: &Outputs) -> Vec<bool> {
    let residuals = outputs.array("h").unwrap_or(&[]);
    let jacobian = outputs.array("Jac").unwrap_or(&[]);
    let rows = jacobian.chunks(case.model.joints.len());
    let mut found = residuals.iter().zip(rows).peekable();
    let held = |(changes, expected): (bool, &Double)| {
        let same = |(residual, row): &(&f64, &[f64])| {
            let constant = row.iter().all(|entry| entry.abs() < 1e-12);
            changes || constant && expected.distance(**residual) < 1e-12
        };
        found.next_if(same).is_some()
    };
    changing(case).into_iter().zip(expected).map(held).collect()
}

fn rows<T: Clone>(rows: &[T], held: &[bool]) -> Vec<T> {
    let kept = rows.iter().zip(held).filter(|(_, held)| **held);
    kept.map(|(row, _)| row.clone()).collect()
}

#[test]
fn constraints_agree_with_their_definition() {
    let recipe = Recipe {
        bodies: 2,
        cuts: 2,
        ..PLAIN
    };
    each(recipe, |case| {
        let (_, state) = case.exact();
        let expected = constraints(&case.model, &state);
        let position = requests(FunctionKind::ConsHJ);
        for (position, second) in position.iter().zip(requests(FunctionKind::ConsJdqd)) {
            let module = case.generate(position);
            let outputs = Outputs::of(case, &module, "cons_hJ", &case.inputs());
            let found = outputs.array("Jac").unwrap_or(&[]);
            let held = held(case, &expected.residual, &outputs);
            let jacobian = rows(&expected.jacobian, &held).concat();
            case.compare("Jac", found, &jacobian);
            let residual = rows(&expected.residual, &held);
            case.compare("h", outputs.array("h").unwrap_or(&[]), &residual);
            let module = case.generate(&second);
            let outputs = Outputs::of(case, &module, "cons_jdqd", &case.inputs());
            let quadratic = rows(&expected.quadratic, &held);
            case.compare("Jdqd", outputs.array("Jdqd").unwrap_or(&[]), &quadratic);
        }
    });
}
