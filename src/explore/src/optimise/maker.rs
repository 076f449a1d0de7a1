//! Programs made on all cores, each from a separate module, and kept on disk.

use super::start::{OptimisationStart, PreparedStarts};
use super::{OptimisationError, OptimisationQuestion};
use crate::ExplorationProgress;
use crate::program::{ExplorationError, transformed, view};
use crate::share::WorkShare;
use crate::store::PointKey;
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
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

#[derive(Clone, Debug)]
pub(super) struct MadeProgram {
    pub module: Arc<Module>,
    /// Key of its start and passes; `None` where nothing is kept.
    key: Option<PointKey>,
    /// The passes from its start on, where it was read from disk: passes may
    /// differ, as a text does not keep the order of symbols.
    read: Option<String>,
}

/// Work of a maker.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct MakerTally {
    /// Programs that were requested.
    pub programs: usize,
    /// Number of those stored by an earlier run or another worker.
    pub found: usize,
}

/// Part of a program that is kept.
#[derive(Serialize, Deserialize)]
enum KeptProgram {
    Text(String),
    /// Reason why a pass gave up.
    Failure(String),
}

/// All programs of a search.
pub(super) fn programs(
    starts: &[OptimisationStart],
    prepared: &PreparedStarts,
    question: &OptimisationQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<(SearchOutcome<MadeProgram>, MakerTally), ExplorationError> {
    let mut maker = ParallelMaker {
        question,
        progress,
        starts: &prepared.modules,
        tally: MakerTally::default(),
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
    let outcome = search(&mut maker, starts, search_question)
        .map_err(|error| ExplorationError::Pass(error.to_string()))?;
    Ok((outcome, maker.tally))
}

/// Maximum number of programs that are placed beside those of the search.
const NEARBY: usize = 16;

/// Places programs that the search passed over as no shorter: those with a
/// bound near the best one's may be as fast, and more exact.
pub(super) fn place_nearby(
    outcome: &mut SearchOutcome<MadeProgram>,
    prepared: &PreparedStarts,
    question: &OptimisationQuestion<'_>,
    progress: ExplorationProgress<'_>,
) {
    // Nothing is placed for a processor.
    let Some(cycles) = outcome.best.and_then(|best| outcome.trials[best].cycles) else {
        return;
    };
    let limit = cycles + cycles / 100;
    let mut nearby: Vec<(u32, usize)> = Vec::new();
    for (index, trial) in outcome.trials.iter().enumerate() {
        if let (Ok(bound), None) = (&trial.bound, trial.cycles)
            && *bound <= limit
        {
            nearby.push((*bound, index));
        }
    }
    nearby.sort_unstable();
    nearby.truncate(NEARBY);
    let programs = nearby
        .iter()
        .map(|(_, index)| &outcome.trials[*index].program);
    let programs: Vec<&MadeProgram> = programs.collect();
    let mut maker = ParallelMaker {
        question,
        progress,
        starts: &prepared.modules,
        tally: MakerTally::default(),
    };
    let sizes = maker.schedules(&programs, question.machine);
    for ((_, index), size) in nearby.into_iter().zip(sizes) {
        if let Ok(ScheduleSize { cycles, words }) = size {
            let trial = &mut outcome.trials[index];
            (trial.cycles, trial.words, trial.remark) = (Some(cycles), Some(words), "");
        }
    }
}

/// A program of a search in its original form, if its text was read from disk.
pub(super) fn as_made(
    trial: &VariantTrial<MadeProgram>,
    prepared: &PreparedStarts,
    question: &OptimisationQuestion<'_>,
) -> Result<Arc<Module>, OptimisationError> {
    let maker = ParallelMaker {
        question,
        progress: &|_| {},
        starts: &prepared.modules,
        tally: MakerTally::default(),
    };
    maker
        .as_made(&trial.program, trial.start)
        .map_err(|error| ExplorationError::Pass(error.to_string()).into())
}

struct ParallelMaker<'a> {
    question: &'a OptimisationQuestion<'a>,
    progress: ExplorationProgress<'a>,
    starts: &'a [Arc<Module>],
    tally: MakerTally,
}

/// Programs that jobs start from, made again, each once, by start and passes.
type AgainMade = BTreeMap<(usize, String), OnceLock<Result<Arc<Module>, PassError>>>;

impl ParallelMaker<'_> {
    fn start_key(&self, module: &Module) -> Option<PointKey> {
        let key = self.question.work.key("optimise")?;
        Some(key.with_machine(self.question.machine).with_module(module))
    }

    /// A program from disk, or made.
    fn program(
        &self,
        job: &SearchJob<MadeProgram>,
        again: &AgainMade,
    ) -> Result<MadeProgram, PassError> {
        (self.progress)(&job.passes);
        let key = job
            .program
            .key
            .map(|key| key.with(&job.pipeline.to_string()));
        match self.question.work.load(key) {
            Some(KeptProgram::Failure(message)) => return Err(PassError::new(message)),
            Some(KeptProgram::Text(text)) => {
                let module = parse_module("program", &text);
                if let Ok(module) = module {
                    return Ok(MadeProgram {
                        module: Arc::new(module),
                        key,
                        read: Some(job.passes.clone()),
                    });
                }
            }
            None => {}
        }
        let origin = match &job.program.read {
            None => Ok(job.program.module.clone()),
            Some(passes) => again[&(job.start, passes.clone())]
                .get_or_init(|| self.as_made(&job.program, job.start))
                .clone(),
        };
        let made = origin.and_then(|module| self.run(&module, &job.pipeline));
        if key.is_some() {
            let kept = match &made {
                Ok(module) => KeptProgram::Text(print_module(module)),
                Err(error) => KeptProgram::Failure(error.to_string()),
            };
            self.question.work.save(key, &kept);
        }
        made.map(|module| MadeProgram {
            module,
            key,
            read: None,
        })
    }

    /// A program in its original form, not as read from its text.
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
        let origins = jobs.iter().filter_map(|job| {
            let read = job.program.read.as_ref()?;
            Some(((job.start, read.clone()), OnceLock::new()))
        });
        let again: AgainMade = origins.collect();
        // The longest work begins first, so that no thread is left with it.
        let mut order: Vec<usize> = (0..jobs.len()).collect();
        order.sort_by_key(|&index| (Reverse(jobs[index].work), index));
        let made = own_first(self.question.work.share, &order, |index| {
            maker.program(&jobs[index], &again)
        });
        let is_found = |made: &&Result<MadeProgram, PassError>| {
            (made.as_ref()).is_ok_and(|program| program.read.is_some())
        };
        self.tally.programs += made.len();
        self.tally.found += made.iter().filter(is_found).count();
        made
    }

    fn function(program: &MadeProgram) -> &Function {
        view(&program.module).function
    }

    fn schedules(
        &mut self,
        programs: &[&MadeProgram],
        machine: &Machine,
    ) -> Vec<Result<ScheduleSize, PlaceError>> {
        (self.progress)("placing");
        let work = self.question.work;
        let order: Vec<usize> = (0..programs.len()).collect();
        own_first(work.share, &order, |index| {
            let key = programs[index].key.map(|key| key.with("schedule"));
            if let Some((cycles, words)) = work.load(key) {
                return Ok(ScheduleSize { cycles, words });
            }
            let size = schedule_size(Self::function(programs[index]), machine)?;
            work.save(key, &(size.cycles, size.words));
            Ok(size)
        })
    }
}

/// Does work on all cores, a share's first; results keep their order.
fn own_first<T: Send>(
    share: WorkShare,
    order: &[usize],
    piece: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let mut done: Vec<(usize, T)> = Vec::with_capacity(order.len());
    for part in share.own_and_others(order.len()) {
        let part = part.into_par_iter().with_max_len(1);
        let part = part.map(|place| (order[place], piece(order[place])));
        done.extend(part.collect::<Vec<(usize, T)>>());
    }
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}
