//! C files that replace Robotran's, for speed.
//!
//! [`write()`] gives a file as Robotran would have written it: one function,
//! which reads back. Here the same function is written for compilers and
//! processors (`robovec_cgen::c`): in bounded parts, in an order that keeps
//! values in registers, with all sines in one loop. Others (sensors, and those
//! that call user functions in the middle) are written in one piece.

use super::Language;
use super::write::{RobotranWriteError, WriteOptions, write};
use robovec_cgen::c::{
    Options, Real, SignatureError, TrialState, files, function_name, minimal_data, trial_main,
};
use robovec_ir::states::States;
use robovec_ir::{Assignment, Function, Module, Output, SourceSet, View};

/// Options of drop-in C.
#[derive(Clone, Default, Debug)]
pub struct DropInOptions {
    /// The C itself.
    pub c: Options,
    /// Name of the model and elements that are not set, as in [`write()`].
    pub write: WriteOptions,
    /// Write beside each function a main program that tries it, and a
    /// `mbs_data.h` to compile both without MBsysC.
    pub test_main: bool,
    /// With a main program: other functions of the same signature that it calls
    /// first and compares and times against, by their linked names.
    pub rivals: Vec<String>,
}

/// Maximum distance of compiled results, relative to an array's largest.
pub const TOLERANCE: f64 = 1e-12;

/// The same for functions that compute in binary32.
pub const TOLERANCE_OF_FLOAT: f64 = 1e-4;

/// Writes every function of a module; gives names and texts of the files.
///
/// # Errors
///
/// Fails when the module has parts that Robotran's files cannot express.
pub fn drop_in(
    module: &Module,
    options: &DropInOptions,
) -> Result<Vec<(String, String)>, RobotranWriteError> {
    let mut written = Vec::new();
    let mut rest = Module {
        tables: module.tables.clone(),
        functions: Vec::new(),
    };
    for function in &module.functions {
        let mut function = function.clone();
        if let Some(model) = &options.write.model {
            function.metadata.retain(|(key, _)| key != "model");
            function.metadata.push(("model".to_owned(), model.clone()));
        }
        if options.write.zeros {
            set_zeros(&mut function);
        }
        let view = module.tables.view(&function);
        match files(view, &options.c) {
            Ok(files) => {
                written.extend(files.clone());
                if options.test_main {
                    let text = test(view, options);
                    written.push((files[0].0.replace(".c", "_test.c"), text));
                }
            }
            Err(SignatureError::Sensor(_) | SignatureError::Call { .. }) => {
                rest.functions.push(function);
            }
            Err(error) => return Err(RobotranWriteError::Signature(error)),
        }
    }
    if !rest.functions.is_empty() {
        written.extend(write(&rest, Language::C, &options.write)?);
    }
    if options.test_main {
        let views = module
            .functions
            .iter()
            .map(|function| module.tables.view(function));
        written.push(minimal_data(views));
    }
    if written.is_empty() {
        return Err(RobotranWriteError::Empty);
    }
    Ok(written)
}

/// The main program that tries a function.
fn test(view: View<'_>, options: &DropInOptions) -> String {
    let tolerance = match options.c.real {
        Real::Double => TOLERANCE,
        Real::Float => TOLERANCE_OF_FLOAT,
    };
    let trial = TrialState::new(view, state(view), tolerance);
    let name = function_name(view, &options.c);
    let rivals = options.rivals.iter().map(String::as_str);
    let contestants: Vec<&str> = rivals.chain([name.as_str()]).collect();
    trial_main(view, &options.c, &contestants, &trial)
}

/// A random state in which every unread input is 0: structural zeros of the
/// model, for functions in which they are symbols.
pub fn state(view: View<'_>) -> Vec<f64> {
    let function = view.function;
    let mut is_read = vec![false; function.input_len()];
    let nodes = function.nodes().iter().flat_map(|node| node.operands());
    let outputs = function.assignments.iter().map(|output| &output.operand);
    for input in nodes.chain(outputs).filter_map(|operand| operand.input()) {
        is_read[input.index()] = true;
        let (array, indices, _) = function.input_element(input);
        // A tensor of inertia is symmetric: both elements are read.
        if view.tables.symbols.text(array.name) == "In" {
            let row = [0, 1, 4, 7, 2, 5, 8, 3, 6, 9].get(indices[0] as usize);
            let twin = row.and_then(|&row| array.shape.offset(&[row, indices[1]]));
            if let Some(offset) = twin {
                is_read[(array.offset + offset) as usize] = true;
            }
        }
    }
    let mut numbers = States::new(1).draw(view, 0);
    assert_eq!(
        numbers.len(),
        is_read.len(),
        "a state has a number per input element"
    );
    for (number, is_read) in numbers.iter_mut().zip(is_read) {
        if !is_read {
            *number = 0.0;
        }
    }
    numbers
}

/// Sets output elements without assignment to 0, except those of inputs.
fn set_zeros(function: &mut Function) {
    let mut is_set = vec![false; function.output_len()];
    for assignment in &function.assignments {
        is_set[assignment.output.index()] = true;
    }
    let zero = function.constant(0.0);
    let mut added = Vec::new();
    for array in function.outputs() {
        if function
            .inputs()
            .iter()
            .any(|input| input.name == array.name)
        {
            continue;
        }
        let first = array.offset as usize;
        let left = (first..first + array.shape.len()).filter(|&output| !is_set[output]);
        added.extend(left.map(|output| Assignment {
            output: Output(output as u32),
            operand: zero.into(),
            sources: SourceSet::EMPTY,
        }));
    }
    function.assignments.extend(added);
    function.sort_assignments();
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::OperandKind;
    use robovec_ir::parse::parse_module;

    #[test]
    fn zeros_are_set_where_nothing_else_is() {
        let text = "function dirdyna equations {\n  in q[1..2]\n  out M[1..2,1..2]\n  out c[1..2]\n\n  \
                    M[1,2] = q[1]\n  c[2] = q[2]\n}\n";
        let mut module = parse_module("test", text).expect("a well-formed module");
        set_zeros(&mut module.functions[0]);
        let function = &module.functions[0];
        assert_eq!(function.assignments.len(), 6);
        let zeros = function
            .assignments
            .iter()
            .filter(|assignment| matches!(assignment.operand.kind(), OperandKind::Constant(_)));
        assert_eq!(zeros.count(), 4);
    }

    #[test]
    fn what_has_calls_is_written_in_one_piece() {
        let text = "function link equations {\n  in F1\n  out Z1\n  \
                    call \"user_LinkForces\"(\"Z1\") -> \"F1\"\n\n  Z1 = 1.0\n}\n\n\
                    function invdyna equations {\n  in q[1..2]\n  out Qq[1..2]\n\n  Qq[1] = q[1]\n}\n";
        let module = parse_module("test", text).expect("a well-formed module");
        let options = DropInOptions {
            test_main: true,
            ..DropInOptions::default()
        };
        let files = drop_in(&module, &options).expect("it can be written");
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            [
                "mbs_invdyna_model.c",
                "mbs_invdyna_model.h",
                "mbs_invdyna_model_test.c",
                "mbs_link_model.c",
                "mbs_link_model.h",
                "mbs_data.h"
            ]
        );
    }
}
