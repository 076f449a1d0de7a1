//! The Python package: functions as objects that are read, transformed,
//! evaluated and written. Tasks that NumPy does better (shapes, checks of
//! arguments, loading of compiled code) are in `robovec/__init__.py`; here
//! numbers are flat lists of binary64 in the order in which the function
//! declares them.
//!
//! **Invariants.** An object never changes; the interpreter is released during
//! all work; every mistake of the user is an exception with the text that the
//! command line would show.

mod program;
mod values;

use program::PythonProgram;
use pyo3::prelude::*;
use robovec::files::Replace;
use robovec::files::sealed::write_folder;
use std::path::PathBuf;

pyo3::create_exception!(
    robovec,
    Error,
    pyo3::exceptions::PyException,
    "What robovec refuses, with the place and the remedy."
);

/// Writes files into a folder, which is made; files of programs that robovec
/// did not write stay.
#[pyfunction]
fn write_files(folder: PathBuf, files: Vec<(String, String)>) -> PyResult<()> {
    let files: Vec<(&str, &str)> = files
        .iter()
        .map(|(name, text)| (&**name, &**text))
        .collect();
    write_folder(&folder, &files, Replace::Results)
        .map_err(|error| Error::new_err(error.to_string()))
}

/// The module after the package.
#[pymodule]
fn _robovec(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("Error", module.py().get_type::<Error>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(write_files, module)?)?;
    module.add_class::<PythonProgram>()
}
