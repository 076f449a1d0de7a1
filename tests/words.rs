//! Plain English: the words of the glossary's table "Words not used" are
//! neither in documents nor in messages, help and doc comments.

use crate::packages::{crates, sources};
use crate::support::files::tree;
use proc_macro2::{TokenStream, TokenTree};
use std::fs;
use std::path::Path;

/// The line before the table.
const HEAD: &str = "## Words not used\n";

/// Text in small letters, one space between words and around marks; without
/// code and identifiers.
fn plain(text: &str) -> String {
    let mut plain = " ".to_owned();
    for (index, prose) in text.split('`').enumerate() {
        let prose = if index % 2 == 0 { prose } else { "." };
        for character in prose.chars().flat_map(char::to_lowercase) {
            if character.is_alphanumeric() || "_-'".contains(character) {
                plain.push(character);
            } else if character.is_whitespace() {
                plain.push(' ');
            } else {
                plain.extend([' ', character, ' ']);
            }
        }
    }
    plain.push(' ');
    let words: Vec<&str> = plain.split(' ').filter(|word| !word.is_empty()).collect();
    format!(" {} ", words.join(" "))
}

/// The forms of all words of the table.
fn words(glossary: &str) -> Vec<String> {
    let (_, table) = glossary.split_once(HEAD).expect("a table of words");
    let rows = table.lines().filter(|line| line.starts_with("| "));
    let forms = rows.skip(1).filter_map(|row| row.split('|').nth(1));
    let forms = forms.flat_map(|forms| forms.split(','));
    forms.map(plain).collect()
}

/// The places of words in a text, as lines of a message.
fn found(words: &[String], place: &Path, text: &str, all: &mut Vec<String>) {
    let text = plain(text);
    for word in words {
        for (start, _) in text.match_indices(word.as_str()) {
            let before: String = text[..start].chars().rev().take(40).collect();
            let before: String = before.chars().rev().collect();
            all.push(format!("{}: ...{before}{word}", place.display()));
        }
    }
}

#[test]
fn documents_use_plain_words() {
    let glossary = fs::read_to_string(tree("docs/glossary.md")).expect("a glossary");
    let words = words(&glossary);
    assert!(words.len() > 15, "{words:?}");
    let mut all = Vec::new();
    for folder in ["", "docs"] {
        for entry in fs::read_dir(tree(folder)).expect("a folder") {
            let path = entry.expect("a readable folder").path();
            if path.extension().is_some_and(|extension| extension == "md") {
                let text = fs::read_to_string(&path).expect("a document");
                let text = text.split(HEAD).next().expect("a first part");
                // A block of code is no prose.
                for (index, prose) in text.split("\n```").enumerate() {
                    if index % 2 == 0 {
                        found(&words, &path, prose, &mut all);
                    }
                }
            }
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

/// Strings that are no identifiers, and doc comments, each whole.
#[derive(Default)]
struct RustProse {
    strings: Vec<String>,
    comments: Vec<String>,
}

impl RustProse {
    fn read(&mut self, tokens: TokenStream) {
        let mut is_comment = false;
        for token in tokens {
            match token {
                TokenTree::Group(group) => {
                    let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                    if let [TokenTree::Ident(name), _, TokenTree::Literal(text)] = &inner[..]
                        && name == "doc"
                    {
                        let line = text.to_string();
                        match self.comments.last_mut() {
                            Some(last) if is_comment => *last += &line.replace('"', " "),
                            _ => self.comments.push(line.replace('"', " ")),
                        }
                        is_comment = true;
                    } else {
                        self.read(group.stream());
                        is_comment = false;
                    }
                }
                TokenTree::Literal(literal) => {
                    let text = literal.to_string().replace("\\n", ";").replace('\\', "");
                    if text.contains('"') && text.contains(' ') {
                        self.strings.push(text);
                    }
                }
                TokenTree::Punct(mark) if "#!".contains(mark.as_char()) => {}
                _ => is_comment = false,
            }
        }
    }
}

#[test]
fn strings_and_comments_use_plain_words() {
    let glossary = fs::read_to_string(tree("docs/glossary.md")).expect("a glossary");
    let words = words(&glossary);
    let mut all = Vec::new();
    for path in crates().iter().flat_map(|path| sources(&path.join("src"))) {
        let text = fs::read_to_string(&path).expect("a readable source");
        let mut prose = RustProse::default();
        prose.read(text.parse().expect("Rust"));
        for string in &prose.strings {
            // The name of a variable in a format is no word.
            let string = string.replace('{', " _").replace('}', "_ ");
            found(&words, &path, &string, &mut all);
        }
        for comment in &prose.comments {
            found(&words, &path, comment, &mut all);
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}
