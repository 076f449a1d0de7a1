//! Places atomic functions on a machine: a registry of one pass.
//!
//!     cargo run -p robovec-schedule --example place -- tests/passes/place/crowded.rvir thesis

use robovec_framework::manager::{Config, run};
use robovec_framework::pass::Registry;
use robovec_ir::diagnostic::Report;
use robovec_ir::{Machine, parse, print};
use robovec_schedule::Place;
use std::error::Error;

static REGISTRY: Registry = Registry {
    passes: &[Place::INFO],
    presets: &[],
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("a file")?;
    let machine = arguments.next().unwrap_or_else(|| "thesis".to_owned());
    let machine = Machine::built_in(&machine).ok_or("there is no such machine")?;
    let text = std::fs::read_to_string(&path)?;
    let mut module = parse::parse_module(&path, &text)
        .map_err(|found| Report::of(&path, text, found).render_plain())?;
    let pipeline = REGISTRY.pipeline("place")?;
    run(
        &mut module,
        &pipeline,
        Config::new(&machine, &mut std::io::stderr()),
    )?;
    print!("{}", print::print_module(&module));
    Ok(())
}
