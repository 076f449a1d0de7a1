//! Numbers and triples of numbers.

use super::fields::{ElementFields, Messages, content, place};
use crate::xml::parse_number;
use roxmltree::Node;

/// The number in an element; zero, with an error, when there is none.
pub(super) fn number(node: Node<'_, '_>, owner: &str, messages: &mut Messages) -> f64 {
    let text = content(node);
    let what = node.tag_name().name();
    parse_number(&text).unwrap_or_else(|refusal| {
        let message = format!("`{what}` of {owner}{}", refusal.message);
        messages.error(place(node), &message, refusal.label, refusal.help);
        0.0
    })
}

/// The numbers of the named children, in this order; absent ones are zero.
pub(super) fn numbers<const N: usize>(
    node: Node<'_, '_>,
    names: [&str; N],
    owner: &str,
    messages: &mut Messages,
) -> [f64; N] {
    let fields = ElementFields::of(node, &names, &[], messages);
    names.map(|name| {
        fields
            .one(name)
            .map_or(0.0, |child| number(child, owner, messages))
    })
}

/// The triple in the `coordinates` of an element.
pub(super) fn coordinates(
    fields: &ElementFields<'_>,
    owner: &str,
    messages: &mut Messages,
) -> [f64; 3] {
    match fields.one("coordinates") {
        Some(node) => numbers(node, ["x", "y", "z"], owner, messages),
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
