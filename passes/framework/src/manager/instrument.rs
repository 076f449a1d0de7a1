//! Printing and dumping the function around passes.
//!
//! Banners are comments of the text form, so that a whole log of dumps is
//! still text that robovec reads function by function.

use super::{Config, PassRecord};
use crate::pipeline::PassStep;
use robovec_ir::{Function, Tables, View, print};
use similar::{ChangeTag, TextDiff};
use std::io;

/// The passes that a dump is requested.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub enum PassFilter {
    /// No output.
    #[default]
    None,
    /// All.
    All,
    /// Those with these names.
    Named(Vec<String>),
}

impl PassFilter {
    fn wants(&self, name: &str) -> bool {
        match self {
            PassFilter::None => false,
            PassFilter::All => true,
            PassFilter::Named(names) => names.iter().any(|wanted| wanted == name),
        }
    }
}

/// The form in which changes are printed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PrintChanged {
    /// The whole function.
    Full,
    /// The lines that differ, with their surroundings.
    Diff,
}

/// Receives every state of every function; the program writes them to files.
pub trait Dump {
    /// Takes one state.
    ///
    /// # Errors
    ///
    /// Fails when it cannot be written.
    fn dump(&mut self, state: DumpState<'_>) -> io::Result<()>;
}

/// A state of a function: as it was read (no record), or after a pass.
pub struct DumpState<'a> {
    /// The function's name.
    pub function: &'a str,
    /// The pass's name, or `start`.
    pub pass: &'a str,
    /// The record of the pass.
    pub record: Option<&'a PassRecord>,
    /// The text; `None` when the pass changed nothing.
    pub text: Option<&'a str>,
}

pub(super) struct Instruments<'a> {
    pub(super) config: Config<'a>,
}

impl<'a> Instruments<'a> {
    pub(super) fn new(config: Config<'a>) -> Instruments<'a> {
        Instruments { config }
    }

    /// Tests whether the function before is needed after the pass.
    pub(super) fn keeps_before(&self) -> bool {
        self.config.check_each.is_some()
            || self.config.trail.is_some()
            || self.config.print_changed == Some(PrintChanged::Diff)
    }

    /// Tests whether the effect of each pass is measured: on request, or when
    /// the report depends on changes.
    pub(super) fn keeps_records(&self) -> bool {
        self.config.records
            || self.config.rounding.is_some()
            || self.config.trail.is_some()
            || self.config.dump.is_some()
            || self.config.print_changed.is_some()
    }

    pub(super) fn start(&mut self, tables: &Tables, function: &Function) -> io::Result<()> {
        if self.config.print_changed.is_some() {
            self.banner("at start", function)?;
            self.print(tables, function)?;
        }
        if let Some(dump) = &mut self.config.dump {
            let text = print::print_file(View { tables, function });
            dump.dump(DumpState {
                function: &function.name,
                pass: "start",
                record: None,
                text: Some(&text),
            })?;
        }
        Ok(())
    }

    pub(super) fn before(
        &mut self,
        step: &PassStep,
        tables: &Tables,
        function: &Function,
    ) -> io::Result<()> {
        if self.config.print_before.wants(step.info.name) {
            self.banner(&format!("before {step}"), function)?;
            self.print(tables, function)?;
        }
        Ok(())
    }

    pub(super) fn after(
        &mut self,
        step: &PassStep,
        tables: &Tables,
        before: Option<&Function>,
        function: &Function,
        record: Option<&PassRecord>,
    ) -> io::Result<()> {
        let view = View { tables, function };
        if self.config.print_after.wants(step.info.name) {
            self.banner(&format!("after {step}"), function)?;
            self.print(tables, function)?;
        }
        let Some(record) = record else {
            return Ok(());
        };
        match (self.config.print_changed, record.changed) {
            (None, _) => {}
            (Some(_), false) => {
                self.banner(&format!("after {step}: no change"), function)?;
            }
            (Some(PrintChanged::Full), true) => {
                self.banner(&format!("after {step}"), function)?;
                self.print(tables, function)?;
            }
            (Some(PrintChanged::Diff), true) => {
                self.banner(&format!("after {step}, as a difference"), function)?;
                let old = before.map_or_else(String::new, |function| {
                    print::print_function(View { tables, function })
                });
                let lines = difference(&old, &print::print_function(view));
                self.config.log.write_all(lines.as_bytes())?;
            }
        }
        if let Some(dump) = &mut self.config.dump {
            let text = record.changed.then(|| print::print_file(view));
            dump.dump(DumpState {
                function: &function.name,
                pass: step.info.name,
                record: Some(record),
                text: text.as_deref(),
            })?;
        }
        Ok(())
    }

    fn banner(&mut self, what: &str, function: &Function) -> io::Result<()> {
        writeln!(self.config.log, "// ----- {}: {what} -----", function.name)
    }

    fn print(&mut self, tables: &Tables, function: &Function) -> io::Result<()> {
        let text = print::print_function(View { tables, function });
        self.config.log.write_all(text.as_bytes())
    }
}

/// Changed lines with three lines around them, `-` before removed and `+`
/// before added ones.
pub(crate) fn difference(old: &str, new: &str) -> String {
    let mut lines = String::new();
    let diff = TextDiff::from_lines(old, new);
    let mut first = true;
    for group in diff.grouped_ops(3) {
        if !first {
            lines.push_str("  …\n");
        }
        first = false;
        for change in group
            .iter()
            .flat_map(|operation| diff.iter_changes(operation))
        {
            let sign = match change.tag() {
                ChangeTag::Equal => ' ',
                ChangeTag::Delete => '-',
                ChangeTag::Insert => '+',
            };
            lines.push(sign);
            lines.push_str(&change.to_string());
        }
    }
    lines
}
