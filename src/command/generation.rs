//! `robovec gen`: equations from a model.

use super::flags::whole;
use super::write::{CFloat, GenerationName, OutputLanguage, save, write_files};
use super::{CommandFailure, input, names, output, telling};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use robovec_cgen::c::{self, Real};
use robovec_cgen::kind::Generation;
use robovec_dynamics::generate::{
    Formulation, GenerateError, GenerationRequest, Options, ParameterBinding, TermOrder,
    contenders, cuts_of_rows, generate_into, redundant_rows, refuse_empty,
};
use robovec_dynamics::whole_step::accuracy::step_error;
use robovec_dynamics::whole_step::{self, StepFunction, StepStyle};
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::Pipeline;
use robovec_io::files::Replace;
use robovec_ir::count::Counts;
use robovec_ir::{Format, Module, print};
use robovec_model::Model;
use robovec_passes::registry::REGISTRY;
use robovec_robotran::FunctionKind;
use robovec_robotran::write::WriteOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `gen`.
#[derive(Args, Debug)]
pub(super) struct GenArguments {
    /// Model (.mbs, .urdf)
    model: PathBuf,
    /// Functions, separated by commas; 'all' for every one but those of the whole step
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_value = "dirdyna",
          default_value_if("whole_step", "true", "accelred"),
          value_parser = PossibleValuesParser::new(function_names()))]
    function: Vec<String>,
    /// Language of Robotran's to write files in, instead of robovec's text
    #[arg(long, value_enum)]
    language: Option<OutputLanguage>,
    /// Write C that does the whole step of MBsysC: driven joints, closing of loops, forces,
    /// accelerations (--function accelred, the default here), or forces of actuators
    /// (--function invdynared); unless said otherwise in the formulation with the fewest
    /// operations, after the preset $cpu
    #[arg(long, requires = "output", conflicts_with = "language")]
    whole_step: bool,
    /// With --whole-step: compute accelerations or forces of actuators in this type; loops are
    /// closed in binary64
    #[arg(long, value_enum, default_value = "double", requires = "whole_step")]
    number: CFloat,
    /// Generator whose names C bears
    #[arg(long, value_enum, default_value = "8.1")]
    generation: GenerationName,
    /// Recursion the equations come from; all but recursive need sin^2 + cos^2 = 1 [default:
    /// recursive]
    #[arg(long, value_parser = formulations_or_fewest())]
    formulation: Option<String>,
    /// Write what children carry before a body's own terms
    #[arg(long)]
    child_first: bool,
    /// Keep parameters that are zero in the model
    #[arg(long)]
    all_parameters: bool,
    /// Put the model's numbers into the equations instead of symbols
    #[arg(long, conflicts_with = "all_parameters")]
    numbers: bool,
    /// Leave out external forces and torques
    #[arg(long)]
    no_forces: bool,
    /// Keep every sum in the order of the recursion, a leading minus included
    #[arg(long)]
    leading_signs: bool,
    /// Multiply products out as Robotran prints them
    #[arg(long)]
    expanded: bool,
    /// Do not use that sin^2 + cos^2 = 1
    #[arg(long)]
    any_angles: bool,
    /// Give the multipliers of constraints beside accelerations, and the forces of driven joints
    #[arg(long)]
    multipliers: bool,
    /// Rows of constraints that the user computes (user_cons_hJ, user_cons_jdqd); as many joints
    /// that the model names dependent, beside those of the loops, follow from them
    #[arg(long, value_name = "ROWS", default_value_t = 0,
          add = whole(0, 32, "each is eliminated with all joints"))]
    user_constraints: usize,
    /// Pipeline run over the equations, e.g. atomise,cse,dce
    #[arg(long, value_name = "PIPELINE")]
    passes: Option<String>,
    /// File (with --language: folder) to write instead of the standard output
    #[arg(short, long, value_name = "PATH", required_if_eq_any = [
        ("language", "c"), ("language", "matlab"), ("language", "python")])]
    output: Option<PathBuf>,
}

impl GenArguments {
    /// The formulation asked for, or else one by name.
    fn formulation(&self, model: &Model, function: FunctionKind, usual: &str) -> Formulation {
        match self.formulation.as_deref().unwrap_or(usual) {
            FEWEST => fewest(model, function, &self.options()),
            name => formulation(name),
        }
    }

    fn options(&self) -> Options {
        Options {
            order: if self.child_first {
                TermOrder::ChildFirst
            } else {
                TermOrder::OwnFirst
            },
            all_parameters: self.all_parameters,
            parameters: if self.numbers {
                ParameterBinding::Numbers
            } else {
                ParameterBinding::Symbols
            },
            external_forces: !self.no_forces,
            leading_signs: self.leading_signs,
            expanded: self.expanded,
            true_angles: !self.any_angles,
            small_angles: Vec::new(),
            multipliers: self.multipliers,
            user_constraints: self.user_constraints,
        }
    }
}

fn function_names() -> Vec<&'static str> {
    let names = FunctionKind::ALL.map(FunctionKind::name);
    ["all"].into_iter().chain(names).collect()
}

/// The functions asked for, each once, in the order of Robotran's numbers.
fn kinds(names: &[String]) -> Vec<FunctionKind> {
    // The parts of a whole step are generated on request only, as in Robotran.
    let asked = |kind: &FunctionKind| {
        names
            .iter()
            .any(|name| name == kind.name() || name == "all" && !kind.is_special())
    };
    FunctionKind::ALL.into_iter().filter(asked).collect()
}

/// The formulations as values of an option, each with its description.
pub(super) fn formulations() -> PossibleValuesParser {
    PossibleValuesParser::new(formulation_values())
}

fn formulation_values() -> impl IntoIterator<Item = PossibleValue> {
    Formulation::ALL
        .map(|formulation| PossibleValue::new(formulation.name()).help(formulation.description()))
}

/// The word for the formulation with the fewest operations.
const FEWEST: &str = "fewest";

fn formulations_or_fewest() -> PossibleValuesParser {
    let fewest = "the one of these with the fewest operations after the preset $cpu";
    let fewest = PossibleValue::new(FEWEST).help(fewest);
    PossibleValuesParser::new(formulation_values().into_iter().chain([fewest]))
}

/// The formulation of a function that has the fewest operations after the
/// preset `$cpu`, of equally short ones the first; one that the generator does
/// not give for this model is none.
fn fewest(model: &Model, function: FunctionKind, options: &Options) -> Formulation {
    let cpu = REGISTRY.pipeline("$cpu").expect("a preset is a pipeline");
    let found = contenders(model, function, &Formulation::ALL, options);
    let lengths = found.possible.into_iter().filter_map(|contender| {
        let mut module = contender.module;
        transform_remarking(&mut module, &cpu, &mut std::io::sink()).ok()?;
        let lengths = module.functions.iter().map(Counts::of);
        let operations: usize = lengths.map(|counts| counts.operations).sum();
        Some((operations, contender.formulation))
    });
    let shortest = lengths.min_by_key(|(operations, _)| *operations);
    shortest.map_or_else(Formulation::default, |(_, formulation)| formulation)
}

/// The formulation of an option's value that [`formulations`] let through.
pub(super) fn formulation(name: &str) -> Formulation {
    Formulation::from_name(name).expect("the command line has checked the formulation")
}

/// Generates the functions of a model into one module.
pub(super) fn functions(
    model: &Model,
    kinds: &[FunctionKind],
    formulation: Formulation,
    options: &Options,
) -> Result<Module, CommandFailure> {
    let mut module = Module::new();
    for &function in kinds {
        add(&mut module, model, (function, formulation), options)?;
    }
    Ok(module)
}

/// Generates one function into a module.
fn add(
    module: &mut Module,
    model: &Model,
    (function, formulation): (FunctionKind, Formulation),
    options: &Options,
) -> Result<(), CommandFailure> {
    let request = GenerationRequest {
        function,
        formulation,
        options: options.clone(),
    };
    generate_into(module, model, &request)
        .map_err(|error| CommandFailure::plain(format!("{}: {error}", function.name())))
}

/// Runs the command.
pub(super) fn run(arguments: &GenArguments) -> Result<String, CommandFailure> {
    if let (true, Some(folder)) = (arguments.whole_step, &arguments.output) {
        return write_whole_step(arguments, folder);
    }
    let pipeline = input::passes_or_empty(arguments.passes.as_deref())?;
    if let (None, Some(path)) = (arguments.language, &arguments.output) {
        names::refuse_wrong(path, true)?;
        output::refuse_foreign(Some(path), &[""], Replace::Own)?;
    }
    let kinds = kinds(&arguments.function);
    let whole = [FunctionKind::Accelred, FunctionKind::Invdynared];
    let whole = kinds.iter().find(|kind| whole.contains(kind));
    if let (Some(kind), Some(OutputLanguage::C)) = (whole, arguments.language) {
        let _ = writeln!(
            telling::remarks(),
            "remark: {name} takes forces as given and loops as closed, and MBsysC asks more of \
             mbs_{name}; --whole-step writes all of it",
            name = kind.name()
        );
    }
    let forces = kinds.iter().find(|kind| kind.depends_on_link_forces());
    let read = input::model_for(&arguments.model, forces.copied())?;
    let options = arguments.options();
    let mut module = Module::new();
    let mut empty = Vec::new();
    for function in kinds {
        let formulation = arguments.formulation(&read.model, function, "recursive");
        let before = module.functions.len();
        add(&mut module, &read.model, (function, formulation), &options)?;
        if refuse_empty(&read.model, function, &module.functions[before..]).is_err() {
            empty.push(function);
        }
    }
    if let Some(&first) = empty.first() {
        refuse_empty(&read.model, first, &module.functions)
            .map_err(|error| CommandFailure::plain(error.to_string()))?;
        let names: Vec<&str> = empty.iter().map(|kind| kind.name()).collect();
        let _ = writeln!(
            telling::remarks(),
            "remark: the model has nothing for {}",
            names.join(", ")
        );
    }
    transform(&mut module, &pipeline)?;
    if arguments.language == Some(OutputLanguage::C) {
        let functions = module.functions.iter_mut();
        functions.for_each(|function| Generation::from(arguments.generation).mark(function));
    }
    if let (Some(language), Some(folder)) = (arguments.language, &arguments.output) {
        return write_files(&module, language, &WriteOptions::default(), folder);
    }
    match &arguments.output {
        None => Ok(print::print_module(&module)),
        Some(path) => {
            output::write_over(path, Replace::Own, |writer| {
                print::write_module(&module, writer)
            })?;
            Ok(String::new())
        }
    }
}

/// Writes the C of the whole step; gives the names of the files.
fn write_whole_step(arguments: &GenArguments, folder: &Path) -> Result<String, CommandFailure> {
    let pipeline = input::passes(arguments.passes.as_deref().unwrap_or("$cpu"))?;
    let steps = steps(&arguments.function)?;
    let model = input::model_for(&arguments.model, Some(FunctionKind::Accelred))?.model;
    let formulation = arguments.formulation(&model, FunctionKind::Accelred, FEWEST);
    let options = arguments.options();
    let mut module = whole_step::generate_parts(&model, &steps, formulation, &options)
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    tell_redundant(&model)?;
    // Passes of the preset that do not suit one of the parts have nothing to
    // tell whoever did not ask for them.
    match arguments.passes {
        Some(_) => transform(&mut module, &pipeline)?,
        None => transform_remarking(&mut module, &pipeline, &mut std::io::sink())?,
    }
    let real = arguments.number.real();
    let style = StepStyle {
        c: &c::Options {
            real,
            ..c::Options::default()
        },
        generation: arguments.generation.into(),
        options: &options,
    };
    let files = whole_step::files(&model, &steps, &module, &style)
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    let saved = save(&files, folder)?;
    match real {
        Real::Double => Ok(saved),
        Real::Float => Ok(saved + &error_lines(&model, &steps, &module)?),
    }
}

/// Names the rows of loops that say what others say.
fn tell_redundant(model: &Model) -> Result<(), CommandFailure> {
    let failed = |error: GenerateError| CommandFailure::plain(error.to_string());
    let cuts = cuts_of_rows(model).map_err(failed)?;
    for row in redundant_rows(model).map_err(failed)? {
        let _ = writeln!(
            telling::remarks(),
            "remark: row {} of the constraints (cut '{}') says what other rows say, and is left out",
            row + 1,
            model.cuts[cuts[row]].name
        );
    }
    Ok(())
}

/// Effect of binary32 on the results of steps, a line each.
fn error_lines(
    model: &Model,
    steps: &[StepFunction],
    module: &Module,
) -> Result<String, CommandFailure> {
    let mut text = String::new();
    for &step in steps {
        let account = step_error(model, step, module, Format::BINARY32)
            .map_err(|error| CommandFailure::plain(error.to_string()))?;
        text += &match account {
            Some(account) => format!("{}: {}\n", step.name(), account.text()),
            None => format!(
                "{}: error in f32 not measured: no states with closed loops were found, or \
                 constraints of the user are part of it\n",
                step.name()
            ),
        };
    }
    Ok(text)
}

/// The steps asked for; without a word on functions it is that of accelerations.
fn steps(names: &[String]) -> Result<Vec<StepFunction>, CommandFailure> {
    let all = [StepFunction::Accelerations, StepFunction::ActuatorForces];
    let known = |name: &String| all.iter().any(|step| step.name() == name);
    match names.iter().find(|name| !known(name)) {
        None => {
            let asked = |step: &StepFunction| names.iter().any(|name| name == step.name());
            Ok(all.into_iter().filter(asked).collect())
        }
        Some(name) => Err(CommandFailure::plain(format!(
            "--whole-step writes accelred and invdynared, and '{name}' is neither"
        ))),
    }
}

/// Runs a pipeline over a module, for the machine of the thesis; what passes
/// remark goes to the standard error.
pub(super) fn transform(module: &mut Module, pipeline: &Pipeline) -> Result<(), CommandFailure> {
    transform_remarking(module, pipeline, &mut telling::remarks())
}

/// Does as [`transform`], and tells somebody else what passes remark.
pub(super) fn transform_remarking(
    module: &mut Module,
    pipeline: &Pipeline,
    remarks: &mut dyn Write,
) -> Result<(), CommandFailure> {
    let machine = input::machine("thesis")?;
    manager::run(module, pipeline, Config::new(&machine, remarks))
        .map(drop)
        .map_err(|error| CommandFailure::plain(error.to_string()))
}
