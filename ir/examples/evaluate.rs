//! Reads functions of a .rvir file and evaluates them at a random state.
//!
//!     cargo run -p robovec-ir --example evaluate -- tests/passes/specialise/alone.rvir

use robovec_ir::evaluate::evaluate;
use robovec_ir::states::States;
use robovec_ir::{parse, print};
use robovec_num::arithmetic::Binary64;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("a file")?;
    let text = std::fs::read_to_string(&path)?;
    let module = parse::parse_module(&path, &text)
        .map_err(|found| robovec_ir::diagnostic::Report::of(&path, text, found).render_plain())?;
    for function in &module.functions {
        let view = module.tables.view(function);
        let inputs = States::new(1).draw(view, 0);
        let outputs = evaluate(function, &Binary64, &inputs);
        for (assignment, number) in function.assignments.iter().zip(outputs) {
            println!(
                "{} = {number}",
                print::print_output(view, assignment.output)
            );
        }
    }
    Ok(())
}
