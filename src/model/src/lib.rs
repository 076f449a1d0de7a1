//! Models: the bodies, joints, points and loops that equations are made of.
//!
//! A model has the contents of a `.mbs` file without its drawings, or those
//! built by a program. All lists are flat and in file order, because Robotran's
//! numbers are places in these lists: a joint id counts joints over all bodies,
//! a point id (the column of `dpt`) counts the points of the base first, then
//! those of the bodies. Both count from 1 in files and messages, from 0 here.
//!
//! **Invariants** (upheld by every reader and builder of models, and verified
//! by [`Model::check`]): a joint's parent has a smaller index; a body has at
//! least one joint and its joints are consecutive; points are in the order of
//! their bodies and sensors in the order of their points; every index is in
//! range; every number is finite.

pub mod build;
pub mod family;
pub mod mbs;
mod mounting;
mod physics;
mod reading;
pub mod robot;
mod rotation;
pub mod summary;
mod xml;

pub use mounting::{ConstantTurn, JointCoupling, JointMounting};
use std::ops::Range;

/// A multibody system. Lengths are in m, masses in kg, angles in rad.
#[derive(Clone, PartialEq, Debug)]
pub struct Model {
    /// The name of the project, the suffix of Robotran's files.
    pub name: String,
    /// Acceleration of gravity in the base frame, m/s^2; usually `(0, 0, -9.81)`.
    pub gravity: [f64; 3],
    /// The bodies, in file order.
    pub bodies: Vec<Body>,
    /// The joints of all bodies, in file order; joint id = index + 1.
    pub joints: Vec<Joint>,
    /// Points of the base, then of the bodies; point id = index + 1.
    pub points: Vec<ModelPoint>,
    /// Cuts of loops, in file order, which is the order of their rows.
    pub cuts: Vec<Cut>,
    /// Point-to-point links that carry a force along their line.
    pub links: Vec<Link>,
    /// Links that carry a force and a torque (Robotran's `link3D`).
    pub links3d: Vec<Link>,
    /// Sensors, in order of appearance; sensor number = index + 1.
    pub sensors: Vec<Sensor>,
    /// Points where external forces act, in their order; number = index + 1.
    pub forces: Vec<Sensor>,
    /// Frames of bodies by name: the links of a robot.
    pub frames: Vec<NamedFrame>,
    /// User models: named groups of parameters for the user's functions. The
    /// equations do not depend on them.
    pub user_models: Vec<UserModel>,
}

/// A rigid body.
#[derive(Clone, PartialEq, Debug)]
pub struct Body {
    /// Unique name.
    pub name: String,
    /// The body it is attached to; `None` for the base.
    pub parent: Option<usize>,
    /// Point of the parent it is attached to; `None` for its origin.
    pub point: Option<usize>,
    /// Its joints, from the parent on; mass, centre and inertia belong to the
    /// last of them, the others move fictitious bodies without mass.
    pub joints: Range<usize>,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the body's frame, m.
    pub center: [f64; 3],
    /// Moments of inertia about the centre of mass in the body's frame, kg m^2:
    /// `Ixx Ixy Ixz Iyy Iyz Izz`, entries of the matrix (`-∫xy dm`).
    pub inertia: [f64; 6],
}

/// The kind of a joint, and of its axis.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum JointKind {
    /// A translation along an axis.
    Prismatic(Axis),
    /// A rotation about an axis.
    Revolute(Axis),
}

/// An axis of a frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Axis {
    /// The first axis.
    X,
    /// The second axis.
    Y,
    /// The third axis.
    Z,
}

impl Axis {
    /// The three axes, in order.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }
}

impl JointKind {
    /// `T1`, `T2`, `T3`, `R1`, `R2`, `R3`, in this order.
    pub const ALL: [JointKind; 6] = [
        JointKind::Prismatic(Axis::X),
        JointKind::Prismatic(Axis::Y),
        JointKind::Prismatic(Axis::Z),
        JointKind::Revolute(Axis::X),
        JointKind::Revolute(Axis::Y),
        JointKind::Revolute(Axis::Z),
    ];

    /// Robotran's name: `T1` to `R3`.
    pub fn name(self) -> &'static str {
        match self {
            JointKind::Prismatic(Axis::X) => "T1",
            JointKind::Prismatic(Axis::Y) => "T2",
            JointKind::Prismatic(Axis::Z) => "T3",
            JointKind::Revolute(Axis::X) => "R1",
            JointKind::Revolute(Axis::Y) => "R2",
            JointKind::Revolute(Axis::Z) => "R3",
        }
    }

    /// The kind with this name.
    pub fn from_name(name: &str) -> Option<JointKind> {
        JointKind::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The axis of the joint.
    pub fn axis(self) -> Axis {
        match self {
            JointKind::Prismatic(axis) | JointKind::Revolute(axis) => axis,
        }
    }

    /// True for a rotation.
    pub fn is_revolute(self) -> bool {
        matches!(self, JointKind::Revolute(_))
    }
}

robovec_num::named! {
    /// Cause of a joint's motion.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
    pub enum Nature {
        /// A degree of freedom.
        Independent = "independent",
        /// Follows from the loops.
        Dependent = "dependent",
        /// Given as a function of time.
        Driven = "driven",
    }
}

/// A joint with one degree of freedom.
#[derive(Clone, PartialEq, Debug)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// Kind and axis.
    pub kind: JointKind,
    /// Cause of its motion.
    pub nature: Nature,
    /// The body of the point.
    pub body: usize,
    /// The joint before it on the way to the base; `None` for the base.
    pub parent: Option<usize>,
    /// Place where it is attached, a point of the parent joint's body: the
    /// body's [`Body::point`] for its first joint, `None` for the others.
    pub point: Option<usize>,
    /// True when velocity `qd` is a symbol of the equations. A driven joint
    /// whose file lists symbols without this one has a structural zero instead.
    pub has_velocity: bool,
    /// True when the acceleration `qdd` is a symbol of the equations; see
    /// [`Joint::has_velocity`].
    pub has_acceleration: bool,
    /// True when the model declares a motor on the joint.
    pub actuated: bool,
    /// Initial position (m or rad), velocity and acceleration.
    pub initial: [f64; 3],
    /// Place where its frame is on the one before.
    pub mounting: JointMounting,
    /// Smallest and greatest position (m or rad), where the model limits it.
    pub limits: Option<[f64; 2]>,
    /// The forces along its motion that the file of a robot gives.
    pub law: JointLaw,
    /// Inertia of the rotor that the joint turns by a gear, as the joint feels
    /// it: that of the rotor times the square of the gear ratio, kg m^2, or kg
    /// for a translation. It is added to the diagonal of `M`; that the rotor
    /// also turns with the body before it is neglected.
    pub armature: f64,
}

/// The forces of a joint alone, which are laws and in no equation.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub struct JointLaw {
    /// Viscous damping, N s/m or N m s/rad.
    pub damping: f64,
    /// Dry friction, N or N m.
    pub friction: f64,
    /// Stiffness of a spring, N/m or N m/rad.
    pub stiffness: f64,
    /// The position in which the spring gives no force, m or rad.
    pub neutral: f64,
}

impl JointLaw {
    /// True where there are any.
    pub fn are_there(&self) -> bool {
        self.damping != 0.0 || self.friction != 0.0 || self.stiffness != 0.0
    }
}

/// A named point of the base or of a body.
#[derive(Clone, PartialEq, Debug)]
pub struct ModelPoint {
    /// Name, unique within its body.
    pub name: String,
    /// The body; `None` for the base.
    pub body: Option<usize>,
    /// Coordinates in the body's frame, m.
    pub coordinates: [f64; 3],
}

/// A place on a body: a named point, or its origin.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Anchor {
    /// The body; `None` for the base.
    pub body: Option<usize>,
    /// The point; `None` for the body's origin.
    pub point: Option<usize>,
}

/// Way in which a loop is cut.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum CutKind {
    /// Two points coincide: 3 rows.
    Ball,
    /// Two points keep a distance (m): 1 row.
    Rod(f64),
    /// Two frames coincide: 6 rows.
    Solid,
    /// A joint follows another one: 1 row. The ends are the bodies of both.
    Coupling(JointCoupling),
}

impl CutKind {
    /// Number of constraint rows, identically zero ones included.
    pub fn rows(self) -> usize {
        match self {
            CutKind::Ball => 3,
            CutKind::Rod(_) | CutKind::Coupling(_) => 1,
            CutKind::Solid => 6,
        }
    }
}

/// A cut of a loop.
#[derive(Clone, PartialEq, Debug)]
pub struct Cut {
    /// Name.
    pub name: String,
    /// Condition at the cut.
    pub kind: CutKind,
    /// The two places that the cut separates.
    pub ends: [Anchor; 2],
    /// Directions of a ball cut that are left out.
    pub ignore: [bool; 3],
    /// The matrix from the frame of the second end to that of the first where a
    /// solid cut is closed; `None` where both coincide.
    pub rotation: Option<[[f64; 3]; 3]>,
}

impl Cut {
    /// Number of constraint rows, without ignored directions, with zero ones.
    pub fn rows(&self) -> usize {
        let ignored = self.ignore.iter().filter(|&&ignored| ignored).count();
        self.kind.rows()
            - if self.kind == CutKind::Ball {
                ignored
            } else {
                0
            }
    }
}

/// A force element between two places.
#[derive(Clone, PartialEq, Debug)]
pub struct Link {
    /// Name.
    pub name: String,
    /// The two places.
    pub ends: [Anchor; 2],
}

/// A point whose motion is computed: a sensor, or where an external force acts.
#[derive(Clone, PartialEq, Debug)]
pub struct Sensor {
    /// Name.
    pub name: String,
    /// The point it sits on.
    pub point: usize,
    /// Quantities requested.
    pub asks: Asks,
}

/// A frame on a body, or on the base, that has a name.
#[derive(Clone, PartialEq, Debug)]
pub struct NamedFrame {
    /// Unique name.
    pub name: String,
    /// The body; `None` for the base.
    pub body: Option<usize>,
    /// Its origin in the body's frame, m.
    pub origin: [f64; 3],
    /// The matrix that takes components in it to those in the body's frame.
    pub rotation: [[f64; 3]; 3],
}

/// Quantities requested from a sensor; all in the base frame.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Asks {
    /// Position.
    pub position: bool,
    /// Rotation matrix.
    pub rotation: bool,
    /// Velocity.
    pub velocity: bool,
    /// Angular velocity.
    pub angular_velocity: bool,
    /// Acceleration.
    pub acceleration: bool,
    /// Angular acceleration.
    pub angular_acceleration: bool,
    /// Jacobian of velocity and angular velocity.
    pub jacobian: bool,
}

impl Asks {
    /// Robotran's names, in the order of the fields.
    pub const NAMES: [&str; 7] = ["Pos", "Rot", "Vit", "Om", "Acc", "Omp", "Jac"];

    /// The field that Robotran calls so.
    pub fn field(&mut self, name: &str) -> Option<&mut bool> {
        Some(match name {
            "Pos" => &mut self.position,
            "Rot" => &mut self.rotation,
            "Vit" => &mut self.velocity,
            "Om" => &mut self.angular_velocity,
            "Acc" => &mut self.acceleration,
            "Omp" => &mut self.angular_acceleration,
            "Jac" => &mut self.jacobian,
            _ => return None,
        })
    }
}

/// A named group of parameters of the user's functions.
#[derive(Clone, PartialEq, Debug)]
pub struct UserModel {
    /// Name.
    pub name: String,
    /// Name, type (`scalar`, `vector`, …) and values of each parameter.
    pub parameters: Vec<(String, String, Vec<f64>)>,
}

/// The number of the joint or body of an index: one more, and 0 for the base.
pub fn number(index: Option<usize>) -> usize {
    index.map_or(0, |index| index + 1)
}

impl Body {
    /// The matrix of inertia, row by row, as the nine rows of `In`.
    pub fn inertia_matrix(&self) -> [f64; 9] {
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        [xx, xy, xz, xy, yy, yz, xz, yz, zz]
    }
}

impl Model {
    /// A model of nothing.
    pub fn new(name: &str) -> Model {
        Model {
            name: name.to_owned(),
            gravity: [0.0, 0.0, -9.81],
            bodies: Vec::new(),
            joints: Vec::new(),
            points: Vec::new(),
            cuts: Vec::new(),
            links: Vec::new(),
            links3d: Vec::new(),
            sensors: Vec::new(),
            forces: Vec::new(),
            frames: Vec::new(),
            user_models: Vec::new(),
        }
    }

    /// The name of a body, `base` for the base.
    pub fn body_name(&self, body: Option<usize>) -> &str {
        body.map_or("base", |body| &self.bodies[body].name)
    }

    /// Coordinates of a point on its body, m; the origin without one.
    pub fn coordinates(&self, point: Option<usize>) -> [f64; 3] {
        point.map_or([0.0; 3], |point| self.points[point].coordinates)
    }

    /// The last joint of a body, which moves with it; `None` for the base.
    pub fn last_joint(&self, body: Option<usize>) -> Option<usize> {
        body.map(|body| self.bodies[body].joints.end - 1)
    }

    /// The body a joint moves, when it is the last one of its body.
    pub fn body_of(&self, joint: usize) -> Option<&Body> {
        let body = &self.bodies[self.joints[joint].body];
        (body.joints.end - 1 == joint).then_some(body)
    }

    /// The joints from a joint to the base, the joint itself first.
    pub fn path(&self, joint: Option<usize>) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(joint, |&joint| self.joints[joint].parent)
    }

    /// The number of pairs of a joint and one of its ancestors or itself: the
    /// entries of a triangle of the mass matrix that are not structurally zero.
    pub fn pairs(&self) -> usize {
        self.depths().iter().sum()
    }

    /// For every joint the number of joints between the base and its body.
    pub fn depths(&self) -> Vec<usize> {
        let mut depths = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            // A parent has a smaller index.
            depths.push(1 + joint.parent.map_or(0, |parent| depths[parent]));
        }
        depths
    }

    /// Numbers points by bodies, and sensors and forces by points.
    pub(crate) fn number_points(&mut self) {
        let mut order: Vec<usize> = (0..self.points.len()).collect();
        order.sort_by_key(|&point| self.points[point].body);
        let mut number_of = vec![0; order.len()];
        for (number, &point) in order.iter().enumerate() {
            number_of[point] = number;
        }
        self.points = order.iter().map(|&at| self.points[at].clone()).collect();
        let number = |point: &mut usize| *point = number_of[*point];
        let cuts = self.cuts.iter_mut().flat_map(|cut| &mut cut.ends);
        let links = self.links.iter_mut().chain(&mut self.links3d);
        let ends = cuts.chain(links.flat_map(|link| &mut link.ends));
        ends.filter_map(|end| end.point.as_mut()).for_each(number);
        for list in [&mut self.sensors, &mut self.forces] {
            list.iter_mut().for_each(|sensor| number(&mut sensor.point));
            list.sort_by_key(|sensor| sensor.point);
        }
        let points = self.bodies.iter_mut().map(|body| &mut body.point);
        points.flatten().for_each(number);
    }

    /// Derives the attachments of joints from the bodies.
    pub fn connect(&mut self) {
        for index in 0..self.bodies.len() {
            let Body { parent, point, .. } = self.bodies[index];
            let range = self.bodies[index].joints.clone();
            assert!(!range.is_empty(), "a body has at least one joint");
            assert!(
                parent.is_none_or(|parent| parent < index),
                "a parent comes before its children"
            );
            let on = self.last_joint(parent);
            for joint in range.clone() {
                let first = joint == range.start;
                self.joints[joint].parent = if first { on } else { Some(joint - 1) };
                self.joints[joint].point = if first { point } else { None };
            }
        }
    }

    /// True when the invariants of this module hold.
    pub fn check(&self) -> bool {
        let bodies = self.bodies.len();
        let points = self.points.len();
        let finite = |numbers: &[f64]| numbers.iter().all(|number| number.is_finite());
        let anchor = |anchor: &Anchor| {
            anchor.body.is_none_or(|body| body < bodies)
                && anchor
                    .point
                    .is_none_or(|point| point < points && self.points[point].body == anchor.body)
        };
        let mut next = 0;
        let consecutive = self.bodies.iter().enumerate().all(|(index, body)| {
            let ok = body.joints.start == next
                && body.joints.end > next
                && body.parent.is_none_or(|parent| parent < index)
                && anchor(&Anchor {
                    body: body.parent,
                    point: body.point,
                })
                && finite(&[body.mass])
                && finite(&body.center)
                && finite(&body.inertia);
            next = body.joints.end;
            ok
        });
        consecutive
            && next == self.joints.len()
            && finite(&self.gravity)
            && self.joints.iter().enumerate().all(|(index, joint)| {
                self.bodies.get(joint.body).is_some_and(|body| {
                    let first = body.joints.start == index;
                    let (parent, point) = if first {
                        (self.last_joint(body.parent), body.point)
                    } else {
                        (index.checked_sub(1), None)
                    };
                    body.joints.contains(&index)
                        && (joint.nature == Nature::Driven
                            || (joint.has_velocity && joint.has_acceleration))
                        && finite(&joint.initial)
                        && joint.limits.is_none_or(|limits| finite(&limits))
                        && finite(&[joint.law.damping, joint.law.friction, joint.armature])
                        && finite(&[joint.law.stiffness, joint.law.neutral])
                        && joint
                            .mounting
                            .turns
                            .iter()
                            .all(|turn| turn.angle.is_finite())
                        && joint.parent == parent
                        && joint.point == point
                })
            })
            && self.points.is_sorted_by_key(|point| point.body)
            && self.sensors.is_sorted_by_key(|sensor| sensor.point)
            && self.forces.is_sorted_by_key(|force| force.point)
            && self.points.iter().all(|point| {
                point.body.is_none_or(|body| body < bodies) && finite(&point.coordinates)
            })
            && self.frames.iter().all(|frame| {
                frame.body.is_none_or(|body| body < bodies)
                    && finite(&frame.origin)
                    && finite(frame.rotation.as_flattened())
            })
            && self.cuts.iter().flat_map(|cut| &cut.ends).all(anchor)
            && self.cuts.iter().all(|cut| {
                let rotation = cut.rotation.unwrap_or_default();
                finite(rotation.as_flattened())
            })
            && self.cuts.iter().all(|cut| match cut.kind {
                CutKind::Coupling(coupling) => {
                    coupling.joint.max(coupling.leader) < self.joints.len()
                        && finite(&[coupling.factor, coupling.offset])
                }
                CutKind::Ball | CutKind::Rod(_) | CutKind::Solid => true,
            })
            && self.links.iter().flat_map(|link| &link.ends).all(anchor)
            && self.links3d.iter().flat_map(|link| &link.ends).all(anchor)
            && self
                .sensors
                .iter()
                .chain(&self.forces)
                .all(|sensor| sensor.point < points)
    }
}
