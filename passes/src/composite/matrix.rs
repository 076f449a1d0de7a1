//! The mass matrix from composite bodies, over any ring.

use super::bodies::{CompositeInertia, JointAxis, RigidBody, Ring, Stand};

/// The placement of a joint on its parent.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct JointPlacement {
    /// The joint before it, counted from 0.
    pub(super) parent: Option<usize>,
    /// Its kind.
    pub(super) joint: JointAxis,
    /// The points of the parent, in [`ModelInputs::points`](super::model::ModelInputs::points), whose sum it
    /// is on: one, or none for the origin. Where joints that only slide
    /// follow one another, all of their points may be here.
    pub(super) points: Vec<usize>,
    /// The inertia of its body is mirrored about the diagonal.
    pub(super) symmetric: bool,
}

/// A tree of bodies in the numbers of a ring. Joints are counted from 0, and
/// the body of a joint is the last one that it moves.
pub(super) trait BodySystem: Ring {
    /// Called before the composite body of a joint is made.
    fn enter(&mut self, joint: usize);

    /// The body of a joint, with the missing half of its inertia mirrored if
    /// its placement requires that.
    fn body(&mut self, joint: usize, place: &JointPlacement) -> RigidBody<Self::Number>;

    fn stand(&mut self, joint: usize, place: &JointPlacement) -> Stand<Self::Number>;
}

/// The matrix, row by row, and the composite body of each joint.
pub(super) fn mass_matrix<S: BodySystem>(
    system: &mut S,
    places: &[JointPlacement],
) -> (Vec<S::Number>, Vec<CompositeInertia<S::Number>>) {
    let count = places.len();
    let mut composites = Vec::with_capacity(count);
    let mut made = vec![system.zero(); count * count];
    let mut inertias: Vec<Option<CompositeInertia<S::Number>>> = vec![None; count];
    for joint in (0..count).rev() {
        system.enter(joint);
        let body = system.body(joint, &places[joint]);
        let own = CompositeInertia::of(system, &body);
        let inertia = match &inertias[joint] {
            Some(behind) => own.plus(system, behind),
            None => own,
        };
        composites.push(inertia);
        let mut wrench = inertia.wrench(places[joint].joint);
        let mut at = joint;
        made[joint * count + joint] = wrench.along(places[joint].joint);
        while let Some(parent) = places[at].parent {
            assert!(parent < at, "a joint comes after the one before it");
            let stand = system.stand(at, &places[at]);
            wrench = stand.wrench(system, wrench);
            made[joint * count + parent] = wrench.along(places[parent].joint);
            made[parent * count + joint] = made[joint * count + parent];
            at = parent;
        }
        if let Some(parent) = places[joint].parent {
            let stand = system.stand(joint, &places[joint]);
            let moved = stand.inertia(system, &inertia);
            inertias[parent] = Some(match &inertias[parent] {
                Some(others) => others.plus(system, &moved),
                None => moved,
            });
        }
    }
    composites.reverse();
    (made, composites)
}
