//! The report for a user.

mod chart;

use super::error::{ArrayReport, ElementReport, FormatReport, MatrixReport};
use super::records::{CheckErrors, CheckReport, PassReport, RoundingReport};
use super::schedule::{ByKind, ScheduleReport, TransferReport};
use super::{FunctionReport, ModuleReport};
use robovec_analysis::rounding::Quantiles;
use robovec_error::errors::{heat_text, heat_title};
use robovec_ir::Level;
use robovec_ir::diagnostic::counted;
use robovec_present::number::{or_dash, scientific, units};
use robovec_present::{indented, text_table};

/// The columns of rows of a label, a number and a remark: without heads.
const LABELLED: &str = " | >";

fn labelled(label: &str, number: impl ToString, remark: &str) -> Vec<String> {
    vec![label.to_owned(), number.to_string(), remark.to_owned()]
}

/// Number of elements of an array named as its worst.
const NAMED_ELEMENTS: usize = 3;

pub(super) fn print(report: &ModuleReport) -> String {
    let mut text = format!("robovec {}\n", report.robovec);
    for function in &report.functions {
        text.push('\n');
        print_function(function, &mut text);
    }
    text
}

fn print_function(function: &FunctionReport, text: &mut String) {
    let title = match &function.model {
        Some(model) => format!("{} of {model}, level {}", function.name, function.level),
        None => format!("{}, level {}", function.name, function.level),
    };
    text.push_str(&format!("{title}\n{}\n", "═".repeat(title.chars().count())));
    counts(function, text);
    boundaries(function, text);
    passes(function, text);
    pass_errors(function, text);
    if let Some(schedule) = &function.schedule {
        print_schedule(schedule, text);
    }
    speed_against_error(function, text);
    matrices(function, text);
    for (name, format) in [
        ("binary32", &function.error.binary32),
        ("binary64", &function.error.binary64),
    ] {
        errors(name, format, text);
        worst_errors(name, format, text);
    }
    section(
        &heat_title(&function.heat),
        &heat_text(&function.heat),
        text,
    );
}

fn section(title: &str, body: &str, text: &mut String) {
    text.push_str(&format!("\n{title}\n"));
    text.push_str(&indented("  ", body));
}

fn counts(function: &FunctionReport, text: &mut String) {
    let mut parts = vec![
        (function.counts.add_sub, "add or subtract"),
        (function.counts.mul, "multiply"),
        (function.counts.div, "divide"),
        (function.counts.sqrt, "take a root"),
    ];
    // Below the equations level a minus is a subtraction from zero.
    let mut detail = String::new();
    match function.level {
        Level::Equations => parts.push((function.counts.negations, "change the sign")),
        _ if function.counts.negations > 0 => {
            detail = format!("; as 0 - x: {}", function.counts.negations);
        }
        _ => {}
    }
    parts.retain(|(count, _)| *count > 0);
    let parts: Vec<String> = parts
        .iter()
        .map(|(n, what)| format!("{n} {what}"))
        .collect();
    let detail = format!("{}{detail}", parts.join(", "));
    let vectors = counted(function.counts.vectors, "vector");
    let vectors = format!("in {vectors} of independent ones");
    let on_host = "on the host, not counted as operations";
    let mut rows = vec![
        labelled("equations", function.counts.equations, &vectors),
        labelled("operations", function.counts.operations, &detail),
        labelled("sin, cos", function.counts.sin_cos, on_host),
        labelled("ASAP", function.asap, "operations in the longest chain"),
        labelled(
            "ASAPCycle",
            function.asap_cycle,
            "cycles of the longest chain",
        ),
    ];
    if let Some(number) = function.number_y {
        let remark = "operations per cycle of the longest chain";
        rows.push(labelled("number Y", format!("{number:.2}"), remark));
    }
    section("Size", &text_table(LABELLED, &rows), text);
}

fn boundaries(function: &FunctionReport, text: &mut String) {
    if function.boundaries.is_empty() {
        return;
    }
    let list = |names: &[String]| match names {
        [] => "-".to_owned(),
        names => names.join(", "),
    };
    let rows: Vec<Vec<String>> = function
        .boundaries
        .iter()
        .map(|boundary| {
            vec![
                format!("{}({})", boundary.callee, boundary.arguments.join(", ")),
                list(&boundary.outputs),
                or_dash(boundary.result.clone(), |result| result),
            ]
        })
        .collect();
    let head = "call | arguments it computes | input with the result";
    let title = "User calls split the function: evaluate the arguments, call, evaluate the rest";
    section(title, &text_table(head, &rows), text);
}

fn passes(function: &FunctionReport, text: &mut String) {
    if function.passes.is_empty() {
        return;
    }
    let rows: Vec<Vec<String>> = function.passes.iter().map(pass_row).collect();
    let head = "pass | >CPU ms | >peak MB | >operations | >ASAPCycle | check | error in binary32";
    let checked = function.passes.iter().find_map(|pass| pass.check.as_ref());
    let title = match checked {
        Some(check) => format!(
            "Passes, each checked at {} from seed {}",
            counted(check.points, "point"),
            check.seed
        ),
        None => "Passes".to_owned(),
    };
    section(&title, &text_table(head, &rows), text);
    for pass in &function.passes {
        let failure = pass.check.as_ref().and_then(|check| check.failure.as_ref());
        if let Some(failure) = failure {
            section(&format!("{} failed its check", pass.name), failure, text);
        }
    }
}

/// The rounding errors after every pass, with those before the first.
fn pass_errors(function: &FunctionReport, text: &mut String) {
    let measured = function
        .passes
        .iter()
        .filter_map(|pass| Some((pass, pass.rounding.as_ref()?)));
    let row = |name: &str, pick: [&Quantiles; 2], verdict: String| {
        let mut row = vec![name.to_owned()];
        for quantiles in pick {
            let numbers = [quantiles.median, quantiles.percentile_99, quantiles.worst];
            row.extend(numbers.map(units));
        }
        row.push(verdict);
        row
    };
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut title = String::new();
    for (pass, rounding) in measured {
        let RoundingReport {
            relative, normwise, ..
        } = rounding;
        if rows.is_empty() {
            title = format!(
                "Rounding in binary32 after each pass, units of 2^-24, {}, seed {}",
                counted(rounding.states, "state"),
                rounding.seed
            );
            let before = [&relative.before, &normwise.before];
            rows.push(row("(as read)", before, String::new()));
        }
        let after = [&relative.after, &normwise.after];
        rows.push(row(&pass.name, after, relative.change.to_string()));
    }
    if rows.is_empty() {
        return;
    }
    let head = "pass | >relative | >99 % | >worst | >normwise | >99 % | >worst | the median is";
    section(&title, &text_table(head, &rows), text);
}

fn pass_row(pass: &PassReport) -> Vec<String> {
    let check = |check: &CheckReport| match (check.result, check.deviation) {
        ("measured", Some(deviation)) => format!("moved by {}", scientific(deviation)),
        (result, _) => result.to_owned(),
    };
    let change = |errors: &CheckErrors| {
        let (before, after) = (errors.before.worst_normwise, errors.after.worst_normwise);
        if before == after {
            scientific(after)
        } else {
            format!("{} → {}", scientific(before), scientific(after))
        }
    };
    let errors = pass
        .check
        .as_ref()
        .and_then(|check| check.binary32.as_ref());
    vec![
        pass.name.clone(),
        // WebAssembly has no clock of the processor.
        or_dash((pass.cpu_s > 0.0).then_some(pass.cpu_s), |time| {
            format!("{:.2}", time * 1e3)
        }),
        or_dash(pass.peak_mb, |mb| format!("{mb:.1}")),
        pass.operations.to_string(),
        pass.asap_cycle.to_string(),
        or_dash(pass.check.as_ref(), check),
        or_dash(errors, change),
    ]
}

fn print_schedule(schedule: &ScheduleReport, text: &mut String) {
    let excess = match schedule.lower_bound {
        bound if bound == schedule.cycles => "optimal: no schedule is shorter".to_owned(),
        0 => String::new(),
        bound => {
            let percent = (f64::from(schedule.cycles) / f64::from(bound) - 1.0) * 100.0;
            format!("at most {percent:.2} % above the shortest, which takes {bound} or more")
        }
    };
    let kinds: Vec<String> = schedule
        .elements
        .iter()
        .map(|kind| format!("{} {}", kind.count, kind.kind))
        .collect();
    let kinds = kinds.join(" + ");
    let identity = match &schedule.machine_hash {
        Some(hash) => format!("{kinds}, hash {hash}"),
        None => kinds,
    };
    let mut rows = vec![
        labelled("machine", &schedule.machine, &identity),
        labelled("cycles", schedule.cycles, &excess),
    ];
    if let (Some(time), Some(clock)) = (schedule.time_us, &schedule.clock) {
        let remark = format!("microseconds at {}", clock.text());
        rows.push(labelled("time", format!("{time:.3}"), &remark));
    }
    let rate = format!("{:.1} %", schedule.parallelisation_rate * 100.0);
    let remark = "of all issue slots is used (parallelisation rate)";
    rows.push(labelled("rate", rate, remark));
    section("Schedule", &text_table(LABELLED, &rows), text);
    section(
        "Occupation: share of issue slots used, over the run",
        &chart::occupation(schedule),
        text,
    );
    if let (Some(memory), Some(buffer)) = (&schedule.memory, &schedule.buffer) {
        let rows: Vec<Vec<String>> = usage("memory", memory)
            .chain(usage("buffer", buffer))
            .collect();
        let head = "words used | elements | >min | >mean | >max";
        section(
            "Memory and buffer, per element",
            &text_table(head, &rows),
            text,
        );
    }
    if let Some(transfers) = &schedule.transfers {
        print_transfers(transfers, text);
    }
}

fn print_transfers(transfers: &TransferReport, text: &mut String) {
    let direct = "writes in the cycle in which the result appears";
    let buffered = "results that pass through a buffer";
    let rows = [
        labelled(
            "preloads",
            transfers.preloads,
            "words filled before the run",
        ),
        labelled("direct", transfers.direct, direct),
        labelled("indirect", transfers.indirect, "writes through a buffer"),
        labelled("buffered", transfers.buffered, buffered),
    ];
    section("Transfers", &text_table(LABELLED, &rows), text);
}

fn usage<'a>(what: &'a str, kinds: &'a ByKind) -> impl Iterator<Item = Vec<String>> + 'a {
    kinds.0.iter().map(move |(kind, usage)| {
        vec![
            what.to_owned(),
            kind.clone(),
            usage.min.to_string(),
            format!("{:.1}", usage.mean),
            usage.max.to_string(),
        ]
    })
}

fn speed_against_error(function: &FunctionReport, text: &mut String) {
    let row = |name: &str, format: &FormatReport| {
        let summary = &format.summary;
        // The machine computes in one format: its cycles are for no other.
        let schedule = function.schedule.as_ref().filter(|schedule| {
            let number = schedule.number.as_deref();
            number.is_some_and(|number| number.starts_with(name))
        });
        vec![
            name.to_owned(),
            or_dash(schedule, |schedule| schedule.cycles.to_string()),
            or_dash(schedule.and_then(|schedule| schedule.time_us), |time| {
                format!("{time:.3}")
            }),
            scientific(summary.median_relative),
            scientific(summary.worst_normwise),
            scientific(summary.worst_ulps),
            or_dash(summary.worst_output.clone(), |output| output),
        ]
    };
    let rows = [
        row("binary32", &function.error.binary32),
        row("binary64", &function.error.binary64),
    ];
    let head =
        "format | >cycles | >time us | >median relative | >worst normwise | >worst ulps | of";
    let title = format!(
        "Speed against error: rounding against reference values ({}), {}, seed {}",
        function.error.reference,
        counted(function.error.states, "random state"),
        function.error.seed
    );
    section(&title, &text_table(head, &rows), text);
}

/// One row per output array, its worst elements named.
fn errors(format: &str, report: &FormatReport, text: &mut String) {
    let rows: Vec<Vec<String>> = report.arrays.iter().map(array_row).collect();
    let head = "output | >elements | >vanish | >normwise | >worst | >relative | >worst | >ulps | \
         >worst | worst elements";
    let title = format!("Error of each output in {format} (medians and worst cases)");
    section(&title, &text_table(head, &rows), text);
}

fn array_row(array: &ArrayReport) -> Vec<String> {
    let median = |pick: fn(&ElementReport) -> f64| {
        let numbers = array.elements.iter().map(pick);
        let mut numbers: Vec<f64> = numbers.filter(|number| !number.is_nan()).collect();
        numbers.sort_unstable_by(f64::total_cmp);
        numbers
            .get(numbers.len().saturating_sub(1) / 2)
            .copied()
            .unwrap_or(f64::NAN)
    };
    let worst =
        |pick: fn(&ElementReport) -> f64| array.elements.iter().map(pick).fold(f64::NAN, f64::max);
    vec![
        array.name.clone(),
        array.elements.len().to_string(),
        match array
            .elements
            .iter()
            .filter(|element| element.vanishing > 0)
            .count()
        {
            0 => "-".to_owned(),
            count => count.to_string(),
        },
        scientific(array.normwise.median),
        scientific(array.normwise.worst),
        scientific(median(|element| element.relative.median)),
        scientific(worst(|element| element.relative.worst)),
        scientific(median(|element| element.ulps.median)),
        scientific(worst(|element| element.ulps.worst)),
        worst_elements(array),
    ]
}

/// Elements shown with the conditions of their errors.
const CONDITIONED_ELEMENTS: usize = 6;

/// The elements with the largest relative errors beside their conditions.
fn worst_errors(format: &str, report: &FormatReport, text: &mut String) {
    let elements = report.arrays.iter().flat_map(|array| &array.elements);
    let mut elements: Vec<&ElementReport> = elements
        .filter(|element| element.condition.is_some())
        .collect();
    elements.sort_by(|a, b| b.relative.worst.total_cmp(&a.relative.worst));
    elements.truncate(CONDITIONED_ELEMENTS);
    if elements.is_empty() {
        return;
    }
    let number = |number: Option<f64>| or_dash(number, scientific);
    let rows: Vec<Vec<String>> = elements
        .iter()
        .map(|element| {
            vec![
                element.name.clone(),
                scientific(element.relative.median),
                scientific(element.relative.percentile_99),
                scientific(element.relative.worst),
                element.worst_state.to_string(),
                scientific(element.mixed.worst),
                number(element.condition),
                number(element.backward),
                or_dash(element.judgement, str::to_owned),
            ]
        })
        .collect();
    let head = "element | >relative | >99 % | >worst | >state | >mixed | >condition | >backward | \
         judgement";
    let title = format!("Largest relative errors in {format}, and how hard the problem is");
    section(&title, &text_table(head, &rows), text);
}

/// Effect of solving with the output matrices on errors.
fn matrices(function: &FunctionReport, text: &mut String) {
    let row = |matrix: &MatrixReport| {
        vec![
            matrix.name.clone(),
            scientific(matrix.condition.median),
            scientific(matrix.condition.worst),
            matrix.condition.worst_state.to_string(),
        ]
    };
    let rows: Vec<Vec<String>> = function.error.matrices.iter().map(row).collect();
    if !rows.is_empty() {
        let head = "matrix | >median | >worst | >state";
        let title = "Condition of symmetric outputs in the 2-norm";
        section(title, &text_table(head, &rows), text);
    }
}

/// Elements with the largest errors in ulps, those without error left out.
fn worst_elements(array: &ArrayReport) -> String {
    let mut elements: Vec<&ElementReport> = array
        .elements
        .iter()
        .filter(|element| element.ulps.worst > 0.0)
        .collect();
    elements.sort_by(|a, b| b.ulps.worst.total_cmp(&a.ulps.worst));
    let names: Vec<&str> = elements
        .iter()
        .take(NAMED_ELEMENTS)
        .map(|element| element.name.as_str())
        .collect();
    names.join(" ")
}
