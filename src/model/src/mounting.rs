//! Mounting of a joint on its parent: turns and signs beyond Robotran's joints.
//!
//! The axis of a joint is always an axis of its frame. If it is no axis of the
//! frame before, constant rotations are inserted; they have no degree of
//! freedom and no joint id. A joint that moves against its axis is reversed.

use super::Axis;
use super::rotation::Rotation3;

/// A rotation about an axis of a frame by a constant angle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ConstantTurn {
    /// The axis.
    pub axis: Axis,
    /// The angle, rad.
    pub angle: f64,
}

/// Frame of a joint, and the direction of its motion.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct JointMounting {
    /// The constant rotations between the frame before and the joint's own, in
    /// the order from there; none for a joint of Robotran.
    pub turns: Vec<ConstantTurn>,
    /// True when a positive position moves against the axis.
    pub reversed: bool,
}

impl JointMounting {
    /// True for a joint of Robotran: along or about an axis of its frame.
    pub fn is_plain(&self) -> bool {
        self.turns.is_empty() && !self.reversed
    }

    /// The constant rotation: row by row the matrix that takes components in the
    /// joint's frame, at position zero, to those in the frame before.
    pub fn rotation(&self) -> [[f64; 3]; 3] {
        Rotation3::of_turns(&self.turns).0
    }

    /// `1`, or `-1` for a reversed joint.
    pub fn sign(&self) -> f64 {
        if self.reversed { -1.0 } else { 1.0 }
    }
}

/// A joint that follows another one: at `factor` times its place plus `offset`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct JointCoupling {
    /// The joint that follows, an index.
    pub joint: usize,
    /// The joint it follows, an index.
    pub leader: usize,
    /// The ratio of both positions.
    pub factor: f64,
    /// The position of the follower where the leader is at zero.
    pub offset: f64,
}
