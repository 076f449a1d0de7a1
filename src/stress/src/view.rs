//! Findings as text, table, figure and page.

use super::{CaseClass, Findings, LoopStabilisation, ProgramTreatment, StressCase, StressVerdict};
use robovec_ir::Format;
use robovec_ir::diagnostic::counted;
use robovec_present::number::or_dash;
use robovec_present::text::cut;
use robovec_present::{DataCell, DataTable, text_lines};

/// A case with its findings.
pub type CaseFinding<'a> = (&'a StressCase, Findings);

/// Number of cases that a cure brings near binary64, or that need none.
pub fn headline(findings: &[CaseFinding<'_>]) -> String {
    let count = |is_in: fn(&Findings) -> bool| {
        let own = findings.iter().filter(|(_, found)| is_in(found));
        own.count()
    };
    let all = counted(findings.len(), "case");
    if findings.iter().all(|(_, found)| found.trials.is_empty()) {
        let fine = count(|found| found.verdict == StressVerdict::Fine);
        return format!("{fine} of {all} fine in binary32");
    }
    let cured = count(|found| found.cure.is_some());
    format!("{cured} of {all} cured to within ten times the error of f64")
}

/// Lines with labels: cases by verdict, by class, and the median cost of cures.
pub fn lines(findings: &[CaseFinding<'_>]) -> Vec<(&'static str, String)> {
    let verdicts = StressVerdict::ALL.into_iter().filter_map(|verdict| {
        let own = findings.iter();
        let count = own.filter(|(_, found)| found.verdict == verdict).count();
        (count > 0).then(|| format!("{} {count}", verdict.name()))
    });
    let mut lines = vec![("in binary32", verdicts.collect::<Vec<_>>().join(", "))];
    let cures = findings.iter().filter_map(|(_, found)| found.cure());
    let mut costs: Vec<f64> = cures.map(|trial| trial.cost).collect();
    costs.sort_by(f64::total_cmp);
    if let (Some(least), Some(most)) = (costs.first(), costs.last()) {
        let middle = costs[costs.len() / 2];
        let unit = "times the operations' cells in binary32";
        let text = match costs.len() {
            1 => format!("{least:.2} {unit}"),
            _ => format!("{least:.2} to {most:.2} {unit}, median {middle:.2}"),
        };
        lines.push(("cost", text));
        let classes = by_class(findings).map(|(class, own)| {
            let cured = own.iter().filter(|(_, found)| found.cure.is_some());
            format!("{} {} of {}", class.name, cured.count(), own.len())
        });
        lines.push(("cured", classes.collect::<Vec<_>>().join(", ")));
    }
    lines
}

/// Maximum number of rows on the terminal.
const SHOWN: usize = 10;
/// Maximum number of characters of a case and of a cure there.
const NAMES: [usize; 2] = [20, 16];

/// The cases with the largest errors in binary32, in 80 columns.
pub fn worst(findings: &[CaseFinding<'_>]) -> String {
    let mut order: Vec<&CaseFinding<'_>> = findings.iter().collect();
    let error = |found: &Findings| match found.short.error {
        error if error.is_nan() => f64::INFINITY,
        error => error,
    };
    order.sort_by(|(_, a), (_, b)| error(b).total_cmp(&error(a)));
    let rows = order.into_iter().take(SHOWN).map(|(case, found)| {
        let cure = found.cure();
        vec![
            cut(&case.name, NAMES[0]),
            short(found.short.error),
            short(found.long.error),
            found.verdict.to_string(),
            or_dash(cure, |trial| cut(&trial.label, NAMES[1])),
            or_dash(cure, |trial| short(trial.measured.error)),
        ]
    });
    let head = "case | >f32 | >f64 | verdict | cheapest cure | >after";
    text_lines(head, &rows.collect::<Vec<_>>())
}

/// The findings as an aligned table, without cures where none were tried.
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
            let untreated = &found.untreated;
            error_of(
                found,
                &untreated.with(|it| (it.compensated, it.state) = (compensated, state)),
            )
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

/// Gaps of the loops of each case, by the method that closes them, if any.
pub fn gaps(findings: &[CaseFinding<'_>]) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (case, found) in findings {
        if case.class.name != "drift" || found.trials.is_empty() {
            continue;
        }
        let mut row = vec![case.name.clone()];
        for stabilisation in LoopStabilisation::ALL {
            for format in [Format::BINARY32, Format::BINARY64] {
                let wanted = found.untreated.with(|it| {
                    (it.stabilisation, it.format) = (stabilisation, format);
                });
                let untreated = (wanted == found.untreated).then_some(found.short.error);
                row.push(or_dash(error_of(found, &wanted).or(untreated), short));
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

/// The error of a treatment that was tried.
fn error_of(found: &Findings, treatment: &ProgramTreatment) -> Option<f64> {
    let mut trials = found.trials.iter();
    let trial = trials.find(|trial| trial.treatment == *treatment)?;
    Some(trial.measured.error)
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
                DataCell::text(case.class.name),
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
