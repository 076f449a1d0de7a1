//! The joints of a body, in series.

use super::{Inner, JOINTS, MjcfReader};
use crate::JointLaw;
use crate::robot::attributes::place_of;
use crate::robot::elements::{JointElement, RobotJointKind, joint_title};
use crate::rotation::{FramePose, Rotation3, scaled, unit};
use robovec_ir::diagnostic::clip;

/// The link before a joint, and the pose of the body's frame on it.
pub(super) type BeforeJoint = (usize, FramePose);

impl<'a> MjcfReader<'a, '_> {
    /// Adds a joint and the link it moves; `pose` is the body's on its parent.
    pub(super) fn joint(
        &mut self,
        joint: &Inner<'a>,
        link_name: String,
        (parent, base): BeforeJoint,
        pose: &FramePose,
    ) -> BeforeJoint {
        let node = joint.node;
        let class = self
            .defaults
            .class(node, "class", joint.class, self.messages);
        let name = self.name(JOINTS, node, "joint");
        let at = place_of(node, "name");
        let Some(kind) = self.kind(joint, class, &name) else {
            return self.fixed(link_name, at, (parent, base));
        };
        let child = self.link(link_name, at.clone(), FramePose::HERE);
        let mut element = JointElement {
            place: at.clone(),
            child_place: at,
            ..JointElement::new(name.clone(), kind, [parent, child])
        };
        let given = self.vector(node, class, "pos", [0.0; 3]);
        let anchor = match kind {
            // Its place has no effect on the motion.
            RobotJointKind::Prismatic => [0.0; 3],
            _ => joint.frame.then(&FramePose::at(given)).origin,
        };
        let around = FramePose::at(anchor);
        let back = FramePose::at(scaled(anchor, -1.0));
        match kind {
            RobotJointKind::Floating => {
                if parent != 0 {
                    self.messages.error(
                        element.place.clone(),
                        &format!("{} is free inside of another body", joint_title(&name)),
                        "only bodies of the world move freely",
                        "move the body into `worldbody`",
                    );
                }
                let [x, y, z] = pose.origin;
                let [yaw, pitch, roll] = pose.rotation.yaw_pitch_roll();
                element.initial = [x, y, z, yaw, pitch, roll];
            }
            RobotJointKind::Ball => {
                element.origin = base.then(&around);
                element.after = back;
            }
            _ => {
                let given = self.vector(node, class, "axis", [0.0, 0.0, 1.0]);
                let axis = unit(joint.frame.rotation.apply(given)).unwrap_or_else(|| {
                    self.messages.error(
                        place_of(node, "axis"),
                        &format!("the axis of {} has no length", joint_title(&name)),
                        "this axis",
                        "write a direction, such as \"0 0 1\"",
                    );
                    [0.0, 0.0, 1.0]
                });
                let position = self.number(node, class, "ref").unwrap_or(0.0);
                let (position, start) = match kind {
                    RobotJointKind::Prismatic => (position, scaled(axis, -position)),
                    _ => (self.settings.angle(position), [0.0; 3]),
                };
                let turned = match kind {
                    RobotJointKind::Prismatic => Rotation3::IDENTITY,
                    _ => Rotation3::about_direction(axis, -position),
                };
                // A position of `ref` leaves the body where the file has it.
                element.origin = base.then(&around).then(&FramePose {
                    rotation: turned,
                    origin: start,
                });
                element.after = back;
                element.axis = axis;
                element.initial[0] = position;
                element.limits = self.limits(joint, class, kind);
            }
        }
        self.forces(joint, class, &mut element);
        self.joints.insert(name, self.robot.joints.len());
        self.robot.joints.push(element);
        (child, FramePose::HERE)
    }

    fn kind(&mut self, joint: &Inner<'a>, class: usize, name: &str) -> Option<RobotJointKind> {
        if joint.node.tag_name().name() == "freejoint" {
            return Some(RobotJointKind::Floating);
        }
        let holder = self.defaults.holder(joint.node, class, "type");
        let text = holder.and_then(|node| node.attribute("type"));
        Some(match text.map(str::trim) {
            None | Some("hinge") => RobotJointKind::Continuous,
            Some("slide") => RobotJointKind::Prismatic,
            Some("ball") => RobotJointKind::Ball,
            Some("free") => RobotJointKind::Floating,
            Some(other) => {
                self.messages.error(
                    place_of(joint.node, "type"),
                    &format!(
                        "{} has an unknown type: '{}'",
                        joint_title(name),
                        clip(other)
                    ),
                    "this type",
                    "write hinge, slide, ball or free",
                );
                return None;
            }
        })
    }

    fn limits(
        &mut self,
        joint: &Inner<'a>,
        class: usize,
        kind: RobotJointKind,
    ) -> Option<[f64; 2]> {
        let range = self.numbers(joint.node, class, "range")?;
        let &[low, high] = range.as_slice() else {
            self.miscounted(joint.node, "range", range.len(), 2);
            return None;
        };
        let holder = self.defaults.holder(joint.node, class, "limited");
        let limited = match holder
            .and_then(|node| node.attribute("limited"))
            .map(str::trim)
        {
            Some("true") => true,
            Some("false") => false,
            _ => self.settings.autolimits,
        };
        let limits = match kind {
            RobotJointKind::Prismatic => [low, high],
            _ => [low, high].map(|angle| self.settings.angle(angle)),
        };
        (limited && limits[0] < limits[1]).then_some(limits)
    }

    /// The forces of a joint, and its rotor.
    fn forces(&mut self, joint: &Inner<'a>, class: usize, element: &mut JointElement) {
        let node = joint.node;
        if node.tag_name().name() == "freejoint" {
            return;
        }
        let mut value = |attribute: &str| {
            let value = self.number(node, class, attribute).unwrap_or(0.0);
            if value < 0.0 {
                self.messages.error(
                    place_of(node, attribute),
                    &format!(
                        "the {attribute} of {} is negative",
                        joint_title(&element.name)
                    ),
                    "this value",
                    "it is zero or positive",
                );
            }
            value
        };
        let armature = value("armature");
        let [damping, friction, stiffness] = ["damping", "frictionloss", "stiffness"].map(value);
        let neutral = self.number(node, class, "springref").unwrap_or(0.0);
        if element.kind.has_axis() {
            element.armature = armature;
            element.law = JointLaw {
                damping,
                friction,
                stiffness,
                neutral: match element.kind {
                    RobotJointKind::Prismatic => neutral,
                    _ => self.settings.angle(neutral),
                },
            };
            return;
        }
        if element.kind == RobotJointKind::Floating {
            element.armature = armature;
        } else if armature != 0.0 {
            self.messages.error(
                place_of(node, "armature"),
                &format!("{} is a ball with an armature", joint_title(&element.name)),
                "only free joints and those of one axis have rotors",
                "write `armature=\"0\"` in the joint",
            );
        }
        if damping != 0.0 || friction != 0.0 || stiffness != 0.0 {
            self.messages.leave_out(
                element.place.clone(),
                &format!(
                    "the forces of {} are in no equation",
                    joint_title(&element.name)
                ),
                "damping, friction and springs of a joint of several axes",
                "add them to the forces of the joints",
            );
        }
    }
}
