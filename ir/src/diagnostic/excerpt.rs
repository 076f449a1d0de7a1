//! The lines a message points at, cut to a readable width.
//!
//! The renderer prints every line that has a label in full and trusts its
//! bytes. Here the lines are copied into a small separate text: cut to a window
//! around the first label, control characters replaced by characters of the
//! same length, labels moved along. Line and column numbers stay those of the
//! whole text.

use super::{Diagnostic, FileId, Label, LabelStyle, SourceText, boundary_after, boundary_before};
use codespan_reporting::files::{Error, Files};
use std::ops::Range;

/// Lines up to this many bytes are shown whole.
const WHOLE: usize = 240;
/// Bytes shown before the start of the label in a longer line.
const BEFORE: usize = 80;
/// Bytes shown from the start of the label in a longer line.
const AFTER: usize = 140;
/// A label over more lines than this is shown on its first line only.
const MAX_LINES: usize = 8;

/// The excerpts of the texts that one message refers to.
pub(super) struct Excerpts {
    files: Vec<Excerpt>,
}

struct Excerpt {
    id: FileId,
    name: String,
    text: String,
    lines: Vec<ExcerptLine>,
}

struct ExcerptLine {
    /// Number in the whole text, from 0.
    index: usize,
    /// The bytes of the whole text that are shown.
    window: Range<usize>,
    /// Characters of the line before the window.
    skipped: usize,
    /// The start of the line in the excerpt, its ellipsis included.
    start: usize,
    /// Bytes of the ellipsis before the window: 0 or 3.
    lead: usize,
}

/// The excerpts for a message, and the message with its labels moved there.
pub(super) fn excerpt(files: &[SourceText], diagnostic: &Diagnostic) -> (Excerpts, Diagnostic) {
    let mut shown = Diagnostic::new(diagnostic.severity)
        .with_message(clean(&diagnostic.message))
        .with_notes_iter(diagnostic.notes.iter().map(|note| clean(note)));
    shown.code.clone_from(&diagnostic.code);
    let mut excerpts = Excerpts { files: Vec::new() };
    for label in &diagnostic.labels {
        let known = excerpts.files.iter().any(|file| file.id == label.file_id);
        if let Some(source) = files.get(label.file_id).filter(|_| !known) {
            let labels = diagnostic.labels.iter();
            let labels: Vec<Label> = labels
                .filter(|other| other.file_id == label.file_id)
                .map(|other| fitted(source, other))
                .collect();
            let excerpt = Excerpt::new(source, label.file_id, &labels);
            for label in labels {
                excerpt.show(source, label, &mut shown);
            }
            excerpts.files.push(excerpt);
        }
    }
    (excerpts, shown)
}

/// A label within the text, on character boundaries, over few lines.
fn fitted(source: &SourceText, label: &Label) -> Label {
    let text = source.text();
    let start = boundary_before(text, label.range.start);
    let end = boundary_after(text, label.range.end).max(start);
    let mut end = start + text[start..end].trim_end_matches(['\n', '\r']).len();
    let first = source.line_index(start);
    if source.line_index(end) - first >= MAX_LINES {
        end = source.line_range(first).end.max(start);
    }
    Label {
        range: start..end,
        message: clean(&label.message),
        ..label.clone()
    }
}

impl Excerpt {
    fn new(source: &SourceText, id: FileId, labels: &[Label]) -> Excerpt {
        let mut indices: Vec<usize> = labels
            .iter()
            .flat_map(|label| {
                source.line_index(label.range.start)..=source.line_index(label.range.end)
            })
            .collect();
        indices.sort_unstable();
        indices.dedup();
        let mut excerpt = Excerpt {
            id,
            name: source.name().to_owned(),
            text: String::new(),
            lines: Vec::new(),
        };
        for index in indices {
            // The renderer draws a break where two lines are missing; so two
            // stand between lines that are far apart.
            if let Some(last) = excerpt.lines.last().map(|line| line.index) {
                for missing in (last + 1..index).take(2) {
                    excerpt.push(source, missing, labels);
                }
            }
            excerpt.push(source, index, labels);
        }
        excerpt
    }

    fn push(&mut self, source: &SourceText, index: usize, labels: &[Label]) {
        let line = source.line_range(index);
        let text = source.text();
        let mut window = line.clone();
        if line.len() > WHOLE {
            let on_line = |style: LabelStyle| {
                labels
                    .iter()
                    .filter(|label| {
                        // The end of the line counts: something may be missing there.
                        let at = label.range.start;
                        label.style == style && line.start <= at && at <= line.end
                    })
                    .map(|label| label.range.start)
                    .min()
            };
            let focus = on_line(LabelStyle::Primary)
                .or_else(|| on_line(LabelStyle::Secondary))
                .unwrap_or(line.start);
            let start = boundary_before(text, focus.saturating_sub(BEFORE));
            let end = boundary_after(text, (focus + AFTER).min(line.end));
            window = start.max(line.start)..end;
        }
        let start = self.text.len();
        let lead = if window.start > line.start { "…" } else { "" };
        self.text.push_str(lead);
        self.text.extend(text[window.clone()].chars().map(visible));
        if window.end < line.end {
            self.text.push('…');
        }
        self.text.push('\n');
        self.lines.push(ExcerptLine {
            index,
            skipped: text[line.start..window.start].chars().count(),
            window,
            start,
            lead: lead.len(),
        });
    }

    /// Moves a label into the excerpt; one outside the window of its line
    /// becomes a note.
    fn show(&self, source: &SourceText, label: Label, shown: &mut Diagnostic) {
        let start_line = self.line_of(source.line_index(label.range.start));
        let end_line = self.line_of(source.line_index(label.range.end));
        let start = label.range.start;
        if start < start_line.window.start || start > start_line.window.end {
            let line_start = source.line_range(start_line.index).start;
            let column = source.text()[line_start..start].chars().count() + 1;
            shown.notes.push(format!(
                "{} (line {}, column {column})",
                label.message,
                start_line.index + 1
            ));
            return;
        }
        shown.labels.push(Label {
            range: start_line.moved(start)..end_line.moved(label.range.end),
            ..label
        });
    }

    fn line_of(&self, index: usize) -> &ExcerptLine {
        let at = self.lines.partition_point(|line| line.index < index);
        &self.lines[at]
    }
}

impl ExcerptLine {
    fn moved(&self, byte: usize) -> usize {
        let clamped = byte.clamp(self.window.start, self.window.end);
        self.start + self.lead + clamped - self.window.start
    }
}

impl Excerpts {
    fn file(&self, id: FileId) -> Result<&Excerpt, Error> {
        let found = self.files.iter().find(|file| file.id == id);
        found.ok_or(Error::FileMissing)
    }

    fn line(&self, id: FileId, index: usize) -> Result<&ExcerptLine, Error> {
        let lines = &self.file(id)?.lines;
        lines.get(index).ok_or(Error::LineTooLarge {
            given: index,
            max: lines.len(),
        })
    }
}

impl<'a> Files<'a> for Excerpts {
    type FileId = FileId;
    type Name = &'a str;
    type Source = &'a str;

    fn name(&'a self, id: FileId) -> Result<&'a str, Error> {
        Ok(&self.file(id)?.name)
    }

    fn source(&'a self, id: FileId) -> Result<&'a str, Error> {
        Ok(&self.file(id)?.text)
    }

    fn line_index(&'a self, id: FileId, byte: usize) -> Result<usize, Error> {
        let lines = &self.file(id)?.lines;
        let after = lines.partition_point(|line| line.start <= byte);
        Ok(after.saturating_sub(1))
    }

    fn line_number(&'a self, id: FileId, index: usize) -> Result<usize, Error> {
        Ok(self.line(id, index)?.index + 1)
    }

    fn column_number(&'a self, id: FileId, index: usize, byte: usize) -> Result<usize, Error> {
        let line = self.line(id, index)?;
        let first = line.start + line.lead;
        let shown = &self.file(id)?.text[first..byte.max(first)];
        Ok(line.skipped + shown.chars().count() + 1)
    }

    fn line_range(&'a self, id: FileId, index: usize) -> Result<Range<usize>, Error> {
        let start = self.line(id, index)?.start;
        let file = self.file(id)?;
        let end = file.lines.get(index + 1).map(|line| line.start);
        Ok(start..end.unwrap_or(file.text.len()))
    }
}

/// A character that is safe to print, of the same length in UTF-8.
fn visible(character: char) -> char {
    let invisible = matches!(
        character,
        '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{2069}' | '\u{feff}'
    );
    match character {
        '\t' => ' ',
        _ if character.is_control() && character.is_ascii() => '?',
        _ if character.is_control() => '·',
        _ if invisible => '\u{fffd}',
        other => other,
    }
}

/// A text without control characters other than line ends.
fn clean(text: &str) -> String {
    let keep = |character| match character {
        '\n' => '\n',
        other => visible(other),
    };
    text.chars().map(keep).collect()
}
