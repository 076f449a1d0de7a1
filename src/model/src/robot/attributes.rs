//! Attributes and children of elements, and messages about faults in them.

use crate::rotation::{FramePose, Rotation3, to_right_angle};
use crate::xml::{Messages, parse_number, place, second};
use robovec_ir::diagnostic::{clip, did_you_mean};
use roxmltree::Node;
use std::ops::Range;

/// The children of an element by name, at most one of each; a name that is
/// similar to a known one gets a warning, since it would be ignored.
pub(super) fn children<'a, const N: usize>(
    node: Node<'a, 'a>,
    known: [&str; N],
    messages: &mut Messages,
) -> [Option<Node<'a, 'a>>; N] {
    let mut found: [Option<Node<'a, 'a>>; N] = [None; N];
    for child in node.children().filter(|child| child.is_element()) {
        let name = child.tag_name().name();
        match known.iter().position(|known| *known == name) {
            Some(index) => match found[index] {
                None => found[index] = Some(child),
                Some(_) if !messages.has_room() => messages.count_error(),
                Some(first) => messages.push_error(second(
                    &format!(
                        "`{name}` is given twice in one `{}`",
                        node.tag_name().name()
                    ),
                    place(child),
                    place(first),
                    "remove one of them",
                )),
            },
            None => remark_unknown(child, &known, messages),
        }
    }
    found
}

/// Extensions of simulators are many, so only probable mistakes are reported.
pub(super) fn remark_unknown(child: Node<'_, '_>, known: &[&str], messages: &mut Messages) {
    let name = child.tag_name().name();
    if let Some(near) = did_you_mean(name, known.iter().copied()) {
        messages.warn(
            place(child),
            &format!("the element `{}` is not known here", clip(name)),
            "passed over",
            &format!("did you mean `{near}`?"),
        );
    }
}

/// Place where an attribute is, for a message: its value, or else the element.
pub(super) fn place_of(node: Node<'_, '_>, attribute: &str) -> Range<usize> {
    match node.attribute_node(attribute) {
        Some(found) if !found.range_value().is_empty() => found.range_value(),
        Some(found) => found.range(),
        None => place(node),
    }
}

/// Place where an attribute of a child is, or else the element.
pub(super) fn place_in(
    node: Node<'_, '_>,
    child: Option<Node<'_, '_>>,
    attribute: &str,
) -> Range<usize> {
    child.map_or_else(|| place(node), |child| place_of(child, attribute))
}

/// A name in an attribute; `None`, with an error, where there is none.
pub(super) fn name(
    node: Node<'_, '_>,
    attribute: &str,
    owner: &str,
    messages: &mut Messages,
) -> Option<String> {
    let range = place_of(node, attribute);
    let (message, label, help) = match node.attribute(attribute).map(str::trim) {
        None => (
            format!("{owner} has no attribute '{attribute}'"),
            "in this element",
            format!("add `{attribute}=\"…\"`"),
        ),
        Some("") => (
            format!("the attribute '{attribute}' of {owner} is empty"),
            "no name",
            "write a name between the quotes".to_owned(),
        ),
        Some(text) if text.chars().any(char::is_control) => (
            format!("the attribute '{attribute}' of {owner} holds a line break or a tab"),
            "this name",
            "write the name on one line".to_owned(),
        ),
        Some(text) => return Some(text.to_owned()),
    };
    messages.error(range, &message, label, &help);
    None
}

/// A number in an attribute; `None`, with an error, for any other text, and
/// without one where the attribute is missing.
pub(super) fn number(
    node: Node<'_, '_>,
    attribute: &str,
    owner: &str,
    messages: &mut Messages,
) -> Option<f64> {
    let text = node.attribute(attribute)?;
    parse_number(text.trim())
        .map_err(|refusal| {
            let message = format!("'{attribute}' of {owner}{}", refusal.message);
            let range = place_of(node, attribute);
            let help = if text.trim().is_empty() {
                "write a number between the quotes"
            } else {
                refusal.help
            };
            messages.error(range, &message, refusal.label, help);
        })
        .ok()
}

/// The same, with a default instead of `None`.
pub(super) fn number_or(
    node: Node<'_, '_>,
    attribute: &str,
    default: f64,
    owner: &str,
    messages: &mut Messages,
) -> f64 {
    number(node, attribute, owner, messages).unwrap_or(default)
}

/// A required number; zero, with an error, where it is missing.
pub(super) fn required(
    node: Node<'_, '_>,
    attribute: &str,
    owner: &str,
    messages: &mut Messages,
) -> f64 {
    if node.attribute(attribute).is_none() {
        messages.error(
            place(node),
            &format!("{owner} has no attribute '{attribute}'"),
            "in this element",
            &format!("add `{attribute}=\"…\"`"),
        );
    }
    number_or(node, attribute, 0.0, owner, messages)
}

/// Numbers in an attribute; `None` where it is missing or (an error) wrong.
pub(super) fn numbers(
    node: Node<'_, '_>,
    attribute: &str,
    owner: &str,
    messages: &mut Messages,
) -> Option<Vec<f64>> {
    let mut values = Vec::new();
    for word in node.attribute(attribute)?.split_whitespace() {
        match parse_number(word) {
            Ok(value) => values.push(value),
            Err(refusal) => {
                let message = format!("'{attribute}' of {owner}{}", refusal.message);
                let range = place_of(node, attribute);
                messages.error(range, &message, refusal.label, refusal.help);
                return None;
            }
        }
    }
    Some(values)
}

/// Three numbers in an attribute; by default `default`, else an error.
pub(super) fn triple(
    node: Node<'_, '_>,
    attribute: &str,
    owner: &str,
    default: [f64; 3],
    messages: &mut Messages,
) -> [f64; 3] {
    let Some(values) = numbers(node, attribute, owner, messages) else {
        return default;
    };
    values[..].try_into().unwrap_or_else(|_| {
        messages.error(
            place_of(node, attribute),
            &format!("'{attribute}' of {owner} holds {} numbers", values.len()),
            "three are wanted",
            "write three numbers with blanks between them, such as \"0 0 1.5\"",
        );
        default
    })
}

/// The pose in an `origin`, if there is one.
pub(super) fn read_pose(
    node: Option<Node<'_, '_>>,
    (title, right_angle): (&str, f64),
    messages: &mut Messages,
) -> FramePose {
    let Some(node) = node else {
        return FramePose::HERE;
    };
    let title = format!("the origin of {title}");
    let origin = triple(node, "xyz", &title, [0.0; 3], messages);
    let angles = triple(node, "rpy", &title, [0.0; 3], messages);
    let angles = angles.map(|angle| to_right_angle(angle, right_angle));
    FramePose {
        rotation: Rotation3::from_roll_pitch_yaw(angles),
        origin,
    }
}

/// The number of a required attribute of a child.
pub(super) fn value_of(
    node: Node<'_, '_>,
    child: Option<Node<'_, '_>>,
    (element, title): (&str, &str),
    messages: &mut Messages,
) -> f64 {
    match child {
        Some(child) => required(
            child,
            "value",
            &format!("the {element} of {title}"),
            messages,
        ),
        None => {
            messages.error(
                place(node),
                &format!("{title} has no `{element}`"),
                "in this element",
                &format!("add `<{element} value=\"…\"/>`"),
            );
            0.0
        }
    }
}
