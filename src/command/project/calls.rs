//! Plain calls of a project about its joints.
//!
//! A project of MBsysC gives the number of its constraints and its driven
//! joints by calls in its main program. They are read where arguments are
//! numbers or names of joints; nothing is run.

use robovec_io::files::limited;
use robovec_model::{Model, Nature};
use std::collections::BTreeMap;
use std::path::PathBuf;

#[derive(Default)]
pub(super) struct ProjectCalls {
    /// Number of its constraints; `None` where no call gives it.
    pub(super) constraints: Option<usize>,
    /// Joints as the calls name them, with the roles that they give.
    pub(super) roles: Vec<(Nature, String)>,
    /// Numbers that the project defines for names.
    ids: BTreeMap<String, usize>,
}

/// Endings of sources in C, C++ and Matlab.
const SOURCES: [&str; 7] = ["c", "cc", "cpp", "cxx", "h", "hpp", "m"];

/// The functions of MBsysC and MBsysLab that give joints their roles.
const ROLES: [(&str, Nature); 3] = [
    ("mbs_set_qu", Nature::Independent),
    ("mbs_set_qv", Nature::Dependent),
    ("mbs_set_qdriven", Nature::Driven),
];

pub(super) fn read<'p>(files: impl Iterator<Item = &'p PathBuf>) -> ProjectCalls {
    let mut calls = ProjectCalls::default();
    for file in files {
        let end = file.extension().and_then(|end| end.to_str()).unwrap_or("");
        if !SOURCES.contains(&end) {
            continue;
        }
        // A source that cannot be read gives no calls.
        let Ok(bytes) = limited::read(file, &limited::EQUATIONS) else {
            continue;
        };
        let text = String::from_utf8_lossy(&bytes);
        calls.add(&if end == "m" {
            without_percent(&text)
        } else {
            without_comments(&text)
        });
    }
    calls
}

impl ProjectCalls {
    fn add(&mut self, text: &str) {
        for arguments in calls_of(text, "mbs_set_nb_userc") {
            if let Some(Ok(count)) = arguments.get(1).map(|count| count.parse()) {
                self.constraints = Some(count);
            }
        }
        for (function, nature) in ROLES {
            for arguments in calls_of(text, function) {
                // The declaration of a function has a type there.
                let joints = arguments.iter().skip(1).filter(|joint| is_word(joint));
                self.roles
                    .extend(joints.map(|joint| (nature, joint.clone())));
            }
        }
        for line in text.lines() {
            let mut words = line.split_whitespace();
            if let (Some("#define"), Some(name), Some(Ok(number))) =
                (words.next(), words.next(), words.next().map(str::parse))
            {
                self.ids.insert(name.to_owned(), number);
            }
        }
    }
}

/// The place of a joint in a call: given by its number, by a name that the
/// project defines as one, or by its name followed by `_id`.
pub(super) fn joint(model: &Model, named: &str, calls: &ProjectCalls) -> Option<usize> {
    let number = named.parse().ok().or(calls.ids.get(named).copied());
    if let Some(number) = number {
        return (1..=model.joints.len())
            .contains(&number)
            .then(|| number - 1);
    }
    let name = named.strip_suffix("_id").unwrap_or(named);
    model.joints.iter().position(|joint| joint.name == name)
}

fn is_word(text: &str) -> bool {
    !text.is_empty()
        && text
            .chars()
            .all(|letter| letter.is_alphanumeric() || letter == '_')
}

/// The arguments of every call of a function; a list of Matlab is several.
fn calls_of(text: &str, function: &str) -> Vec<Vec<String>> {
    let found = text.match_indices(function).filter_map(|(place, _)| {
        let rest = text[place + function.len()..].trim_start();
        let inside = rest.strip_prefix('(')?;
        let inside = &inside[..inside.find(')')?];
        let arguments = inside.split(',').flat_map(|argument| {
            let list = argument.trim().strip_prefix('[');
            let list = list.map(|list| list.trim_end_matches(']').split_whitespace());
            match list {
                Some(list) => list.map(str::to_owned).collect(),
                None => vec![argument.trim().trim_end_matches(']').to_owned()],
            }
        });
        Some(arguments.collect())
    });
    found.collect()
}

/// A text of Matlab without its comments.
fn without_percent(text: &str) -> String {
    let lines = text
        .lines()
        .map(|line| line.split('%').next().unwrap_or(""));
    lines.collect::<Vec<_>>().join("\n")
}

fn without_comments(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(place) = rest.find('/') {
        let (before, comment) = rest.split_at(place);
        plain.push_str(before);
        rest = if comment.starts_with("//") {
            comment.find('\n').map_or("", |end| &comment[end..])
        } else if comment.starts_with("/*") {
            comment.find("*/").map_or("", |end| &comment[end + 2..])
        } else {
            plain.push('/');
            &comment[1..]
        };
    }
    plain + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_calls_are_read() {
        let mut calls = ProjectCalls::default();
        calls.add(&without_comments(
            "/* mbs_set_nb_userc(data, 9); */\n#define R1_a_id 3\nmbs_set_nb_userc(mbs_data, 4 );\n\
             // mbs_set_qdriven(mbs_data, 8);\nmbs_set_qdriven (mbs_data, R1_a_id);\n\
             void mbs_set_qdriven(MbsData *mbs_data, int qdriven);\nx = a / b;",
        ));
        assert_eq!(calls.constraints, Some(4));
        assert_eq!(calls.roles, [(Nature::Driven, "R1_a_id".to_owned())]);
        assert_eq!(calls.ids["R1_a_id"], 3);
        let mut calls = ProjectCalls::default();
        calls.add(&without_percent(
            "s = mbs_set_qu(s,[1 2]); % mbs_set_qv(s,[9])",
        ));
        let joints: Vec<&str> = calls.roles.iter().map(|(_, joint)| &**joint).collect();
        assert_eq!(joints, ["1", "2"]);
    }
}
