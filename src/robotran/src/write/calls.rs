//! Calls of user functions, in the words of each language.

use super::error::RobotranWriteError;
use super::names::is_word;
use crate::Language;
use robovec_ir::{Boundary, Function};

/// The user function a call names, as a language calls it: C's
/// `user_ExtForces` is Matlab's `usrfun.fext` and Python's
/// `s.user_ExtForces`.
pub(super) fn callee(call: &Boundary, language: Language) -> Option<String> {
    let name = match call.callee.strip_prefix("usrfun.") {
        Some("fext") => "user_ExtForces".to_owned(),
        Some("flink") => "user_LinkForces".to_owned(),
        Some(other) if other.starts_with("user_") => other.to_owned(),
        Some(other) => format!("user_{other}"),
        None => call.callee.clone(),
    };
    let bare = name.strip_prefix("user_").filter(|bare| !bare.is_empty());
    if bare.is_none() || !is_word(&name) {
        return None;
    }
    // The C of the reduced accelerations calls through `user_call_…`.
    let plain = name.replacen("user_call_", "user_", 1);
    Some(match (language, plain.as_str()) {
        (Language::C, _) => name,
        (Language::Matlab, "user_ExtForces") => "usrfun.fext".to_owned(),
        (Language::Matlab, "user_LinkForces") => "usrfun.flink".to_owned(),
        (Language::Matlab, _) => format!("usrfun.{plain}"),
        (Language::Python, _) => format!("s.{plain}"),
    })
}

/// The statement of a call, without its end.
pub(super) fn statement(
    function: &Function,
    call: &Boundary,
    language: Language,
) -> Result<String, RobotranWriteError> {
    let refuse = || RobotranWriteError::Call {
        function: function.name.clone(),
        callee: call.callee.clone(),
    };
    let callee = callee(call, language).ok_or_else(refuse)?;
    let mut arguments = Vec::new();
    for argument in &call.arguments {
        let number = !argument.is_empty() && argument.bytes().all(|byte| byte.is_ascii_digit());
        if !is_word(argument) && !number {
            return Err(refuse());
        }
        arguments.push(argument.as_str());
    }
    let result = match &call.result {
        Some(result) if !is_word(result) => return Err(refuse()),
        Some(result) => format!("{result} = "),
        None => String::new(),
    };
    Ok(format!("{result}{callee}({})", arguments.join(",")))
}
