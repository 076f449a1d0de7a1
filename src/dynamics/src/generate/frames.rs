//! The frames of a model: its joints, and the constant rotations between them.
//!
//! A recursion goes from frame to frame, each turned about one of its axes. A
//! constant rotation is a frame like any other whose angle is a number and
//! which no coordinate moves: it has no symbols, no column and no row. So
//! constant rotations need no code in formulations.
//!
//! Inside the generator a *joint* is such a frame, numbered with the others
//! (which shows in the names of equations, where there are constant
//! rotations); arrays of inputs and outputs count joints of the model. A joint
//! that moves against its axis has symbols with the opposite sign.

use super::algebra::Scalar;
use super::equations::{Equations, QuantityLabel};
use super::joint_arrays::JointNumbers;
use super::vector::AxisRotation;
use robovec_model::{Joint, JointKind, JointMounting, Model, Nature};
use std::borrow::Cow;

/// A quarter turn: sine and cosine of its multiples are 0, 1 or -1.
const RIGHT_ANGLE: f64 = std::f64::consts::FRAC_PI_2;

pub(super) struct ModelFrames<'m> {
    pub(super) source: &'m Model,
    /// The model whose joints are all frames.
    pub(super) model: Cow<'m, Model>,
    /// The frame of every joint.
    places: Vec<usize>,
    /// The joint of every frame; of a constant rotation its angle.
    frames: Vec<Result<usize, f64>>,
}

impl<'m> ModelFrames<'m> {
    pub(super) fn new(source: &'m Model) -> ModelFrames<'m> {
        let mut frames = Vec::with_capacity(source.joints.len());
        let mut places = Vec::with_capacity(source.joints.len());
        for (index, joint) in source.joints.iter().enumerate() {
            frames.extend(joint.mounting.turns.iter().map(|turn| Err(turn.angle)));
            places.push(frames.len());
            frames.push(Ok(index));
        }
        let model = if frames.len() == source.joints.len() {
            Cow::Borrowed(source)
        } else {
            Cow::Owned(with_frames(source))
        };
        ModelFrames {
            source,
            model,
            places,
            frames,
        }
    }

    pub(super) fn place(&self, joint: usize) -> usize {
        self.places[joint]
    }

    /// The frames of all joints of the model, in their order.
    pub(super) fn places(&self) -> &[usize] {
        &self.places
    }

    /// True for a constant rotation.
    pub(super) fn is_constant(&self, frame: usize) -> bool {
        self.frames[frame].is_err()
    }

    /// True for a joint that moves against its axis.
    pub(super) fn is_reversed(&self, frame: usize) -> bool {
        self.frames[frame].is_ok_and(|joint| self.source.joints[joint].mounting.reversed)
    }

    /// The joint of a frame, from 0; `None` for a constant rotation.
    pub(super) fn joint(&self, frame: usize) -> Option<usize> {
        self.frames[frame].ok()
    }

    pub(super) fn joint_numbers(&self) -> JointNumbers {
        let all = 0..self.model.joints.len();
        let plain = |frame| self.joint(frame) == Some(frame) && !self.is_reversed(frame);
        if all.clone().all(plain) {
            return JointNumbers::default();
        }
        let number = |frame| robovec_model::number(self.joint(frame)) as u32;
        JointNumbers {
            numbers: all.clone().map(number).collect(),
            reversed: all.map(|frame| self.is_reversed(frame)).collect(),
            ..JointNumbers::default()
        }
    }

    /// The angle of a constant rotation, rad; `None` for a joint.
    pub(super) fn angle(&self, frame: usize) -> Option<f64> {
        self.frames[frame].err()
    }

    /// The rotation of a frame whose angle is a number; `None` for a joint.
    pub(super) fn constant(&self, equations: &mut Equations, frame: usize) -> Option<AxisRotation> {
        let angle = self.frames[frame].err()?;
        let axis = self.model.joints[frame].kind.axis().index();
        // A quarter of a turn costs no more than signs.
        for (quarters, [cos, sin]) in [
            (0.0, [Scalar::ONE, Scalar::ZERO]),
            (1.0, [Scalar::ZERO, Scalar::ONE]),
            (-1.0, [Scalar::ZERO, -Scalar::ONE]),
            (2.0, [-Scalar::ONE, Scalar::ZERO]),
            (-2.0, [-Scalar::ONE, Scalar::ZERO]),
        ] {
            if angle == quarters * RIGHT_ANGLE {
                return Some(AxisRotation { axis, cos, sin });
            }
        }
        // Not the numbers: that they are a sine and a cosine is what the
        // proofs rely on, and their rounding would be an error.
        let label = |prefix| QuantityLabel::new(prefix, 0, frame + 1);
        let angle = equations.number(angle);
        Some(AxisRotation {
            axis,
            cos: equations.cos(label("C"), angle),
            sin: equations.sin(label("S"), angle),
        })
    }
}

/// The model with a joint for every constant rotation, which rests.
fn with_frames(source: &Model) -> Model {
    let mut model = source.clone();
    model.joints.clear();
    for body in &mut model.bodies {
        let start = model.joints.len();
        for joint in &source.joints[body.joints.clone()] {
            let turns = joint.mounting.turns.iter().map(|turn| Joint {
                kind: JointKind::Revolute(turn.axis),
                nature: Nature::Driven,
                has_velocity: false,
                has_acceleration: false,
                actuated: false,
                initial: [turn.angle, 0.0, 0.0],
                mounting: JointMounting::default(),
                limits: None,
                law: Default::default(),
                armature: 0.0,
                ..joint.clone()
            });
            model.joints.extend(turns);
            model.joints.push(Joint {
                mounting: JointMounting {
                    turns: Vec::new(),
                    ..joint.mounting.clone()
                },
                ..joint.clone()
            });
        }
        body.joints = start..model.joints.len();
    }
    model.connect();
    model
}
