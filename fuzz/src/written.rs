//! Whatever function the writer of Robotran's files takes, the reader must
//! give back, in every language.

use crate::generate::{self, Kind};
use arbitrary::{Result, Unstructured};
use robovec::robotran::drop_in::{DropInOptions, drop_in};
use robovec::robotran::write::{RobotranWriteError, WriteOptions, write};
use robovec::robotran::{Language, read};
use robovec_ir::evaluate::evaluate;
use robovec_ir::print::print_output;
use robovec_ir::verify::verify;
use robovec_ir::{
    Array, Boundary, Function, Input, Module, Operand, OperandKind, Operation, Output, Shape,
    SourceSet, Tables, View,
};
use robovec_num::arithmetic::Binary64;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Writes a random function in each language and reads it.
///
/// # Panics
///
/// Panics when the result of reading is another function, or an error.
pub fn written_reads_back(data: &[u8]) {
    // Too few bytes for a function are no finding.
    let made = [
        module(&mut Unstructured::new(data)),
        sensors(&mut Unstructured::new(data)),
    ];
    for module in made.into_iter().flatten() {
        for language in Language::ALL {
            check(&module, language);
        }
    }
}

/// A random function dressed as a file of Robotran's.
fn module(bytes: &mut Unstructured<'_>) -> Result<Module> {
    let mut module = Module::new();
    let kind = *bytes.choose(&[Kind::Tame, Kind::Wild])?;
    let raw = generate::function(bytes, &mut module.tables, "accelred", kind)?;
    let calls = bytes.ratio(1, 3)?;
    let function = dressed(&raw, &mut module.tables, calls);
    module.functions.push(function);
    Ok(module)
}

/// Sensors that begin alike: each but the first has one operation changed.
fn sensors(bytes: &mut Unstructured<'_>) -> Result<Module> {
    let mut module = Module::new();
    let raw = generate::function(bytes, &mut module.tables, "sensor_1", Kind::Tame)?;
    let mut first = dressed(&raw, &mut module.tables, false);
    let fields = ["sens.P", "sens.R", "sens.V", "sens.OM", "sens.A", "sens.J"];
    let outputs = first.outputs().iter().zip(fields);
    let outputs = outputs.map(|(array, field)| (module.tables.symbols.intern(field), array.shape));
    let inputs = first.inputs().iter().map(Array::declaration);
    let renamed = Function::new(&first.name, first.level).with_arrays(inputs, outputs);
    first = first.moved_into(renamed, |input| input, Some);
    if first.assignments.is_empty() {
        return Ok(module);
    }
    for number in 2..=bytes.int_in_range(1..=4)? {
        let mut other = first.clone();
        other.name = format!("sensor_{number}");
        if !other.nodes().is_empty() {
            let last = other.nodes().len() as u32 - 1;
            let value = robovec_ir::Value(bytes.int_in_range(0..=last)?);
            let node = other.node_mut(value);
            node.operation = match node.operation {
                Operation::Add => Operation::Sub,
                Operation::Sub => Operation::Add,
                Operation::Mul => Operation::Div,
                Operation::Sin => Operation::Cos,
                other => other,
            };
        }
        module.functions.push(other);
    }
    module.functions.insert(0, first);
    Ok(module)
}

/// The function with arrays that Robotran's files can have: no scalars but the
/// time, no empty arrays, one shape for arrays that are both input and output;
/// perhaps with a call.
fn dressed(raw: &Function, tables: &mut Tables, calls: bool) -> Function {
    let (mut function, input_places, output_places) = declared(raw, tables, calls);
    if calls {
        let boundary = external_force(&function, tables);
        function.boundaries.push(boundary);
    }
    let input = |input: Input| Input(input_places[input.index()]);
    let output = |output: Output| Some(Output(output_places[output.index()]));
    raw.moved_into(function, input, output)
}

/// A function with the arrays of another, as [`dressed`] needs them, and the
/// start of its inputs and outputs in terms of the other's.
fn declared(raw: &Function, tables: &mut Tables, calls: bool) -> (Function, Vec<u32>, Vec<u32>) {
    let mut function = Function::new(&raw.name, raw.level);
    let shape = |shape: Shape| match shape {
        Shape::Scalar => Shape::Vector(1),
        other => other,
    };
    let mut input_places = vec![0; raw.input_len()];
    let mut output_places = vec![0; raw.output_len()];
    for array in raw.inputs().iter().filter(|array| !array.shape.is_empty()) {
        let name = match tables.symbols.text(array.name) {
            "sens.P" => "g",
            "in" => "In",
            "on" if calls => "SWr1",
            "on" => "tsim_",
            other => other,
        }
        .to_owned();
        let name = tables.symbols.intern(&name);
        let new = function.add_input(name, shape(array.shape));
        map(&mut input_places, array, new);
    }
    for array in raw.outputs().iter().filter(|array| !array.shape.is_empty()) {
        let name = match tables.symbols.text(array.name) {
            "sens.J" => "Jac",
            "out" => "h",
            "Z1" if calls => "PxF1",
            other => other,
        }
        .to_owned();
        let name = tables.symbols.intern(&name);
        let given = function.inputs().iter().find(|input| input.name == name);
        let given = given.map(|input| input.shape);
        let shape = match (given, shape(array.shape)) {
            (Some(given), own) if given.len() >= own.len() => given,
            (Some(_), own) => {
                // The larger one holds the elements of both.
                let inputs = function.inputs().iter().map(|array| match array.name {
                    same if same == name => (name, own),
                    _ => array.declaration(),
                });
                let outputs = function.outputs().iter().map(Array::declaration);
                function = Function::new(&raw.name, raw.level).with_arrays(inputs, outputs);
                own
            }
            (None, own) => own,
        };
        let new = function.add_output(name, shape);
        map(&mut output_places, array, new);
    }
    (function, input_places, output_places)
}

/// The call of the user's function of external forces, with its arguments and
/// results.
fn external_force(function: &Function, tables: &Tables) -> Boundary {
    let given = |arrays: &[Array], name: &str| {
        let mut arrays = arrays.iter();
        arrays.any(|array| tables.symbols.text(array.name) == name)
    };
    let mut arguments = vec!["s".to_owned(), "tsim".to_owned(), "1".to_owned()];
    if given(function.outputs(), "PxF1") {
        arguments.insert(0, "PxF1".to_owned());
    }
    let result = given(function.inputs(), "SWr1").then(|| "SWr1".to_owned());
    Boundary {
        callee: "user_ExtForces".to_owned(),
        arguments,
        result,
        sources: SourceSet::EMPTY,
    }
}

fn map(places: &mut [u32], old: &Array, new: Array) {
    for place in 0..old.shape.len() as u32 {
        places[(old.offset + place) as usize] = new.offset + place;
    }
}

fn check(module: &Module, language: Language) {
    let files = match write(module, language, &WriteOptions::default()) {
        Ok(files) => files,
        Err(RobotranWriteError::CallOrder { .. } | RobotranWriteError::Empty) => return,
        Err(error) => panic!("{error}"),
    };
    if language == Language::C {
        check_drop_in(module);
    }
    let (name, text) = &files[0];
    let again = match read(name, text.as_bytes(), None) {
        Ok(read) => read.module,
        Err(error) => panic!("{}\n{text}", error.report.render_plain()),
    };
    assert_eq!(module.functions.len(), again.functions.len(), "{text}");
    for (before, after) in module.functions.iter().zip(&again.functions) {
        let before = module.tables.view(before);
        let after = again.tables.view(after);
        compare(before, after, text);
    }
}

/// Checks that a module that can be written in one file can also be written in
/// parts, one file for each function.
fn check_drop_in(module: &Module) {
    let mut options = DropInOptions {
        test_main: true,
        ..DropInOptions::default()
    };
    options.c.part = 7;
    match drop_in(module, &options) {
        Ok(files) => {
            for (name, text) in files {
                let count = |brace| text.matches(brace).count();
                assert_eq!(count('{'), count('}'), "{name}:\n{text}");
            }
        }
        Err(error) => panic!("{error}"),
    }
}

fn compare(before: View<'_>, after: View<'_>, text: &str) {
    assert_eq!(verify(before), []);
    assert_eq!(verify(after), [], "{text}");
    assert_eq!(values(before), values(after), "{text}");
    let overwritten = before.function.inputs().iter().any(|input| {
        let mut outputs = before.function.outputs().iter();
        outputs.any(|output| output.name == input.name)
    });
    if before.function.boundaries.is_empty() && !overwritten {
        let (before, after) = (structure(before), structure(after));
        for (left, right) in before.lines().zip(after.lines()) {
            assert_eq!(left, right, "{text}");
        }
        assert_eq!(before.len(), after.len(), "{text}");
    }
}

/// The outputs' bits where every input has its own number; NaN is NaN.
fn values(view: View<'_>) -> BTreeMap<String, u64> {
    let function = view.function;
    let inputs: Vec<f64> = (0..function.input_len() as u32)
        .map(|input| {
            let bytes = element(view, Input(input)).into_bytes();
            let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            let hash = bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, mix);
            0.25 + (hash >> 40) as f64 / f64::from(1 << 24)
        })
        .collect();
    let numbers = evaluate(function, &Binary64, &inputs);
    let outputs = function.assignments.iter().zip(numbers);
    outputs
        .map(|(assignment, number)| {
            let bits = if number.is_nan() { f64::NAN } else { number }.to_bits();
            (print_output(view, assignment.output), bits)
        })
        .collect()
}

fn element(view: View<'_>, input: Input) -> String {
    let (array, indices, rank) = view.function.input_element(input);
    format!(
        "{}{:?}",
        view.tables.symbols.text(array.name),
        &indices[..rank]
    )
}

/// Every node and output in words that do not depend on names of values and
/// on the order of arrays.
fn structure(view: View<'_>) -> String {
    let operand = |operand: Operand| match operand.kind() {
        OperandKind::Value(value) => format!("%{}", value.0),
        OperandKind::Input(input) => element(view, input),
        OperandKind::Constant(constant) => {
            format!("{:?}", view.function.constant_number(constant))
        }
        OperandKind::None => String::new(),
    };
    let mut text = String::new();
    for node in view.function.nodes() {
        let named = !node.name.is_none();
        let operands = node.operands.map(operand);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{} {named} {operands:?}", node.operation.name());
    }
    let mut outputs: Vec<String> = (view.function.assignments.iter())
        .map(|output| {
            format!(
                "{} {}",
                print_output(view, output.output),
                operand(output.operand)
            )
        })
        .collect();
    outputs.sort();
    text + &outputs.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn random_functions_read_back() {
        let mut checked = 0;
        cases::of_sizes(200, 6000, |bytes| {
            for module in [module(bytes)?, sensors(bytes)?] {
                for language in Language::ALL {
                    check(&module, language);
                }
            }
            checked += 1;
            Ok(())
        });
        assert!(checked > 20, "only {checked} functions were large enough");
    }
}
