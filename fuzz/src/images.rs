//! The simulator must load, refuse or run any images: never panic, never hang.

use arbitrary::{Result, Unstructured};
use robovec::simulate::LoadedProgram;
use robovec::simulate::mif::Image;
use robovec_fpga::images;
use robovec_ir::{
    Assignment, Function, Input, Level, Machine, Module, Name, Node, Operand, Operation, Output,
    Shape, SourceSet,
};
use robovec_schedule::{PlaceOptions, place};

const MACHINES: [&str; 4] = ["thesis", "side-split", "ideal", "de10-nano"];
const INPUTS: u32 = 3;

/// Places a small random function, damages its images in a few places, loads
/// them and, if that succeeds, runs them.
///
/// # Panics
///
/// Panics when placement refuses the function or the undamaged images do not
/// run; the simulator itself must not.
pub fn simulate_garbage(data: &[u8]) {
    // The bytes as they are, too: an image of nobody's making.
    let _ = Image::parse(&String::from_utf8_lossy(data));
    // Too few bytes for a function and its damage are no finding.
    let _ = damage_and_run(&mut Unstructured::new(data));
}

/// As [`simulate_garbage`]; true when the damaged images ran to the end.
///
/// # Errors
///
/// Fails when the bytes run out.
///
/// # Panics
///
/// As [`simulate_garbage`].
pub fn damage_and_run(bytes: &mut Unstructured<'_>) -> Result<bool> {
    let machine = Machine::built_in(bytes.choose(&MACHINES)?).expect("it ships");
    let mut files = sound_images(bytes, &machine)?;
    let inputs = [1.5, -0.25, 3.0];
    let program = LoadedProgram::load(&files, &machine).expect("sound images can be loaded");
    program.run(&inputs).expect("sound images run");
    for _ in 0..bytes.int_in_range(1..=4)? {
        let index = bytes.choose_index(files.len())?;
        damage(bytes, &mut files[index].1)?;
    }
    let Ok(program) = LoadedProgram::load_edited(&files, &machine) else {
        return Ok(false);
    };
    Ok(program.run(&inputs).is_ok())
}

fn sound_images(bytes: &mut Unstructured<'_>, machine: &Machine) -> Result<Vec<(String, String)>> {
    let mut module = Module::new();
    let symbols = &mut module.tables.symbols;
    let mut function = Function::new("random", Level::Atomic);
    function.add_input(symbols.intern("q"), Shape::Vector(INPUTS));
    function.add_output(symbols.intern("out"), Shape::Vector(2));
    let base = symbols.intern("v");
    let mut known: Vec<Operand> = (0..INPUTS).map(|index| Input(index).into()).collect();
    known.push(function.constant(0.1).into());
    for suffix in 0..bytes.int_in_range(1..=24)? {
        let operation = *bytes.choose(&[Operation::Add, Operation::Sub, Operation::Mul])?;
        let operands = [*bytes.choose(&known)?, *bytes.choose(&known)?];
        let value = function.push(Node {
            name: Name { base, suffix },
            sources: SourceSet::EMPTY,
            operands: Operand::list(operands),
            operation,
        });
        known.push(value.into());
    }
    let last = known.len() - 1;
    function.assignments = [known[last], *bytes.choose(&known)?]
        .into_iter()
        .enumerate()
        .map(|(index, operand)| Assignment {
            output: Output(index as u32),
            operand,
            sources: SourceSet::EMPTY,
        })
        .collect();
    place(&mut function, machine, PlaceOptions::default()).expect("it can be placed");
    let view = module.tables.view(&function);
    Ok(images(view, machine, None).expect("a placed function has images"))
}

/// One small change of a text, as an editor, a broken disk or a wrong generator
/// makes.
fn damage(bytes: &mut Unstructured<'_>, text: &mut String) -> Result<()> {
    if text.is_empty() {
        return Ok(());
    }
    let start = bytes.choose_index(text.len())?;
    let length = bytes.int_in_range(0..=12)?;
    let end = (start + length).min(text.len());
    let (start, end) = (boundary(text, start), boundary(text, end));
    match bytes.int_in_range(0..=4)? {
        0 => text.truncate(start),
        1 => text.replace_range(start..end, ""),
        2 => {
            let piece = text[start..end].repeat(bytes.int_in_range(1..=3)?);
            text.insert_str(end, &piece);
        }
        3 => {
            let digits = format!("{:X}", bytes.arbitrary::<u64>()?);
            text.replace_range(start..end, &digits);
        }
        _ => {
            // A digit for a digit keeps the file well formed most often.
            let digit = *bytes.choose(b"0123456789ABCDEF")? as char;
            let from_here = |character: char| character.is_ascii_hexdigit();
            if let Some(found) = text[start..].find(from_here) {
                let place = start + found;
                text.replace_range(place..place + 1, &digit.to_string());
            }
        }
    }
    Ok(())
}

fn boundary(text: &str, at: usize) -> usize {
    (0..=at)
        .rev()
        .find(|&place| text.is_char_boundary(place))
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn damaged_images_are_loaded_or_refused() {
        let (mut ran, mut refused) = (0, 0);
        cases::of_sizes(1000, 2000, |bytes| {
            if damage_and_run(bytes)? {
                ran += 1;
            } else {
                refused += 1;
            }
            Ok(())
        });
        assert!(ran > 0 && refused > 0, "{ran} ran, {refused} were refused");
    }
}
