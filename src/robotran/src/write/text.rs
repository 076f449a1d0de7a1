//! Text in one of the languages: statements, and lines that are not too long.

use crate::Language;

/// Lines longer than this continue in the next where an operator allows it.
const WIDTH: usize = 118;

#[derive(Debug)]
pub(super) struct FileText {
    pub(super) language: Language,
    out: String,
    /// Beginning of the line.
    line: usize,
    /// Last place at which the line can be broken: after an operator.
    breakable: usize,
    /// Continuation lines of this statement, and the most of any.
    continuations: u32,
    most: u32,
    indent: usize,
}

impl FileText {
    pub(super) fn new(language: Language) -> FileText {
        FileText {
            language,
            out: String::new(),
            line: 0,
            breakable: 0,
            continuations: 0,
            most: 0,
            indent: 0,
        }
    }

    /// The text, and the most continuation lines of any statement.
    pub(super) fn finish(self) -> (String, u32) {
        (self.out, self.most)
    }

    pub(super) fn most_continuations(&self) -> u32 {
        self.most
    }

    /// Blanks before every statement from here on.
    pub(super) fn indent(&mut self, blanks: usize) {
        self.indent = blanks;
    }

    /// Writes a whole line unchanged.
    pub(super) fn line(&mut self, text: &str) {
        self.out.push_str(text);
        self.out.push('\n');
        self.line = self.out.len();
    }

    pub(super) fn comment(&mut self, text: &str) {
        self.out.push_str(comment_mark(self.language));
        self.line(text);
    }

    /// A title over a section.
    pub(super) fn section(&mut self, title: &str) {
        self.line("");
        self.comment(&format!(" {title}"));
        self.line("");
    }

    /// A statement that needs no wrapping, indented and ended.
    pub(super) fn statement(&mut self, text: &str) {
        self.begin();
        self.push(text);
        self.end();
    }

    pub(super) fn begin(&mut self) {
        self.line = self.out.len();
        self.breakable = self.line;
        self.continuations = 0;
        for _ in 0..self.indent {
            self.out.push(' ');
        }
    }

    pub(super) fn end(&mut self) {
        match self.language {
            Language::C | Language::Matlab => self.out.push_str(";\n"),
            Language::Python => self.out.push('\n'),
        }
        self.line = self.out.len();
        self.most = self.most.max(self.continuations);
    }

    /// A piece of a statement, before which a line that is too long is broken.
    pub(super) fn push(&mut self, text: &str) {
        self.out.push_str(text);
        if self.out.len() - self.line > WIDTH {
            self.wrap();
        }
    }

    /// An operator, after which the line may be broken.
    pub(super) fn operator(&mut self, text: &str) {
        self.push(text);
        self.breakable = self.out.len();
    }

    pub(super) fn integer(&mut self, number: u32) {
        let mut digits = [0u8; 10];
        let mut start = digits.len();
        let mut rest = number;
        loop {
            start -= 1;
            digits[start] = b'0' + (rest % 10) as u8;
            rest /= 10;
            if rest == 0 {
                break;
            }
        }
        for &digit in &digits[start..] {
            self.out.push(char::from(digit));
        }
    }

    /// An array element, its name and its indices, which count from 1.
    pub(super) fn element(&mut self, name: &str, indices: &[u32]) {
        self.out.push_str(name);
        let (open, between, close) = match self.language {
            Language::C => ("[", "][", "]"),
            Language::Matlab => ("(", ",", ")"),
            Language::Python => ("[", ",", "]"),
        };
        for (place, &index) in indices.iter().enumerate() {
            self.out.push_str(if place == 0 { open } else { between });
            self.integer(index);
        }
        self.push(if indices.is_empty() { "" } else { close });
    }

    /// A number as Robotran writes it, in parentheses; a sign is inside
    /// them, where the reader takes it as part of the number.
    pub(super) fn number(&mut self, number: f64) {
        let text = format!("({number:?})");
        self.push(&text);
    }

    fn wrap(&mut self) {
        if self.breakable <= self.line {
            return;
        }
        let mark = match self.language {
            Language::C => "\n ",
            Language::Matlab => "...\n ",
            Language::Python => "\\\n ",
        };
        // Only what was pushed since the last operator moves: one operand.
        self.out.insert_str(self.breakable, mark);
        self.line = self.breakable + mark.len() - 1;
        self.breakable = self.line;
        self.continuations += 1;
    }
}

pub(super) fn comment_mark(language: Language) -> &'static str {
    match language {
        Language::C => "//",
        Language::Matlab => "%",
        Language::Python => "#",
    }
}
