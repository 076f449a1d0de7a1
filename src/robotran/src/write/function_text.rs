//! The text of a function while it is written.

use super::expression::Printer;
use super::text::FileText;
use crate::Language;
use hashbrown::HashSet;
use rustc_hash::FxBuildHasher;

/// The text being written, with its running counts.
pub(super) struct FunctionText {
    pub(super) text: FileText,
    pub(super) printer: Printer,
    /// C's declarations of the temporaries, in order.
    pub(super) declarations: String,
    /// Definitions that several cases of a sensor file may have.
    known: HashSet<Box<str>, FxBuildHasher>,
    pub(super) section: BodySection,
}

/// Section under the title printed last.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Debug)]
pub(super) enum BodySection {
    Start,
    Trigonometry,
    Main,
    Outputs,
}

impl FunctionText {
    pub(super) fn new(language: Language) -> FunctionText {
        FunctionText {
            text: FileText::new(language),
            printer: Printer::default(),
            declarations: String::new(),
            known: HashSet::default(),
            section: BodySection::Start,
        }
    }

    /// Declares a temporary, for the header of C.
    pub(super) fn declare(&mut self, name: &str) {
        if self.text.language == Language::C {
            self.declarations.push_str("double    ");
            self.declarations.push_str(name);
            self.declarations.push_str(";\n");
        }
    }

    /// As [`FunctionText::declare`], for names that other cases may have
    /// declared before.
    pub(super) fn declare_once(&mut self, name: &str) {
        if self.text.language == Language::C && !self.known.contains(name) {
            self.known.insert(name.into());
            self.declare(name);
        }
    }
}
