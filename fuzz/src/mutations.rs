//! Mutations that show only where a check looks for them: at constants that
//! vanish modulo a prime or round away, at the signs of roots, at poles, and
//! in the formats of single values.

use arbitrary::{Result, Unstructured};
use robovec_ir::evaluate::evaluate_mixed_nodes;
use robovec_ir::{
    Format, Function, Name, Node, Operand, OperandKind, Operation, SourceSet, Tables, Value,
    ValueFormats,
};

/// Factors that are one, or next to it, where arithmetic is done modulo a
/// number of 61 bits or in a narrow format.
const FACTORS: [f64; 8] = [
    2_305_843_009_213_693_952.0,
    1.0 / 2_305_843_009_213_693_952.0,
    2_305_843_009_213_693_952.0 * 2_305_843_009_213_693_952.0,
    4_611_686_018_427_387_904.0,
    -1.0,
    1.0 + f64::EPSILON,
    1.0 + 1e-12,
    0.999_999,
];

/// The function with one output replaced by a value that a careless rewrite
/// would confuse with it; `None` where no output is a value.
pub(crate) fn mutate(
    bytes: &mut Unstructured<'_>,
    original: &Function,
    tables: &mut Tables,
) -> Result<Option<Function>> {
    let values: Vec<usize> = (0..original.assignments.len())
        .filter(|&place| original.assignments[place].operand.value().is_some())
        .collect();
    if values.is_empty() {
        return Ok(None);
    }
    let place = *bytes.choose(&values)?;
    let value = original.assignments[place].operand;
    let mut mutated = original.clone();
    let base = tables.symbols.intern("mutant");
    let mut names = 0;
    let mut push = |function: &mut Function, operation, operands: [Operand; 2]| -> Operand {
        names += 1;
        let value = function.push(Node {
            name: Name {
                base,
                suffix: names,
            },
            sources: SourceSet::EMPTY,
            operands: Operand::list(operands),
            operation,
        });
        value.into()
    };
    let replaced = match bytes.int_in_range(0..=3)? {
        // The sign of a root.
        0 => {
            let square = push(&mut mutated, Operation::Mul, [value, value]);
            push(&mut mutated, Operation::Sqrt, [square, Operand::NONE])
        }
        // A pole where there was none, at a whole number or beside it.
        1 => {
            let pole = *bytes.choose(&[0.0, 1.0, -1.0, 0.5])?;
            let pole = mutated.constant(pole).into();
            let distance = push(&mut mutated, Operation::Sub, [value, pole]);
            let product = push(&mut mutated, Operation::Mul, [value, distance]);
            push(&mut mutated, Operation::Div, [product, distance])
        }
        _ => {
            let factor = mutated.constant(*bytes.choose(&FACTORS)?).into();
            push(&mut mutated, Operation::Mul, [value, factor])
        }
    };
    mutated.assignments[place].operand = replaced;
    Ok(Some(mutated))
}

/// Two versions of a function that differ in the format of one value.
pub(crate) fn formats(bytes: &mut Unstructured<'_>, original: &Function) -> Result<[Function; 2]> {
    let narrow: [Format; 3] = ["f16", "bf16", "f32"].map(|name| name.parse().expect("a format"));
    let count = original.nodes().len();
    let mut formats = ValueFormats::new(count);
    for value in 0..count as u32 {
        if bytes.ratio(1, 4)? {
            formats.set(Value(value), Some(*bytes.choose(&narrow)?));
        }
    }
    let mut before = original.clone();
    let mut after = original.clone();
    before.formats = Some(formats.clone());
    let changed = Value(bytes.int_in_range(0..=count as u32 - 1)?);
    let others = [None, Some(narrow[0]), Some(narrow[1]), Some(narrow[2])];
    formats.set(changed, *bytes.choose(&others)?);
    after.formats = Some(formats);
    Ok([before, after])
}

/// The outputs in the formats of their values; `None` where an intermediate
/// value is not finite.
pub(crate) fn outputs(function: &Function, format: Format, inputs: &[f64]) -> Vec<Option<f64>> {
    let values = evaluate_mixed_nodes(function, format, inputs);
    let whole = values.iter().all(|value| value.is_finite());
    let assignments = function.assignments.iter();
    assignments
        .map(|assignment| match assignment.operand.kind() {
            OperandKind::Value(value) => Some(values[value.index()]).filter(|_| whole),
            _ => None,
        })
        .collect()
}
