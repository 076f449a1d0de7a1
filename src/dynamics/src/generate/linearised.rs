//! The linear system near a state, `xd = A x + B u`, of the derivatives of
//! accelerations ([`super::sensitivity`]).
//!
//! The state `x` holds the positions of the joints that move freely, then their
//! velocities; `u` are the forces of all joints. Joints that loops determine
//! follow.

use super::algebra::Scalar;
use super::derivative::JointEntry;
use super::equations::Equations;
use super::frames::ModelFrames;
use super::parameters::ModelParameters;
use super::sensitivity::AccelerationDerivatives;
use super::{GenerateError, GenerationRequest, independent_joints};
use robovec_model::Model;

/// Writes `A` and `B`.
pub(super) fn write(
    equations: &mut Equations,
    frames: &ModelFrames<'_>,
    parameters: &ModelParameters<'_>,
    request: &GenerationRequest,
) -> Result<(), GenerateError> {
    let free = free_joints(frames.source, request)?;
    let derivatives = AccelerationDerivatives::new(equations, parameters, request)?;
    let count = free.len();
    let joint = |frame: usize| frames.joint(frame).expect("only joints have derivatives");
    let place = |frame: usize| free.binary_search(&joint(frame)).ok();
    let signed = |&(row, column, value): &JointEntry| {
        value.negated_if(frames.is_reversed(row) ^ frames.is_reversed(column))
    };
    // Velocities are the derivatives of positions.
    for state in 1..=count {
        equations.output("A", &[state, count + state], Scalar::ONE);
    }
    // The last element shows a reader how large an array is.
    let mut is_open = [true; 2];
    for (first, entries) in [
        (0, &derivatives.by_position),
        (count, &derivatives.by_velocity),
    ] {
        for entry in entries {
            if let (Some(row), Some(column)) = (place(entry.0), place(entry.1)) {
                let indices = [count + row + 1, first + column + 1];
                is_open[0] &= indices != [2 * count; 2];
                equations.output("A", &indices, signed(entry));
            }
        }
    }
    let joints = frames.source.joints.len();
    for entry in &derivatives.by_force {
        if let Some(row) = place(entry.0) {
            let indices = [count + row + 1, joint(entry.1) + 1];
            is_open[1] &= indices != [2 * count, joints];
            equations.output("B", &indices, signed(entry));
        }
    }
    for (array, columns, is_open) in [("A", 2 * count, is_open[0]), ("B", joints, is_open[1])] {
        if is_open {
            equations.output(array, &[2 * count, columns], Scalar::ZERO);
        }
    }
    Ok(())
}

/// Numbers from 1 of the joints whose positions and velocities are the state.
pub(super) fn state(model: &Model, request: &GenerationRequest) -> Result<String, GenerateError> {
    let free = free_joints(model, request)?;
    let numbers: Vec<String> = free.iter().map(|joint| (joint + 1).to_string()).collect();
    Ok(numbers.join(" "))
}

fn free_joints(model: &Model, request: &GenerationRequest) -> Result<Vec<usize>, GenerateError> {
    let free = independent_joints(model, &request.options)?;
    if free.is_empty() {
        return Err(GenerateError::Motionless(model.name.clone()));
    }
    Ok(free)
}
