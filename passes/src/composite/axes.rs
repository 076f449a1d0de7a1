//! The axes of joints, found with all frames aligned.
//!
//! With all coordinates and attachment points zero every frame is the base's,
//! and an element of the matrix depends on the axes of its two joints and on
//! the inertia beyond the second alone. Parameters that bodies do not show as
//! point masses are shown by single components of attachment points or single
//! coordinates of prismatic joints: a joint moves points along another axis
//! than its own.
//!
//! Every joint has at most three axes left; those of a joint and of one before
//! it must agree with their element. The remaining freedom does not matter: the
//! whole may be turned.

use super::bodies::{CompositeInertia, JointAxis};
use super::model::{AncestorTree, ModelInputs, SystemInput};
use super::probe::{MatrixProbe, ProbedMatrix, UsualState, near};

/// Comparisons of pairs of joints before the rest is left unexplained.
const MAX_COMPARISONS: usize = 20_000_000;

/// The axes of joints.
pub(super) struct FoundAxes {
    pub(super) chosen: Vec<JointAxis>,
    /// Joints, counted from 0, with alternative axes that agree equally well
    /// with all other joints.
    pub(super) open: Vec<(usize, JointAxis)>,
}

/// The axis of every joint.
pub(super) fn find(
    probe: &mut MatrixProbe<'_>,
    model: &ModelInputs,
    tree: &AncestorTree,
) -> FoundAxes {
    let frames = AlignedFrames::new(probe, model, tree);
    let mut search = AxisSearch {
        domains: (0..model.len()).map(|joint| frames.domain(joint)).collect(),
        frames,
        chosen: vec![0; model.len()],
        unexplained: vec![false; model.len()],
        comparisons: 0,
    };
    while let Some(joint) = search.choose() {
        search.unexplained[joint] = true;
    }
    FoundAxes {
        chosen: (0..model.len()).map(|joint| search.axis(joint)).collect(),
        open: search.open(),
    }
}

/// The matrix at states in which all frames are aligned.
struct AlignedFrames<'a> {
    tree: &'a AncestorTree,
    /// Without attachment points.
    bodies: ProbedMatrix,
    /// By joint: the inertia of all bodies beyond it, about the one origin.
    inertias: Vec<CompositeInertia<f64>>,
    /// With point masses and attachment points along one axis.
    points: [ProbedMatrix; 3],
    /// By axis and joint: whether the points along this axis move something
    /// beyond the joint.
    reach: [Vec<bool>; 3],
    /// By prismatic joint: the matrix with its coordinate alone and point
    /// masses.
    slides: Vec<Option<ProbedMatrix>>,
    /// By joint: the point masses beyond it.
    masses: Vec<f64>,
    /// By joint: its coordinate where it alone is not zero.
    coordinates: Vec<f64>,
}

impl<'a> AlignedFrames<'a> {
    fn new(
        probe: &mut MatrixProbe<'_>,
        model: &ModelInputs,
        tree: &'a AncestorTree,
    ) -> AlignedFrames<'a> {
        // A product of inertia that is given on one side of the diagonal only
        // may be meant for both.
        let body_number = |input: SystemInput| match input {
            SystemInput::Coordinate(_) | SystemInput::Point(..) => 0.0,
            SystemInput::Inertia(body, [r, c]) if model.bodies[body].inertia[c][r].is_none() => 0.0,
            _ => input.usual(),
        };
        let inertias = (0..model.len()).map(|joint| {
            let bodies = tree.behind[joint].iter();
            let each = bodies.map(|&body| {
                let parts = model.body(body);
                parts.map(|place| place.map_or(0.0, body_number))
            });
            let ring = &mut UsualState { model };
            let mut sum = CompositeInertia::none(ring);
            for body in each {
                let own = CompositeInertia::of(ring, &body);
                sum = sum.plus(ring, &own);
            }
            sum
        });
        let inertias = inertias.collect();
        let bodies = probe.matrix(body_number);
        let points = [0, 1, 2].map(|along| {
            probe.matrix(|input| match input {
                SystemInput::Mass(_) => input.usual(),
                SystemInput::Point(_, axis) if axis == along => input.usual().abs(),
                _ => 0.0,
            })
        });
        let coordinate = |joint: usize| SystemInput::Coordinate(joint).usual().abs();
        let slides = (0..model.len()).map(|joint| {
            let is_read = tree.slides[joint] && model.coordinates[joint].is_some();
            is_read.then(|| {
                probe.matrix(|input| match input {
                    SystemInput::Mass(_) => input.usual(),
                    SystemInput::Coordinate(other) if other == joint => coordinate(joint),
                    _ => 0.0,
                })
            })
        });
        AlignedFrames {
            slides: slides.collect(),
            masses: (0..model.len())
                .map(|joint| tree.mass(joint, model))
                .collect(),
            coordinates: (0..model.len()).map(coordinate).collect(),
            reach: points.each_ref().map(|matrix| reach(matrix, tree)),
            tree,
            bodies,
            inertias,
            points,
        }
    }

    /// The possible kinds of a joint, from its own element.
    fn domain(&self, joint: usize) -> Vec<JointAxis> {
        let own = self.bodies.at(joint, joint);
        let size = self.bodies.largest();
        let fits = |axis: usize| {
            if self.tree.slides[joint] {
                return true;
            }
            let kind = JointAxis::Revolute(axis);
            let expected = self.inertias[joint].wrench(kind).along(kind);
            let moved = |along: usize| !self.points[along].is_zero(joint, joint);
            // What lies along its own axis a joint does not move.
            let told = |along: usize| match (along == axis, moved(along)) {
                (true, moved) => !moved,
                (false, moved) => moved || !self.reach[along][joint],
            };
            near(own, expected, size) && (0..3).all(told)
        };
        let kind = |axis: usize| {
            if self.tree.slides[joint] {
                JointAxis::Prismatic(axis)
            } else {
                JointAxis::Revolute(axis)
            }
        };
        (0..3).filter(|&axis| fits(axis)).map(kind).collect()
    }

    /// Tests whether the kinds of two joints, the first before the second,
    /// agree with the observations.
    fn agree(&self, [before, joint]: [usize; 2], [first, second]: [JointAxis; 2]) -> bool {
        let expected = self.inertias[joint].wrench(second).along(first);
        if !near(
            self.bodies.at(before, joint),
            expected,
            self.bodies.largest(),
        ) {
            return false;
        }
        (0..3).all(|along| {
            let matrix = &self.points[along];
            // Two prismatic joints do not feel points.
            if let [JointAxis::Prismatic(_), JointAxis::Prismatic(_)] = [first, second] {
                return true;
            }
            match velocities(along, first, second) {
                0 => matrix.is_zero(before, joint),
                _ if matrix.is_zero(before, joint) => !self.reach[along][joint],
                sign => (matrix.at(before, joint) > 0.0) == (sign > 0),
            }
        })
    }

    /// Tests whether the kinds of two joints, the first before the second,
    /// agree with their dependence on the coordinate of a prismatic joint.
    fn agree_on_slide(
        &self,
        (slide, along): (usize, usize),
        [before, joint]: [usize; 2],
        [first, second]: [JointAxis; 2],
    ) -> bool {
        let Some(matrix) = &self.slides[slide] else {
            return true;
        };
        let is_turn = |kind| matches!(kind, JointAxis::Revolute(_));
        let turns = [first, second].into_iter().filter(|&kind| is_turn(kind));
        let distance = self.coordinates[slide].powi(turns.count() as i32);
        let mass = self.masses[joint.max(slide)];
        let expected = f64::from(velocities(along, first, second)) * mass * distance;
        near(matrix.at(before, joint), expected, mass * distance)
    }
}

/// For each joint whether a revolute joint at or beyond it is seen to move
/// something.
fn reach(matrix: &ProbedMatrix, tree: &AncestorTree) -> Vec<bool> {
    let mut reach = vec![false; tree.parents.len()];
    for joint in (0..reach.len()).rev() {
        reach[joint] |= !tree.slides[joint] && !matrix.is_zero(joint, joint);
        if let (true, Some(parent)) = (reach[joint], tree.parents[joint]) {
            reach[parent] = true;
        }
    }
    reach
}

/// The sign of the scalar product of the velocities that two joints give to a
/// point on an axis, at a positive distance; 0 where there is no product.
fn velocities(along: usize, first: JointAxis, second: JointAxis) -> i32 {
    let velocity = |kind: JointAxis| match kind {
        JointAxis::Prismatic(axis) => (axis, 1),
        // The cross product of an axis and the next is the third.
        JointAxis::Revolute(axis) if (axis + 1) % 3 == along => ((axis + 2) % 3, 1),
        JointAxis::Revolute(axis) if (axis + 2) % 3 == along => ((axis + 1) % 3, -1),
        JointAxis::Revolute(axis) => (axis, 0),
    };
    let ((a, a_sign), (b, b_sign)) = (velocity(first), velocity(second));
    if a == b { a_sign * b_sign } else { 0 }
}

/// The choice of an axis for every joint.
struct AxisSearch<'a> {
    frames: AlignedFrames<'a>,
    domains: Vec<Vec<JointAxis>>,
    /// By joint: the place of its axis in its domain.
    chosen: Vec<usize>,
    /// Joints that need no further explanation.
    unexplained: Vec<bool>,
    comparisons: usize,
}

impl AxisSearch<'_> {
    /// The axis that is chosen for a joint; any, where none is left.
    fn axis(&self, joint: usize) -> JointAxis {
        let domain = &self.domains[joint];
        let any = if self.frames.tree.slides[joint] {
            JointAxis::Prismatic(0)
        } else {
            JointAxis::Revolute(0)
        };
        domain.get(self.chosen[joint]).copied().unwrap_or(any)
    }

    /// Chooses axes that agree with one another; returns the first joint
    /// without such an axis, if any.
    fn choose(&mut self) -> Option<usize> {
        self.chosen.fill(0);
        let mut joint = 0;
        while joint < self.chosen.len() {
            if self.unexplained[joint] || self.settle(joint) {
                joint += 1;
                if let Some(next) = self.chosen.get_mut(joint) {
                    *next = 0;
                }
                continue;
            }
            // Only joints before this one have a say in it.
            let tree = self.frames.tree;
            let open = |&before: &usize| {
                !self.unexplained[before] && self.chosen[before] + 1 < self.domains[before].len()
            };
            let back = tree.chain(joint).skip(1).find(open);
            let Some(back) = back.filter(|_| self.comparisons < MAX_COMPARISONS) else {
                return Some(joint);
            };
            self.chosen[back] += 1;
            joint = back;
        }
        None
    }

    /// The next axis of a joint, from the chosen one on, that agrees with those
    /// before it.
    fn settle(&mut self, joint: usize) -> bool {
        while self.chosen[joint] < self.domains[joint].len() {
            if self.agrees(joint) {
                return true;
            }
            self.chosen[joint] += 1;
        }
        false
    }

    /// Tests whether a joint agrees with those before it.
    fn agrees(&mut self, joint: usize) -> bool {
        let kind = self.axis(joint);
        let chain = self.frames.tree.chain(joint).skip(1);
        let before: Vec<usize> = chain.filter(|&before| !self.unexplained[before]).collect();
        let mut compared = 0;
        let agrees = self.unexplained[joint]
            || before.iter().all(|&before| {
                compared += 1;
                let kinds = [self.axis(before), kind];
                self.frames.agree([before, joint], kinds)
            }) && self.slides_agree(joint, &before, &mut compared);
        self.comparisons += compared;
        agrees
    }

    /// Tests whether a joint agrees with all pairs before it, the nearest
    /// first, on the effect of coordinates: the joint's own one where it
    /// slides, and those of joints between the two.
    fn slides_agree(&self, joint: usize, before: &[usize], compared: &mut usize) -> bool {
        let JointAxis::Prismatic(along) = self.axis(joint) else {
            return true;
        };
        let is_turn = |joint: usize| !self.frames.tree.slides[joint];
        before.iter().enumerate().all(|(place, &near)| {
            before[place..].iter().all(|&far| {
                *compared += 1;
                let kinds = [self.axis(far), self.axis(near)];
                let own = !(is_turn(far) || is_turn(near))
                    || self
                        .frames
                        .agree_on_slide((joint, along), [far, near], kinds);
                let between = match kinds {
                    [JointAxis::Revolute(_), JointAxis::Prismatic(between)] => {
                        let kinds = [kinds[0], self.axis(joint)];
                        self.frames
                            .agree_on_slide((near, between), [far, joint], kinds)
                    }
                    _ => true,
                };
                own && between
            })
        })
    }

    /// Other axes of single joints that agree as well.
    fn open(&mut self) -> Vec<(usize, JointAxis)> {
        let mut open = Vec::new();
        for joint in 0..self.chosen.len() {
            let chosen = self.chosen[joint];
            for other in (0..self.domains[joint].len()).filter(|&other| other != chosen) {
                self.chosen[joint] = other;
                let mut behind = self.frames.tree.behind[joint].iter();
                if self.unexplained[joint] || behind.all(|&behind| self.agrees(behind)) {
                    open.push((joint, self.axis(joint)));
                }
            }
            self.chosen[joint] = chosen;
        }
        open
    }
}
