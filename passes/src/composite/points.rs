//! The attachment points that joints are on, one point at a time.
//!
//! With point masses and a single attachment point, the effect on a joint is
//! the mass beyond the point times the square of the point's speed. So the body
//! of a point is the one for which exactly the joints before it have the effect
//! that follows from the rotations between them, and the mass identifies the
//! body's children at the point. A point that no joint feels has no place, and
//! needs none.

use super::bodies::{JointAxis, cross};
use super::matrix::{BodySystem, JointPlacement};
use super::model::{AncestorTree, ModelInputs, SystemInput};
use super::probe::{MatrixProbe, UsualState, near};

/// Maximum number of children of a body for which every set is tried; of more
/// only single ones and all of them.
const MAX_CHILDREN: usize = 16;

/// By joint: the points of its parent at its place, counted from 0.
pub(super) fn find(
    probe: &mut MatrixProbe<'_>,
    model: &ModelInputs,
    tree: &AncestorTree,
    axes: &[JointAxis],
) -> Vec<Vec<usize>> {
    let frames = TurnedFrames::new(model, tree, axes);
    let mut stands: Vec<Vec<usize>> = vec![Vec::new(); model.len()];
    for point in 0..model.points.len() {
        let matrix = probe.matrix(|input| match input {
            SystemInput::Coordinate(joint) if tree.slides[joint] => 0.0,
            SystemInput::Point(other, _) if other != point => 0.0,
            SystemInput::Centre(..) | SystemInput::Inertia(..) => 0.0,
            _ => input.usual(),
        });
        let felt: Vec<f64> = (0..model.len())
            .map(|joint| {
                if tree.slides[joint] || matrix.is_zero(joint, joint) {
                    0.0
                } else {
                    matrix.at(joint, joint)
                }
            })
            .collect();
        if felt.iter().all(|&felt| felt == 0.0) {
            continue;
        }
        let arm = [0, 1, 2].map(|axis| {
            let part = model.points[point][axis];
            part.map_or(0.0, |_| SystemInput::Point(point, axis).usual())
        });
        let fits = (0..model.len()).filter_map(|body| frames.children_at(body, arm, &felt));
        // Between joints that slide a point may lie on either body.
        let free = |children: &Vec<usize>| children.iter().all(|&child| stands[child].is_empty());
        let chosen = fits.clone().find(free).or_else(|| fits.clone().next());
        for child in chosen.into_iter().flatten() {
            stands[child].push(point);
        }
    }
    stands
}

/// The frames of all joints in the usual state, turned but not moved.
struct TurnedFrames<'a> {
    model: &'a ModelInputs,
    tree: &'a AncestorTree,
    children: Vec<Vec<usize>>,
    /// By joint: the masses beyond it.
    masses: Vec<f64>,
    /// By joint: its axes, in those of the base.
    axes: Vec<[[f64; 3]; 3]>,
    /// By joint: its angular velocity; zero for one that slides.
    turns: Vec<[f64; 3]>,
}

impl<'a> TurnedFrames<'a> {
    fn new(model: &'a ModelInputs, tree: &'a AncestorTree, axes: &[JointAxis]) -> TurnedFrames<'a> {
        let count = model.len();
        let mut frames = TurnedFrames {
            model,
            tree,
            children: vec![Vec::new(); count],
            masses: (0..count).map(|joint| tree.mass(joint, model)).collect(),
            axes: Vec::with_capacity(count),
            turns: Vec::with_capacity(count),
        };
        for (joint, &axis) in axes.iter().enumerate() {
            let before = tree.parents[joint];
            if let Some(parent) = before {
                frames.children[parent].push(joint);
            }
            let place = JointPlacement {
                parent: before,
                joint: axis,
                points: Vec::new(),
                symmetric: false,
            };
            let stand = UsualState { model }.stand(joint, &place);
            let own = [0, 1, 2].map(|axis| {
                let mut unit = [0.0; 3];
                unit[axis] = 1.0;
                let turned = stand.turn_back(&mut UsualState { model }, unit);
                before.map_or(turned, |parent| sum(frames.axes[parent], turned))
            });
            frames.axes.push(own);
            frames.turns.push(match axis {
                JointAxis::Revolute(about) => own[about],
                JointAxis::Prismatic(_) => [0.0; 3],
            });
        }
        frames
    }

    /// The children of a body that are at a point of it, if the effects on
    /// joints confirm that it has this point.
    fn children_at(&self, body: usize, arm: [f64; 3], felt: &[f64]) -> Option<Vec<usize>> {
        let arm = sum(self.axes[body], arm);
        let speeds: Vec<(usize, f64)> = self
            .tree
            .chain(body)
            .map(|joint| (joint, self.square_of_speed(joint, arm)))
            .collect();
        let fastest = speeds.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let mass = felt[fastest.0] / fastest.1;
        let size = felt[fastest.0];
        let in_chain = speeds.iter().filter(|(joint, _)| felt[*joint] != 0.0);
        let all = felt.iter().filter(|&&felt| felt != 0.0);
        let agrees = |&(joint, speed): &(usize, f64)| near(felt[joint], mass * speed, size);
        if !(mass > 0.0 && mass.is_finite() && speeds.iter().all(agrees))
            || in_chain.count() != all.count()
        {
            return None;
        }
        self.children_of_mass(body, mass)
    }

    /// The square of the speed, per unit speed of the joint, of a point at an
    /// arm, in the axes of the base.
    fn square_of_speed(&self, joint: usize, arm: [f64; 3]) -> f64 {
        let ring = &mut UsualState { model: self.model };
        let [x, y, z] = cross(ring, self.turns[joint], arm);
        x * x + y * y + z * z
    }

    /// Some of the children of a body, with everything beyond them, by their
    /// mass.
    fn children_of_mass(&self, body: usize, mass: f64) -> Option<Vec<usize>> {
        let children: Vec<usize> = self.children[body]
            .iter()
            .copied()
            .filter(|&child| self.masses[child] > 0.0)
            .collect();
        let weighs = |chosen: &Vec<usize>| {
            let sum: f64 = chosen.iter().map(|&child| self.masses[child]).sum();
            near(sum, mass, mass)
        };
        let mut single = children.iter().map(|&child| vec![child]);
        if let Some(found) = single.find(&weighs) {
            return Some(found);
        }
        if children.len() > MAX_CHILDREN {
            return Some(children).filter(weighs);
        }
        let some = |set: u32| -> Vec<usize> {
            let places = children.iter().enumerate();
            let inside = places.filter(|(place, _)| set >> place & 1 == 1);
            inside.map(|(_, &child)| child).collect()
        };
        (1..1u32 << children.len()).map(some).find(weighs)
    }
}

/// A vector of a frame in the axes of the base.
fn sum(axes: [[f64; 3]; 3], parts: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|row| (0..3).map(|axis| axes[axis][row] * parts[axis]).sum())
}
