//! Classes of default attributes.

use crate::robot::attributes::place_of;
use crate::xml::{Messages, place};
use robovec_ir::diagnostic::{clip, suggestion};
use roxmltree::Node;

/// A class, an index into [`Defaults`].
pub(super) type ClassIndex = usize;

/// The class of elements that name none.
pub(super) const MAIN: ClassIndex = 0;

struct DefaultClass<'a> {
    name: String,
    parent: Option<ClassIndex>,
    /// The element `default`.
    node: Option<Node<'a, 'a>>,
}

/// The classes of a file, each after its own; the first is for all elements.
pub(super) struct Defaults<'a> {
    classes: Vec<DefaultClass<'a>>,
}

impl<'a> Defaults<'a> {
    pub(super) fn read(root: Node<'a, 'a>, messages: &mut Messages) -> Defaults<'a> {
        let mut classes = vec![DefaultClass {
            name: "main".to_owned(),
            parent: None,
            node: None,
        }];
        let sections = super::children(root, "default");
        let mut pending: Vec<(Node<'a, 'a>, Option<ClassIndex>)> =
            sections.map(|node| (node, None)).collect();
        pending.reverse();
        while let Some((node, parent)) = pending.pop() {
            let name = node.attribute("class").map(str::trim);
            if name.is_none() && parent.is_some() {
                messages.error(
                    place(node),
                    "a class of defaults has no name",
                    "in this element",
                    "add `class=\"…\"`",
                );
            }
            let name = name.unwrap_or("main").to_owned();
            let index = match parent {
                // Sections of included files add to the first class.
                None if classes[0].node.is_none() => {
                    classes[0].name = name;
                    classes[0].node = Some(node);
                    0
                }
                _ => {
                    classes.push(DefaultClass {
                        name,
                        parent: Some(parent.unwrap_or(0)),
                        node: Some(node),
                    });
                    classes.len() - 1
                }
            };
            let start = pending.len();
            pending.extend(super::children(node, "default").map(|inner| (inner, Some(index))));
            pending[start..].reverse();
        }
        Defaults { classes }
    }

    /// The class that an attribute names, or else the one around the element.
    pub(super) fn class(
        &self,
        node: Node<'_, '_>,
        attribute: &str,
        around: ClassIndex,
        messages: &mut Messages,
    ) -> ClassIndex {
        let Some(name) = node.attribute(attribute).map(str::trim) else {
            return around;
        };
        if let Some(found) = self.classes.iter().position(|class| class.name == name) {
            return found;
        }
        let names = self.classes.iter().map(|class| class.name.as_str());
        let help = suggestion(name, names)
            .unwrap_or_else(|| format!("add `<default class=\"{}\">`", clip(name)));
        messages.error(
            place_of(node, attribute),
            &format!("there is no class of defaults '{}'", clip(name)),
            "this class",
            &help,
        );
        around
    }

    /// The element that holds an attribute of an element of a class: itself, or
    /// one of the same name in its class or in those around it.
    pub(super) fn holder(
        &self,
        node: Node<'a, 'a>,
        class: ClassIndex,
        attribute: &str,
    ) -> Option<Node<'a, 'a>> {
        if node.has_attribute(attribute) {
            return Some(node);
        }
        let name = node.tag_name().name();
        let classes = std::iter::successors(Some(class), |&class| self.classes[class].parent);
        let nodes = classes.filter_map(|class| self.classes[class].node);
        let mut elements = nodes.flat_map(|node| node.children());
        elements
            .find(|element| element.tag_name().name() == name && element.has_attribute(attribute))
    }
}
