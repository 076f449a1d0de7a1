//! Elements of a URDF file.
//!
//! The inertia of a rotor, felt through its gear, is `armature` of `dynamics`,
//! or, as in Drake, given by rotor and gear in a transmission:
//!
//! ```text
//! <transmission name="t"><joint name="hinge"/><actuator name="motor">
//!   <drake:rotor_inertia value="1e-5"/><drake:gear_ratio value="100"/>
//! </actuator></transmission>
//! ```

use crate::JointLaw;
use crate::robot::attributes::{
    children, name, number, number_or, place_in, place_of, read_pose, remark_unknown, required,
    triple, value_of,
};
use crate::robot::elements::{
    FrameElement, JointElement, LinkElement, MimicElement, RobotElements, RobotJointKind,
    joint_title,
};
use crate::robot::inertia::LinkInertial;
use crate::rotation::{FramePose, unit};
use crate::xml::{Messages, is_usable, place, second, stem};
use robovec_ir::diagnostic::{clip, suggestion};
use roxmltree::Node;
use rustc_hash::FxHashMap;
use std::ops::Range;

const KINDS: [(&str, RobotJointKind); 6] = [
    ("revolute", RobotJointKind::Revolute),
    ("continuous", RobotJointKind::Continuous),
    ("prismatic", RobotJointKind::Prismatic),
    ("fixed", RobotJointKind::Fixed),
    ("floating", RobotJointKind::Floating),
    ("planar", RobotJointKind::Planar),
];

/// Reads the elements of a robot; `None`, with errors, when it is none.
pub(in crate::robot) fn read(
    (file, right_angle): (&str, f64),
    root: Node<'_, '_>,
    messages: &mut Messages,
) -> Option<RobotElements> {
    if root.tag_name().name() != "robot" {
        messages.error(
            place(root),
            "this is XML, but not a robot",
            "the first element is not `robot`",
            "give a URDF or MJCF file; those of SDF and other formats must be converted first",
        );
        return None;
    }
    if let Some(node) = root.descendants().find(is_xacro) {
        messages.error(
            place(node),
            "this is a xacro file, which must be expanded first",
            "an element of xacro",
            "expand it: `xacro FILE.xacro > ROBOT.urdf`",
        );
        return None;
    }
    let name = robot_name(file, root, messages);
    let elements: Vec<Node<'_, '_>> = root.children().filter(Node::is_element).collect();
    let of = |kind: &'static str| {
        let all = elements.iter().copied();
        all.filter(move |element| element.tag_name().name() == kind)
    };
    for &other in &elements {
        if other.tag_name().namespace().is_none()
            && !["link", "joint"].contains(&other.tag_name().name())
        {
            remark_unknown(other, &["link", "joint"], messages);
        }
    }
    let mut links = Vec::new();
    let mut numbers: FxHashMap<String, usize> = FxHashMap::default();
    for node in of("link") {
        read_link(node, &mut links, (&mut numbers, right_angle), messages);
    }
    let mut joints: Vec<JointElement> = Vec::new();
    let mut seen: FxHashMap<String, Range<usize>> = FxHashMap::default();
    for node in of("joint") {
        let Some(joint) = read_joint(node, (&numbers, right_angle), messages) else {
            continue;
        };
        match seen.get(&joint.name) {
            None => {
                seen.insert(joint.name.clone(), joint.place.clone());
            }
            Some(first) if messages.has_room() => messages.push_error(second(
                &format!("there are two joints '{}'", clip(&joint.name)),
                joint.place.clone(),
                first.clone(),
                "give every joint a different name",
            )),
            Some(_) => messages.count_error(),
        }
        joints.push(joint);
    }
    add(of("transmission"), &mut joints, messages);
    let frames = links
        .iter()
        .enumerate()
        .map(|(link, element)| FrameElement {
            name: element.name.clone(),
            link,
            pose: FramePose::HERE,
        });
    Some(RobotElements {
        name,
        gravity: [0.0, 0.0, -9.81],
        frames: frames.collect(),
        links,
        joints,
        closures: Vec::new(),
        place: place(root),
    })
}

/// True for elements that only xacro can expand.
fn is_xacro(node: &Node<'_, '_>) -> bool {
    let space = node.tag_name().namespace();
    node.is_element() && space.is_some_and(|space| space.ends_with("/xacro"))
}

/// The name of the robot, which is also part of file names.
fn robot_name(file: &str, root: Node<'_, '_>, messages: &mut Messages) -> String {
    let given = root.attribute("name").map(str::trim).unwrap_or_default();
    if is_usable(given) {
        return given.to_owned();
    }
    if !given.is_empty() {
        messages.error(
            place_of(root, "name"),
            "the name of the robot holds a slash or a line break",
            "it becomes part of file names",
            "use letters, digits and underscores",
        );
    }
    stem(file, ".urdf", "robot").to_owned()
}

fn read_link(
    node: Node<'_, '_>,
    links: &mut Vec<LinkElement>,
    (numbers, right_angle): (&mut FxHashMap<String, usize>, f64),
    messages: &mut Messages,
) {
    let Some(name) = name(node, "name", "a link", messages) else {
        return;
    };
    let at = place_of(node, "name");
    if let Some(&first) = numbers.get(&name) {
        let first: &LinkElement = &links[first];
        if messages.has_room() {
            messages.push_error(second(
                &format!("there are two links '{}'", clip(&name)),
                at,
                first.place.clone(),
                "give every link a different name",
            ));
        } else {
            messages.count_error();
        }
        return;
    }
    let [inertial, _, _] = children_of_link(node, messages);
    let title = format!("link '{}'", clip(&name));
    numbers.insert(name.clone(), links.len());
    links.push(LinkElement {
        inertial: inertial.map(|node| read_inertial(node, (&title, right_angle), messages)),
        name,
        place: at,
    });
}

/// Links may hold any number of drawings.
fn children_of_link<'a>(node: Node<'a, 'a>, messages: &mut Messages) -> [Option<Node<'a, 'a>>; 3] {
    let mut found = [None; 3];
    for child in node.children().filter(Node::is_element) {
        match child.tag_name().name() {
            "inertial" => match found[0] {
                None => found[0] = Some(child),
                Some(first) => messages.push_error(second(
                    "`inertial` is given twice in one `link`",
                    place(child),
                    place(first),
                    "remove one of them",
                )),
            },
            "visual" | "collision" => {}
            _ => remark_unknown(child, &["inertial", "visual", "collision"], messages),
        }
    }
    found
}

/// The link that a child of a joint names; `None` with an error.
fn end(
    joint: Node<'_, '_>,
    child: Option<Node<'_, '_>>,
    (which, title): (&str, &str),
    numbers: &FxHashMap<String, usize>,
    messages: &mut Messages,
) -> Option<usize> {
    let Some(child) = child else {
        messages.error(
            place(joint),
            &format!("{title} has no `{which}`"),
            "in this element",
            &format!("add `<{which} link=\"…\"/>`"),
        );
        return None;
    };
    let link = name(child, "link", &format!("the {which} of {title}"), messages)?;
    if let Some(&number) = numbers.get(&link) {
        return Some(number);
    }
    if !messages.has_room() {
        messages.count_error();
        return None;
    }
    let mut known: Vec<&str> = numbers.keys().map(String::as_str).collect();
    known.sort_unstable();
    let help = suggestion(&link, known).unwrap_or_else(|| {
        format!(
            "add `<link name=\"{}\"/>`, or correct the name",
            clip(&link)
        )
    });
    messages.error(
        place_of(child, "link"),
        &format!("the {which} of {title} is not a link of the robot"),
        "there is no link of this name",
        &help,
    );
    None
}

fn read_joint(
    node: Node<'_, '_>,
    (numbers, right_angle): (&FxHashMap<String, usize>, f64),
    messages: &mut Messages,
) -> Option<JointElement> {
    let joint_name = name(node, "name", "a joint", messages);
    let title = joint_title(joint_name.as_deref().unwrap_or("?"));
    let [origin, parent, child, axis, limit, mimic, dynamics, ..] = children(
        node,
        [
            "origin",
            "parent",
            "child",
            "axis",
            "limit",
            "mimic",
            "dynamics",
            "calibration",
            "safety_controller",
        ],
        messages,
    );
    let kind = read_kind(node, &title, messages);
    let ends = [("parent", parent), ("child", child)]
        .map(|(which, child)| end(node, child, (which, &title), numbers, messages));
    let limits = limit.and_then(|limit| read_limits(limit, kind?, &title, messages));
    let (law, armature) = match dynamics {
        Some(dynamics) => read_dynamics(dynamics, kind, &title, messages),
        None => Default::default(),
    };
    let axis = read_axis(axis, kind, &title, messages);
    let mimic = mimic.and_then(|mimic| {
        let title = format!("the mimic of {title}");
        Some(MimicElement {
            leader: name(mimic, "joint", &title, messages)?,
            factor: number_or(mimic, "multiplier", 1.0, &title, messages),
            offset: number_or(mimic, "offset", 0.0, &title, messages),
            place: place_of(mimic, "joint"),
        })
    });
    let origin = read_pose(origin, (&title, right_angle), messages);
    let initial = limits.map_or(0.0, |[lower, upper]| 0.0_f64.clamp(lower, upper));
    let [parent, child_link] = ends;
    Some(JointElement {
        origin,
        axis,
        initial: [initial, 0.0, 0.0, 0.0, 0.0, 0.0],
        limits,
        law,
        armature,
        mimic,
        place: place_of(node, "name"),
        child_place: place_in(node, child, "link"),
        ..JointElement::new(joint_name?, kind?, [parent?, child_link?])
    })
}

fn read_kind(node: Node<'_, '_>, title: &str, messages: &mut Messages) -> Option<RobotJointKind> {
    let text = name(node, "type", title, messages)?;
    let found = KINDS.iter().find(|(name, _)| *name == text);
    if found.is_none() {
        let names = KINDS.map(|(name, _)| name);
        let help = suggestion(&text, names)
            .unwrap_or_else(|| format!("kinds of joints: {}", names.join(", ")));
        messages.error(
            place_of(node, "type"),
            &format!("{title} has an unknown type: '{}'", clip(&text)),
            "this kind",
            &help,
        );
    }
    found.map(|(_, kind)| *kind)
}

/// The axis, of length one; the first axis where none is given.
fn read_axis(
    node: Option<Node<'_, '_>>,
    kind: Option<RobotJointKind>,
    title: &str,
    messages: &mut Messages,
) -> [f64; 3] {
    let default = [1.0, 0.0, 0.0];
    let needed = !matches!(
        kind,
        None | Some(RobotJointKind::Fixed | RobotJointKind::Floating)
    );
    let (Some(node), true) = (node, needed) else {
        return default;
    };
    let given = triple(
        node,
        "xyz",
        &format!("the axis of {title}"),
        default,
        messages,
    );
    unit(given).unwrap_or_else(|| {
        messages.error(
            place_of(node, "xyz"),
            &format!("the axis of {title} has no length"),
            "this axis",
            "write a direction, such as \"0 0 1\"",
        );
        default
    })
}

fn read_limits(
    node: Node<'_, '_>,
    kind: RobotJointKind,
    title: &str,
    messages: &mut Messages,
) -> Option<[f64; 2]> {
    if !matches!(kind, RobotJointKind::Revolute | RobotJointKind::Prismatic) {
        return None;
    }
    let title = format!("the limit of {title}");
    let lower = number(node, "lower", &title, messages);
    let upper = number(node, "upper", &title, messages);
    if lower.is_none() && upper.is_none() {
        return None;
    }
    let limits = [lower.unwrap_or(0.0), upper.unwrap_or(0.0)];
    if limits[0] > limits[1] {
        messages.warn(
            place_of(node, "lower"),
            &format!(
                "{title} is not a range: from {} to {}",
                limits[0], limits[1]
            ),
            "passed over",
            "the lower limit comes first",
        );
        return None;
    }
    Some(limits)
}

/// Damping, friction and rotor inertia of joints along or about one axis.
fn read_dynamics(
    node: Node<'_, '_>,
    kind: Option<RobotJointKind>,
    title: &str,
    messages: &mut Messages,
) -> (JointLaw, f64) {
    let title = format!("the dynamics of {title}");
    let [damping, friction, armature] = ["damping", "friction", "armature"].map(|name| {
        let value = number_or(node, name, 0.0, &title, messages);
        if value < 0.0 {
            messages.warn(
                place_of(node, name),
                &format!("{title} would give energy: the {name} is {value}"),
                "taken as 0",
                "damping, friction and armature are zero or positive",
            );
        }
        value.max(0.0)
    });
    let law = JointLaw {
        damping,
        friction,
        ..JointLaw::default()
    };
    let has_axis = kind.is_none_or(RobotJointKind::has_axis);
    if has_axis || !law.are_there() && armature == 0.0 {
        return (law, armature);
    }
    messages.warn(
        place(node),
        &format!("{title} are left out"),
        "passed over",
        "only joints about or along one axis have damping, friction and armature",
    );
    Default::default()
}

/// Adds the rotors of transmissions to the joints they move.
pub(super) fn add<'a>(
    transmissions: impl Iterator<Item = Node<'a, 'a>>,
    joints: &mut [JointElement],
    messages: &mut Messages,
) {
    for transmission in transmissions {
        let find = |tag: &str| {
            let mut all = transmission.descendants();
            all.find(|node| node.tag_name().name() == tag)
        };
        let (Some(rotor), Some(joint)) = (find("rotor_inertia"), find("joint")) else {
            continue;
        };
        let title = "the rotor of a transmission";
        let inertia = required(rotor, "value", title, messages);
        let ratio = match find("gear_ratio") {
            Some(gear) => required(gear, "value", "the gear of a transmission", messages),
            None => 1.0,
        };
        let Some(moved) = name(joint, "name", "the joint of a transmission", messages) else {
            continue;
        };
        let Some(moved) = joints.iter_mut().find(|joint| joint.name == moved) else {
            messages.error(
                place_of(joint, "name"),
                &format!(
                    "a transmission moves {}, which is not there",
                    joint_title(&moved)
                ),
                "no joint of the robot",
                "name a joint of the robot, or remove the transmission",
            );
            continue;
        };
        if !moved.kind.has_axis() || inertia < 0.0 {
            messages.warn(
                place_of(rotor, "value"),
                &format!("{title} is left out: {}", clip(&moved.name)),
                "passed over",
                "an inertia is positive, and its joint moves about or along one axis",
            );
            continue;
        }
        moved.armature += inertia * ratio * ratio;
    }
}

pub(super) fn read_inertial(
    node: Node<'_, '_>,
    (title, right_angle): (&str, f64),
    messages: &mut Messages,
) -> LinkInertial {
    let [origin, mass, inertia] = children(node, ["origin", "mass", "inertia"], messages);
    let value = value_of(node, mass, ("mass", title), messages);
    if value < 0.0 {
        let at = place_in(node, mass, "value");
        messages.error(
            at,
            &format!("the mass of {title} is negative"),
            "this mass",
            "a mass is zero or positive, in kilograms",
        );
    }
    let entries = match inertia {
        Some(inertia) => {
            let owner = format!("the inertia of {title}");
            ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]
                .map(|entry| required(inertia, entry, &owner, messages))
        }
        None => {
            messages.error(
                place(node),
                &format!("{title} has no `inertia`"),
                "in this element",
                "add `<inertia ixx=\"…\" ixy=\"0\" ixz=\"0\" iyy=\"…\" iyz=\"0\" izz=\"…\"/>`",
            );
            [0.0; 6]
        }
    };
    LinkInertial {
        mass: value,
        origin: read_pose(origin, (title, right_angle), messages),
        inertia: entries,
        place: inertia.map_or(place(node), place),
    }
}
