//! The rules that ship with robovec.

use super::RuleSet;

/// The rule files that ship: name and text.
pub const BUILT_IN: &[(&str, &str)] = &[
    ("signs", include_str!("../rules/signs.rules")),
    (
        "commutativity",
        include_str!("../rules/commutativity.rules"),
    ),
    ("distribution", include_str!("../rules/distribution.rules")),
    ("factoring", include_str!("../rules/factoring.rules")),
    ("sums", include_str!("../rules/sums.rules")),
    ("division", include_str!("../rules/division.rules")),
    ("trigonometry", include_str!("../rules/trigonometry.rules")),
    (
        "associativity",
        include_str!("../rules/associativity.rules"),
    ),
];

/// The files of [`RuleSet::built_in`]: all but associativity, which makes
/// graphs grow exponentially and which trees by arrival time do exactly.
pub const DEFAULT: &[&str] = &[
    "signs",
    "commutativity",
    "distribution",
    "factoring",
    "sums",
    "division",
    "trigonometry",
];

impl RuleSet {
    /// The rules used when no other are named: those of [`DEFAULT`].
    pub fn built_in() -> RuleSet {
        let mut all = RuleSet::default();
        for name in DEFAULT {
            let set = RuleSet::named(name).expect("a default file ships");
            all.extend(set).expect("names are unique, as a test checks");
        }
        all
    }

    /// The rules of a file that ships.
    pub fn named(name: &str) -> Option<RuleSet> {
        let (_, text) = BUILT_IN.iter().find(|(known, _)| *known == name)?;
        let set = RuleSet::parse(text, &format!("{name}.rules"));
        Some(set.expect("files that ship are well formed, as a test checks"))
    }
}
