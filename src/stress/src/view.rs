//! Findings as text, table, figure and page.

use super::{CaseClass, Findings, LoopStabilisation, ProgramTreatment, StressCase};
use robovec_ir::Format;
use robovec_ir::diagnostic::counted;
use robovec_present::number::or_dash;
use robovec_present::{DataCell, DataTable, text_lines};

/// A case with what was found.
pub type CaseFinding<'a> = (&'a StressCase, Findings);

/// The findings as an aligned table; without the columns of cures where none
/// were tried.
pub fn text(findings: &[CaseFinding<'_>]) -> String {
    let mut head = "case | >cond | >f32 error | >f64 error | of | verdict".to_owned();
    let tried = findings.iter().any(|(_, found)| !found.trials.is_empty());
    if tried {
        head += " | cheapest cure | >cost | >error after";
        head += " | for f32 results | >cost | >error after";
    }
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (case, findings) in findings {
        let mut row = vec![
            case.name.clone(),
            short(findings.condition),
            short(findings.short.error),
            short(findings.long.error),
            findings.metric.to_owned(),
            findings.verdict.to_string(),
        ];
        for cure in [findings.cure(), findings.short_cure()] {
            row.extend(match cure {
                _ if !tried => Vec::new(),
                None => ["-", "", ""].map(str::to_owned).to_vec(),
                Some(trial) => vec![
                    trial.label.clone(),
                    format!("{:.2}", trial.cost),
                    short(trial.measured.error),
                ],
            });
        }
        rows.push(row);
    }
    text_lines(&head, &rows)
}

/// The step of long simulations against the drift, and the best step in
/// binary32; empty without simulations of energy.
pub fn steps(findings: &[CaseFinding<'_>]) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut best: [Option<(f64, f64)>; 2] = [None, None];
    for (_, found) in findings {
        let Some(step) = found.untreated.step else {
            continue;
        };
        if found.metric != "energy drift" {
            continue;
        }
        // The trials at this step with nothing else changed.
        let trial = |compensated: bool, state: Option<Format>| {
            let wanted = ProgramTreatment {
                compensated,
                state,
                ..found.untreated.clone()
            };
            let trials = found.trials.iter();
            let mut same = trials.filter(|trial| trial.treatment == wanted);
            same.next().map(|trial| trial.measured.error)
        };
        let compensated = trial(true, None);
        for (best, error) in best.iter_mut().zip([Some(found.short.error), compensated]) {
            if let Some(error) = error
                && best.is_none_or(|(_, least)| error < least)
            {
                *best = Some((step, error));
            }
        }
        let cell = |error: Option<f64>| or_dash(error, short);
        rows.push(vec![
            format!("{step:e}"),
            short(found.short.error),
            cell(compensated),
            cell(trial(false, Some(Format::BINARY64))),
            short(found.long.error),
        ]);
    }
    if rows.len() < 2 {
        return String::new();
    }
    let head = ">step (s) | >f32 | >f32, compensated state | >f32, state f64 | >f64";
    let mut text =
        "Energy drift of the double pendulum, relative to its kinetic energy:\n".to_owned();
    text += &text_lines(head, &rows);
    let names = ["in f32", "in f32 with a compensated state"];
    for (name, best) in names.into_iter().zip(best) {
        if let Some((step, error)) = best {
            text += &format!(
                "The best step {name} is {step:e} s, with a drift of {}.\n",
                short(error)
            );
        }
    }
    text
}

/// Gaps of the loops of each case, by the method that keeps them closed; empty
/// without such cases.
pub fn gaps(findings: &[CaseFinding<'_>]) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (case, found) in findings {
        if case.class.name() != "drift" || found.trials.is_empty() {
            continue;
        }
        let mut row = vec![case.name.clone()];
        for stabilisation in LoopStabilisation::ALL {
            for format in [Format::BINARY32, Format::BINARY64] {
                let wanted = ProgramTreatment {
                    stabilisation,
                    format,
                    ..found.untreated.clone()
                };
                let mut trials = found.trials.iter();
                let trial = trials.find(|trial| trial.treatment == wanted);
                let untreated = (wanted == found.untreated).then_some(found.short.error);
                let error = trial.map(|trial| trial.measured.error).or(untreated);
                row.push(or_dash(error, short));
            }
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return String::new();
    }
    let head = "case | >f32 | >f64 | >stabilised f32 | >f64 | >projected f32 | >f64";
    let text = "Gap of the loop, relative to the longest bar:\n".to_owned();
    text + &text_lines(head, &rows)
}

/// Two digits.
pub(super) fn short(number: f64) -> String {
    if number.is_finite() {
        format!("{number:.1e}")
    } else {
        "none".to_owned()
    }
}

/// The findings of every class that has some.
pub(super) fn by_class<'a>(
    findings: &'a [CaseFinding<'a>],
) -> impl Iterator<Item = (CaseClass, Vec<&'a CaseFinding<'a>>)> {
    let classes = CaseClass::ALL.into_iter().map(move |class| {
        let of_class = findings.iter().filter(move |(case, _)| case.class == class);
        (class, of_class.collect::<Vec<_>>())
    });
    classes.filter(|(_, of_class)| !of_class.is_empty())
}

/// Number of cases of each class with each verdict, and the closeness of cures
/// to binary64.
pub fn classes(findings: &[CaseFinding<'_>]) -> String {
    let mut text = String::new();
    for (class, of_class) in by_class(findings) {
        let cured = of_class.iter().filter(|(_, found)| found.cure.is_some());
        text += &format!(
            "{}: {} of {} cured to within ten times the error of f64\n",
            class.name(),
            cured.count(),
            counted(of_class.len(), "case")
        );
    }
    text
}

/// The same for programs: one row for each case and treatment.
pub fn table(findings: &[CaseFinding<'_>]) -> DataTable {
    let number = |number: f64| {
        if number.is_finite() {
            DataCell::text(format!("{number:.3e}"))
        } else {
            DataCell::Empty
        }
    };
    let mut rows = Vec::new();
    for (case, found) in findings {
        let untreated = ("as it is", &found.short, 1.0, false);
        let trials = found.trials.iter().enumerate().map(|(index, trial)| {
            let chosen = found.cure == Some(index);
            (trial.label.as_str(), &trial.measured, trial.cost, chosen)
        });
        for (label, measured, cost, chosen) in std::iter::once(untreated).chain(trials) {
            rows.push(vec![
                DataCell::text(&case.name),
                DataCell::text(case.class.name()),
                DataCell::text(found.metric),
                number(found.condition),
                number(found.floor),
                DataCell::text(found.verdict.name()),
                DataCell::text(label),
                number(measured.error),
                DataCell::number(cost, 3),
                number(measured.outside),
                if chosen {
                    DataCell::text("yes")
                } else {
                    DataCell::Empty
                },
            ]);
        }
    }
    DataTable::new(
        "stress",
        "Hard cases and their cures",
        "Every case as it is in binary32 and under every treatment tried; the cost \
                  is the cells of the operations, those of a product the square of its bits, \
                  relative to the untreated program.",
        "case | class | metric | condition | attainable in f32 | verdict | treatment | \
         error | cost | outside the range | cheapest",
        rows,
    )
}
