//! The manifest as Tcl: where the cable's script finds everything.

use super::super::manifest::{Manifest, OutputValue, WordAddress};
use std::fmt::Write;

/// The script `map.tcl`: memories with their images, and the addresses of
/// inputs and outputs.
pub(super) fn map(manifest: &Manifest) -> String {
    let mut text = String::from(
        "# Where the host finds everything, in 32-bit words. Written by robovec.\n\
         # memories: name {address limbs stride image}; an image that only the host can\n\
         # give is the file with its constants.\n",
    );
    let window = manifest.window.as_ref();
    let window = window.expect("the images of hardware have a window");
    let image = |name: &str| {
        let own = name.strip_suffix(".instructions");
        let elements = manifest.elements.iter();
        let mut files = elements.flat_map(|element| {
            let instructions =
                (own == Some(element.name.as_str())).then_some(element.instructions.file.as_str());
            let memories = element.memories.iter();
            let memories = memories
                .filter(|memory| memory.name == name)
                .map(|memory| memory.file.as_str());
            instructions.into_iter().chain(memories)
        });
        let file = files.next();
        let file = file.expect("every unit of the window is a memory of the manifest");
        file.strip_suffix(".mif").unwrap_or(file).to_owned()
    };
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(text, "set robovec_cycles {}", manifest.cycles);
    let _ = writeln!(text, "set robovec_machine_hash {}", window.machine_hash);
    let _ = writeln!(text, "set robovec_schedule_hash {}", manifest.schedule_hash);
    let limbs = window.units.iter().filter(|unit| unit.readable);
    let limbs = limbs.map(|unit| unit.limbs).fold(1, u32::max);
    let _ = writeln!(text, "set robovec_limbs {limbs}");
    text += "set robovec_memories {\n";
    for unit in &window.units {
        let _ = writeln!(
            text,
            "    {{{}}} {{{} {} {} {{{}}}}}",
            unit.name,
            unit.address,
            unit.limbs,
            unit.stride,
            image(&unit.name)
        );
    }
    text += "}\n# inputs and host values: name {address ...}; all of them are to be written.\n";
    text += "set robovec_inputs {\n";
    let address = |word: &WordAddress| {
        let unit = window.units.iter().find(|unit| unit.name == word.memory);
        let unit = unit.expect("every memory of the manifest is a unit of the window");
        unit.address + word.address * unit.stride
    };
    let inputs = manifest
        .inputs
        .iter()
        .map(|input| (&input.name, &input.words));
    let host = manifest
        .host
        .iter()
        .map(|value| (&value.name, &value.words));
    for (name, words) in inputs.chain(host) {
        let places: Vec<String> = words.iter().map(|word| address(word).to_string()).collect();
        let _ = writeln!(text, "    {{{name}}} {{{}}}", places.join(" "));
    }
    text += "}\n# outputs: name address; those known before the run are left out.\n";
    text += "set robovec_outputs {\n";
    for output in &manifest.outputs {
        if let OutputValue::Home(home) = &output.value {
            let word = WordAddress {
                memory: home.memory.clone(),
                address: home.address,
            };
            let _ = writeln!(text, "    {{{}}} {}", output.name, address(&word));
        }
    }
    text += "}\n";
    text
}
