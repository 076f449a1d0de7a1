//! Text inside HTML and SVG.

use std::fmt::{self, Display, Formatter, Write};

/// A text safe between tags and in attributes.
pub struct Escaped<'a>(pub &'a str);

/// A text safe between tags alone: quotes stay.
pub struct EscapedContent<'a>(pub &'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '"' => formatter.write_str("&quot;")?,
                '\'' => formatter.write_str("&#39;")?,
                // XML has no place for most control characters.
                control if control.is_control() => formatter.write_char(' ')?,
                other => content(formatter, other)?,
            }
        }
        Ok(())
    }
}

impl Display for EscapedContent<'_> {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let mut characters = self.0.chars();
        characters.try_for_each(|character| content(formatter, character))
    }
}

fn content(formatter: &mut Formatter<'_>, character: char) -> fmt::Result {
    match character {
        '<' => formatter.write_str("&lt;"),
        '>' => formatter.write_str("&gt;"),
        '&' => formatter.write_str("&amp;"),
        other => formatter.write_char(other),
    }
}
