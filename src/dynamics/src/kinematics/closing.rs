//! Closing loops: positions and velocities of dependent joints.

use super::linear::{DenseMatrix, column, dot, largest, solve_positive, solve_square};
use super::{CompiledFunction, MotionState, Partition, StateError};
use robovec_ir::Format;
use robovec_model::{CutKind, Model, Nature};

/// Newton steps before giving up; from a predicted position three suffice.
const NEWTON_STEPS: u32 = 25;
/// Steps of the search for a closed position.
const ASSEMBLY_STEPS: usize = 200;

/// Ends of Newton's rounds, in the numbers that residuals are evaluated in.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ClosingLimits {
    /// A residual that the arithmetic cannot make smaller.
    tight: f64,
    /// A residual that still counts as closed.
    loose: f64,
    /// The residual before the last round.
    before: f64,
    rounds: u32,
}

impl ClosingLimits {
    /// Before the first round; `epsilon`: relative distance of neighbours.
    pub fn new(epsilon: f64) -> ClosingLimits {
        ClosingLimits {
            tight: 8.0 * epsilon,
            loose: 1e4 * epsilon,
            before: f64::INFINITY,
            rounds: 0,
        }
    }

    /// The rounds considered so far.
    pub fn rounds(&self) -> u32 {
        self.rounds
    }

    /// Verdict on the largest residual of a round: closed, not yet, or never.
    pub fn look(&mut self, gap: f64) -> Option<bool> {
        self.rounds += 1;
        let stalled = gap >= 0.5 * self.before && gap <= self.loose;
        if gap <= self.tight || stalled {
            return Some(true);
        }
        self.before = gap;
        (self.rounds < NEWTON_STEPS && gap.is_finite()).then_some(false)
    }
}

/// A model and the constraints from its loops.
pub struct LoopClosure<'a> {
    /// The model.
    pub model: &'a Model,
    /// The constraints of its loops.
    pub constraints: &'a LoopConstraints,
}

impl LoopClosure<'_> {
    /// Closes the loops of an initial state, and divides the joints there.
    ///
    /// # Errors
    ///
    /// [`StateError::OpenLoop`] and [`StateError::NotFinite`].
    pub fn start(&self, state: &mut MotionState) -> Result<Partition, StateError> {
        if self.constraints.rows() > 0 {
            // Where the joints called dependent close no loops, all move.
            let start = state.clone();
            if self.assemble(state, &[Nature::Dependent]).is_err() {
                *state = start;
                self.assemble(state, &[Nature::Dependent, Nature::Independent])?;
            }
        }
        // Only at a closed position do rows that say the same look the same.
        let partition = self.divide(state);
        self.close(state, &partition)?;
        Ok(partition)
    }

    /// Divides the joints into independent and dependent ones.
    pub fn divide(&self, state: &MotionState) -> Partition {
        let jacobian = self.constraints.evaluate(state).1;
        // A pivot below this fraction of the largest one counts as zero.
        let threshold = self.constraints.epsilon().sqrt();
        Partition::new(self.model, &jacobian, threshold)
    }

    /// A residual that still counts as closed.
    fn loose(&self) -> f64 {
        ClosingLimits::new(self.constraints.epsilon()).loose
    }

    /// Moves dependent joints until loops close, with consistent velocities.
    ///
    /// # Errors
    ///
    /// [`StateError::OpenLoop`] and [`StateError::NotFinite`].
    pub fn close(&self, state: &mut MotionState, partition: &Partition) -> Result<(), StateError> {
        self.close_in_rounds(state, partition).map(|_| ())
    }

    /// As [`LoopClosure::close`]; the evaluations of constraints that it took.
    pub fn close_in_rounds(
        &self,
        state: &mut MotionState,
        partition: &Partition,
    ) -> Result<u32, StateError> {
        if self.constraints.rows() == 0 {
            return Ok(0);
        }
        let (jacobian, rounds) = self.close_positions(state, partition)?;
        self.close_velocities(state, partition, &jacobian)?;
        Ok(rounds)
    }

    /// Gives dependent joints the velocities that keep loops closed.
    fn close_velocities(
        &self,
        state: &mut MotionState,
        partition: &Partition,
        jacobian: &DenseMatrix,
    ) -> Result<(), StateError> {
        let dependent = jacobian.select(&partition.rows, &partition.dependent);
        let mut others = state.qd.clone();
        for &joint in &partition.dependent {
            others[joint] = 0.0;
        }
        let right: Vec<f64> = partition
            .rows
            .iter()
            .map(|&row| -dot(jacobian.row(row), &others))
            .collect();
        let Some(velocities) = solve_square(dependent, column(&right)) else {
            return Err(self.open(state, &self.constraints.evaluate(state).0));
        };
        for (place, &joint) in partition.dependent.iter().enumerate() {
            state.qd[joint] = velocities[(place, 0)];
        }
        Ok(())
    }

    /// Newton's method; the Jacobian at the closed position.
    fn close_positions(
        &self,
        state: &mut MotionState,
        partition: &Partition,
    ) -> Result<(DenseMatrix, u32), StateError> {
        let mut limits = ClosingLimits::new(self.constraints.epsilon());
        loop {
            let (residual, jacobian) = self.constraints.evaluate(state);
            match limits.look(largest(&residual)) {
                Some(true) => return Ok((jacobian, limits.rounds())),
                Some(false) => {}
                None => return Err(self.not_closed(state, partition, &residual)),
            }
            if !self.newton(state, partition, &residual, &jacobian) {
                return Err(self.open(state, &residual));
            }
        }
    }

    /// One round of Newton's method; false where loops are not determined.
    fn newton(
        &self,
        state: &mut MotionState,
        partition: &Partition,
        residual: &[f64],
        jacobian: &DenseMatrix,
    ) -> bool {
        assert_eq!(
            residual.len(),
            jacobian.rows(),
            "one residual per row of the Jacobian"
        );
        let right: Vec<f64> = partition.rows.iter().map(|&row| -residual[row]).collect();
        let square = jacobian.select(&partition.rows, &partition.dependent);
        let Some(step) = solve_square(square, column(&right)) else {
            return false;
        };
        for (place, &joint) in partition.dependent.iter().enumerate() {
            state.q[joint] += step[(place, 0)];
        }
        true
    }

    /// The target of stabilisation: dependent joints moved by one iteration of
    /// Newton's method, with the velocities that loops require at present.
    ///
    /// # Errors
    ///
    /// [`StateError::OpenLoop`] where dependent joints determine no loops.
    pub fn nearest(
        &self,
        state: &MotionState,
        partition: &Partition,
    ) -> Result<MotionState, StateError> {
        let mut near = state.clone();
        if self.constraints.rows() > 0 {
            let (residual, jacobian) = self.constraints.evaluate(state);
            self.close_velocities(&mut near, partition, &jacobian)?;
            if !self.newton(&mut near, partition, &residual, &jacobian) {
                return Err(self.open(state, &residual));
            }
        }
        Ok(near)
    }

    /// Moves the joints of some natures, as little as possible, until the loops
    /// are closed: steps of least squares (Levenberg), with equal rows, too.
    fn assemble(&self, state: &mut MotionState, natures: &[Nature]) -> Result<(), StateError> {
        let movable: Vec<usize> = (0..self.model.joints.len())
            .filter(|&joint| natures.contains(&self.model.joints[joint].nature))
            .collect();
        let all_rows: Vec<usize> = (0..self.constraints.rows()).collect();
        let mut damping = 1e-3;
        let (mut residual, mut jacobian) = self.constraints.evaluate(state);
        for _ in 0..ASSEMBLY_STEPS {
            if largest(&residual) <= self.loose() {
                return Ok(());
            }
            let moving = jacobian.select(&all_rows, &movable);
            let mut normal = moving.product(&moving.transposed());
            let scale = (0..all_rows.len()).fold(1e-30, |most, i| normal[(i, i)].max(most));
            for row in 0..all_rows.len() {
                normal[(row, row)] += damping * scale;
            }
            let right = residual.iter().map(|h| -h).collect();
            let mut tried = state.clone();
            if let Ok(multipliers) = solve_positive(normal, right, 0.0) {
                let step = moving.transposed_times(&multipliers);
                for (&joint, step) in movable.iter().zip(step) {
                    tried.q[joint] += step;
                }
            }
            let (next, next_jacobian) = self.constraints.evaluate(&tried);
            if dot(&next, &next) < dot(&residual, &residual) {
                *state = tried;
                (residual, jacobian) = (next, next_jacobian);
                damping = (damping * 0.2).max(1e-14);
            } else {
                damping *= 4.0;
                if damping > 1e12 {
                    break;
                }
            }
        }
        if largest(&residual) <= self.loose() {
            return Ok(());
        }
        Err(self.open(state, &residual))
    }

    /// The error of dependent joints that do not close the loops.
    fn not_closed(
        &self,
        state: &MotionState,
        partition: &Partition,
        residual: &[f64],
    ) -> StateError {
        let taken = |row: &usize| partition.rows.binary_search(row).is_ok();
        let (taken, left): (Vec<usize>, Vec<usize>) = (0..residual.len()).partition(taken);
        let is_closed = |row: &usize| residual[*row].abs() <= self.loose();
        match left.iter().find(|row| !is_closed(row)) {
            Some(&row) if taken.iter().all(is_closed) => StateError::Overdetermined {
                cut: self.model.cuts[self.constraints.cut_of(row)].name.clone(),
                time: state.time,
            },
            _ => self.open(state, residual),
        }
    }

    /// The error of the cut with the largest residual.
    fn open(&self, state: &MotionState, residual: &[f64]) -> StateError {
        let gaps = residual.iter().map(|h| h.abs()).enumerate();
        let worst = gaps.max_by(|a, b| a.1.total_cmp(&b.1));
        let (row, gap) = worst.expect("a loop that is open has a residual");
        if !gap.is_finite() {
            return StateError::NotFinite {
                what: "the residual of a loop".to_owned(),
                time: state.time,
            };
        }
        let cut = &self.model.cuts[self.constraints.cut_of(row)];
        // The row of a rod is half the difference of the squares.
        let (gap, rod) = if let CutKind::Rod(length) = cut.kind {
            let distance = (2.0 * residual[row] + length * length).max(0.0).sqrt();
            (2.0 * gap / (distance + length), true)
        } else {
            (gap, false)
        };
        StateError::OpenLoop {
            cut: cut.name.clone(),
            gap,
            rod,
            time: state.time,
        }
    }
}

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

    /// Relative distance of neighbouring numbers: twice the unit roundoff.
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
