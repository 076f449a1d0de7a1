//! Warnings of laws that a run accepts and a user may not mean.

use robovec_dynamics::motion::Laws;
use robovec_ir::diagnostic::{Diagnostic, Report};
use robovec_model::Model;

/// Maximum number of names of a kind in a warning.
const SHOWN_NAMES: usize = 8;

/// The first names of a kind, as words; `None` where there are none.
fn listed(kind: &str, names: &[&str]) -> Option<String> {
    let rest = names.len().saturating_sub(SHOWN_NAMES);
    let shown = names[..names.len() - rest].join(", ");
    match (names.is_empty(), rest) {
        (true, _) => None,
        (false, 0) => Some(format!("{kind} {shown}")),
        (false, rest) => Some(format!("{kind} {shown} and {rest} more")),
    }
}

/// Warnings of links and external forces that no law makes different from
/// zero, and of tyres on bodies that are no wheels.
pub(super) fn of_laws(model: &Model, laws: &Laws) -> Report {
    let mut report = Report::new();
    let mut warn = |message: String, note: &str| {
        let warning = Diagnostic::warning().with_message(message);
        report.push(warning.with_notes(vec![note.to_owned()]));
    };
    let links = model.links.iter().zip(&laws.links);
    let links = links.filter(|(_, law)| !law.acts());
    let links: Vec<&str> = links.map(|(link, _)| link.name.as_str()).collect();
    let (mut zero, mut locked): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
    for (index, (force, law)) in model.forces.iter().zip(&laws.forces).enumerate() {
        if !law.acts() {
            zero.push(&force.name);
        }
        let tyre = law.tyre.as_ref();
        if tyre.is_some_and(|tyre| !tyre.turns(model, index)) {
            locked.push(&force.name);
        }
    }
    let both = [listed("links", &links), listed("external forces", &zero)];
    let both: Vec<String> = both.into_iter().flatten().collect();
    if !both.is_empty() {
        warn(
            format!("zero, since no law acts on them: {}", both.join("; ")),
            "help: give laws with --laws: [[link]], [[force]], [[contact]], [[tyre]]",
        );
    }
    if let Some(list) = listed("tyres", &locked) {
        warn(
            format!("no joint turns their bodies about the axes of these wheels: {list}"),
            "help: the external force of a tyre belongs to the body that spins; these wheels \
             slide as if they were locked",
        );
    }
    report
}
