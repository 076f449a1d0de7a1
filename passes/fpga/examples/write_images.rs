//! Writes memory images for the first function of a placed .rvir file.
//!
//!     cargo run -p robovec-fpga --example write_images -- tests/text/placed.rvir

use robovec_fpga::images;
use robovec_ir::diagnostic::Report;
use robovec_ir::{Machine, parse};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("a file")?;
    let text = std::fs::read_to_string(&path)?;
    let module = parse::parse_module(&path, &text)
        .map_err(|found| Report::of(&path, text, found).render_plain())?;
    let view = module
        .tables
        .view(module.functions.first().ok_or("the file has no function")?);
    let machine = Machine::built_in("thesis").ok_or("there is no such machine")?;
    for (name, content) in images(view, &machine, None)? {
        println!("{name}\n{content}");
    }
    Ok(())
}
