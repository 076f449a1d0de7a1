//! The base and the tree of bodies: joints, masses, points, sensors.

use super::JOINT_LIMIT;
use super::fields::{Fields, Messages, place, second};
use super::number::{coordinates, number, numbers};
use crate::model::{Anchor, Asks, Body, Joint, JointKind, Model, Nature, Point, Sensor};
use robovec_ir::diagnostic::{clip, did_you_mean};
use roxmltree::Node;
use rustc_hash::FxHashMap;
use std::ops::Range;

/// The name of the base as a parent and at the ends of cuts and links.
pub(super) const BASE: &str = "base";
/// The name of a body's own frame, unless the body has a point of this name.
pub(super) const ORIGIN: &str = "origin";

/// The names of a model, for what refers to them.
#[derive(Default)]
pub(super) struct Scope {
    bodies: FxHashMap<String, usize>,
    points: FxHashMap<(Option<usize>, String), usize>,
    /// Where each body's name is written.
    pub(super) body_places: Vec<Range<usize>>,
}

/// How messages call a body.
pub(super) fn body_title(name: &str) -> String {
    format!("body '{}'", clip(name))
}

impl Scope {
    /// The place that `bodyname` and `pointname` of an element tell; `None`,
    /// with an error, when there is no such place.
    pub(super) fn anchor(
        &self,
        fields: &Fields<'_>,
        owner: &str,
        model: &Model,
        messages: &mut Messages,
    ) -> Option<Anchor> {
        let body_name = fields.name("bodyname", owner, messages);
        let point_name = fields.name("pointname", owner, messages);
        if body_name.is_empty() || point_name.is_empty() {
            return None;
        }
        let body = if body_name == BASE {
            None
        } else if let Some(&index) = self.bodies.get(&body_name) {
            Some(index)
        } else {
            let names = model.bodies.iter().map(|body| body.name.as_str());
            let help = match did_you_mean(&body_name, names.chain([BASE])) {
                Some(near) => format!("did you mean '{near}'?"),
                None => "name one of the bodies, or base".to_owned(),
            };
            messages.error(
                fields.one("bodyname").map_or(0..0, place),
                &format!(
                    "{owner} names a body '{}', which does not exist",
                    clip(&body_name)
                ),
                "no body has this name",
                &help,
            );
            return None;
        };
        let point = self.points.get(&(body, point_name.clone())).copied();
        if point.is_none() && point_name != ORIGIN {
            let title = body.map_or("the base".to_owned(), |body| {
                body_title(&model.bodies[body].name)
            });
            let names = model.points.iter().filter(|point| point.body == body);
            let names = names.map(|point| point.name.as_str());
            let help = match did_you_mean(&point_name, names.clone().chain([ORIGIN])) {
                Some(near) => format!("did you mean '{near}'?"),
                None => {
                    let all: Vec<&str> = names.chain([ORIGIN]).take(8).collect();
                    format!("the points of {title} are: {}", all.join(", "))
                }
            };
            messages.error(
                fields.one("pointname").map_or(0..0, place),
                &format!(
                    "{owner} names a point '{}', which {title} does not have",
                    clip(&point_name)
                ),
                "no point of that body has this name",
                &help,
            );
            return None;
        }
        Some(Anchor { body, point })
    }
}

/// Reads base and bodies into the model.
pub(super) fn read(root: &Fields<'_>, model: &mut Model, messages: &mut Messages) -> Option<Scope> {
    let mut scope = Scope::default();
    if let Some(base) = root.one("base") {
        read_base(base, &mut scope, model, messages);
    } else {
        messages.warn(
            place(root.node),
            "the model has no base",
            "there is no `base` in it",
            "gravity is taken as (0, 0, -9.81) m/s^2; add `<base>` to say otherwise",
        );
    }
    let tree = root.one("bodytree");
    let bodies: Vec<Node<'_, '_>> = match tree {
        Some(tree) => Fields::of(tree, &[], &["body"], messages).all().collect(),
        None => Vec::new(),
    };
    if bodies.is_empty() {
        messages.error(
            place(tree.unwrap_or(root.node)),
            "the model has no body",
            "there is no `body` in a `bodytree` here",
            "a model has at least one body with one joint",
        );
        return None;
    }
    if !within_limit(&bodies, messages) {
        return None;
    }
    let mut all = Vec::with_capacity(bodies.len());
    for (index, &node) in bodies.iter().enumerate() {
        let one = ["bodyname", "parent", "mass", "com", "inertia"];
        let fields = Fields::of(node, &one, &["joint", "point"], messages);
        read_body(index, &fields, &mut scope, model, messages);
        all.push(fields);
    }
    repeated_joints(&all, model, messages);
    hang(&all, &scope, model, messages);
    Some(scope)
}

/// Counts joints before anything is done with them.
fn within_limit(bodies: &[Node<'_, '_>], messages: &mut Messages) -> bool {
    let joints = bodies.iter().flat_map(|body| body.children());
    let mut joints = joints.filter(|child| child.has_tag_name("joint"));
    let Some(first_beyond) = joints.nth(JOINT_LIMIT) else {
        return true;
    };
    let count = JOINT_LIMIT + 1 + joints.count();
    messages.error(
        place(first_beyond),
        &format!("the model has {count} joints, more than the {JOINT_LIMIT} that are allowed"),
        &format!("joint {}", JOINT_LIMIT + 1),
        "split the model, or replace chains of small bodies by fewer ones",
    );
    false
}

fn read_base(node: Node<'_, '_>, scope: &mut Scope, model: &mut Model, messages: &mut Messages) {
    let base = Fields::of(node, &["gravity"], &["point"], messages);
    match base.one("gravity") {
        Some(gravity) => {
            let gravity = Fields::of(gravity, &["coordinates"], &[], messages);
            model.gravity = coordinates(&gravity, "the gravity", messages);
        }
        None => messages.warn(
            place(node),
            "the base has no gravity",
            "there is no `gravity` in it",
            "it is taken as (0, 0, -9.81) m/s^2; write it, even where it is zero",
        ),
    }
    for point in base.many("point") {
        read_point(point, None, "the base", scope, model, messages);
    }
}

fn read_body(
    index: usize,
    fields: &Fields<'_>,
    scope: &mut Scope,
    model: &mut Model,
    messages: &mut Messages,
) {
    let name = fields.name("bodyname", &format!("body {}", index + 1), messages);
    let title = body_title(&name);
    let name_place = fields.one("bodyname").map_or(0..0, place);
    if name == BASE {
        messages.error(
            name_place.clone(),
            "a body may not be called 'base'",
            "this is the name of the base",
            "give the body another name",
        );
    } else if let Some(&first) = scope.bodies.get(&name) {
        messages.push_error(second(
            &format!("there are two bodies '{}'", clip(&name)),
            name_place.clone(),
            scope.body_places[first].clone(),
            "give one of them another name",
        ));
    } else if !name.is_empty() {
        scope.bodies.insert(name.clone(), index);
    }
    scope.body_places.push(name_place);
    let start = model.joints.len();
    for joint in fields.many("joint") {
        let joint = read_joint(joint, index, &title, messages);
        model.joints.push(joint);
    }
    if model.joints.len() == start {
        messages.error(
            fields.one("bodyname").map_or(place(fields.node), place),
            &format!("{title} has no joint"),
            "this body",
            "add a `joint`, or give its mass and points to the body it is fixed to",
        );
    }
    let (mass, center, inertia) = read_mass(fields, &title, messages);
    model.bodies.push(Body {
        name,
        parent: None,
        point: None,
        joints: start..model.joints.len(),
        mass,
        center,
        inertia,
    });
    for point in fields.many("point") {
        read_point(point, Some(index), &title, scope, model, messages);
    }
}

/// The inertia in the order of [`Body::inertia`].
const INERTIA: [&str; 6] = ["Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];

fn read_mass(
    fields: &Fields<'_>,
    title: &str,
    messages: &mut Messages,
) -> (f64, [f64; 3], [f64; 6]) {
    let center = fields.one("com").map_or([0.0; 3], |com| {
        let com_fields = Fields::of(com, &["coordinates"], &[], messages);
        coordinates(
            &com_fields,
            &format!("the centre of mass of {title}"),
            messages,
        )
    });
    let inertia = fields
        .one("inertia")
        .map_or([0.0; 6], |node| numbers(node, INERTIA, title, messages));
    let needs_mass = [
        ("inertia", inertia != [0.0; 6]),
        ("com", center != [0.0; 3]),
    ];
    let mass = match fields.one("mass") {
        Some(node) => {
            let mass = number(node, title, messages);
            if mass < 0.0 {
                messages.error(
                    place(node),
                    &format!("the mass of {title} is negative"),
                    "kilograms",
                    "a mass is zero or positive",
                );
            }
            mass
        }
        None => {
            if let Some((element, _)) = needs_mass.iter().find(|(_, given)| *given) {
                messages.error(
                    fields.one(element).map_or(0..0, place),
                    &format!("{title} has no mass"),
                    &format!("but `{element}` is given"),
                    "add `<mass>`, zero if it is meant to be so, or remove this element",
                );
            }
            0.0
        }
    };
    (mass, center, inertia)
}

fn read_joint(node: Node<'_, '_>, body: usize, title: &str, messages: &mut Messages) -> Joint {
    let one = [
        "jointname",
        "type",
        "nature",
        "symbols",
        "initialvalue",
        "actuated",
    ];
    let fields = Fields::of(node, &one, &[], messages);
    let name = fields.name("jointname", &format!("a joint of {title}"), messages);
    let owner = format!("joint '{}' of {title}", clip(&name));
    let kind = word(
        &fields,
        "type",
        &owner,
        JointKind::from_name,
        messages,
        || JointKind::ALL.iter().map(|kind| kind.name()).collect(),
    );
    let nature = word(
        &fields,
        "nature",
        &owner,
        Nature::from_name,
        messages,
        || Nature::ALL.iter().map(|nature| nature.name()).collect(),
    );
    let nature = nature.unwrap_or(Nature::Independent);
    let (has_velocity, has_acceleration) = symbols(&fields, nature, &owner, messages);
    let initial = fields.one("initialvalue").map_or([0.0; 3], |initial| {
        numbers(initial, ["q", "qd", "qdd"], &owner, messages)
    });
    Joint {
        name,
        kind: kind.unwrap_or(JointKind::ALL[0]),
        nature,
        body,
        parent: None,
        point: None,
        has_velocity,
        has_acceleration,
        actuated: fields.one("actuated").is_some(),
        initial,
    }
}

/// A word out of a short list; `None`, with an error, for any other.
fn word<T>(
    fields: &Fields<'_>,
    field: &str,
    owner: &str,
    from_name: impl Fn(&str) -> Option<T>,
    messages: &mut Messages,
    names: impl Fn() -> Vec<&'static str>,
) -> Option<T> {
    let name = fields.name(field, owner, messages);
    let value = from_name(&name);
    if value.is_none() && !name.is_empty() {
        let names = names();
        let near = did_you_mean(&name, names.iter().copied());
        let near = near.map_or(String::new(), |near| format!("did you mean '{near}'? "));
        messages.error(
            fields.one(field).map_or(0..0, place),
            &format!("{owner} has the unknown {field} '{}'", clip(&name)),
            "not one that exists",
            &format!("{near}it is one of: {}", names.join(", ")),
        );
    }
    value
}

/// Whether velocity and acceleration are symbols. Only a driven joint may do
/// without, and only by listing those it has: a list that is absent forbids
/// nothing.
fn symbols(
    fields: &Fields<'_>,
    nature: Nature,
    owner: &str,
    messages: &mut Messages,
) -> (bool, bool) {
    let Some(node) = fields.one("symbols") else {
        return (true, true);
    };
    let listed = Fields::of(node, &["q", "qd", "qdd"], &[], messages);
    let has = |name| listed.one(name).is_some();
    if nature == Nature::Driven {
        return (has("qd"), has("qdd"));
    }
    if !(has("q") && has("qd") && has("qdd")) {
        messages.warn(
            place(node),
            &format!("{owner} is {} and lists only some symbols", nature.name()),
            "passed over",
            "only a driven joint can have a constant zero for qd or qdd",
        );
    }
    (true, true)
}

fn read_point(
    node: Node<'_, '_>,
    body: Option<usize>,
    owner: &str,
    scope: &mut Scope,
    model: &mut Model,
    messages: &mut Messages,
) {
    let one = ["pointname", "coordinates"];
    let fields = Fields::of(node, &one, &["sensor", "extforce"], messages);
    let name = fields.name("pointname", &format!("a point of {owner}"), messages);
    let title = format!("point '{}' of {owner}", clip(&name));
    let coordinates = coordinates(&fields, &title, messages);
    let index = model.points.len();
    if !name.is_empty() && scope.points.insert((body, name.clone()), index).is_some() {
        messages.error(
            fields.one("pointname").map_or(0..0, place),
            &format!("{owner} has two points '{}'", clip(&name)),
            "the second one",
            "give one of them another name",
        );
    }
    model.points.push(Point {
        name,
        body,
        coordinates,
    });
    for sensor in fields.all() {
        let list = match sensor.tag_name().name() {
            "sensor" => &mut model.sensors,
            "extforce" => &mut model.forces,
            _ => continue,
        };
        list.push(read_sensor(sensor, index, &title, messages));
    }
}

fn read_sensor(node: Node<'_, '_>, point: usize, owner: &str, messages: &mut Messages) -> Sensor {
    let kind = node.tag_name().name();
    let mut sensor = Sensor {
        name: String::new(),
        point,
        asks: Asks::default(),
    };
    for attribute in node.attributes() {
        let value = attribute.value().trim();
        if attribute.name() == "name" {
            value.clone_into(&mut sensor.name);
            continue;
        }
        let Some(asked) = sensor.asks.field(attribute.name()) else {
            let known = Asks::NAMES.iter().copied().chain(["name"]);
            let help = match did_you_mean(attribute.name(), known.clone()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("it may have: {}", known.collect::<Vec<_>>().join(", ")),
            };
            messages.warn(
                attribute.range(),
                &format!(
                    "the {kind} at {owner} has the unknown attribute `{}`",
                    clip(attribute.name())
                ),
                "passed over",
                &help,
            );
            continue;
        };
        match value {
            "true" => *asked = true,
            "false" => *asked = false,
            _ => messages.error(
                attribute.range_value(),
                &format!(
                    "the attribute `{}` of the {kind} at {owner} is '{}'",
                    attribute.name(),
                    clip(value)
                ),
                "neither true nor false",
                "write true or false",
            ),
        }
    }
    if sensor.name.is_empty() || sensor.name.chars().any(char::is_control) {
        messages.error(
            place(node),
            &format!("the {kind} at {owner} has no name"),
            "this element",
            "add the attribute name=\"…\"",
        );
    }
    sensor
}

/// Refuses two joints of one name: the user's functions find joints by it.
fn repeated_joints(bodies: &[Fields<'_>], model: &Model, messages: &mut Messages) {
    let mut seen: FxHashMap<&str, Range<usize>> = FxHashMap::default();
    let nodes = bodies.iter().flat_map(|body| body.many("joint"));
    for (joint, node) in model.joints.iter().zip(nodes) {
        let name_place = node
            .children()
            .find(|child| child.has_tag_name("jointname"))
            .map_or(0..0, place);
        if let Some(first) = seen.get(joint.name.as_str()) {
            if !joint.name.is_empty() {
                messages.push_error(second(
                    &format!(
                        "there are two joints '{}', the second in {}",
                        clip(&joint.name),
                        body_title(&model.bodies[joint.body].name)
                    ),
                    name_place,
                    first.clone(),
                    "give one of them another name",
                ));
            }
        } else {
            seen.insert(&joint.name, name_place);
        }
    }
}

/// Hangs every body on its parent, and every joint on the one before it.
fn hang(bodies: &[Fields<'_>], scope: &Scope, model: &mut Model, messages: &mut Messages) {
    let mut parents = vec![None; bodies.len()];
    for (index, fields) in bodies.iter().enumerate() {
        let title = body_title(&model.bodies[index].name);
        let Some(node) = fields.one("parent") else {
            messages.error(
                fields.one("bodyname").map_or(place(fields.node), place),
                &format!("{title} has no parent"),
                "this body",
                "add `<parent><bodyname>base</bodyname><pointname>origin</pointname></parent>`",
            );
            continue;
        };
        let parent = Fields::of(node, &["bodyname", "pointname"], &[], messages);
        let owner = format!("the parent of {title}");
        if let Some(anchor) = scope.anchor(&parent, &owner, model, messages) {
            parents[index] = anchor.body;
            model.bodies[index].parent = anchor.body;
            model.bodies[index].point = anchor.point;
        }
    }
    order(bodies, &parents, model, messages);
    if messages.has_errors() {
        return;
    }
    model.connect();
}

/// Complains of parents that are declared after their children, on a cycle or
/// not.
fn order(bodies: &[Fields<'_>], parents: &[Option<usize>], model: &Model, messages: &mut Messages) {
    let mut on_known_cycle = vec![false; bodies.len()];
    for (index, fields) in bodies.iter().enumerate() {
        let Some(parent) = parents[index].filter(|&parent| parent >= index) else {
            continue;
        };
        if on_known_cycle[index] {
            continue;
        }
        let name = |index: usize| format!("'{}'", clip(&model.bodies[index].name));
        let range = fields.one("parent").and_then(|node| {
            let child = node
                .children()
                .find(|child| child.has_tag_name("bodyname"))?;
            Some(place(child))
        });
        let range = range.unwrap_or(0..0);
        // At most one step for each body leads back, or to the base.
        let next = |&body: &usize| parents[body];
        let mut path: Vec<usize> = std::iter::successors(Some(index), next)
            .take(bodies.len() + 1)
            .collect();
        match path[1..].iter().position(|&body| body == index) {
            Some(length) => {
                path.truncate(length + 2);
                for &body in &path {
                    on_known_cycle[body] = true;
                }
                let mut names: Vec<String> = path.iter().map(|&body| name(body)).collect();
                if names.len() > 8 {
                    names.splice(5..names.len() - 1, ["…".to_owned()]);
                }
                let message = match names.len() {
                    2 => format!("body {} hangs on itself", names[0]),
                    _ => format!("bodies hang on each other: {}", names.join(" on ")),
                };
                messages.error(
                    range,
                    &message,
                    "this parent closes the cycle",
                    "hang one of them on the base, and close the loop with a cut",
                );
            }
            None => messages.error(
                range,
                &format!(
                    "body {} hangs on body {}, which is declared after it",
                    name(index),
                    name(parent)
                ),
                "declared further down",
                "move the parent before its children: joints are numbered in this order",
            ),
        }
    }
}
