//! Runs a pipeline on a .rvir file, every pass checked, and prints the result.
//!
//!     cargo run -p robovec-passes --example optimise -- tests/passes/specialise/alone.rvir '$shorten'

use robovec_framework::manager::{Config, run};
use robovec_ir::diagnostic::Report;
use robovec_ir::{Machine, parse, print};
use robovec_passes::registry::REGISTRY;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("a file")?;
    let passes = arguments.next().unwrap_or_else(|| "$shorten".to_owned());
    let machine = Machine::built_in("thesis").ok_or("it ships")?;
    let text = std::fs::read_to_string(&path)?;
    let mut module = parse::parse_module(&path, &text)
        .map_err(|found| Report::of(&path, text, found).render_plain())?;
    let pipeline = REGISTRY.pipeline(&passes)?;
    let mut log = std::io::stderr();
    let config = Config {
        check_each: Some(8),
        ..Config::new(&machine, &mut log)
    };
    let outcome = run(&mut module, &pipeline, config)?;
    print!("{}", print::print_module(&module));
    for record in outcome.records {
        eprintln!("{}: {} operations", record.name, record.operations);
    }
    Ok(())
}
