//! The trait of passes, their inputs and their results.
//!
//! A pass rewrites one function. It declares the level it takes and gives,
//! the properties it needs and destroys, and its numeric class; verification,
//! dumps, timing and the semantic check are the business of the manager, not
//! of the pass.

mod declare;
mod info;
mod registry;

pub(crate) use info::first_line;
pub use info::{BuildPass, Gives, PassInfo, Property};
pub use registry::{Preset, Registry};

use crate::check::Promise;
use crate::differentiation::Differentiation;
use crate::instances::Instances;
use crate::rewrite_limit::RewriteLimit;
use crate::scene::Scene;
use crate::trail::Notes;
use robovec_analysis::class::NumericClass;
use robovec_ir::{Function, Machine, Name, SourceSet, Tables};
use robovec_rules::RuleSet;

/// A transformation (or analysis) of one function.
pub trait Pass {
    /// Runs the pass.
    ///
    /// # Errors
    ///
    /// Fails when the function cannot be treated (an operation the machine
    /// cannot do, a memory that is too small); the function is then not used
    /// any more.
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError>;

    /// The numeric class that the semantic check holds this pass to, given the
    /// class its entry in the registry declares. A pass overrides it when one
    /// of its options weakens the promise.
    fn class(&self, declared: NumericClass) -> NumericClass {
        declared
    }

    /// The instances (copies side by side, each with its own outputs and all
    /// but the shared inputs) the pass makes of the function; `None` for a pass that makes
    /// none. The semantic check compares each of them with the function
    /// before the pass.
    fn instances(&self) -> Option<Instances> {
        None
    }

    /// The derivative that the pass makes of the function; `None` for a pass
    /// that makes none. The semantic check compares it with dual numbers of
    /// the function before the pass.
    fn differentiation(&self) -> Option<Differentiation> {
        None
    }
}

/// Context of a pass besides the function: data to read, and, as `&mut`, places
/// for its reports.
pub struct Context<'a> {
    /// Names and source places of the module.
    pub tables: &'a mut Tables,
    /// The machine compiled for.
    pub machine: &'a Machine,
    /// The passes that this pass can run itself.
    pub registry: &'static Registry,
    /// The rules that rewriting may use.
    pub rules: &'a RuleSet,
    /// Scene that describes the use of the function (ranges, tolerances,
    /// deadline), when the user gave one.
    pub scene: Option<&'a Scene>,
    /// Target of code generation that the user described.
    pub target: Option<&'a TargetFolder>,
    /// Left by a pass that rounds constants: the same function with the
    /// constants still computed from exact ones. The semantic check proves that
    /// one equal to the function before, and compares its constants with the
    /// rounded ones.
    pub witness: &'a mut Option<Function>,
    /// Left by an approximating pass: the largest difference of the outputs
    /// from those of the function before. The semantic check tests this class.
    pub promise: &'a mut Option<Promise>,
    /// Files the pass produces (memory images, C).
    pub artifacts: &'a mut Vec<Artifact>,
    /// Counts of the pass: the name of a count and its value.
    pub statistics: &'a mut Vec<(&'static str, u64)>,
    /// Findings of the pass for the user, one line each.
    pub remarks: &'a mut Vec<String>,
    /// The rules the pass applied, value by value; see [`Context::note`].
    pub notes: &'a mut Notes,
    /// Counts the rewrites, and refuses those beyond a limit during the search
    /// for the one that breaks a function.
    pub rewrites: &'a RewriteLimit,
}

impl Context<'_> {
    /// Records that the value which has this name after the pass was made by
    /// this rule of the pass (`factor`, `sub-neg`, …). Costs one comparison
    /// when no trail is wanted. Where another field of the context is borrowed,
    /// call [`Notes::note`] on the field [`notes`](Context::notes) itself.
    #[inline]
    pub fn note(&mut self, name: Name, rule: &str) {
        self.notes.note(name, rule);
    }

    /// Adds a count to the statistics of the pass.
    pub fn count(&mut self, name: &'static str, value: u64) {
        self.statistics.push((name, value));
    }

    /// Adds a finding for the user, one line.
    pub fn remark(&mut self, text: String) {
        self.remarks.push(text);
    }

    /// Tests whether the value of this name may be rewritten by this rule:
    /// called before every rewrite, so that the one that breaks a function can
    /// be found ([`RewriteLimit::allow`]).
    pub fn allow_rewrite(&self, name: Name, rule: &str) -> bool {
        self.rewrites.allow(name, rule)
    }
}

/// Reports of passes that another pass runs: separate from the [`Context`] of
/// that one, which decides which to pass on.
#[derive(Default, Debug)]
pub struct NestedReport {
    /// As [`Context::artifacts`].
    pub artifacts: Vec<Artifact>,
    /// As [`Context::statistics`].
    pub statistics: Vec<(&'static str, u64)>,
    /// As [`Context::remarks`].
    pub remarks: Vec<String>,
    /// As [`Context::notes`].
    pub notes: Notes,
    /// As [`Context::witness`].
    pub witness: Option<Function>,
    /// As [`Context::promise`].
    pub promise: Option<Promise>,
}

impl Context<'_> {
    /// The context for a pass that this pass runs itself, for a machine: the
    /// same tables, registry, rules, scene, target and limit of rewrites, with the
    /// reports of the nested pass going to `report`. Its notes are kept when
    /// those of this context are.
    pub fn nested<'b>(
        &'b mut self,
        machine: &'b Machine,
        report: &'b mut NestedReport,
    ) -> Context<'b> {
        // Notes that are wanted already may hold some of an earlier pass.
        if self.notes.are_wanted() && !report.notes.are_wanted() {
            report.notes = Notes::wanted();
        }
        Context {
            tables: self.tables,
            machine,
            registry: self.registry,
            rules: self.rules,
            scene: self.scene,
            target: self.target,
            witness: &mut report.witness,
            promise: &mut report.promise,
            rewrites: self.rewrites,
            artifacts: &mut report.artifacts,
            statistics: &mut report.statistics,
            remarks: &mut report.remarks,
            notes: &mut report.notes,
        }
    }
}

/// A file produced by code generation.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Artifact {
    /// File name; folders in it, divided by `/`, lie below that of the output.
    pub name: String,
    /// Content.
    pub text: String,
}

/// A target of code generation that a user described, as read.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TargetFolder {
    /// Name of the folder, for messages.
    pub name: String,
    /// Text of the description.
    pub description: String,
    /// Text of the template.
    pub template: String,
}

/// Reason why a pass gave up on a function.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{message}")]
pub struct PassError {
    /// Fault in words.
    pub message: String,
    /// The equations it is about.
    pub sources: SourceSet,
    /// Advice for the user.
    pub help: Option<String>,
}

impl PassError {
    /// An error about no equation in particular.
    pub fn new(message: impl Into<String>) -> PassError {
        PassError {
            message: message.into(),
            sources: SourceSet::EMPTY,
            help: None,
        }
    }

    /// The same error, about some equations.
    #[must_use]
    pub fn at(self, sources: SourceSet) -> PassError {
        PassError { sources, ..self }
    }

    /// The same error, with advice.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> PassError {
        PassError {
            help: Some(help.into()),
            ..self
        }
    }
}
