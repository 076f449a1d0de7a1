//! The Python package: functions as objects that are read, transformed,
//! evaluated and written. What NumPy does better (shapes, checks of arguments,
//! loading of compiled code) is in `robovec/__init__.py`; here numbers are
//! flat lists of binary64 in the order in which the function declares them.
//!
//! **Invariants.** An object never changes; the interpreter is released during
//! all work; whatever the user got wrong is an exception with the text that the
//! command line would show.

mod program;
mod values;

use program::PythonProgram;
use pyo3::prelude::*;

pyo3::create_exception!(
    robovec,
    Error,
    pyo3::exceptions::PyException,
    "What robovec refuses, with the place and the remedy."
);

/// The module behind the package.
#[pymodule]
fn _robovec(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("Error", module.py().get_type::<Error>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<PythonProgram>()
}
