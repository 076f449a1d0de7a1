//! `robovec`: evaluation, simulation and comparison of the files that
//! `robovec-opt` reads and writes. Called by the name `robovec-opt` it is that
//! program, so that one file in WebAssembly holds both.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let name = std::env::args_os().next().unwrap_or_default();
    if Path::new(&name).file_stem() == Some("robovec-opt".as_ref()) {
        return robovec::command::opt::main(std::env::args_os());
    }
    robovec::command::tool::main(std::env::args_os())
}
