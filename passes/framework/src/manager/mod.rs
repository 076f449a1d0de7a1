//! The pass manager: runs a pipeline over every function of a module, and
//! everything around the passes.
//!
//! Invariants: levels and properties are checked for the whole pipeline before
//! the first pass runs; after each pass the verifier has accepted the function
//! (unless switched off); the output of instruments never goes to the standard
//! output, which belongs to the result.

mod bisect;
mod given;
mod instrument;
mod measure;
mod plan;
mod settle;
mod walk;

pub use bisect::{Executed, LIMIT, Limit};
pub use given::check_schedules;
pub(crate) use instrument::difference;
pub use instrument::{Dump, DumpState, PassFilter, PrintChanged};
pub use measure::usage;
pub use plan::PlanError;
pub use walk::apply;

use crate::check::{self, CheckVerdict, Promise};
use crate::differentiation::Differentiation;
use crate::instances::Instances;
use crate::pass::{
    Artifact, Context, NestedReport, Pass, PassError, PassInfo, Registry, TargetFolder,
};
use crate::pipeline::{PassStep, Pipeline};
use crate::rewrite_limit::RewriteLimit;
use crate::scene::Scene;
use crate::trail::{self, Follower, Notes, Trail};
use instrument::Instruments;
use measure::Meter;
use robovec_analysis::class::NumericClass;
use robovec_analysis::rounding::{RoundingErrors, rounding, usual_states};
use robovec_ir::states::States;
use robovec_ir::{Function, Level, Machine, Module, Tables, View, verify};
use robovec_rules::RuleSet;
use settle::{pass_failed, settled};
use std::any::Any;
use std::borrow::Cow;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use walk::PipelineWalk;

/// Called before each pass with its ordinal, the number of all, its name.
pub type Progress<'a> = dyn FnMut(usize, usize, &str) + 'a;

/// The settings with which a pipeline is run.
pub struct Config<'a> {
    /// The machine compiled for.
    pub machine: &'a Machine,
    /// The rules that rewriting may use; those that ship when `None`.
    pub rules: Option<&'a RuleSet>,
    /// Run the verifier after every pass.
    pub verify_each: bool,
    /// Compare the function before and after every pass at this many points.
    pub check_each: Option<u32>,
    /// Measure the rounding errors in binary32 before and after every pass,
    /// over this number of states; `Some(0)` means [`usual_states`] of the
    /// function as it was read.
    pub rounding: Option<u32>,
    /// The source of random states; their seed is also that of the points of
    /// the prime field.
    pub states: States,
    /// The scene that the functions are needed for. States should be its own
    /// ([`Scene::states`]).
    pub scene: Option<&'a Scene>,
    /// Target of code generation that the user described.
    pub target: Option<&'a TargetFolder>,
    /// Print the function before these passes.
    pub print_before: PassFilter,
    /// Print the function after these passes.
    pub print_after: PassFilter,
    /// Print the function after passes that changed it.
    pub print_changed: Option<PrintChanged>,
    /// Receives every state of every function.
    pub dump: Option<&'a mut dyn Dump>,
    /// Keep with every value the passes and rules that made it.
    pub histories: bool,
    /// Receives every state that a pass changed, for
    /// [`explain`](crate::trail::explain).
    pub trail: Option<&'a mut Trail>,
    /// Receives printed output, and the remarks of the passes.
    pub log: &'a mut dyn io::Write,
    /// Called before each pass of each function.
    pub progress: Option<&'a mut Progress<'a>>,
    /// Stop here, and log which passes run.
    pub limit: Option<Limit>,
    /// Receives every pass that is started.
    pub executed: Option<&'a mut Vec<Executed>>,
    /// True if the remarks of the passes are printed.
    pub remarks: bool,
    /// Keep a record of every pass, for which the function is measured after
    /// each; without them the outcome has none. The measurement of rounding
    /// errors and of changes needs them, and they are kept for these anyway.
    pub records: bool,
}

impl<'a> Config<'a> {
    /// The verifier after every pass, and no other instrument.
    pub fn new(machine: &'a Machine, log: &'a mut dyn io::Write) -> Config<'a> {
        Config {
            machine,
            rules: None,
            verify_each: true,
            check_each: None,
            rounding: None,
            states: States::new(1),
            scene: None,
            target: None,
            print_before: PassFilter::None,
            print_after: PassFilter::None,
            print_changed: None,
            dump: None,
            histories: false,
            trail: None,
            log,
            progress: None,
            limit: None,
            executed: None,
            remarks: true,
            records: true,
        }
    }
}

/// The record of one pass on one function.
#[derive(Clone, PartialEq, Debug)]
pub struct PassRecord {
    /// The function.
    pub function: String,
    /// The pass with its options, as in the pipeline.
    pub name: String,
    /// True if the function is another one now.
    pub changed: bool,
    /// CPU time in seconds.
    pub cpu_s: f64,
    /// Largest memory of the process so far, in megabytes of 10^6 bytes; 0
    /// where the system does not report it.
    pub peak_mb: f64,
    /// Operations after the pass: everything but sines, cosines and copies.
    pub operations: u64,
    /// Length of the longest chain after the pass, in cycles.
    pub asap_cycle: u32,
    /// The counts of the pass.
    pub statistics: Vec<(&'static str, u64)>,
    /// The outcome of the semantic check.
    pub check: Option<CheckVerdict>,
    /// Rounding errors before and after, when they were requested.
    pub rounding: Option<[Arc<RoundingErrors>; 2]>,
}

/// The outcome of a run besides the module.
#[derive(Default, Debug)]
pub struct RunOutcome {
    /// One record per pass and function, in order, if they are kept.
    pub records: Vec<PassRecord>,
    /// Files produced by code generation.
    pub artifacts: Vec<Artifact>,
}

/// The reason why a pipeline stopped.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The pipeline cannot work on this module.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A pass gave up.
    #[error("{pass}, function '{function}': {error}")]
    Pass {
        /// The pass, as in the pipeline.
        pass: String,
        /// The function.
        function: String,
        /// Its reason.
        error: PassError,
    },
    /// A pass panicked: a mistake in the pass.
    #[error(
        "{pass}, function '{function}': the pass panicked; this is a mistake in the pass\n{message}"
    )]
    Panic {
        /// The pass, as in the pipeline.
        pass: String,
        /// The function.
        function: String,
        /// The message of the panic.
        message: String,
    },
    /// The verifier refuses the input of the pipeline; no pass is at fault.
    #[error(
        "function '{function}' is wrong as it was read, before any pass\n{}",
        violations.join("\n")
    )]
    Given {
        /// The function.
        function: String,
        /// The violations that the verifier found.
        violations: Vec<String>,
        /// The advice to the user.
        help: String,
    },
    /// The verifier refuses the result of a pass: a mistake in the pass.
    #[error(
        "{pass}, function '{function}': the result is not valid; this is a mistake in the pass\n{}",
        violations.join("\n")
    )]
    Verify {
        /// The pass, as in the pipeline.
        pass: String,
        /// The function.
        function: String,
        /// The violations that the verifier found.
        violations: Vec<String>,
    },
    /// The semantic check refuses the result of a pass: a mistake in the pass.
    #[error(
        "{pass}, function '{function}': the pass changed the function; this is a mistake in the pass\n{reason}"
    )]
    Check {
        /// The pass, as in the pipeline.
        pass: String,
        /// The function.
        function: String,
        /// The difference.
        reason: String,
    },
    /// A dump or log could not be written.
    #[error("cannot write: {0}")]
    Io(#[from] io::Error),
}

/// Runs a pipeline over every function of a module.
///
/// # Errors
///
/// See [`RunError`]; the module is then left half way and must not be used.
pub fn run(
    module: &mut Module,
    pipeline: &Pipeline,
    config: Config<'_>,
) -> Result<RunOutcome, RunError> {
    plan::check(module, pipeline)?;
    given::check(module, pipeline, config.machine)?;
    let rules = config.rules.map(Cow::Borrowed);
    let mut run = PipelineRun {
        registry: pipeline.registry,
        rules: rules.unwrap_or_else(|| Cow::Owned(RuleSet::built_in())),
        instruments: Instruments::new(config),
        outcome: RunOutcome::default(),
        ordinal: 0,
        index: 0,
        fingerprint: 0,
        rounding: None,
        total: pipeline.passes().count() * module.functions.len(),
        repeats: pipeline.repeats(),
    };
    let tables = &mut module.tables;
    for (index, function) in module.functions.iter_mut().enumerate() {
        run.index = index;
        if run.instruments.config.histories {
            trail::begin(function);
        }
        run.instruments.start(tables, function)?;
        run.take_fingerprint(function);
        run.rounding = run.instruments.config.rounding.map(|states| {
            let states = match states {
                0 => usual_states(function.nodes().len()),
                states => states,
            };
            let view = View { tables, function };
            let measured = rounding(view, &run.instruments.config.states, states);
            (measure::computation(function), Arc::new(measured))
        });
        run.steps(pipeline, tables, function)?;
    }
    Ok(run.outcome)
}

/// The claim about the effect of a pass.
struct Claim {
    class: NumericClass,
    /// Of a pass that makes several instances of a function.
    instances: Option<Instances>,
    /// Of a pass that differentiates.
    differentiation: Option<Differentiation>,
    /// Of an approximating pass.
    promise: Option<Promise>,
}

struct PipelineRun<'a> {
    registry: &'static Registry,
    rules: Cow<'a, RuleSet>,
    instruments: Instruments<'a>,
    outcome: RunOutcome,
    ordinal: usize,
    total: usize,
    /// Of the function.
    index: usize,
    /// Fingerprint of the current function, if requested.
    fingerprint: u64,
    /// The pipeline has groups that end at a fixed point.
    repeats: bool,
    /// Its rounding errors, with the fingerprint of its computation.
    rounding: Option<(u64, Arc<RoundingErrors>)>,
}

impl PipelineRun<'_> {
    fn steps(
        &mut self,
        pipeline: &Pipeline,
        tables: &mut Tables,
        function: &mut Function,
    ) -> Result<(), RunError> {
        let mut walk = PipelineWalk::new(pipeline);
        while let Some(step) = walk.next(self.fingerprint) {
            self.pass(step, tables, function)?;
        }
        Ok(())
    }

    /// Computes the fingerprint of the current function, where a record or a
    /// group of passes will be compared with it.
    fn take_fingerprint(&mut self, function: &Function) {
        if self.repeats || self.instruments.keeps_records() {
            self.fingerprint = measure::fingerprint(function);
        }
    }

    fn pass(
        &mut self,
        step: &PassStep,
        tables: &mut Tables,
        function: &mut Function,
    ) -> Result<(), RunError> {
        self.ordinal += 1;
        let name = step.to_string();
        let Some(limit) = self.limit(&name, function)? else {
            return Ok(());
        };
        if let Some(progress) = &mut self.instruments.config.progress {
            progress(self.ordinal, self.total.max(self.ordinal), &name);
        }
        // The pipeline was read, so the options are known to be right.
        let pass = (step.info.build)(&step.options)
            .map_err(|error| pass_failed(&name, function, PassError::new(error.to_string())))?;
        self.instruments.before(step, tables, function)?;
        let before = self.instruments.keeps_before().then(|| function.clone());
        let fingerprint = self.fingerprint;
        let meter = Meter::start();
        let follower = Follower::start(function);
        let wanted = follower.is_some() || self.instruments.config.trail.is_some();
        let rewrites = RewriteLimit::new(limit);
        let ran = self.execute(pass.as_ref(), wanted, &rewrites, tables, function);
        self.note_rewrites(step, &rewrites);
        let mut report = settled(ran, &name, function)?;
        self.outcome.artifacts.append(&mut report.artifacts);
        measure::forget_stale_properties(step.info, function);
        let (cpu_s, peak_mb) = meter.stop();
        if let Some(follower) = follower {
            follower.finish(tables, function, &name, &report.notes);
        }
        self.take_fingerprint(function);
        self.tell(&name, function, &report.remarks)?;
        self.verify(step.info, &name, tables, function)?;
        let claim = Claim {
            class: pass.class(step.info.class),
            instances: pass.instances(),
            differentiation: pass.differentiation(),
            promise: report.promise,
        };
        let versions = before.as_ref().map(|before| {
            let old = report.witness.as_ref().unwrap_or(function);
            [before, old, function]
        });
        let check = self.check_if_wanted(&claim, &name, tables, versions)?;
        if let Some(verdict) = check.as_ref().filter(|verdict| !verdict.is_complete()) {
            let log = &mut self.instruments.config.log;
            writeln!(log, "warning: {}: {name}: {verdict}", function.name)?;
        }
        let record = self.instruments.keeps_records().then(|| {
            // Only what the verifier has accepted can be measured.
            let (operations, asap_cycle) = measure::size(function, self.instruments.config.machine);
            PassRecord {
                function: function.name.clone(),
                changed: self.fingerprint != fingerprint,
                cpu_s,
                peak_mb,
                operations,
                asap_cycle,
                statistics: report.statistics,
                check,
                rounding: self.measure_rounding(tables, function),
                name,
            }
        });
        self.instruments
            .after(step, tables, before.as_ref(), function, record.as_ref())?;
        let Some(record) = record else {
            return Ok(());
        };
        if let (Some(trail), Some(before), true) =
            (&mut self.instruments.config.trail, before, record.changed)
        {
            trail.add(before, &record.name, report.notes);
        }
        self.outcome.records.push(record);
        Ok(())
    }

    /// Runs a pass over a function; the result is its report, its error, or the
    /// message of its panic. After a panic the partly changed state is not used
    /// again.
    fn execute(
        &self,
        pass: &dyn Pass,
        notes_wanted: bool,
        rewrites: &RewriteLimit,
        tables: &mut Tables,
        function: &mut Function,
    ) -> Result<Result<NestedReport, PassError>, Box<dyn Any + Send>> {
        let mut report = NestedReport::default();
        if notes_wanted {
            report.notes = Notes::wanted();
        }
        let mut context = Context {
            tables,
            machine: self.instruments.config.machine,
            registry: self.registry,
            rules: &self.rules,
            scene: self.instruments.config.scene,
            target: self.instruments.config.target,
            witness: &mut report.witness,
            promise: &mut report.promise,
            artifacts: &mut report.artifacts,
            statistics: &mut report.statistics,
            remarks: &mut report.remarks,
            notes: &mut report.notes,
            rewrites,
        };
        let formats = function.formats.is_some();
        let result = catch_unwind(AssertUnwindSafe(|| {
            pass.run(function, &mut context)?;
            measure::check_formats(formats, function)
        }))?;
        Ok(result.map(|()| report))
    }

    /// Notes the rewrites a pass did, for the search of the first wrong one.
    fn note_rewrites(&mut self, step: &PassStep, rewrites: &RewriteLimit) {
        if let Some(executed) = &mut self.instruments.config.executed {
            executed.push(Executed {
                function: self.index,
                step: step.clone(),
                rewrites: rewrites.asked(),
                last: rewrites.last(),
            });
        }
    }

    /// The semantic check of a pass, where one was requested.
    fn check_if_wanted(
        &self,
        claim: &Claim,
        name: &str,
        tables: &Tables,
        versions: Option<[&Function; 3]>,
    ) -> Result<Option<CheckVerdict>, RunError> {
        match (self.instruments.config.check_each, versions) {
            (Some(points), Some(versions)) => {
                let verdict = self.check(claim, name, points, tables, versions)?;
                Ok(Some(verdict))
            }
            _ => Ok(None),
        }
    }

    /// Prints the remarks of a pass.
    fn tell(&mut self, name: &str, function: &Function, remarks: &[String]) -> io::Result<()> {
        if !self.instruments.config.remarks {
            return Ok(());
        }
        let log = &mut self.instruments.config.log;
        let mut each = remarks.iter();
        each.try_for_each(|remark| writeln!(log, "remark: {}: {name}: {remark}", function.name))
    }

    /// The rounding errors before and after the pass that just ran. A pass
    /// that computes the same, as placement does, is not measured again.
    fn measure_rounding(
        &mut self,
        tables: &Tables,
        function: &Function,
    ) -> Option<[Arc<RoundingErrors>; 2]> {
        let (old, before) = self.rounding.take()?;
        let new = measure::computation(function);
        let after = if new == old {
            before.clone()
        } else {
            let view = View { tables, function };
            Arc::new(rounding(
                view,
                &self.instruments.config.states,
                before.states,
            ))
        };
        self.rounding = Some((new, after.clone()));
        Some([before, after])
    }

    /// The number of rewrites the next pass may do; `None` when it is beyond
    /// the limit.
    fn limit(&mut self, name: &str, function: &Function) -> io::Result<Option<Option<u64>>> {
        let config = &mut self.instruments.config;
        let limit = Limit::of(config.limit, self.ordinal as u64);
        if config.limit.is_some() {
            let verb = if limit.is_some() {
                "running"
            } else {
                "NOT running"
            };
            writeln!(
                config.log,
                "BISECT: {verb} pass ({}) {name} on {}",
                self.ordinal, function.name
            )?;
        }
        Ok(limit)
    }

    fn verify(
        &self,
        info: &PassInfo,
        name: &str,
        tables: &Tables,
        function: &Function,
    ) -> Result<(), RunError> {
        if !self.instruments.config.verify_each {
            return Ok(());
        }
        let view = View { tables, function };
        let found = match function.level {
            Level::Placed => verify::verify_placement(view, self.instruments.config.machine),
            Level::Equations | Level::Atomic | Level::Scheduled => verify::verify(view),
        };
        let mut violations: Vec<String> = found
            .into_iter()
            .map(|violation| violation.message)
            .collect();
        if let crate::pass::Gives::Level(level) = info.gives
            && function.level != level
        {
            violations.push(format!("the level is {}, not {level}", function.level));
        }
        if violations.is_empty() {
            return Ok(());
        }
        Err(RunError::Verify {
            pass: name.to_owned(),
            function: function.name.clone(),
            violations,
        })
    }

    fn check(
        &self,
        claim: &Claim,
        name: &str,
        points: u32,
        tables: &Tables,
        versions: [&Function; 3],
    ) -> Result<CheckVerdict, RunError> {
        let [before, witness, after] = versions.map(|function| View { tables, function });
        let config = &self.instruments.config;
        let class = claim.class;
        let verdict = if let Some(instances) = &claim.instances {
            let states = &config.states;
            check::check_instances(before, after, instances, class, states, points)
        } else if let Some(differentiation) = &claim.differentiation {
            check::check_derivative(before, after, differentiation, &config.states, points)
        } else if std::ptr::eq(witness.function, after.function) {
            let claim = (class, claim.promise.as_ref());
            check::check_promise(before, after, claim, &config.states, points)
        } else {
            let subject = check::Specialised {
                before,
                witness,
                after,
                scene: config.scene,
            };
            check::check_specialised(subject, class, &config.states, points)
        };
        if verdict.holds() {
            return Ok(verdict);
        }
        Err(RunError::Check {
            pass: name.to_owned(),
            function: after.function.name.clone(),
            reason: verdict.to_string(),
        })
    }
}
