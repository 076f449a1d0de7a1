//! The readers of robots: URDF and MJCF, the XML in which they are exchanged.
//!
//! A file passes through [`crate::xml`] (bytes to a tree of elements), a reader
//! of its format ([`urdf`], [`mjcf`]) that makes [`elements`] of it, links and
//! joints with their places, and from there on one way: [`tree`] (links and
//! joints in the order from the base), [`couplings`] (joints that follow
//! others), [`frames`] (the frame of each moving body) and [`bodies`] (the
//! model). Drawings, materials, collisions and extensions are skipped.
//!
//! Frames of bodies are chosen, not copied: the frame of a body is that of the
//! body it is attached to, where all joints are at zero, unless the axis of its
//! joint is no axis of that frame. So most constant rotations of a file are in
//! no equation; those that remain turn by at most half a right angle.
//!
//! **Invariants.** A model that is returned upholds
//! [`Model::check`](super::Model::check); a file with any error returns none.
//! There is no recursion over links.

mod attributes;
mod bodies;
mod couplings;
mod elements;
mod frames;
mod inertia;
mod mjcf;
mod tree;
mod urdf;

use super::reading::{self, ModelError, ReadModel};
use super::xml::{self, Messages};
use super::{Model, physics};
pub use mjcf::with_includes;

/// Base of a robot.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum RobotBase {
    /// The first link is at rest, as URDF defines; free joints are the file's.
    #[default]
    Fixed,
    /// The first link of a URDF file moves freely, by six joints: three
    /// translations, then yaw, pitch and roll.
    Floating,
}

/// Way in which a robot is read.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub struct RobotReading {
    /// Base of the robot.
    pub base: RobotBase,
    /// Largest distance from a multiple of a right angle at which an angle of
    /// the file is taken as one, rad: many files write `1.57079632679`, and
    /// nearly right rotations cost operations that right ones do not.
    pub right_angle: f64,
}

impl From<RobotBase> for RobotReading {
    fn from(base: RobotBase) -> RobotReading {
        RobotReading {
            base,
            ..RobotReading::default()
        }
    }
}

/// Description of a file of a robot, for messages.
const KIND: xml::DocumentKind = xml::DocumentKind {
    last: "</robot>` or `</mujoco>",
    what: "URDF and MJCF files are XML; one that xacro makes a robot of must pass through xacro first",
    first: "the first element of a URDF file is `<robot>`, of an MJCF file `<mujoco>`",
};

/// Reads a URDF or MJCF file; `name` is for messages and nameless robots.
///
/// # Errors
///
/// Everything that keeps the file from being a model, each with its place:
/// text that is not XML or is cut short, document types and entities, unknown
/// or repeated names, links on a cycle or with two parents, unknown kinds of
/// joints, axes of no length, numbers that are none, elements whose effect on
/// the equations is not supported, more joints than
/// [`JOINT_LIMIT`](robovec_robotran::conventions::JOINT_LIMIT).
pub fn read_robot(
    name: &str,
    bytes: &[u8],
    reading: impl Into<RobotReading>,
) -> Result<ReadModel, ModelError> {
    let reading = reading.into();
    reading::read_model((name, bytes), &KIND, |document, messages| {
        read_document(name, document, reading, messages)
    })
}

/// The model of a document; `None` with errors among the messages.
fn read_document(
    name: &str,
    document: &roxmltree::Document<'_>,
    mut reading: RobotReading,
    messages: &mut Messages,
) -> Option<Model> {
    let root = document.root_element();
    let file = (name, reading.right_angle);
    let robot = if root.tag_name().name() == "mujoco" {
        if reading.base == RobotBase::Floating {
            messages.warn(
                xml::place(root),
                "an MJCF file has free joints itself: --base floating is passed over",
                "this file",
                "write `<freejoint/>` in the body that moves freely",
            );
            reading.base = RobotBase::Fixed;
        }
        mjcf::read(file, root, messages)?
    } else {
        urdf::read(file, root, messages)?
    };
    let order = tree::order(&robot, messages)?;
    let couplings = couplings::resolve(&robot, messages);
    if messages.has_errors() {
        return None;
    }
    for link in &robot.links {
        if let Some(inertial) = &link.inertial {
            let title = format!("link '{}'", link.name);
            physics::impossible(&title, &inertial.inertia, &inertial.place, messages);
        }
    }
    let built = bodies::build(&robot, &order, &couplings, reading.base, messages)?;
    physics::massless(&built.model, &built.places, messages);
    if built.model.joints.is_empty() {
        messages.warn(
            robot.place,
            "nothing in the robot moves",
            "all its joints are fixed",
            "there are no equations for it; with --base floating it moves freely",
        );
    }
    debug_assert!(built.model.check(), "the reader upholds the invariants");
    Some(built.model)
}
