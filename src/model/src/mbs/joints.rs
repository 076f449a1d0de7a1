//! Joints.

use super::fields::{ElementFields, Messages, numbers, place, second};
use super::scope::body_title;
use crate::{Joint, JointKind, JointMounting, Model, Nature};
use robovec_ir::diagnostic::{clip, did_you_mean};
use roxmltree::Node;
use rustc_hash::FxHashMap;
use std::ops::Range;

/// Reads a joint of a body; its attachment is filled in later.
pub(super) fn read_joint(
    node: Node<'_, '_>,
    body: usize,
    title: &str,
    messages: &mut Messages,
) -> Joint {
    let one = [
        "jointname",
        "type",
        "nature",
        "symbols",
        "initialvalue",
        "actuated",
    ];
    let fields = ElementFields::of(node, &one, &[], messages);
    let name = fields.name("jointname", &format!("a joint of {title}"), messages);
    let owner = format!("joint '{}' of {title}", clip(&name));
    let kinds = JointKind::ALL.map(|kind| (kind.name(), kind));
    let kind = word(&fields, "type", &owner, kinds, messages);
    let natures = Nature::ALL.map(|nature| (nature.name(), nature));
    let nature = word(&fields, "nature", &owner, natures, messages);
    let (has_velocity, has_acceleration) = symbols(&fields, nature, &owner, messages);
    let initial = fields.one("initialvalue");
    let initial = numbers(initial, ["q", "qd", "qdd"], &owner, messages);
    Joint {
        name,
        kind,
        nature,
        body,
        parent: None,
        point: None,
        has_velocity,
        has_acceleration,
        actuated: fields.one("actuated").is_some(),
        initial,
        mounting: JointMounting::default(),
        limits: None,
        law: Default::default(),
        armature: 0.0,
    }
}

/// The value of a word of a list; the first one, with an error, for any other.
fn word<T: Copy, const N: usize>(
    fields: &ElementFields<'_>,
    field: &str,
    owner: &str,
    words: [(&'static str, T); N],
    messages: &mut Messages,
) -> T {
    let name = fields.name(field, owner, messages);
    if let Some((_, value)) = words.iter().find(|(word, _)| *word == name) {
        return *value;
    }
    if !name.is_empty() {
        let names = words.map(|(word, _)| word);
        let near = did_you_mean(&name, names);
        let near = near.map_or(String::new(), |near| format!("did you mean '{near}'? "));
        messages.error(
            fields.place_of(field),
            &format!("{owner} has the unknown {field} '{}'", clip(&name)),
            "not one that exists",
            &format!("{near}it is one of: {}", names.join(", ")),
        );
    }
    words[0].1
}

/// Tests whether velocity and acceleration are symbols. Only a driven joint may
/// omit it, and only if others are listed: an absent list forbids nothing.
fn symbols(
    fields: &ElementFields<'_>,
    nature: Nature,
    owner: &str,
    messages: &mut Messages,
) -> (bool, bool) {
    let Some(node) = fields.one("symbols") else {
        return (true, true);
    };
    let listed = ElementFields::of(node, &["q", "qd", "qdd"], &[], messages);
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

/// Refuses two joints of one name: the user's functions find joints by it.
pub(super) fn repeated_joints(
    bodies: &[ElementFields<'_>],
    model: &Model,
    messages: &mut Messages,
) {
    let mut seen: FxHashMap<&str, Range<usize>> = FxHashMap::default();
    let nodes = bodies.iter().flat_map(|body| body.many("joint"));
    for (joint, node) in model.joints.iter().zip(nodes) {
        // A name that is missing is empty, and has had its error.
        if joint.name.is_empty() {
            continue;
        }
        let mut children = node.children();
        let named = children.find(|child| child.has_tag_name("jointname"));
        let name_place = place(named.expect("the name was read"));
        if let Some(first) = seen.get(joint.name.as_str()) {
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
        } else {
            seen.insert(&joint.name, name_place);
        }
    }
}
