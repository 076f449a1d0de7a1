//! `robovec write`: equations as Robotran's files.

use super::arguments::InputLanguage;
use super::{CommandFailure, input, output, telling};
use clap::{Args, ValueEnum};
use robovec_cgen::c::{Options, Real};
use robovec_cgen::kind::Generation;
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::Pipeline;
use robovec_io::files::Replace;
use robovec_ir::Module;
use robovec_robotran::Language;
use robovec_robotran::drop_in::{DropInOptions, drop_in};
use robovec_robotran::write::{WriteOptions, write};
use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Options of `robovec write`.
#[derive(Args, Debug)]
pub(crate) struct WriteArguments {
    /// Robotran files or robovec texts
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Language to write
    #[arg(long, value_enum)]
    language: OutputLanguage,
    /// Folder for the files
    #[arg(short, long, value_name = "FOLDER", default_value = ".")]
    output: PathBuf,
    /// Name of the model, in file names and headers; by default the input's
    #[arg(long = "name", alias = "model", value_name = "NAME")]
    model: Option<String>,
    /// Passes to run before, as in robovec-opt
    #[arg(long, value_name = "PIPELINE")]
    passes: Option<String>,
    /// Set also the output elements that are zero whatever the state
    #[arg(long)]
    zeros: bool,
    /// C in functions of bounded length, fast to compile and to run; it does
    /// not read back
    #[arg(long)]
    bounded: bool,
    /// With --bounded: a main program that tries each function, and a header
    /// to compile it without MBsysC
    #[arg(long, requires = "bounded")]
    test_main: bool,
    /// With --test-main: functions to compare and time against, by the names
    /// they are linked under
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        requires = "test_main"
    )]
    rivals: Vec<String>,
    /// With --bounded: compute in this type
    #[arg(long, value_enum, default_value = "double", requires = "bounded")]
    number: CFloat,
    /// Language of the input; by default told by its name and content
    #[arg(long, value_enum)]
    input_language: Option<InputLanguage>,
    /// Generator whose names C bears, instead of the one the file was written for
    #[arg(long, value_enum)]
    generation: Option<GenerationName>,
}

/// The type that C computes in.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum CFloat {
    /// IEEE binary64
    #[value(alias = "f64")]
    Double,
    /// IEEE binary32; MBsysC's arrays stay binary64
    #[value(alias = "f32")]
    Float,
}

impl CFloat {
    /// The type in C.
    pub(super) fn real(self) -> Real {
        match self {
            CFloat::Double => Real::Double,
            CFloat::Float => Real::Float,
        }
    }
}

/// A language Robotran writes.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum OutputLanguage {
    /// C, for MBsysC
    C,
    /// Matlab, for MBsysLab
    Matlab,
    /// Python, for MBsysPy
    Python,
}

/// The generator whose names C bears.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum GenerationName {
    /// MbsData, mbs_dirdyna
    #[value(name = "8.1")]
    Current,
    /// MBSdataStruct, dirdyna
    #[value(name = "6.6")]
    Old,
}

impl From<GenerationName> for Generation {
    fn from(name: GenerationName) -> Generation {
        match name {
            GenerationName::Current => Generation::Current,
            GenerationName::Old => Generation::Old,
        }
    }
}

impl From<OutputLanguage> for Language {
    fn from(language: OutputLanguage) -> Language {
        match language {
            OutputLanguage::C => Language::C,
            OutputLanguage::Matlab => Language::Matlab,
            OutputLanguage::Python => Language::Python,
        }
    }
}

/// Writes the files; gives their names, one per line.
pub(crate) fn run(arguments: &WriteArguments) -> Result<String, CommandFailure> {
    let pipeline = input::passes_or_empty(arguments.passes.as_deref())?;
    let options = WriteOptions {
        model: arguments.model.clone(),
        zeros: arguments.zeros,
    };
    let mut files = Vec::new();
    for path in &arguments.files {
        let mut module = equations(path, arguments.input_language, &pipeline)?;
        if let Some(generation) = arguments.generation {
            let functions = module.functions.iter_mut();
            functions.for_each(|function| Generation::from(generation).mark(function));
        }
        let written = if arguments.bounded {
            drop_in(&module, &bounded(arguments, &options)?)
        } else {
            write(&module, arguments.language.into(), &options)
        };
        let written = written
            .map_err(|error| CommandFailure::plain(format!("{}: {error}", path.display())))?;
        files.extend(written);
    }
    refuse_losses(&arguments.files, &files, &arguments.output)?;
    save(&files, &arguments.output)
}

/// Way in which bounded C is written.
fn bounded(
    arguments: &WriteArguments,
    write: &WriteOptions,
) -> Result<DropInOptions, CommandFailure> {
    if arguments.language != OutputLanguage::C {
        return Err(CommandFailure::advised(
            "only C is written in functions of bounded length".to_owned(),
            vec!["leave --bounded out: Matlab and Python are not compiled".to_owned()],
        ));
    }
    let real = arguments.number.real();
    Ok(DropInOptions {
        c: Options {
            real,
            ..Options::default()
        },
        write: write.clone(),
        test_main: arguments.test_main,
        rivals: arguments.rivals.clone(),
    })
}

/// Reads a file and runs the passes.
fn equations(
    path: &Path,
    language: Option<InputLanguage>,
    pipeline: &Pipeline,
) -> Result<Module, CommandFailure> {
    let mut input = input::equations_or_stubs(path, language)?;
    let machine = input::machine("thesis")?;
    let scene = input.scene(None);
    let mut log = telling::remarks();
    let config = Config {
        scene: scene.as_ref(),
        ..Config::new(&machine, &mut log)
    };
    manager::run(&mut input.module, pipeline, config)
        .map_err(|error| CommandFailure::plain(format!("{}: {error}", path.display())))?;
    Ok(input.module)
}

/// An error when one file would take the place of another, or of an input.
fn refuse_losses(
    inputs: &[PathBuf],
    files: &[(String, String)],
    folder: &Path,
) -> Result<(), CommandFailure> {
    let inputs: Vec<PathBuf> = inputs
        .iter()
        .filter_map(|path| path.canonicalize().ok())
        .collect();
    let mut known = HashSet::new();
    for (name, _) in files {
        if !known.insert(name.as_str()) {
            return Err(CommandFailure::advised(
                format!("two of the files give a {name}"),
                vec!["write them one by one, into folders of their own".to_owned()],
            ));
        }
        let path = folder.join(name);
        if path.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
            return Err(CommandFailure::advised(
                format!("{} is the input and would be overwritten", path.display()),
                vec!["name another folder: -o FOLDER".to_owned()],
            ));
        }
    }
    Ok(())
}

/// Writes all functions of a module into a folder; gives the names of the
/// files, one per line.
pub(super) fn write_files(
    module: &Module,
    language: OutputLanguage,
    options: &WriteOptions,
    folder: &Path,
) -> Result<String, CommandFailure> {
    let files = write(module, language.into(), options)
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    save(&files, folder)
}

pub(super) fn save(files: &[(String, String)], folder: &Path) -> Result<String, CommandFailure> {
    let texts: Vec<(&str, &str)> = files
        .iter()
        .map(|(name, text)| (&**name, &**text))
        .collect();
    output::write_folder(folder, &texts, Replace::Own)?;
    let mut names = String::new();
    for (name, _) in files {
        // Writing to a string cannot fail.
        let _ = writeln!(names, "{}", folder.join(name).display());
    }
    Ok(names)
}
