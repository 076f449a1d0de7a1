//! From links and joints to bodies: links that are fixed to each other are one.

use super::RobotBase;
use super::couplings::ResolvedMimic;
use super::elements::{ClosureElement, FrameElement, JointElement, RobotElements, RobotJointKind};
use super::frames::{self, AxisFrame};
use super::inertia::BodyInertia;
use super::tree::RobotOrder;
use crate::rotation::{FramePose, upright};
use crate::xml::Messages;
use crate::{
    Anchor, Axis, Body, Cut, CutKind, Joint, JointCoupling, JointKind, JointMounting, Model,
    ModelPoint, NamedFrame, Nature,
};
use robovec_num::limits::Amount;
use robovec_robotran::conventions::JOINTS;
use rustc_hash::FxHashSet;
use std::ops::Range;

/// A model, and the place of each body's name.
pub(super) struct BuiltRobot {
    pub(super) model: Model,
    pub(super) places: Vec<Range<usize>>,
}

/// Placement of a link: its body, and its pose on the body.
#[derive(Clone, Copy)]
struct LinkPlace {
    body: Option<usize>,
    pose: FramePose,
}

/// The joints of a free body: the names after its own, and the kinds.
const FREE: [(&str, JointKind); 6] = [
    ("x", JointKind::Prismatic(Axis::X)),
    ("y", JointKind::Prismatic(Axis::Y)),
    ("z", JointKind::Prismatic(Axis::Z)),
    ("yaw", JointKind::Revolute(Axis::Z)),
    ("pitch", JointKind::Revolute(Axis::Y)),
    ("roll", JointKind::Revolute(Axis::X)),
];

/// The joints of a body that moves in a plane.
const PLANAR: [(&str, JointKind); 3] = [
    ("x", JointKind::Prismatic(Axis::X)),
    ("y", JointKind::Prismatic(Axis::Y)),
    ("angle", JointKind::Revolute(Axis::Z)),
];

struct RobotBuilder<'r> {
    robot: &'r RobotElements,
    model: Model,
    places: Vec<Range<usize>>,
    inertias: Vec<BodyInertia>,
    /// The joint of the model for a joint of the robot, if there is one.
    numbers: Vec<Option<usize>>,
}

/// Builds the model of a robot; `None`, with an error, when it is too large.
pub(super) fn build(
    robot: &RobotElements,
    order: &RobotOrder,
    couplings: &[Option<ResolvedMimic>],
    base: RobotBase,
    messages: &mut Messages,
) -> Option<BuiltRobot> {
    assert_eq!(
        order.joints.len(),
        robot.joints.len(),
        "the order has every joint"
    );
    assert_eq!(
        couplings.len(),
        robot.joints.len(),
        "every joint follows another or none"
    );
    let mut builder = RobotBuilder {
        robot,
        model: Model {
            gravity: robot.gravity,
            ..Model::new(&robot.name)
        },
        places: Vec::new(),
        inertias: Vec::new(),
        numbers: vec![None; robot.joints.len()],
    };
    let here = LinkPlace {
        body: None,
        pose: FramePose::HERE,
    };
    let mut links = vec![here; robot.links.len()];
    if base == RobotBase::Floating {
        links[order.root] = builder.series(order.root, &here, "base", &FREE, Vec::new());
    }
    builder.weigh(order.root, &links[order.root]);
    for &index in &order.joints {
        let joint = &robot.joints[index];
        let before = links[joint.parent];
        let frame = LinkPlace {
            body: before.body,
            pose: before.pose.then(&joint.origin),
        };
        links[joint.child] = builder.joint(index, &frame);
        builder.weigh(joint.child, &links[joint.child]);
    }
    let count = builder.model.joints.len();
    if !JOINTS.admits(Amount::Whole(count as u64)) {
        messages.error(
            robot.place.clone(),
            &format!("joints: {}", JOINTS.refusal(&count.to_string())),
            "in this robot",
            "leave out what does not matter for the motion",
        );
        return None;
    }
    builder.couple(couplings);
    let points = builder.model.points.iter();
    let mut taken: FxHashSet<_> = points
        .map(|point| (point.body, point.name.clone()))
        .collect();
    for closure in &robot.closures {
        builder.close(closure, &links, &mut taken);
    }
    let frame = |frame: &FrameElement| {
        let place = links[frame.link];
        let pose = place.pose.then(&frame.pose);
        NamedFrame {
            name: frame.name.clone(),
            body: place.body,
            origin: pose.origin,
            rotation: pose.rotation.0,
        }
    };
    builder.model.frames = robot.frames.iter().map(frame).collect();
    Some(builder.finish())
}

impl RobotBuilder<'_> {
    /// Adds the mass of a link to its body; the base does not move.
    fn weigh(&mut self, link: usize, place: &LinkPlace) {
        if let (Some(body), Some(inertial)) = (place.body, &self.robot.links[link].inertial) {
            let inertia = BodyInertia::of_link(inertial, &place.pose);
            self.inertias[body] = self.inertias[body].with(&inertia);
        }
    }

    /// Place of a joint's child from the place of its frame.
    fn joint(&mut self, index: usize, frame: &LinkPlace) -> LinkPlace {
        let robot = self.robot;
        let joint = &robot.joints[index];
        match joint.kind {
            RobotJointKind::Fixed => *frame,
            RobotJointKind::Floating => {
                let turns = frame.pose.rotation.turns();
                let place = self.series(joint.child, frame, &joint.name, &FREE, turns);
                self.start(&joint.initial);
                self.turn_rotors(joint.armature);
                place
            }
            RobotJointKind::Ball => {
                let turns = frame.pose.rotation.turns();
                let mut place = self.series(joint.child, frame, &joint.name, &FREE[3..], turns);
                self.start(&joint.initial[..3]);
                place.pose = joint.after;
                place
            }
            RobotJointKind::Planar => {
                let upright = upright(joint.axis);
                let rotation = frame.pose.rotation.then(&upright);
                let mut place =
                    self.series(joint.child, frame, &joint.name, &PLANAR, rotation.turns());
                place.pose.rotation = upright.inverse();
                place
            }
            RobotJointKind::Revolute | RobotJointKind::Continuous | RobotJointKind::Prismatic => {
                self.numbers[index] = Some(self.model.joints.len());
                self.single(joint, frame)
            }
        }
    }

    /// A body on one joint, turned from the body before as the axis needs.
    fn single(&mut self, joint: &JointElement, frame: &LinkPlace) -> LinkPlace {
        let AxisFrame {
            mounting,
            axis,
            rotation,
        } = frames::of_axis(frame.pose.rotation.apply(joint.axis));
        let kind = match joint.kind {
            RobotJointKind::Prismatic => JointKind::Prismatic(axis),
            _ => JointKind::Revolute(axis),
        };
        let one = Joint {
            initial: [joint.initial[0], 0.0, 0.0],
            actuated: joint.actuated,
            limits: joint.limits,
            law: joint.law,
            armature: joint.armature,
            ..plain(joint.name.clone(), kind, mounting)
        };
        let body = self.body(joint.child, frame, &joint.name, vec![one]);
        LinkPlace {
            body: Some(body),
            pose: FramePose {
                rotation: rotation.inverse().then(&frame.pose.rotation),
                origin: [0.0; 3],
            }
            .then(&joint.after),
        }
    }

    /// Adds a rotor to each direction of the free body that was added last.
    /// They turn as the body does: equal moments have no gyroscopic effect.
    fn turn_rotors(&mut self, armature: f64) {
        let body = self.model.bodies.last().expect("it was added");
        for joint in &mut self.model.joints[body.joints.clone()][..3] {
            joint.armature = armature;
        }
        let inertia = self.inertias.last_mut().expect("every body has one");
        for moment in [0, 3, 5] {
            inertia.inertia[moment] += armature;
        }
    }

    /// Sets the initial positions of the joints that were added last.
    fn start(&mut self, positions: &[f64]) {
        let count = self.model.joints.len();
        let last = &mut self.model.joints[count - positions.len()..];
        for (joint, &position) in last.iter_mut().zip(positions) {
            joint.initial[0] = position;
        }
    }

    /// A body on several joints, whose frame is the link's own.
    fn series(
        &mut self,
        link: usize,
        frame: &LinkPlace,
        name: &str,
        kinds: &[(&str, JointKind)],
        mut turns: Vec<crate::ConstantTurn>,
    ) -> LinkPlace {
        let joints = kinds
            .iter()
            .map(|&(suffix, kind)| {
                let mounting = JointMounting {
                    turns: std::mem::take(&mut turns),
                    reversed: false,
                };
                plain(format!("{name}_{suffix}"), kind, mounting)
            })
            .collect();
        LinkPlace {
            body: Some(self.body(link, frame, name, joints)),
            pose: FramePose::HERE,
        }
    }

    /// Adds a body with its joints at the origin of a frame.
    fn body(&mut self, link: usize, on: &LinkPlace, name: &str, joints: Vec<Joint>) -> usize {
        let link = &self.robot.links[link];
        let index = self.model.bodies.len();
        let point = (on.pose.origin != [0.0; 3]).then(|| {
            self.model.points.push(ModelPoint {
                name: name.to_owned(),
                body: on.body,
                coordinates: on.pose.origin,
            });
            self.model.points.len() - 1
        });
        let start = self.model.joints.len();
        self.model
            .joints
            .extend(joints.into_iter().map(|joint| Joint {
                body: index,
                ..joint
            }));
        self.model.bodies.push(Body {
            name: link.name.clone(),
            parent: on.body,
            point,
            joints: start..self.model.joints.len(),
            mass: 0.0,
            center: [0.0; 3],
            inertia: [0.0; 6],
        });
        self.places.push(link.place.clone());
        self.inertias.push(BodyInertia::NONE);
        index
    }

    /// Adds the cut of a loop; `taken` are the names of points by their bodies.
    fn close(
        &mut self,
        closure: &ClosureElement,
        links: &[LinkPlace],
        taken: &mut FxHashSet<(Option<usize>, String)>,
    ) {
        let ends = closure.ends.map(|(link, pose)| {
            let place = links[link];
            (place.body, place.pose.then(&pose))
        });
        let anchors = [0, 1].map(|side| {
            let (body, pose) = ends[side];
            let mut name = format!("{}_{}", closure.name, side + 1);
            while !taken.insert((body, name.clone())) {
                name.push('_');
            }
            self.model.points.push(ModelPoint {
                name,
                body,
                coordinates: pose.origin,
            });
            Anchor {
                body,
                point: Some(self.model.points.len() - 1),
            }
        });
        let [first, second] = ends.map(|(_, pose)| pose.rotation);
        let between = first.then(&second.inverse());
        self.model.cuts.push(Cut {
            name: closure.name.clone(),
            kind: match closure.is_solid {
                true => CutKind::Solid,
                false => CutKind::Ball,
            },
            ends: anchors,
            ignore: [false; 3],
            rotation: (closure.is_solid && !between.is_identity()).then_some(between.0),
        });
    }

    /// Adds the couplings of joints that follow others.
    fn couple(&mut self, couplings: &[Option<ResolvedMimic>]) {
        for (index, coupling) in couplings.iter().enumerate() {
            let Some(ResolvedMimic {
                leader,
                factor,
                offset,
            }) = *coupling
            else {
                continue;
            };
            let [joint, leader] = [index, leader].map(|joint| {
                self.numbers[joint].expect("only joints with a position follow and lead")
            });
            let position = factor * self.model.joints[leader].initial[0] + offset;
            let model = &mut self.model;
            let follower = &mut model.joints[joint];
            follower.nature = Nature::Dependent;
            follower.initial[0] = position;
            let ends = [joint, leader].map(|joint| Anchor {
                body: Some(model.joints[joint].body),
                point: None,
            });
            model.cuts.push(Cut {
                name: model.joints[joint].name.clone(),
                kind: CutKind::Coupling(JointCoupling {
                    joint,
                    leader,
                    factor,
                    offset,
                }),
                ends,
                ignore: [false; 3],
                rotation: None,
            });
        }
    }

    fn finish(mut self) -> BuiltRobot {
        let model = &mut self.model;
        assert_eq!(
            self.inertias.len(),
            model.bodies.len(),
            "every body has an inertia"
        );
        for (body, inertia) in model.bodies.iter_mut().zip(&self.inertias) {
            body.mass = inertia.mass;
            // Where nothing weighs, a centre means nothing.
            if inertia.mass != 0.0 {
                body.center = inertia.center;
            }
            body.inertia = inertia.inertia;
        }
        model.number_points();
        model.connect();
        BuiltRobot {
            model: self.model,
            places: self.places,
        }
    }
}

/// A joint that starts at zero and is attached to nothing yet.
fn plain(name: String, kind: JointKind, mounting: JointMounting) -> Joint {
    Joint {
        name,
        kind,
        nature: Nature::Independent,
        body: 0,
        parent: None,
        point: None,
        has_velocity: true,
        has_acceleration: true,
        actuated: false,
        initial: [0.0; 3],
        mounting,
        limits: None,
        law: Default::default(),
        armature: 0.0,
    }
}
