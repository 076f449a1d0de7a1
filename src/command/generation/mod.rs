//! `robovec gen`: equations of a model or a file, in any language.

mod files;
mod whole_step;

use super::flags::{choice, whole};
use super::{CommandFailure, base_parameters, input, opt, output, progress};
use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{ArgGroup, Args};
use files::{FileArguments, refuse_losses};
use robovec_cgen::kind::Generation;
use robovec_dynamics::generate::{
    Formulation, GenerationRequest, Options, ParameterBinding, TermOrder, case_name, fewest,
    generate_into, refuse_empty, with_jacobians_into,
};
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::Pipeline;
use robovec_framework::scene::Scene;
use robovec_io::files::Replace;
use robovec_io::sources::{self, EquationLanguage};
use robovec_ir::diagnostic::did_you_mean;
use robovec_ir::{Module, print};
use robovec_model::Model;
use robovec_robotran::{FunctionKind, Language};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Generate the equations of a model, or convert files of equations: robovec's
/// text, C, Matlab or Python
#[derive(Args, Debug)]
#[command(group = ArgGroup::new("drop_in").args(["bounded", "whole_step"]).multiple(true))]
pub(super) struct GenArguments {
    /// Models (.mbs, .urdf, .xml) or files of equations
    #[arg(required = true, value_name = "SUBJECT")]
    subjects: Vec<PathBuf>,
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help = function_help())]
    function: Vec<String>,
    /// Write C for the whole step of MBsysC: driven joints, closure of loops,
    /// forces, and accelerations (--function accelred, the default here) or
    /// forces of actuators (--function invdynared). By default the formulation
    /// is the one with the fewest operations, and the pipeline is the preset
    /// $cpu
    #[arg(long, requires = "output", conflicts_with_all = ["language", "bounded"])]
    whole_step: bool,
    /// Recursion the equations come from; all but recursive need sin^2 + cos^2 = 1 [default:
    /// recursive]
    #[arg(long, value_parser = formulations_or_fewest())]
    formulation: Option<String>,
    /// Write the terms of child bodies before a body's own terms
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
    /// Keep every sum in the order of the recursion, even where it then starts
    /// with a minus
    #[arg(long)]
    leading_signs: bool,
    /// Multiply products out as Robotran prints them
    #[arg(long)]
    expanded: bool,
    /// Do not use that sin^2 + cos^2 = 1
    #[arg(long)]
    any_angles: bool,
    /// Also compute the multipliers of the constraints and the forces of driven
    /// joints
    #[arg(long)]
    multipliers: bool,
    /// Also write the Jacobians of the outputs of invdyna and accelred, as arrays
    /// named Qq_q
    #[arg(long)]
    jacobians: bool,
    /// Describe the free base of a model by a quaternion, quat = (x, y, z, w), and
    /// by its velocity, acceleration and force along its own axes
    #[arg(long)]
    quaternion: bool,
    /// Write only the columns of the regressor that belong to base parameters
    /// (robovec model --base-parameters prints these)
    #[arg(long)]
    base_parameters: bool,
    /// Number of constraint rows that the user computes (user_cons_hJ,
    /// user_cons_jdqd); they determine as many dependent joints of the model,
    /// in addition to those of the loops
    #[arg(long, value_name = "ROWS", default_value_t = 0,
          add = whole(0, 32, "each row is eliminated with all joints"))]
    user_constraints: usize,
    /// Joints of the model that the project drives
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    driven: Vec<String>,
    /// Joints held where they start, whatever the model calls them
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    hold: Vec<String>,
    /// Language of files of equations; by default found from their names and content
    #[arg(long, value_parser = choice(&input::LANGUAGES))]
    input_language: Option<EquationLanguage>,
    /// Passes that run over the equations, e.g. atomise,cse,dce
    #[arg(long, value_name = "PIPELINE")]
    passes: Option<String>,
    /// File to write instead of the standard output; with --language or
    /// --whole-step, folder to write files to (with --language by default the
    /// current one)
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
    // Last, since its heading holds for all that follow.
    #[command(flatten)]
    files: FileArguments,
}

impl GenArguments {
    /// An option given that only models take.
    fn of_models(&self) -> Option<&'static str> {
        let given = [
            ("--whole-step", self.whole_step),
            ("--formulation", self.formulation.is_some()),
            ("--child-first", self.child_first),
            ("--all-parameters", self.all_parameters),
            ("--numbers", self.numbers),
            ("--no-forces", self.no_forces),
            ("--leading-signs", self.leading_signs),
            ("--expanded", self.expanded),
            ("--any-angles", self.any_angles),
            ("--multipliers", self.multipliers),
            ("--jacobians", self.jacobians),
            ("--quaternion", self.quaternion),
            ("--base-parameters", self.base_parameters),
            ("--user-constraints", self.user_constraints > 0),
            ("--driven", !self.driven.is_empty()),
            ("--hold", !self.hold.is_empty()),
        ];
        let mut given = given.into_iter().filter(|(_, is_given)| *is_given);
        given.next().map(|(name, _)| name)
    }

    /// The model of a subject, with the joints that are driven or held.
    fn model(&self, path: &Path, kind: Option<FunctionKind>) -> Result<Model, CommandFailure> {
        let mut model = input::model_for(path, kind)?.model;
        for (names, moves) in [(&self.driven, true), (&self.hold, false)] {
            for place in input::drive(&mut model, names)? {
                // What does not move has no velocity in the equations.
                model.joints[place].has_velocity = moves;
                model.joints[place].has_acceleration = moves;
            }
        }
        Ok(model)
    }

    /// The formulation requested, or else one by name.
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
            growth: false,
            quaternion: self.quaternion,
            base_columns: Vec::new(),
        }
    }
}

/// Help of `--function`, with the names that models give.
fn function_help() -> String {
    let names = FunctionKind::ALL.map(FunctionKind::name).join(", ");
    format!(
        "Functions, separated by commas; by default all of a file, and dirdyna of a model; 'all' \
         means all except those of the whole step [of a model: all, {names}]"
    )
}

/// The functions requested, each once, in the order of Robotran's numbers.
fn kinds(names: &[String]) -> Result<Vec<FunctionKind>, CommandFailure> {
    if names.is_empty() {
        return Ok(vec![FunctionKind::Dirdyna]);
    }
    let known = |name: &&String| *name == "all" || FunctionKind::with_name(name).is_some();
    if let Some(name) = names.iter().find(|name| !known(name)) {
        return Err(input::no_such_kind(name));
    }
    // The parts of a whole step are generated on request only, as in Robotran.
    let asked = |kind: &FunctionKind| {
        names.iter().any(|name| match name.as_str() {
            "all" => !kind.is_special(),
            name => FunctionKind::with_name(name) == Some(*kind),
        })
    };
    Ok(FunctionKind::ALL.into_iter().filter(asked).collect())
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

/// The formulation of an option's value that [`formulations`] let through.
pub(super) fn formulation(name: &str) -> Formulation {
    Formulation::from_name(name).expect("the command line has checked the formulation")
}

pub(super) fn functions(
    model: &Model,
    kinds: &[FunctionKind],
    formulation: Formulation,
    options: &Options,
) -> Result<Module, CommandFailure> {
    let mut module = Module::new();
    for &function in kinds {
        add(&mut module, model, (function, formulation), options, false)?;
    }
    Ok(module)
}

/// Generates one function into a module, with its Jacobians on request.
fn add(
    module: &mut Module,
    model: &Model,
    (function, formulation): (FunctionKind, Formulation),
    options: &Options,
    jacobians: bool,
) -> Result<(), CommandFailure> {
    let request = GenerationRequest {
        function,
        formulation,
        options: options.clone(),
    };
    let made = match jacobians {
        true => with_jacobians_into(module, model, &request),
        false => generate_into(module, model, &request),
    };
    made.map_err(|error| CommandFailure::plain(format!("{}: {error}", function.name())))
}

pub(super) fn run(arguments: &GenArguments) -> Result<String, CommandFailure> {
    if arguments.whole_step {
        return whole_step::run(arguments);
    }
    let pipeline = input::passes_or_empty(arguments.passes.as_deref())?;
    let Some(language) = arguments.files.language else {
        return text(arguments, &pipeline);
    };
    let folder = arguments.output.as_deref().unwrap_or(Path::new("."));
    let mut files = Vec::new();
    for path in &arguments.subjects {
        let mut module = equations(path, arguments, &pipeline)?;
        let usual = sources::is_model_path(path).then_some(Generation::Current);
        let generation = arguments.files.generation.or(usual);
        if let (Some(generation), Language::C) = (generation, language) {
            let functions = module.functions.iter_mut();
            functions.for_each(|function| generation.mark(function));
        }
        files.extend(arguments.files.write(&module, language, path)?);
    }
    refuse_losses(&arguments.subjects, &files, folder)?;
    files::save(&files, folder)
}

/// Prints or writes robovec's text of one subject.
fn text(arguments: &GenArguments, pipeline: &Pipeline) -> Result<String, CommandFailure> {
    let [path] = &arguments.subjects[..] else {
        return Err(CommandFailure::advised(
            "robovec's text can be written for one subject at a time",
            vec!["to write several, choose a language of Robotran: --language c".to_owned()],
        ));
    };
    if let Some(file) = &arguments.output {
        output::refuse_wrong(file, true)?;
        output::refuse_foreign(Some(file), &[""], Replace::Own)?;
    }
    let module = equations(path, arguments, pipeline)?;
    match &arguments.output {
        None => Ok(print::print_module(&module)),
        Some(file) => {
            output::write_over(file, Replace::Own, |writer| {
                print::write_module(&module, writer)
            })?;
            Ok(String::new())
        }
    }
}

/// The equations of a subject after the passes.
fn equations(
    path: &Path,
    arguments: &GenArguments,
    pipeline: &Pipeline,
) -> Result<Module, CommandFailure> {
    if sources::is_model_path(path) && arguments.input_language.is_none() {
        let mut module = of_model(path, arguments)?;
        transform(&mut module, pipeline)?;
        return Ok(module);
    }
    if let Some(option) = arguments.of_models() {
        return Err(not_a_model(option, path));
    }
    let mut input = input::equations_or_stubs(path, arguments.input_language)?;
    if !arguments.function.is_empty() {
        opt::select_all(&mut input.module, &arguments.function)?;
    }
    let scene = input::scene_of(&input, None);
    run_passes(
        &mut input.module,
        pipeline,
        scene.as_ref(),
        &mut progress::remarks(),
    )
    .map_err(|error| CommandFailure::plain(format!("{}: {error}", path.display())))?;
    Ok(input.module)
}

/// The failure for an option of models that is given with equations.
fn not_a_model(option: &str, path: &Path) -> CommandFailure {
    CommandFailure::advised(
        format!(
            "{option} generates from a model, and {} holds equations",
            path.display()
        ),
        vec!["name the model (.mbs, .urdf, .xml) they come from".to_owned()],
    )
}

fn of_model(path: &Path, arguments: &GenArguments) -> Result<Module, CommandFailure> {
    let kinds = kinds(&arguments.function)?;
    let whole = [FunctionKind::Accelred, FunctionKind::Invdynared];
    let whole = kinds.iter().find(|kind| whole.contains(kind));
    if let (Some(kind), Some(Language::C)) = (whole, arguments.files.language) {
        let _ = writeln!(
            progress::remarks(),
            "remark: {name} takes forces as given and loops as closed, but MBsysC needs more \
             from mbs_{name}; --whole-step writes all of it",
            name = kind.name()
        );
    }
    let forces = kinds.iter().find(|kind| kind.depends_on_link_forces());
    let model = arguments.model(path, forces.copied())?;
    let mut options = arguments.options();
    if arguments.base_parameters {
        if !kinds.contains(&FunctionKind::Regressor) {
            return Err(CommandFailure::plain(
                "--base-parameters is for the regressor: add --function regressor",
            ));
        }
        options.base_columns = base_parameters::find(&model, &options)?.columns();
    }
    let mut module = Module::new();
    let names = arguments.function.iter();
    let names: Vec<String> = names.map(|name| case_name(&model, name)).collect();
    let mut empty = Vec::new();
    for function in kinds {
        let formulation = arguments.formulation(&model, function, "recursive");
        let before = module.functions.len();
        let wanted = (function, formulation);
        add(&mut module, &model, wanted, &options, arguments.jacobians)?;
        keep_cases(&mut module, before, function, &names)?;
        if refuse_empty(&model, function, &module.functions[before..]).is_err() {
            empty.push(function);
        }
    }
    if let Some(&first) = empty.first() {
        refuse_empty(&model, first, &module.functions)
            .map_err(|error| CommandFailure::plain(error.to_string()))?;
        let names: Vec<&str> = empty.iter().map(|kind| kind.name()).collect();
        let _ = writeln!(
            progress::remarks(),
            "remark: the model has no equations for {}",
            names.join(", ")
        );
    }
    Ok(module)
}

/// Keeps the cases of a function requested by name (`sensor_2`, `frame_tool0`),
/// among the functions of a module from a first one on.
fn keep_cases(
    module: &mut Module,
    first: usize,
    kind: FunctionKind,
    names: &[String],
) -> Result<(), CommandFailure> {
    let made = module.functions.split_off(first);
    let own = names
        .iter()
        .filter(|name| FunctionKind::with_name(name) == Some(kind));
    let own: Vec<&String> = own.collect();
    if own.is_empty() || own.iter().any(|name| *name == kind.name()) {
        module.functions.extend(made);
        return Ok(());
    }
    if let Some(name) = own
        .iter()
        .find(|name| made.iter().all(|one| one.name != ***name))
    {
        let known: Vec<&str> = made.iter().map(|one| one.name.as_str()).collect();
        let note = match did_you_mean(name, known.iter().copied()) {
            Some(near) => format!("did you mean '{near}'?"),
            None if known.is_empty() => format!("the model has no function '{}'", kind.name()),
            None => format!("there are {}", known.join(", ")),
        };
        let message = format!("the model has no function '{name}'");
        return Err(CommandFailure::advised(message, vec![note]));
    }
    let kept = made
        .into_iter()
        .filter(|one| own.iter().any(|name| **name == one.name));
    module.functions.extend(kept);
    Ok(())
}

/// Runs a pipeline for the thesis' machine; remarks go to standard error.
pub(super) fn transform(module: &mut Module, pipeline: &Pipeline) -> Result<(), CommandFailure> {
    transform_remarking(module, pipeline, &mut progress::remarks())
}

/// Does as [`transform`], and passes the remarks of passes to an observer.
pub(super) fn transform_remarking(
    module: &mut Module,
    pipeline: &Pipeline,
    remarks: &mut dyn Write,
) -> Result<(), CommandFailure> {
    run_passes(module, pipeline, None, remarks).map_err(CommandFailure::plain)
}

fn run_passes(
    module: &mut Module,
    pipeline: &Pipeline,
    scene: Option<&Scene>,
    remarks: &mut dyn Write,
) -> Result<(), String> {
    let machine = input::machine("thesis").expect("the machine ships");
    let config = Config {
        scene,
        ..Config::new(&machine, remarks)
    };
    let outcome = manager::run(module, pipeline, config);
    outcome.map(drop).map_err(|error| error.to_string())
}
