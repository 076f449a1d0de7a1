//! Inertias without the parts that no joint distinguishes from those of the
//! body before: the base parameters of a model, in numbers.
//!
//! A point mass on the axis of a revolute joint moves as one on the body before
//! does, and so does any inertia that is the same all around the axis and has
//! no moment about it. So the mass, the first moment along the axis and one of
//! the moments across it may be moved to the body before; of a prismatic joint
//! all moments of inertia may, and across a constant rotation all parameters.
//! The remaining set has fewer numbers, and no joint force changes (Gautier and
//! Khalil, "Direct calculation of minimum set of inertial parameters of serial
//! robots", IEEE Transactions on Robotics and Automation 6, 1990).

use super::frames::ModelFrames;
use robovec_model::Axis;
use std::array::from_fn;

/// Inertia that a joint moves, about the origin of its frame.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub(super) struct GroupedInertia {
    /// Mass; perhaps none.
    pub(super) mass: f64,
    pub(super) first: [f64; 3],
    /// Moments of inertia; no body need have them.
    pub(super) moments: [[f64; 3]; 3],
}

impl GroupedInertia {
    /// Of a body whose moments are given about its centre.
    pub(super) fn of_body(mass: f64, center: [f64; 3], inertia: [f64; 9]) -> GroupedInertia {
        let own = GroupedInertia {
            mass,
            first: [0.0; 3],
            moments: from_fn(|row| from_fn(|column| inertia[3 * row + column])),
        };
        own.moved(center)
    }

    fn add(&mut self, other: &GroupedInertia) {
        self.mass += other.mass;
        for row in 0..3 {
            self.first[row] += other.first[row];
            for column in 0..3 {
                self.moments[row][column] += other.moments[row][column];
            }
        }
    }

    /// About an origin that lies `offset` before.
    fn moved(&self, offset: [f64; 3]) -> GroupedInertia {
        let (d, h, m) = (offset, self.first, self.mass);
        let along: f64 = (0..3).map(|k| d[k] * (2.0 * h[k] + m * d[k])).sum();
        GroupedInertia {
            mass: m,
            first: from_fn(|k| h[k] + m * d[k]),
            moments: from_fn(|r| {
                from_fn(|c| {
                    let both = d[r] * h[c] + h[r] * d[c] + m * d[r] * d[c];
                    self.moments[r][c] - both + if r == c { along } else { 0.0 }
                })
            }),
        }
    }

    /// In the axes of a frame that this one is turned from, about an axis.
    fn turned(&self, axis: Axis, angle: f64) -> GroupedInertia {
        let (a, (sine, cosine)) = (axis.index(), angle.sin_cos());
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        let mut rotation = [[0.0; 3]; 3];
        rotation[a][a] = 1.0;
        rotation[b][b] = cosine;
        rotation[c][c] = cosine;
        rotation[b][c] = -sine;
        rotation[c][b] = sine;
        let half: [[f64; 3]; 3] =
            from_fn(|r| from_fn(|c| (0..3).map(|k| rotation[r][k] * self.moments[k][c]).sum()));
        GroupedInertia {
            mass: self.mass,
            first: from_fn(|r| (0..3).map(|k| rotation[r][k] * self.first[k]).sum()),
            moments: from_fn(|r| from_fn(|c| (0..3).map(|k| half[r][k] * rotation[c][k]).sum())),
        }
    }

    /// Removes the part that the body before a revolute joint may have instead.
    fn split_revolute(&mut self, axis: usize) -> GroupedInertia {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let across = self.moments[b][b];
        let mut before = GroupedInertia {
            mass: self.mass,
            ..GroupedInertia::default()
        };
        before.first[axis] = self.first[axis];
        before.moments[b][b] = across;
        before.moments[c][c] = across;
        self.mass = 0.0;
        self.first[axis] = 0.0;
        self.moments[b][b] = 0.0;
        self.moments[c][c] -= across;
        before
    }
}

/// Inertias of all frames, moved to the bodies before as far as possible.
pub(super) fn grouped(frames: &ModelFrames<'_>, first: usize) -> Vec<GroupedInertia> {
    let model = &frames.model;
    let of_body = |joint| match model.body_of(joint) {
        Some(body) => GroupedInertia::of_body(body.mass, body.center, body.inertia_matrix()),
        None => GroupedInertia::default(),
    };
    let mut all: Vec<GroupedInertia> = (0..model.joints.len()).map(of_body).collect();
    for index in (first..all.len()).rev() {
        let joint = &model.joints[index];
        let kind = joint.kind;
        let own = &mut all[index];
        let before = match frames.angle(index) {
            Some(angle) => std::mem::take(own).turned(kind.axis(), angle),
            None if kind.is_revolute() => own.split_revolute(kind.axis().index()),
            None => GroupedInertia {
                moments: std::mem::take(&mut own.moments),
                ..GroupedInertia::default()
            },
        };
        // What goes to the base moves nothing.
        if let Some(parent) = joint.parent {
            let offset = model.coordinates(joint.point);
            all[parent].add(&before.moved(offset));
        }
    }
    all
}
