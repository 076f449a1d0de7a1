//! Joints that mimic others: each by the joint at the end of its leaders.

use super::elements::{RobotElements, joint_title};
use crate::xml::Messages;
use robovec_ir::diagnostic::suggestion;
use rustc_hash::FxHashMap;

/// A joint that follows: `factor` times the leader, plus `offset`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct ResolvedMimic {
    /// Index of the leader, which follows no other joint.
    pub(super) leader: usize,
    pub(super) factor: f64,
    pub(super) offset: f64,
}

/// For every joint, the joint that it follows.
pub(super) fn resolve(
    robot: &RobotElements,
    messages: &mut Messages,
) -> Vec<Option<ResolvedMimic>> {
    let numbers: FxHashMap<&str, usize> = robot
        .joints
        .iter()
        .enumerate()
        .map(|(index, joint)| (joint.name.as_str(), index))
        .collect();
    let direct: Vec<Option<ResolvedMimic>> = (0..robot.joints.len())
        .map(|joint| direct(robot, joint, &numbers, messages))
        .collect();
    let mut all = vec![None; direct.len()];
    for start in 0..direct.len() {
        let Some(mut found) = direct[start] else {
            continue;
        };
        let mut steps = 0;
        while let Some(next) = direct[found.leader] {
            found = ResolvedMimic {
                leader: next.leader,
                factor: found.factor * next.factor,
                offset: found.factor * next.offset + found.offset,
            };
            steps += 1;
            if steps > direct.len() {
                let joint = &robot.joints[start];
                let mimic = joint.mimic.as_ref().expect("it follows");
                messages.error(
                    mimic.place.clone(),
                    &format!("{} follows itself", joint_title(&joint.name)),
                    "by way of this joint",
                    "let one of the joints follow nobody",
                );
                return all;
            }
        }
        if !(found.factor.is_finite() && found.offset.is_finite()) {
            let joint = &robot.joints[start];
            let mimic = joint.mimic.as_ref().expect("it follows");
            messages.error(
                mimic.place.clone(),
                &format!(
                    "what {} follows with is not finite",
                    joint_title(&joint.name)
                ),
                "by way of this joint",
                "write smaller multipliers and offsets",
            );
        }
        all[start] = Some(found);
    }
    all
}

/// Whom a joint follows, as the file states it.
fn direct(
    robot: &RobotElements,
    joint: usize,
    numbers: &FxHashMap<&str, usize>,
    messages: &mut Messages,
) -> Option<ResolvedMimic> {
    let joint = &robot.joints[joint];
    let mimic = joint.mimic.as_ref()?;
    let title = joint_title(&joint.name);
    if !joint.kind.has_axis() {
        messages.warn(
            mimic.place.clone(),
            &format!("{title} has no position that could follow"),
            "passed over",
            "only revolute, continuous and prismatic joints follow others",
        );
        return None;
    }
    let found = numbers.get(mimic.leader.as_str()).copied();
    let (message, label, help) = match found {
        Some(leader) if robot.joints[leader].kind.has_axis() => {
            return Some(ResolvedMimic {
                leader,
                factor: mimic.factor,
                offset: mimic.offset,
            });
        }
        Some(_) => (
            format!("{title} follows a joint that has no position"),
            "this joint is fixed, floating or planar",
            "let it follow a revolute, continuous or prismatic joint".to_owned(),
        ),
        None => {
            let mut known: Vec<&str> = numbers.keys().copied().collect();
            known.sort_unstable();
            let help = suggestion(&mimic.leader, known)
                .unwrap_or_else(|| "name a joint of the robot".to_owned());
            (
                format!("{title} follows a joint that is not there"),
                "there is no joint of this name",
                help,
            )
        }
    };
    messages.error(mimic.place.clone(), &message, label, &help);
    None
}
