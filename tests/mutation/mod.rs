//! Files of equations changed at random: tokens exchanged, left out, doubled
//! and inserted; whole lines; mistakes of people and of bad generators.

use robovec::robotran::Language;
use robovec_num::random::Random;

/// Numbers in the spellings of the languages.
const NUMBERS: [&str; 24] = [
    "1",
    "2",
    "0",
    "-0",
    "1.0",
    "0.0",
    "3/2",
    "(1/2)",
    "1/3",
    "-1/2",
    "010",
    "0x10",
    "0.1f",
    "1.f",
    "2L",
    "1e2",
    "5.",
    ".5",
    "08",
    "1u",
    "0.1L",
    "0x1p-1",
    "2147483647",
    "(0)",
];
/// Pieces put between tokens.
const PIECES: [&str; 40] = [
    "(", ")", "-", "+", "*", "/", "/2", "*1/2", "1/2*", "-(0)*", "++", "--", "?", ":", "%2", ",",
    ";", "{", "}", "(int)", "(double)", "(float)", "!", "[1]", "[1][2]", "[01]", "=", "==", "&",
    "/*", "*/", "//", "\\\n", "\"", "'", "sin(", "**", "//2", "^2", "s->",
];
/// Lines put between lines.
const LINES: [&str; 60] = [
    "#if 0",
    "#if 1",
    "#else",
    "#elif 1",
    "#endif",
    "#ifdef A",
    "#ifndef A",
    "#define A",
    "#define q qd",
    "#define q s->qd",
    "#define qd s->q",
    "#undef q",
    "#define C2 2",
    "#define C2 1/2",
    "#define S2 C2",
    "#define cos sin",
    "#define cos(x) (x)",
    "#define double float",
    "/*",
    "*/",
    "// \\",
    "// ??/",
    "\\",
    "{",
    "}",
    "if (q[1] > 0)",
    "if (0) {",
    "} else {",
    "else",
    "while (0) {",
    "for (;;) {",
    "do {",
    "switch (isens) {",
    "case 1:",
    "case 2:",
    "default:",
    "break;",
    "return;",
    "{ return; }",
    "int C2;",
    "int n = 1;",
    "double C2;",
    "double t1 = 1/2;",
    "static double S2;",
    "float S2;",
    "{ double C2 = 3; }",
    "double q[4];",
    "double *x = s->qd;",
    "q = s->qd;",
    "qd = s->q;",
    "q = qd;",
    "tsim = 2;",
    "isens = 2;",
    "C2 = 1/2;",
    "q[1] = q[2];",
    "q[2] = 1/2*q[2];",
    "change(q);",
    "mbs_msg(\"a // b\");",
    ";",
    "A: ;",
];

/// A source of changes that depends only on its seed.
pub(crate) struct Mutator(Random);

impl Mutator {
    pub(crate) fn new(seed: u64) -> Mutator {
        Mutator(Random::new(seed))
    }

    fn below(&mut self, count: usize) -> usize {
        self.0.below(count.max(1))
    }

    /// A text with a change, or two, after its head.
    pub(crate) fn mutant(&mut self, text: &str, language: Language) -> String {
        let marks = match language {
            Language::C => ["void mbs_", "int mbs_"],
            Language::Matlab => ["function ", "function "],
            Language::Python => ["def ", "def "],
        };
        let head = marks.iter().find_map(|mark| text.find(mark)).unwrap_or(0);
        let mut body = text[head..].to_owned();
        for _ in 0..=self.below(4) / 3 {
            body = match self.below(6) {
                0 | 1 => self.lines_changed(&body, language),
                _ => self.tokens_changed(&body),
            };
        }
        format!("{}{body}", &text[..head])
    }

    fn lines_changed(&mut self, text: &str, language: Language) -> String {
        let mut lines: Vec<String> = text.split_inclusive('\n').map(str::to_owned).collect();
        let at = self.below(lines.len());
        let other = self.below(lines.len());
        match self.below(6) {
            0 => {
                lines.remove(at);
            }
            1 => lines.insert(other, lines[at].clone()),
            2 => lines.swap(at, other),
            _ => {
                let line = LINES[self.below(LINES.len())];
                let line = match language {
                    Language::C => line.to_owned(),
                    Language::Matlab => line.replace("->", ".").replace('[', "(").replace(']', ")"),
                    Language::Python => format!("    {}", line.replace("->", ".")),
                };
                lines.insert(at.max(2), line + "\n");
                // Often also what closes it.
                if self.below(2) == 0 {
                    let end = ["#endif\n", "}\n", "*/\n", "#else\n", "break;\n"][self.below(5)];
                    let place = (at.max(2) + 2 + self.below(3)).min(lines.len());
                    lines.insert(place, end.to_owned());
                }
            }
        }
        lines.concat()
    }

    fn tokens_changed(&mut self, text: &str) -> String {
        let mut tokens: Vec<String> = tokens(text);
        let at = self.below(tokens.len());
        let other = self.below(tokens.len());
        let is_number = |token: &String| token.starts_with(|c: char| c.is_ascii_digit());
        let is_operator = |token: &String| matches!(token.as_str(), "+" | "-" | "*" | "/");
        match self.below(9) {
            0 => {
                tokens.remove(at);
            }
            1 => tokens.insert(at, tokens[at].clone()),
            2 => tokens.swap(at, other),
            3 => tokens.insert(at, PIECES[self.below(PIECES.len())].to_owned()),
            4 => tokens[at] = tokens[other].clone(),
            5 | 6 => {
                // Before an operand, or in the place of a number.
                let found = (at..tokens.len()).find(|&index| is_number(&tokens[index]));
                let number = NUMBERS[self.below(NUMBERS.len())];
                if let Some(index) = found {
                    tokens[index] = number.to_owned();
                }
                let operator = (at..tokens.len()).find(|&index| is_operator(&tokens[index]));
                if let Some(index) = operator {
                    let joined = ["*", "/", "+", "-"][self.below(4)];
                    tokens.insert(index + 1, format!("{number}{joined}"));
                }
            }
            7 => {
                let found = (at..tokens.len()).find(|&index| is_operator(&tokens[index]));
                if let Some(index) = found {
                    tokens[index] = ["+", "-", "*", "/"][self.below(4)].to_owned();
                }
            }
            _ => {
                let found = (at..tokens.len()).find(|&index| tokens[index] == "=");
                if let Some(index) = found {
                    let number = NUMBERS[self.below(NUMBERS.len())];
                    let operator = ["*", "/", "+", "-"][self.below(4)];
                    tokens.insert(index + 1, format!(" {number}{operator}"));
                }
            }
        }
        tokens.concat()
    }
}

/// Words with digits, runs of blanks, single characters.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let kind = |c: char| match c {
        c if c.is_alphanumeric() || c == '_' || c == '.' => 0,
        c if c.is_whitespace() => 1,
        _ => 2,
    };
    let mut last = 2;
    for character in text.chars() {
        let now = kind(character);
        match tokens.last_mut() {
            Some(token) if now == last && now != 2 => token.push(character),
            _ => tokens.push(character.to_string()),
        }
        last = now;
    }
    tokens
}
