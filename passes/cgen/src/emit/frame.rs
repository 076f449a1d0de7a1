//! The frame around the statements: comments, headers, parameters.

use super::names::is_word_letter;
use robovec_ir::Function;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Keeps compilers from putting parts together again.
pub(crate) const APART: &str = "#if defined(__GNUC__)\n\
    #define ROBOVEC_APART __attribute__((noinline))\n\
    #else\n#define ROBOVEC_APART\n#endif\n";

/// Lets compilers make a function several times, for processors with wider
/// registers and fused multiply-adds as well, of which the one that suits is
/// taken when the program is loaded (GCC manual, function attribute
/// `target_clones`): a build for any processor is then nearly as fast as one
/// for this one. A build for processors that have them needs no clones, and
/// `-DROBOVEC_CLONES=` does without. Follows a header of the library,
/// which shows whether it can choose.
pub(crate) const CLONES: &str = "#if !defined(ROBOVEC_CLONES)\n\
    #if defined(__GNUC__) && __GNUC__ >= 12 && !defined(__clang__) && !defined(__INTEL_COMPILER) \\\n    \
    && defined(__x86_64__) && defined(__GLIBC__) && !defined(__AVX2__)\n\
    #define ROBOVEC_CLONES __attribute__((target_clones(\"arch=x86-64-v3\", \"default\")))\n\
    #define ROBOVEC_CLONED\n\
    #else\n#define ROBOVEC_CLONES\n#endif\n#endif\n";

/// A text of others within a comment, which cannot hold its own end.
pub(crate) fn quoted(text: &str) -> String {
    text.replace("*/", "* /")
}

/// Lines of a comment with the calls of the user's functions that the caller
/// must make.
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

/// The parameters of a function: declaration and name of each.
#[derive(Clone, Default)]
pub(crate) struct ParameterList {
    list: Vec<(String, String)>,
}

impl ParameterList {
    /// Appends a parameter by the text of its type, spaces included, and its
    /// name.
    pub(crate) fn add(&mut self, kind: &str, name: &str) {
        self.push(format!("{kind}{name}"), name);
    }

    /// Appends a parameter whose declaration is a text with its name.
    pub(crate) fn push(&mut self, declaration: String, name: &str) {
        self.list.push((declaration, name.to_owned()));
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.list.iter().map(|(_, name)| name.as_str())
    }

    /// The declarations; C writes `void` where there are none.
    pub(crate) fn declared(&self) -> String {
        let declarations: Vec<&str> = self.list.iter().map(|(text, _)| text.as_str()).collect();
        if declarations.is_empty() {
            "void".to_owned()
        } else {
            declarations.join(", ")
        }
    }

    /// The names as arguments of a call.
    pub(crate) fn arguments(&self) -> String {
        self.names().collect::<Vec<&str>>().join(", ")
    }

    /// The definition of a function with these parameters; those that its body
    /// leaves alone are marked as used.
    pub(crate) fn definition(&self, head: &str, body: &str) -> String {
        let unused = unused(self.names(), body);
        format!("{head}({})\n{{\n{unused}{body}}}\n", self.declared())
    }
}

/// A header that declares one function.
pub(crate) fn header(comment: &str, file: &str, data: Option<&str>, declared: &str) -> String {
    let data = data.map_or(String::new(), |name| format!("#include \"{name}\"\n\n"));
    guarded(comment, file, &format!("{data}{declared};\n"))
}

/// A header of C and C++ that declares one function. `constants` come before;
/// C++ has no `restrict`, which declarations do not need.
pub(crate) fn header_for_both(
    comment: &str,
    file: &str,
    constants: &str,
    declared: &str,
) -> String {
    let declared = declared.replace("*restrict ", "*");
    let body = format!("{constants}#ifdef __cplusplus\nextern \"C\"\n#endif\n{declared};\n");
    guarded(comment, file, &body)
}

fn guarded(comment: &str, file: &str, body: &str) -> String {
    let guard = file.to_ascii_uppercase().replace('-', "_");
    format!("{comment}#ifndef ROBOVEC_{guard}_H\n#define ROBOVEC_{guard}_H\n\n{body}\n#endif\n")
}

/// Lines that mark the parameters that a body leaves alone as used, for strict
/// compilers.
pub(crate) fn unused<'a>(names: impl IntoIterator<Item = &'a str>, body: &str) -> String {
    let words: BTreeSet<&str> = body.split(|letter| !is_word_letter(letter)).collect();
    let names = names.into_iter().filter(|name| !words.contains(name));
    names.map(|name| format!("    (void){name};\n")).collect()
}
