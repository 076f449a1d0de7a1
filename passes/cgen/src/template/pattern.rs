//! Texts with fields in braces: `"{a} + {b}"`.

use crate::emit::expression::Tightness;
use robovec_ir::Operation;

/// A text whose fields are numbered as in the list that it was read with.
#[derive(Clone, Debug)]
pub(super) struct TextPattern {
    /// Text before each field, the field, and the text after the last one.
    fields: Vec<(String, usize)>,
    end: String,
}

impl TextPattern {
    /// Reads a text with some of the fields of a list; `{{` and `}}` are braces.
    ///
    /// # Errors
    ///
    /// The fault of the text.
    pub(super) fn parse(text: &str, known: &[&str]) -> Result<TextPattern, String> {
        let mut pattern = TextPattern {
            fields: Vec::new(),
            end: String::new(),
        };
        let mut rest = text;
        while let Some(place) = rest.find(['{', '}']) {
            pattern.end += &rest[..place];
            let brace = &rest[place..=place];
            rest = &rest[place + 1..];
            if let Some(after) = rest.strip_prefix(brace) {
                pattern.end += brace;
                rest = after;
                continue;
            }
            let field = rest.split_once('}').filter(|_| brace == "{");
            let (name, after) = field.ok_or("a brace is '{{' or '}}' in this text")?;
            let number = known.iter().position(|known| *known == name);
            let number = number.ok_or_else(|| {
                let known = known.join("}, {");
                format!("unknown field '{{{name}}}': expected one of {{{known}}}")
            })?;
            pattern
                .fields
                .push((std::mem::take(&mut pattern.end), number));
            rest = after;
        }
        pattern.end += rest;
        Ok(pattern)
    }

    /// True if the text has a field.
    pub(super) fn has(&self, field: usize) -> bool {
        self.fields.iter().any(|(_, known)| *known == field)
    }

    /// True if the text is one field alone.
    pub(super) fn is_field(&self) -> bool {
        matches!(&self.fields[..], [(before, _)] if before.is_empty() && self.end.is_empty())
    }

    /// The text with its fields filled, each by number.
    pub(super) fn fill(&self, mut field: impl FnMut(usize) -> String) -> String {
        let mut text = String::new();
        for (before, number) in &self.fields {
            text += before;
            text += &field(*number);
        }
        text + &self.end
    }
}

/// The text of an operation, with the tightness that its place requires of each
/// operand, as in C; arguments of calls need none.
#[derive(Clone, Debug)]
pub(super) struct OperationText {
    pub(super) pattern: TextPattern,
    pub(super) tightness: Tightness,
    /// For each field of the pattern.
    pub(super) least: Vec<Tightness>,
}

impl OperationText {
    /// Fields of the text of an operation.
    pub(super) const FIELDS: [&str; 4] = ["a", "b", "c", "name"];

    /// Reads the text of an operation.
    ///
    /// # Errors
    ///
    /// The fault of the text, among them a missing operand.
    pub(super) fn parse(text: &str, operation: Operation) -> Result<OperationText, String> {
        let pattern = TextPattern::parse(text, &OperationText::FIELDS)?;
        let arity = operation.arity();
        for (number, field) in OperationText::FIELDS.iter().take(3).enumerate() {
            let name = operation.name();
            match (pattern.has(number), number < arity) {
                (false, true) => return Err(format!("'{name}' needs the operand '{{{field}}}'")),
                (true, false) => return Err(format!("'{name}' has no operand '{{{field}}}'")),
                (true, true) | (false, false) => {}
            }
        }
        let own = match operation {
            Operation::Add | Operation::Sub => Tightness::Sum,
            Operation::Mul | Operation::Div => Tightness::Product,
            Operation::Neg => Tightness::Unary,
            _ => Tightness::Open,
        };
        let mut least = vec![Tightness::Primary; OperationText::FIELDS.len()];
        for (place, (before, field)) in pattern.fields.iter().enumerate() {
            let after = pattern.fields.get(place + 1).map(|(text, _)| text);
            let after = after.unwrap_or(&pattern.end);
            let is_argument = before.ends_with('(') || before.ends_with(", ");
            if is_argument && after.starts_with([',', ')']) {
                least[*field] = Tightness::Open;
            } else if operation.arity() == 2 {
                least[*field] = if *field == 0 { own } else { own.next() };
            }
        }
        let tightness = if is_call(text) {
            Tightness::Primary
        } else {
            own
        };
        Ok(OperationText {
            pattern,
            tightness,
            least,
        })
    }
}

/// True for a name, also after a dot, with arguments in parentheses.
fn is_call(text: &str) -> bool {
    let Some((name, arguments)) = text.split_once('(') else {
        return false;
    };
    let mut depth = 1;
    let closed = arguments.find(|letter| {
        depth += i32::from(letter == '(') - i32::from(letter == ')');
        depth == 0
    });
    let is_name = |letter: char| letter.is_ascii_alphanumeric() || "_.:{}".contains(letter);
    name.chars().all(is_name) && closed == Some(arguments.len().wrapping_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_filled_and_braces_kept() {
        let pattern = TextPattern::parse("{{{b}}} {a}", &["a", "b"]).expect("two fields");
        assert_eq!(pattern.fill(|field| field.to_string()), "{1} 0");
        for wrong in ["{c}", "{", "}", "{a"] {
            assert!(TextPattern::parse(wrong, &["a"]).is_err(), "{wrong}");
        }
    }

    #[test]
    fn calls_bind_as_names_and_other_text_as_in_c() {
        let of = |text: &str, operation| OperationText::parse(text, operation).expect("valid");
        let tightness = |text: &str, operation| of(text, operation).tightness;
        assert_eq!(tightness("sin({a})", Operation::Sin), Tightness::Primary);
        assert_eq!(tightness("{a}.sin()", Operation::Sin), Tightness::Primary);
        assert_eq!(tightness("({a}) + ({b})", Operation::Add), Tightness::Sum);
        assert_eq!(tightness("{a} / {b}", Operation::Div), Tightness::Product);
        assert_eq!(
            of("{a} - {b}", Operation::Sub).least[..2],
            [Tightness::Sum, Tightness::Product]
        );
        assert_eq!(
            of("sub({a}, {b})", Operation::Sub).least[..2],
            [Tightness::Open; 2]
        );
        assert!(OperationText::parse("{a}", Operation::Add).is_err());
        assert!(OperationText::parse("{b}", Operation::Neg).is_err());
    }
}
