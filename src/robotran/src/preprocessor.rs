//! The C preprocessor, as far as a file of equations needs one.
//!
//! Robotran's older files name the arrays of the structure by macros (`#define
//! q s->q`), and people switch parts of a file on and off. A macro whose body
//! is one name or one number is replaced exactly; any other may be defined but
//! not used in an equation, because its tokens would have to be read there.
//! Conditions on names that the file does not define, such as the macros of a
//! compiler, are refused where they would select the text that is read.

use super::literal::{self, Literal};
use hashbrown::HashMap;
use rustc_hash::FxBuildHasher;

/// Macros that compilers and the usual headers define, separated by blanks.
/// Names that begin with `_` are theirs too.
const STANDARD: &str = "linux unix i386 NULL NAN INFINITY HUGE_VAL M_PI M_PI_2 M_PI_4 M_E M_SQRT2 EOF BUFSIZ \
    RAND_MAX EXIT_SUCCESS EXIT_FAILURE stdin stdout stderr FP_NAN FP_INFINITE MATH_ERRNO \
    assert";

/// Macros that name macros are followed this far.
const LONGEST_CHAIN: usize = 16;

const CANNOT_TELL: (&str, &str) = (
    "this line of the preprocessor is not understood",
    "run the file through the preprocessor first (`cpp -P`), or remove the line",
);

#[derive(Clone, PartialEq, Debug)]
enum Macro {
    /// No text.
    Empty,
    /// Another word, or `s->q`.
    Reference(String),
    Number(Literal),
    /// Any other text.
    Other,
}

/// Meaning of a word of the text.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Expansion {
    /// No text.
    Nothing,
    /// A word, or a structure and its member.
    Words(Option<String>, String),
    Number(Literal),
}

#[derive(Clone, Copy, Debug)]
struct OpenConditional {
    /// Its text is compiled.
    live: bool,
    /// A part of it counted, or none may.
    taken: bool,
    /// Its `#else` has come.
    last: bool,
}

/// Message and note of a refusal.
pub(super) type PreprocessorRefusal = (&'static str, &'static str);

#[derive(Default, Debug)]
pub(super) struct Preprocessor {
    macros: HashMap<String, Macro, FxBuildHasher>,
    conditions: Vec<OpenConditional>,
    /// Number of conditions that are false.
    skipping: usize,
}

impl Preprocessor {
    /// True where the text does not count.
    pub(super) fn skips(&self) -> bool {
        self.skipping > 0
    }

    /// True inside an `#if`; forgets it.
    pub(super) fn end(&mut self) -> bool {
        self.skipping = 0;
        let open = !self.conditions.is_empty();
        self.conditions.clear();
        open
    }

    pub(super) fn is_empty(&self) -> bool {
        self.macros.is_empty()
    }

    pub(super) fn defines(&self, word: &str) -> bool {
        self.macros.contains_key(word)
    }

    /// Meaning of a word: `None` for itself.
    pub(super) fn expand(&self, word: &str) -> Result<Option<Expansion>, PreprocessorRefusal> {
        const OTHER: PreprocessorRefusal = (
            "a macro that is neither a name nor a number",
            "run the file through the preprocessor first (`cpp -P`), or write out the text of the macro",
        );
        let mut current = word;
        for _ in 0..LONGEST_CHAIN {
            let expansion = match self.macros.get(current) {
                None if current == word => return Ok(None),
                None => Expansion::Words(None, current.to_owned()),
                Some(Macro::Empty) => Expansion::Nothing,
                Some(Macro::Number(number)) => Expansion::Number(*number),
                Some(Macro::Other) => return Err(OTHER),
                Some(Macro::Reference(text)) => match text.split_once("->") {
                    // The name of the macro itself is not replaced again.
                    None if text == word => return Ok(None),
                    None => {
                        current = text;
                        continue;
                    }
                    Some((structure, member)) => {
                        let again = |part: &str| part != word && self.defines(part);
                        if again(structure) || again(member) {
                            return Err(OTHER);
                        }
                        Expansion::Words(Some(structure.to_owned()), member.to_owned())
                    }
                },
            };
            return Ok(Some(expansion));
        }
        Err(OTHER)
    }

    /// Obeys a line, without its `#`.
    pub(super) fn obey(&mut self, line: &str) -> Result<(), PreprocessorRefusal> {
        let line = without_comments(line);
        let line = line.trim();
        let (directive, rest) = split_word(line, |c| c.is_ascii_alphabetic());
        let rest = rest.trim();
        match directive {
            "if" | "ifdef" | "ifndef" => {
                let live = match directive {
                    _ if self.skips() => Ok(false),
                    "if" => self.holds(rest),
                    _ => self
                        .is_defined(rest)
                        .map(|known| known == (directive == "ifdef")),
                };
                // Behind an error its `#else` is still expected.
                self.open(!matches!(live, Ok(false)));
                live?;
            }
            "elif" => self.otherwise(Some(rest))?,
            "else" => self.otherwise(None)?,
            "endif" => {
                let Some(condition) = self.conditions.pop() else {
                    return Err(("`#endif` without `#if`", CANNOT_TELL.1));
                };
                self.skipping -= usize::from(!condition.live);
            }
            _ if self.skips() => {}
            "define" => self.define(rest)?,
            "undef" => {
                self.macros.remove(rest);
            }
            "pragma" if changes_numbers(rest) => {
                return Err((
                    "this line changes how the compiler computes",
                    "remove it: robovec rounds every operation",
                ));
            }
            "include" | "pragma" | "line" | "" => {}
            _ => return Err(CANNOT_TELL),
        }
        Ok(())
    }

    fn open(&mut self, live: bool) {
        // Within text that does not count, no part of a condition counts.
        let taken = live || self.skips();
        self.conditions.push(OpenConditional {
            live,
            taken,
            last: false,
        });
        self.skipping += usize::from(!live);
    }

    /// `#elif` with its condition, `#else` without one.
    fn otherwise(&mut self, condition: Option<&str>) -> Result<(), PreprocessorRefusal> {
        let Some(&open) = self.conditions.last() else {
            return Err(("`#else` without `#if`", CANNOT_TELL.1));
        };
        if open.last {
            return Err(("`#else` after another `#else`", CANNOT_TELL.1));
        }
        let live = match condition {
            _ if open.taken => false,
            None => true,
            Some(text) => self.holds(text)?,
        };
        self.skipping = self.skipping + usize::from(!live) - usize::from(!open.live);
        if let Some(open) = self.conditions.last_mut() {
            *open = OpenConditional {
                live,
                taken: open.taken || live,
                last: condition.is_none(),
            };
        }
        Ok(())
    }

    /// Tests whether a condition of one word, or one `defined`, holds.
    fn holds(&self, text: &str) -> Result<bool, PreprocessorRefusal> {
        let (text, expected) = match text.strip_prefix('!') {
            Some(text) => (text.trim_start(), false),
            None => (text, true),
        };
        let held = match text {
            "0" => false,
            "1" => true,
            _ => {
                let name = text.strip_prefix("defined").ok_or(CANNOT_TELL)?.trim();
                let inner = name
                    .strip_prefix('(')
                    .and_then(|name| name.strip_suffix(')'));
                self.is_defined(inner.unwrap_or(name).trim())?
            }
        };
        Ok(held == expected)
    }

    fn is_defined(&self, name: &str) -> Result<bool, PreprocessorRefusal> {
        if !is_word(name) {
            return Err(CANNOT_TELL);
        }
        if self.defines(name) {
            return Ok(true);
        }
        // The file is read as C.
        if name == "__cplusplus" {
            return Ok(false);
        }
        if name.starts_with('_') || STANDARD.split(' ').any(|word| word == name) {
            return Err((
                "what is read would depend on the compiler",
                "run the file through the preprocessor first (`cpp -P`), or remove the condition",
            ));
        }
        Ok(false)
    }

    fn define(&mut self, text: &str) -> Result<(), PreprocessorRefusal> {
        let (name, body) = split_word(text, |c| c.is_ascii_alphanumeric() || c == '_');
        if !is_word(name) {
            return Err(CANNOT_TELL);
        }
        // Behind the name of a macro with parameters stands its parenthesis.
        let body_words = body.trim();
        let found = if body.starts_with('(') {
            Macro::Other
        } else if body_words.is_empty() {
            Macro::Empty
        } else if is_reference(body_words) {
            Macro::Reference(body_words.to_owned())
        } else if body_words.contains(char::is_whitespace) {
            Macro::Other
        } else {
            match literal::c(body_words) {
                Ok(number) => Macro::Number(number),
                Err(_) => Macro::Other,
            }
        };
        self.macros.insert(name.to_owned(), found);
        Ok(())
    }
}

/// The longest beginning of such characters, and the rest.
fn split_word(text: &str, belongs: impl Fn(char) -> bool) -> (&str, &str) {
    let end = text.find(|c: char| !belongs(c));
    text.split_at(end.unwrap_or(text.len()))
}

/// The text after a mark, empty without it.
fn after<'t>(text: &'t str, mark: &str) -> &'t str {
    match text.split_once(mark) {
        Some((_, after)) => after,
        None => "",
    }
}

/// A line with its comments as blanks and its joined lines as one.
fn without_comments(line: &str) -> String {
    let mut clean = String::with_capacity(line.len());
    let mut rest = line;
    while let Some(at) = rest.find(['/', '\\', '"']) {
        clean.push_str(&rest[..at]);
        rest = &rest[at..];
        if rest.starts_with("//") {
            return clean;
        }
        if let Some(inside) = rest.strip_prefix("/*") {
            clean.push(' ');
            rest = after(inside, "*/");
            continue;
        }
        let length = match rest.as_bytes()[0] {
            b'"' => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
            b'\\'
                if rest[1..]
                    .trim_start_matches([' ', '\t', '\r'])
                    .starts_with('\n') =>
            {
                clean.push(' ');
                rest = after(rest, "\n");
                continue;
            }
            _ => 1,
        };
        clean.push_str(&rest[..length]);
        rest = &rest[length..];
    }
    clean + rest
}

/// Pragmas after which a compiler may round otherwise.
fn changes_numbers(pragma: &str) -> bool {
    let pragma = pragma.to_ascii_lowercase();
    [
        "optimize",
        "fp_contract",
        "fast",
        "fenv",
        "float",
        "push_macro",
        "pop_macro",
    ]
    .iter()
    .any(|word| pragma.contains(word))
}

fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// True for `s->q` and plain words.
fn is_reference(text: &str) -> bool {
    match text.split_once("->") {
        Some((structure, member)) => is_word(structure) && is_word(member),
        None => is_word(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(lines: &[&str]) -> Preprocessor {
        let mut preprocessor = Preprocessor::default();
        for line in lines {
            preprocessor.obey(line).expect("understood");
        }
        preprocessor
    }

    #[test]
    fn one_part_of_a_condition_counts() {
        assert!(after(&["if 0"]).skips());
        assert!(!after(&["if 0", "elif 1"]).skips());
        assert!(after(&["if 1", "elif 1"]).skips());
        assert!(after(&["if 0", "elif 1", "else"]).skips());
        assert!(after(&["if 0", "if 1", "else"]).skips());
        assert!(!after(&["if 0", "if 1", "endif", "else"]).skips());
        assert!(!after(&["define A", "if defined(A)"]).skips());
        assert!(after(&["define A /* x */", "undef A", "ifdef A"]).skips());
        for line in ["if 1 && 0", "ifdef __GNUC__", "elif 1", "if A", "ifdef"] {
            assert!(Preprocessor::default().obey(line).is_err(), "{line}");
        }
    }

    #[test]
    fn macros_are_replaced_or_refused() {
        let preprocessor = after(&[
            "define q s->q",
            "define p q",
            "define TWO 2.0 // two",
            "define f(x) x",
            "define g (1)",
            "define a b",
            "define b a",
            "define nothing",
        ]);
        let member = Some(Expansion::Words(Some("s".to_owned()), "q".to_owned()));
        assert_eq!(preprocessor.expand("q"), Ok(member.clone()));
        assert_eq!(preprocessor.expand("other"), Ok(None));
        assert_eq!(preprocessor.expand("nothing"), Ok(Some(Expansion::Nothing)));
        let two = Expansion::Number(Literal::Double(2.0));
        assert_eq!(preprocessor.expand("TWO"), Ok(Some(two)));
        assert_eq!(preprocessor.expand("a"), Ok(None));
        assert!(preprocessor.expand("f").is_err());
        assert!(preprocessor.expand("g").is_err());
    }
}
