//! Partition of the joints into independent, dependent and driven ones.

use super::linear::{DenseMatrix, Pivot, determinant_sign, eliminate};
use robovec_model::{Model, Nature};

/// A pivot below this fraction of another choice's is not trusted.
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
        assert_eq!(
            jacobian.columns(),
            model.joints.len(),
            "one column per joint"
        );
        let weights = |natures: &[Nature]| {
            let weight = |nature: Nature| f64::from(u8::from(natures.contains(&nature)));
            let joints = model.joints.iter();
            joints.map(|joint| weight(joint.nature)).collect::<Vec<_>>()
        };
        let free = weights(&[Nature::Independent, Nature::Dependent]);
        let best = eliminate(jacobian.clone(), &free, threshold);
        let named = eliminate(jacobian.clone(), &weights(&[Nature::Dependent]), threshold);
        let smallest = |pivots: &[Pivot]| {
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
        for places in [&dependent, &rows] {
            assert!(
                places.is_sorted_by(|one, next| one < next),
                "a joint and a row have one pivot"
            );
        }
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
        self.weakest(jacobian)
            .is_none_or(|pivot| pivot.size >= WEAK)
    }

    /// On which side of a dead point a state is: the sign of the determinant
    /// that dependent joints follow from, 0 at the point itself.
    pub fn side(&self, jacobian: &DenseMatrix) -> i8 {
        determinant_sign(jacobian.select(&self.rows, &self.dependent))
    }

    /// The row of the constraints and the dependent joint that the loops
    /// determine least; its size is that of the pivot as a fraction of the
    /// smallest one of the best choice among the joints that are not driven.
    /// `None` without dependent joints.
    pub fn weakest(&self, jacobian: &DenseMatrix) -> Option<Pivot> {
        let count = self.dependent.len();
        let square = jacobian.select(&self.rows, &self.dependent);
        let pivots = eliminate(square, &vec![1.0; count], 0.0);
        let mut free = vec![0.0; jacobian.columns()];
        for &joint in self.dependent.iter().chain(&self.independent) {
            free[joint] = 1.0;
        }
        let best = eliminate(jacobian.clone(), &free, 0.0);
        // Rows that say what others say come last.
        let best = best
            .get(count.wrapping_sub(1))
            .map_or(0.0, |pivot| pivot.size);
        let lost = |taken: fn(&Pivot) -> usize| {
            (0..count).find(|place| pivots.iter().all(|pivot| taken(pivot) != *place))
        };
        let (row, column, size) = match (lost(|p| p.row), lost(|p| p.column), pivots.last()) {
            (Some(row), Some(column), _) => (row, column, 0.0),
            (_, _, last) => last.map(|last| (last.row, last.column, last.size))?,
        };
        Some(Pivot {
            row: self.rows[row],
            column: self.dependent[column],
            size: if best > 0.0 { size / best } else { 0.0 },
        })
    }
}

/// The matrix that takes the motions of independent joints `u` to those of all
/// joints: ones, and the slopes `B` of dependent joints `v`.
pub fn stack(u: &[usize], v: &[usize], slopes: &DenseMatrix, joints: usize) -> DenseMatrix {
    let mut matrix = DenseMatrix::zeros(joints, u.len());
    for (place, &joint) in u.iter().enumerate() {
        matrix[(joint, place)] = 1.0;
    }
    for (row, &joint) in v.iter().enumerate() {
        for place in 0..u.len() {
            matrix[(joint, place)] = slopes[(row, place)];
        }
    }
    matrix
}
