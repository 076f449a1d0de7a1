//! The search for the choices that explain a mass matrix; see [`super::tree`].

use super::bodies::{CompositeInertia, JointAxis, RigidBody, Ring, Stand, UnitWrench, cross};
use super::model::ModelInputs;
use super::tree::JointPlacement;
use robovec_framework::fingerprint::{Fingerprint, Images};
use robovec_ir::{Input, Operation};
use robovec_num::arithmetic::Arithmetic;

/// The number of times that joints behind another may be explained anew to
/// explain that one.
const EFFORT: usize = 500;
/// The largest number of explanations of one column that are kept.
const MAX_OPTIONS: usize = 64;
/// The number of joints behind one whose choices are taken back to explain it.
const DEEPEST: usize = 3;

/// The numbers the search computes with.
#[derive(Clone, Copy)]
pub(super) struct FingerprintRing(pub(super) Images);

impl Ring for FingerprintRing {
    type Number = Fingerprint;
    fn zero(&mut self) -> Fingerprint {
        self.0.zero()
    }
    fn add(&mut self, a: Fingerprint, b: Fingerprint) -> Fingerprint {
        Arithmetic::add(&self.0, a, b)
    }
    fn sub(&mut self, a: Fingerprint, b: Fingerprint) -> Fingerprint {
        Arithmetic::sub(&self.0, a, b)
    }
    fn mul(&mut self, a: Fingerprint, b: Fingerprint) -> Fingerprint {
        Arithmetic::mul(&self.0, a, b)
    }
}

/// One explanation of a joint's column: its kind, the points its children
/// stand on, in order of the children, and whether the inertia of its body is
/// to be mirrored.
#[derive(Clone, PartialEq, Eq, Debug)]
struct JointChoice {
    joint: JointAxis,
    symmetric: bool,
    points: Vec<Option<usize>>,
}

/// The facts about a joint and all behind it.
struct JointState {
    /// Explanations, given what was chosen behind the joint.
    options: Vec<JointChoice>,
    chosen: usize,
    inertia: CompositeInertia<Fingerprint>,
    /// The joint's own and those behind it, with what a unit acceleration of
    /// each needs, on this joint's frame.
    wrenches: Vec<(usize, UnitWrench<Fingerprint>)>,
}

impl JointState {
    fn new(images: &Images) -> JointState {
        let zero = [[images.zero(); 3]; 3];
        JointState {
            options: Vec::new(),
            chosen: 0,
            inertia: CompositeInertia {
                a: zero,
                b: zero,
                d: zero,
            },
            wrenches: Vec::new(),
        }
    }
}

/// The choices made so far.
pub(super) struct CompositeSearch<'a> {
    model: &'a ModelInputs,
    images: Images,
    /// Row by row.
    matrix: Vec<Fingerprint>,
    children: Vec<Vec<usize>>,
    parents: Vec<Option<usize>>,
    states: Vec<JointState>,
    /// The number of times that joints may still be explained anew.
    effort: usize,
}

impl<'a> CompositeSearch<'a> {
    /// A search in which nothing is chosen yet; `matrix` is row by row.
    pub(super) fn new(
        model: &'a ModelInputs,
        images: Images,
        matrix: Vec<Fingerprint>,
        parents: Vec<Option<usize>>,
    ) -> CompositeSearch<'a> {
        let mut children = vec![Vec::new(); parents.len()];
        for (joint, parent) in parents.iter().enumerate() {
            if let Some(parent) = *parent {
                children[parent].push(joint);
            }
        }
        CompositeSearch {
            model,
            images,
            matrix,
            children,
            states: parents.iter().map(|_| JointState::new(&images)).collect(),
            parents,
            effort: EFFORT,
        }
    }

    fn exact(&self) -> FingerprintRing {
        FingerprintRing(self.images)
    }

    fn value(&self, input: Option<Input>) -> Fingerprint {
        input.map_or(self.images.zero(), |input| self.images.input(input))
    }

    fn stand(&self, joint: usize, kind: JointAxis, point: Option<usize>) -> Stand<Fingerprint> {
        let coordinate = self.value(self.model.coordinates[joint]);
        let turn = |operation| self.images.apply(operation, [coordinate; 3]);
        Stand {
            joint: kind,
            offset: point.map_or([self.images.zero(); 3], |point| {
                self.model.points[point].map(|part| self.value(part))
            }),
            coordinate,
            cosine: turn(Operation::Cos),
            sine: turn(Operation::Sin),
        }
    }

    fn kind(&self, joint: usize) -> JointAxis {
        let state = &self.states[joint];
        state.options[state.chosen].joint
    }

    /// Explains a joint, if need be by taking back choices behind it, the
    /// nearest first and further and further back, or with one more child.
    pub(super) fn settle(&mut self, joint: usize) -> bool {
        for depth in 0..=DEEPEST {
            if self.settle_within(joint, depth) {
                return true;
            }
            for sibling in self.untied(joint) {
                let parent = self.parents[joint];
                self.stand_on(sibling, Some(joint));
                if self.settle_within(joint, depth) {
                    return true;
                }
                self.stand_on(sibling, parent);
            }
        }
        false
    }

    /// Explains a joint by taking back choices at most so far behind it.
    fn settle_within(&mut self, joint: usize, depth: usize) -> bool {
        self.effort = EFFORT;
        for kind in self.kinds(joint) {
            let children = self.children[joint].clone();
            let fit = |search: &mut Self, child: usize| search.fit(joint, kind, child, depth);
            let mut more = children.into_iter().all(|child| fit(self, child));
            while more && self.effort > 0 {
                self.explain(joint);
                if !self.states[joint].options.is_empty() {
                    return true;
                }
                more = self.advance(joint, kind, depth);
            }
        }
        false
    }

    /// Brings the children on to the next explanations that fit a kind of
    /// their parent; false when there are no more.
    fn advance(&mut self, joint: usize, kind: JointAxis, depth: usize) -> bool {
        for child in self.children[joint].clone() {
            while self.effort > 0 && self.next(child, depth) {
                if !self.points(joint, kind, child).is_empty() {
                    return true;
                }
            }
            self.restart(child, depth);
            if !self.fit(joint, kind, child, depth) {
                return false;
            }
        }
        false
    }

    /// The kinds a joint may be of.
    fn kinds(&self, joint: usize) -> Vec<JointAxis> {
        let turns = self.model.turns[joint];
        let possible = |kind: &JointAxis| !turns || matches!(kind, JointAxis::Revolute(_));
        JointAxis::ALL.into_iter().filter(possible).collect()
    }

    /// Brings a child to an explanation that fits a kind of its parent.
    fn fit(&mut self, joint: usize, kind: JointAxis, child: usize, depth: usize) -> bool {
        if !self.points(joint, kind, child).is_empty() {
            return true;
        }
        self.restart(child, depth);
        loop {
            if !self.points(joint, kind, child).is_empty() {
                return true;
            }
            if self.effort == 0 || !self.next(child, depth) {
                self.restart(child, depth);
                return false;
            }
        }
    }

    /// Goes back to the first explanation of a joint.
    fn restart(&mut self, joint: usize, depth: usize) {
        if depth > 0 {
            for child in self.children[joint].clone() {
                self.restart(child, depth - 1);
            }
        }
        self.explain(joint);
    }

    /// The next explanation of a joint that differs from the present one at
    /// most so far behind it.
    fn next(&mut self, joint: usize, depth: usize) -> bool {
        let state = &mut self.states[joint];
        if state.chosen + 1 < state.options.len() {
            state.chosen += 1;
            self.compute(joint);
            return true;
        }
        if depth == 0 {
            return false;
        }
        for child in self.children[joint].clone() {
            while self.effort > 0 && self.next(child, depth - 1) {
                self.explain(joint);
                if !self.states[joint].options.is_empty() {
                    return true;
                }
            }
            self.restart(child, depth - 1);
        }
        false
    }

    /// Later joints with the same parent that may as well stand on this one:
    /// nothing ties them to it, as with axes at right angles.
    fn untied(&self, joint: usize) -> Vec<usize> {
        let count = self.model.len();
        let tied = |other: usize| self.model.elements[other * count + joint].is_some();
        let Some(parent) = self.parents[joint] else {
            return Vec::new();
        };
        let siblings = self.children[parent].iter().copied();
        siblings
            .filter(|&other| other > joint && !tied(other))
            .filter(|&other| !self.behind(other).into_iter().any(tied))
            .collect()
    }

    /// Gives a joint another parent.
    fn stand_on(&mut self, joint: usize, parent: Option<usize>) {
        if let Some(old) = self.parents[joint] {
            self.children[old].retain(|&child| child != joint);
        }
        self.parents[joint] = parent;
        if let Some(new) = parent {
            self.children[new].push(joint);
            self.children[new].sort_unstable();
        }
    }

    /// The joints behind a joint, the nearest first.
    fn behind(&self, joint: usize) -> Vec<usize> {
        let mut behind = self.children[joint].clone();
        let mut next = 0;
        while next < behind.len() {
            behind.extend_from_slice(&self.children[behind[next]]);
            next += 1;
        }
        behind
    }

    /// Finds all explanations of a joint's column, given what is chosen behind
    /// it, and takes the first.
    fn explain(&mut self, joint: usize) {
        self.effort = self.effort.saturating_sub(1);
        let mut options = Vec::new();
        for kind in self.kinds(joint) {
            self.explain_as(joint, kind, &mut options);
        }
        let state = &mut self.states[joint];
        state.options = options;
        state.chosen = 0;
        if !state.options.is_empty() {
            self.compute(joint);
        }
    }

    fn explain_as(&self, joint: usize, kind: JointAxis, options: &mut Vec<JointChoice>) {
        let children = &self.children[joint];
        let points: Vec<Vec<Option<usize>>> = children
            .iter()
            .map(|&child| self.points(joint, kind, child))
            .collect();
        if points.iter().any(Vec::is_empty) {
            return;
        }
        // The diagonal element is the sum of what each part adds to it.
        let parts: Vec<Vec<Fingerprint>> = points
            .iter()
            .zip(children)
            .map(|(points, &child)| {
                let part =
                    |&point: &Option<usize>| self.moved(child, point).wrench(kind).along(kind);
                points.iter().map(part).collect()
            })
            .collect();
        let diagonal = self.matrix[joint * self.model.len() + joint];
        let body = self.model.bodies[joint];
        for symmetric in [true, false] {
            if !symmetric && body.mirrored(true) == body {
                continue;
            }
            let own = self.own(joint, symmetric).wrench(kind).along(kind);
            let mut digits = vec![0; points.len()];
            loop {
                let chosen = parts.iter().zip(&digits).map(|(list, &at)| list[at]);
                if self.images.add(own, self.images.sum(chosen)) == diagonal {
                    let chosen = points.iter().zip(&digits).map(|(list, &at)| list[at]);
                    options.push(JointChoice {
                        joint: kind,
                        symmetric,
                        points: chosen.collect(),
                    });
                }
                if options.len() >= MAX_OPTIONS || !advance(&mut digits, &points) {
                    break;
                }
            }
        }
    }

    /// The points a child may stand on so that everything behind it gives the
    /// right elements of its parent's column.
    fn points(&self, joint: usize, kind: JointAxis, child: usize) -> Vec<Option<usize>> {
        if self.states[child].options.is_empty() {
            return Vec::new();
        }
        let stand = self.stand(child, self.kind(child), None);
        let wrenches: Vec<(usize, UnitWrench<Fingerprint>)> = self.states[child]
            .wrenches
            .iter()
            .map(|&(one, wrench)| (one, stand.turned(&mut self.exact(), wrench)))
            .collect();
        let fits = |point: Option<usize>| {
            let arm = self
                .stand(child, self.kind(child), point)
                .arm(&mut self.exact());
            wrenches.iter().all(|&(one, wrench)| {
                let moment = cross(&mut self.exact(), arm, wrench.force);
                let torque = [0, 1, 2].map(|i| self.images.add(wrench.torque[i], moment[i]));
                let value = UnitWrench { torque, ..wrench }.along(kind);
                value == self.matrix[one * self.model.len() + joint]
            })
        };
        let points = (0..self.model.points.len()).map(Some);
        std::iter::once(None)
            .chain(points)
            .filter(|&point| fits(point))
            .collect()
    }

    /// The inertia of a joint's own body.
    fn own(&self, joint: usize, symmetric: bool) -> CompositeInertia<Fingerprint> {
        let body = self.model.bodies[joint].mirrored(symmetric);
        let body = RigidBody {
            mass: self.value(body.mass),
            centre: body.centre.map(|part| self.value(part)),
            inertia: body.inertia.map(|row| row.map(|part| self.value(part))),
        };
        CompositeInertia::of(&mut self.exact(), &body)
    }

    /// The inertia of a child and of all behind it, as part of its parent's.
    fn moved(&self, child: usize, point: Option<usize>) -> CompositeInertia<Fingerprint> {
        let stand = self.stand(child, self.kind(child), point);
        stand.inertia(&mut self.exact(), &self.states[child].inertia)
    }

    /// Inertia and wrenches that follow from the choice made for a joint.
    fn compute(&mut self, joint: usize) {
        let state = &self.states[joint];
        let choice = state.options[state.chosen].clone();
        let mut inertia = self.own(joint, choice.symmetric);
        for (&child, &point) in self.children[joint].iter().zip(&choice.points) {
            inertia = inertia.plus(&mut self.exact(), &self.moved(child, point));
        }
        let mut wrenches = vec![(joint, inertia.wrench(choice.joint))];
        for (&child, &point) in self.children[joint].iter().zip(&choice.points) {
            let stand = self.stand(child, self.kind(child), point);
            for &(one, wrench) in &self.states[child].wrenches {
                wrenches.push((one, stand.wrench(&mut self.exact(), wrench)));
            }
        }
        self.states[joint].inertia = inertia;
        self.states[joint].wrenches = wrenches;
    }

    /// The placements that have been chosen.
    pub(super) fn places(&self) -> Vec<JointPlacement> {
        let mut places: Vec<JointPlacement> = (0..self.model.len())
            .map(|joint| JointPlacement {
                parent: self.parents[joint],
                joint: self.kind(joint),
                point: None,
                symmetric: false,
            })
            .collect();
        for (joint, state) in self.states.iter().enumerate() {
            let choice = &state.options[state.chosen];
            places[joint].symmetric = choice.symmetric;
            let points = &choice.points;
            for (&child, &point) in self.children[joint].iter().zip(points) {
                places[child].point = point;
            }
        }
        places
    }
}

/// Counts on in mixed radix; false at the end.
fn advance(digits: &mut [usize], lists: &[Vec<Option<usize>>]) -> bool {
    for (digit, list) in digits.iter_mut().zip(lists) {
        *digit += 1;
        if *digit < list.len() {
            return true;
        }
        *digit = 0;
    }
    false
}
