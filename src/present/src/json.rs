//! Plain data as JSON: strings, numbers and lists of them, only values that
//! JSON can represent. Numbers that are not finite become `null`.

use serde::Serialize;

/// Indented JSON that ends with a line end.
pub fn json_text(value: &(impl Serialize + ?Sized)) -> String {
    let mut text = serde_json::to_string_pretty(value).expect("results are plain data");
    text.push('\n');
    text
}

/// On one line, for a script inside HTML.
pub fn json_script(value: &(impl Serialize + ?Sized)) -> String {
    let text = serde_json::to_string(value).expect("results are plain data");
    // A closing tag inside a string would end the script.
    text.replace("</", "<\\/")
}
