//! The errors that outputs may have: what a scene says of them, or one bound.

use super::{Measure, Scene};
use robovec_ir::View;

/// The errors that outputs may have.
#[derive(Clone, Debug)]
pub struct Allowed {
    /// By assignment: measures and bounds, all of which hold.
    bounds: Vec<Vec<(Measure, f64)>>,
    /// The output array of every assignment, and how many there are.
    arrays: Vec<usize>,
    count: usize,
}

impl Allowed {
    /// The allowed errors: those of a scene, and for all other outputs this
    /// part of the largest element of the array.
    pub fn new(view: View<'_>, scene: Option<&Scene>, error: f64) -> Allowed {
        let outputs = view.function.outputs();
        let array = |place: u32| outputs.partition_point(|array| array.offset <= place) - 1;
        let assignments = &view.function.assignments;
        let bounds = assignments.iter().map(|assignment| {
            let known = scene.map(|scene| scene.tolerances(view, assignment.output));
            let known = known.unwrap_or_default();
            match known.is_empty() {
                true => vec![(Measure::Norm, error)],
                false => known.iter().map(|one| (one.measure, one.bound)).collect(),
            }
        });
        Allowed {
            bounds: bounds.collect(),
            arrays: assignments.iter().map(|a| array(a.output.0)).collect(),
            count: outputs.len(),
        }
    }

    /// The errors allowed of outputs with these values.
    pub fn of(&self, exact: &[f64]) -> Vec<f64> {
        let mut norms = vec![0.0f64; self.count];
        for (value, &array) in exact.iter().zip(&self.arrays) {
            if value.is_finite() {
                norms[array] = norms[array].max(value.abs());
            }
        }
        let rows = self.bounds.iter().zip(exact).zip(&self.arrays);
        rows.map(|((bounds, value), &array)| {
            let allowed = bounds.iter().map(|(measure, bound)| match measure {
                Measure::Norm => bound * norms[array],
                Measure::Relative => bound * value.abs(),
                Measure::Absolute => *bound,
            });
            allowed.fold(f64::INFINITY, f64::min)
        })
        .collect()
    }
}
