//! The reason why a project was not built or did not run, in one sentence.

use robovec_ir::diagnostic::clip;

/// A text that tools print, and the sentence for it.
type KnownText = (&'static str, &'static str);

/// Texts about the library of Robotran.
const ROBOTRAN: [KnownText; 7] = [
    ("ROBOTRAN_SOURCE_DIR-NOTFOUND", "MBsysC is not installed"),
    ("mbsysc package is not found", "MBsysC is not installed"),
    ("mbs_data.h: No such file", "MBsysC is not installed"),
    ("MBSdataStruct.h: No such file", "MBsysC is not installed"),
    ("MBsysPy not found", "MBsysPy is not installed"),
    ("No module named 'MBsysPy'", "MBsysPy is not installed"),
    ("'mbs_load' undefined", "MBsysLab is not installed"),
];

/// Texts after which the name of a missing part follows.
const PARTS: [(&str, &str); 9] = [
    (
        "Unknown CMake command ",
        "the MBsysC found has no CMake function",
    ),
    ("Could NOT find ", "a library is missing:"),
    ("configuration file provided by ", "a library is missing:"),
    ("Could not find ", "a part is missing:"),
    ("No module named ", "a module of Python is missing:"),
    ("fatal error: ", "a header is missing:"),
    (
        "has no member named ",
        "the MBsysC found, or a header, has no member",
    ),
    ("cannot find -l", "a library is missing:"),
    ("correctly in the CMake files:", "a library is missing:"),
];

/// The reason in the messages of a tool, if it is a known one.
pub(super) fn reason(messages: &str) -> Option<String> {
    let known = ROBOTRAN.iter().find(|(text, _)| messages.contains(text));
    if let Some((_, sentence)) = known {
        return Some(format!("{sentence}: --library names its folder"));
    }
    for line in messages.lines() {
        if let Some((before, _)) = line.split_once(": command not found") {
            let tool = before.rsplit(": ").next().unwrap_or(before);
            return Some(format!("'{tool}' is not installed"));
        }
    }
    let part = |(text, sentence): &(&str, &str)| {
        let (_, after) = messages.split_once(text)?;
        let name = after.split_whitespace().next()?;
        let name = name.trim_matches(|letter: char| "\"'‘’:;,.()".contains(letter));
        Some(format!("{sentence} {name}"))
    };
    let error = |line: &&str| line.contains("rror: ") || line.contains("undefined reference");
    let first = || messages.lines().find(error);
    PARTS
        .iter()
        .find_map(part)
        .or_else(|| Some(clip(first()?.trim()).into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named() {
        let cases = [
            (
                "bash: line 1: cmake: command not found",
                "'cmake' is not installed",
            ),
            (
                "CMake Error at CMakeLists.txt:100:\n  Unknown CMake command \"add_void\".",
                "the MBsysC found has no CMake function add_void",
            ),
            (
                "MBsysC path: ROBOTRAN_SOURCE_DIR-NOTFOUND",
                "MBsysC is not installed: --library names its folder",
            ),
            (
                "main.c:1:10: fatal error: a/b.h: No such file",
                "a header is missing: a/b.h",
            ),
            (
                "  Could NOT find LibXml2 (missing: A)",
                "a library is missing: LibXml2",
            ),
            (
                "ModuleNotFoundError: No module named 'numpy'",
                "a module of Python is missing: numpy",
            ),
            (
                "‘MbsData’ has no member named ‘x’",
                "the MBsysC found, or a header, has no member x",
            ),
        ];
        for (messages, sentence) in cases {
            assert_eq!(reason(messages).as_deref(), Some(sentence));
        }
        assert_eq!(reason("Segmentation fault"), None);
    }
}
