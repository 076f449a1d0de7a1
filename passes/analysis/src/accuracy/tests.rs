//! Measures on functions whose errors are known.

use super::*;
use robovec_ir::{Function, Input, Level, Name, Node, Operand, Operation, SourceSet, Tables};

/// Inputs `x[1..2]`, outputs `y[1..length]` and the scalars `z` and `w`.
fn function(tables: &mut Tables, length: u32) -> Function {
    let mut function = Function::new("sample", Level::Atomic);
    function.add_input(tables.symbols.intern("x"), Shape::Vector(2));
    function.add_output(tables.symbols.intern("y"), Shape::Vector(length));
    function.add_output(tables.symbols.intern("z"), Shape::Scalar);
    function.add_output(tables.symbols.intern("w"), Shape::Scalar);
    function
}

fn push(function: &mut Function, operation: Operation, a: Operand, b: Operand) -> Operand {
    let node = Node {
        name: Name::NONE,
        sources: SourceSet::EMPTY,
        operands: Operand::list([a, b]),
        operation,
    };
    function.push(node).into()
}

fn assign(function: &mut Function, operand: Operand) {
    function.assign(
        Output(function.assignments.len() as u32),
        operand,
        SourceSet::EMPTY,
    );
}

fn measured(view: View<'_>, count: u32) -> Accuracy {
    let formats = [Format::BINARY32, Format::BINARY64];
    let measurement = Measurement::default();
    measure(view, &States::new(3), count, &formats, measurement)
}

#[test]
fn one_rounding_costs_at_most_half_an_ulp_and_a_copy_nothing() {
    let mut tables = Tables::default();
    let mut function = function(&mut tables, 2);
    let (a, b) = (Operand::from(Input(0)), Operand::from(Input(1)));
    let product = push(&mut function, Operation::Mul, a, b);
    assign(&mut function, product);
    assign(&mut function, a);
    let view = tables.view(&function);
    let accuracy = measured(view, 40);
    let narrow = &accuracy.formats[0];
    let product = narrow.elements[0];
    assert!(product.ulps.worst <= 0.5 && product.ulps.worst > 0.4);
    assert!(product.ulps.median > 0.1 && product.ulps.median < 0.4);
    assert!(product.relative.worst <= 2f64.powi(-24));
    assert_eq!(narrow.elements[1].relative.worst, 0.0);
    // Products of two binary32 numbers are exact in binary64.
    assert_eq!(accuracy.formats[1].elements[0].ulps.worst, 0.0);
    assert_eq!(narrow.summary().worst_output, Some(Output(0)));
    assert!(narrow.arrays[0].normwise.worst <= 2f64.powi(-24));
}

#[test]
fn cancellation_overflow_and_undefined_values_show() {
    let mut tables = Tables::default();
    let mut function = function(&mut tables, 1);
    let (a, b) = (Operand::from(Input(0)), Operand::from(Input(1)));
    let large = Operand::from(function.constant(1e30));
    let zero = Operand::from(function.constant(0.0));
    let sum = push(&mut function, Operation::Add, a, large);
    let difference = push(&mut function, Operation::Sub, sum, large);
    assign(&mut function, difference);
    let square = push(&mut function, Operation::Mul, large, large);
    assign(&mut function, square);
    let undefined = push(&mut function, Operation::Div, b, zero);
    assign(&mut function, undefined);
    let view = tables.view(&function);
    let accuracy = measured(view, 5);
    let errors = |format: &FormatAccuracy| {
        let worst = |index: usize| format.elements[index].relative.worst;
        (worst(0), worst(1), worst(2))
    };
    let (cancelled, overflown, undefined) = errors(&accuracy.formats[0]);
    assert!(cancelled >= 1.0 && overflown == f64::INFINITY && undefined.is_nan());
    let (cancelled, square, undefined) = errors(&accuracy.formats[1]);
    assert!(cancelled == 1.0 && square < 1e-15 && undefined.is_nan());
    assert_eq!(
        accuracy.formats[1].summary().worst_output,
        Some(Output(0)),
        "an undefined output is not the worst"
    );
}

#[test]
fn an_element_that_vanishes_has_no_relative_error() {
    let mut tables = Tables::default();
    let mut function = function(&mut tables, 2);
    let (a, b) = (Operand::from(Input(0)), Operand::from(Input(1)));
    // (a*b)/b - a is zero, but neither binary32 nor double-double know.
    let third = Operand::from(function.constant(3.0));
    let thirds = push(&mut function, Operation::Div, a, third);
    let product = push(&mut function, Operation::Mul, thirds, b);
    let quotient = push(&mut function, Operation::Div, product, b);
    let nothing = push(&mut function, Operation::Sub, quotient, thirds);
    assign(&mut function, nothing);
    assign(&mut function, a);
    let view = tables.view(&function);
    let accuracy = measured(view, 40).formats[0].clone();
    let element = accuracy.elements[0];
    assert!(element.vanishing > 0 && element.vanishing < 40);
    assert!(element.mixed.worst.is_nan());
    assert!(
        element.relative.worst.is_nan(),
        "that it is computed as zero in the other states is luck"
    );
    assert!(element.absolute.worst > 0.0);
    assert!(accuracy.arrays[0].normwise.worst > 1e-9);
    assert_eq!(accuracy.elements[1].vanishing, 0);
}

#[test]
fn what_cancels_has_a_small_mixed_error_and_a_large_condition() {
    let mut tables = Tables::default();
    let mut function = function(&mut tables, 1);
    let (a, b) = (Operand::from(Input(0)), Operand::from(Input(1)));
    // a*b - (a*b rounded to few bits by a large number) is a rest of a
    // part in 2^12, and the product's rounding is all of its error.
    let large = Operand::from(function.constant(3.0 * 2f64.powi(38)));
    let product = push(&mut function, Operation::Mul, a, b);
    let near = push(&mut function, Operation::Add, product, a);
    let far = push(&mut function, Operation::Mul, near, b);
    let back = push(&mut function, Operation::Mul, product, b);
    let other = push(&mut function, Operation::Mul, a, b);
    let difference = push(&mut function, Operation::Sub, far, back);
    let rest = push(&mut function, Operation::Sub, difference, other);
    let sum = push(&mut function, Operation::Add, rest, a);
    assign(&mut function, sum);
    let raised = push(&mut function, Operation::Add, a, large);
    let lowered = push(&mut function, Operation::Sub, raised, large);
    assign(&mut function, lowered);
    let view = tables.view(&function);
    let measurement = Measurement {
        effort: ReferenceEffort::Certified,
        sensitivities: true,
        condition_work: 1 << 20,
    };
    let formats = [Format::BINARY32, "float(8,12)".parse().expect("it is one")];
    let accuracy = measure(view, &States::new(3), 40, &formats, measurement);
    assert_eq!(accuracy.certainty.uncertain, 0);
    let narrow = &accuracy.formats[0];
    // The second output is `a` but for rounding: of condition one, and
    // all of its error is the code's.
    let conditioned = narrow.elements[1].conditioned.expect("it was asked for");
    assert!((conditioned.condition - 1.0).abs() < 1e-12);
    assert_eq!(conditioned.judgement, Judgement::UnstableCode);
    assert!(narrow.elements[1].relative.worst >= 1.0);
    let spread = narrow.elements[0].mixed;
    assert!(spread.worst <= narrow.elements[0].relative.worst);
    assert!((narrow.elements[0].sensitivity - 1.0).abs() < 0.1);
    // Every format is measured with its own rounding.
    let ratio = accuracy.formats[1].elements[0].relative.worst / narrow.elements[0].relative.worst;
    assert!((200.0..20_000.0).contains(&ratio), "{ratio}");
    assert_eq!(accuracy.formats[1].elements[0].subnormal, 0);
}

#[test]
fn numbers_at_the_ends_of_the_range_are_counted() {
    let mut tables = Tables::default();
    let mut function = function(&mut tables, 1);
    let a = Operand::from(Input(0));
    let tiny = Operand::from(function.constant(1e-40));
    let huge = Operand::from(function.constant(1e39));
    let small = push(&mut function, Operation::Mul, a, tiny);
    assign(&mut function, small);
    let large = push(&mut function, Operation::Mul, a, huge);
    assign(&mut function, large);
    let view = tables.view(&function);
    let accuracy = measured(view, 10);
    let [narrow, wide] = [0, 1].map(|index| &accuracy.formats[index]);
    assert_eq!(narrow.elements[0].subnormal, 10);
    assert_eq!(narrow.elements[1].overflowed, 10);
    assert_eq!((narrow.subnormal, narrow.overflowed), (0.5, 0.5));
    assert_eq!((wide.subnormal, wide.overflowed), (0.0, 0.0));
}

#[test]
fn symmetric_matrices_have_their_condition_number() {
    let text = "function f equations {
      in x[1..2]
      out M[1..2,1..2]
      M[1,1] = 2
      M[2,1] = 1
      M[2,2] = 2
    }";
    let module = robovec_ir::parse::parse_module("f", text).expect("it is sound");
    let view = module.tables.view(&module.functions[0]);
    let measurement = Measurement {
        condition_work: 1000,
        ..Measurement::default()
    };
    let accuracy = measure(view, &States::new(1), 3, &[Format::BINARY32], measurement);
    let [matrix] = accuracy.matrices[..] else {
        panic!("there is one matrix");
    };
    assert!((matrix.condition.median - 3.0).abs() < 1e-9);
}
