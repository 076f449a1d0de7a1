//! Rotations and poses in numbers.
//!
//! An angle within the rounding of a decimal number of sixteen digits of a
//! right angle is treated as one: a cosine of `6e-17` would be an operation.
//! For angles in files the tolerance is larger ([`to_right_angle`]).

use crate::{Axis, ConstantTurn};
use std::array::from_fn;

pub(super) type Point3 = [f64; 3];

/// Part of a number of the size of one that is rounding.
pub(super) const DUST: f64 = 1e-15;

/// The multiple of a right angle nearly equal to an angle, rad, or the angle.
pub(super) fn to_right_angle(angle: f64, tolerance: f64) -> f64 {
    let quarter = std::f64::consts::FRAC_PI_2;
    let nearest = (angle / quarter).round() * quarter;
    if (angle - nearest).abs() <= tolerance {
        nearest
    } else {
        angle
    }
}

pub(super) fn add(a: Point3, b: Point3) -> Point3 {
    from_fn(|i| a[i] + b[i])
}

pub(super) fn scaled(a: Point3, factor: f64) -> Point3 {
    a.map(|x| x * factor)
}

/// The vector of length one in a direction; `None` without a length.
pub(super) fn unit(vector: Point3) -> Option<Point3> {
    let largest = vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    // Scaled first, so that no square is lost.
    let vector = vector.map(|x| x / largest);
    let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    Some(vector.map(|x| x / length))
}

/// A rotation: the matrix from components in a frame to those in its parent.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Rotation3(pub(super) [[f64; 3]; 3]);

/// Sine and cosine, exact at right angles.
fn sine_cosine(angle: f64) -> (f64, f64) {
    let (sine, cosine) = angle.sin_cos();
    if cosine.abs() <= DUST {
        (sine.signum(), 0.0)
    } else if sine.abs() <= DUST && angle != 0.0 && angle.abs() > 1.0 {
        (0.0, cosine.signum())
    } else {
        (sine, cosine)
    }
}

impl Rotation3 {
    pub(super) const IDENTITY: Rotation3 =
        Rotation3([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    pub(super) fn about(axis: Axis, angle: f64) -> Rotation3 {
        let (sine, cosine) = sine_cosine(angle);
        let (b, c) = ((axis.index() + 1) % 3, (axis.index() + 2) % 3);
        let mut matrix = Rotation3::IDENTITY.0;
        matrix[b][b] = cosine;
        matrix[b][c] = -sine;
        matrix[c][b] = sine;
        matrix[c][c] = cosine;
        Rotation3(matrix)
    }

    /// By yaw about the third axis, pitch about the new second, then roll.
    pub(super) fn from_roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> Rotation3 {
        let about = Rotation3::about;
        let first = about(Axis::Z, yaw).then(&about(Axis::Y, pitch));
        first.then(&about(Axis::X, roll))
    }

    /// The rotation of a quaternion `w x y z` of any length but zero.
    pub(super) fn from_quaternion([w, x, y, z]: [f64; 4]) -> Rotation3 {
        let square = w * w + x * x + y * y + z * z;
        debug_assert!(square > 0.0, "a quaternion has a length");
        let double = 2.0 / square;
        let product = |a: f64, b: f64, c: f64, d: f64| {
            let value = double * (a * b + c * d);
            if value.abs() <= DUST { 0.0 } else { value }
        };
        let diagonal = |a: f64, b: f64| {
            let value = 1.0 - double * (a * a + b * b);
            match value {
                value if value.abs() <= DUST => 0.0,
                value if 1.0 - value.abs() <= DUST => value.signum(),
                value => value,
            }
        };
        Rotation3([
            [diagonal(y, z), product(x, y, -w, z), product(x, z, w, y)],
            [product(x, y, w, z), diagonal(x, z), product(y, z, -w, x)],
            [product(x, z, -w, y), product(y, z, w, x), diagonal(x, y)],
        ])
    }

    /// The rotation by an angle about a direction of length one.
    pub(super) fn about_direction([x, y, z]: Point3, angle: f64) -> Rotation3 {
        let (sine, cosine) = sine_cosine(angle / 2.0);
        Rotation3::from_quaternion([cosine, sine * x, sine * y, sine * z])
    }

    pub(super) fn is_identity(&self) -> bool {
        *self == Rotation3::IDENTITY
    }

    /// This rotation, followed by another one in the rotated frame.
    pub(super) fn then(&self, other: &Rotation3) -> Rotation3 {
        if self.is_identity() {
            return *other;
        }
        let product: [[f64; 3]; 3] = from_fn(|row| {
            from_fn(|column| (0..3).map(|k| self.0[row][k] * other.0[k][column]).sum())
        });
        Rotation3(product.map(|row| row.map(|x: f64| if x.abs() <= DUST { 0.0 } else { x })))
    }

    /// A vector of the frame in the axes of the parent frame.
    pub(super) fn apply(&self, vector: Point3) -> Point3 {
        from_fn(|row| (0..3).map(|k| self.0[row][k] * vector[k]).sum())
    }

    pub(super) fn inverse(&self) -> Rotation3 {
        Rotation3(from_fn(|row| from_fn(|column| self.0[column][row])))
    }

    pub(super) fn of_turns(turns: &[ConstantTurn]) -> Rotation3 {
        let start = Rotation3::IDENTITY;
        turns.iter().fold(start, |before, turn| {
            before.then(&Rotation3::about(turn.axis, turn.angle))
        })
    }

    /// Yaw, pitch and roll, rad.
    pub(super) fn yaw_pitch_roll(&self) -> [f64; 3] {
        let m = &self.0;
        let pitch = (0.0 - m[2][0]).atan2(m[0][0].hypot(m[1][0]));
        let (yaw, roll) = if m[0][0].hypot(m[1][0]) <= 4.0 * DUST {
            // Only the sum or difference of yaw and roll is determined.
            ((-m[0][1]).atan2(m[1][1]), 0.0)
        } else {
            (m[1][0].atan2(m[0][0]), m[2][1].atan2(m[2][2]))
        };
        [yaw, pitch, roll]
    }

    /// Turns about axes that give the rotation: yaw, pitch and roll.
    pub(super) fn turns(&self) -> Vec<ConstantTurn> {
        let [yaw, pitch, roll] = self.yaw_pitch_roll();
        let all = [(Axis::Z, yaw), (Axis::Y, pitch), (Axis::X, roll)];
        let turns = all.into_iter().filter(|(_, angle)| *angle != 0.0);
        turns
            .map(|(axis, angle)| ConstantTurn { axis, angle })
            .collect()
    }
}

/// Place where a frame is on another one.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct FramePose {
    pub(super) rotation: Rotation3,
    pub(super) origin: Point3,
}

impl FramePose {
    /// On the other frame itself.
    pub(super) const HERE: FramePose = FramePose {
        rotation: Rotation3::IDENTITY,
        origin: [0.0; 3],
    };

    /// At a place on the other frame, along its axes.
    pub(super) fn at(origin: Point3) -> FramePose {
        FramePose {
            rotation: Rotation3::IDENTITY,
            origin,
        }
    }

    /// The pose of the parent frame in this one.
    pub(super) fn inverse(&self) -> FramePose {
        let rotation = self.rotation.inverse();
        FramePose {
            rotation,
            origin: rotation.apply(scaled(self.origin, -1.0)),
        }
    }

    /// A pose in this frame, expressed in the parent frame.
    pub(super) fn then(&self, other: &FramePose) -> FramePose {
        let moved = if self.rotation.is_identity() {
            other.origin
        } else {
            clean(self.rotation.apply(other.origin))
        };
        FramePose {
            rotation: self.rotation.then(&other.rotation),
            origin: add(self.origin, moved),
        }
    }
}

/// The vector without components that are rounding beside the others.
fn clean(vector: Point3) -> Point3 {
    let largest = vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    vector.map(|x| if x.abs() <= largest * DUST { 0.0 } else { x })
}

/// The shortest rotation after which the third axis is the direction, which
/// has length one; against the axis, half a turn about the first one.
pub(super) fn upright([x, y, z]: Point3) -> Rotation3 {
    let aside = x * x + y * y;
    if aside == 0.0 {
        return if z < 0.0 {
            Rotation3::about(Axis::X, std::f64::consts::PI)
        } else {
            Rotation3::IDENTITY
        };
    }
    // `1 / (1 + z)`, in the form that does not cancel.
    let factor = if z < 0.0 {
        (1.0 - z) / aside
    } else {
        1.0 / (1.0 + z)
    };
    let both = -x * y * factor;
    Rotation3([
        [1.0 - x * x * factor, both, x],
        [both, 1.0 - y * y * factor, y],
        [-x, -y, z],
    ])
}
