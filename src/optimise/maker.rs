//! Programs made on all cores, each from a module of its own, and remembered
//! on disk.

use super::start::{OptimisationStart, PreparedStarts};
use super::{OptimisationError, OptimisationQuestion};
use crate::explore::ExplorationProgress;
use crate::explore::program::{ExplorationError, transformed, view};
use crate::explore::store::{PointKey, build_key};
use rayon::prelude::*;
use robovec_framework::pass::PassError;
use robovec_framework::pipeline::Pipeline;
use robovec_ir::count::Counts;
use robovec_ir::parse::parse_module;
use robovec_ir::print::print_module;
use robovec_ir::{Function, Machine, Module};
use robovec_passes::optimise::search::{
    ProgramMaker, ScheduleSize, SearchJob, SearchOutcome, SearchQuestion, SearchStart,
    schedule_size, search, usual_unit,
};
use robovec_passes::optimise::trial::VariantTrial;
use robovec_passes::registry::REGISTRY;
use robovec_schedule::PlaceError;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::sync::Arc;

/// A program of the search.
#[derive(Clone, Debug)]
pub struct MadeProgram {
    /// The module, with one function.
    pub module: Arc<Module>,
    /// What it was made from and by; `None` where nothing is kept.
    key: Option<PointKey>,
    /// The passes from its start on, where it was read from disk: passes may
    /// go another way from there, since texts do not tell in which order
    /// symbols were first met.
    read: Option<String>,
}

/// What is kept of a program.
#[derive(Serialize, Deserialize)]
enum KeptProgram {
    /// Its text.
    Text(String),
    /// Why a pass gave up.
    Failure(String),
}

/// All programs of a search.
pub(super) fn programs(
    starts: &[OptimisationStart],
    prepared: &PreparedStarts,
    question: &OptimisationQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<SearchOutcome<MadeProgram>, ExplorationError> {
    let mut maker = ParallelMaker {
        question,
        progress,
        build: build_key().ok(),
        starts: &prepared.modules,
    };
    let sizes = prepared.modules.iter();
    let sizes = sizes.map(|module| Counts::of(view(module).function).operations);
    let operations = sizes.min().expect("a search has starts");
    let search_question = SearchQuestion {
        machine: question.machine,
        goal: question.target.goal(),
        class: question.class.numeric(),
        registry: &REGISTRY,
        effort: question.effort,
        unit: usual_unit(operations),
    };
    let named = starts.iter().zip(&prepared.modules);
    let starts = named.map(|(start, module)| SearchStart {
        name: start.name.clone(),
        form: start.form,
        program: MadeProgram {
            key: maker.start_key(module),
            module: module.clone(),
            read: None,
        },
    });
    let starts = starts.collect();
    search(&mut maker, starts, search_question)
        .map_err(|error| ExplorationError::Pass(error.to_string()))
}

/// A program of a search as it was made, where its text was read from disk.
pub(super) fn as_made(
    trial: &VariantTrial<MadeProgram>,
    prepared: &PreparedStarts,
    question: &OptimisationQuestion<'_>,
) -> Result<Arc<Module>, OptimisationError> {
    let maker = ParallelMaker {
        question,
        progress: &|_| {},
        build: None,
        starts: &prepared.modules,
    };
    maker
        .as_made(&trial.program, trial.start)
        .map_err(|error| ExplorationError::Pass(error.to_string()).into())
}

struct ParallelMaker<'a> {
    question: &'a OptimisationQuestion<'a>,
    progress: ExplorationProgress<'a>,
    /// Of this robovec; programs are kept only where it is known.
    build: Option<PointKey>,
    /// The programs of the starts.
    starts: &'a [Arc<Module>],
}

impl ParallelMaker<'_> {
    fn start_key(&self, module: &Module) -> Option<PointKey> {
        self.question.store?;
        let machine = serde_json::to_string(self.question.machine);
        let machine = machine.expect("a machine is plain data");
        Some(self.build?.with(&machine).with(&print_module(module)))
    }

    /// A program from disk, or made.
    fn program(&self, job: SearchJob<MadeProgram>) -> Result<MadeProgram, PassError> {
        (self.progress)(&job.passes);
        let key = job
            .program
            .key
            .map(|key| key.with(&job.pipeline.to_string()));
        let kept = (self.question.store.zip(key)).and_then(|(store, key)| store.load(key));
        match kept {
            Some(KeptProgram::Failure(message)) => return Err(PassError::new(message)),
            Some(KeptProgram::Text(text)) => {
                let module = parse_module("program", &text);
                if let Ok(module) = module {
                    return Ok(MadeProgram {
                        module: Arc::new(module),
                        key,
                        read: Some(job.passes),
                    });
                }
            }
            None => {}
        }
        let made = self
            .as_made(&job.program, job.start)
            .and_then(|module| self.run(&module, &job.pipeline));
        if let Some((store, key)) = self.question.store.zip(key) {
            let kept = match &made {
                Ok(module) => KeptProgram::Text(print_module(module)),
                Err(error) => KeptProgram::Failure(error.to_string()),
            };
            // A program that cannot be kept is only made again.
            store.save(key, &kept).unwrap_or_default();
        }
        made.map(|module| MadeProgram {
            module,
            key,
            read: None,
        })
    }

    /// A program as it was made, not as its text was read.
    fn as_made(&self, program: &MadeProgram, start: usize) -> Result<Arc<Module>, PassError> {
        let Some(passes) = &program.read else {
            return Ok(program.module.clone());
        };
        let pipeline = REGISTRY.pipeline(passes).expect("it was run before");
        self.run(&self.starts[start], &pipeline)
    }

    fn run(&self, module: &Module, pipeline: &Pipeline) -> Result<Arc<Module>, PassError> {
        let made = transformed(module, pipeline, self.question.machine, self.question.scene);
        made.map(Arc::new)
            .map_err(|error| PassError::new(error.to_string()))
    }
}

impl ProgramMaker for ParallelMaker<'_> {
    type Program = MadeProgram;

    fn make(&mut self, jobs: Vec<SearchJob<MadeProgram>>) -> Vec<Result<MadeProgram, PassError>> {
        let maker = &*self;
        // The longest work begins first, so that no thread is left with it.
        let mut order: Vec<(usize, SearchJob<MadeProgram>)> =
            jobs.into_iter().enumerate().collect();
        order.sort_by_key(|(index, job)| (Reverse(job.work), *index));
        let mut made: Vec<(usize, Result<MadeProgram, PassError>)> = order
            .into_par_iter()
            .with_max_len(1)
            .map(|(index, job)| (index, maker.program(job)))
            .collect();
        made.sort_by_key(|(index, _)| *index);
        made.into_iter().map(|(_, made)| made).collect()
    }

    fn function(program: &MadeProgram) -> &Function {
        view(&program.module).function
    }

    fn schedules(
        &mut self,
        functions: &[&Function],
        machine: &Machine,
    ) -> Vec<Result<ScheduleSize, PlaceError>> {
        (self.progress)("placing");
        let functions = functions.par_iter();
        functions
            .map(|function| schedule_size(function, machine))
            .collect()
    }
}
