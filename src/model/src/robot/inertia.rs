//! Masses of links, and of bodies that are made of several.

use crate::rotation::{FramePose, Rotation3, add, scaled};
use std::ops::Range;

/// Inertia of a link, in its own frame.
pub(super) struct LinkInertial {
    pub(super) mass: f64,
    /// Of the frame of the centre of mass in the link's.
    pub(super) origin: FramePose,
    /// About the centre of mass, in its frame: `xx xy xz yy yz zz`.
    pub(super) inertia: [f64; 6],
    pub(super) place: Range<usize>,
}

#[derive(Clone, Copy)]
pub(super) struct BodyInertia {
    pub(super) mass: f64,
    pub(super) center: [f64; 3],
    /// About the centre of mass: `xx xy xz yy yz zz`.
    pub(super) inertia: [f64; 6],
}

impl BodyInertia {
    pub(super) const NONE: BodyInertia = BodyInertia {
        mass: 0.0,
        center: [0.0; 3],
        inertia: [0.0; 6],
    };

    /// Inertia of a link, in the frame of the body that it is on with a pose.
    pub(super) fn of_link(link: &LinkInertial, pose: &FramePose) -> BodyInertia {
        let frame = pose.then(&link.origin);
        BodyInertia {
            mass: link.mass,
            center: frame.origin,
            inertia: turned(&link.inertia, &frame.rotation),
        }
    }

    /// Both in one.
    pub(super) fn with(&self, other: &BodyInertia) -> BodyInertia {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            let mut sum = *self;
            for (entry, more) in sum.inertia.iter_mut().zip(other.inertia) {
                *entry += more;
            }
            return sum;
        }
        // A part without mass is not moved by rounding.
        let center = match (self.mass == 0.0, other.mass == 0.0) {
            (true, _) => other.center,
            (_, true) => self.center,
            _ => scaled(
                add(
                    scaled(self.center, self.mass),
                    scaled(other.center, other.mass),
                ),
                1.0 / mass,
            ),
        };
        let mut inertia = [0.0; 6];
        for part in [self, other] {
            let shifted = part.about(center);
            for (entry, more) in inertia.iter_mut().zip(shifted) {
                *entry += more;
            }
        }
        BodyInertia {
            mass,
            center,
            inertia,
        }
    }

    fn about(&self, point: [f64; 3]) -> [f64; 6] {
        let [x, y, z] = add(self.center, scaled(point, -1.0));
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        let m = self.mass;
        [
            xx + m * (y * y + z * z),
            xy - m * x * y,
            xz - m * x * z,
            yy + m * (x * x + z * z),
            yz - m * y * z,
            zz + m * (x * x + y * y),
        ]
    }
}

/// A symmetric matrix in the axes of another frame, `R I R^T`.
fn turned(entries: &[f64; 6], rotation: &Rotation3) -> [f64; 6] {
    if rotation.is_identity() {
        return *entries;
    }
    let [xx, xy, xz, yy, yz, zz] = *entries;
    let matrix = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    // The columns of `I R^T` are `I` times the rows of `R`.
    let half = matrix.map(|row| rotation.apply(row));
    let column = |k: usize| rotation.apply(half.map(|row| row[k]));
    let columns = [column(0), column(1), column(2)];
    let scale = entries.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    // What is left of a zero entry by rounding is no entry.
    let entry = |row: usize, column: usize| {
        let value = columns[column][row];
        if value.abs() <= scale * 4.0 * f64::EPSILON {
            0.0
        } else {
            value
        }
    };
    [
        entry(0, 0),
        entry(0, 1),
        entry(0, 2),
        entry(1, 1),
        entry(1, 2),
        entry(2, 2),
    ]
}
