//! Elements of a robot, whatever the format of the file.

use super::inertia::LinkInertial;
use crate::JointLaw;
use crate::rotation::FramePose;
use robovec_ir::diagnostic::clip;
use std::ops::Range;

/// A robot, its references by name resolved.
pub(super) struct RobotElements {
    pub(super) name: String,
    /// Acceleration of gravity in the frame of the root, m/s^2.
    pub(super) gravity: [f64; 3],
    pub(super) links: Vec<LinkElement>,
    pub(super) joints: Vec<JointElement>,
    pub(super) closures: Vec<ClosureElement>,
    pub(super) frames: Vec<FrameElement>,
    /// Place where the robot's element begins.
    pub(super) place: Range<usize>,
}

pub(super) struct LinkElement {
    pub(super) name: String,
    pub(super) inertial: Option<LinkInertial>,
    pub(super) place: Range<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum RobotJointKind {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Planar,
    Floating,
    Ball,
}

impl RobotJointKind {
    /// True for motion about or along one axis.
    pub(super) fn has_axis(self) -> bool {
        match self {
            RobotJointKind::Revolute | RobotJointKind::Continuous | RobotJointKind::Prismatic => {
                true
            }
            RobotJointKind::Fixed
            | RobotJointKind::Planar
            | RobotJointKind::Floating
            | RobotJointKind::Ball => false,
        }
    }
}

pub(super) struct JointElement {
    pub(super) name: String,
    pub(super) kind: RobotJointKind,
    /// Links, by index.
    pub(super) parent: usize,
    pub(super) child: usize,
    /// Of the joint's frame in the parent's.
    pub(super) origin: FramePose,
    /// Of length one, in the joint's frame.
    pub(super) axis: [f64; 3],
    /// Pose of the child in the frame that the joint moves.
    pub(super) after: FramePose,
    /// Initial positions: one, or those of translations, yaw, pitch and roll.
    pub(super) initial: [f64; 6],
    pub(super) limits: Option<[f64; 2]>,
    /// True for a joint that a motor moves.
    pub(super) actuated: bool,
    pub(super) law: JointLaw,
    /// Of the rotor, as the joint feels it.
    pub(super) armature: f64,
    pub(super) mimic: Option<MimicElement>,
    pub(super) place: Range<usize>,
    pub(super) child_place: Range<usize>,
}

impl JointElement {
    /// A joint between two links, whose frames coincide while it is at zero.
    pub(super) fn new(name: String, kind: RobotJointKind, [parent, child]: [usize; 2]) -> Self {
        JointElement {
            name,
            kind,
            parent,
            child,
            origin: FramePose::HERE,
            axis: [1.0, 0.0, 0.0],
            after: FramePose::HERE,
            initial: [0.0; 6],
            limits: None,
            actuated: false,
            law: JointLaw::default(),
            armature: 0.0,
            mimic: None,
            place: 0..0,
            child_place: 0..0,
        }
    }
}

/// Two places that a loop keeps together, or two frames.
pub(super) struct ClosureElement {
    pub(super) name: String,
    /// True where the frames coincide, false where their origins do.
    pub(super) is_solid: bool,
    /// Links, by index, with the poses on them.
    pub(super) ends: [(usize, FramePose); 2],
}

pub(super) struct FrameElement {
    pub(super) name: String,
    pub(super) link: usize,
    pub(super) pose: FramePose,
}

/// Joint whose motion another one follows.
pub(super) struct MimicElement {
    pub(super) leader: String,
    pub(super) factor: f64,
    pub(super) offset: f64,
    pub(super) place: Range<usize>,
}

pub(super) fn joint_title(name: &str) -> String {
    format!("joint '{}'", clip(name))
}
