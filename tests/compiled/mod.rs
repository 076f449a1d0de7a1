//! Files of equations compiled by gcc and called at states that depend on the
//! names of the inputs alone, beside robovec's evaluation at the same states:
//! the same bits, or a difference that is described.
//!
//! Many files go into one program, because starting a compiler for each would
//! take longer than all the rest.

mod callable;
mod differences;
mod octave;
mod program;
mod python;

use self::callable::callable;
use self::differences::differences;
pub(crate) use self::octave::compare_octave;
use self::program::Program;
pub(crate) use self::python::compare_python;

use robovec::robotran::{Language, read};
use robovec_ir::View;
use std::path::PathBuf;
use std::process::Command;

/// Arrays of the compiled program have this many elements in each direction,
/// element 0 included, unless a test needs more.
pub(crate) const EXTENT: u32 = 48;

const STATES: u64 = 2;

/// A file of equations.
pub(crate) struct Subject {
    /// Title in messages, and the text its kind is read from.
    pub(crate) name: String,
    pub(crate) text: String,
}

/// Outcome of a file in gcc and in robovec.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Outcome {
    /// robovec refuses it, with this message.
    Refused(String),
    /// gcc refuses it, robovec reads it.
    OnlyRead,
    /// robovec reads it, but only a part of it is a function, or an array is
    /// larger than those of the program.
    NotCompared,
    /// Number of numbers that are the same.
    Equal(usize),
    /// A number differs.
    Differs(String),
}

/// True when there is a gcc; prints a remark otherwise.
pub(crate) fn has_gcc() -> bool {
    let found = Command::new("gcc").arg("--version").output().is_ok();
    if !found {
        eprintln!("no gcc: nothing is compared with it");
    }
    found
}

/// The number of an element in a state; the compiled program has the same.
pub(crate) fn number(state: u64, name: &str, i: u32, j: u32) -> f64 {
    let mut x = 1_469_598_103_934_665_603_u64.wrapping_add(state);
    for byte in name.bytes() {
        x = (x ^ u64::from(byte)).wrapping_mul(1_099_511_628_211);
    }
    x = x.wrapping_add(u64::from(i).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    x = x.wrapping_add(u64::from(j).wrapping_mul(0xc2b2_ae3d_27d4_eb4f));
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 31;
    ((x >> 11) as f64 + 0.5) / (1u64 << 52) as f64 - 1.0
}

/// Reads and compiles the files, calls them, and compares.
pub(crate) fn compare(subjects: &[Subject], headers: &[PathBuf]) -> Vec<Outcome> {
    compare_within(EXTENT, subjects, headers)
}

/// The same with arrays of any number of elements in each direction.
pub(crate) fn compare_within(
    extent: u32,
    subjects: &[Subject],
    headers: &[PathBuf],
) -> Vec<Outcome> {
    let mut outcomes = vec![Outcome::NotCompared; subjects.len()];
    let mut callables = Vec::new();
    for (subject, Subject { name, text }) in subjects.iter().enumerate() {
        match read(name, text.as_bytes(), Some(Language::C)) {
            Err(error) => {
                let text = error.report.render_plain();
                let first = text.lines().next().unwrap_or_default();
                outcomes[subject] = Outcome::Refused(first.to_owned());
            }
            Ok(read) => callables.extend(callable(subject, read.module, text, extent)),
        }
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let program = Program {
        folder: folder.path(),
        headers,
        extent,
    };
    program.write_files(subjects, &callables);
    let refused = program.refused(&callables);
    callables.retain(|callable| {
        let kept = !refused.contains(&callable.subject);
        if !kept {
            outcomes[callable.subject] = Outcome::OnlyRead;
        }
        kept
    });
    if callables.is_empty() {
        return outcomes;
    }
    let calls = program.calls(subjects, &callables);
    let found = program.run();
    for callable in &callables {
        outcomes[callable.subject] = Outcome::Equal(0);
    }
    for (call, &(place, function)) in calls.iter().enumerate() {
        let callable = &callables[place];
        let view = View {
            tables: &callable.module.tables,
            function: &callable.module.functions[function],
        };
        for state in 1..=STATES {
            let Outcome::Equal(count) = &mut outcomes[callable.subject] else {
                continue;
            };
            let compared = found.get(&(state, call));
            match compared.map(|changed| differences(view, state, changed)) {
                None => outcomes[callable.subject] = Outcome::OnlyRead,
                Some(Ok(equal)) => *count += equal,
                Some(Err(difference)) => outcomes[callable.subject] = Outcome::Differs(difference),
            }
        }
    }
    outcomes
}
