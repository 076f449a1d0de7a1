//! A function while batch code is made of it: the data from which its files are
//! written.

use super::Options;
use super::names::BatchNames;
use super::plan::BatchPlan;
use super::prepared::Prepared;
use crate::emit::frame::ParameterList;
use crate::sincos::SineKernel;
use robovec_framework::template::fill;
use robovec_ir::{Function, Shape, View};
use std::fmt::Display;

/// Writes the files of one function.
pub(super) struct BatchWriter<'a> {
    pub(super) view: View<'a>,
    pub(super) options: &'a Options,
    pub(super) plan: &'a BatchPlan,
    pub(super) prepared: &'a Prepared,
    pub(super) names: BatchNames,
    pub(super) kernel: SineKernel,
}

impl<'a> BatchWriter<'a> {
    pub(super) fn new(
        view: View<'a>,
        options: &'a Options,
        plan: &'a BatchPlan,
        prepared: &'a Prepared,
    ) -> BatchWriter<'a> {
        BatchWriter {
            names: BatchNames::new(view),
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

    /// A template with the words of every file and some others.
    pub(super) fn fill(&self, template: &str, own: &[(&str, &dyn Display)]) -> String {
        let vector = self.kernel.vector();
        let width = self.width();
        let words: [(&str, &dyn Display); 5] = [
            ("name", &self.names.function),
            ("real", &self.options.real.name()),
            ("lanes", &self.options.lanes),
            ("vector", &vector),
            ("width", &width),
        ];
        fill(template, &[&words, own].concat())
    }

    /// The macro for the number of lanes of a vector; 0 without vectors.
    fn width(&self) -> String {
        format!("ROBOVEC_{}", self.kernel.suffix().to_ascii_uppercase())
    }

    /// Appends the input arrays that are shared by all states, or are not.
    pub(super) fn add_inputs(&self, list: &mut ParameterList, wanted: &[bool], restrict: &str) {
        let real = self.options.real.name();
        for (index, array) in self.function().inputs().iter().enumerate() {
            let shared = self.plan.shared[index];
            if wanted.contains(&shared) {
                let kind = match array.shape {
                    Shape::Scalar if shared => format!("{real} "),
                    _ => format!("const {real} *{restrict}"),
                };
                list.add(&kind, &self.names.inputs[index]);
            }
        }
    }

    /// Appends the output arrays.
    pub(super) fn add_outputs(&self, list: &mut ParameterList, restrict: &str) {
        let kind = format!("{} *{restrict}", self.options.real.name());
        for name in &self.names.outputs {
            list.add(&kind, name);
        }
    }

    /// The shared inputs and the values prepared from them.
    pub(super) fn prepare_list(&self) -> ParameterList {
        let mut list = ParameterList::default();
        self.add_inputs(&mut list, &[true], "");
        list.add(&format!("{} *", self.options.real.name()), "prepared");
        list
    }

    /// The other inputs, the prepared values, and the outputs.
    pub(super) fn batch_list(&self) -> ParameterList {
        let mut list = ParameterList::default();
        self.add_inputs(&mut list, &[false], "");
        list.add(&format!("const {} *", self.options.real.name()), "prepared");
        self.add_outputs(&mut list, "");
        list
    }
}
