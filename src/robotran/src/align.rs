//! Two functions made comparable: the same arrays in both.
//!
//! Generators differ in their declarations of arrays: one lists only the
//! columns it uses, one leaves out elements that are zero, which the caller has
//! cleared. The union of both signatures lets the two be compared as functions.

use robovec_ir::{
    Array, Function, Input, Operand, OperandKind, Output, Shape, SourceSet, Symbol, Tables, Value,
    places_by_name,
};

/// A name and an extent.
type ArrayExtent = Vec<(String, Shape)>;

/// Both functions with the union of their arrays. An output element that only
/// one of them sets has the caller's value in the other: the input element of
/// its name (`frc`), else zero. Equal calls of a user function are one.
pub fn align(
    (before, before_tables): (&Function, &mut Tables),
    (after, after_tables): (&Function, &mut Tables),
) -> (Function, Function) {
    let inputs = union(
        &signature(before_tables, before.inputs()),
        &signature(after_tables, after.inputs()),
    );
    let outputs = union(
        &signature(before_tables, before.outputs()),
        &signature(after_tables, after.outputs()),
    );
    let mut one = rebuild(before, before_tables, &inputs, &outputs);
    let mut other = rebuild(after, after_tables, &inputs, &outputs);
    merge_calls(before, before_tables, &mut one);
    merge_calls(after, after_tables, &mut other);
    let set: Vec<Output> = one
        .assignments
        .iter()
        .chain(&other.assignments)
        .map(|assignment| assignment.output)
        .collect();
    clear(&mut one, &set);
    clear(&mut other, &set);
    assert_eq!(
        one.assignments.len(),
        other.assignments.len(),
        "both set the same elements"
    );
    (one, other)
}

fn signature(tables: &Tables, arrays: &[Array]) -> ArrayExtent {
    arrays
        .iter()
        .map(|array| (tables.symbols.text(array.name).to_owned(), array.shape))
        .collect()
}

/// Every name once, sorted, with the larger extents.
fn union(one: &ArrayExtent, other: &ArrayExtent) -> ArrayExtent {
    let mut union: ArrayExtent = one.iter().chain(other).cloned().collect();
    union.sort_by(|a, b| a.0.cmp(&b.0));
    union.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 = larger(kept.1, next.1);
        }
        same
    });
    union
}

fn larger(one: Shape, other: Shape) -> Shape {
    let extents = |shape: Shape| match shape {
        Shape::Scalar => (0, 0),
        Shape::Vector(rows) => (rows, 0),
        Shape::Matrix(rows, columns) => (rows, columns),
    };
    let (a, b) = (extents(one), extents(other));
    match (a.0.max(b.0), a.1.max(b.1)) {
        (0, _) => Shape::Scalar,
        (rows, 0) => Shape::Vector(rows),
        (rows, columns) => Shape::Matrix(rows, columns),
    }
}

/// The function with other arrays, each of which contains one of its arrays.
fn rebuild(
    function: &Function,
    tables: &mut Tables,
    inputs: &ArrayExtent,
    outputs: &ArrayExtent,
) -> Function {
    let mut declare = |signature: &ArrayExtent| -> Vec<(Symbol, Shape)> {
        let named = signature.iter();
        named
            .map(|(name, shape)| (tables.symbols.intern(name), *shape))
            .collect()
    };
    let new = Function::new(&function.name, function.level)
        .with_arrays(declare(inputs), declare(outputs));
    let inputs = places_by_name(function.inputs(), new.inputs());
    let outputs = places_by_name(function.outputs(), new.outputs());
    let covered = "the union contains every element of both functions";
    let mut rebuilt = function.moved_into(
        new,
        |input| Input(inputs[input.index()].expect(covered)),
        |output| Some(Output(outputs[output.index()].expect(covered))),
    );
    rebuilt.formats = function.formats.clone();
    rebuilt
}

/// Sets unset outputs.
fn clear(function: &mut Function, outputs: &[Output]) {
    let mut set = vec![false; function.output_len()];
    for assignment in &function.assignments {
        set[assignment.output.index()] = true;
    }
    for &output in outputs {
        if !std::mem::replace(&mut set[output.index()], true) {
            let (array, indices, rank) = function.output_element(output);
            let name = array.name;
            let given = function.inputs().iter().find(|input| input.name == name);
            let given = given.and_then(|input| {
                let offset = input.shape.offset(&indices[..rank])?;
                Some(Operand::from(Input(input.offset + offset)))
            });
            let operand = match given {
                Some(operand) => operand,
                None => function.constant(0.0).into(),
            };
            function.assign(output, operand, SourceSet::EMPTY);
        }
    }
    function.sort_assignments();
}

/// Generator 6.6 calls the law of a link again wherever its force is used
/// once; the results of equal calls are equal.
fn merge_calls(original: &Function, tables: &Tables, function: &mut Function) {
    let calls = &original.boundaries;
    let first_of = |name: &str| {
        let call = calls
            .iter()
            .find(|call| call.result.as_deref() == Some(name))?;
        let mut equal = calls
            .iter()
            .filter(|other| other.callee == call.callee && other.arguments == call.arguments);
        equal.find_map(|other| other.result.as_deref())
    };
    let places: Vec<Option<Operand>> = (0..function.input_len() as u32)
        .map(|input| {
            let (array, ..) = function.input_element(Input(input));
            let first = first_of(tables.symbols.text(array.name))?;
            let mut arrays = function.inputs().iter();
            let target = arrays.find(|other| tables.symbols.text(other.name) == first)?;
            let within = input - array.offset;
            let there = (within as usize) < target.shape.len();
            there.then(|| Input(target.offset + within).into())
        })
        .collect();
    replace(function, |input| places[input.index()]);
}

/// Replaces inputs wherever they are used.
pub fn replace(function: &mut Function, by: impl Fn(Input) -> Option<Operand>) {
    let replaced = |operand: Operand| match operand.kind() {
        OperandKind::Input(input) => by(input).unwrap_or(operand),
        _ => operand,
    };
    for index in 0..function.nodes().len() {
        let node = function.node_mut(Value(index as u32));
        node.operands = node.operands.map(replaced);
    }
    for assignment in &mut function.assignments {
        assignment.operand = replaced(assignment.operand);
    }
}
