//! Tree of the bodies.

use super::fields::{ElementFields, Messages, place};
use super::scope::{ModelScope, body_title};
use crate::Model;
use robovec_ir::diagnostic::clip;

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

/// Complains of parents that are declared after their children, on a cycle or
/// not.
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
