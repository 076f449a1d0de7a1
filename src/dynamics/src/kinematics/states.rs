//! Random states of a model with closed loops.

use super::{LoopClosure, MotionState};
use robovec_model::{Model, Nature};
use robovec_num::random::Random;

/// Maximum distance of drawn joints from their start, m or rad.
const REACH: f64 = 0.2;

/// Maximum number of times a state is drawn again, ever nearer to the start.
const ATTEMPTS: i32 = 20;

/// Random states around the closed initial one, with random forces. Positions
/// of joints are drawn near their start, and the loops closed again. Empty
/// where the loops do not close; a state that is not found is left out.
pub fn closed_states(loops: &LoopClosure<'_>, count: usize, seed: u64) -> Vec<MotionState> {
    let mut start = MotionState::initial(loops.model);
    let Ok(partition) = loops.start(&mut start) else {
        return Vec::new();
    };
    let mut random = Random::new(seed);
    let drawn = (0..count).filter_map(|_| {
        (0..ATTEMPTS).find_map(|attempt| {
            let reach = REACH * 0.5f64.powi(attempt);
            let mut state = drawn(loops.model, &start, reach, &mut random);
            loops.close(&mut state, &partition).ok().map(|()| state)
        })
    });
    drawn.collect()
}

/// A state around another one: positions of joints within `reach`, everything
/// else within one.
fn drawn(model: &Model, start: &MotionState, reach: f64, random: &mut Random) -> MotionState {
    let mut state = start.clone();
    for (joint, description) in model.joints.iter().enumerate() {
        // Dependent joints only start to be closed from here.
        if description.nature != Nature::Dependent {
            state.q[joint] += reach * random.signed();
            state.qd[joint] = random.signed();
            state.qdd[joint] = random.signed();
        }
        state.joint_forces[joint] = random.signed();
        state.frc[joint] = [(); 3].map(|()| random.signed());
        state.trq[joint] = [(); 3].map(|()| random.signed());
    }
    state
}
