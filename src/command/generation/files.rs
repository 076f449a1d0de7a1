//! Equations as Robotran's C, Matlab or Python files.

use crate::command::flags::{FlagChoice, choice};
use crate::command::{CommandFailure, output};
use clap::Args;
use robovec_cgen::c::{Options, Real};
use robovec_cgen::kind::Generation;
use robovec_cgen::superword::SuperwordLanes;
use robovec_io::files::Replace;
use robovec_ir::Module;
use robovec_robotran::Language;
use robovec_robotran::drop_in::{DropInOptions, drop_in};
use robovec_robotran::write::{WriteOptions, write};
use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Way in which files are written.
#[derive(Args, Debug)]
#[command(next_help_heading = "Files of Robotran")]
pub(super) struct FileArguments {
    /// Language of the files to write, instead of robovec's text
    #[arg(long, value_parser = choice(&LANGUAGES))]
    pub(super) language: Option<Language>,
    /// Name of the model, in file names and headers; by default the input's
    #[arg(
        long = "name",
        alias = "model",
        value_name = "NAME",
        requires = "language"
    )]
    model: Option<String>,
    /// Also set output elements that are always zero
    #[arg(long, requires = "language")]
    zeros: bool,
    /// Write C in functions of limited length, fast to compile and to run;
    /// robovec cannot read this C back
    #[arg(long, requires = "language")]
    bounded: bool,
    /// With --bounded: also write a main program that tests each function, and
    /// a header to compile it without MBsysC
    #[arg(long, requires = "bounded")]
    test_main: bool,
    /// With --test-main: linked functions to compare with and to time, by name
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        requires = "test_main"
    )]
    rivals: Vec<String>,
    /// With --bounded or --whole-step: compute in this type; loops are closed in binary64
    #[arg(long, value_parser = choice(&REALS), default_value = "double", requires = "drop_in")]
    pub(super) number: Real,
    /// With --bounded or --whole-step: vectors for operations that repeat in the sides of
    /// a mechanism, such as legs; the C is for gcc and clang
    #[arg(long, value_parser = choice(&SUPERWORDS), default_value = "none", requires = "drop_in")]
    pub(super) superwords: SuperwordLanes,
    /// Version of Robotran's generator whose names the C uses; by default that
    /// of the file, and 8.1 for a model
    #[arg(long, value_parser = choice(&GENERATIONS))]
    pub(super) generation: Option<Generation>,
}

/// Types that C computes in.
const REALS: [FlagChoice<Real>; 2] = [
    (&["double", "f64"], "IEEE binary64", Real::Double),
    (
        &["float", "f32"],
        "IEEE binary32; MBsysC's arrays stay binary64",
        Real::Float,
    ),
];

/// Numbers of a vector for operations of equal structure.
const SUPERWORDS: [FlagChoice<SuperwordLanes>; 5] = [
    (&["none"], "No vectors", SuperwordLanes::None),
    (&["2"], "Two, for two sides", SuperwordLanes::Two),
    (&["3"], "Three, for three arms", SuperwordLanes::Three),
    (
        &["4"],
        "Four, for four legs or wheels",
        SuperwordLanes::Four,
    ),
    (&["auto"], "The fewest instructions", SuperwordLanes::Auto),
];

/// Languages that Robotran writes.
const LANGUAGES: [FlagChoice<Language>; 3] = [
    (&["c"], "C, for MBsysC", Language::C),
    (&["matlab"], "Matlab, for MBsysLab", Language::Matlab),
    (&["python"], "Python, for MBsysPy", Language::Python),
];

/// Generators whose names C uses.
const GENERATIONS: [FlagChoice<Generation>; 2] = [
    (&["8.1"], "MbsData, mbs_dirdyna", Generation::Current),
    (&["6.6"], "MBSdataStruct, dirdyna", Generation::Old),
];

impl FileArguments {
    /// Files of a module that was read from a path.
    pub(super) fn write(
        &self,
        module: &Module,
        language: Language,
        path: &Path,
    ) -> Result<Vec<(String, String)>, CommandFailure> {
        let options = WriteOptions {
            model: self.model.clone(),
            zeros: self.zeros,
        };
        let written = if self.bounded {
            if language != Language::C {
                return Err(CommandFailure::advised(
                    "only C is written in functions of bounded length".to_owned(),
                    vec!["leave --bounded out: Matlab and Python are not compiled".to_owned()],
                ));
            }
            drop_in(
                module,
                &DropInOptions {
                    c: Options {
                        real: self.number,
                        superwords: self.superwords,
                        ..Options::default()
                    },
                    write: options,
                    test_main: self.test_main,
                    rivals: self.rivals.clone(),
                },
            )
        } else {
            write(module, language, &options)
        };
        written.map_err(|error| CommandFailure::plain(format!("{}: {error}", path.display())))
    }
}

/// An error when one file would replace another, or of an input.
pub(super) fn refuse_losses(
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
                vec!["write them one by one, into separate folders".to_owned()],
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

/// Writes files into a folder; gives their names, one per line.
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
