//! FPCore, the format in which tools that bound rounding errors exchange
//! problems (FPBench, <https://fpbench.org/spec/fpcore-2.0.html>).
//!
//! A core is a function of scalars with one result. Straight-line code of known
//! operations is read; branches, loops, tensors and other functions are
//! refused, with their places. The writer is a target of the pass `codegen`.
//!
//! **Invariant.** Nesting costs memory, not stack: parentheses are read into
//! an arena, and expressions are walked with their own stack.

mod core;
mod lower;
mod number;
mod ranges;
mod terms;

use self::core::{Core, cores};
use robovec_ir::diagnostic::{Diagnostic, Report, clip, suggestion};
use robovec_ir::parenthesised;
use robovec_ir::states::Ranges;
use robovec_ir::verify::is_valid;
use robovec_ir::{Format, Module};
use robovec_robotran::LineIndex;

/// No more errors than this are reported for one core.
const ERROR_LIMIT: usize = 20;

/// No more names than this are listed.
const NAMES: usize = 100;

/// A core that was read.
#[derive(Debug)]
pub struct ReadCore {
    /// One function of equations, with scalar inputs and the output `result`.
    pub module: Module,
    /// Ranges of the inputs by `:pre`.
    pub ranges: Ranges,
    /// The format of `:precision`, else binary64; `None` for real numbers.
    pub format: Option<Format>,
    /// Parts that were left out.
    pub warnings: Report,
}

/// Reads the core of a name, or the only one.
///
/// # Errors
///
/// A construct outside straight-line cores, with its place; a list of the
/// cores, when there are several and none was named.
pub fn read(file: &str, text: &str, wanted: Option<&str>) -> Result<ReadCore, Report> {
    let fail = |diagnostics: Vec<Diagnostic>| Report::of(file, text, diagnostics);
    let forest = parenthesised::read(text).map_err(|error| fail(vec![error]))?;
    let cores = cores(&forest).map_err(&fail)?;
    let core = chosen(file, &cores, wanted)?;
    let mut problems = CoreProblems::default();
    let mut module = Module::new();
    let index = module.tables.sources.add_file(file);
    let mut places = LineIndex::new(text, index);
    let lowered = lower::lower(
        &forest,
        core,
        &mut module.tables,
        &mut places,
        &mut problems,
    );
    let format = core.format(&forest, &mut problems);
    let ranges = ranges::ranges(&forest, core, &lowered.arguments, &mut problems);
    if !problems.errors.is_empty() {
        problems.errors.truncate(ERROR_LIMIT);
        return Err(fail(problems.errors));
    }
    module.functions.push(lowered.function);
    debug_assert!(is_valid(&module), "every function that was read is valid");
    let warnings = if problems.warnings.is_empty() {
        Report::new()
    } else {
        fail(problems.warnings)
    };
    Ok(ReadCore {
        module,
        ranges,
        format,
        warnings,
    })
}

/// The names of the cores of a file, in its order, each once.
///
/// # Errors
///
/// Fails where the text is not made of cores.
pub fn names(file: &str, text: &str) -> Result<Vec<String>, Report> {
    let fail = |diagnostics: Vec<Diagnostic>| Report::of(file, text, diagnostics);
    let forest = parenthesised::read(text).map_err(|error| fail(vec![error]))?;
    let cores = cores(&forest).map_err(&fail)?;
    Ok(cores.into_iter().map(|core| core.name).collect())
}

/// The names for a message.
fn listed(cores: &[Core]) -> String {
    let names = cores.iter().take(NAMES).map(|core| clip(&core.name));
    let list = names.collect::<Vec<_>>().join(", ");
    match cores.len().saturating_sub(NAMES) {
        0 => list,
        more => format!("{list} and {more} more"),
    }
}

/// Faults, and omitted parts.
#[derive(Default, Debug)]
struct CoreProblems {
    errors: Vec<Diagnostic>,
    warnings: Vec<Diagnostic>,
}

fn chosen<'c>(file: &str, cores: &'c [Core], wanted: Option<&str>) -> Result<&'c Core, Report> {
    let names = || cores.iter().map(|core| core.name.as_str());
    match (wanted, cores) {
        (None, [core]) => Ok(core),
        (None, []) => Err(Report::error(format!("{file} holds no FPCore"), Vec::new())),
        (None, _) => Err(Report::error(
            format!("{file} holds {} cores; choose one", cores.len()),
            vec![
                format!("--function NAME, of {}", listed(cores)),
                "a command without --function reads files of one core".to_owned(),
            ],
        )),
        (Some(wanted), _) => cores
            .iter()
            .find(|core| core.name == wanted)
            .ok_or_else(|| {
                let note = suggestion(wanted, names())
                    .unwrap_or_else(|| format!("cores: {}", listed(cores)));
                Report::error(
                    format!("{file} holds no core '{}'", clip(wanted)),
                    vec![note],
                )
            }),
    }
}
