//! Evaluates a Robotran file at the states of another file:
//! `cargo run --example evaluate -- FILE STATES`.

use robovec::evaluate_command::evaluate_at_states;
use robovec::robotran::read;
use robovec_ir::diagnostic::Report;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, states] = &arguments[..] else {
        eprintln!("usage: evaluate FILE STATES");
        return ExitCode::FAILURE;
    };
    match run(file, states) {
        Ok(text) => {
            print!("{text}");
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprint!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn run(file: &str, states: &str) -> Result<String, String> {
    let bytes = std::fs::read(file).map_err(|error| format!("{file}: {error}\n"))?;
    let states_text =
        std::fs::read_to_string(states).map_err(|error| format!("{states}: {error}\n"))?;
    let module = read(file, &bytes, None)
        .map_err(|error| error.report.render_plain())?
        .module;
    evaluate_at_states(&module, &states_text)
        .map_err(|errors| Report::of(states, states_text.as_str(), errors).render_plain())
}
