//! Comments at the head and foot of a file.

use super::Language;
use super::conventions::JOINTS;
use robovec_num::limits::NumberLimit;
use std::ops::Range;

/// Maximum number of lines of a header.
const HEADER_LINES: usize = 120;

/// Rows and columns that a header may state.
pub(super) const EXTENT: NumberLimit = NumberLimit::whole(
    0,
    super::tokens::LARGEST_INDEX as u64,
    "no multibody model has arrays like this",
);

#[derive(Clone, Default, Debug)]
pub(super) struct Header {
    pub(super) model: Option<String>,
    pub(super) generator: Option<String>,
    /// `F1` and its like.
    pub(super) function: Option<String>,
    pub(super) joints: Option<u32>,
    pub(super) flops: Option<String>,
    pub(super) date: Option<String>,
    pub(super) all_parameter_symbols: bool,
    /// The project's data structure has its name of before 2015.
    pub(super) old_structure: bool,
    /// Arrays whose extent is not evident from use: rows, and columns or 0.
    pub(super) extents: Vec<(String, u32, u32)>,
    /// Sizes that no file can have: their places, and the reasons.
    pub(super) refused: Vec<(Range<usize>, String)>,
}

impl Header {
    pub(super) fn read(text: &str) -> Header {
        let mut header = Header {
            old_structure: memchr::memmem::find(text.as_bytes(), b"MBSdataStruct").is_some(),
            ..Header::default()
        };
        for line in text.lines().take(HEADER_LINES) {
            let line = line
                .trim_start_matches([' ', '\t', '%', '#', '/', '*'])
                .trim();
            if let Some(fact) = line.strip_prefix("==>") {
                header.fact(fact.trim(), text);
            } else if let Some(rest) = line.strip_prefix("ROBOTRAN - Version ") {
                header.generator = first_word(rest).map(|version| format!("ROBOTRAN {version}"));
            } else if let Some(rest) = line.strip_prefix("MBsysTran - Release ") {
                header.generator = first_word(rest).map(|version| format!("MBsysTran {version}"));
            } else if let Some(rest) = line.strip_prefix("robovec - Version ") {
                header.generator = first_word(rest).map(|version| format!("robovec {version}"));
            } else if let Some(rest) = line.strip_prefix("Project:") {
                header.model.get_or_insert_with(|| rest.trim().to_owned());
            } else if let Some(rest) = line.strip_prefix("Generation date:") {
                header.date.get_or_insert_with(|| rest.trim().to_owned());
            }
        }
        header
    }

    /// A size of a comment, or `None` when no number is there. One that
    /// is not allowed is remembered, with its place in the text.
    fn size(&mut self, written: &str, what: &str, limit: NumberLimit, text: &str) -> Option<u32> {
        // Both are pieces of one text.
        let start = written.as_ptr() as usize - text.as_ptr() as usize;
        written.parse::<f64>().ok()?;
        match limit.read_whole(written) {
            Ok(number) => Some(number as u32),
            Err(reason) => {
                let span = start..start + written.len();
                self.refused.push((span, format!("{what}: {reason}")));
                None
            }
        }
    }

    /// `dpt(3,12)` or `h(4)`.
    fn extent(&mut self, written: &str, text: &str) -> Option<(String, u32, u32)> {
        let (name, rest) = written.split_once('(')?;
        let inner = rest.strip_suffix(')')?;
        let what = format!("the extent of '{name}' in a comment");
        let (rows, columns) = match inner.split_once(',') {
            Some((rows, columns)) => (rows, self.size(columns, &what, EXTENT, text)?),
            None => (inner, 0),
        };
        let rows = self.size(rows, &what, EXTENT, text)?;
        Some((name.to_owned(), rows, columns))
    }

    fn fact(&mut self, fact: &str, text: &str) {
        if fact.starts_with("All Parameter Symbols included") {
            self.all_parameter_symbols = true;
        }
        let Some((key, value)) = fact.split_once(':') else {
            return;
        };
        let value = value.trim();
        match key.trim() {
            "Project name" => self.model = Some(value.to_owned()),
            "Generation Date" => self.date = Some(value.to_owned()),
            "Number of joints" => {
                self.joints = self.size(value, "the number of joints in a comment", JOINTS, text);
            }
            "Array extents" => {
                let extents = value.split_whitespace();
                self.extents = extents
                    .filter_map(|written| self.extent(written, text))
                    .collect();
            }
            "Flops complexity" => self.flops = Some(value.to_owned()),
            "Function" => {
                let digits: String = value
                    .trim_start_matches('F')
                    .trim_start()
                    .chars()
                    .take_while(char::is_ascii_digit)
                    .collect();
                self.function = (!digits.is_empty()).then(|| format!("F{digits}"));
            }
            _ => {}
        }
    }

    /// The metadata of a function of the file.
    pub(super) fn metadata(&self, language: Language, kind: &str) -> Vec<(String, String)> {
        let joints = self.joints.map(|joints| joints.to_string());
        let all = self.all_parameter_symbols.then(|| "yes".to_owned());
        // Matlab and Python have it without a type.
        let structure =
            (self.old_structure && language == Language::C).then(|| "MBSdataStruct".to_owned());
        let known = [
            ("model", self.model.clone()),
            ("generator", self.generator.clone()),
            ("language", Some(language.name().to_owned())),
            ("function", self.function.clone()),
            ("kind", Some(kind.to_owned())),
            ("joints", joints),
            ("flops", self.flops.clone()),
            ("date", self.date.clone()),
            ("all_parameter_symbols", all),
            ("structure", structure),
        ];
        known
            .into_iter()
            .filter_map(|(key, value)| value.map(|value| (key.to_owned(), value)))
            .collect()
    }

    /// The closing comment that a complete file of this generator has and
    /// this one has not. Matlab and Python files have no other mark of their
    /// end, and a cut one would silently lack equations.
    pub(super) fn missing_end(&self, text: &str) -> Option<&'static str> {
        if text.matches("===== BEGIN task").count() > text.matches("====== END Task").count() {
            return Some("====== END Task 0 ======");
        }
        let newer = self
            .generator
            .as_deref()
            .is_some_and(|name| name.starts_with("MBsysTran") || name.starts_with("robovec"));
        (newer && !text.contains("Number of continuation lines"))
            .then_some("Number of continuation lines = 0")
    }
}

fn first_word(text: &str) -> Option<&str> {
    text.split_whitespace().next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_generators_are_understood() {
        let old = Header::read(
            "%\tROBOTRAN - Version 6.6 (build : x)\n%\t==> Project name : Car\n\
             %\t==> All Parameter Symbols included\n%\t==> Number of joints : 44\n\
             %\t==> Function : F 1 : Direct\n%\t==> Flops complexity : 6120\n",
        );
        assert_eq!(old.generator.as_deref(), Some("ROBOTRAN 6.6"));
        assert_eq!(old.model.as_deref(), Some("Car"));
        assert_eq!(old.joints, Some(44));
        assert_eq!(old.function.as_deref(), Some("F1"));
        assert_eq!(old.flops.as_deref(), Some("6120"));
        assert!(old.all_parameter_symbols);
        let new = Header::read(
            "#\tMBsysTran - Release 8.1\n#\t==> Function: F19 - External Forces\n\
             #\t==> Generation Date: Wed May  4 23:04:45 2022\n",
        );
        assert_eq!(new.generator.as_deref(), Some("MBsysTran 8.1"));
        assert_eq!(new.function.as_deref(), Some("F19"));
        assert_eq!(new.date.as_deref(), Some("Wed May  4 23:04:45 2022"));
        assert!(new.missing_end("x = y").is_some());
        let ours = Header::read(
            "//\trobovec - Version 0.1.0\n//\t==> Array extents : dpt(3,12) h(4) odd( x(9,\n",
        );
        assert_eq!(ours.generator.as_deref(), Some("robovec 0.1.0"));
        let expected = [("dpt".to_owned(), 3, 12), ("h".to_owned(), 4, 0)];
        assert_eq!(ours.extents, expected);
        assert!(ours.refused.is_empty());
        assert!(ours.missing_end("x = y").is_some());
    }

    #[test]
    fn sizes_that_no_model_has_are_refused_where_they_stand() {
        for (line, part) in [
            ("Number of joints : 2147483647", "2147483647"),
            ("Number of joints : 2001", "2001"),
            (
                "Number of joints : 99999999999999999999",
                "99999999999999999999",
            ),
            ("Array extents : dpt(3,12) h(4000000000)", "4000000000"),
            ("Array extents : dpt(3,1000001)", "1000001"),
        ] {
            let text = format!("% first\n%\t==> {line}\n");
            let header = Header::read(&text);
            let [(span, reason)] = header.refused.as_slice() else {
                panic!("{line} is taken");
            };
            assert_eq!(&text[span.clone()], part);
            assert!(reason.contains("is not allowed"), "{reason}");
        }
        let strange = Header::read("%\t==> Number of joints : many\n");
        assert_eq!((strange.joints, strange.refused.len()), (None, 0));
        assert_eq!(
            Header::read("%\t==> Number of joints : 2000\n").joints,
            Some(2000)
        );
    }
}
