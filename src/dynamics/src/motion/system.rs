//! The differential equation of a model.
//!
//! The state of the integrator has all positions, all velocities and the work
//! done so far. Driven joints get the positions of their laws first, and so do
//! dependent joints where loops are projected ([`LoopKeeping`]).

use super::equations::EquationSetting;
use super::generated_loops::LoopKeeping;
use super::{Laws, MotionEquations, MotionError, energy};
use crate::kinematics::linear::largest;
use crate::kinematics::{LoopClosure, MotionState, Partition};
use robovec_model::{Model, Nature};

/// A model with its equations and the laws of its forces.
pub struct MultibodySystem<'m> {
    pub(super) model: &'m Model,
    pub(super) equations: MotionEquations,
    pub(super) laws: Laws,
    /// The positions that joints start from.
    pub(super) initial: Vec<f64>,
    /// The lengths of links, from the equations. Along one axis of the common
    /// frame they have the axis' sign, and keep it.
    pub(super) lengths: Vec<f64>,
    /// Places where springs hold the points of external forces.
    pub(super) places: Vec<[f64; 3]>,
    pub(super) partition: Partition,
    pub(super) keeping: LoopKeeping,
    pub(super) work: EvaluationWork,
    /// First time at which joints of generated functions near a dead point, s.
    weak_since: Option<f64>,
    /// Their side of a dead point.
    side: Option<i8>,
}

/// Evaluations of a run.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct EvaluationWork {
    /// Right-hand sides of the differential equation.
    pub slopes: u64,
    /// Rounds of Newton's method, each with the constraints of all loops.
    pub rounds: u64,
}

impl<'m> MultibodySystem<'m> {
    /// Makes a model's equations and closes its loops; also its initial state.
    pub fn new(
        model: &'m Model,
        laws: Laws,
        setting: &EquationSetting<'_>,
    ) -> Result<(MultibodySystem<'m>, MotionState), MotionError> {
        assert_eq!(
            (laws.joints.len(), laws.drives.len()),
            (model.joints.len(), model.joints.len()),
            "every joint has its laws"
        );
        assert_eq!(laws.links.len(), model.links.len(), "every link has a law");
        assert_eq!(
            laws.forces.len(),
            model.forces.len(),
            "every external force has a law"
        );
        let mut state = MotionState::initial(model);
        let mut system = MultibodySystem {
            model,
            equations: MotionEquations::new(model, setting)?,
            laws,
            initial: state.q.clone(),
            lengths: Vec::new(),
            places: Vec::new(),
            partition: Partition::default(),
            keeping: LoopKeeping::Project,
            work: EvaluationWork::default(),
            weak_since: None,
            side: None,
        };
        system.drive(&mut state);
        system.partition = system.loops().start(&mut state)?;
        if let Some(loops) = system.equations.generated_loops() {
            system.partition = loops.partition(model);
            system.renew(&state)?;
        }
        system.initial.clone_from(&state.q);
        let motions = energy::point_motions(model, &state).into_iter();
        let places = motions.zip(&system.laws.forces);
        let places = places.map(|(motion, law)| law.place.unwrap_or(motion.place));
        system.places = places.collect();
        let lengths = system.equations.link_lengths(&state);
        system.lengths = lengths.into_iter().map(|[length, _]| length).collect();
        Ok((system, state))
    }

    /// The laws of a model as [`MultibodySystem::settled_laws`] has them.
    pub fn settled(model: &'m Model, laws: Laws) -> Result<Laws, MotionError> {
        let (system, _) = MultibodySystem::new(model, laws, &EquationSetting::default())?;
        Ok(system.settled_laws())
    }

    /// The laws with every place that is by default the initial one as a
    /// number, so that they stay the same for another initial state.
    pub fn settled_laws(&self) -> Laws {
        let mut laws = self.laws.clone();
        for (law, &initial) in laws.joints.iter_mut().zip(&self.initial) {
            law.neutral.get_or_insert(initial);
        }
        for (law, length) in laws.links.iter_mut().zip(&self.lengths) {
            law.neutral.get_or_insert(length.abs());
        }
        for (law, &place) in laws.forces.iter_mut().zip(&self.places) {
            law.place.get_or_insert(place);
        }
        for (law, &initial) in laws.drives.iter_mut().zip(&self.initial) {
            law.offset.get_or_insert(initial);
        }
        // What a run looks out for moves nothing.
        laws.events.clear();
        laws
    }

    /// Initial lengths of links, m, with the sign of the common axis, if any.
    pub fn link_lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// The laws.
    pub fn laws(&self) -> &Laws {
        &self.laws
    }

    /// Sets the method of closing loops from now on.
    pub fn keep_loops(&mut self, keeping: LoopKeeping) {
        self.keeping = keeping;
    }

    /// The roles of the joints.
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    fn loops(&self) -> LoopClosure<'_> {
        LoopClosure {
            model: self.model,
            constraints: self.equations.constraints(),
        }
    }

    /// Puts driven joints at their positions for the state's time.
    fn drive(&self, state: &mut MotionState) {
        for (index, joint) in self.model.joints.iter().enumerate() {
            if joint.nature != Nature::Driven {
                continue;
            }
            let [q, qd, qdd] = if joint.has_velocity && joint.has_acceleration {
                self.laws.drives[index].at(state.time, joint.initial[0])
            } else {
                [joint.initial[0], 0.0, 0.0]
            };
            (state.q[index], state.qd[index], state.qdd[index]) = (q, qd, qdd);
        }
    }

    /// Positions, velocities and work, in the layout of the integrator.
    pub(super) fn pack(state: &MotionState, work: f64) -> Vec<f64> {
        let mut packed = state.q.clone();
        packed.extend_from_slice(&state.qd);
        packed.push(work);
        packed
    }

    /// The state of an integrator's numbers, driven and projected.
    pub(super) fn unpack(&mut self, time: f64, packed: &[f64]) -> Result<MotionState, MotionError> {
        let joints = self.model.joints.len();
        assert_eq!(
            packed.len(),
            2 * joints + 1,
            "positions, velocities and work"
        );
        if !largest(packed).is_finite() {
            return Err(MotionError::not_finite("a position or velocity", time));
        }
        let mut state = MotionState::initial(self.model);
        state.time = time;
        state.q.copy_from_slice(&packed[..joints]);
        state.qd.copy_from_slice(&packed[joints..2 * joints]);
        self.drive(&mut state);
        if self.keeping == LoopKeeping::Project {
            let rounds = match self.equations.generated_loops() {
                None => self.loops().close_in_rounds(&mut state, &self.partition)?,
                Some(loops) => loops.close(self.model, self.equations.constraints(), &mut state)?,
            };
            self.work.rounds += u64::from(rounds);
        }
        Ok(state)
    }

    /// The right-hand side of the differential equation.
    pub(super) fn slope(&mut self, time: f64, packed: &[f64]) -> Result<Vec<f64>, MotionError> {
        let mut state = self.unpack(time, packed)?;
        let mut motion = self.motion(&mut state)?;
        self.work.slopes += 1;
        if let LoopKeeping::Stabilise { rate } = self.keeping {
            self.stabilise(&state, rate, &mut motion.accelerations)?;
        }
        let mut slope = state.qd;
        slope.extend_from_slice(&motion.accelerations);
        slope.push(motion.power);
        assert_eq!(slope.len(), packed.len(), "every number has a slope");
        Ok(slope)
    }

    /// Adds the terms that return dependent joints to the constraints.
    fn stabilise(
        &mut self,
        state: &MotionState,
        rate: f64,
        accelerations: &mut [f64],
    ) -> Result<(), MotionError> {
        if self.partition.dependent.is_empty() {
            return Ok(());
        }
        let near = match self.equations.generated_loops() {
            None => self.loops().nearest(state, &self.partition)?,
            Some(loops) => loops.nearest(state),
        };
        self.work.rounds += 1;
        for &joint in &self.partition.dependent {
            let (away, faster) = (
                state.q[joint] - near.q[joint],
                state.qd[joint] - near.qd[joint],
            );
            accelerations[joint] -= rate * (2.0 * faster + rate * away);
        }
        Ok(())
    }

    /// Chooses other dependent joints when those in use have come near a dead
    /// point. Where they are fixed the first such time is remembered.
    ///
    /// # Errors
    ///
    /// [`MotionError::DeadPoint`] where fixed ones have moved past it: there
    /// the others have two possible positions, and the choice is undetermined.
    pub(super) fn renew(&mut self, state: &MotionState) -> Result<(), MotionError> {
        let constraints = self.equations.constraints();
        if constraints.rows() == 0 {
            return Ok(());
        }
        let jacobian = constraints.evaluate(state).1;
        let Some(loops) = self.equations.generated_loops() else {
            if !self.partition.holds(&jacobian) {
                self.partition = self.loops().divide(state);
            }
            return Ok(());
        };
        if !self.partition.holds(&jacobian) {
            self.weak_since.get_or_insert(state.time);
        }
        let side = self.partition.side(&jacobian);
        if *self.side.get_or_insert(side) != side {
            return Err(loops.dead_point(self.model, constraints, state));
        }
        Ok(())
    }

    /// The error of generated functions near a dead point; `None` elsewhere.
    pub(super) fn dead_point(&self, state: &MotionState) -> Option<MotionError> {
        let constraints = self.equations.constraints();
        let loops = self.equations.generated_loops()?;
        let jacobian = constraints.evaluate(state).1;
        let near = !self.partition.holds(&jacobian);
        near.then(|| loops.dead_point(self.model, constraints, state))
    }

    /// First time of joints of generated functions near a dead point, s.
    pub fn weak_since(&self) -> Option<f64> {
        self.weak_since
    }

    /// The largest residual of the constraints.
    pub fn gap(&self, state: &MotionState) -> f64 {
        largest(&self.equations.constraints().evaluate(state).0)
    }
}
