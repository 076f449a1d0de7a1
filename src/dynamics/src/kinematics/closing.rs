//! Closing loops: positions and velocities of dependent joints.

use super::linear::{DenseMatrix, column, dot, largest, solve_positive, solve_square};
use super::{LoopConstraints, MotionState, Partition, StateError};
use robovec_model::{CutKind, Model, Nature};

/// Newton steps before giving up; from a predicted position three suffice.
const NEWTON_STEPS: u32 = 25;
/// Steps of the search for a closed position.
const ASSEMBLY_STEPS: usize = 200;

/// Ends of the rounds of Newton's method, in the numbers that residuals are
/// evaluated in.
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
    /// Before the first round; `epsilon` is the relative distance of
    /// neighbours of the numbers.
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

    /// Verdict on the largest residual of a round: closed, or not yet; `None`
    /// when there is no hope left.
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
            // Where the joints that the model calls dependent cannot close the
            // loops, all move.
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
        Partition::new(self.model, &jacobian, self.rank_threshold())
    }

    /// A residual that still counts as closed.
    fn loose(&self) -> f64 {
        ClosingLimits::new(self.constraints.epsilon()).loose
    }

    /// The fraction of the largest pivot that counts as zero in the Jacobian.
    fn rank_threshold(&self) -> f64 {
        self.constraints.epsilon().sqrt()
    }

    /// Moves the dependent joints until the loops are closed, and gives them
    /// consistent velocities.
    ///
    /// # Errors
    ///
    /// [`StateError::OpenLoop`] and [`StateError::NotFinite`].
    pub fn close(&self, state: &mut MotionState, partition: &Partition) -> Result<(), StateError> {
        self.close_in_rounds(state, partition).map(|_| ())
    }

    /// Does as [`LoopClosure::close`]; the evaluations of the constraints that
    /// it took.
    ///
    /// # Errors
    ///
    /// As in that state.
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

    /// Gives the dependent joints the velocities that keep the loops closed;
    /// the Jacobian is that of the state.
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

    /// One round of Newton's method; false where the dependent joints do not
    /// determine the loops.
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

    /// The state with the dependent joints moved by one iteration of Newton's
    /// method, and with the velocities that the loops require at their present
    /// positions: the target of stabilisation.
    ///
    /// # Errors
    ///
    /// [`StateError::OpenLoop`] where the dependent joints do not determine
    /// the loops.
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

    /// Moves the joints of some natures, as little as possible, until the
    /// loops are closed: steps of least squares (Levenberg's method). Unlike
    /// Newton's it does not mind equal rows.
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
