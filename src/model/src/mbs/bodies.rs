//! The base and the bodies with their masses.

use super::fields::{ElementFields, Messages, coordinates, number, numbers, place, second};
use super::joints::{read_joint, repeated_joints};
use super::points::read_point;
use super::scope::{BASE, ModelScope, body_title};
use crate::{Body, Model};
use robovec_ir::diagnostic::clip;
use robovec_robotran::conventions::{JOINT_LIMIT, JOINTS};
use roxmltree::Node;

pub(super) fn read(
    root: &ElementFields<'_>,
    model: &mut Model,
    messages: &mut Messages,
) -> Option<ModelScope> {
    let mut scope = ModelScope::default();
    if let Some(base) = root.one("base") {
        read_base(base, &mut scope, model, messages);
    } else {
        messages.warn(
            place(root.node),
            "the model has no base",
            "there is no `base` in it",
            "gravity is taken as (0, 0, -9.81) m/s^2; add `<base>` to change it",
        );
    }
    let tree = root.one("bodytree");
    let bodies: Vec<Node<'_, '_>> = match tree {
        Some(tree) => ElementFields::of(tree, &[], &["body"], messages)
            .all()
            .collect(),
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
        let fields = ElementFields::of(node, &one, &["joint", "point"], messages);
        read_body(index, &fields, &mut scope, model, messages);
        all.push(fields);
    }
    repeated_joints(&all, model, messages);
    hang(&all, &scope, model, messages);
    Some(scope)
}

/// Counts bodies and joints before any are processed.
fn within_limit(bodies: &[Node<'_, '_>], messages: &mut Messages) -> bool {
    if let Some(first_beyond) = bodies.get(JOINT_LIMIT) {
        messages.error(
            place(*first_beyond),
            &format!(
                "bodies of the model: {}",
                JOINTS.refusal(&bodies.len().to_string())
            ),
            &format!("body {}", JOINT_LIMIT + 1),
            "every body has a joint; split the model, or replace chains of small bodies by fewer ones",
        );
        return false;
    }
    let joints = bodies.iter().flat_map(|body| body.children());
    let mut joints = joints.filter(|child| child.has_tag_name("joint"));
    let Some(first_beyond) = joints.nth(JOINT_LIMIT) else {
        return true;
    };
    let count = JOINT_LIMIT + 1 + joints.count();
    messages.error(
        place(first_beyond),
        &format!(
            "joints of the model: {}",
            JOINTS.refusal(&count.to_string())
        ),
        &format!("joint {}", JOINT_LIMIT + 1),
        "split the model, or replace chains of small bodies by fewer ones",
    );
    false
}

fn read_base(
    node: Node<'_, '_>,
    scope: &mut ModelScope,
    model: &mut Model,
    messages: &mut Messages,
) {
    let base = ElementFields::of(node, &["gravity"], &["point"], messages);
    match base.one("gravity") {
        Some(gravity) => {
            let gravity = ElementFields::of(gravity, &["coordinates"], &[], messages);
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
    fields: &ElementFields<'_>,
    scope: &mut ModelScope,
    model: &mut Model,
    messages: &mut Messages,
) {
    let name = fields.name("bodyname", &format!("body {}", index + 1), messages);
    let title = body_title(&name);
    let name_place = fields.place_or_own("bodyname");
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
            fields.place_or_own("bodyname"),
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
    fields: &ElementFields<'_>,
    title: &str,
    messages: &mut Messages,
) -> (f64, [f64; 3], [f64; 6]) {
    let center = match fields.one("com") {
        Some(com) => {
            let com_fields = ElementFields::of(com, &["coordinates"], &[], messages);
            let owner = format!("the centre of mass of {title}");
            coordinates(&com_fields, &owner, messages)
        }
        None => [0.0; 3],
    };
    let inertia = numbers(fields.one("inertia"), INERTIA, title, messages);
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
                messages.warn(
                    fields.place_of(element),
                    &format!("{title} has no mass"),
                    &format!("but `{element}` is given"),
                    "its mass is taken as 0, as Robotran does; write it, even where it is zero",
                );
            }
            0.0
        }
    };
    (mass, center, inertia)
}

/// Hangs every body on its parent, and every joint on the one before it.
pub(super) fn hang(
    bodies: &[ElementFields<'_>],
    scope: &ModelScope,
    model: &mut Model,
    messages: &mut Messages,
) {
    assert_eq!(bodies.len(), model.bodies.len(), "every element is a body");
    let mut parents = vec![None; bodies.len()];
    for (index, fields) in bodies.iter().enumerate() {
        let title = body_title(&model.bodies[index].name);
        let Some(node) = fields.one("parent") else {
            messages.error(
                fields.place_or_own("bodyname"),
                &format!("{title} has no parent"),
                "this body",
                "add `<parent><bodyname>base</bodyname><pointname>origin</pointname></parent>`",
            );
            continue;
        };
        let parent = ElementFields::of(node, &["bodyname", "pointname"], &[], messages);
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

/// Complains of parents declared after their children, on a cycle or not.
fn order(
    bodies: &[ElementFields<'_>],
    parents: &[Option<usize>],
    model: &Model,
    messages: &mut Messages,
) {
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
        let range = range.expect("the name of the parent was read");
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
                    2 => format!("body {} is its own parent", names[0]),
                    _ => format!(
                        "these bodies are parents of one another: {}",
                        names.join(" on ")
                    ),
                };
                messages.error(
                    range,
                    &message,
                    "this parent closes the cycle",
                    "connect one of them to the base, and close the loop with a cut",
                );
            }
            None => messages.error(
                range,
                &format!(
                    "the parent of body {} is body {}, which is declared after it",
                    name(index),
                    name(parent)
                ),
                "declared further down",
                "move the parent before its children: joints are numbered in this order",
            ),
        }
    }
}
