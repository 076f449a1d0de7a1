//! The parts of a core: its name, arguments, properties and body.

use super::CoreProblems;
use robovec_ir::Format;
use robovec_ir::diagnostic::Diagnostic;
use robovec_ir::parenthesised::{Forest, TreeKind, error};
use std::collections::BTreeMap;

/// A core, by the trees of its parts.
#[derive(Debug)]
pub(super) struct Core {
    /// The name its function gets, unlike that of every other core.
    pub(super) name: String,
    pub(super) arguments: Vec<u32>,
    pub(super) properties: Vec<(u32, u32)>,
    pub(super) body: u32,
}

pub(super) fn cores(forest: &Forest<'_>) -> Result<Vec<Core>, Vec<Diagnostic>> {
    let (mut cores, mut taken) = (Vec::new(), TakenNames::default());
    for &root in &forest.roots {
        cores.push(one(forest, root, &mut taken).map_err(|error| vec![error])?);
    }
    Ok(cores)
}

fn one(forest: &Forest<'_>, root: u32, taken: &mut TakenNames) -> Result<Core, Diagnostic> {
    let span = forest.get(root).span.clone();
    let elements = match forest.head(root) {
        Some("FPCore") => &forest.elements(root)[1..],
        Some(_) | None => return Err(error(span, "only '(FPCore …)' is allowed outside a core")),
    };
    let (symbol, rest) = match elements {
        [first, rest @ ..] if forest.atom(*first).is_some() => (Some(*first), rest),
        all => (None, all),
    };
    let [arguments, rest @ ..] = rest else {
        return Err(error(
            span,
            "a core has a list of arguments and an expression",
        ));
    };
    if forest.get(*arguments).kind == TreeKind::Atom {
        let span = forest.get(*arguments).span.clone();
        return Err(error(span, "the arguments are in parentheses"));
    }
    let (mut properties, mut rest) = (Vec::new(), rest);
    while let [key, value, more @ ..] = rest {
        if !forest.atom(*key).is_some_and(|key| key.starts_with(':')) {
            break;
        }
        properties.push((*key, *value));
        rest = more;
    }
    let [body] = rest else {
        return Err(error(
            span,
            "one expression follows the properties of a core",
        ));
    };
    let title = property(forest, &properties, ":name").and_then(|value| forest.atom(value));
    let symbol = symbol.and_then(|symbol| forest.atom(symbol));
    let given = symbol.or(title.map(|title| title.trim_matches('"')));
    let clean = word(given.unwrap_or("core"));
    Ok(Core {
        name: unlike(clean, taken),
        arguments: forest.elements(*arguments).to_vec(),
        properties,
        body: *body,
    })
}

/// The value of a property, the last one of its name.
fn property(forest: &Forest<'_>, properties: &[(u32, u32)], name: &str) -> Option<u32> {
    let mut found = properties.iter().rev();
    found
        .find(|(key, _)| forest.atom(*key) == Some(name))
        .map(|(_, value)| *value)
}

impl Core {
    pub(super) fn property(&self, forest: &Forest<'_>, name: &str) -> Option<u32> {
        property(forest, &self.properties, name)
    }

    /// The number format it is computed in, `None` for real numbers.
    pub(super) fn format(
        &self,
        forest: &Forest<'_>,
        problems: &mut CoreProblems,
    ) -> Option<Format> {
        if let Some(round) = self.property(forest, ":round") {
            rounds_to_nearest(forest, round, problems);
        }
        let Some(precision) = self.property(forest, ":precision") else {
            return Some(Format::BINARY64);
        };
        match forest.atom(precision).and_then(named_format) {
            Some(format) => format,
            None => {
                let diagnostic = error(
                    forest.get(precision).span.clone(),
                    "this precision is not known",
                );
                let help = "binary16, binary32, binary64 and real are".to_owned();
                problems.errors.push(diagnostic.with_notes(vec![help]));
                None
            }
        }
    }
}

/// The format of a name of FPCore; none for real numbers.
pub(super) fn named_format(name: &str) -> Option<Option<Format>> {
    Some(match name {
        "binary16" => "f16".parse().ok(),
        "binary32" => Some(Format::BINARY32),
        "binary64" => Some(Format::BINARY64),
        "real" => None,
        _ => return None,
    })
}

/// Refuses roundings other than that of the operations.
pub(super) fn rounds_to_nearest(forest: &Forest<'_>, round: u32, problems: &mut CoreProblems) {
    if forest.atom(round) != Some("nearestEven") {
        let span = forest.get(round).span.clone();
        problems.errors.push(error(
            span,
            "operations round to the nearest number, 'nearestEven'",
        ));
    }
}

/// A name as a word of letters, digits and `_`.
pub(super) fn word(name: &str) -> String {
    let fits = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let mut word: String = name.chars().map(fits).collect();
    if word.starts_with(|first: char| first.is_ascii_digit()) || word.is_empty() {
        word.insert(0, '_');
    }
    word
}

/// Names in use, each with the last number tried after it.
#[derive(Default, Debug)]
pub(super) struct TakenNames(BTreeMap<String, u64>);

/// The name, with a number appended when it is taken.
pub(super) fn unlike(name: String, taken: &mut TakenNames) -> String {
    let Some(&tried) = taken.0.get(&name) else {
        taken.0.insert(name.clone(), 1);
        return name;
    };
    let mut number = tried;
    let free = loop {
        number += 1;
        let free = format!("{name}_{number}");
        if !taken.0.contains_key(&free) {
            break free;
        }
    };
    taken.0.insert(name, number);
    taken.0.insert(free.clone(), 1);
    free
}
