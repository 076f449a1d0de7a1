//! Identifiers that all three languages, and Robotran's conventions, accept.
//!
//! Every name is made valid in all languages, so that the same function has the
//! same names in each of them. Robotran's are unchanged; one made by a pass
//! (`OM16.1`) becomes `OM16_1`. A taken name gets a number appended.

use super::arrays::{ArrayRole, FileArrays};
use super::plan::WrittenStatement;
use hashbrown::{HashMap, HashSet};
use robovec_ir::{Function, Input, Name, Shape, Symbol, Symbols};
use rustc_hash::FxBuildHasher;

/// Words that the languages, the reader or Robotran keep, blanks between.
const KEYWORDS: [&str; 4] = [
    // C, and macros of its mathematics header.
    "auto break case char const continue default do double else enum extern float for goto if \
     inline int long register restrict return short signed sizeof static struct switch \
     typedef union unsigned void volatile while asm typeof bool main NULL INFINITY NAN \
     HUGE_VAL OVERFLOW UNDERFLOW DOMAIN SING PLOSS TLOSS errno PI",
    // Matlab.
    "catch classdef elseif end endfunction endif endswitch endwhile function global otherwise \
     parfor persistent spmd try zeros ones",
    // Python.
    "False None True and as assert async await class def del elif except finally from import \
     in is lambda nonlocal not or pass raise with yield np numpy math print",
    // Functions and structures.
    "sin cos sqrt s tsim isens sens usrfun phi mbs mbs_data MbsData MbsSensor MBSdataStruct \
     MBSsensorStruct flag_stop",
];

/// Arrays of Robotran's: a bare name among these means the whole array.
const ARRAYS: [&str; 22] = [
    "q", "qd", "qdd", "Qq", "Qa", "c", "m", "l", "frc", "trq", "In", "M", "Jac", "dpt", "g", "h",
    "Jdqd", "lrod", "Z", "Zd", "Flink", "Flnk",
];

fn keywords() -> impl Iterator<Item = &'static str> {
    KEYWORDS.iter().flat_map(|words| words.split(' '))
}

/// True for a letter that letters, digits and underscores may follow.
pub(super) fn is_word(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}

/// True for a name an array can have in every language.
pub(super) fn is_array_name(text: &str) -> bool {
    is_word(text) && !keywords().any(|word| word == text)
}

#[derive(Debug)]
pub(super) struct FileIdentifiers {
    /// Per symbol: true when a value has it as its identifier.
    plain: Vec<bool>,
    /// Identifiers that are no symbol some value has unchanged.
    made: HashMap<Name, Box<str>, FxBuildHasher>,
    /// Taken by the languages, by arrays, parameters and made identifiers.
    taken: HashSet<Box<str>, FxBuildHasher>,
    /// For identifiers requested again the number that was tried last.
    numbers: HashMap<Box<str>, u32, FxBuildHasher>,
}

impl FileIdentifiers {
    pub(super) fn new() -> FileIdentifiers {
        FileIdentifiers {
            plain: Vec::new(),
            made: HashMap::default(),
            taken: keywords().chain(ARRAYS).map(Box::from).collect(),
            numbers: HashMap::default(),
        }
    }

    /// Keeps a word from being given to any value.
    pub(super) fn reserve(&mut self, text: &str) {
        if !self.taken.contains(text) {
            self.taken.insert(text.into());
        }
    }

    /// Gives values the names they have, where those are possible. All names
    /// of a file come through here before any comes through
    /// [`FileIdentifiers::derive`], so that no derived name takes one of Robotran's.
    pub(super) fn keep(&mut self, names: impl Iterator<Item = Name>, symbols: &Symbols) {
        assert!(self.made.is_empty(), "names are kept before any is derived");
        for name in names.filter(|name| !name.is_none() && name.suffix == 0) {
            let index = name.base.index();
            if index >= self.plain.len() {
                self.plain.resize(symbols.len().max(index + 1), false);
            }
            if self.plain[index] {
                continue;
            }
            let text = symbols.text(name.base);
            self.plain[index] = is_word(text) && !self.taken.contains(text);
        }
    }

    /// Makes identifiers for the names that [`FileIdentifiers::keep`] could not keep.
    pub(super) fn derive(&mut self, names: impl Iterator<Item = Name>, symbols: &Symbols) {
        for name in names.filter(|name| !name.is_none()) {
            if !self.is_plain(name) && !self.made.contains_key(&name) {
                let made = self.fresh(symbols.text(name.base), name.suffix, symbols);
                self.made.insert(name, made);
            }
        }
    }

    /// A new identifier like a wanted one.
    pub(super) fn fresh(&mut self, wanted: &str, suffix: u32, symbols: &Symbols) -> Box<str> {
        let mut text: String = wanted
            .chars()
            .map(|character| match character {
                'a'..='z' | 'A'..='Z' | '0'..='9' | '_' => character,
                _ => '_',
            })
            .collect();
        if !text.starts_with(|first: char| first.is_ascii_alphabetic()) {
            text.insert(0, 'v');
        }
        if suffix > 0 {
            push_number(&mut text, suffix);
        }
        if self.is_taken(&text, symbols) {
            let length = text.len();
            let wanted: Box<str> = text.as_str().into();
            let mut number = self.numbers.get(&wanted).copied().unwrap_or(0);
            while self.is_taken(&text, symbols) {
                number += 1;
                text.truncate(length);
                push_number(&mut text, number);
            }
            self.numbers.insert(wanted, number);
        }
        debug_assert!(is_word(&text), "an identifier is a word");
        self.taken.insert(text.as_str().into());
        text.into()
    }

    fn is_taken(&self, text: &str, symbols: &Symbols) -> bool {
        self.taken.contains(text)
            || symbols
                .find(text)
                .is_some_and(|symbol| self.is_plain(Name::plain(symbol)))
    }

    fn is_plain(&self, name: Name) -> bool {
        name.suffix == 0 && self.plain.get(name.base.index()) == Some(&true)
    }

    pub(super) fn text<'a>(&'a self, name: Name, symbols: &'a Symbols) -> &'a str {
        if self.is_plain(name) {
            return symbols.text(name.base);
        }
        let made = self.made.get(&name);
        made.expect("every name of the file came through `keep` and `derive`")
    }
}

fn push_number(text: &mut String, number: u32) {
    text.push('_');
    text.push_str(&number.to_string());
}

/// Gives every value of the file its identifier.
pub(super) fn identifiers(
    functions: &[&Function],
    symbols: &Symbols,
    arrays: &FileArrays,
) -> FileIdentifiers {
    let mut names = FileIdentifiers::new();
    let own = own_arguments(functions[0]);
    for array in &arrays.all {
        let scalar = array.shape == Shape::Scalar && array.role == ArrayRole::Argument;
        let own = symbols
            .find(&array.name)
            .is_some_and(|name| own.contains(&name));
        if !(scalar && own) {
            names.reserve(&array.name);
        }
    }
    for function in functions {
        for call in &function.boundaries {
            let words = call.arguments.iter().chain(&call.result);
            for word in words.filter(|word| is_word(word) && arrays.find(word).is_none()) {
                names.reserve(word);
            }
        }
    }
    for function in functions {
        names.keep(function.nodes().iter().map(|node| node.name), symbols);
    }
    for function in functions {
        names.derive(function.nodes().iter().map(|node| node.name), symbols);
    }
    names
}

/// The numbers handed to user functions whose temporaries have their names.
fn own_arguments(function: &Function) -> HashSet<Symbol, FxBuildHasher> {
    let own = function.assignments.iter().filter_map(|assignment| {
        let (array, _, rank) = function.output_element(assignment.output);
        let name = function.node(assignment.operand.value()?).name;
        (rank == 0 && name == Name::plain(array.name)).then_some(array.name)
    });
    own.collect()
}

/// A temporary for every input element that must be kept.
pub(super) fn kept(
    function: &Function,
    plan: &[WrittenStatement],
    names: &mut FileIdentifiers,
    symbols: &Symbols,
) -> HashMap<Input, Box<str>, FxBuildHasher> {
    let mut kept = HashMap::default();
    for statement in plan {
        if let WrittenStatement::Keep(input) = *statement {
            let (array, indices, rank) = function.input_element(input);
            let mut wanted = symbols.text(array.name).to_owned();
            for index in &indices[..rank] {
                wanted.push_str(&format!("_{index}"));
            }
            kept.insert(input, names.fresh(&wanted, 0, symbols));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_are_valid_and_each_for_one_name() {
        let mut symbols = Symbols::default();
        let texts = ["x.1", "x_1", "x", "lambda", "q", "a b", "1st", "é", "x.2"];
        let given: Vec<Name> = texts
            .iter()
            .map(|text| {
                let (base, suffix) = Name::split(text);
                let base = symbols.intern(base);
                Name { base, suffix }
            })
            .collect();
        let mut names = FileIdentifiers::new();
        names.reserve("x_2");
        names.keep(given.iter().copied(), &symbols);
        names.derive(given.iter().copied(), &symbols);
        let found: Vec<&str> = given
            .iter()
            .map(|&name| names.text(name, &symbols))
            .collect();
        let expected = [
            "x_1_1", "x_1", "x", "lambda_1", "q_1", "a_b", "v1st", "v_", "x_2_1",
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn many_names_that_look_alike_take_linear_time() {
        let mut symbols = Symbols::default();
        let mut names = FileIdentifiers::new();
        for number in 0..100_000u32 {
            let symbol = symbols.intern(&format!(
                "\u{e9}{}",
                char::from_u32(0x4e00 + number % 20_000).unwrap_or('x')
            ));
            let name = Name {
                base: symbol,
                suffix: number / 20_000,
            };
            names.derive(std::iter::once(name), &symbols);
        }
        assert!(names.made.values().any(|name| name.len() > 6));
    }
}
