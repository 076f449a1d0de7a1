//! Families of models for studies and tests: chains, trees, random trees, and
//! existing machines, whose files are those of `examples/models`.
//!
//! **The frozen serial model** (the one that reproduces the operation counts of
//! the thesis, Table 3.1): revolute joints about the first and second axis in
//! turn; each body is attached to the point `(0, 0, d3)` of the one before, has
//! its centre of mass at `(l1, 0, 0)`, a mass and a full matrix of inertia. The
//! semi-serial and parallel models have the same bodies in other trees.
//!
//! **Invariant.** A model depends on family, number of joints and seed alone,
//! to the last bit. Inertias are those of clouds of points, hence physically
//! possible.

use super::build::{BASE, BodyPlace, BodyRef, ModelBuilder};
use super::mbs::read_mbs;
use super::{Axis, JointKind, Model};
use robovec_num::limits::NumberLimit;
use robovec_num::random::Random;
use robovec_robotran::conventions::JOINT_LIMIT;

/// Limit of the number of joints of a family.
pub const JOINTS: NumberLimit = NumberLimit::whole(
    1,
    JOINT_LIMIT as u64,
    "a mass matrix has as many rows and columns",
);

/// A kind of model that can be requested by name.
#[derive(Clone, Copy, Debug)]
pub struct ModelFamily {
    name: &'static str,
    joints: Option<usize>,
    members: FamilyMembers,
}

#[derive(Clone, Copy, Debug)]
enum FamilyMembers {
    /// Models of the frozen kind, on the tree for a number of joints.
    Trees(fn(usize) -> TrunkTree),
    /// Random trees with joints of all six types.
    Random,
    /// One model, of an existing machine, read from a file.
    File(&'static [u8]),
}

/// The family of the one model of a file.
macro_rules! machine {
    ($name:literal, $joints:literal) => {
        ModelFamily {
            name: $name,
            joints: Some($joints),
            members: FamilyMembers::File(include_bytes!(concat!("models/", $name, ".mbs"))),
        }
    };
}

impl ModelFamily {
    /// All families.
    pub const ALL: [ModelFamily; 14] = [
        ModelFamily::trees("serial", None, TrunkTree::serial),
        ModelFamily::trees("semi-serial", None, TrunkTree::semi_serial),
        ModelFamily::trees("parallel", None, TrunkTree::parallel),
        ModelFamily::trees("thesis-70", Some(70), |_| TrunkTree::thesis_70()),
        ModelFamily {
            name: "random",
            joints: None,
            members: FamilyMembers::Random,
        },
        machine!("bogie", 23),
        machine!("train", 70),
        machine!("double-pendulum", 2),
        machine!("four-bar", 3),
        machine!("slider-crank", 2),
        machine!("quarter-car", 5),
        machine!("car", 18),
        machine!("wishbone-car", 45),
        machine!("leg", 9),
    ];

    const fn trees(
        name: &'static str,
        joints: Option<usize>,
        tree: fn(usize) -> TrunkTree,
    ) -> ModelFamily {
        ModelFamily {
            name,
            joints,
            members: FamilyMembers::Trees(tree),
        }
    }

    /// The family's name.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// The family with this name.
    pub fn from_name(name: &str) -> Option<ModelFamily> {
        ModelFamily::ALL
            .into_iter()
            .find(|family| family.name == name)
    }

    /// The number of joints, for families of one size.
    pub fn joints(self) -> Option<usize> {
        self.joints
    }

    /// True when the seed decides the parameters.
    pub fn is_seeded(self) -> bool {
        !matches!(self.members, FamilyMembers::File(_))
    }

    /// The model of the family with this number of joints, if sizes differ.
    ///
    /// # Panics
    ///
    /// Panics when `joints` is 0 and the family has more than one size.
    pub fn build(self, joints: usize, seed: u64) -> Model {
        match self.members {
            FamilyMembers::Trees(topology) => {
                let mut name = self.name.replace('-', "_");
                if self.joints.is_none() {
                    name += &format!("_{joints}");
                }
                tree(&name, &topology(joints), seed)
            }
            FamilyMembers::Random => random_tree(seed, joints),
            FamilyMembers::File(file) => {
                let read = read_mbs(self.name, file);
                read.expect("files of the program are sound").model
            }
        }
    }
}

/// A tree in the form of a trunk, on whose last body branches hang.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TrunkTree {
    /// Number of bodies of the trunk; 0 when branches are attached to the base.
    pub trunk: usize,
    /// The number of bodies of each branch.
    pub branches: Vec<usize>,
}

impl TrunkTree {
    /// The number of bodies, each with one joint.
    pub fn joints(&self) -> usize {
        self.trunk + self.branches.iter().sum::<usize>()
    }

    /// The number of pairs of a body and one of its ancestors or itself: the
    /// non-zero entries of a triangle of the mass matrix.
    pub fn pairs(&self) -> usize {
        let branch = |&length: &usize| length * (length + 1) / 2 + length * self.trunk;
        self.trunk * (self.trunk + 1) / 2 + self.branches.iter().map(branch).sum::<usize>()
    }

    /// A chain.
    pub fn serial(joints: usize) -> TrunkTree {
        TrunkTree {
            trunk: joints,
            branches: Vec::new(),
        }
    }

    /// A trunk with a few long branches. The thesis does not give its trees: for
    /// 23, 50, 70, 100 and 130 joints this is one whose equations come close to
    /// those of its Table 3.1 in operations and path; for other numbers a trunk
    /// of an eighth of the bodies and five branches.
    pub fn semi_serial(joints: usize) -> TrunkTree {
        let (trunk, branches) = match joints {
            23 => (3, vec![7, 4, 4, 4, 1]),
            50 => (1, vec![22, 22, 2, 2, 1]),
            70 => (2, vec![14, 14, 8, 8, 8, 8, 8]),
            100 => (2, vec![14; 7]),
            130 => (6, vec![21, 21, 17, 17, 16, 16, 16]),
            _ => {
                let trunk = joints.div_ceil(8);
                (trunk, even(joints - trunk, 5))
            }
        };
        TrunkTree { trunk, branches }
    }

    /// Many branches on the base or on one body. The numbers of joints fitted
    /// to the thesis are those of [`TrunkTree::semi_serial`]; others have about
    /// as many branches as each branch has bodies.
    pub fn parallel(joints: usize) -> TrunkTree {
        let (trunk, branches) = match joints {
            23 => (1, vec![8, 3, 3, 3, 3, 2]),
            50 => (0, vec![14, 5, 5, 5, 5, 5, 5, 5, 1]),
            70 => (0, long_and_short(17, 53, 13)),
            100 => (0, long_and_short(23, 77, 11)),
            130 => (0, vec![30, 13, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 7]),
            _ => (0, even(joints, joints.isqrt())),
        };
        TrunkTree { trunk, branches }
    }

    /// The tree that comes close to the 70-dof system of the thesis.
    pub fn thesis_70() -> TrunkTree {
        TrunkTree {
            trunk: 9,
            branches: vec![35, 15, 11],
        }
    }
}

/// Splits a total into parts that differ by at most one, without empty parts.
fn even(total: usize, parts: usize) -> Vec<usize> {
    let parts = parts.clamp(1, total.max(1));
    let lengths = (0..parts).map(|part| total / parts + usize::from(part < total % parts));
    let lengths: Vec<usize> = lengths.filter(|&length| length > 0).collect();
    assert_eq!(lengths.iter().sum::<usize>(), total, "nothing is left over");
    lengths
}

/// One long branch and several short ones.
fn long_and_short(long: usize, rest: usize, parts: usize) -> Vec<usize> {
    let mut branches = vec![long];
    branches.extend(even(rest, parts));
    branches
}

/// A model of the frozen kind on a tree.
///
/// # Panics
///
/// Panics when the tree has no body.
pub fn tree(name: &str, topology: &TrunkTree, seed: u64) -> Model {
    assert!(topology.joints() > 0, "a model has at least one body");
    let mut random = ParameterRandom::new(seed);
    let mut builder = ModelBuilder::new(name);
    let mut number = 0;
    let mut body = |builder: &mut ModelBuilder, on: BodyPlace, depth: usize| {
        number += 1;
        let axis = if depth.is_multiple_of(2) {
            Axis::X
        } else {
            Axis::Y
        };
        let name = format!("Body_{number}");
        let body = builder.body(&name, on, &[JointKind::Revolute(axis)]);
        let mass = random.between(0.5, 5.0);
        let center = [random.signed(0.02, 0.2), 0.0, 0.0];
        builder.mass(body, mass, center, inertia(&mut random, mass, 0.15));
        builder.joint(body, 0).initial[0] = random.signed(0.05, 0.5);
        body
    };
    let mut heights = ParameterRandom::new(seed ^ 0x5eed);
    let mut next = |builder: &mut ModelBuilder, on: BodyRef, name: &str| {
        let place = [0.0, 0.0, heights.between(0.1, 0.5)];
        builder.point(on, name, place)
    };
    let mut place = BASE.origin();
    let mut last = BASE;
    for depth in 0..topology.trunk {
        last = body(&mut builder, place, depth);
        if depth + 1 < topology.trunk {
            place = next(&mut builder, last, "Next");
        }
    }
    for (branch, &length) in topology.branches.iter().enumerate() {
        let mut place = if topology.trunk == 0 {
            BASE.origin()
        } else {
            next(&mut builder, last, &format!("Branch_{}", branch + 1))
        };
        for step in 0..length {
            let on = body(&mut builder, place, topology.trunk + step);
            if step + 1 < length {
                place = next(&mut builder, on, "Next");
            }
        }
    }
    assert_eq!(number, topology.joints(), "the tree is built as a whole");
    builder.finish()
}

/// The frozen serial model.
///
/// # Panics
///
/// Panics when there is no joint.
pub fn serial(joints: usize, seed: u64) -> Model {
    let name = format!("serial_{joints}");
    tree(&name, &TrunkTree::serial(joints), seed)
}

/// The inertia of six points of a body about their centre, kg m^2, in the
/// order of [`super::Body::inertia`]: full, and physically possible.
fn inertia(random: &mut ParameterRandom, mass: f64, size: f64) -> [f64; 6] {
    let mut points = [[0.0; 3]; 6];
    for coordinate in points.iter_mut().flatten() {
        *coordinate = random.signed(0.1 * size, size);
    }
    let mean: [f64; 3] = std::array::from_fn(|axis| {
        points.iter().map(|point| point[axis]).sum::<f64>() / points.len() as f64
    });
    let mut sums = [0.0; 6];
    for point in points {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|axis| point[axis] - mean[axis]);
        let terms = [
            y * y + z * z,
            -x * y,
            -x * z,
            x * x + z * z,
            -y * z,
            x * x + y * y,
        ];
        for (sum, term) in sums.iter_mut().zip(terms) {
            *sum += term * mass / points.len() as f64;
        }
    }
    sums.map(four_digits)
}

/// A random tree with joints of all six types, for tests. Bodies have one to
/// three joints in series, of different types: the mass matrix is regular; they
/// are on the base, points and origins; some parameters are zero.
///
/// # Panics
///
/// Panics when there is no joint.
pub fn random_tree(seed: u64, joints: usize) -> Model {
    assert!(joints > 0, "a model has at least one joint");
    let mut random = ParameterRandom::new(seed ^ 0x7ee5);
    let mut builder = ModelBuilder::new(&format!("random_{joints}"));
    builder.gravity([0.0, 0.0, -9.81]);
    let mut bodies: Vec<BodyRef> = Vec::new();
    let mut left = joints;
    // Types in a random order, over and over, so that all six occur.
    let mut deck: Vec<JointKind> = Vec::new();
    while left > 0 {
        let count = (1 + random.below(3)).min(left);
        left -= count;
        let mut kinds: Vec<JointKind> = Vec::new();
        while kinds.len() < count {
            if deck.is_empty() {
                deck.extend(JointKind::ALL);
            }
            let kind = deck.swap_remove(random.below(deck.len()));
            // The end of one deck and the start of the next may hold the same.
            if kinds.contains(&kind) {
                deck.push(kind);
                deck.extend(JointKind::ALL);
            } else {
                kinds.push(kind);
            }
        }
        let on = match bodies.len() {
            0 => BASE,
            // Mostly near the end, so that there are long branches.
            len if random.once_in(3) => bodies[random.below(len)],
            len => bodies[len - 1],
        };
        let number = bodies.len() + 1;
        let place = if random.once_in(4) {
            on.origin()
        } else {
            let place = std::array::from_fn(|_| sparse(&mut random, 0.05, 0.8));
            builder.point(on, &format!("Point_{number}"), place)
        };
        let body = builder.body(&format!("Body_{number}"), place, &kinds);
        random_mass(&mut builder, body, &mut random);
        bodies.push(body);
    }
    let model = builder.finish();
    assert_eq!(model.joints.len(), joints, "as many joints as asked for");
    model
}

/// A random number of either sign, zero once in four times.
fn sparse(random: &mut ParameterRandom, low: f64, high: f64) -> f64 {
    let value = random.signed(low, high);
    if random.once_in(4) { 0.0 } else { value }
}

fn random_mass(builder: &mut ModelBuilder, body: BodyRef, random: &mut ParameterRandom) {
    let mass = random.between(0.2, 4.0);
    let center = std::array::from_fn(|_| sparse(random, 0.02, 0.3));
    let mut inertia = inertia(random, mass, 0.3);
    if random.once_in(3) {
        // Without products the moments are still those of a cloud of points.
        for product in [1, 2, 4] {
            inertia[product] = 0.0;
        }
    }
    builder.mass(body, mass, center, inertia);
}

/// The family and the number of joints of a name like `bogie` or `serial-23`.
fn named(name: &str) -> Option<(ModelFamily, usize)> {
    if let Some(family) = ModelFamily::from_name(name) {
        return family.joints().map(|joints| (family, joints));
    }
    let (family, joints) = name.rsplit_once('-')?;
    let family = ModelFamily::from_name(family).filter(|family| family.joints().is_none())?;
    let joints = JOINTS.read_whole(joints).ok()?;
    Some((family, joints as usize))
}

/// Tests whether a name is that of a built-in model.
pub fn is_built_in(name: &str) -> bool {
    named(name).is_some()
}

/// The built-in model of a name like `bogie` or `serial-23`; its parameters are
/// those of the seed 1, and equations do not depend on them.
pub fn built_in(name: &str) -> Option<Model> {
    let (family, joints) = named(name)?;
    Some(family.build(joints, 1))
}

#[cfg(test)]
mod tests;

#[derive(Clone, Debug)]
pub(crate) struct ParameterRandom(Random);

impl ParameterRandom {
    pub(crate) fn new(seed: u64) -> ParameterRandom {
        ParameterRandom(Random::new(seed))
    }

    /// A number from 0 to below `count`, which is not zero.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        self.0.below(count)
    }

    pub(crate) fn once_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    /// A number in a range, with four digits, so that files stay short.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        debug_assert!(low <= high, "a range ends after its start");
        four_digits(low + (high - low) * self.0.unit())
    }

    /// As [`ParameterRandom::between`], of either sign.
    pub(crate) fn signed(&mut self, low: f64, high: f64) -> f64 {
        let size = self.between(low, high);
        if self.once_in(2) { -size } else { size }
    }
}

/// The nearest number with four significant digits.
pub(crate) fn four_digits(value: f64) -> f64 {
    let text = format!("{value:.3e}");
    text.parse().expect("the text of a number is one")
}
