//! Which joints move freely and which follow from the loops.

use super::linear::{DenseMatrix, eliminate};
use crate::model::{Model, Nature};

/// A pivot that is smaller than this fraction of what another choice of
/// dependent joints would give is not trusted.
const WEAK: f64 = 1e-3;

/// The joints of a model by role, and the constraint rows that determine the
/// dependent ones. Each list is in ascending order.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct Partition {
    /// Joints that move freely.
    pub independent: Vec<usize>,
    /// Joints that follow from the loops, as many as `rows`.
    pub dependent: Vec<usize>,
    /// Joints whose motion is given.
    pub driven: Vec<usize>,
    /// Rows of the constraints that are independent of each other.
    pub rows: Vec<usize>,
    /// True when the dependent joints are not those that the model names.
    pub chosen: bool,
}

impl Partition {
    /// Takes the dependent joints that the model names where they determine
    /// the loops well, and else those with the largest pivots. `threshold` is
    /// the fraction of the largest pivot below which one counts as zero.
    pub fn new(model: &Model, jacobian: &DenseMatrix, threshold: f64) -> Partition {
        let weights = |natures: &[Nature]| {
            let weight = |nature: Nature| f64::from(u8::from(natures.contains(&nature)));
            let joints = model.joints.iter();
            joints.map(|joint| weight(joint.nature)).collect::<Vec<_>>()
        };
        let free = weights(&[Nature::Independent, Nature::Dependent]);
        let best = eliminate(jacobian.clone(), &free, threshold);
        let named = eliminate(jacobian.clone(), &weights(&[Nature::Dependent]), threshold);
        let smallest = |pivots: &[super::linear::Pivot]| {
            let sizes = pivots.iter().map(|pivot| pivot.size);
            sizes.fold(f64::INFINITY, f64::min)
        };
        let trusted =
            named.len() == best.len() && smallest(&named) >= WEAK * smallest(&best).min(1e300);
        let pivots = if trusted || best.is_empty() {
            named
        } else {
            best
        };
        let mut dependent: Vec<usize> = pivots.iter().map(|pivot| pivot.column).collect();
        let mut rows: Vec<usize> = pivots.iter().map(|pivot| pivot.row).collect();
        dependent.sort_unstable();
        rows.sort_unstable();
        let (mut independent, mut driven) = (Vec::new(), Vec::new());
        for (index, joint) in model.joints.iter().enumerate() {
            if joint.nature == Nature::Driven {
                driven.push(index);
            } else if dependent.binary_search(&index).is_err() {
                independent.push(index);
            }
        }
        let natures = model.joints.iter().enumerate();
        let named = natures.filter(|(_, joint)| joint.nature == Nature::Dependent);
        let chosen = named.map(|(index, _)| index).ne(dependent.iter().copied());
        Partition {
            independent,
            dependent,
            driven,
            rows,
            chosen,
        }
    }

    /// True when the dependent joints still determine the loops well.
    pub fn holds(&self, jacobian: &DenseMatrix) -> bool {
        let square = jacobian.select(&self.rows, &self.dependent);
        let pivots = eliminate(square, &vec![1.0; self.dependent.len()], WEAK * 0.1);
        pivots.len() == self.dependent.len()
    }
}
