//! Written files, external tools, and files that have changed: the parts of a
//! run other than the equations.

mod folders;
mod machines;
mod replaced;
mod tools;
mod written;

use crate::support::programs::{opt_in, said, stderr};
use std::path::Path;
use std::process::Output;

/// Two sums and a product.
const PROGRAM: &str = "// robovec 1

function blend atomic {
  in a
  in b
  out M

  %p = a*b
  %s = %p + b
  %t = %s + a

  M = %t
}
";

/// A small model that ships.
fn pendulum() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = root.join("examples/models/double-pendulum.mbs");
    path.display().to_string()
}

/// The messages of a run that must be refused.
fn refused(output: &Output) -> String {
    let errors = stderr(output);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(!errors.contains("panicked"), "{errors}");
    assert!(!errors.contains("mistake in the pass"), "{errors}");
    errors
}

/// A folder with the program in `blend.rvir`.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&folder.path().join("blend.rvir"), PROGRAM);
    folder
}

/// A folder with the program, and with it placed.
fn placed() -> tempfile::TempDir {
    let folder = folder();
    let place = ["blend.rvir", "-passes=place", "-o", "placed.rvir"];
    said(&opt_in(folder.path(), &place));
    folder
}

fn write(path: &Path, text: &str) {
    std::fs::write(path, text).expect("a folder of our own");
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).expect("it is there")
}
