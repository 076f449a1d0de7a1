//! Files that an MJCF file includes.

use crate::xml;
use roxmltree::{Document, Node};
use std::ops::Range;

/// The most files that one file includes, those of included files counted.
const LIMIT: usize = 100;

/// The file with the elements of included files in their place. Each is on the
/// line of its `include`, so that messages name the lines of the file itself.
/// `read` gets the names as they are written, which MuJoCo takes relative to
/// the folder of the first file. What is no XML, and includes beyond the
/// hundredth, are left as they are, for the reader to refuse.
///
/// # Errors
///
/// Those of `read`.
pub fn with_includes<E>(
    bytes: Vec<u8>,
    mut read: impl FnMut(&str) -> Result<Vec<u8>, E>,
) -> Result<Vec<u8>, E> {
    let Ok(text) = xml::decode(&bytes) else {
        return Ok(bytes);
    };
    let mut text = text.into_owned();
    for _ in 0..LIMIT {
        let Some((place, file)) = first(&text) else {
            break;
        };
        let included = read(&file)?;
        let Some(inside) = elements(&included) else {
            break;
        };
        text.replace_range(place, &inside);
    }
    Ok(text.into_bytes())
}

/// The first `include` of a file: its place, and the file it names.
fn first(text: &str) -> Option<(Range<usize>, String)> {
    if !text.contains("<include") {
        return None;
    }
    let document = Document::parse(text).ok()?;
    let is_include = |node: &Node<'_, '_>| node.has_tag_name("include");
    let node = document.descendants().find(is_include)?;
    Some((node.range(), node.attribute("file")?.trim().to_owned()))
}

/// The text inside of the first element of a file, on one line.
fn elements(bytes: &[u8]) -> Option<String> {
    let text = xml::decode(bytes).ok()?;
    let document = Document::parse(&text).ok()?;
    let root = document.root_element();
    let inside = root.first_child()?.range().start..root.last_child()?.range().end;
    Some(text[inside].replace(['\n', '\r'], " "))
}
