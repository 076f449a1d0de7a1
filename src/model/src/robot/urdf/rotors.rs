//! Rotors of motors: the inertia that a joint feels through its gear.
//!
//! A file gives it as `armature` of `dynamics`, or as Drake does, by rotor and
//! gear in a transmission:
//!
//! ```text
//! <transmission name="t"><joint name="hinge"/><actuator name="motor">
//!   <drake:rotor_inertia value="1e-5"/><drake:gear_ratio value="100"/>
//! </actuator></transmission>
//! ```

use crate::robot::attributes::{name, place_of, required};
use crate::robot::elements::{JointElement, joint_title};
use crate::xml::Messages;
use robovec_ir::diagnostic::clip;
use roxmltree::Node;

/// Adds the rotors of transmissions to the joints they move.
pub(super) fn add<'a>(
    transmissions: impl Iterator<Item = Node<'a, 'a>>,
    joints: &mut [JointElement],
    messages: &mut Messages,
) {
    for transmission in transmissions {
        let find = |tag: &str| {
            let mut all = transmission.descendants();
            all.find(|node| node.tag_name().name() == tag)
        };
        let (Some(rotor), Some(joint)) = (find("rotor_inertia"), find("joint")) else {
            continue;
        };
        let title = "the rotor of a transmission";
        let inertia = required(rotor, "value", title, messages);
        let ratio = match find("gear_ratio") {
            Some(gear) => required(gear, "value", "the gear of a transmission", messages),
            None => 1.0,
        };
        let Some(moved) = name(joint, "name", "the joint of a transmission", messages) else {
            continue;
        };
        let Some(moved) = joints.iter_mut().find(|joint| joint.name == moved) else {
            messages.error(
                place_of(joint, "name"),
                &format!(
                    "a transmission moves {}, which is not there",
                    joint_title(&moved)
                ),
                "no joint of the robot",
                "name a joint of the robot, or remove the transmission",
            );
            continue;
        };
        if !moved.kind.has_axis() || inertia < 0.0 {
            messages.warn(
                place_of(rotor, "value"),
                &format!("{title} is left out: {}", clip(&moved.name)),
                "passed over",
                "an inertia is positive, and its joint moves about or along one axis",
            );
            continue;
        }
        moved.armature += inertia * ratio * ratio;
    }
}
