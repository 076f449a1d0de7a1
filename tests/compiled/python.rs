//! Files of Python, called at the same states.

use super::callable::{callable, case_of, kind_of};
use super::differences::differences;
use super::program::parse_changes;
use super::{EXTENT, Outcome, STATES, Subject};
use robovec::robotran::{Language, read};
use robovec_ir::View;
use std::fmt::Write;
use std::process::Command;

/// Runs files of Python at the same states and compares; files that Python
/// refuses are [`Outcome::OnlyRead`].
pub(crate) fn compare_python(subjects: &[Subject]) -> Vec<Outcome> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let script = folder.path().join("run.py");
    std::fs::write(&script, include_str!("run.py")).expect("a temporary file");
    let mut outcomes = vec![Outcome::NotCompared; subjects.len()];
    let (mut list, mut calls) = (String::new(), Vec::new());
    for (subject, Subject { name, text }) in subjects.iter().enumerate() {
        let module = match read(name, text.as_bytes(), Some(Language::Python)) {
            Err(error) => {
                let text = error.report.render_plain();
                let first = text.lines().next().unwrap_or_default();
                outcomes[subject] = Outcome::Refused(first.to_owned());
                continue;
            }
            Ok(read) => read.module,
        };
        let Some(callable) = callable(subject, module, text, EXTENT) else {
            continue;
        };
        outcomes[subject] = Outcome::Equal(0);
        let file = folder.path().join(format!("file_{subject}.py"));
        std::fs::write(&file, text).expect("a temporary file");
        let function = kind_of(&callable.module.functions[0]);
        for (index, case) in callable.module.functions.iter().map(case_of).enumerate() {
            for state in 1..=STATES {
                let call = calls.len();
                writeln!(list, "{state} {call} {} {function} {case}", file.display())
                    .expect("a string");
            }
            calls.push((callable.module.clone(), subject, index));
        }
    }
    let input = folder.path().join("calls");
    std::fs::write(&input, list).expect("a temporary file");
    let output = Command::new("python3")
        .arg(&script)
        .stdin(std::fs::File::open(&input).expect("a temporary file"))
        .output()
        .expect("python3 is there");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let found = parse_changes(&String::from_utf8_lossy(&output.stdout));
    for (call, (module, subject, index)) in calls.iter().enumerate() {
        for state in 1..=STATES {
            let view = View {
                tables: &module.tables,
                function: &module.functions[*index],
            };
            let Outcome::Equal(count) = &mut outcomes[*subject] else {
                continue;
            };
            match found
                .get(&(state, call))
                .map(|changed| differences(view, state, changed))
            {
                None => outcomes[*subject] = Outcome::OnlyRead,
                Some(Ok(equal)) => *count += equal,
                Some(Err(difference)) => outcomes[*subject] = Outcome::Differs(difference),
            }
        }
    }
    outcomes
}
