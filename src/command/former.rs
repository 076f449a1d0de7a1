//! Former commands, answered with the present ones.

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Command lines of former versions, each with the one that has the same results.
pub const FORMER: [(&str, &str); 15] = [
    ("accuracy FILE…", "error FILE… --passes '$shorten'"),
    ("accuracy FILE… --outputs", "error FILE…"),
    ("equilibrium MODEL", "sim equilibrium MODEL"),
    ("errors FILE", "error FILE… --blame"),
    ("errors FILE --method interval", "error FILE… --prove"),
    ("front SUBJECT…", "explore SUBJECT…"),
    ("modal MODEL", "sim modal MODEL"),
    ("neglect SCENE", "fit SCENE --reduce"),
    ("scene SCENE", "fit SCENE --explain"),
    ("simulate FOLDER", "rtl simulate FOLDER"),
    ("study", "explore --plan thesis"),
    ("sweep SUBJECT…", "explore SUBJECT… --designs"),
    ("synthesise", "rtl synthesise"),
    ("trig FILE…", "error FILE… --series"),
    (
        "write FILE… --language LANGUAGE",
        "gen FILE… --language LANGUAGE",
    ),
];

/// The error of the command line, with advice where it names a former command.
pub(super) fn answer(mut error: clap::Error) -> clap::Error {
    let name = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(name)) if error.kind() == ErrorKind::InvalidSubcommand => name,
        Some(_) | None => return error,
    };
    let is_it = |(line, _): &&(&str, &str)| line.split(' ').next() == Some(name);
    let advice: Vec<_> = FORMER
        .iter()
        .filter(is_it)
        .map(|(line, now)| format!("robovec {line} is now: robovec {now}").into())
        .collect();
    if !advice.is_empty() {
        error.remove(ContextKind::SuggestedSubcommand);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(advice));
    }
    error
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn former_names_are_answered_with_commands_that_are_there() {
        let [_, tool] = crate::command::commands();
        for (line, now) in FORMER {
            let name = line.split(' ').next().expect("a split has a first part");
            let error = tool.clone().try_get_matches_from(["robovec", name]);
            let told = answer(error.expect_err("a former name")).to_string();
            assert!(told.contains(&format!("is now: robovec {now}")), "{told}");
            let mut command = &tool;
            for word in now.split(' ') {
                if let Some(inner) = command.find_subcommand(word) {
                    command = inner;
                } else if let Some(long) = word.strip_prefix("--") {
                    let mut flags = command.get_arguments();
                    assert!(flags.any(|flag| flag.get_long() == Some(long)), "{now}");
                }
            }
            assert_ne!(command.get_name(), tool.get_name(), "{now}");
        }
    }
}
