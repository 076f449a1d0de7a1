//! The part of a function that a scene needs: its outputs, and the arrays that
//! are left.

use robovec_framework::rewrite::without_dead;
use robovec_framework::scene::Scene;
use robovec_ir::count::Counts;
use robovec_ir::{Array, Function, Input, Operand, OperandKind, Output, View};

/// The function without the outputs that a scene does not need and the values
/// that only they use, with the numbers of outputs and operations removed. The
/// arguments of calls of the user's functions are needed in any case.
pub(super) fn needed(view: View<'_>, scene: &Scene) -> (Function, [u64; 2]) {
    let function = view.function;
    let symbols = &view.tables.symbols;
    let is_argument = |output: Output| {
        let name = symbols.text(function.output_element(output).0.name);
        let mut calls = function.boundaries.iter();
        calls.any(|call| call.arguments.iter().any(|argument| argument == name))
    };
    let mut sliced = function.clone();
    sliced
        .assignments
        .retain(|set| scene.needs(view, set.output) || is_argument(set.output));
    let outputs = (function.assignments.len() - sliced.assignments.len()) as u64;
    if outputs == 0 {
        return (sliced, [0; 2]);
    }
    let sliced = without_dead(sliced);
    let operations = |function: &Function| Counts::of(function).operations as u64;
    let gone = operations(function) - operations(&sliced);
    (sliced, [outputs, gone])
}

/// For every input element a flag: true when the function reads it.
pub(super) fn read_inputs(function: &Function) -> Vec<bool> {
    let mut read = vec![false; function.input_len()];
    for input in function.reads().filter_map(Operand::input) {
        read[input.index()] = true;
    }
    read
}

/// The arrays of a function without those that nothing of is read or set, and
/// the new places of elements.
pub(crate) struct SliceSignature {
    pub(super) inputs: Vec<Array>,
    pub(super) outputs: Vec<Array>,
    /// For every old input element the new one.
    input_places: Vec<Option<u32>>,
    output_places: Vec<Option<u32>>,
}

impl SliceSignature {
    /// Keeps all arrays of a function.
    pub(crate) fn whole(function: &Function) -> SliceSignature {
        let every = |length: usize| (0..length as u32).map(Some).collect();
        SliceSignature {
            inputs: function.inputs().to_vec(),
            outputs: function.outputs().to_vec(),
            input_places: every(function.input_len()),
            output_places: every(function.output_len()),
        }
    }

    /// Keeps the inputs and outputs of a function, and the arrays of calls of
    /// the user's functions.
    pub(super) fn of(view: View<'_>) -> SliceSignature {
        let function = view.function;
        let read = read_inputs(function);
        let mut given = vec![false; function.output_len()];
        for assignment in &function.assignments {
            given[assignment.output.index()] = true;
        }
        let calls = &function.boundaries;
        let is_result = |name: &str| {
            calls
                .iter()
                .any(|call| call.result.as_deref() == Some(name))
        };
        let is_argument = |name: &str| {
            calls
                .iter()
                .any(|call| call.arguments.iter().any(|argument| argument == name))
        };
        let name = |array: &Array| view.tables.symbols.text(array.name);
        let (inputs, input_places) = kept(function.inputs(), &read, &|a| is_result(name(a)));
        let (outputs, output_places) = kept(function.outputs(), &given, &|a| is_argument(name(a)));
        SliceSignature {
            inputs,
            outputs,
            input_places,
            output_places,
        }
    }

    /// An operand of the old function in the new one.
    pub(super) fn operand(&self, operand: Operand) -> Operand {
        match operand.kind() {
            OperandKind::Input(input) => {
                let place = self.input_places[input.index()];
                Input(place.expect("an input that is read is kept")).into()
            }
            _ => operand,
        }
    }

    /// An output element of the old function in the new one.
    pub(super) fn output(&self, output: Output) -> Output {
        Output(self.output_places[output.index()].expect("an output that is set is kept"))
    }
}

/// The arrays with an element that counts, or that are wanted anyway, and the
/// new place of every element.
fn kept(
    arrays: &[Array],
    counts: &[bool],
    wanted: &dyn Fn(&Array) -> bool,
) -> (Vec<Array>, Vec<Option<u32>>) {
    let mut list = Vec::new();
    let mut places = Vec::with_capacity(counts.len());
    let mut next = 0;
    for array in arrays {
        let (first, length) = (array.offset as usize, array.shape.len());
        let keep = wanted(array) || counts[first..first + length].contains(&true);
        if keep {
            places.extend((next..next + length as u32).map(Some));
            next += length as u32;
            list.push(*array);
        } else {
            places.extend(std::iter::repeat_n(None, length));
        }
    }
    (list, places)
}
