//! Format of results.

use std::fmt::Write;

/// Way in which results are written.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, clap::ValueEnum)]
pub enum ResultFormat {
    /// Lines `state 2 dirdyna M[1,1] 3.0`; floats as the shortest decimal that
    /// is read as the same number.
    #[default]
    Text,
    /// The same lines with floats in hexadecimal, `0x1.8p+1`.
    #[value(skip)]
    Hexadecimal,
    /// A table with the columns state, function, output and value; decimal.
    Csv,
    /// A list of objects with state, function and outputs; decimal, and as a
    /// text where a number of JSON would lose digits.
    Json,
}

/// A value in its printed form.
pub(super) struct Shown {
    pub(super) text: String,
    /// True where JSON has no number for it.
    pub(super) quoted: bool,
}

pub(super) struct ResultWriter {
    format: ResultFormat,
    text: String,
    head: (usize, String),
    first_element: bool,
    first_group: bool,
}

impl ResultWriter {
    pub(super) fn new(format: ResultFormat) -> ResultWriter {
        let text = match format {
            ResultFormat::Text | ResultFormat::Hexadecimal => String::new(),
            ResultFormat::Csv => "state,function,output,value\n".to_owned(),
            ResultFormat::Json => "[".to_owned(),
        };
        ResultWriter {
            format,
            text,
            head: (0, String::new()),
            first_element: true,
            first_group: true,
        }
    }

    pub(super) fn start(&mut self, state: usize, function: &str) {
        self.head = (state, function.to_owned());
        if self.format == ResultFormat::Json {
            let separator = if self.first_group { "\n" } else { ",\n" };
            // Writing to a string cannot fail, here and below.
            let _ = write!(
                self.text,
                "{separator}  {{\"state\": {state}, \"function\": {}, \"outputs\": {{",
                json(function)
            );
        }
        self.first_group = false;
        self.first_element = true;
    }

    pub(super) fn element(&mut self, element: &str, shown: &Shown) {
        let (state, function) = &self.head;
        let value = &shown.text;
        let _ = match self.format {
            ResultFormat::Text | ResultFormat::Hexadecimal => {
                writeln!(self.text, "state {state} {function} {element} {value}")
            }
            ResultFormat::Csv => writeln!(self.text, "{state},{function},\"{element}\",{value}"),
            ResultFormat::Json => {
                let separator = if self.first_element { "\n" } else { ",\n" };
                let quote = if shown.quoted { "\"" } else { "" };
                let name = json(element);
                write!(self.text, "{separator}    {name}: {quote}{value}{quote}")
            }
        };
        self.first_element = false;
    }

    pub(super) fn end(&mut self) {
        if self.format == ResultFormat::Json {
            let end = if self.first_element { "}}" } else { "\n  }}" };
            self.text.push_str(end);
        }
    }

    pub(super) fn finish(mut self) -> String {
        if self.format == ResultFormat::Json {
            self.text.push_str("\n]\n");
        }
        self.text
    }
}

fn json(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
