//! What an element may hold, and messages about what it should not.

use robovec_ir::diagnostic::{Diagnostic, Label, clip, did_you_mean};
use roxmltree::Node;
use std::ops::Range;

/// No more errors, and no more warnings, than this are reported for one file.
const LIMIT: usize = 20;

/// What is wrong or remarkable about a file.
#[derive(Default)]
pub(super) struct Messages {
    errors: Vec<Diagnostic>,
    warnings: Vec<Diagnostic>,
    more_warnings: usize,
    more_errors: bool,
    left_out: Vec<Diagnostic>,
    more_left_out: usize,
}

/// An error about a place of the text.
pub(super) fn diagnostic(
    range: Range<usize>,
    message: &str,
    label: &str,
    help: &str,
) -> Diagnostic {
    Diagnostic::error()
        .with_message(message)
        .with_labels(vec![Label::primary(0, range).with_message(label)])
        .with_note(format!("help: {help}"))
}

/// An error about what is there twice.
pub(super) fn second(
    message: &str,
    second: Range<usize>,
    first: Range<usize>,
    help: &str,
) -> Diagnostic {
    diagnostic(second, message, "the second one", help)
        .with_label(Label::secondary(0, first).with_message("the first one"))
}

impl Messages {
    pub(super) fn push_error(&mut self, error: Diagnostic) {
        if self.errors.len() < LIMIT {
            self.errors.push(error);
        } else {
            self.more_errors = true;
        }
    }

    /// Adds an error about a place.
    pub(super) fn error(&mut self, range: Range<usize>, message: &str, label: &str, help: &str) {
        self.push_error(diagnostic(range, message, label, help));
    }

    /// Adds a warning about a place.
    pub(super) fn warn(&mut self, range: Range<usize>, message: &str, label: &str, help: &str) {
        if self.warnings.len() < LIMIT {
            let mut warning = diagnostic(range, message, label, help);
            warning.severity = robovec_ir::diagnostic::Severity::Warning;
            self.warnings.push(warning);
        } else {
            self.more_warnings += 1;
        }
    }

    /// Adds a warning about what is read but is in no equation. Only a command
    /// that makes equations has reason to tell it.
    pub(super) fn leave_out(
        &mut self,
        range: Range<usize>,
        message: &str,
        label: &str,
        help: &str,
    ) {
        if self.left_out.len() < LIMIT {
            let mut warning = diagnostic(range, message, label, help);
            warning.severity = robovec_ir::diagnostic::Severity::Warning;
            self.left_out.push(warning);
        } else {
            self.more_left_out += 1;
        }
    }

    /// The warnings about what is in no equation, which are no part of the
    /// others.
    pub(super) fn take_left_out(&mut self) -> Vec<Diagnostic> {
        let mut all = std::mem::take(&mut self.left_out);
        if self.more_left_out > 0 {
            all.push(Diagnostic::note().with_message(format!(
                "{} more are left out and not shown",
                self.more_left_out
            )));
        }
        all
    }

    /// False when further errors are only counted, so that there is no point in
    /// searching for advice.
    pub(super) fn has_room(&self) -> bool {
        self.errors.len() < LIMIT
    }

    /// Remembers an error that there is no room for.
    pub(super) fn count_error(&mut self) {
        self.more_errors = true;
    }

    pub(super) fn has_errors(&self) -> bool {
        !self.errors.is_empty()
    }

    /// The errors, then the warnings.
    pub(super) fn into_diagnostics(self) -> Vec<Diagnostic> {
        let mut all = self.errors;
        if self.more_errors {
            all.push(Diagnostic::note().with_message(format!(
                "reading stopped after {LIMIT} errors; there are more"
            )));
        }
        all.extend(self.warnings);
        if self.more_warnings > 0 {
            all.push(Diagnostic::note().with_message(format!(
                "{} more warnings are not shown",
                self.more_warnings
            )));
        }
        all
    }
}

/// Where an element is, for a message: its text when that is all it holds,
/// else its opening tag up to its name.
pub(super) fn place(node: Node<'_, '_>) -> Range<usize> {
    let text = node.children().find(|child| child.is_text());
    if let Some(text) = text
        && !node.children().any(|child| child.is_element())
        && let Some(content) = text.text().map(str::trim)
        && !content.is_empty()
    {
        let range = text.range();
        let source = &node.document().input_text()[range.clone()];
        let start = range.start + (source.len() - source.trim_start().len());
        return start..start + source.trim().len();
    }
    let start = node.range().start;
    let source = &node.document().input_text()[start..];
    let length = source.find(['>', ' ', '\n', '\r', '\t', '/']).unwrap_or(1);
    start..start + length.max(1)
}

/// The text of an element, without the blanks around it.
pub(super) fn content(node: Node<'_, '_>) -> String {
    let mut text = String::new();
    for piece in node.children().filter(|child| child.is_text()) {
        text.push_str(piece.text().unwrap_or_default());
    }
    text.trim().to_owned()
}

/// The children of an element, told apart by name.
pub(super) struct ElementFields<'a> {
    /// The element itself.
    pub(super) node: Node<'a, 'a>,
    children: Vec<Node<'a, 'a>>,
}

/// Elements with nothing but drawings, and old declarations that mean nothing
/// to the equations.
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
                // At most one of each is in this list, so that searching it
                // takes no time.
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

    /// Where the child of this name is, for a message. The child must be
    /// there, as one is whose content was read.
    pub(super) fn place_of(&self, name: &str) -> Range<usize> {
        place(self.one(name).expect("a field that was read is there"))
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

/// The name of the project, which is also the suffix of the files of
/// equations.
pub(super) fn project_name(
    root: &ElementFields<'_>,
    file: &str,
    messages: &mut Messages,
) -> String {
    if root.one("mbsname").is_none() {
        let stem = file.strip_suffix(".mbs").unwrap_or(file).trim();
        let usable = !stem.is_empty() && !stem.contains(['/', '\\', '\n', '\r', '\t']);
        let stem = if usable { stem } else { "model" };
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
