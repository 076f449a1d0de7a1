//! The frame of a joint: the fewest constant rotations to its axis.

use crate::rotation::{Point3, Rotation3};
use crate::{Axis, ConstantTurn, JointMounting};

/// Frame of a joint relative to the frame before, and its axis in it.
pub(super) struct AxisFrame {
    pub(super) mounting: JointMounting,
    pub(super) axis: Axis,
    pub(super) rotation: Rotation3,
}

/// Part of a component of an axis of length one that counts as rounding.
const ROUNDING: f64 = 4e-15;

/// The frame of a joint whose axis is given in the frame before.
///
/// An axis of that frame needs no turn; one in a plane of two axes needs one, by
/// at most half a right angle; any other needs two.
pub(super) fn of_axis(direction: Point3) -> AxisFrame {
    debug_assert!(
        (direction.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-6,
        "an axis has length one"
    );
    let nearest = (0..3).fold(0, |best, k| {
        if direction[k].abs() > direction[best].abs() {
            k
        } else {
            best
        }
    });
    let reversed = direction[nearest] < 0.0;
    let sign = if reversed { -1.0 } else { 1.0 };
    let (next, last) = ((nearest + 1) % 3, (nearest + 2) % 3);
    let [along, b, c] = [nearest, next, last].map(|k| sign * direction[k]);
    let is_zero = |x: f64| x.abs() <= ROUNDING;
    // A turn about the last axis moves the nearest one towards the next; one
    // about the next then moves it away from the last.
    let mut turns = Vec::new();
    if !is_zero(c) {
        turns.push(ConstantTurn {
            axis: Axis::ALL[next],
            angle: (-c).atan2(along),
        });
    }
    if !is_zero(b) {
        turns.push(ConstantTurn {
            axis: Axis::ALL[last],
            angle: b.atan2(along.hypot(c)),
        });
    }
    AxisFrame {
        rotation: Rotation3::of_turns(&turns),
        mounting: JointMounting { turns, reversed },
        axis: Axis::ALL[nearest],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The axis of the frame is the direction that was requested, and the
    /// number of turns is as small as it can be.
    #[test]
    fn the_axis_of_the_frame_is_the_direction() {
        let mut numbers = [0.3_f64, -0.7, 0.2];
        for round in 0..300 {
            numbers = numbers.map(|x| (x * 7919.0 + 0.1).sin());
            let mut direction = numbers;
            for (k, component) in direction.iter_mut().enumerate() {
                if round & (1 << k) != 0 && round % 8 != 7 {
                    *component = 0.0;
                }
            }
            let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
            let direction = direction.map(|x| x / length);
            let frame = of_axis(direction);
            let zeros = direction.iter().filter(|x| **x == 0.0).count();
            assert_eq!(frame.mounting.turns.len(), 2 - zeros);
            let mut unit = [0.0; 3];
            unit[frame.axis.index()] = frame.mounting.sign();
            let found = frame.rotation.apply(unit);
            for (found, asked) in found.iter().zip(direction) {
                assert!((found - asked).abs() < 4e-16, "{direction:?}");
            }
        }
    }
}
