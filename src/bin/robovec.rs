//! `robovec`: evaluation, simulation and comparison of what `robovec-opt`
//! reads and writes.

use std::process::ExitCode;

fn main() -> ExitCode {
    robovec::command::tool::main(std::env::args_os())
}
