//! The ways in which a case writes its equations as text.

use super::{ProgramTreatment, StressError};

/// One form of equations, with the numbers at which it is evaluated.
pub(super) struct TextForm<N> {
    /// Its name; empty for the case itself.
    pub(super) name: &'static str,
    /// A module of one function in the text form.
    pub(super) text: String,
    pub(super) numbers: N,
    /// True when the host prepared the numbers from those of the case.
    pub(super) prepared: bool,
}

impl<N> TextForm<N> {
    /// Equations that compute with the numbers of the case.
    pub(super) fn given(name: &'static str, text: impl Into<String>, numbers: N) -> TextForm<N> {
        TextForm {
            name,
            text: text.into(),
            numbers,
            prepared: false,
        }
    }

    /// Equations in numbers that the host prepares.
    pub(super) fn prepared(name: &'static str, text: impl Into<String>, numbers: N) -> TextForm<N> {
        TextForm {
            prepared: true,
            ..TextForm::given(name, text, numbers)
        }
    }
}

/// All ways of a case.
pub(super) struct TextForms<N> {
    /// The one that the case is about.
    pub(super) plain: TextForm<N>,
    others: Vec<TextForm<N>>,
}

impl<N> TextForms<N> {
    pub(super) fn new(text: impl Into<String>, numbers: N) -> TextForms<N> {
        TextForms {
            plain: TextForm::given("", text, numbers),
            others: Vec::new(),
        }
    }

    pub(super) fn push(&mut self, form: TextForm<N>) {
        self.others.push(form);
    }

    pub(super) fn all(&self) -> impl Iterator<Item = &TextForm<N>> {
        std::iter::once(&self.plain).chain(&self.others)
    }

    pub(super) fn named(&self, name: &str) -> Result<&TextForm<N>, StressError> {
        let found = self.all().find(|form| form.name == name);
        found.ok_or_else(|| StressError::Passes(format!("there is no form '{name}'")))
    }

    /// A treatment with every list of passes over some forms of the case.
    pub(super) fn treatments(
        &self,
        prepared: bool,
        passes: &[&'static str],
        untreated: &ProgramTreatment,
    ) -> Vec<ProgramTreatment> {
        let forms = self.all().filter(|form| form.prepared == prepared);
        let treatments = forms.flat_map(|form| {
            passes.iter().map(|&passes| ProgramTreatment {
                passes,
                form: form.name,
                ..untreated.clone()
            })
        });
        treatments.collect()
    }
}
