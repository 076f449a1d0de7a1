//! `robovec fit --explain`: meaning of a scene.

use super::FitArguments;
use crate::command::{CommandFailure, input};
use robovec_explore::scene::{SceneEffect, SceneFile, SceneSubject, effects};
use robovec_fpga::hardware;
use robovec_framework::scene::{Hold, Scene};
use robovec_ir::diagnostic::counted;
use robovec_ir::{Input, Machine, Module, View};
use robovec_present::number::{exponential, or_dash};
use robovec_present::text_table;
use std::fmt::Write;

pub(super) fn run(arguments: &FitArguments) -> Result<String, CommandFailure> {
    let file = input::scene(&arguments.scene)?;
    let fail =
        |error: String| CommandFailure::plain(format!("{}: {error}", arguments.scene.display()));
    let module = file.module().map_err(|error| fail(error.to_string()))?;
    let machine = super::machine(arguments, &file, &module)?;
    let effects = effects(&file, &machine).map_err(|error| fail(error.to_string()))?;
    let mut text = format!("{}\n", file.scene.name);
    if !file.scene.description.is_empty() {
        text += &format!("{}\n", file.scene.description);
    }
    text += &about(&file);
    text += &joints(&file.scene);
    text += &outputs(&file.scene, &module);
    text += &inputs(&file.scene, &module);
    text += &worth(&effects, &machine, &file.scene);
    Ok(text)
}

fn about(file: &SceneFile) -> String {
    match &file.subject {
        SceneSubject::Equations(module) => {
            let names: Vec<&str> = module.functions.iter().map(|f| f.name.as_str()).collect();
            format!("\nfunction {}, as it was read\n", names.join(", "))
        }
        SceneSubject::Model(subject) => format!(
            "\nfunction {} of the model {}, formulation {}\n",
            subject.name,
            subject.model.name,
            file.formulation().name()
        ),
    }
}

fn joints(scene: &Scene) -> String {
    if scene.joints.is_empty() {
        return String::new();
    }
    let rows: Vec<Vec<String>> = scene
        .joints
        .iter()
        .map(|joint| {
            let hold = match joint.hold {
                Hold::Locked(position) => format!("locked at {position}"),
                Hold::Driven => "driven".to_owned(),
            };
            vec![joint.number.to_string(), joint.name.clone(), hold]
        })
        .collect();
    format!("\n{}\n", text_table(">joint | name | held", &rows))
}

fn outputs(scene: &Scene, module: &Module) -> String {
    let tables = &module.tables;
    let views = || {
        module
            .functions
            .iter()
            .map(|function| View { tables, function })
    };
    let all: usize = module.functions.iter().map(|f| f.assignments.len()).sum();
    if scene.outputs.is_empty() {
        return format!("\nneeded: all of {}\n", counted(all, "output"));
    }
    let rows: Vec<Vec<String>> = scene
        .outputs
        .iter()
        .map(|need| {
            let count: usize = views().map(|view| need.pattern.outputs(view).len()).sum();
            let error = need.tolerance.map_or("any".to_owned(), |t| t.to_string());
            vec![need.pattern.to_string(), count.to_string(), error]
        })
        .collect();
    let needed: usize = views()
        .map(|view| {
            let set = view.function.assignments.iter();
            set.filter(|set| scene.needs(view, set.output)).count()
        })
        .sum();
    let head = "output | >elements | allowed error";
    format!(
        "\nneeded: {needed} of {}\n{}\n",
        counted(all, "output"),
        text_table(head, &rows)
    )
}

/// Number of elements of an input array that are read, and their known ranges.
#[derive(Default)]
struct InputCoverage {
    name: String,
    read: usize,
    bound: usize,
    ranged: usize,
}

fn inputs(scene: &Scene, module: &Module) -> String {
    let mut arrays: Vec<InputCoverage> = Vec::new();
    for function in &module.functions {
        let mut read = vec![false; function.input_len()];
        let operands = function.nodes().iter().flat_map(|node| node.operands());
        let set = function.assignments.iter().map(|set| &set.operand);
        for input in operands.chain(set).filter_map(|operand| operand.input()) {
            read[input.index()] = true;
        }
        for index in (0..read.len()).filter(|&index| read[index]) {
            let (array, indices, _) = function.input_element(Input(index as u32));
            let name = module.tables.symbols.text(array.name);
            let place = arrays.iter().position(|known| known.name == name);
            let place = place.unwrap_or_else(|| {
                arrays.push(InputCoverage {
                    name: name.to_owned(),
                    ..InputCoverage::default()
                });
                arrays.len() - 1
            });
            let known = &mut arrays[place];
            known.read += 1;
            if scene.bound.get(name, indices).is_some() {
                known.bound += 1;
            } else if scene.ranges.get(name, indices).is_some() {
                known.ranged += 1;
            }
        }
    }
    let number = |count: usize| match count {
        0 => String::new(),
        count => count.to_string(),
    };
    let rows: Vec<Vec<String>> = arrays
        .iter()
        .map(|known| {
            let free = known.read - known.bound - known.ranged;
            let counts = [known.read, known.bound, known.ranged, free];
            let mut row = vec![known.name.clone()];
            row.extend(counts.map(number));
            row
        })
        .collect();
    let head = "input | >read | >bound | >ranged | >free";
    format!("\n{}\n", text_table(head, &rows))
}

fn worth(effects: &[SceneEffect], machine: &Machine, scene: &Scene) -> String {
    let general = effects[0].operations.max(1);
    let rows: Vec<Vec<String>> = effects
        .iter()
        .map(|effect| {
            let share = 100.0 * effect.operations as f64 / general as f64;
            vec![
                effect.what.to_owned(),
                effect.operations.to_string(),
                format!("{share:.0} %"),
                effect.sin_cos.to_string(),
                effect.path.to_string(),
                or_dash(effect.placed, |(cycles, _)| cycles.to_string()),
                or_dash(effect.placed, |(_, share)| {
                    format!("{:.2} %", 100.0 * share)
                }),
                exponential(effect.normwise.median),
                exponential(effect.normwise.worst),
            ]
        })
        .collect();
    let head = "used | >operations | >of them | >sin, cos | >longest chain | >cycles | >of device | \
         >median error | >worst error";
    let mut text = format!("\n{}\n", text_table(head, &rows));
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(
        text,
        "cycles and errors on {}, in {}; errors in parts of the largest element of the array, at \
         states of the scene, against double-double arithmetic",
        machine.name, machine.number
    );
    if let (Some(deadline), Some(last)) = (scene.deadline, effects.last()) {
        let cycles = last.placed.map_or(last.path, |(cycles, _)| cycles);
        let what = match last.placed {
            Some(_) => "the schedule",
            None => "the longest chain",
        };
        let time = hardware::clock(machine).microseconds(cycles);
        let verdict = if time <= deadline {
            "within the deadline of"
        } else {
            "beyond the deadline of"
        };
        let _ = writeln!(
            text,
            "\n{what} takes {time:.2} us on {}, {verdict} {deadline} us",
            machine.name
        );
    }
    text
}
