//! Numbers and triples of numbers.

use super::NUMBER;
use super::fields::{ElementFields, Messages, content, place};
use robovec_ir::diagnostic::clip;
use robovec_num::limits::Amount;
use roxmltree::Node;

/// The number in an element; zero, with an error, when there is none.
pub(super) fn number(node: Node<'_, '_>, owner: &str, messages: &mut Messages) -> f64 {
    let text = content(node);
    let what = node.tag_name().name();
    let mut fail = |message: String, label: &str, help: &str| {
        messages.error(place(node), &message, label, help);
        0.0
    };
    match text.parse::<f64>() {
        Ok(value) if NUMBER.admits(Amount::Real(value)) => value,
        Ok(value) if value.is_finite() => fail(
            format!("`{what}` of {owner}: {}", NUMBER.refusal(&text)),
            "this value",
            "models are in SI units",
        ),
        Ok(value) => {
            let kind = if value.is_nan() {
                "not a number"
            } else {
                "not finite"
            };
            fail(
                format!("`{what}` of {owner} is {kind}"),
                "this value",
                "write a finite number below 1.8e308",
            )
        }
        Err(_) if text.is_empty() => fail(
            format!("`{what}` of {owner} is empty"),
            "no number",
            "write a number between the tags, or remove the element where it is zero",
        ),
        Err(_) => {
            let help = if text.replace(',', ".").parse::<f64>().is_ok() {
                "write a point instead of the comma"
            } else {
                "write a number such as 0.5 or -1.2e-3"
            };
            fail(
                format!("`{what}` of {owner} is no number: '{}'", clip(&text)),
                "this value",
                help,
            )
        }
    }
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
