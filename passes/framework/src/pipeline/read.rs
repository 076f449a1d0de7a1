//! Reading a pipeline: grammar first, then meaning, with a caret for each
//! mistake.

use super::token::PipelineToken;
use super::{DEEPEST, DEFAULT_ROUNDS, PassStep, Pipeline, PipelineStep, ROUNDS};
use crate::options::OptionError;
use crate::pass::first_line;
use crate::pass::{PassInfo, Registry};
use lalrpop_util::{ParseError, lalrpop_mod};
use logos::Logos;
use robovec_ir::diagnostic::{Diagnostic, Label, Report, did_you_mean};
use std::ops::Range;

lalrpop_mod!(
    #[allow(
        clippy::all,
        clippy::restriction,
        missing_docs,
        unreachable_pub,
        unused
    )]
    grammar,
    "/pipeline/grammar.rs"
);

/// Mistakes of a pipeline, with the text they are in.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}", .0.render_plain())]
pub struct PipelineError(pub Report);

/// The name under which messages show the pipeline's text.
const TEXT_NAME: &str = "<-passes>";

/// Longest pipeline text accepted, in bytes.
const LONGEST: usize = 1 << 20;

impl Registry {
    /// Reads a pipeline of these passes.
    ///
    /// # Errors
    ///
    /// Fails when the text does not follow the grammar, names a pass, preset or
    /// option that does not exist, or gives an option a value it cannot take.
    pub fn pipeline(&'static self, text: &str) -> Result<Pipeline, PipelineError> {
        parse(text, self)
    }
}

fn parse(text: &str, registry: &'static Registry) -> Result<Pipeline, PipelineError> {
    let mut builder = PipelineBuilder::new(registry);
    if text.len() > LONGEST {
        builder.error(0..0, "a pipeline of more than a megabyte is a mistake");
    } else {
        builder.read(text);
    }
    if builder.diagnostics.is_empty() {
        Ok(Pipeline {
            steps: builder.steps,
            registry,
        })
    } else {
        let diagnostics = builder.diagnostics;
        Err(PipelineError(Report::of(TEXT_NAME, text, diagnostics)))
    }
}

pub(crate) struct WrittenOption {
    pub(super) span: Range<usize>,
    pub(super) name: String,
    pub(super) value: Option<String>,
}

pub(crate) struct PipelineBuilder {
    registry: &'static Registry,
    steps: Vec<PipelineStep>,
    depth: usize,
    /// Set while the text of a preset is read: where the preset is used.
    inside: Option<Range<usize>>,
    diagnostics: Vec<Diagnostic>,
}

impl PipelineBuilder {
    fn new(registry: &'static Registry) -> PipelineBuilder {
        PipelineBuilder {
            registry,
            steps: Vec::new(),
            depth: 0,
            inside: None,
            diagnostics: Vec::new(),
        }
    }

    fn read(&mut self, text: &str) {
        let tokens = PipelineToken::lexer(text)
            .spanned()
            .map(|(token, span)| match token {
                Ok(token) => Ok((span.start, token, span.end)),
                Err(()) => Err(span),
            });
        let result = grammar::PipelineParser::new().parse(self, tokens);
        let Err(error) = result else { return };
        match error {
            ParseError::User { error: span } => {
                self.error(span, "this character is not allowed in a pipeline");
            }
            ParseError::UnrecognizedToken {
                token: (start, _, end),
                expected,
            } => {
                self.expected(start..end, &expected);
            }
            ParseError::UnrecognizedEof { location, expected } if !text.trim().is_empty() => {
                self.expected(location..location, &expected);
            }
            ParseError::UnrecognizedEof { location, .. } => {
                self.error(location..location, "the pipeline is empty");
            }
            ParseError::InvalidToken { location } => {
                self.error(
                    location..location,
                    "this character is not allowed in a pipeline",
                );
            }
            ParseError::ExtraToken {
                token: (start, _, end),
            } => {
                self.error(start..end, "the pipeline ends before this");
            }
        }
    }

    fn expected(&mut self, span: Range<usize>, expected: &[String]) {
        let wanted: Vec<String> = expected
            .iter()
            .map(|token| match token.trim_matches('"') {
                "word" => "a name".to_owned(),
                "quoted" => "a quoted text".to_owned(),
                other => format!("'{other}'"),
            })
            .collect();
        self.error(span, &format!("expected {}", wanted.join(" or ")));
    }

    fn error(&mut self, span: Range<usize>, message: &str) -> &mut Diagnostic {
        let span = self.inside.clone().unwrap_or(span);
        self.diagnostics.push(
            Diagnostic::error()
                .with_message(message)
                .with_labels(vec![Label::primary(0, span)]),
        );
        let last = self.diagnostics.len() - 1;
        &mut self.diagnostics[last]
    }

    pub(super) fn pass(&mut self, span: Range<usize>, name: &str, settings: Vec<WrittenOption>) {
        let Some(info) = self.registry.find(name) else {
            let message = if name == "fixpoint" {
                "'fixpoint' needs a group of passes: fixpoint(fold,cse)".to_owned()
            } else {
                format!("there is no pass '{name}'")
            };
            let start = span.start;
            let notes = unknown_pass_notes(name, self.registry);
            self.error(start..start + name.len(), &message).notes = notes;
            return;
        };
        let mut options: Vec<(String, String)> = Vec::new();
        for setting in settings {
            self.option(info, &mut options, setting);
        }
        let span = self.inside.clone().unwrap_or(span);
        self.steps.push(PipelineStep::Pass(PassStep {
            info,
            options,
            span,
        }));
    }

    fn option(
        &mut self,
        info: &'static PassInfo,
        options: &mut Vec<(String, String)>,
        setting: WrittenOption,
    ) {
        let flag = setting.value.is_none();
        let written = setting.value.unwrap_or_else(|| "true".to_owned());
        if options.iter().any(|(name, _)| *name == setting.name) {
            let message = format!("option '{}' is given twice", setting.name);
            self.error(setting.span, &message);
            return;
        }
        let pair = (setting.name.clone(), written);
        match (info.build)(std::slice::from_ref(&pair)) {
            Ok(_) => options.push(pair),
            Err(OptionError::Unknown(name)) => {
                let message = format!("the pass '{}' has no option '{name}'", info.name);
                let notes = option_notes(info, Some(&name));
                self.error(setting.span, &message).notes = notes;
            }
            Err(OptionError::Value { name, reason }) => {
                let message = if flag {
                    format!("option '{name}' of '{}' needs a value", info.name)
                } else {
                    format!("option '{name}' of '{}': {reason}", info.name)
                };
                let notes = option_notes(info, None);
                self.error(setting.span, &message).notes = notes;
            }
        }
    }

    pub(super) fn preset(&mut self, span: Range<usize>, name: &str) {
        let Some(preset) = self.registry.preset(name) else {
            let presets = self.registry.presets;
            let known = presets.iter().map(|preset| preset.name);
            let mut notes = suggestion(name, known, "$");
            let list: Vec<String> = presets
                .iter()
                .map(|preset| format!("${} = {}", preset.name, preset.pipeline))
                .collect();
            notes.push(format!("presets: {}", list.join("; ")));
            self.error(span, &format!("there is no preset '${name}'"))
                .notes = notes;
            return;
        };
        let outer = self.inside.replace(span);
        self.read(preset.pipeline);
        self.inside = outer;
    }

    pub(super) fn open(&mut self, span: Range<usize>, name: &str, settings: Vec<WrittenOption>) {
        self.depth += 1;
        if self.depth == DEEPEST + 1 {
            self.error(span.clone(), &format!("groups nest at most {DEEPEST} deep"));
        }
        if name != "fixpoint" {
            let message = format!("only 'fixpoint' takes a group of passes, not '{name}'");
            self.error(span, &message);
            return;
        }
        let mut max = DEFAULT_ROUNDS;
        for setting in settings {
            let rounds = setting.value.as_deref().map(|text| ROUNDS.read_whole(text));
            match (setting.name.as_str(), rounds) {
                ("max", Some(Ok(rounds))) => max = rounds as u32,
                ("max", Some(Err(reason))) => {
                    let message = format!("option 'max' of 'fixpoint': {reason}");
                    self.error(setting.span, &message);
                }
                ("max", None) => {
                    self.error(setting.span, "option 'max' of 'fixpoint' needs a value");
                }
                (other, _) => {
                    let message = format!("'fixpoint' has no option '{other}'");
                    self.error(setting.span, &message).notes =
                        vec!["options: max=<integer> (default 8)".to_owned()];
                }
            }
        }
        self.steps.push(PipelineStep::Open { max });
    }

    pub(super) fn close(&mut self) {
        self.depth -= 1;
        self.steps.push(PipelineStep::Close);
    }
}

fn suggestion<'a>(
    word: &str,
    known: impl IntoIterator<Item = &'a str>,
    prefix: &str,
) -> Vec<String> {
    did_you_mean(word, known)
        .map(|near| format!("did you mean '{prefix}{near}'?"))
        .into_iter()
        .collect()
}

fn unknown_pass_notes(name: &str, registry: &Registry) -> Vec<String> {
    let names: Vec<&str> = registry.passes.iter().map(|info| info.name).collect();
    let mut notes = suggestion(name, names.iter().copied(), "");
    if registry.preset(name).is_some() {
        notes.push(format!("'{name}' is a preset: write '${name}'"));
    }
    notes.push(format!("passes: {}", names.join(", ")));
    notes
}

fn option_notes(info: &PassInfo, misspelt: Option<&str>) -> Vec<String> {
    let known = info.options.iter().map(|option| option.name);
    let mut notes = match misspelt {
        Some(name) => suggestion(name, known, ""),
        None => Vec::new(),
    };
    if info.options.is_empty() {
        notes.push(format!("'{}' has no options", info.name));
    }
    for option in info.options {
        notes.push(format!(
            "{}=<{}> (default {}): {}",
            option.name,
            option.type_text(),
            (option.default)(),
            first_line(option.documentation),
        ));
    }
    notes
}
