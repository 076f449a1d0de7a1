//! The reader of MJCF, the format of MuJoCo.
//!
//! Bodies are nested, and joints belong to the body they move: a body with
//! several joints becomes as many links in series. Read are bodies, frames,
//! joints, inertias (also those of geoms that are no meshes), defaults,
//! `equality` of kinds connect, weld, joint and tendon ([`equality`]), gravity
//! and the motors of joints; contacts, sensors and drawings are skipped.
//! Unsupported changes of equations are errors, forces in none are named.
//!
//! The state of the file is the one of its positions `ref`, as MuJoCo defines.
//!
//! Source: MuJoCo's XML reference, `https://mujoco.readthedocs.io`.

mod defaults;
mod equality;
mod geoms;
mod inertial;
mod joints;
mod places;
mod settings;

use self::defaults::{ClassIndex, Defaults, MAIN};
use self::settings::MjcfSettings;
use crate::robot::attributes::place_of;
use crate::robot::elements::{
    FrameElement, JointElement, LinkElement, RobotElements, RobotJointKind,
};
use crate::rotation::FramePose;
use crate::xml::{self, Messages, is_usable, place, second, stem};
use robovec_ir::diagnostic::clip;
use roxmltree::{Document, Node};
use rustc_hash::{FxHashMap, FxHashSet};
use std::ops::Range;

/// An element inside of a body: its frame in the body's, and its class.
#[derive(Clone, Copy)]
struct Inner<'a> {
    node: Node<'a, 'a>,
    frame: FramePose,
    class: ClassIndex,
}

struct MjcfReader<'a, 'm> {
    settings: MjcfSettings,
    defaults: Defaults<'a>,
    messages: &'m mut Messages,
    robot: RobotElements,
    /// The pose of each link in the base where all positions are `ref`.
    start: Vec<FramePose>,
    bodies: FxHashMap<String, usize>,
    joints: FxHashMap<String, usize>,
    /// Link and pose of each site.
    sites: FxHashMap<String, (usize, FramePose)>,
    /// Places of the names of bodies, of joints and of sites.
    names: [FxHashMap<String, Range<usize>>; 3],
    /// All names of the file.
    given: FxHashSet<&'a str>,
    loops: FxHashSet<String>,
}

/// The kinds of names.
const BODIES: usize = 0;
const JOINTS: usize = 1;
const SITES: usize = 2;

/// Elements that change the equations and are not supported.
const REFUSED: [(&str, &str); 8] = [
    (
        "include",
        "save the model as one file: `mj_saveLastXML` of MuJoCo writes it",
    ),
    (
        "replicate",
        "save the model as MuJoCo expands it: `mj_saveLastXML` writes it",
    ),
    (
        "attach",
        "save the model as MuJoCo expands it: `mj_saveLastXML` writes it",
    ),
    (
        "model",
        "save the model as MuJoCo expands it: `mj_saveLastXML` writes it",
    ),
    ("composite", "bodies that bend are not supported: remove it"),
    ("flexcomp", "bodies that bend are not supported: remove it"),
    (
        "deformable",
        "bodies that bend are not supported: remove it",
    ),
    ("plugin", "forces of plugins are not supported: remove it"),
];

/// Reads the elements of a robot; `None`, with errors, when it is none.
pub(in crate::robot) fn read<'a>(
    (file, right_angle): (&str, f64),
    root: Node<'a, 'a>,
    messages: &mut Messages,
) -> Option<RobotElements> {
    let elements = root.descendants().filter(Node::is_element);
    for node in elements {
        let name = node.tag_name().name();
        if let Some((_, help)) = REFUSED.iter().find(|(refused, _)| *refused == name) {
            let message = format!("the element `{name}` is not supported");
            messages.error(place(node), &message, "in this file", help);
        }
    }
    let settings = MjcfSettings::read(root, right_angle, messages);
    let defaults = Defaults::read(root, messages);
    let mut reader = MjcfReader {
        robot: RobotElements {
            name: name_of(file, root),
            gravity: settings.gravity,
            links: Vec::new(),
            joints: Vec::new(),
            closures: Vec::new(),
            frames: Vec::new(),
            place: place(root),
        },
        settings,
        defaults,
        messages,
        start: Vec::new(),
        bodies: FxHashMap::default(),
        joints: FxHashMap::default(),
        sites: FxHashMap::default(),
        names: Default::default(),
        given: root
            .descendants()
            .filter_map(|node| node.attribute("name"))
            .collect(),
        loops: FxHashSet::default(),
    };
    reader.world(root);
    reader.finish_masses();
    for section in children(root, "equality") {
        reader.equalities(section);
    }
    reader.tendons(root);
    reader.actuators(root);
    (!reader.messages.has_errors()).then_some(reader.robot)
}

fn children<'a>(node: Node<'a, 'a>, name: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    let children = node.children();
    children.filter(move |child| child.tag_name().name() == name)
}

/// The name of the model, which is also part of file names.
fn name_of(file: &str, root: Node<'_, '_>) -> String {
    let given = root.attribute("model").map(str::trim).unwrap_or_default();
    match is_usable(given) {
        true => given.to_owned(),
        false => stem(file, ".xml", "robot").to_owned(),
    }
}

impl<'a> MjcfReader<'a, '_> {
    /// All bodies, in the order of the file.
    fn world(&mut self, root: Node<'a, 'a>) {
        let link = self.link("world".to_owned(), place(root), FramePose::HERE);
        self.bodies.insert("world".to_owned(), link);
        let mut pending: Vec<(Inner<'a>, usize)> = Vec::new();
        let bodies: Vec<Inner<'a>> = children(root, "worldbody")
            .flat_map(|node| self.contents(node, MAIN))
            .collect();
        self.sites(link, &bodies);
        pending.extend(bodies_of(&bodies, link));
        while let Some((body, parent)) = pending.pop() {
            let (link, inner) = self.body(&body, parent);
            pending.extend(bodies_of(&inner, link));
        }
    }

    /// Elements of a body, those of frames included, in the order of the file.
    fn contents(&mut self, node: Node<'a, 'a>, class: ClassIndex) -> Vec<Inner<'a>> {
        let mut found = Vec::new();
        let mut pending = vec![Inner {
            node,
            frame: FramePose::HERE,
            class,
        }];
        let mut is_first = true;
        while let Some(inner) = pending.pop() {
            let name = inner.node.tag_name().name();
            if !std::mem::take(&mut is_first) && name != "frame" {
                found.push(inner);
                continue;
            }
            let class = self
                .defaults
                .class(inner.node, "childclass", inner.class, self.messages);
            let frame = match name {
                "frame" => inner.frame.then(&self.pose(inner.node, inner.class)),
                _ => inner.frame,
            };
            let elements = inner.node.children().filter(Node::is_element);
            let inside = elements.map(|node| Inner { node, frame, class });
            let start = pending.len();
            pending.extend(inside);
            pending[start..].reverse();
        }
        found
    }

    /// Adds a body with its joints; gives its link and the elements inside.
    fn body(&mut self, body: &Inner<'a>, parent: usize) -> (usize, Vec<Inner<'a>>) {
        let node = body.node;
        let name = self.name(BODIES, node, "body");
        let pose = body.frame.then(&self.pose(node, body.class));
        let inner = self.contents(node, body.class);
        let joints: Vec<Inner<'a>> = inner
            .iter()
            .filter(|inner| matches!(inner.node.tag_name().name(), "joint" | "freejoint"))
            .copied()
            .collect();
        let mut before = (parent, pose);
        for (number, joint) in joints.iter().enumerate() {
            let is_last = number + 1 == joints.len();
            let link_name = match is_last {
                true => name.clone(),
                false => format!("{name}_{}", number + 1),
            };
            before = self.joint(joint, link_name, before, &pose);
        }
        if joints.is_empty() {
            before = self.fixed(name.clone(), place_of(node, "name"), before);
        }
        let (link, _) = before;
        self.start[link] = self.start[parent].then(&pose);
        self.bodies.insert(name.clone(), link);
        if node.has_attribute("name") {
            self.robot.frames.push(FrameElement {
                name,
                link,
                pose: FramePose::HERE,
            });
        }
        self.sites(link, &inner);
        self.weigh(link, node, &inner);
        if node
            .attribute("gravcomp")
            .is_some_and(|text| text.trim() != "0")
        {
            self.messages.leave_out(
                place_of(node, "gravcomp"),
                "the compensation of gravity is in no equation",
                "passed over",
                "add it to the forces of the joints",
            );
        }
        (link, inner)
    }

    /// Adds a link that does not move on the one before.
    fn fixed(
        &mut self,
        name: String,
        at: Range<usize>,
        (parent, pose): (usize, FramePose),
    ) -> (usize, FramePose) {
        let child = self.link(name.clone(), at.clone(), FramePose::HERE);
        self.robot.joints.push(JointElement {
            place: at.clone(),
            child_place: at,
            origin: pose,
            ..JointElement::new(
                format!("{name}_fixed"),
                RobotJointKind::Fixed,
                [parent, child],
            )
        });
        (child, FramePose::HERE)
    }

    fn link(&mut self, name: String, place: Range<usize>, start: FramePose) -> usize {
        self.robot.links.push(LinkElement {
            name,
            inertial: None,
            place,
        });
        self.start.push(start);
        self.robot.links.len() - 1
    }

    /// The name of an element, or one of its kind and a number.
    fn name(&mut self, kind: usize, node: Node<'a, 'a>, noun: &str) -> String {
        let given = node.attribute("name").map(str::trim).unwrap_or_default();
        if !given.is_empty() && !given.contains(char::is_control) {
            let at = place_of(node, "name");
            match self.names[kind].get(given) {
                Some(first) => self.messages.push_error(second(
                    &format!(
                        "there are two elements `{noun}` with the name '{}'",
                        clip(given)
                    ),
                    at,
                    first.clone(),
                    "give each of them a different name",
                )),
                None => {
                    self.names[kind].insert(given.to_owned(), at);
                }
            }
            return given.to_owned();
        }
        let numbers = self.names[kind].len() + 1..;
        let mut names = numbers.map(|number| format!("{noun}{number}"));
        let is_free = |name: &String| {
            !self.names[kind].contains_key(name) && !self.given.contains(name.as_str())
        };
        let name = names
            .find(is_free)
            .expect("there are more numbers than names");
        self.names[kind].insert(name.clone(), place(node));
        name
    }

    /// The sites of a body, which are frames with names.
    fn sites(&mut self, link: usize, inner: &[Inner<'a>]) {
        for site in inner {
            if site.node.tag_name().name() != "site" || !site.node.has_attribute("name") {
                continue;
            }
            let name = self.name(SITES, site.node, "site");
            let pose = site.frame.then(&self.pose(site.node, site.class));
            self.sites.insert(name.clone(), (link, pose));
            let is_taken = self.names[BODIES].contains_key(&name);
            self.robot.frames.push(FrameElement {
                name: match is_taken {
                    true => format!("{name}_site"),
                    false => name,
                },
                link,
                pose,
            });
        }
    }

    /// Marks the joints that motors move.
    fn actuators(&mut self, root: Node<'a, 'a>) {
        let motors = children(root, "actuator").flat_map(|section| section.children());
        for motor in motors {
            let moved = motor
                .attribute("joint")
                .or(motor.attribute("jointinparent"));
            let Some(moved) = moved.and_then(|name| self.joints.get(name.trim())) else {
                continue;
            };
            self.robot.joints[*moved].actuated = true;
        }
    }
}

/// The bodies among elements, the last one first, with their parent.
fn bodies_of<'a>(inner: &[Inner<'a>], parent: usize) -> Vec<(Inner<'a>, usize)> {
    let bodies = inner
        .iter()
        .rev()
        .filter(|inner| inner.node.tag_name().name() == "body");
    bodies.map(|body| (*body, parent)).collect()
}

/// The most files that one file includes, those of included files counted.
const LIMIT: usize = 100;

/// The file with the elements of included files in their place. Each is on the
/// line of its `include`, so that messages name the lines of the file itself.
/// `read` gets the names as they are written, which MuJoCo takes relative to
/// the folder of the first file. What is no XML, and includes beyond the
/// hundredth, are left as they are, for the reader to refuse.
pub fn with_includes<E>(
    bytes: Vec<u8>,
    mut read: impl FnMut(&str) -> Result<Vec<u8>, E>,
) -> Result<Vec<u8>, E> {
    let Ok(text) = xml::decode(&bytes) else {
        return Ok(bytes);
    };
    let mut text = text.into_owned();
    for _ in 0..LIMIT {
        let Some((place, file)) = first(&text) else {
            break;
        };
        let included = read(&file)?;
        let Some(inside) = elements(&included) else {
            break;
        };
        text.replace_range(place, &inside);
    }
    Ok(text.into_bytes())
}

/// The first `include` of a file: its place, and the file it names.
fn first(text: &str) -> Option<(Range<usize>, String)> {
    if !text.contains("<include") {
        return None;
    }
    let document = Document::parse(text).ok()?;
    let is_include = |node: &Node<'_, '_>| node.has_tag_name("include");
    let node = document.descendants().find(is_include)?;
    Some((node.range(), node.attribute("file")?.trim().to_owned()))
}

/// The text inside of the first element of a file, on one line.
fn elements(bytes: &[u8]) -> Option<String> {
    let text = xml::decode(bytes).ok()?;
    let document = Document::parse(&text).ok()?;
    let root = document.root_element();
    let inside = root.first_child()?.range().start..root.last_child()?.range().end;
    Some(text[inside].replace(['\n', '\r'], " "))
}
