//! The search for the tree of bodies that a mass matrix belongs to.
//!
//! The zeros of the matrix tell which joints stand behind which. What is not
//! known of a joint is its kind, one of six, and the point of its parent it
//! stands on. Going from the last joint to the first, the inertia and the
//! wrenches of everything behind a joint are known once those choices have
//! been made behind it, and each choice must give the right values of the
//! joint's column of the matrix, in the prime fields. Where a column does not
//! tell (a prismatic joint does not feel where its children stand) the choice
//! stays open, and is taken back when a joint further on cannot be explained.

use super::bodies::JointAxis;
use super::model::ModelInputs;
use super::search::CompositeSearch;
use crate::factor::network::FactorNetwork;

/// The placement of a joint on its parent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct JointPlacement {
    /// The joint before it, counted from 0.
    pub(super) parent: Option<usize>,
    /// Its kind.
    pub(super) joint: JointAxis,
    /// The point of the parent, in [`ModelInputs::points`]; `None` for its origin.
    pub(super) point: Option<usize>,
    /// The inertia of its body is mirrored about the diagonal.
    pub(super) symmetric: bool,
}

/// The tree, if there is one that explains every element of the matrix.
pub(super) fn find(model: &ModelInputs, network: &FactorNetwork) -> Option<Vec<JointPlacement>> {
    let count = model.len();
    let mut matrix = Vec::with_capacity(count * count);
    for row in 0..count {
        for column in 0..count {
            let value = model.element(network, row, column);
            if value != model.element(network, column, row) {
                return None;
            }
            matrix.push(value);
        }
    }
    let mut search = CompositeSearch::new(model, network.values.images, matrix, parents(model));
    for joint in (0..count).rev() {
        if !search.settle(joint) {
            return None;
        }
    }
    Some(search.places())
}

/// The joint before each: the last of those it must stand behind. Two joints
/// stand behind one another when their element is not zero, or when a third
/// stands behind both. A joint without a body is one of several that lead to
/// the next body, so the joint that follows it in the numbering stands on it.
fn parents(model: &ModelInputs) -> Vec<Option<usize>> {
    let count = model.len();
    let tied = |a: usize, b: usize| model.elements[a * count + b].is_some();
    let mut parents: Vec<Option<usize>> = (0..count)
        .map(|joint| {
            (0..joint).rev().find(|&before| {
                tied(joint, before)
                    || (joint + 1..count).any(|after| tied(after, joint) && tied(after, before))
            })
        })
        .collect();
    for joint in (0..count - 1).rev() {
        let behind = parents.contains(&Some(joint));
        if model.bodies[joint].is_absent() && tied(joint, joint) && !behind {
            parents[joint + 1] = Some(joint);
        }
    }
    parents
}
