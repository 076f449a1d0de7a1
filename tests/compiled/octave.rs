//! Files of Matlab, called by Octave at the same states.

use super::differences::differences;
use super::program::{Changes, parse_changes};
use super::{Outcome, STATES, Subject};
use robovec::robotran::{Language, read};
use robovec_ir::View;
use std::process::Command;

/// Runs functions `invdyna` of Matlab in Octave at the same states.
pub(crate) fn compare_octave(subjects: &[Subject]) -> Vec<Outcome> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut outcomes = Vec::new();
    let (mut names, mut modules) = (Vec::new(), Vec::new());
    for (subject, Subject { name, text }) in subjects.iter().enumerate() {
        match read(name, text.as_bytes(), Some(Language::Matlab)) {
            Err(error) => {
                let text = error.report.render_plain();
                let first = text.lines().next().unwrap_or_default();
                outcomes.push(Outcome::Refused(first.to_owned()));
            }
            Ok(read) => {
                outcomes.push(Outcome::Equal(0));
                let file = folder.path().join(format!("file_{subject}.m"));
                // A script file: its first statement is no function.
                std::fs::write(&file, format!("1;\n{text}\nend\n")).expect("a temporary file");
                names.push(format!("'{}'", file.display()));
                modules.push((subject, read.module));
            }
        }
    }
    let script = format!(
        "STATES = {STATES}; EXTENT = 9; NAMES = {{{}}};\n{}",
        names.join(", "),
        include_str!("run.m")
    );
    let file = folder.path().join("run.m");
    std::fs::write(&file, script).expect("a temporary file");
    let output = Command::new("octave-cli")
        .args(["--no-init-file", "--quiet"])
        .arg(&file)
        .output()
        .expect("octave is there");
    let text = String::from_utf8_lossy(&output.stdout);
    let ours: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("> "))
        .collect();
    let found = parse_changes(&ours.join("\n"));
    for (call, (subject, module)) in modules.iter().enumerate() {
        for state in 1..=STATES {
            let view = View {
                tables: &module.tables,
                function: &module.functions[0],
            };
            let Outcome::Equal(count) = &mut outcomes[*subject] else {
                continue;
            };
            match found.get(&(state, call)) {
                None => outcomes[*subject] = Outcome::OnlyRead,
                Some(changed) => match same_outputs(view, state, changed) {
                    Ok(equal) => *count += equal,
                    Err(difference) => outcomes[*subject] = Outcome::Differs(difference),
                },
            }
        }
    }
    outcomes
}

/// Compares the elements that robovec sets with those Octave gives back.
fn same_outputs(view: View<'_>, state: u64, results: &Changes) -> Result<usize, String> {
    let outputs = view.function.assignments.iter().map(|assignment| {
        let (_, indices, _) = view.function.output_element(assignment.output);
        ("Qq".to_owned(), indices[0], 0)
    });
    let set: Vec<_> = outputs.collect();
    let mut given = results.clone();
    // What the function does not set is zero in Octave.
    given.retain(|key, _| set.contains(key));
    differences(view, state, &given)
}
