//! Reasons why a statement could not be read, in words.

use super::token::{LexicalError, RobotranToken, SourceSpan};
use super::tokens::SpannedToken;
use lalrpop_util::ParseError;
use robovec_ir::diagnostic::{Diagnostic, Label};

/// The message about a statement refused; `previous`: the token before.
pub(super) fn explain(
    error: ParseError<u32, RobotranToken, LexicalError>,
    previous: Option<SpannedToken>,
    text: &str,
) -> Diagnostic {
    match error {
        ParseError::User { error } => refusal(error.message(), error.span, "", error.note()),
        ParseError::InvalidToken { location } | ParseError::UnrecognizedEof { location, .. } => {
            cut(location, previous)
        }
        ParseError::ExtraToken { token } | ParseError::UnrecognizedToken { token, .. } => {
            misfit(token, previous, text)
        }
    }
}

pub(super) fn refusal(message: &str, span: SourceSpan, label: &str, note: &str) -> Diagnostic {
    Diagnostic::error()
        .with_message(message)
        .with_labels(vec![Label::primary(0, span.range()).with_message(label)])
        .with_note(note)
}

fn cut(location: u32, previous: Option<SpannedToken>) -> Diagnostic {
    let (start, end) = previous.map_or((location, location), |(start, _, end)| (start, end));
    refusal(
        "the file ends in the middle of a statement",
        SourceSpan { start, end },
        "nothing follows",
        "the file is cut short; generate or copy it again",
    )
}

fn misfit(
    (start, token, end): SpannedToken,
    previous: Option<SpannedToken>,
    text: &str,
) -> Diagnostic {
    let span = SourceSpan { start, end };
    let found = text.get(span.range()).unwrap_or_default();
    let before = previous.map(|(_, token, _)| token);
    let (message, label, note): (String, &str, &str) = match (before, token) {
        (Some(RobotranToken::Equals), RobotranToken::End) => (
            "an equation without a right side".to_owned(),
            "an expression is missing before this",
            "complete the equation, or delete it if nothing reads its name",
        ),
        (
            Some(
                RobotranToken::Plus
                | RobotranToken::Minus
                | RobotranToken::Star
                | RobotranToken::Slash,
            ),
            RobotranToken::End,
        ) => (
            "the expression ends after an operator".to_owned(),
            "an operand is missing before this",
            "the statement is cut short, or a line break needs `...` (Matlab) or `\\` (Python)",
        ),
        (_, RobotranToken::End) => (
            "the statement ends too early".to_owned(),
            "something is missing before this",
            "look for a parenthesis that is not closed, or an operand that is not there",
        ),
        (_, RobotranToken::Refused) => (
            format!("`{found}` is not understood"),
            "jumps and counted loops cannot be compiled",
            "write the iterations out as equations",
        ),
        (Some(RobotranToken::Name(_)), RobotranToken::Open | RobotranToken::BracketOpen) => (
            "a call or an index that is not a plain number".to_owned(),
            "in an expression only sin, cos and sqrt may be called, and indices must be plain numbers",
            "a user function must be alone on the right side (`F = user_LinkForces(...)`)",
        ),
        (_, RobotranToken::Equals) => (
            "`=` after something that cannot be assigned to".to_owned(),
            "its left side must be a name or an array element",
            "check that the statement before ends correctly",
        ),
        (_, RobotranToken::Other) => (
            format!("`{found}` is not understood"),
            operator_label(found),
            operator_note(found),
        ),
        (
            Some(
                RobotranToken::Name(_)
                | RobotranToken::Element(_)
                | RobotranToken::Number(_)
                | RobotranToken::Close,
            ),
            RobotranToken::Name(_) | RobotranToken::Element(_),
        ) => (
            format!("`{found}` follows an operand"),
            "an operator or the end of the statement is missing before this",
            "a statement ends with `;` in C, with `;` and a line end in Matlab, with a line end in Python",
        ),
        _ => (
            format!("`{found}` does not fit here"),
            "not expected",
            "only equations, user calls, sensor cases and Robotran's prologue are understood",
        ),
    };
    refusal(&message, span, label, note)
}

fn operator_label(found: &str) -> &'static str {
    match found {
        "^" | "**" => "there are no powers",
        "+=" | "-=" | "*=" | "/=" | "++" | "--" => "there are no combined assignments",
        "?" | "<" | ">" | "==" | "!=" | "<=" | ">=" | "&&" | "||" | "!" => {
            "there are no comparisons in equations"
        }
        _ => "this has no meaning here",
    }
}

fn operator_note(found: &str) -> &'static str {
    match found {
        "^" | "**" => "write a product: `a*a`",
        "+=" | "-=" | "*=" | "/=" | "++" | "--" => "write the assignment out: `a = a + b`",
        _ => "an equation has `+ - * /`, parentheses, sin, cos and sqrt",
    }
}
