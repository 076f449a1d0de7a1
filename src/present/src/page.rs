//! Pages: Self-contained HTML files.
//!
//! Figures are inserted as drawn for paper, tables as HTML, data as JSON for a
//! script. **Invariant.** A page refers to no other file and no address.

use super::escape::{Escaped, EscapedContent};
use super::{DataCell, DataTable, Figure, plot};
use std::fmt::Write;

/// The style of all pages with tables and figures.
pub const STYLE: &str = include_str!("page/page.css");

/// Script of all pages with tables: sort, find, save, show values.
pub const TABLES: &str = include_str!("page/tables.js");

const POINTS: &str = include_str!("page/points.html");

/// Tables with more rows than this are shown when requested.
const LONG_TABLE: usize = 50;

/// Texts with more lines than this are shown when requested.
const LONG_TEXT: usize = 12;

/// Cells with longer texts are broken into lines.
const LONG_CELL: usize = 60;

/// A page of points: figures, all points as tables, and explanations.
pub struct PointsPage<'a> {
    /// Text.
    pub title: String,
    /// Text: subject and program.
    pub subtitle: String,
    /// HTML: the first part of the page.
    pub figures: String,
    /// Description of the points, over their tables.
    pub points: &'a str,
    /// HTML.
    pub tables: String,
    /// HTML: how the numbers came about.
    pub method: &'a str,
    /// JSON for scripts, as [`super::json::json_script`] makes it.
    pub data: String,
}

impl PointsPage<'_> {
    /// The page.
    pub fn to_html(&self) -> String {
        let title = Escaped(&self.title).to_string();
        let subtitle = Escaped(&self.subtitle).to_string();
        let parts = [
            ("title", title.as_str()),
            ("subtitle", &subtitle),
            ("css", STYLE),
            ("figures", &self.figures),
            ("points", self.points),
            ("tables", &self.tables),
            ("method", self.method),
            ("data", &self.data),
            ("js", TABLES),
        ];
        fill(POINTS, &parts)
    }
}

/// Fills the places `{{name}}` of a template, none in inserted text.
///
/// # Panics
///
/// Panics when a place of the template has no part.
pub fn fill(template: &str, parts: &[(&str, &str)]) -> String {
    let mut text = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        text.push_str(before);
        let (name, after) = after.split_once("}}").expect("a place of a template ends");
        let part = parts.iter().find(|(known, _)| *known == name);
        text.push_str(part.expect("every place of a template has a part").1);
        rest = after;
    }
    text + rest
}

/// Unchanged lines of text under a title that folds them if they are many.
pub fn lines(title: &str, text: &str) -> String {
    let open = open_unless(text.lines().count() > LONG_TEXT);
    let text = EscapedContent(text);
    format!("<details{open}><summary>{title}</summary>\n<pre>{text}</pre></details>\n")
}

fn open_unless(is_long: bool) -> &'static str {
    if is_long { "" } else { " open" }
}

/// A card with an answer, and lines of evidence after their labels.
pub fn card(answer: &str, lines: &[(&str, String)]) -> String {
    let mut text = format!(
        "<div class=\"card\"><p class=\"answer\">{}</p>\n<dl>",
        arrows(answer)
    );
    for (label, content) in lines {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "<dt>{}</dt><dd>{}</dd>",
            Escaped(label),
            arrows(content)
        );
    }
    text + "</dl></div>\n"
}

/// A text with arrows that are not broken into lines.
fn arrows(text: &str) -> String {
    Escaped(&text.replace("->", "→")).to_string()
}

/// Maximum number of lines of a text beside another one.
const BESIDE: usize = 300;

/// Two texts side by side, each under its name; of long ones the beginning.
pub fn side_by_side(texts: [(&str, &str); 2]) -> String {
    let mut html = "<div class=\"pair\">".to_owned();
    for (name, text) in texts {
        let count = text.lines().count();
        let shown: Vec<&str> = text.lines().take(BESIDE).collect();
        let part = if count > BESIDE {
            format!(", the first {BESIDE} of {count} lines")
        } else {
            format!(", {count} lines")
        };
        // Writing to a string cannot fail.
        let _ = write!(
            html,
            "<div><h3>{}{part}</h3><pre class=\"tall\">{}</pre></div>",
            Escaped(name),
            EscapedContent(&shown.join("\n"))
        );
    }
    html + "</div>\n"
}

/// A table that folds if it is long; `file` has its numbers, if any.
pub fn table(table: &DataTable, file: &str) -> String {
    folding_table(table, file, table.rows.len() <= LONG_TABLE)
}

/// As [`table`], open or not, without columns that are empty in every row.
pub fn folding_table(table: &DataTable, file: &str, open: bool) -> String {
    let mut text = String::new();
    let open = open_unless(!open);
    let is_filled = |column: &usize| {
        table
            .rows
            .iter()
            .any(|row| !row[*column].plain().is_empty())
    };
    let filled: Vec<usize> = (0..table.columns.len()).filter(is_filled).collect();
    let file = match file {
        "" => String::new(),
        file => format!("File: {file}."),
    };
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "<details id=\"{}\"{open}><summary>{}</summary>\n<p class=\"caption\">{} \
         {file}</p>\n<div class=\"scroll tall\"><table class=\"data\"><thead><tr>",
        table.name,
        Escaped(&table.title),
        Escaped(&table.caption),
    );
    for &column in &filled {
        let _ = write!(text, "<th>{}</th>", Escaped(&table.columns[column]));
    }
    text.push_str("</tr></thead><tbody>\n");
    for row in &table.rows {
        text.push_str("<tr>");
        for &column in &filled {
            cell(&mut text, &row[column]);
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</tbody></table></div></details>\n");
    text
}

fn cell(text: &mut String, cell: &DataCell) {
    let plain = cell.plain();
    // As above, writing cannot fail.
    let _ = match cell {
        DataCell::Empty => write!(text, "<td></td>"),
        DataCell::Count(_) | DataCell::Number(..) => write!(text, "<td class=\"n\">{plain}</td>"),
        DataCell::Text(number) if number.parse::<f64>().is_ok() => {
            write!(text, "<td class=\"n\">{number}</td>")
        }
        DataCell::Text(long) if long.len() > LONG_CELL => {
            write!(text, "<td class=\"long\">{}</td>", Escaped(long))
        }
        DataCell::Text(short) => write!(text, "<td>{}</td>", Escaped(short)),
        DataCell::Doubtful { doubtful } => write!(text, "<td class=\"n\"><s>{doubtful}</s></td>"),
    };
}

/// A figure with its caption, its panels side by side where they fit.
pub fn figure(figure: &Figure) -> String {
    format!(
        "<figure id=\"{}\"><div class=\"panels\">{}</div><figcaption><b>{}</b><br><span class=\"caption\">{}</span></figcaption></figure>\n",
        figure.name,
        plot::draw_apart(figure).concat(),
        Escaped(&figure.title),
        Escaped(&figure.caption),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_filled_in_is_not_filled_again() {
        let parts = [("a", "{{b}}"), ("b", "2")];
        assert_eq!(fill("<{{a}}|{{b}}>", &parts), "<{{b}}|2>");
    }
}
