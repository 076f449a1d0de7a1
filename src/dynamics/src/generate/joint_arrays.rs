//! Joints among the indices of arrays, and frames in the arrays of functions:
//! constant rotations are in none, symbols of reversed joints change sign.

use super::algebra::Scalar;
use robovec_model::Model;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum IndexMeaning {
    /// Any other parent, or none.
    Other,
    /// The bodies that joints move.
    Body,
    /// Joints: the sign of an element follows the joint's.
    Coordinate,
}

fn meanings(array: &str) -> [IndexMeaning; 2] {
    use IndexMeaning::{Body, Coordinate, Other};
    match array {
        // The columns of a regressor are numbers of bodies.
        "Y" | "q" | "qd" | "qdd" | "Qq" | "Qa" | "Qc" | "c" => [Coordinate, Other],
        "M" | "Minv" => [Coordinate, Coordinate],
        "Jac" | "Juserc" | "sens.J" | "jacobian" | "jacobian_rate" => [Other, Coordinate],
        "m" => [Body, Other],
        "l" | "In" | "frc" | "trq" => [Other, Body],
        // The Jacobians that laws of external forces are given.
        _ if array.starts_with("JxF") => [Other, Coordinate],
        // Derivatives, as `Qq_q`.
        _ => match array.split_once('_') {
            Some((of, "direction" | "weight" | "gradient")) => meanings(of),
            Some((of, by)) => match [meanings(of), meanings(by)] {
                [[Coordinate, Other], [Coordinate, Other]] => [Coordinate, Coordinate],
                _ => [Other, Other],
            },
            None => [Other, Other],
        },
    }
}

/// Names of the rows and of the columns of an array that belong to joints or to
/// the bodies that they move, empty for a body without mass; `None` for others.
pub fn index_names<'m>(
    model: &'m Model,
    array: &str,
    quaternion: bool,
) -> [Option<Vec<&'m str>>; 2] {
    let joints = 0..model.joints.len();
    meanings(array).map(|meaning| match meaning {
        IndexMeaning::Other => None,
        IndexMeaning::Body => {
            let body = |joint| model.body_of(joint).map_or("", |body| body.name.as_str());
            Some(joints.clone().map(body).collect())
        }
        IndexMeaning::Coordinate => {
            let mut names: Vec<_> = joints
                .clone()
                .map(|joint| &*model.joints[joint].name)
                .collect();
            if let (true, Some(angles)) = (quaternion, names.get_mut(3..6)) {
                angles.reverse();
            }
            Some(names)
        }
    })
}

/// Number of each frame's joint, both from 1, and a flag: true when reversed.
#[derive(Clone, Default, Debug)]
pub(super) struct JointNumbers {
    /// By frame: 0 for a constant rotation. Empty where frames are joints.
    pub(super) numbers: Vec<u32>,
    pub(super) reversed: Vec<bool>,
    /// Yaw and roll of a free base are exchanged: its arrays are roll first.
    pub(super) is_exchanged: bool,
}

impl JointNumbers {
    /// Exchanges yaw and roll of the free base of a model with so many frames.
    pub(super) fn exchange(&mut self, frames: usize) {
        if self.numbers.is_empty() {
            self.numbers = (1..=frames as u32).collect();
            self.reversed = vec![false; frames];
        }
        self.is_exchanged = true;
    }

    /// The indices of an element in arrays of joints, and a flag: true when its
    /// sign changes; `None` for one of a constant rotation.
    pub(super) fn element(&self, array: &str, mut indices: [u32; 2]) -> Option<([u32; 2], bool)> {
        if self.numbers.is_empty() {
            return Some((indices, false));
        }
        let mut negative = false;
        for (index, meaning) in indices.iter_mut().zip(meanings(array)) {
            if meaning == IndexMeaning::Other || *index == 0 {
                continue;
            }
            let frame = *index as usize - 1;
            if self.numbers[frame] == 0 {
                return None;
            }
            *index = self.numbers[frame];
            if self.is_exchanged && meaning == IndexMeaning::Coordinate && (4..=6).contains(index) {
                *index = 10 - *index;
            }
            negative ^= meaning == IndexMeaning::Coordinate && self.reversed[frame];
        }
        Some((indices, negative))
    }

    /// The elements of outputs as functions give them.
    pub(super) fn outputs(&self, arrays: &[String], outputs: &mut [(u32, [u32; 2], Scalar)]) {
        for (array, indices, value) in outputs {
            if let Some((numbers, negative)) = self.element(&arrays[*array as usize], *indices) {
                (*indices, *value) = (numbers, value.negated_if(negative));
            }
        }
    }
}
