//! Compares the first functions of two .rvir files over the real numbers.
//!
//!     cargo run -p robovec-framework --example compare -- tests/check/common-divisor.before.rvir tests/check/common-divisor.after.rvir

use robovec_framework::NumericClass;
use robovec_framework::check::check;
use robovec_ir::diagnostic::Report;
use robovec_ir::states::States;
use robovec_ir::{Module, parse};
use std::error::Error;

fn read(path: &str) -> Result<Module, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let module = parse::parse_module(path, &text);
    Ok(module.map_err(|found| Report::of(path, text, found).render_plain())?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let [before, after] = paths.as_slice() else {
        return Err("two files".into());
    };
    let modules = [read(before)?, read(after)?];
    let [before, after] = modules
        .each_ref()
        .map(|module| module.tables.view(&module.functions[0]));
    let verdict = check(before, after, NumericClass::Real, &States::new(1), 8);
    println!("{verdict}");
    Ok(())
}
