//! The frame around the statements: comments, headers, parameters.

use super::names::is_word_letter;
use robovec_ir::Function;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Keeps compilers from putting parts together again.
pub(crate) const APART: &str = "#if defined(__GNUC__)\n\
    #define ROBOVEC_APART __attribute__((noinline))\n\
    #else\n#define ROBOVEC_APART\n#endif\n";

/// A text of others within a comment, which cannot hold its own end.
pub(crate) fn quoted(text: &str) -> String {
    text.replace("*/", "* /")
}

/// Lines of a comment that say what the caller must do about calls of the
/// user's functions.
pub(crate) fn boundaries(function: &Function) -> String {
    let mut text = String::new();
    for boundary in &function.boundaries {
        let result = boundary.result.as_deref().unwrap_or("nothing");
        let _ = writeln!(
            text,
            "   The results of {} are taken from the input {}; its arguments are outputs.",
            quoted(&boundary.callee),
            quoted(result)
        );
    }
    text
}

/// A list of parameters: C says `void` where there are none.
pub(crate) fn parameters<T: AsRef<str>>(list: impl IntoIterator<Item = T>) -> String {
    let mut text = String::new();
    for parameter in list {
        if !text.is_empty() {
            text.push_str(", ");
        }
        text.push_str(parameter.as_ref());
    }
    match text.is_empty() {
        true => "void".to_owned(),
        false => text,
    }
}

/// A header that declares one function.
pub(crate) fn header(comment: &str, file: &str, data: Option<&str>, declared: &str) -> String {
    let guard = file.to_ascii_uppercase().replace('-', "_");
    let data = data.map_or(String::new(), |name| format!("#include \"{name}\"\n\n"));
    format!(
        "{comment}#ifndef ROBOVEC_{guard}_H\n#define ROBOVEC_{guard}_H\n\n{data}{declared};\n\n#endif\n"
    )
}

/// Lines that mark the parameters that a body leaves alone as used, for strict
/// compilers.
pub(crate) fn unused<'a>(names: impl IntoIterator<Item = &'a str>, bodies: &[&str]) -> String {
    let words = bodies
        .iter()
        .flat_map(|body| body.split(|letter| !is_word_letter(letter)));
    let words: BTreeSet<&str> = words.collect();
    let names = names.into_iter().filter(|name| !words.contains(name));
    names.map(|name| format!("    (void){name};\n")).collect()
}
