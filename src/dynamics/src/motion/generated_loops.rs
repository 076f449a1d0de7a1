//! Loops closed by the generated functions of the whole step.
//!
//! `loop_positions` is one iteration of Newton's method and `loop_velocities`
//! gives the velocities, both for dependent joints that are fixed when they are
//! generated. So no exchange is possible near a dead point: a run whose loops
//! cannot be closed there ends, and reports the undetermined joint.

use super::MotionError;

use crate::kinematics::linear::largest;
use crate::kinematics::{ClosingLimits, CompiledFunction, LoopConstraints, MotionState, Partition};
use robovec_model::{Model, Nature};

/// Method that keeps loops closed in a run.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub enum LoopKeeping {
    /// Dependent joints are put onto the constraints in every evaluation.
    #[default]
    Project,
    /// All joints are integrated, and accelerations of dependent joints pull
    /// them back: `h'' + 2 rate h' + rate^2 h = 0` (Baumgarte, "Stabilization
    /// of constraints and integrals of motion in dynamical systems", 1972).
    Stabilise {
        /// 1/s.
        rate: f64,
    },
    /// All joints are integrated, and nothing pulls them back.
    Free,
}

/// Generated functions that close the loops of a model.
pub(super) struct GeneratedLoops {
    positions: CompiledFunction,
    velocities: CompiledFunction,
    /// Rows of the constraints that the functions solve.
    rows: Vec<usize>,
    /// Joints that they set.
    dependent: Vec<usize>,
    /// The relative distance of neighbours of the functions' numbers.
    epsilon: f64,
}

impl GeneratedLoops {
    /// `loop_positions` and `loop_velocities`, numbers with spacing `epsilon`.
    pub(super) fn new(
        [positions, velocities]: [CompiledFunction; 2],
        epsilon: f64,
    ) -> GeneratedLoops {
        let sorted = |name: &str| {
            let mut places = positions.assigned(name);
            places.sort_unstable();
            places
        };
        GeneratedLoops {
            rows: sorted("h"),
            dependent: sorted("q"),
            positions,
            velocities,
            epsilon,
        }
    }

    /// The roles of joints in these functions.
    pub(super) fn partition(&self, model: &Model) -> Partition {
        let of = |driven: bool| {
            let joints = model.joints.iter().enumerate();
            joints.filter(move |(_, joint)| (joint.nature == Nature::Driven) == driven)
        };
        let free = of(false).map(|(index, _)| index);
        let named = of(false).filter(|(_, joint)| joint.nature == Nature::Dependent);
        Partition {
            independent: free
                .filter(|index| self.dependent.binary_search(index).is_err())
                .collect(),
            dependent: self.dependent.clone(),
            driven: of(true).map(|(index, _)| index).collect(),
            rows: self.rows.clone(),
            chosen: named
                .map(|(index, _)| index)
                .ne(self.dependent.iter().copied()),
        }
    }

    /// Puts dependent joints onto the constraints; the rounds, or a dead point.
    pub(super) fn close(
        &self,
        model: &Model,
        constraints: &LoopConstraints,
        state: &mut MotionState,
    ) -> Result<u32, MotionError> {
        let mut limits = ClosingLimits::new(self.epsilon);
        loop {
            let outputs = self.positions.evaluate(state);
            let gap = largest(&outputs.vector("h", constraints.rows()));
            match limits.look(gap) {
                Some(true) => break,
                Some(false) => {
                    outputs.take_joints("q", &mut state.q);
                }
                None => return Err(self.dead_point(model, constraints, state)),
            }
            if !largest(&state.q).is_finite() {
                return Err(self.dead_point(model, constraints, state));
            }
        }
        self.set_velocities(state);
        if !largest(&state.qd).is_finite() {
            return Err(self.dead_point(model, constraints, state));
        }
        Ok(limits.rounds())
    }

    /// The state with dependent joints moved by an iteration, and velocities.
    pub(super) fn nearest(&self, state: &MotionState) -> MotionState {
        let mut near = state.clone();
        self.set_velocities(&mut near);
        let outputs = self.positions.evaluate(state);
        outputs.take_joints("q", &mut near.q);
        near
    }

    fn set_velocities(&self, state: &mut MotionState) {
        let outputs = self.velocities.evaluate(state);
        outputs.take_joints("qd", &mut state.qd);
    }

    /// The error that names the joint least determined, and its cut.
    pub(super) fn dead_point(
        &self,
        model: &Model,
        constraints: &LoopConstraints,
        state: &MotionState,
    ) -> MotionError {
        let (residual, jacobian) = constraints.evaluate(state);
        if !largest(&residual).is_finite() {
            return MotionError::not_finite("the residual of a loop", state.time);
        }
        // Functions without dependent joints close nothing.
        let Some(weakest) = self.partition(model).weakest(&jacobian) else {
            return MotionError::not_finite("the residual of a loop", state.time);
        };
        MotionError::DeadPoint {
            joint: model.joints[weakest.column].name.clone(),
            cut: model.cuts[constraints.cut_of(weakest.row)].name.clone(),
            pivot: weakest.size,
            gap: largest(&residual),
            time: state.time,
        }
    }
}
