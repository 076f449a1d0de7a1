//! Messages about the user's text, with a caret under the place.
//!
//! A thin layer over codespan-reporting, which draws the snippets. Additions: a
//! [`Report`] that owns the texts and the messages about them, plain and
//! coloured rendering, and protection against hostile texts. Only an excerpt of
//! the lines a message points at is handed to the renderer, cut to a window
//! around the label, so that a caret into a line of ten megabytes prints two
//! hundred characters, and control characters never reach the terminal.
//!
//! Library code returns plain [`Diagnostic`]s whose labels use the file
//! number it was given (0 for a parser of one text); the program puts them
//! into a [`Report`] together with the text.

mod excerpt;

use crate::source::SourcePlace;
pub use codespan_reporting::diagnostic::{LabelStyle, Severity};
pub use codespan_reporting::term::termcolor;
use codespan_reporting::term::{Config, emit_to_string, emit_to_write_style};
pub use robovec_num::limits::{clip, counted};
use std::io::{self, IsTerminal};
use std::ops::Range;
use std::sync::OnceLock;
use termcolor::{ColorChoice, StandardStream, WriteColor};

/// The number of a text in a [`Report`], from 0 in order of adding.
pub type FileId = usize;

/// A message with labels (byte ranges of a text) and notes.
pub type Diagnostic = codespan_reporting::diagnostic::Diagnostic<FileId>;

/// A labelled byte range of a text.
pub type Label = codespan_reporting::diagnostic::Label<FileId>;

/// A named text that messages point into.
#[derive(Clone, Default, Debug)]
pub struct SourceText {
    name: String,
    text: String,
    line_starts: OnceLock<Vec<usize>>,
}

impl SourceText {
    /// The name shown above a snippet.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    fn line_starts(&self) -> &[usize] {
        self.line_starts.get_or_init(|| {
            let breaks = self.text.bytes().enumerate();
            let after = breaks
                .filter(|&(_, byte)| byte == b'\n')
                .map(|(at, _)| at + 1);
            std::iter::once(0).chain(after).collect()
        })
    }

    /// The line of a byte, from 0.
    fn line_index(&self, byte: usize) -> usize {
        self.line_starts().partition_point(|&start| start <= byte) - 1
    }

    /// The bytes of a line, from 0, without its line end; empty past the end.
    fn line_range(&self, line: usize) -> Range<usize> {
        let starts = self.line_starts();
        let Some(&start) = starts.get(line) else {
            return self.text.len()..self.text.len();
        };
        let end = starts.get(line + 1).copied().unwrap_or(self.text.len());
        start..start + self.text[start..end].trim_end_matches(['\n', '\r']).len()
    }

    /// The byte of a line and column, both from 1, columns in characters;
    /// clamped to the line.
    fn byte_at(&self, line: u32, column: u32) -> usize {
        let range = self.line_range((line as usize).saturating_sub(1));
        let before = (column as usize).saturating_sub(1);
        let text = &self.text[range.clone()];
        match text.char_indices().nth(before) {
            Some((offset, _)) => range.start + offset,
            None => range.end,
        }
    }
}

/// Texts, and messages that point into them.
#[derive(Clone, Default, Debug)]
pub struct Report {
    files: Vec<SourceText>,
    diagnostics: Vec<Diagnostic>,
}

impl Report {
    /// No texts, no messages.
    pub fn new() -> Report {
        Report::default()
    }

    /// One error about no text, with advice.
    pub fn error(message: impl Into<String>, notes: Vec<String>) -> Report {
        let mut report = Report::new();
        let error = Diagnostic::error().with_message(message.into());
        report.push(error.with_notes(notes));
        report
    }

    /// A report on one text, whose messages use file 0.
    pub fn of(name: &str, text: impl Into<String>, diagnostics: Vec<Diagnostic>) -> Report {
        let mut report = Report::new();
        report.add_file(name, text);
        report.extend(diagnostics);
        report
    }

    /// Adds a text and returns its number for labels.
    pub fn add_file(&mut self, name: &str, text: impl Into<String>) -> FileId {
        self.files.push(SourceText {
            name: name.to_owned(),
            text: text.into(),
            line_starts: OnceLock::new(),
        });
        self.files.len() - 1
    }

    /// The texts, in order of adding.
    pub fn files(&self) -> &[SourceText] {
        &self.files
    }

    /// The first text and the number of errors.
    ///
    /// # Panics
    ///
    /// Panics when there is no text that errors could be about.
    pub fn summary(&self) -> String {
        let name = self.files.first().expect("errors are about a text").name();
        let count = self.error_count();
        let plural = if count == 1 { "" } else { "s" };
        format!("{name}: {count} error{plural}")
    }

    /// Adds a message.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// Adds messages.
    pub fn extend(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        self.diagnostics.extend(diagnostics);
    }

    /// The messages, in order of adding.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        &self.diagnostics
    }

    /// True when there is no message.
    pub fn is_empty(&self) -> bool {
        self.diagnostics.is_empty()
    }

    /// True when a message is an error (or worse).
    pub fn has_errors(&self) -> bool {
        self.error_count() > 0
    }

    /// The number of messages that are errors (or worse).
    pub fn error_count(&self) -> usize {
        let severities = self.diagnostics.iter().map(|message| message.severity);
        severities
            .filter(|&severity| severity >= Severity::Error)
            .count()
    }

    /// The bytes of a place in one of the texts, for a label; clamped to the
    /// text. [`SourcePlace::file`] is not read.
    pub fn range_of(&self, file: FileId, place: SourcePlace) -> Range<usize> {
        let Some(source) = self.files.get(file) else {
            return 0..0;
        };
        let start = source.byte_at(place.line, place.column);
        let end = source.byte_at(place.end_line, place.end_column.saturating_add(1));
        start..end.max(start)
    }

    /// All messages as text without colour.
    pub fn render_plain(&self) -> String {
        let mut text = String::new();
        for diagnostic in &self.diagnostics {
            let (excerpts, shown) = excerpt::excerpt(&self.files, diagnostic);
            // The excerpt holds every file and byte the message refers to,
            // and writing to a string cannot fail.
            let drawn = emit_to_string(&mut text, &Config::default(), &excerpts, &shown);
            assert!(drawn.is_ok(), "an excerpt covers its labels");
        }
        text
    }

    /// Writes all messages, in colour when the writer supports it.
    ///
    /// # Errors
    ///
    /// Passes on the errors of the writer.
    pub fn emit(&self, writer: &mut dyn WriteColor) -> io::Result<()> {
        for diagnostic in &self.diagnostics {
            let (excerpts, shown) = excerpt::excerpt(&self.files, diagnostic);
            emit_to_write_style(&mut *writer, &Config::default(), &excerpts, &shown).map_err(
                |error| match error {
                    codespan_reporting::files::Error::Io(error) => error,
                    other => io::Error::other(other),
                },
            )?;
        }
        Ok(())
    }

    /// Writes all messages to the standard error stream; with
    /// [`ColorChoice::Auto`] in colour when that is a terminal.
    ///
    /// # Errors
    ///
    /// Passes on the errors of the stream.
    pub fn emit_to_stderr(&self, colour: ColorChoice) -> io::Result<()> {
        let colour = match colour {
            ColorChoice::Auto if !io::stderr().is_terminal() => ColorChoice::Never,
            other => other,
        };
        self.emit(&mut StandardStream::stderr(colour).lock())
    }
}

/// The last character boundary at or before a byte.
fn boundary_before(text: &str, byte: usize) -> usize {
    let mut byte = byte.min(text.len());
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    byte
}

/// The first character boundary at or after a byte.
fn boundary_after(text: &str, byte: usize) -> usize {
    let mut byte = byte.min(text.len());
    while !text.is_char_boundary(byte) {
        byte += 1;
    }
    byte
}

/// The question whether the candidate of [`did_you_mean`] is meant.
pub fn suggestion<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    did_you_mean(word, candidates).map(|near| format!("did you mean '{near}'?"))
}

/// The candidate nearest to a misspelt word, when one is near enough to be
/// meant: at most a third of the letters differ (two neighbours exchanged
/// count once). Of equally near ones the first. Candidates of very different
/// length are skipped unread, so a table of names may be searched whole.
pub fn did_you_mean<'a>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let length = word.chars().count();
    if length > 100 {
        return None;
    }
    let limit = (length / 3).clamp(1, 3);
    let mut allowed = limit;
    let mut best = None;
    for candidate in candidates {
        if candidate.len() > 4 * (length + limit) {
            continue;
        }
        if candidate.chars().count().abs_diff(length) > allowed {
            continue;
        }
        let distance = strsim::osa_distance(word, candidate);
        if distance == 0 {
            continue;
        }
        if distance <= allowed {
            best = Some(candidate);
            allowed = distance - 1;
            if allowed == 0 {
                break;
            }
        }
    }
    // A word of one or two letters resembles every other one.
    best.filter(|_| length > 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rendered(text: &str, first: Range<usize>, others: &[Range<usize>]) -> String {
        let ranges = std::iter::once(&first).chain(others);
        let labels = ranges.enumerate().map(|(index, range)| match index {
            0 => Label::primary(0, range.clone()).with_message("here"),
            _ => Label::secondary(0, range.clone()).with_message("first defined here"),
        });
        let diagnostic = Diagnostic::error()
            .with_message("something is wrong")
            .with_labels(labels.collect())
            .with_note("help: mend it");
        Report::of("a.rvir", text, vec![diagnostic]).render_plain()
    }

    #[test]
    fn a_caret_stands_under_the_range() {
        let shown = rendered("one\r\ntwo three\r\n", 9..14, &[]);
        assert!(shown.contains("a.rvir:2:5"), "{shown}");
        assert!(
            shown.contains("2 │ two three\n  │     ^^^^^ here\n"),
            "{shown}"
        );
        assert!(shown.contains("= help: mend it"), "{shown}");
    }

    #[test]
    fn a_huge_line_is_cut_around_the_label_and_keeps_its_column() {
        let mut text = "first\n".to_owned();
        text.push_str(&"é".repeat(5_000_000));
        let at = text.len();
        text.push_str("WRONG");
        text.push_str(&"y".repeat(5_000_000));
        let second = [Range { start: 6, end: 8 }];
        let shown = rendered(&text, at..at + 5, &second);
        assert!(shown.len() < 2000, "{} bytes", shown.len());
        assert!(shown.contains("a.rvir:2:5000001"), "{shown}");
        assert!(
            shown.contains("first defined here (line 2, column 1)"),
            "{shown}"
        );
        assert!(shown.contains("WRONG"));
    }

    #[test]
    fn distant_lines_keep_their_numbers_and_a_break_between() {
        let text = "a\n".repeat(100);
        let second = [Range { start: 2, end: 3 }];
        let shown = rendered(&text, 180..181, &second);
        assert!(shown.contains(" 2 │ a"), "{shown}");
        assert!(shown.contains("·"), "{shown}");
        assert!(shown.contains("91 │ a"), "{shown}");
    }

    #[test]
    fn odd_ranges_and_control_characters_are_harmless() {
        let text = "a\u{1b}[31mé\u{202e}\u{85}\0\nlast";
        for start in 0..text.len() + 3 {
            for end in 0..text.len() + 3 {
                let shown = rendered(text, start..end, &[]);
                let controls = shown.chars().filter(|&c| c.is_control() && c != '\n');
                assert_eq!(controls.count(), 0, "{shown:?}");
            }
        }
    }

    #[test]
    fn places_become_byte_ranges_and_back() {
        let report = Report::of("a.m", "x\nab é cd\n", Vec::new());
        let place = SourcePlace {
            file: 7,
            line: 2,
            column: 4,
            end_line: 2,
            end_column: 6,
        };
        let range = report.range_of(0, place);
        assert_eq!(&report.files()[0].text()[range.clone()], "é c");
    }

    #[test]
    fn near_words_are_offered_and_far_ones_are_not() {
        let words = ["atomise", "balance", "cse", "dce"];
        assert_eq!(did_you_mean("atomize", words), Some("atomise"));
        assert_eq!(did_you_mean("blaance", words), Some("balance"));
        assert_eq!(did_you_mean("place", words), None);
        assert_eq!(did_you_mean("x", words), None);
    }
}
