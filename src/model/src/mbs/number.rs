//! Numbers and triples of numbers.

use super::fields::{ElementFields, Messages, content, place};
use crate::xml::parse_number;
use roxmltree::Node;

/// The number in an element; zero, with an error, when there is none.
pub(super) fn number(node: Node<'_, '_>, owner: &str, messages: &mut Messages) -> f64 {
    let text = content(node);
    let what = node.tag_name().name();
    match parse_number(&text) {
        Ok(number) => number,
        Err(refusal) => {
            let message = format!("`{what}` of {owner}{}", refusal.message);
            messages.error(place(node), &message, refusal.label, refusal.help);
            0.0
        }
    }
}

/// The numbers of the named children of an element, in this order; absent ones
/// are zero, and all of no element.
pub(super) fn numbers<const N: usize>(
    node: Option<Node<'_, '_>>,
    names: [&str; N],
    owner: &str,
    messages: &mut Messages,
) -> [f64; N] {
    let mut numbers = [0.0; N];
    if let Some(node) = node {
        let fields = ElementFields::of(node, &names, &[], messages);
        for (place, name) in numbers.iter_mut().zip(names) {
            if let Some(child) = fields.one(name) {
                *place = number(child, owner, messages);
            }
        }
    }
    numbers
}

/// The triple in the `coordinates` of an element.
pub(super) fn coordinates(
    fields: &ElementFields<'_>,
    owner: &str,
    messages: &mut Messages,
) -> [f64; 3] {
    match fields.one("coordinates") {
        node @ Some(_) => numbers(node, ["x", "y", "z"], owner, messages),
        None => {
            messages.error(
                place(fields.node),
                &format!("{owner} has no coordinates"),
                "in this element",
                "add `<coordinates><x>0</x><y>0</y><z>0</z></coordinates>`",
            );
            [0.0; 3]
        }
    }
}
