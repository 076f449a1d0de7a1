//! The C of an FMU: generated functions, tables, and the C files beside this.

use super::functions::{FmuFunction, KINDS};
use super::variables::{FmuVariables, NumberPlace};
use super::{FmuPlan, WatchedSlot};
use std::fmt::{Display, Write};

/// Elements of a line of a table.
const PER_LINE: usize = 12;

/// The whole C; `token` is that of the model description.
pub(super) fn source(
    plan: &FmuPlan,
    variables: &FmuVariables<'_>,
    functions: &[FmuFunction],
    token: &str,
) -> String {
    let model = variables.model;
    let mut text = format!(
        "/* FMU of the model {}, by robovec. */\n",
        c_text(&model.name)
    );
    text += include_str!("types.c");
    for function in functions {
        text += &function.source;
        text.push('\n');
    }
    let slots = variables.list.len();
    text += "/* The model. */\n";
    let sizes = [
        ("SLOTS", slots),
        ("JOINTS", model.joints.len()),
        ("LINKS", model.links.len()),
        ("FORCES", model.forces.len()),
        ("ROWS", plan.row_cuts.len()),
        ("DEPENDENT", plan.dependent.len()),
        ("STATES", 2 * plan.independent.len()),
        ("EVENTS", plan.watched.len()),
        ("FRAMES", model.sensors.len() + model.frames.len()),
        (
            "INPUTS",
            functions.iter().map(|function| function.from.len()).sum(),
        ),
        (
            "MOST_RESULTS",
            functions
                .iter()
                .map(|function| function.to.len())
                .max()
                .unwrap_or(0),
        ),
    ];
    for (name, size) in sizes {
        line(&mut text, format_args!("#define {name} {size}"));
    }
    line(&mut text, format_args!("#define TOKEN \"{token}\""));
    for (block, first) in &variables.blocks {
        line(&mut text, format_args!("#define {block} {first}"));
    }
    text += "\n";
    tables(&mut text, plan, variables);
    let kinds = KINDS + model.sensors.len() + model.frames.len();
    function_tables(&mut text, functions, kinds, slots as u32);
    text += include_str!("laws.c");
    text.push('\n');
    text += include_str!("motion.c");
    text.push('\n');
    text += include_str!("fmi3.c");
    text
}

fn tables(text: &mut String, plan: &FmuPlan, variables: &FmuVariables<'_>) {
    let list = &variables.list;
    let roles = list
        .iter()
        .map(|variable| format!("'{}'", variable.role.letter()));
    table(text, "char kinds[]", roles);
    let started = || {
        list.iter()
            .enumerate()
            .filter(|(_, variable)| variable.start != 0.0)
    };
    table(
        text,
        "unsigned start_slots[]",
        started().map(|(slot, _)| slot),
    );
    table(
        text,
        "double starts[]",
        started().map(|(_, variable)| format!("{:?}", variable.start)),
    );
    let [q, qd, qdd] = ["AT_Q", "AT_QD", "AT_QDD"].map(|block| variables.block(block));
    let free = || plan.independent.iter().map(|&joint| joint as u32);
    let states = free()
        .map(|joint| q + joint)
        .chain(free().map(|joint| qd + joint));
    table(text, "unsigned states[]", states);
    let slopes = free()
        .map(|joint| qd + joint)
        .chain(free().map(|joint| qdd + joint));
    table(text, "unsigned slopes[]", slopes);
    table(text, "unsigned dependent[]", plan.dependent.iter());
    let model = variables.model;
    table(
        text,
        "char *const joints[]",
        model.joints.iter().map(|joint| c_text(&joint.name)),
    );
    let cuts = plan
        .row_cuts
        .iter()
        .map(|&cut| c_text(&model.cuts[cut].name));
    table(text, "char *const cuts[]", cuts);
    let laws = &variables.laws;
    let places = [
        ("unsigned joint_laws[]", &laws.joints),
        ("unsigned link_laws[]", &laws.links),
        ("unsigned force_laws[]", &laws.forces),
        ("unsigned ground_laws[]", &laws.ground),
        ("unsigned tyre_laws[]", &laws.tyres),
        ("unsigned drive_laws[]", &laws.drives),
    ];
    for (name, places) in places {
        table(text, name, places.iter());
    }
    table(text, "double link_signs[]", plan.link_signs.iter());
    let events = plan.watched.iter().map(|event| {
        let WatchedSlot {
            slot,
            value,
            direction,
            stops,
        } = event;
        format!("{{{slot}, {value:?}, {direction}, {}}}", u8::from(*stops))
    });
    table(
        text,
        "Event events[]",
        events.chain(["{0, 0, 0, 0}".to_owned()]),
    );
}

/// The functions, from values to values and along a direction.
fn function_tables(text: &mut String, functions: &[FmuFunction], kinds: usize, slots: u32) {
    let slot = |place: &NumberPlace| place.slot + if place.along { slots } else { 0 };
    let mut entries = vec!["{NULL, NULL, NULL, 0, 0, 0, 0}".to_owned(); 2 * kinds];
    let mut place = 0;
    for function in functions {
        let name = &function.name;
        table(
            text,
            &format!("unsigned {name}_from[]"),
            function.from.iter().map(slot),
        );
        table(
            text,
            &format!("unsigned {name}_to[]"),
            function.to.iter().map(slot),
        );
        let (moving, inputs, results) = (function.moving, function.from.len(), function.to.len());
        entries[kinds * usize::from(function.along) + function.kind] =
            format!("{{{name}, {name}_from, {name}_to, {moving}, {inputs}, {results}, {place}}}");
        place += inputs;
    }
    text.push_str("static const Function functions[2][KINDS + FRAMES] = {\n");
    for entry in entries.chunks(kinds) {
        line(text, format_args!("    {{{}}},", entry.join(",\n     ")));
    }
    text.push_str("};\n\n");
}

/// A constant array, of one zero when there are no elements.
fn table<T: Display>(text: &mut String, declaration: &str, elements: impl Iterator<Item = T>) {
    let mut elements: Vec<String> = elements.map(|element| element.to_string()).collect();
    if elements.is_empty() {
        elements.push("0".to_owned());
    }
    line(text, format_args!("static const {declaration} = {{"));
    for elements in elements.chunks(PER_LINE) {
        line(text, format_args!("    {},", elements.join(", ")));
    }
    text.push_str("};\n");
}

fn line(text: &mut String, line: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{line}");
}

/// A text of C; letters outside of ASCII are written as bytes.
fn c_text(text: &str) -> String {
    let mut quoted = String::from("\"");
    for byte in text.bytes() {
        match byte {
            b' '..=b'~' if !matches!(byte, b'"' | b'\\' | b'?' | b'*') => quoted.push(byte.into()),
            // Writing to a string cannot fail.
            _ => {
                let _ = write!(quoted, "\\{byte:03o}");
            }
        }
    }
    quoted + "\""
}
