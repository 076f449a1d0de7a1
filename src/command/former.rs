//! Former commands, answered with the present ones.

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// A command line of former versions.
pub(super) struct FormerCommand {
    pub(super) line: &'static str,
    /// Command line with the same results.
    pub(super) now: &'static str,
    /// Results under other names than before.
    pub(super) results: &'static str,
}

const fn former(line: &'static str, now: &'static str, results: &'static str) -> FormerCommand {
    FormerCommand { line, now, results }
}

pub(super) const FORMER: [FormerCommand; 15] = [
    former(
        "accuracy FILE…",
        "error FILE… --passes '$shorten'",
        "`accuracy.csv`, `.json`, `.svg` are `passes.csv`, `.json`, `.svg`; the errors of every \
         output of the result follow",
    ),
    former(
        "accuracy FILE… --outputs",
        "error FILE…",
        "`--most` is `--top`; with `--passes` the errors after every pass come first",
    ),
    former("equilibrium MODEL", "sim equilibrium MODEL", ""),
    former(
        "errors FILE",
        "error FILE… --blame",
        "`-o` writes `errors.csv`, `errors.json`",
    ),
    former(
        "errors FILE --method interval",
        "error FILE… --prove",
        "with the bound of one state",
    ),
    former(
        "front SUBJECT…",
        "explore SUBJECT…",
        "`front.html`, `.csv`, `.json`, `.svg` are `explore.html`, …",
    ),
    former("modal MODEL", "sim modal MODEL", ""),
    former("neglect SCENE", "fit SCENE --reduce", ""),
    former("scene SCENE", "fit SCENE --explain", ""),
    former("simulate FOLDER", "rtl simulate FOLDER", ""),
    former(
        "study",
        "explore --plan thesis",
        "`--models`, `--pipelines`, `--machines`, `--pe` are subjects, `--passes`, `--machine`, \
         `--elements`; `report.html`, `results.json` are `explore.html`, `explore.json`",
    ),
    former(
        "sweep SUBJECT…",
        "explore SUBJECT… --designs",
        "`sweep.html`, `.csv`, `.json`, `.svg` are `explore.html`, …",
    ),
    former("synthesise", "rtl synthesise", ""),
    former(
        "trig FILE…",
        "error FILE… --series",
        "`--method` is `--polynomials`",
    ),
    former(
        "write FILE… --language LANGUAGE",
        "gen FILE… --language LANGUAGE",
        "",
    ),
];

/// The error of the command line, with advice where it names a former command.
pub(super) fn answer(mut error: clap::Error) -> clap::Error {
    let name = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(name)) if error.kind() == ErrorKind::InvalidSubcommand => name,
        Some(_) | None => return error,
    };
    let is_it = |former: &&FormerCommand| former.line.split(' ').next() == Some(name);
    let advice: Vec<_> = FORMER
        .iter()
        .filter(is_it)
        .map(|former| format!("robovec {} is now: robovec {}", former.line, former.now).into())
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
        for FormerCommand { line, now, .. } in FORMER {
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
