//! The report: one HTML file that needs nothing else.
//!
//! Figures are put in as they are drawn for paper, tables as HTML, points as
//! JSON for the chart that a reader composes. **Invariant.** The page refers
//! to no other file and no address.

use super::cpu::{self, CpuTime};
use super::figure::Figure;
use super::figures::zone;
use super::plot::{self, Escaped};
use super::results::{Results, time_us};
use super::table::{Cell, Table, round};
use super::verdict::verdicts;
use serde_json::{Value, json};
use std::fmt::Write;

const TEMPLATE: &str = include_str!("page.html");
pub(crate) const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Tables with more rows than this are left to the files.
const LONGEST_TABLE: usize = 400;

/// The report as HTML.
pub fn page(results: &Results, tables: &[Table], figures: &[Figure], times: &[CpuTime]) -> String {
    let plan = &results.plan;
    let subtitle = format!(
        "{}. {} models, {} placements, computed by robovec {}.",
        plan.description.trim_end_matches('.'),
        plan.models.len(),
        results.outcome.points.len(),
        env!("CARGO_PKG_VERSION")
    );
    let measured: Vec<Table> = [
        cpu::table::winners(results, times),
        cpu::table::programs(times),
    ]
    .into_iter()
    .flatten()
    .collect();
    let shown = measured
        .iter()
        .chain(tables)
        .filter(|table| table.rows.len() <= LONGEST_TABLE);
    let parts = [
        (
            "title",
            Escaped(&format!("Study: {}", plan.name)).to_string(),
        ),
        ("subtitle", Escaped(&subtitle).to_string()),
        ("css", STYLE.to_owned()),
        ("js", SCRIPT.to_owned()),
        ("tables", shown.map(table).collect()),
        ("figures", figures.iter().map(figure).collect()),
        ("method", method(results)),
        // A closing tag inside a string would end the script.
        (
            "data",
            data(results, times).to_string().replace("</", "<\\/"),
        ),
    ];
    fill(TEMPLATE, &parts)
}

/// Fills the places `{{name}}` of a template; what is filled in is not looked
/// at again.
pub(crate) fn fill(template: &str, parts: &[(&str, String)]) -> String {
    let mut text = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        text.push_str(before);
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        let part = parts.iter().find(|(known, _)| *known == name);
        text.push_str(part.map_or("", |(_, part)| part));
        rest = after;
    }
    text + rest
}

pub(crate) fn table(table: &Table) -> String {
    let mut text = String::new();
    let name = &table.name;
    // Data of the thesis and long lists are there for whoever looks for them.
    let asked_for = name == "verdicts";
    let open = if name.starts_with("table-1.") || table.rows.len() > 50 && !asked_for {
        ""
    } else {
        " open"
    };
    let file = match name.as_str() {
        "cpu" | "winners" | "verdicts" => String::new(),
        "front" | "fit" | "sweep" => format!("File: {name}.csv."),
        name => format!("File: tables/{name}.csv."),
    };
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "<details id=\"{name}\"{open}><summary>{}</summary>\n<p class=\"caption\">{} \
         {file}</p>\n<div class=\"scroll tall\"><table class=\"data\"><thead><tr>",
        Escaped(&table.title),
        Escaped(&table.caption),
    );
    for column in &table.columns {
        let _ = write!(text, "<th>{}</th>", Escaped(column));
    }
    text.push_str("</tr></thead><tbody>\n");
    for row in &table.rows {
        text.push_str("<tr>");
        for value in row {
            cell(&mut text, value);
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</tbody></table></div></details>\n");
    text
}

fn cell(text: &mut String, cell: &Cell) {
    let plain = cell.plain();
    // As above, writing cannot fail.
    let _ = match cell {
        Cell::Empty => write!(text, "<td></td>"),
        Cell::Count(_) | Cell::Number(..) => write!(text, "<td class=\"n\">{plain}</td>"),
        Cell::Text(long) if long.len() > 60 => {
            write!(text, "<td class=\"long\">{}</td>", Escaped(long))
        }
        Cell::Text(short) => write!(text, "<td>{}</td>", Escaped(short)),
        Cell::Doubtful { doubtful } => write!(text, "<td class=\"n\"><s>{doubtful}</s></td>"),
    };
}

pub(crate) fn figure(figure: &Figure) -> String {
    format!(
        "<figure id=\"{}\">{}<figcaption><b>{}</b><br><span class=\"caption\">{}</span></figcaption></figure>\n",
        figure.name,
        plot::draw(figure),
        Escaped(&figure.title),
        Escaped(&figure.caption),
    )
}

/// What the script works on.
fn data(results: &Results, cpu: &[CpuTime]) -> Value {
    let plan = &results.plan;
    let machine = results
        .main_machine()
        .map(|machine| &plan.machines[machine]);
    let all = results.outcome.points.iter();
    let points = all.map(|(request, point)| {
        let placed = super::results::Placed { request, point };
        let facts = results.program(request.model, request.pipeline, request.machine);
        let facts = facts.filter(|_| point.failure.is_none());
        let machine = &plan.machines[request.machine];
        let most = |words: [f64; 3]| words[2];
        json!({
            "model": plan.models[request.model].name,
            "pipeline": plan.pipelines[request.pipeline].name,
            "machine": machine.name,
            "n_add": request.n_add,
            "n_multi": request.n_multi,
            "priority": request.priority,
            "choice": request.choice,
            "cycles": point.cycles,
            "lower_bound": point.lower_bound,
            "time_us": round(time_us(point, machine.machine.clock_mhz), 4),
            "rate": round(point.rate, 4),
            "busy": [round(point.kinds[0].rate, 4), round(point.kinds[1].rate, 4)],
            "memory": [most(point.kinds[0].memory), most(point.kinds[1].memory)],
            "buffer": [most(point.kinds[0].buffer), most(point.kinds[1].buffer)],
            "zone": facts.map(|facts| zone(facts, placed)),
            "failure": point.failure,
        })
    });
    json!({
        "headline": plan.models.get(plan.headline).map(|model| &model.name),
        "machine": machine.map(|machine| &machine.name),
        "mhz": machine.map(|machine| machine.machine.clock_mhz),
        "pipelines": plan
            .pipelines
            .iter()
            .map(|pipeline| (pipeline.name.clone(), json!(pipeline.pipeline.to_string())))
            .collect::<serde_json::Map<_, _>>(),
        "points": points.collect::<Vec<_>>(),
        "verdicts": verdicts(results),
        "cpu": cpu,
    })
}

/// Models, pipelines and machines, and the words used.
fn method(results: &Results) -> String {
    let plan = &results.plan;
    let mut text = "<p>Every program is a straight line of additions, subtractions and \
        multiplications. A pipeline of passes rewrites it; the placer gives every operation a \
        cycle and an element of the machine; a verifier accepts the result before it is counted. \
        Lower bounds are proved. Elements are counted as adders + multipliers (all together): \
        the thesis uses both ways of counting.</p><ul>"
        .to_owned();
    for pipeline in &plan.pipelines {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "<li>Pipeline <b>{}</b>: <code>{}</code></li>",
            Escaped(&pipeline.name),
            Escaped(&pipeline.pipeline.to_string())
        );
    }
    for machine in plan
        .machines
        .iter()
        .filter(|machine| machine.couple.is_none())
    {
        let _ = write!(
            text,
            "<li>Machine <b>{}</b>: {}</li>",
            Escaped(&machine.name),
            Escaped(&machine.machine.description)
        );
    }
    for model in &plan.models {
        let stands = model
            .printed
            .as_ref()
            .map_or(String::new(), |row| format!(", for the thesis' {row}"));
        let _ = write!(
            text,
            "<li>Model <b>{}</b>: {}, equations {}{}</li>",
            Escaped(&model.name),
            Escaped(&model.source),
            Escaped(&super::variants::label(model)),
            Escaped(&stands)
        );
    }
    text + "</ul>"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_filled_in_is_not_filled_again() {
        let parts = [("a", "{{b}}".to_owned()), ("b", "2".to_owned())];
        assert_eq!(fill("<{{a}}|{{b}}|{{c}}>", &parts), "<{{b}}|2|>");
    }
}
