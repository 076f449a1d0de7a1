//! `robovec-opt`: reads equations, runs a pipeline, writes the result.

use std::process::ExitCode;

fn main() -> ExitCode {
    robovec::command::opt::main(std::env::args_os())
}
