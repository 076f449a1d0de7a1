//! The semantic check must catch every planted wrong rewrite.

use crate::generate::{self, Kind};
use crate::mutations;
use crate::referee::{self, BITS, Leniency, Opinion, Referee};
use arbitrary::{Result, Unstructured};
use robovec_analysis::class::NumericClass;
use robovec_framework::check::check;
use robovec_ir::evaluate::evaluate;
use robovec_ir::print::print_function;
use robovec_ir::states::States;
use robovec_ir::{
    Format, Function, Input, Level, Name, Node, Operand, Operation, Output, Shape, SourceSet,
    Tables, Value,
};
use robovec_num::double_double::DoubleDouble;

const INPUTS: u32 = 4;
const STATES: u32 = 3;
/// Points the referee looks at.
const SEEN: u32 = 4;
const CONSTANTS: [f64; 6] = [0.0, 1.0, 2.0, 0.5, -3.0, 0.1];
const OPERATIONS: [Operation; 14] = [
    Operation::Add,
    Operation::Add,
    Operation::Sub,
    Operation::Sub,
    Operation::Mul,
    Operation::Mul,
    Operation::Mul,
    Operation::Neg,
    Operation::Div,
    Operation::Sin,
    Operation::Cos,
    Operation::Sqrt,
    Operation::Fma,
    Operation::Fnma,
];

/// Fate of a planted mutation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mutant {
    /// It changed a number in double-double, and the check detected it.
    Caught,
    /// It changed no number, so it may be an identity.
    Harmless,
}

/// Makes a random function from bytes, changes one operation or operand, a
/// constant by a factor that is one modulo many a number, the sign of a root,
/// a pole or a value's format, and lets the check compare the two. A change
/// that shows at a random state is no identity: the check must catch it. The unchanged
/// function, and one with the operands of sums and products exchanged, must
/// pass.
///
/// # Panics
///
/// Panics when the check lets a wrong rewrite pass or refuses a right one.
pub fn check_catches_mutants(data: &[u8]) {
    // Too few bytes for a function and a mutation are no finding.
    let _ = plant(&mut Unstructured::new(data));
}

/// As [`check_catches_mutants`], and returns the fate of the mutation.
///
/// # Errors
///
/// Fails when the bytes run out.
///
/// # Panics
///
/// As [`check_catches_mutants`].
pub fn plant(bytes: &mut Unstructured<'_>) -> Result<Mutant> {
    let mut tables = Tables::default();
    // Values of every shape in one kind of function, what Robotran writes in
    // the other.
    let original = if bytes.arbitrary()? {
        function(bytes, &mut tables)?
    } else {
        generate::function(bytes, &mut tables, "random", Kind::Tame)?
    };
    if original.nodes().is_empty() {
        return Ok(Mutant::Harmless);
    }
    let hostile = match bytes.int_in_range(0..=3)? {
        0 => mutations::mutate(bytes, &original, &mut tables)?,
        1 => return plant_format(bytes, &tables, &original),
        _ => None,
    };
    let is_hostile = hostile.is_some();
    let mutated = match hostile {
        Some(mutated) => mutated,
        None => mutate(bytes, &original)?,
    };
    let seed = bytes.arbitrary()?;
    let holds = |class, after: &Function| {
        check(
            tables.view(&original),
            tables.view(after),
            class,
            &States::new(seed),
            STATES,
        )
    };
    for class in [NumericClass::Exact, NumericClass::RealTrig] {
        let verdict = holds(class, &commuted(&original));
        assert!(verdict.holds(), "a right rewrite was refused: {verdict}");
    }
    let shows = if is_hostile {
        referee_sees(&tables, [&original, &mutated], seed)
    } else {
        differ(&tables, &original, &mutated, seed)
    };
    if !shows {
        return Ok(Mutant::Harmless);
    }
    for class in [
        NumericClass::Exact,
        NumericClass::Real,
        NumericClass::RealTrig,
    ] {
        assert!(
            !holds(class, &mutated).holds(),
            "a wrong rewrite passed as {class}:\n{}\nbecame\n{}",
            print_function(tables.view(&original)),
            print_function(tables.view(&mutated))
        );
    }
    Ok(Mutant::Caught)
}

/// Changes the format of one value: the check must report this if a bit of a
/// result changes, and must accept the unchanged function.
fn plant_format(
    bytes: &mut Unstructured<'_>,
    tables: &Tables,
    original: &Function,
) -> Result<Mutant> {
    let [before, after] = mutations::formats(bytes, original)?;
    let seed = bytes.arbitrary()?;
    let states = States::new(seed);
    let verdict = |after: &Function| {
        let (before, after) = (tables.view(&before), tables.view(after));
        check(before, after, NumericClass::Exact, &states, STATES)
    };
    let same = verdict(&before);
    assert!(same.holds(), "a function differs from itself: {same}");
    let shows = (0..STATES).all(|state| {
        let inputs = states.draw(tables.view(&before), state);
        [Format::BINARY64, Format::BINARY32]
            .into_iter()
            .all(|format| {
                let before = mutations::outputs(&before, format, &inputs);
                let after = mutations::outputs(&after, format, &inputs);
                let mut pairs = before.iter().zip(&after);
                pairs.any(|(before, after)| before.is_some() && after.is_some() && before != after)
            })
    });
    if !shows {
        return Ok(Mutant::Harmless);
    }
    assert!(
        !verdict(&after).holds(),
        "another format of a value passed:\n{}\nbecame\n{}",
        print_function(tables.view(&before)),
        print_function(tables.view(&after))
    );
    Ok(Mutant::Caught)
}

/// True when an output certainly differs, or is missing, at most of the points
/// of a separate referee.
fn referee_sees(tables: &Tables, [before, after]: [&Function; 2], seed: u64) -> bool {
    let mut referee = Referee::new(BITS[0]);
    let differ = (0..SEEN).filter(|&state| {
        let inputs = States::new(seed).draw(tables.view(before), state);
        let before = referee.evaluate(before, &inputs, Leniency::default());
        let after = referee.evaluate(after, &inputs, Leniency::default());
        let mut pairs = before.iter().zip(&after);
        pairs.any(|(before, after)| {
            let opinion = referee::compare(before, after);
            matches!(opinion, Opinion::Different | Opinion::Lost)
        })
    });
    2 * differ.count() > SEEN as usize
}

/// A random function whose outputs are the values without readers.
fn function(bytes: &mut Unstructured<'_>, tables: &mut Tables) -> Result<Function> {
    let mut function = Function::new("random", Level::Equations);
    function.add_input(tables.symbols.intern("x"), Shape::Vector(INPUTS));
    let base = tables.symbols.intern("v");
    let count: u32 = bytes.int_in_range(1..=40)?;
    for suffix in 0..count {
        let operation = *bytes.choose(&OPERATIONS)?;
        let mut operands = [Operand::NONE; Operand::MAX_COUNT];
        for place in &mut operands[..operation.arity()] {
            *place = operand(bytes, &mut function, suffix)?;
        }
        function.push(Node {
            name: Name { base, suffix },
            sources: SourceSet::EMPTY,
            operands,
            operation,
        });
    }
    let unread: Vec<u32> = function
        .use_counts()
        .iter()
        .zip(0..)
        .filter(|(uses, _)| **uses == 0)
        .map(|(_, value)| value)
        .collect();
    function.add_output(
        tables.symbols.intern("y"),
        Shape::Vector(unread.len() as u32),
    );
    for (output, value) in (0..).zip(unread) {
        function.assign(Output(output), Value(value).into(), SourceSet::EMPTY);
    }
    Ok(function)
}

/// A value before `limit`, most likely, an input or a constant.
fn operand(bytes: &mut Unstructured<'_>, function: &mut Function, limit: u32) -> Result<Operand> {
    let inputs = function.input_len() as u32;
    Ok(match bytes.int_in_range(0..=7)? {
        1 | 2 if inputs > 0 => Input(bytes.int_in_range(0..=inputs - 1)?).into(),
        3.. if limit > 0 => Value(bytes.int_in_range(0..=limit - 1)?).into(),
        _ => function.constant(*bytes.choose(&CONSTANTS)?).into(),
    })
}

/// The function with one operation or operand changed.
pub(crate) fn mutate(bytes: &mut Unstructured<'_>, original: &Function) -> Result<Function> {
    let mut mutated = original.clone();
    let place = bytes.int_in_range(0..=original.nodes().len() as u32 - 1)?;
    let mut node = *original.node(Value(place));
    let arity = node.operation.arity();
    match bytes.int_in_range(0..=2)? {
        0 if arity == 2 => node.operands.swap(0, 1),
        1 => {
            let others = OPERATIONS.iter().copied();
            let same: Vec<Operation> = others
                .filter(|other| other.arity() == arity && *other != node.operation)
                .collect();
            node.operation = *bytes.choose(&same)?;
        }
        _ => {
            let side = bytes.int_in_range(0..=arity - 1)?;
            node.operands[side] = operand(bytes, &mut mutated, place)?;
        }
    }
    *mutated.node_mut(Value(place)) = node;
    Ok(mutated)
}

/// The function with the operands of every sum and product exchanged: the
/// same function, bit by bit.
fn commuted(original: &Function) -> Function {
    let mut commuted = original.clone();
    for index in 0..original.nodes().len() as u32 {
        let node = commuted.node_mut(Value(index));
        if node.operation.is_commutative() {
            node.operands.swap(0, 1);
        }
    }
    commuted
}

/// True when some output certainly differs in double-double.
pub(crate) fn differ(tables: &Tables, original: &Function, mutated: &Function, seed: u64) -> bool {
    (0..STATES).any(|state| {
        let inputs: Vec<_> = States::new(seed)
            .draw(tables.view(original), state)
            .into_iter()
            .map(Into::into)
            .collect();
        let before = evaluate(original, &DoubleDouble, &inputs);
        let after = evaluate(mutated, &DoubleDouble, &inputs);
        before.into_iter().zip(after).any(|(before, after)| {
            let distance = (before - after).high.abs();
            let size = before.high.abs().max(after.high.abs());
            // Outputs of a usual size, so that no cancellation of huge
            // numbers passes for a difference.
            (1e-3..1e6).contains(&size) && distance > 1e-6 * size
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn planted_mutants_are_caught() {
        let tally = [const { AtomicU32::new(0) }; 2];
        cases::on_all_cores(3000, 1024, |bytes| {
            let mutant = plant(bytes)?;
            tally[usize::from(mutant == Mutant::Caught)].fetch_add(1, Ordering::Relaxed);
            Ok(())
        });
        let [harmless, caught] = tally.map(AtomicU32::into_inner);
        assert!(
            caught > 1000,
            "too few mutants: {caught}, {harmless} harmless"
        );
    }
}
