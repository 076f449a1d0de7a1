//! Contents of elements, and messages about wrong ones.

pub(super) use crate::xml::{Messages, content, place, second};
use crate::xml::{parse_number, stem};
use robovec_ir::diagnostic::{clip, did_you_mean};
use roxmltree::Node;
use std::ops::Range;

/// The children of an element, distinguished by name.
pub(super) struct ElementFields<'a> {
    /// The element itself.
    pub(super) node: Node<'a, 'a>,
    children: Vec<Node<'a, 'a>>,
}

/// Elements with drawings alone, and old declarations without any effect.
const IGNORED: [&str; 6] = [
    "graphics",
    "x3D",
    "x2D",
    "user_variables",
    "mbsyspad_version",
    "baseBodyName",
];

impl<'a> ElementFields<'a> {
    /// The children of an element that may hold each of `one` once and each
    /// of `many` any number of times. Others are warned of.
    pub(super) fn of(
        node: Node<'a, 'a>,
        one: &[&str],
        many: &[&str],
        messages: &mut Messages,
    ) -> ElementFields<'a> {
        let mut children: Vec<Node<'a, 'a>> = Vec::new();
        let mut single: Vec<Node<'a, 'a>> = Vec::new();
        let parent = node.tag_name().name();
        for child in node.children().filter(|child| child.is_element()) {
            let name = child.tag_name().name();
            if many.contains(&name) {
                children.push(child);
            } else if one.contains(&name) {
                // At most one of each is in this list, which is short.
                match single.iter().find(|other| other.tag_name().name() == name) {
                    None => {
                        single.push(child);
                        children.push(child);
                    }
                    Some(first) if messages.has_room() => messages.push_error(second(
                        &format!("`{name}` is given twice in one `{parent}`"),
                        place(child),
                        place(*first),
                        "remove one of them",
                    )),
                    Some(_) => messages.count_error(),
                }
            } else if !IGNORED.contains(&name) {
                let known = one.iter().chain(many).copied();
                let help = match did_you_mean(name, known.clone()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None if one.is_empty() && many.is_empty() => {
                        format!("`{parent}` holds no elements")
                    }
                    None => {
                        let known: Vec<&str> = known.collect();
                        format!("`{parent}` holds: {}", known.join(", "))
                    }
                };
                let message = format!("the element `{}` is not known here", clip(name));
                let start = child.range().start;
                let range = start..start + 1 + name.len();
                messages.warn(range, &message, "passed over", &help);
            }
        }
        ElementFields { node, children }
    }

    /// The children of the root, when it is a model's.
    pub(super) fn of_root(
        root: Node<'a, 'a>,
        messages: &mut Messages,
    ) -> Option<ElementFields<'a>> {
        let name = root.tag_name().name();
        if name != "mbsDescR7" {
            messages.error(
                place(root),
                "this is XML, but not a model",
                "the first element is not `mbsDescR7`",
                "give a `.mbs` file as Robotran's editor saves it",
            );
            return None;
        }
        let one = [
            "mbsname",
            "base",
            "bodytree",
            "cuts",
            "links",
            "user_models",
        ];
        Some(ElementFields::of(root, &one, &[], messages))
    }

    /// The only child of this name.
    pub(super) fn one(&self, name: &str) -> Option<Node<'a, 'a>> {
        self.many(name).next()
    }

    /// Place of the child of this name, whose content was read, for a message.
    pub(super) fn place_of(&self, name: &str) -> Range<usize> {
        place(self.one(name).expect("a field that was read is there"))
    }

    /// Place where the child of this name is, or else the element.
    pub(super) fn place_or_own(&self, name: &str) -> Range<usize> {
        place(self.one(name).unwrap_or(self.node))
    }

    /// All children of this name, in order.
    pub(super) fn many(&self, name: &str) -> impl Iterator<Item = Node<'a, 'a>> + '_ {
        let name = name.to_owned();
        self.children
            .iter()
            .copied()
            .filter(move |child| child.tag_name().name() == name)
    }

    /// All children, in order.
    pub(super) fn all(&self) -> impl Iterator<Item = Node<'a, 'a>> + '_ {
        self.children.iter().copied()
    }

    /// The name in a child; an error and a stand-in when there is none.
    pub(super) fn name(&self, field: &str, owner: &str, messages: &mut Messages) -> String {
        let Some(child) = self.one(field) else {
            messages.error(
                place(self.node),
                &format!("{owner} has no `{field}`"),
                "in this element",
                &format!("add `<{field}>…</{field}>`"),
            );
            return String::new();
        };
        let name = content(child);
        if name.is_empty() {
            messages.error(
                place(child),
                &format!("the `{field}` of {owner} is empty"),
                "no name",
                "write a name between the tags",
            );
        } else if name.chars().any(char::is_control) {
            messages.error(
                place(child),
                &format!("the `{field}` of {owner} holds a line break or a tab"),
                "this name",
                "write the name on one line",
            );
            // So that further messages about it stay on one line.
            return name.replace(char::is_control, " ");
        }
        name
    }
}

/// Name of the project, also the suffix of the files of equations.
pub(super) fn project_name(
    root: &ElementFields<'_>,
    file: &str,
    messages: &mut Messages,
) -> String {
    if root.one("mbsname").is_none() {
        let stem = stem(file, ".mbs", "model");
        messages.warn(
            place(root.node),
            "the model has no name",
            "there is no `mbsname` in it",
            &format!("it is called '{}' after its file", clip(stem)),
        );
        return stem.to_owned();
    }
    let name = root.name("mbsname", "the model", messages);
    if name.contains(['/', '\\']) {
        messages.error(
            root.place_of("mbsname"),
            "the name of the model holds a slash",
            "it becomes part of file names",
            "use letters, digits and underscores",
        );
    }
    name
}

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

/// The numbers of the named children of an element; absent ones are zero.
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
