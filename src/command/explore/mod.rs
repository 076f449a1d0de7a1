//! `robovec explore`: programs, designs of machines, or a plan of both.

mod designs;
mod plan;

use super::flags::{SEED, real, states, whole};
use super::shares::ShareArguments;
use super::subjects::named_model;
use super::{CommandFailure, generation, input, output, progress};
use ExplorationKind::{Designs, Plan, Programs};
use clap::Args;
use designs::DesignArguments;
use robovec_dynamics::generate::{Formulation, Options};
use robovec_explore::ExplorationProgress;
use robovec_explore::exploration::{self, Exploration, Explored, ExploredFunction};
use robovec_explore::front::{FrontQuestion, front};
use robovec_explore::optimise::start::FORMULATIONS;
use robovec_explore::program::ExplorationError;
use robovec_explore::share::{SharedWork, WorkShare};
use robovec_explore::study::plan::ELEMENTS;
use robovec_ir::count::Counts;
use robovec_ir::states::{Ranges, States};
use robovec_robotran::FunctionKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Compare programs (speed against error) or machines (resources against time),
/// or run a plan: measure every combination and list the best
#[derive(Args, Debug)]
pub(super) struct ExploreArguments {
    /// Files of equations, models (.mbs, .urdf, .xml) or built-in models (serial-23,
    /// bogie); with --plan they replace the models of the plan, or select some
    /// by name
    #[arg(required_unless_present = "plan")]
    subjects: Vec<String>,
    /// Function of the models; dirdyna by default
    #[arg(long)]
    function: Option<String>,
    /// Machine to compile for: a name or a .toml file; by default solver for
    /// equations that divide and thesis for others. With --plan several
    /// machines are allowed and replace those of the plan; `couples` means
    /// those of Table 1.3
    #[arg(long, value_delimiter = ',')]
    machine: Vec<String>,
    /// Numbers of elements per kind; by default 4,16,64, or those of the plan
    #[arg(long, value_delimiter = ',', value_name = "NUMBERS", add = super::flags::FlagLimit(ELEMENTS))]
    elements: Vec<u32>,
    /// Pipeline, as in robovec-opt or by its name in the plan; repeat the
    /// option for several. Each design uses the pipeline with the shortest
    /// schedule. By default the pipelines that 'robovec optimise' finds are
    /// used
    #[arg(long)]
    passes: Vec<String>,
    /// Random states; by default the more the smaller the function is
    #[arg(long, add = states(0, 100_000))]
    states: Option<u32>,
    /// Seed of the states; 1 by default
    #[arg(long, add = SEED)]
    seed: Option<u64>,
    /// Also time the programs on one core of this computer, with the C compiler 'cc'
    #[arg(long, conflicts_with = "shard")]
    cpu: bool,
    /// Folder for explore.html, .csv, .json and .svg, or tables/ and figures/ of a plan, and for
    /// the points
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    shares: ShareArguments,
    /// Number of threads; by default the number of processors
    #[arg(long, add = whole(1, 1024, "every thread takes memory"))]
    jobs: Option<u32>,
    /// Positions q of programs are drawn from -ANGLE to ANGLE (rad, m); 0.1 by default
    #[arg(long, help_heading = "Programs",
          add = real(1e-12, 1e6, "smaller positions are zero in every format, and no joint moves further"))]
    angle: Option<f64>,
    #[command(flatten, next_help_heading = "Designs of machines")]
    designs: Option<DesignArguments>,
    /// Plan of models, pipelines and machines: a .toml file, or `thesis` for
    /// the study of the thesis
    #[arg(long, help_heading = "Plans", value_name = "FILE", requires = "output")]
    plan: Option<String>,
    /// Leave functions with more operations than this out of --cpu; 200000 by default
    #[arg(long, help_heading = "Plans", value_name = "OPERATIONS",
          add = whole(0, 100_000_000, "beyond some million operations compiling takes minutes"))]
    cpu_limit: Option<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum ExplorationKind {
    Programs,
    Designs,
    Plan,
}

impl ExplorationKind {
    /// Its name, and the words that request it.
    fn texts(self) -> [&'static str; 2] {
        match self {
            Programs => ["programs", "leave '--plan' and the options of machines out"],
            Designs => ["designs of machines", "add '--designs'"],
            Plan => ["a plan", "add '--plan'"],
        }
    }
}

impl ExploreArguments {
    fn kind(&self) -> ExplorationKind {
        match (&self.plan, &self.designs) {
            (Some(_), _) => Plan,
            (None, Some(_)) => Designs,
            (None, None) => Programs,
        }
    }

    /// Refuses words that the kind of exploration does not take.
    fn check_words(&self) -> Result<(), CommandFailure> {
        let both: &[ExplorationKind] = &[Programs, Designs];
        let words: [(bool, &str, &[ExplorationKind]); 9] = [
            (self.function.is_some(), "--function", both),
            (self.states.is_some(), "--states", both),
            (self.seed.is_some(), "--seed", both),
            (self.angle.is_some(), "--angle", &[Programs]),
            (!self.machine.is_empty(), "--machine", &[Programs, Plan]),
            (!self.elements.is_empty(), "--elements", &[Programs, Plan]),
            (!self.passes.is_empty(), "--passes", &[Designs, Plan]),
            (
                self.designs.is_some(),
                "--designs and options of machines",
                &[Designs],
            ),
            (self.cpu_limit.is_some(), "--cpu-limit", &[Plan]),
        ];
        let kind = self.kind();
        let [name, _] = kind.texts();
        let mut wrong = words.iter().filter(|(given, ..)| *given);
        if let Some((_, word, takers)) = wrong.find(|(.., takers)| !takers.contains(&kind)) {
            let notes = takers.iter().map(|taker| {
                let [taker, advice] = taker.texts();
                format!("for {taker}, {advice}")
            });
            let message = format!("{word}: not for an exploration of {name}");
            return Err(CommandFailure::advised(message, notes.collect()));
        }
        if kind == Programs && self.machine.len() > 1 {
            let notes = vec![format!("for {}, {}", Plan.texts()[0], Plan.texts()[1])];
            let message = "--machine: expected one machine for an exploration of programs";
            return Err(CommandFailure::advised(message, notes));
        }
        Ok(())
    }
}

pub(super) fn run(arguments: &ExploreArguments) -> Result<String, CommandFailure> {
    arguments.check_words()?;
    super::require_compiler(arguments.cpu)?;
    let pool = super::threads(arguments.jobs)?;
    pool.install(|| match (&arguments.plan, &arguments.designs) {
        (Some(plan), _) => plan::run(arguments, plan),
        (None, Some(axes)) => designs::run(arguments, axes),
        (None, None) => programs(arguments),
    })
}

/// Explores one subject after the other, and writes complete results.
fn each<E: Exploration>(
    arguments: &ExploreArguments,
    angle: Option<f64>,
    explore: impl Fn(
        ExploredFunction,
        SharedWork<'_>,
        ExplorationProgress<'_>,
    ) -> Result<Result<Explored<E>, ExplorationError>, CommandFailure>,
) -> Result<String, CommandFailure> {
    let shares = &arguments.shares;
    let store = shares.store(arguments.output.as_deref())?;
    let work = SharedWork::new(store.as_ref(), shares.share());
    let bar = progress::spinner();
    let mut text = String::new();
    let mut results: Vec<E> = Vec::new();
    for subject in &arguments.subjects {
        let function = function(subject, arguments, angle)?;
        let name = function.name.clone();
        let told = |what: &str| bar.set_message(format!("{name}: {what}"));
        let explored = explore(function, work, &told)?;
        match explored.map_err(|error| CommandFailure::plain(format!("{name}: {error}")))? {
            Explored::Share(pieces, found) => {
                text += &format!("{name}: {pieces}, {found} of them found\n");
            }
            Explored::Whole(result) => {
                text += &result.text(progress::is_verbose());
                text.push('\n');
                results.push(result);
            }
        }
    }
    bar.finish_and_clear();
    if let (Some(folder), WorkShare::ALL) = (&arguments.output, shares.share()) {
        output::write_files(folder, &exploration::files(&results))?;
    }
    Ok(text.trim_end().to_owned() + "\n")
}

/// A function with its formulations; unknown positions lie within an angle.
fn function(
    subject: &str,
    arguments: &ExploreArguments,
    angle: Option<f64>,
) -> Result<ExploredFunction, CommandFailure> {
    let wanted = arguments.function.as_deref().unwrap_or("dirdyna");
    let (name, model) = named_model(subject)?;
    let mut others = Vec::new();
    let (module, mut ranges) = match model {
        None => {
            let read = input::equations(Path::new(subject), None)?;
            let mut module = read.module;
            if module.functions.len() != 1 {
                super::opt::select(&mut module, wanted)?;
            }
            (module, read.ranges)
        }
        Some(model) => {
            let kind = FunctionKind::from_name(wanted);
            let kind = kind.ok_or_else(|| input::no_such_kind(wanted))?;
            let equations = |formulation| {
                generation::functions(&model, &[kind], formulation, &Options::default())
            };
            for formulation in FORMULATIONS {
                if formulation.gives(kind) {
                    others.push((formulation, equations(formulation)?));
                }
            }
            (equations(Formulation::Recursive)?, Ranges::default())
        }
    };
    let mut inputs = module.functions[0].inputs().iter();
    let positions = inputs.find(|array| module.tables.symbols.text(array.name) == "q");
    if let (Some(angle), Some(array)) = (angle, positions) {
        for offset in 0..array.shape.len() as u32 {
            let indices = array.shape.indices(offset).0;
            if ranges.get("q", indices).is_none() {
                ranges.set("q", indices, -angle, angle);
            }
        }
    }
    let operations = Counts::of(&module.functions[0]).operations;
    let states = States::new(arguments.seed.unwrap_or(1)).within(Arc::new(ranges));
    Ok(ExploredFunction {
        name,
        module,
        others,
        states,
        count: match arguments.states {
            None | Some(0) => robovec_analysis::rounding::usual_states(operations),
            Some(count) => count,
        },
    })
}

/// Numbers of elements per kind, unless the user names others.
const USUAL_ELEMENTS: [u32; 3] = [4, 16, 64];

/// Explores programs: speed against error.
fn programs(arguments: &ExploreArguments) -> Result<String, CommandFailure> {
    let angle = arguments.angle.unwrap_or(0.1);
    each(arguments, Some(angle), |function, work, progress| {
        let machine = match arguments.machine.first() {
            Some(machine) => input::machine(machine)?,
            None => input::machine(input::usual_machine(&function.module.functions[0])?)?,
        };
        let question = FrontQuestion {
            machine: &machine,
            elements: match arguments.elements.as_slice() {
                [] => &USUAL_ELEMENTS,
                elements => elements,
            },
            angle,
            cpu: arguments.cpu,
            work,
        };
        Ok(front(function, &question, progress))
    })
}
