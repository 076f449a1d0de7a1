//! Comma-separated values (RFC 4180, with line feeds).

/// Appends a line of fields, quoted where they need it.
pub fn push_line<'a>(text: &mut String, fields: impl Iterator<Item = &'a str>) {
    for (index, field) in fields.enumerate() {
        if index > 0 {
            text.push(',');
        }
        if field.contains([',', '"', '\n', '\r']) {
            text.push_str(&quoted(field));
        } else {
            text.push_str(field);
        }
    }
    text.push('\n');
}

/// A field in quotes, needed or not.
pub fn quoted(field: &str) -> String {
    format!("\"{}\"", field.replace('"', "\"\""))
}
