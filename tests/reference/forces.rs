//! Forces of links and external forces, as they add to `frc` and `trq`.

use super::kinematics::{anchor, frames, point};
use super::spatial::*;
use super::{Real, State, Tree};
use robovec::model::Model;

/// The length of each link and its rate.
pub(crate) fn link_lengths<T: Real>(model: &Model, state: &State<T>) -> Vec<(T, T)> {
    let tree = Tree::new(model);
    let frames = frames(&tree, state, zeros());
    let measure = |link: &robovec::model::Link| {
        let [a, b] = link.ends.each_ref().map(|end| {
            let (joint, place) = anchor(model, end);
            point(&tree, &frames, joint, place)
        });
        let (span, rate) = (sub(b.position, a.position), sub(b.velocity, a.velocity));
        let length = dot(span, span).root();
        (length, dot(span, rate) / length)
    };
    model.links.iter().map(measure).collect()
}

/// Adds the forces of links that pull their ends together with the given
/// strengths.
pub(crate) fn add_links<T: Real>(model: &Model, state: &State<T>, strengths: &[T]) -> State<T> {
    let tree = Tree::new(model);
    let frames = frames(&tree, state, zeros());
    let mut result = state.clone();
    for (link, &strength) in model.links.iter().zip(strengths) {
        let ends = link.ends.each_ref().map(|end| anchor::<T>(model, end));
        let [a, b] = ends.map(|(joint, place)| point(&tree, &frames, joint, place).position);
        let span = sub(b, a);
        let pull = scale(strength / dot(span, span).root(), span);
        for ((joint, place), force) in ends.into_iter().zip([pull, pull.map(|x| -x)]) {
            let Some(joint) = joint else { continue };
            let local = apply(&frames[joint].rotation, force);
            let arm = sub(place, tree.links[joint].center);
            result.frc[joint] = add(result.frc[joint], local);
            result.trq[joint] = add(result.trq[joint], cross(arm, local));
        }
    }
    result
}

/// Adds external forces. Each has nine numbers: force and torque in the base
/// frame, and the place of the force in the body's frame.
pub(crate) fn add_external<T: Real>(model: &Model, state: &State<T>, given: &[[T; 9]]) -> State<T> {
    let tree = Tree::new(model);
    let frames = frames(&tree, state, zeros());
    let mut result = state.clone();
    for (force, numbers) in model.forces.iter().zip(given) {
        let body = model.points[force.point].body;
        let Some(joint) = model.last_joint(body) else {
            continue;
        };
        let part = |from: usize| [0, 1, 2].map(|i| numbers[from + i]);
        let rotation = &frames[joint].rotation;
        let arm = sub(part(6), tree.links[joint].center);
        let local = apply(rotation, part(0));
        let torque = add(apply(rotation, part(3)), cross(arm, local));
        result.frc[joint] = add(result.frc[joint], local);
        result.trq[joint] = add(result.trq[joint], torque);
    }
    result
}
