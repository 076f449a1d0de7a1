//! From a file of Robotran to C: reads equations, runs passes, writes a
//! function and its header into a folder.
//!
//!     cargo run --example to_c -- examples/suspension/mbs_dirdyna_suspension.m /tmp

use robovec::sources;
use robovec_cgen::c::{Real, c_files};
use robovec_framework::manager::{Config, run};
use robovec_ir::Machine;
use robovec_passes::registry::REGISTRY;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, folder] = arguments.as_slice() else {
        return Err("a file and a folder".into());
    };
    let read =
        sources::equations(Path::new(input), None, None).map_err(|found| found.render_plain())?;
    let mut module = read.module;
    let machine = Machine::built_in("thesis").ok_or("it ships")?;
    let pipeline = REGISTRY.pipeline("$cpu")?;
    run(
        &mut module,
        &pipeline,
        Config::new(&machine, &mut std::io::stderr()),
    )?;
    for function in &module.functions {
        let view = module.tables.view(function);
        for (name, content) in c_files(view, Real::Double) {
            std::fs::write(Path::new(folder).join(&name), content)?;
            println!("{name}");
        }
    }
    Ok(())
}
