//! Tables and figures with the titles and captions of `captions.toml`.

use crate::operators::MEMORY_CAP_MHZ;
use robovec_present::{ColumnList, DataTable, Figure, Panel};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::LazyLock;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Captions {
    words: BTreeMap<String, String>,
    tables: BTreeMap<String, Caption>,
    figures: BTreeMap<String, Caption>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Caption {
    title: String,
    caption: String,
}

static CAPTIONS: LazyLock<Captions> =
    LazyLock::new(|| toml::from_str(include_str!("captions.toml")).expect("sound captions"));

/// Words that texts refer to, by name.
pub(crate) type Words<'a> = [(&'a str, &'a str)];

pub(crate) fn fill(text: &str, words: &Words<'_>) -> String {
    let fill =
        |text: String, (name, word): (&str, &str)| text.replace(&format!("{{{name}}}"), word);
    let shared = CAPTIONS.words.iter();
    let shared = shared.map(|(name, word)| (name.as_str(), word.as_str()));
    let cap = MEMORY_CAP_MHZ.to_string();
    let words = words.iter().copied().chain([("cap", cap.as_str())]);
    shared.chain(words).fold(text.to_owned(), fill)
}

pub(crate) fn table<R>(
    name: &str,
    words: &Words<'_>,
    columns: &ColumnList<'_, R>,
    rows: &[R],
) -> DataTable {
    let texts = &CAPTIONS.tables[name];
    let [title, caption] = [&texts.title, &texts.caption].map(|text| fill(text, words));
    columns.table(name, title, caption, rows)
}

/// A table of a name, if it has rows.
pub(crate) fn filled<R>(
    name: &str,
    words: &Words<'_>,
    columns: &ColumnList<'_, R>,
    rows: &[R],
) -> Option<DataTable> {
    (!rows.is_empty()).then(|| table(name, words, columns, rows))
}

/// A figure with panels, two in a row, if any; `texts`: the name of its texts.
pub(crate) fn figure(
    texts: &str,
    name: &str,
    words: &Words<'_>,
    panels: Vec<Panel>,
) -> Option<Figure> {
    let texts = &CAPTIONS.figures[texts];
    let [title, caption] = [&texts.title, &texts.caption].map(|text| fill(text, words));
    let columns = panels.len().min(2);
    (columns > 0).then(|| Figure::new(name, title, caption, columns, panels))
}
