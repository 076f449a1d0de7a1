//! `robovec front`: speed against error.

use super::flags::{SEED, real, states, whole};
use super::output::result_files;
use super::shares::ShareArguments;
use super::{CommandFailure, generation, input, output, progress, subjects};
use clap::Args;
use robovec_dynamics::generate::{Formulation, Options};
use robovec_explore::front::{self, Front, FrontQuestion};
use robovec_explore::optimise::start::FORMULATIONS;
use robovec_explore::share::SharedWork;
use robovec_ir::diagnostic::counted;
use robovec_ir::states::{Ranges, States};
use robovec_ir::{Machine, Module};
use robovec_model::Model;
use robovec_present::json::json_text;
use robovec_robotran::FunctionKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Speed against error: every way to compute a function as a point, with the thesis' choices among them
#[derive(Args, Debug)]
pub(super) struct FrontArguments {
    /// Files of equations, models (.mbs, .urdf) or built-in models (serial-23, bogie)
    #[arg(required = true)]
    subjects: Vec<String>,
    /// Function of the models
    #[arg(long, default_value = "dirdyna")]
    function: String,
    /// Machine compiled for: a name or a .toml file; by default thesis, or solver for equations
    /// that divide
    #[arg(long)]
    machine: Option<String>,
    /// Numbers of elements per kind
    #[arg(long, value_delimiter = ',', default_value = "4,16,64",
          add = whole(1, 1024, "a program is placed for every number of elements"))]
    elements: Vec<u32>,
    /// Positions q are drawn from -ANGLE to ANGLE (rad, m)
    #[arg(long, default_value_t = 0.1,
          add = real(1e-12, 1e6, "smaller positions are zero in every format, and no joint moves further"))]
    angle: f64,
    /// Random states; by default the more the smaller the function is
    #[arg(long, default_value_t = 0, hide_default_value = true,
          add = states(0, 100_000))]
    states: u32,
    /// Seed of the states
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// Also time every program on this computer, with the C compiler 'cc'
    #[arg(long, conflicts_with = "shard")]
    cpu: bool,
    /// Folder for front.html, front.csv, front.json and front.svg, and for the points
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    shares: ShareArguments,
}

/// Runs the command.
pub(super) fn run(arguments: &FrontArguments) -> Result<String, CommandFailure> {
    if !(arguments.angle > 0.0 && arguments.angle.is_finite()) {
        return Err(CommandFailure::plain("'--angle' must be a positive number"));
    }
    super::require_compiler(arguments.cpu)?;
    let store = arguments.shares.store(arguments.output.as_deref())?;
    let work = SharedWork::new(store.as_ref(), arguments.shares.share());
    let bar = progress::spinner();
    let mut fronts: Vec<Front> = Vec::new();
    let mut text = String::new();
    let mut machines: Vec<Machine> = Vec::new();
    for subject in &arguments.subjects {
        let subject = programs(subject, &arguments.function)?;
        let FrontSubject {
            name,
            module,
            others,
            mut ranges,
        } = subject;
        add_angles(&mut ranges, &module, arguments.angle);
        let function = &module.functions[0];
        let machine = match &arguments.machine {
            Some(name) => input::machine(name)?,
            None => input::machine(input::usual_machine(function)?)?,
        };
        let operations = robovec_ir::count::Counts::of(function).operations;
        let count = match arguments.states {
            0 => robovec_analysis::rounding::usual_states(operations),
            count => count,
        };
        let states = States::new(arguments.seed).within(Arc::new(ranges));
        let question = FrontQuestion {
            machine: &machine,
            elements: &arguments.elements,
            states: &states,
            count,
            angle: arguments.angle,
            cpu: arguments.cpu,
            work,
        };
        let progress = |choice: &str| bar.set_message(format!("{name}: {choice}"));
        let failure = |error| CommandFailure::plain(format!("{name}: {error}"));
        if arguments.shares.shard.is_some() {
            let share = front::measure_share(&module, others, &question, &progress);
            let share = share.map_err(failure)?;
            let (count, found) = (share.choices, share.found);
            text += &format!(
                "{name}: {}, {found} of them found\n",
                counted(count, "choice")
            );
            continue;
        }
        let front = front::front(&name, &module, others, &question, &progress).map_err(failure)?;
        text += &front::text::text(&front);
        text.push('\n');
        fronts.push(front);
        if !machines.contains(&machine) {
            machines.push(machine);
        }
    }
    bar.finish_and_clear();
    if let (Some(folder), None) = (&arguments.output, arguments.shares.shard) {
        write(folder, &fronts, &machines)?;
    }
    Ok(text)
}

/// Every position of which nothing is known between the same bounds.
fn add_angles(ranges: &mut Ranges, module: &Module, bound: f64) {
    for array in module.functions[0].inputs() {
        if module.tables.symbols.text(array.name) == "q" {
            for offset in 0..array.shape.len() as u32 {
                let indices = array.shape.indices(offset).0;
                if ranges.get("q", indices).is_none() {
                    ranges.set("q", indices, -bound, bound);
                }
            }
        }
    }
}

/// A function alone in a module.
pub(super) struct FrontSubject {
    pub(super) name: String,
    pub(super) module: Module,
    /// The same in other formulations.
    pub(super) others: Vec<(Formulation, Module)>,
    /// The ranges that its file gives inputs.
    pub(super) ranges: Ranges,
}

pub(super) fn programs(subject: &str, function: &str) -> Result<FrontSubject, CommandFailure> {
    let (name, model) = subjects::named_model(subject)?;
    let path = Path::new(subject);
    let Some(model) = model else {
        let read = input::equations(path, None)?;
        let mut module = read.module;
        if module.functions.len() != 1 {
            super::opt::select(&mut module, function)?;
        }
        return Ok(FrontSubject {
            name,
            module,
            others: Vec::new(),
            ranges: read.ranges,
        });
    };
    let kind = FunctionKind::from_name(function).ok_or_else(|| input::no_such_kind(function))?;
    let module = equations(&model, kind, Formulation::Recursive)?;
    let mut others = Vec::new();
    for formulation in FORMULATIONS {
        if formulation.gives(kind) {
            others.push((formulation, equations(&model, kind, formulation)?));
        }
    }
    Ok(FrontSubject {
        name,
        module,
        others,
        ranges: Ranges::default(),
    })
}

fn equations(
    model: &Model,
    kind: FunctionKind,
    formulation: Formulation,
) -> Result<Module, CommandFailure> {
    generation::functions(model, &[kind], formulation, &Options::default())
}

fn write(folder: &Path, fronts: &[Front], machines: &[Machine]) -> Result<(), CommandFailure> {
    let table = front::text::points_table(fronts);
    let figure = front::text::figure(fronts);
    let mut files = result_files(&table, json_text(fronts), &figure);
    files.push(("front.html".to_owned(), front::page::page(fronts, machines)));
    output::write_files(folder, &files)
}
