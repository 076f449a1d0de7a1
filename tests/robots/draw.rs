//! Random robots, as numbers and as the text of a URDF file of them.

use crate::reference::random::ModelDraw;
use robovec_num::random::Random;
use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;

/// A place in URDF: an offset, and roll, pitch and yaw.
#[derive(Clone, Copy, Default)]
pub(super) struct DrawnPlace {
    pub(super) offset: [f64; 3],
    pub(super) angles: [f64; 3],
}

/// A link: mass, where the centre of mass is, and the inertia about it.
#[derive(Clone, Copy, Default)]
pub(super) struct DrawnLink {
    pub(super) mass: f64,
    pub(super) center: DrawnPlace,
    /// `xx xy xz yy yz zz`.
    pub(super) inertia: [f64; 6],
}

/// A joint of link `index + 1`.
pub(super) struct DrawnJoint {
    pub(super) kind: &'static str,
    pub(super) parent: usize,
    pub(super) place: DrawnPlace,
    /// Of any length.
    pub(super) axis: [f64; 3],
    /// The joint it follows, factor and offset.
    pub(super) mimic: Option<(usize, f64, f64)>,
}

/// A robot: link 0 is the base, joint `i` carries link `i + 1`.
pub(super) struct DrawnRobot {
    pub(super) links: Vec<DrawnLink>,
    pub(super) joints: Vec<DrawnJoint>,
    /// The order in which the text has the joints.
    order: Vec<usize>,
}

const KINDS: [&str; 12] = [
    "revolute",
    "revolute",
    "revolute",
    "revolute",
    "continuous",
    "prismatic",
    "prismatic",
    "fixed",
    "fixed",
    "fixed",
    "planar",
    "floating",
];

/// Tests whether a joint of a kind has one position.
pub(super) fn has_position(kind: &str) -> bool {
    ["revolute", "continuous", "prismatic"].contains(&kind)
}

/// Angles: none, right ones, or any.
fn angles(random: &mut Random) -> [f64; 3] {
    match random.below(4) {
        0 => [0.0; 3],
        1 => [(); 3].map(|()| FRAC_PI_2 * (random.below(5) as f64 - 2.0)),
        _ => [(); 3].map(|()| 3.0 * random.signed()),
    }
}

fn place(random: &mut Random) -> DrawnPlace {
    DrawnPlace {
        offset: random.vector(0.3),
        angles: angles(random),
    }
}

/// A direction: along an axis or against it, in a plane, or any.
fn axis(random: &mut Random) -> [f64; 3] {
    let length = random.between(0.1, 7.0);
    loop {
        let zeros = [0.0, 0.0, 0.35][random.below(3)];
        let mut direction = random.vector(zeros);
        if random.chance(0.3) {
            direction = [0.0; 3];
            direction[random.below(3)] = if random.chance(0.5) { 1.0 } else { -1.0 };
        }
        let size = direction.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        if size > 0.01 {
            return direction.map(|x| x * length);
        }
    }
}

fn link(random: &mut Random) -> DrawnLink {
    if random.chance(0.25) {
        return DrawnLink::default();
    }
    let mut product = || 0.2 * random.signed();
    let [xy, xz, yz] = [product(), product(), product()];
    let [xx, yy, zz] = [(); 3].map(|()| random.between(0.8, 1.4));
    DrawnLink {
        mass: random.between(0.2, 3.0),
        center: place(random),
        inertia: [xx, xy, xz, yy, yz, zz],
    }
}

impl DrawnRobot {
    /// A robot of 2 to 14 links.
    pub(super) fn new(random: &mut Random) -> DrawnRobot {
        DrawnRobot::of_kinds(random, &KINDS)
    }

    /// A robot whose joints have one position or none.
    pub(super) fn of_one_axis(random: &mut Random) -> DrawnRobot {
        DrawnRobot::of_kinds(random, &KINDS[..10])
    }

    fn of_kinds(random: &mut Random, kinds: &[&'static str]) -> DrawnRobot {
        let count = 1 + random.below(13);
        let mut joints: Vec<DrawnJoint> = Vec::new();
        for index in 0..count {
            // Half of the links continue the chain.
            let parent = if random.chance(0.5) {
                index
            } else {
                random.below(index + 1)
            };
            let kind = kinds[random.below(kinds.len())];
            let leaders: Vec<usize> = (0..index)
                .filter(|&leader| has_position(joints[leader].kind))
                .collect();
            let follows = has_position(kind) && !leaders.is_empty() && random.chance(0.2);
            let mimic = follows.then(|| {
                let leader = leaders[random.below(leaders.len())];
                (leader, random.between(-2.0, 2.0), random.signed())
            });
            joints.push(DrawnJoint {
                kind,
                parent,
                place: place(random),
                axis: axis(random),
                mimic,
            });
        }
        let mut order: Vec<usize> = (0..count).collect();
        for place in (1..count).rev() {
            order.swap(place, random.below(place + 1));
        }
        DrawnRobot {
            links: (0..=count).map(|_| link(random)).collect(),
            joints,
            order,
        }
    }

    /// The text of a file. Every number is written so that it reads back.
    pub(super) fn text(&self) -> String {
        let mut text = String::from("<?xml version=\"1.0\"?>\n<robot name=\"drawn\">\n");
        // Writing to a string cannot fail.
        for &joint in self.order.iter().rev() {
            let _ = writeln!(text, "{}", self.link_text(joint + 1));
        }
        for &joint in &self.order {
            let _ = writeln!(text, "{}", self.joint_text(joint));
        }
        let _ = writeln!(text, "{}</robot>", self.link_text(0));
        text
    }

    fn link_text(&self, number: usize) -> String {
        let link = &self.links[number];
        if link.mass == 0.0 {
            return format!("  <link name='l{number}'/>");
        }
        let [xx, xy, xz, yy, yz, zz] = link.inertia;
        format!(
            "  <link name='l{number}'><inertial>{}<mass value='{}'/><inertia ixx='{xx}' \
             ixy='{xy}' ixz='{xz}' iyy='{yy}' iyz='{yz}' izz='{zz}'/></inertial></link>",
            place_text(&link.center),
            link.mass
        )
    }

    fn joint_text(&self, number: usize) -> String {
        let joint = &self.joints[number];
        let [x, y, z] = joint.axis;
        let mimic = joint
            .mimic
            .map_or(String::new(), |(leader, factor, offset)| {
                format!("<mimic joint='j{leader}' multiplier='{factor}' offset='{offset}'/>")
            });
        format!(
            "  <joint name='j{number}' type='{}'><parent link='l{}'/><child link='l{}'/>{}\
             <axis xyz='{x} {y} {z}'/>{mimic}</joint>",
            joint.kind,
            joint.parent,
            number + 1,
            place_text(&joint.place)
        )
    }

    /// The joint at the end of the leaders of a joint, with factor and offset.
    pub(super) fn leader(&self, joint: usize) -> Option<(usize, f64, f64)> {
        let (mut leader, mut factor, mut offset) = self.joints[joint].mimic?;
        while let Some((next, more, shift)) = self.joints[leader].mimic {
            offset += factor * shift;
            factor *= more;
            leader = next;
        }
        Some((leader, factor, offset))
    }
}

fn place_text(place: &DrawnPlace) -> String {
    let ([x, y, z], [roll, pitch, yaw]) = (place.offset, place.angles);
    format!("<origin xyz='{x} {y} {z}' rpy='{roll} {pitch} {yaw}'/>")
}
