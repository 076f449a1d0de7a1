//! Cuts of loops and links, which have two ends, and user models without any.

use super::fields::{ElementFields, Messages, content, number, place};
use super::scope::ModelScope;
use crate::{Anchor, Cut, CutKind, Link, Model, UserModel};
use robovec_ir::diagnostic::clip;
use roxmltree::Node;

pub(super) fn read(
    root: &ElementFields<'_>,
    scope: &ModelScope,
    model: &mut Model,
    messages: &mut Messages,
) {
    if let Some(cuts) = root.one("cuts") {
        for node in ElementFields::of(cuts, &[], &["ball", "rod", "solid"], messages).all() {
            if let Some(cut) = read_cut(node, scope, model, messages) {
                model.cuts.push(cut);
            }
        }
    }
    if let Some(links) = root.one("links") {
        for node in ElementFields::of(links, &[], &["link", "link3D"], messages).all() {
            let fields =
                ElementFields::of(node, &["name", "endpoint1", "endpoint2"], &[], messages);
            let (name, ends) = name_and_ends(&fields, scope, model, messages);
            if let Some(ends) = ends {
                if node.tag_name().name() == "link3D" {
                    leave_out(&name, &fields, messages);
                }
                let list = match node.tag_name().name() {
                    "link3D" => &mut model.links3d,
                    _ => &mut model.links,
                };
                list.push(Link { name, ends });
            }
        }
    }
}

/// Remembers that no function is generated for a link with a torque.
fn leave_out(name: &str, fields: &ElementFields<'_>, messages: &mut Messages) {
    messages.leave_out(
        fields.place_or_own("name"),
        &format!("link3D '{}' is left out of the equations", clip(name)),
        "no function is generated for its force and torque",
        "add them to the `frc` and `trq` of its bodies in your own program",
    );
}

fn read_cut(
    node: Node<'_, '_>,
    scope: &ModelScope,
    model: &Model,
    messages: &mut Messages,
) -> Option<Cut> {
    let kind = node.tag_name().name();
    let one: &[&str] = match kind {
        "rod" => &["name", "endpoint1", "endpoint2", "length"],
        _ => &["name", "endpoint1", "endpoint2", "ignore"],
    };
    let fields = ElementFields::of(node, one, &[], messages);
    let (name, ends) = name_and_ends(&fields, scope, model, messages);
    let owner = format!("{kind} '{}'", clip(&name));
    let kind = match kind {
        "rod" => CutKind::Rod(length(&fields, &owner, messages)),
        "ball" => CutKind::Ball,
        _ => CutKind::Solid,
    };
    let mut ignore = [false; 3];
    if let Some(node) = fields.one("ignore")
        && kind == CutKind::Solid
    {
        messages.error(
            place(node),
            &format!("{owner} ignores directions"),
            "only a ball can",
            "close the loop with a ball, or with rods, where less than six directions are held",
        );
    } else if let Some(node) = fields.one("ignore") {
        let axes = ["x", "y", "z"];
        let listed = ElementFields::of(node, &axes, &[], messages);
        ignore = axes.map(|axis| listed.one(axis).is_some());
        if ignore == [true; 3] {
            messages.error(
                place(node),
                &format!("{owner} ignores all three directions"),
                "the cut has no constraints left",
                "remove the cut, or one of the directions",
            );
        }
    }
    let ends = ends?;
    if ends[0].body == ends[1].body {
        messages.warn(
            place(node),
            &format!("both ends of {owner} are on the same body"),
            "closes no loop",
            "its constraints always hold or never hold; name two bodies",
        );
    }
    Some(Cut {
        name,
        kind,
        ends,
        ignore,
        rotation: None,
    })
}

fn length(fields: &ElementFields<'_>, owner: &str, messages: &mut Messages) -> f64 {
    let Some(node) = fields.one("length") else {
        messages.error(
            place(fields.node),
            &format!("{owner} has no length"),
            "this rod",
            "add `<length>` in metres",
        );
        return 1.0;
    };
    let length = number(node, owner, messages);
    if length <= 0.0 {
        messages.error(
            place(node),
            &format!("the length of {owner} is not positive"),
            "metres",
            "a rod keeps two points apart; use a ball to keep them together",
        );
    }
    length
}

/// The name of a cut or link, and its ends when they exist.
fn name_and_ends(
    fields: &ElementFields<'_>,
    scope: &ModelScope,
    model: &Model,
    messages: &mut Messages,
) -> (String, Option<[Anchor; 2]>) {
    let kind = fields.node.tag_name().name();
    let name = fields.name("name", &format!("a {kind}"), messages);
    let mut end = |field: &str| {
        let owner = format!("{field} of {kind} '{}'", clip(&name));
        let Some(node) = fields.one(field) else {
            messages.error(
                place(fields.node),
                &format!("{kind} '{}' has no `{field}`", clip(&name)),
                "this element",
                "both ends name a body and a point of it",
            );
            return None;
        };
        let end = ElementFields::of(node, &["bodyname", "pointname"], &[], messages);
        scope.anchor(&end, &owner, model, messages)
    };
    let ends = [end("endpoint1"), end("endpoint2")];
    match ends {
        [Some(first), Some(second)] => (name, Some([first, second])),
        _ => (name, None),
    }
}

/// Reads parameters of the user's functions; no equation depends on them.
pub(super) fn read_user_models(
    root: &ElementFields<'_>,
    model: &mut Model,
    messages: &mut Messages,
) {
    let Some(models) = root.one("user_models") else {
        return;
    };
    for node in ElementFields::of(models, &[], &["user_model"], messages).all() {
        let fields = ElementFields::of(node, &["name"], &["parameter"], messages);
        let name = fields.name("name", "a user model", messages);
        let parameters = fields
            .many("parameter")
            .map(|node| {
                let one = ["name", "type", "structure", "header"];
                let fields = ElementFields::of(node, &one, &["value"], messages);
                let owner = format!("a parameter of user model '{}'", clip(&name));
                let parameter = fields.name("name", &owner, messages);
                let owner = format!(
                    "parameter '{}' of user model '{}'",
                    clip(&parameter),
                    clip(&name)
                );
                let kind = fields.one("type").map(content).unwrap_or_default();
                let values = fields
                    .many("value")
                    .map(|value| number(value, &owner, messages))
                    .collect();
                (parameter, kind, values)
            })
            .collect();
        model.user_models.push(UserModel { name, parameters });
    }
}
