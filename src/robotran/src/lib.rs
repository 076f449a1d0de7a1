//! The reader of all Robotran files: C, Matlab, Python, generators 6.6 and 8.1.
//!
//! A file passes through [`decode`] (bytes to text), a lexer of its language
//! ([`raw`], [`tokens`]), one grammar for all three (`grammar.lalrpop`) that
//! writes into an arena ([`syntax`]), [`structure`] (functions, sensor cases,
//! loops), [`storage`] (arrays and their extents) and [`lower`]. Plain
//! equations, nearly all of a file, do not pass through the tables of the
//! grammar (`tokens/equations.rs`); with the same result: a module of equations
//! whose evaluation in 64-bit floats equals the compiled C bit for bit.

pub mod align;
pub mod conventions;
mod decode;
pub mod drop_in;
mod explain;
mod function_kind;
mod header;
mod literal;
mod lower;
mod places;
mod preprocessor;
mod raw;
mod storage;
mod structure;
mod syntax;
mod token;
mod tokens;
pub mod write;

lalrpop_util::lalrpop_mod!(
    #[allow(
        clippy::all,
        clippy::unwrap_used,
        clippy::pedantic,
        unused,
        missing_docs,
        unreachable_pub
    )]
    grammar,
    "/grammar.rs"
);

pub use self::decode::{decode_text, is_control, is_equations, with_line_feeds};
use self::explain::{explain, refusal};
pub use self::function_kind::FunctionKind;
use self::header::Header;
use self::literal::IntegerArithmetic;
use self::lower::Lowering;
pub use self::places::LineIndex;
use self::raw::{C, Matlab, Python, Surface};
use self::syntax::{CAPACITY, SyntaxBuilder, SyntaxTree};
use self::token::RobotranToken;
pub use self::token::SourceSpan;
use self::tokens::{ExpressionStacks, TokenSource, TokenStream};
use robovec_ir::diagnostic::{Diagnostic, Report};
use robovec_ir::verify::is_valid;
use robovec_ir::{Module, Symbols};
use robovec_num::limits::NumberLimit;
use std::fmt;

/// No more errors, and no more warnings, than this are reported for one file.
const ERROR_LIMIT: usize = 20;

/// The limits of sizes in these files: name, limit, and the default.
pub const FIELDS: &[(&str, NumberLimit, &str)] = &[
    ("Number of joints (comment)", conventions::JOINTS, "as used"),
    ("Array extents (comment)", header::EXTENT, "as used"),
    ("index", header::EXTENT, ""),
];

robovec_num::named! {
    /// A language Robotran writes.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
    pub enum Language {
        /// C, for MBsysC.
        C = "c",
        /// Matlab, for MBsysLab.
        Matlab = "matlab",
        /// Python, for MBsysPy.
        Python = "python",
    }
}

impl Language {
    /// The language of a file name's extension, without the dot.
    pub fn from_extension(extension: &str) -> Option<Language> {
        match extension {
            "c" | "h" | "cc" | "cpp" => Some(Language::C),
            "m" => Some(Language::Matlab),
            "py" => Some(Language::Python),
            _ => None,
        }
    }
}

impl fmt::Display for Language {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// A file that was read.
#[derive(Debug)]
pub struct Read {
    /// One function for each function of the file, for each case of a sensor
    /// file (`sensor_3`), or for each part of a function with loops.
    pub module: Module,
    /// Warnings, with the text they are about; without it when there are none.
    pub warnings: Report,
}

/// A file that could not be read: the reasons, and the text they point into.
#[derive(Debug, thiserror::Error)]
#[error("{}", .report.summary())]
pub struct ReadError {
    /// One to twenty errors, perhaps with warnings.
    pub report: Report,
}

/// Reads a file of Robotran's. The name is used in messages and for the source
/// places of the module, and, where the text leaves it open, to find the
/// language and the kind of file; `language` overrides the detected one.
///
/// # Errors
///
/// All faults that prevent the file from being compiled as intended, each with
/// its place: syntax, names that are undefined or defined twice, cycles,
/// outputs that are never written, an incomplete file, a file that is not text.
pub fn read(name: &str, bytes: &[u8], language: Option<Language>) -> Result<Read, ReadError> {
    let fail = |text: &str, errors: Vec<Diagnostic>| ReadError {
        report: Report::of(name, text, errors),
    };
    let text = decode::decode(bytes).map_err(|mut error| {
        // There is no text to point into, so the message names the file.
        error.message = format!("{name}: {}", error.message);
        fail("", vec![error])
    })?;
    let Some(language) = language.or_else(|| decode::detect(name, &text)) else {
        let error = Diagnostic::error()
            .with_message("the language of the file cannot be recognised")
            .with_note("name the file .c, .m or .py, or force the language");
        return Err(fail(&text, vec![error]));
    };
    if language == Language::C
        && let Some(error) = loops_of_robovec(&text)
    {
        return Err(fail(&text, vec![error]));
    }
    let mut module = Module::new();
    let syntax = parse(&text, language, &mut module.tables.symbols)
        .map_err(|errors| fail(&text, limited(errors, Vec::new())))?;
    let (module, errors, warnings) = build(name, &text, language, module, syntax);
    let mut warnings = warnings;
    warnings.truncate(ERROR_LIMIT);
    if errors.is_empty() {
        debug_assert!(is_valid(&module), "every function that was read is valid");
        let shown = if warnings.is_empty() { "" } else { &text };
        return Ok(Read {
            module,
            warnings: Report::of(name, shown, warnings),
        });
    }
    Err(fail(&text, limited(errors, warnings)))
}

/// True for robovec's own C for processors, by its first line.
fn is_for_processors(text: &str) -> bool {
    let mut lines = text.lines();
    lines
        .next()
        .is_some_and(|head| head.starts_with("/*") && head.contains(" by robovec"))
}

/// Reason why a file of robovec's own C for processors cannot be read, where it
/// holds more than one straight-line function of 64-bit floats.
fn loops_of_robovec(text: &str) -> Option<Diagnostic> {
    if !is_for_processors(text) {
        return None;
    }
    let kinds = [
        (
            "ROBOVEC_ANGLES",
            "robovec wrote the sines of this file as a loop",
            "they are not the library's to the last bit: read the .rvir file that it was written from, or write it with `sines=library`",
        ),
        (
            "ROBOVEC_APART",
            "robovec wrote this file in several parts",
            "read the .rvir file that it was written from, or write it with a `part` that holds all operations",
        ),
        (
            "for (",
            "robovec wrote this file with loops",
            "only straight-line C is read: read the .rvir file that it was written from",
        ),
    ];
    kinds.into_iter().find_map(|(mark, message, note)| {
        let start = text.find(mark)?;
        let span = SourceSpan::new(start, start + mark.len());
        Some(refusal(message, span, "the first of it", note))
    })
}

/// At most [`ERROR_LIMIT`] errors, then the warnings.
fn limited(mut errors: Vec<Diagnostic>, warnings: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let more = errors.len() >= ERROR_LIMIT;
    errors.truncate(ERROR_LIMIT);
    errors.extend(warnings);
    if more {
        errors.push(Diagnostic::note().with_message(format!(
            "reading stopped after {ERROR_LIMIT} errors; there may be more"
        )));
    }
    errors
}

fn parse(
    text: &str,
    language: Language,
    symbols: &mut Symbols,
) -> Result<SyntaxTree, Vec<Diagnostic>> {
    let mut builder = SyntaxBuilder::default();
    builder.extents_from_zero = language != Language::Matlab;
    builder.arithmetic = match language {
        Language::C => IntegerArithmetic::C,
        Language::Matlab => IntegerArithmetic::Floats,
        Language::Python => IntegerArithmetic::Python,
    };
    let errors = match language {
        Language::C => parse_tokens::<C>(text, language, symbols, &mut builder),
        Language::Matlab => parse_tokens::<Matlab>(text, language, symbols, &mut builder),
        Language::Python => parse_tokens::<Python>(text, language, symbols, &mut builder),
    };
    let syntax = builder.syntax;
    if syntax
        .nodes
        .len()
        .max(syntax.elements.len())
        .max(symbols.len())
        >= CAPACITY
    {
        return Err(vec![
            Diagnostic::error().with_message("the file has more than 2^29 operations or names"),
        ]);
    }
    if errors.is_empty() {
        Ok(syntax)
    } else {
        Err(errors)
    }
}

/// The tokens up to the end of a statement; true when they were the last.
struct StatementTokens<'a, T> {
    tokens: &'a mut T,
    ended: bool,
    last: bool,
}

impl<T: TokenSource> Iterator for StatementTokens<'_, T> {
    type Item = T::Item;

    fn next(&mut self) -> Option<T::Item> {
        if self.ended {
            return None;
        }
        let token = self.tokens.next();
        self.last = token.is_none();
        self.ended = matches!(token, None | Some(Ok((_, RobotranToken::End, _))));
        token
    }
}

/// Parses all statements; after one that cannot be read it starts again.
fn parse_tokens<'s, L: Surface<'s>>(
    text: &'s str,
    language: Language,
    symbols: &mut Symbols,
    builder: &mut SyntaxBuilder,
) -> Vec<Diagnostic> {
    let mut tokens = TokenStream::<L>::new(text, language, symbols);
    let parser = grammar::FileParser::new();
    let mut stacks = ExpressionStacks::default();
    let mut errors = Vec::new();
    loop {
        while tokens.plain_equation(builder, &mut stacks) {}
        let mut statement = StatementTokens {
            tokens: &mut tokens,
            ended: false,
            last: false,
        };
        let read = parser.parse(builder, &mut statement);
        let last = statement.last;
        let Err(error) = read else {
            if last {
                return errors;
            }
            continue;
        };
        let [last, before] = tokens.recent();
        let at_end = matches!(error, lalrpop_util::ParseError::UnrecognizedEof { .. });
        let previous = if at_end { last } else { before };
        errors.push(explain(error, previous, text));
        builder.abandon_statement();
        if at_end || errors.len() >= ERROR_LIMIT {
            return errors;
        }
        tokens.skip_statement();
    }
}

fn build(
    name: &str,
    text: &str,
    language: Language,
    mut module: Module,
    syntax: SyntaxTree,
) -> (Module, Vec<Diagnostic>, Vec<Diagnostic>) {
    let file = module.tables.sources.add_file(name);
    let mut places = LineIndex::new(text, file);
    let blocks =
        match structure::functions(&syntax, language, &mut places, &module.tables.symbols, text) {
            Ok(blocks) => blocks,
            Err(errors) => return (module, errors, Vec::new()),
        };
    let header = Header::read(text);
    let mut errors = Vec::new();
    if blocks.is_empty() {
        let note = if name.ends_with(".h") {
            "a header only declares the temporaries; give the .c file beside it".to_owned()
        } else {
            format!("it was read as {language}; is it one of Robotran's files?")
        };
        errors.push(
            Diagnostic::error()
                .with_message("there is no function and no equation in the file")
                .with_note(note),
        );
    }
    errors.extend(header.refused.iter().map(|(span, reason)| {
        let span = SourceSpan::new(span.start, span.end);
        refusal(reason, span, "this size", "correct or remove the comment")
    }));
    let has_equations = !syntax.nodes.is_empty();
    if has_equations
        && language != Language::C
        && let Some(mark) = header.missing_end(text)
    {
        let end = text.trim_end().len();
        errors.push(refusal(
            "the file is cut short",
            SourceSpan::new(end, end),
            "its closing comment is missing",
            &format!("generate or copy it again; if it is complete, add the comment `{mark}`"),
        ));
    }
    let mut lowering = Lowering {
        syntax,
        text,
        file_name: name,
        language,
        header,
        places,
        module,
        errors,
        warnings: Vec::new(),
        guard: None,
        work: 0,
    };
    lowering.run(&blocks);
    (lowering.module, lowering.errors, lowering.warnings)
}
