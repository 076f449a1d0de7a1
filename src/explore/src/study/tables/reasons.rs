//! Reasons why a row of Table 3.1 differs from the thesis', with figures.

use super::super::plan::{Printed, StudySubject};
use super::super::printed::{PrintedSystem, SystemTopology, thesis};
use super::super::program::ProgramFacts;
use super::super::results::StudiedProgram;
use crate::captions;
use robovec_present::number::or_nothing;

/// Reason why a row of a program differs from the thesis'.
pub(super) fn of(program: &StudiedProgram<'_>) -> String {
    let Some(system) = program.results.system(program.place[0]) else {
        return String::new();
    };
    let reason = match program.pipeline().printed {
        None => return "the thesis has no row for this pipeline".to_owned(),
        Some(Printed::Modified) if system.modified.is_none() => {
            return "the thesis changed only the bogie and the 23- and 50-dof systems by hand"
                .to_owned();
        }
        Some(Printed::Modified) => modified(system, program),
        Some(Printed::Original) => original(system, program.subject(), program.facts),
    };
    let remark = program.row().map(|row| row.remark.clone());
    let mut parts = vec![reason, remark.unwrap_or_default()];
    parts.retain(|part| !part.is_empty());
    parts.join("; ")
}

/// Of a system as written.
fn original(system: &PrintedSystem, subject: &StudySubject, facts: &ProgramFacts) -> String {
    let model = built_in(system);
    if subject.source != model {
        return "the equations are of another system than the thesis'".to_owned();
    }
    let text = why(system);
    let share = |operations: f64| format!("{:.1}", per_square(operations, system.dof));
    let words = [
        ("equations", facts.equations.to_string()),
        ("vectors", facts.vectors.to_string()),
        ("ours", share(facts.operations as f64)),
        ("thesis", share(f64::from(system.original.operations))),
        ("range", serial_range()),
    ];
    let words = words.each_ref().map(|(name, word)| (*name, word.as_str()));
    captions::fill(text, &words)
}

/// The text of the reason for a system as written.
fn why(system: &PrintedSystem) -> &'static str {
    let why = &thesis().why;
    let own = why.get(&built_in(system));
    own.unwrap_or_else(|| &why[system.topology.name()])
}

/// Of a system changed by hand in the thesis and by the compiler here.
fn modified(system: &PrintedSystem, program: &StudiedProgram<'_>) -> String {
    let (results, facts) = (program.results, program.facts);
    let [model, _, machine] = program.place;
    let before = results.pipeline(Printed::Original);
    let before = before.and_then(|original| results.program([model, original, machine]));
    let Some(StudiedProgram { facts: before, .. }) = before else {
        return "the compiler's chain beside the thesis' by hand".to_owned();
    };
    let share = |after: f64, before: f64| 100.0 * after / before.max(1.0);
    let mut text = format!(
        "the compiler takes the chain to {:.0} % of the unmodified one",
        share(f64::from(facts.asap_cycle), f64::from(before.asap_cycle))
    );
    if let Some(row) = program.row() {
        text += &format!(
            ", the thesis by hand to {:.0} %",
            share(
                f64::from(row.asap_cycle),
                f64::from(system.original.asap_cycle)
            )
        );
    }
    text + &format!(
        "; it drops leading zeros and shares equal sums, {:+.1} % operations, where the thesis \
         repeats the count of the unmodified system",
        share(facts.operations as f64, before.operations as f64) - 100.0
    )
}

/// The name of our model of a system.
fn built_in(system: &PrintedSystem) -> String {
    match system.topology {
        SystemTopology::Bogie => "bogie".to_owned(),
        SystemTopology::Mixed => "thesis-70".to_owned(),
        SystemTopology::Serial | SystemTopology::SemiSerial | SystemTopology::Parallel => {
            format!("{}-{}", system.topology.name(), system.dof)
        }
    }
}

fn per_square(operations: f64, dof: u32) -> f64 {
    operations / f64::from(dof * dof)
}

/// Least and most operations per dof squared among the thesis' serial rows.
fn serial_range() -> String {
    let serial = thesis()
        .systems
        .iter()
        .filter(|system| system.topology == SystemTopology::Serial);
    let mut shares: Vec<f64> = serial
        .map(|system| per_square(f64::from(system.original.operations), system.dof))
        .collect();
    shares.sort_by(f64::total_cmp);
    let ends = shares.first().zip(shares.last());
    or_nothing(ends, |(low, high)| format!("{low:.1} to {high:.1}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_system_has_a_reason() {
        for system in &thesis().systems {
            assert!(why(system).contains("the"), "{}", system.name);
        }
    }
}
