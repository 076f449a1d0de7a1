//! Writes C for the first function of a .rvir file.
//!
//!     cargo run -p robovec-cgen --example write_c -- tests/passes/specialise/alone.rvir

use robovec_cgen::c::{Real, c_files};
use robovec_ir::diagnostic::Report;
use robovec_ir::{View, parse};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("a file")?;
    let text = std::fs::read_to_string(&path)?;
    let module = parse::parse_module(&path, &text)
        .map_err(|found| Report::of(&path, text, found).render_plain())?;
    let view = View {
        tables: &module.tables,
        function: module.functions.first().ok_or("the file has no function")?,
    };
    for (name, content) in c_files(view, Real::Double) {
        println!("/* {name} */\n{content}");
    }
    Ok(())
}
