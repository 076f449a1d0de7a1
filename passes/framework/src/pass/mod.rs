//! What a pass is.
//!
//! A pass rewrites one function. It declares the level it takes and gives,
//! the properties it needs and destroys, and its numeric class; verification,
//! dumps, timing and the semantic check are the business of the manager, not
//! of the pass.

mod declare;
mod info;
mod registry;

pub use info::{BuildPass, Gives, PassInfo, Property};
pub use registry::{Preset, Registry};

use crate::check::Promise;
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
    /// When the function cannot be treated (an operation the machine cannot
    /// do, a memory that is too small); the function is then not used any
    /// more.
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError>;

    /// What the pass promises about numbers with its options, from what it
    /// declares; an option may weaken the promise, and the check then asks for
    /// no more.
    fn class(&self, declared: NumericClass) -> NumericClass {
        declared
    }

    /// The instances the pass makes of the function, if it makes several; the
    /// check then compares each of them with the function before.
    fn instances(&self) -> Option<Instances> {
        None
    }
}

/// What a pass has at hand besides the function.
pub struct Context<'a> {
    /// Names and source places of the module.
    pub tables: &'a mut Tables,
    /// The machine compiled for.
    pub machine: &'a Machine,
    /// The passes that it can run itself.
    pub registry: &'static Registry,
    /// The rules that rewriting may use.
    pub rules: &'a RuleSet,
    /// What the function is needed for, when that is known.
    pub scene: Option<&'a Scene>,
    /// Left by a pass that rounds constants: the function in which they are
    /// still computed. The check proves that, and compares the constants.
    pub witness: &'a mut Option<Function>,
    /// Left by an approximating pass: what it promises of the outputs. The
    /// check holds it to that.
    pub promise: &'a mut Option<Promise>,
    /// Files the pass produces (memory images, C).
    pub artifacts: &'a mut Vec<Artifact>,
    /// What the pass counted: name and number.
    pub statistics: &'a mut Vec<(&'static str, u64)>,
    /// What the pass has to tell: one line each.
    pub remarks: &'a mut Vec<String>,
    /// The rules it applied, value by value; see [`Context::note`].
    pub notes: &'a mut Notes,
    /// Counts the rewrites, and stops them when one is looked for.
    pub rewrites: &'a RewriteLimit,
}

impl Context<'_> {
    /// Says that the value which bears this name after the pass was made by
    /// this rule of the pass (`factor`, `sub-neg`, …). Free when nobody asked
    /// for the trail. Where the context is borrowed otherwise, the field
    /// [`notes`](Context::notes) does the same.
    #[inline]
    pub fn note(&mut self, name: Name, rule: &str) {
        self.notes.note(name, rule);
    }

    /// Whether a value may be written anew: asked before every rewrite, so
    /// that the one that breaks a function can be found
    /// ([`RewriteLimit::allow`]).
    pub fn allow_rewrite(&self, name: Name, rule: &str) -> bool {
        self.rewrites.allow(name, rule)
    }
}

/// What passes say when they are run by another pass, which decides what of
/// it is passed on.
#[derive(Default, Debug)]
pub struct Aside {
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
    /// The context for a pass that this one runs for a machine: the same
    /// tables, and everything it says kept aside.
    pub fn aside<'b>(&'b mut self, machine: &'b Machine, aside: &'b mut Aside) -> Context<'b> {
        if self.notes.are_wanted() && !aside.notes.are_wanted() {
            aside.notes = Notes::wanted();
        }
        Context {
            tables: self.tables,
            machine,
            registry: self.registry,
            rules: self.rules,
            scene: self.scene,
            witness: &mut aside.witness,
            promise: &mut aside.promise,
            rewrites: self.rewrites,
            artifacts: &mut aside.artifacts,
            statistics: &mut aside.statistics,
            remarks: &mut aside.remarks,
            notes: &mut aside.notes,
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

/// Why a pass gave up on a function.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{message}")]
pub struct PassError {
    /// What is wrong.
    pub message: String,
    /// The equations it is about.
    pub sources: SourceSet,
    /// What the user can do.
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
