//! The constraints of loops, evaluated.

use super::linear::DenseMatrix;
use super::{CompiledFunction, MotionState};
use robovec_ir::Format;
use robovec_model::Model;

/// The constraints `h` of a model's loops and their Jacobian.
pub struct LoopConstraints {
    joints: usize,
    format: Format,
    /// The function `cons_hJ`; `None` for a model without cuts.
    position: Option<CompiledFunction>,
    row_cuts: Vec<usize>,
}

impl LoopConstraints {
    /// The constraints of a model without cuts, in the numbers of a format.
    pub fn none(model: &Model, format: Format) -> LoopConstraints {
        LoopConstraints {
            joints: model.joints.len(),
            format,
            position: None,
            row_cuts: Vec::new(),
        }
    }

    /// The constraints that the function `cons_hJ` gives in the numbers of a
    /// format, and the cut, from 0, of each of its rows.
    pub fn new(
        model: &Model,
        format: Format,
        position: CompiledFunction,
        row_cuts: Vec<usize>,
    ) -> LoopConstraints {
        LoopConstraints {
            joints: model.joints.len(),
            format,
            position: Some(position),
            row_cuts,
        }
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.row_cuts.len()
    }

    /// The cut of a row, from 0.
    pub fn cut_of(&self, row: usize) -> usize {
        self.row_cuts[row]
    }

    /// The relative distance of neighbours of the numbers the equations are
    /// evaluated in: twice the unit roundoff.
    pub fn epsilon(&self) -> f64 {
        2.0 * self.format.unit_roundoff()
    }

    /// The residual `h` and the Jacobian `Jac`.
    pub fn evaluate(&self, state: &MotionState) -> (Vec<f64>, DenseMatrix) {
        match &self.position {
            None => (Vec::new(), DenseMatrix::zeros(0, self.joints)),
            Some(compiled) => {
                let outputs = compiled.evaluate(state);
                (
                    outputs.vector("h", self.rows()),
                    outputs.matrix("Jac", self.rows(), self.joints),
                )
            }
        }
    }

    /// The derivative of the Jacobian along a direction.
    pub fn jacobian_along(&self, state: &MotionState, direction: &MotionState) -> DenseMatrix {
        match &self.position {
            None => DenseMatrix::zeros(0, self.joints),
            Some(compiled) => {
                let outputs = compiled.evaluate_along(state, direction);
                outputs.matrix("Jac", self.rows(), self.joints)
            }
        }
    }
}
