//! A function on its way to batch code: everything that its files are written
//! from.

use super::Options;
use super::names::BatchNames;
use super::plan::BatchPlan;
use super::prepared::Prepared;
use crate::sincos::SineKernel;
use robovec_ir::{Function, View};

/// Writes the files of one function.
pub(super) struct BatchWriter<'a> {
    pub(super) view: View<'a>,
    pub(super) options: &'a Options,
    pub(super) plan: &'a BatchPlan,
    pub(super) prepared: &'a Prepared,
    pub(super) names: BatchNames,
    pub(super) kernel: SineKernel,
}

/// The form of a list of arrays.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum List {
    /// With types, as parameters.
    Parameters,
    /// Names only, as arguments.
    Arguments,
}

impl<'a> BatchWriter<'a> {
    pub(super) fn new(
        view: View<'a>,
        options: &'a Options,
        plan: &'a BatchPlan,
        prepared: &'a Prepared,
    ) -> BatchWriter<'a> {
        BatchWriter {
            names: BatchNames::new(view, plan),
            kernel: SineKernel {
                real: options.real,
                lanes: options.lanes,
            },
            view,
            options,
            plan,
            prepared,
        }
    }

    pub(super) fn function(&self) -> &'a Function {
        self.view.function
    }

    /// The line behind which vectors are there.
    pub(super) fn guard(&self) -> String {
        format!("#if {}\n", self.width())
    }

    /// The macro that says how many lanes a vector has; 0 without vectors.
    pub(super) fn width(&self) -> String {
        format!("ROBOVEC_{}", self.kernel.suffix().to_ascii_uppercase())
    }
}
