//! Links and joints in the order from the base.

use super::elements::{RobotElements, joint_title};
use crate::xml::{Messages, diagnostic, second};
use robovec_ir::diagnostic::{Label, clip};
use robovec_num::limits::Amount;
use robovec_robotran::conventions::JOINTS;

pub(super) struct RobotOrder {
    /// The link that is attached to nothing.
    pub(super) root: usize,
    /// The joints such that each is after the one its parent is attached to: a
    /// branch as a whole before the next one, in the order of the file.
    pub(super) joints: Vec<usize>,
}

/// The order of the links; `None`, with errors, when they are no tree.
pub(super) fn order(robot: &RobotElements, messages: &mut Messages) -> Option<RobotOrder> {
    if messages.has_errors() {
        return None;
    }
    let mut parents: Vec<Option<usize>> = vec![None; robot.links.len()];
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); robot.links.len()];
    for (index, joint) in robot.joints.iter().enumerate() {
        match parents[joint.child] {
            None => parents[joint.child] = Some(index),
            Some(first) if messages.has_room() => messages.push_error(second(
                &format!(
                    "link '{}' has two parent joints",
                    clip(&robot.links[joint.child].name)
                ),
                joint.child_place.clone(),
                robot.joints[first].child_place.clone(),
                "URDF describes trees only: remove one of the joints; a loop can be closed as a cut in \
                 a .mbs model",
            )),
            Some(_) => messages.count_error(),
        }
        children[joint.parent].push(index);
    }
    if messages.has_errors() {
        return None;
    }
    let root = root(robot, &parents, messages)?;
    let mut joints = Vec::with_capacity(robot.joints.len());
    let mut pending: Vec<usize> = children[root].iter().rev().copied().collect();
    while let Some(joint) = pending.pop() {
        joints.push(joint);
        pending.extend(children[robot.joints[joint].child].iter().rev());
    }
    if joints.len() < robot.joints.len() {
        on_a_cycle(robot, &parents, &joints, messages);
        return None;
    }
    if !JOINTS.admits(Amount::Whole(joints.len() as u64)) {
        messages.error(
            robot.place.clone(),
            &format!("joints: {}", JOINTS.refusal(&joints.len().to_string())),
            "in this robot",
            "leave out what does not matter for the motion",
        );
        return None;
    }
    Some(RobotOrder { root, joints })
}

/// The only link without a joint above it.
fn root(
    robot: &RobotElements,
    parents: &[Option<usize>],
    messages: &mut Messages,
) -> Option<usize> {
    let mut roots = (0..parents.len()).filter(|&link| parents[link].is_none());
    match (roots.next(), roots.next()) {
        (Some(root), None) => Some(root),
        (Some(one), Some(other)) => {
            let [one, other] = [one, other].map(|link| &robot.links[link]);
            messages.push_error(
                diagnostic(
                    other.place.clone(),
                    &format!(
                        "links '{}' and '{}' both have no parent",
                        clip(&one.name),
                        clip(&other.name)
                    ),
                    "a second base",
                    "a robot has one base: add a joint between them, for example a fixed one",
                )
                .with_label(Label::secondary(0, one.place.clone()).with_message("the first base")),
            );
            None
        }
        (None, _) if robot.links.is_empty() => {
            messages.error(
                robot.place.clone(),
                "the robot has no link",
                "nothing in this element",
                "add `<link name=\"base\"/>`",
            );
            None
        }
        (None, _) => {
            on_a_cycle(robot, parents, &[], messages);
            None
        }
    }
}

/// Reports a joint on a cycle, when some joints were not reached.
fn on_a_cycle(
    robot: &RobotElements,
    parents: &[Option<usize>],
    reached: &[usize],
    messages: &mut Messages,
) {
    let mut is_reached = vec![false; robot.joints.len()];
    for &joint in reached {
        is_reached[joint] = true;
    }
    let start = is_reached.iter().position(|reached| !reached);
    let start = start.expect("a joint was not reached");
    // Upwards from any of them one comes onto the cycle after as many steps as
    // there are joints at the most.
    let above = |joint: usize| parents[robot.joints[joint].parent];
    let mut joint = start;
    for _ in 0..robot.joints.len() {
        joint = above(joint).expect("what hangs on the root was reached");
    }
    let joint = &robot.joints[joint];
    messages.error(
        joint.place.clone(),
        &format!("{} is on a cycle", joint_title(&joint.name)),
        "its parent is connected to its child",
        "URDF describes trees only: one link must have no parent, and all others must follow from it",
    );
}
