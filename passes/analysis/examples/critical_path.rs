//! The critical path of every function of a .rvir file on a machine.
//!
//!     cargo run -p robovec-analysis --example critical_path -- tests/passes/specialise/alone.rvir thesis

use robovec_analysis::critical_path::critical_path;
use robovec_ir::diagnostic::Report;
use robovec_ir::{Machine, parse};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("a file")?;
    let machine = arguments.next().unwrap_or_else(|| "thesis".to_owned());
    let machine = Machine::built_in(&machine).ok_or("there is no such machine")?;
    let text = std::fs::read_to_string(&path)?;
    let module = parse::parse_module(&path, &text)
        .map_err(|found| Report::of(&path, text, found).render_plain())?;
    for function in &module.functions {
        let longest = critical_path(function, &machine);
        println!(
            "{}: {} operations, {} cycles",
            function.name, longest.asap, longest.asap_cycle
        );
    }
    Ok(())
}
