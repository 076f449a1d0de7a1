//! The build of a project, and its main program.
//!
//! MBsysC is built by CMake: in `workR`, or in the folder that holds all the
//! sources. A folder builds a project if the equations are in it or beside it,
//! so the tools that some projects keep among their sources are no candidates.
//! Projects of MBsysPy and MBsysLab have a script there instead.

use super::CommandFailure;
use super::find::FoundProject;
use robovec_io::files::limited;
use robovec_robotran::Language;
use std::path::{Path, PathBuf};

/// Options of MBsysC, old and new, that need a screen, a keyboard or a clock.
const SCREENS: [&str; 8] = [
    "FLAG_REAL_TIME",
    "FLAG_PLOT",
    "FLAG_VISU",
    "FLAG_JAVA",
    "FLAG_OPEN_GL",
    "FLAG_SDL",
    "FLAG_JNI",
    "FLAG_YARP",
];

/// A command that sets the option of MBsysC for the whole step in sources.
const STEP_OPTION: &str = r"sed -i -E -e 's/(\w+) *= *mbs_new_dirdyn *\([^;]*;/& \1->options->accelred = 1;/' -e 's/(options->accelred *= *)0/\11/'";

/// Commands that configure, build and run a copy of a project.
#[derive(Default)]
pub(super) struct ProjectBuild {
    /// The file that they follow from.
    pub(super) file: PathBuf,
    pub(super) configure: Option<String>,
    /// The same for the whole step, where the project has a switch for it.
    pub(super) step_configure: Option<String>,
    pub(super) build: Option<String>,
    /// A script; otherwise the program that the build makes in the folder.
    pub(super) run: Option<String>,
    pub(super) folder: PathBuf,
}

/// Finds the build of a project; `library`: MBsysC's, MBsysPy's or MBsysLab's.
pub(super) fn find(
    project: &FoundProject,
    library: Option<&Path>,
) -> Result<ProjectBuild, CommandFailure> {
    let library = library.map(std::path::absolute).transpose();
    let library = library.map_err(|error| CommandFailure::plain(error.to_string()))?;
    let library = library.as_deref();
    let (found, wanted) = match project.language {
        Language::C => (
            cmake(project, library).or_else(|| makefile(project)),
            "CMakeLists.txt with add_executable and no Makefile",
        ),
        Language::Python => (python(project, library), "script of MBsysPy"),
        Language::Matlab => (matlab(project, library), "script of MBsysLab"),
    };
    found.ok_or_else(|| {
        let near = project.shown(&project.symbolic);
        CommandFailure::advised(
            format!(
                "{} has no main program: no {wanted} is beside {near}",
                project.name
            ),
            vec!["--build, --run and --result give the commands of another build".to_owned()],
        )
    })
}

fn cmake(project: &FoundProject, library: Option<&Path>) -> Option<ProjectBuild> {
    let file = nearest(project, |name, text| {
        let text = text.to_lowercase();
        let has = |command: &str| text.contains(command);
        let is_whole = has("add_subdirectory") && !has("add_library");
        let mut lines = text.lines().map(str::trim_start);
        name == "CMakeLists.txt"
            && lines.any(|line| line.starts_with("project"))
            && (has("add_executable") || is_whole)
    })?;
    let (folder, build) = (folder(project, &file), folder(project, &file).join("build"));
    let mut options: String = SCREENS
        .iter()
        .map(|name| format!(" -D{name}=OFF"))
        .collect();
    if let Some(library) = library {
        let path = quoted(library);
        options += &format!(" -DROBOTRAN_SOURCE_DIR={path} -DCMAKE_PREFIX_PATH={path}");
    }
    let (at, into) = (quoted(&folder), quoted(&build));
    let configure = format!(
        "cmake -S {at} -B {into} -DCMAKE_BUILD_TYPE=Release -DCMAKE_POLICY_VERSION_MINIMUM=3.5\
         {options}"
    );
    let step_configure = if text(&file).contains("FLAG_ACCELRED") {
        Some(format!(
            "{configure} -DFLAG_DIRDYNARED=OFF -DFLAG_ACCELRED=ON"
        ))
    } else {
        // What is added to the equations is found when CMake runs.
        step_option(project, library).map(|option| format!("{option} && {configure}"))
    };
    Some(ProjectBuild {
        configure: Some(format!("rm -rf {into} && {configure}")),
        step_configure,
        build: Some(format!("cmake --build {into}")),
        folder: build,
        file,
        ..ProjectBuild::default()
    })
}

/// The command that selects the whole step in a project, if it has the option.
fn step_option(project: &FoundProject, library: Option<&Path>) -> Option<String> {
    let module = |path: &&PathBuf| path.ends_with("mbs_module/mbs_dirdyn.c");
    let own = library.map(|path| path.join("mbs_common/mbs_module/mbs_dirdyn.c"));
    let mut modules = project.files.iter().filter(module).chain(&own);
    if modules.any(|path| path.exists() && !text(path).contains("options->accelred")) {
        return None;
    }
    let sources = project.files.iter().filter(|path| {
        let end = path.extension().and_then(|end| end.to_str());
        matches!(end, Some("c" | "cc" | "cpp")) && !module(path)
    });
    let sources = sources.filter(|path| text(path).contains("mbs_new_dirdyn"));
    let paths = sources.map(|path| quoted(path.strip_prefix(&project.root).unwrap_or(path)));
    let paths: Vec<String> = paths.collect();
    (!paths.is_empty()).then(|| format!("{STEP_OPTION} {}", paths.join(" ")))
}

fn makefile(project: &FoundProject) -> Option<ProjectBuild> {
    let file = nearest(project, |name, text| {
        ["Makefile", "makefile"].contains(&name) && !text.contains("CMAKE_COMMAND")
    })?;
    let folder = folder(project, &file);
    Some(ProjectBuild {
        build: Some(format!("make -C {}", quoted(&folder))),
        folder,
        file,
        ..ProjectBuild::default()
    })
}

fn python(project: &FoundProject, library: Option<&Path>) -> Option<ProjectBuild> {
    let file = nearest(project, |name, text| {
        name.ends_with(".py") && text.contains("MBsysPy") && text.contains("MbsDirdyn")
    })?;
    let paths = library.map(|path| format!("PYTHONPATH={}:\"$PYTHONPATH\" ", quoted(path)));
    let name = quoted(file.file_name()?);
    let command = format!("MPLBACKEND=Agg {}python3 {name}", paths.unwrap_or_default());
    Some(scripted(project, file, &command))
}

fn matlab(project: &FoundProject, library: Option<&Path>) -> Option<ProjectBuild> {
    let file = nearest(project, |name, text| {
        name.ends_with(".m") && text.contains("mbs_exe_dirdyn(") && text.contains("mbs_load(")
    })?;
    let paths = library.map(|path| format!("addpath(genpath('{}'));", path.display()));
    let name = file.file_stem()?.to_string_lossy();
    let program = format!("{}addpath(genpath('..'));{name}", paths.unwrap_or_default());
    let command = format!("octave-cli --eval {}", quoted(program));
    Some(scripted(project, file, &command))
}

fn scripted(project: &FoundProject, file: PathBuf, command: &str) -> ProjectBuild {
    let folder = folder(project, &file);
    ProjectBuild {
        run: Some(format!("cd {} && {command}", quoted(folder))),
        file,
        ..ProjectBuild::default()
    }
}

fn folder(project: &FoundProject, file: &Path) -> PathBuf {
    let folder = file.parent().unwrap_or(file);
    let inside = folder.strip_prefix(&project.root).unwrap_or(folder);
    Path::new(".").join(inside)
}

/// Of several files with a name and a text, whose folders have the equations
/// inside or beside them, the one in `workR`, else one that has them inside, the
/// nearest to them; of the same folder a file named `main`, else the first.
fn nearest(project: &FoundProject, fits: impl Fn(&str, &str) -> bool) -> Option<PathBuf> {
    let is_beside = |path: &&PathBuf| {
        let folder = path.parent().unwrap_or(path);
        let around = folder.parent().filter(|_| folder != project.root);
        project.symbolic.starts_with(around.unwrap_or(folder))
    };
    let fits = |path: &&PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| {
            // Most files are passed over without being read.
            fits_name(name) && fits(name, &text(path))
        })
    };
    let rank = |path: &&PathBuf| {
        let folder = path.parent().unwrap_or(path);
        (
            folder.ends_with("workR"),
            project.symbolic.starts_with(folder),
            path.components().count(),
            path.file_stem() == Some("main".as_ref()),
        )
    };
    let found = project.files.iter().filter(is_beside).filter(fits);
    found.rev().max_by_key(rank).cloned()
}

/// True for a name that a build or a script may have.
fn fits_name(name: &str) -> bool {
    let is_script = name.ends_with(".py") || name.ends_with(".m");
    is_script || ["CMakeLists.txt", "Makefile", "makefile"].contains(&name)
}

/// The text of a file, empty where it cannot be read.
fn text(path: &Path) -> String {
    let bytes = limited::read(path, &limited::EQUATIONS).unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A word of a command for the shell.
pub(super) fn quoted(word: impl AsRef<std::ffi::OsStr>) -> String {
    let word = word.as_ref().to_string_lossy();
    format!("'{}'", word.replace('\'', r"'\''"))
}
