//! Random recurrences are rolled, and proved equal by unrolling; every change
//! of a rolled program is detected.

use super::program::SpaceElement;
use super::*;
use crate::c::{self, TrialState, trial_main};
use crate::testing::compiled_output;
use robovec_ir::{
    Assignment, Input, Level, Module, Name, Node, Operation, Output, Shape, SourceSet, Symbol,
};
use robovec_num::random::Random;

struct Builder {
    function: Function,
    base: Symbol,
    /// One in this number of statements is another than its neighbours; 0 for
    /// none.
    odd: usize,
}

impl Builder {
    fn node(&mut self, operation: Operation, operands: &[Operand]) -> Operand {
        let suffix = self.function.nodes().len() as u32;
        let base = self.base;
        let mut list = [Operand::NONE; Operand::MAX_COUNT];
        list[..operands.len()].copy_from_slice(operands);
        let value = self.function.push(Node {
            name: Name { base, suffix },
            sources: SourceSet::EMPTY,
            operands: list,
            operation,
        });
        value.into()
    }

    fn binary(&mut self, random: &mut Random, operation: Operation, pair: [Operand; 2]) -> Operand {
        let other = self.odd > 0 && random.below(self.odd) == 0;
        self.node(if other { Operation::Div } else { operation }, &pair)
    }
}

const OPERATIONS: [Operation; 3] = [Operation::Add, Operation::Sub, Operation::Mul];

/// A recursion forwards and backwards along a chain, then a triangle of
/// products that is mirrored.
fn recurrences(random: &mut Random, joints: u32, odd: usize) -> Module {
    let mut module = Module::new();
    let symbols = &mut module.tables.symbols;
    let mut function = Function::new("f", Level::Atomic);
    function.add_input(symbols.intern("q"), Shape::Vector(joints));
    function.add_input(symbols.intern("p"), Shape::Matrix(3, joints));
    function.add_output(symbols.intern("M"), Shape::Matrix(joints, joints));
    function.add_output(symbols.intern("c"), Shape::Vector(joints));
    let base = symbols.intern("x");
    let mut builder = Builder {
        function,
        base,
        odd,
    };
    let q = |joint: u32| Operand::from(Input(joint));
    let p = |row: u32, joint: u32| Operand::from(Input(joints + row * joints + joint));
    let number = builder.function.constant(0.25).into();
    let sines: Vec<[Operand; 2]> = (0..joints)
        .map(|joint| {
            [
                builder.node(Operation::Cos, &[q(joint)]),
                builder.node(Operation::Sin, &[q(joint)]),
            ]
        })
        .collect();
    // The body: an operation, and where its operands come from.
    let body: Vec<(Operation, [usize; 2])> = (0..6 + random.below(6))
        .map(|_| {
            let operation = OPERATIONS[random.below(3)];
            (operation, [random.below(30), random.below(30)])
        })
        .collect();
    let mut results: Vec<Vec<Operand>> = Vec::new();
    for sweep in 0..2u32 {
        let mut before: Vec<Operand> = vec![number, p(0, 0), sines[0][1]];
        for step in 0..joints {
            let joint = if sweep == 0 { step } else { joints - 1 - step };
            let mut now: Vec<Operand> = Vec::new();
            for (operation, sources) in &body {
                let pair = sources.map(|source| match source {
                    0..=5 => before[source % before.len()],
                    6..=8 => p(source as u32 % 3, joint),
                    9..=11 => sines[joint as usize][source % 2],
                    12..=14 if sweep == 1 => results[joint as usize][source % body.len()],
                    15 => q(0),
                    16 => number,
                    _ if now.is_empty() => before[0],
                    _ => now[source % now.len()],
                });
                let result = builder.binary(random, *operation, pair);
                now.push(result);
            }
            before.clone_from(&now);
            if sweep == 0 {
                results.push(now);
            } else {
                results[joint as usize].extend(now);
            }
        }
    }
    let width = results[0].len();
    let terms: Vec<[usize; 2]> = (0..2 + random.below(3))
        .map(|_| [random.below(width), random.below(width)])
        .collect();
    let output = |row: u32, column: u32| Output(row * joints + column);
    for row in 0..joints {
        for column in (0..=row).rev() {
            let mut sum: Option<Operand> = None;
            for term in &terms {
                let pair = [
                    results[row as usize][term[0]],
                    results[column as usize][term[1]],
                ];
                let product = builder.binary(random, Operation::Mul, pair);
                sum = Some(match sum {
                    Some(sum) => builder.binary(random, Operation::Add, [sum, product]),
                    None => product,
                });
            }
            let operand = sum.expect("at least two terms");
            let mut elements = vec![output(row, column), output(column, row)];
            elements.dedup();
            for output in elements {
                builder.function.assignments.push(Assignment {
                    output,
                    operand,
                    sources: SourceSet::EMPTY,
                });
            }
        }
        builder.function.assignments.push(Assignment {
            output: Output(joints * joints + row),
            operand: results[row as usize][width - 1],
            sources: SourceSet::EMPTY,
        });
    }
    builder.function.sort_assignments();
    module.functions.push(builder.function);
    module
}

#[test]
fn random_recurrences_are_rolled_and_unroll_to_themselves() {
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let joints = 1 + random.below(24) as u32;
        let odd = [0, 0, 3, 20, 200][random.below(5)];
        let module = recurrences(&mut random, joints, odd);
        let (_, summary) = roll(&module.functions[0]).expect("equal");
        if joints >= 20 && odd == 0 {
            assert!(
                summary.rolled * 2 > summary.operations,
                "{seed}: {summary:?}"
            );
            assert!(
                summary.written * 3 < summary.operations,
                "{seed}: {summary:?}"
            );
        }
    }
}

#[test]
fn changes_of_a_rolled_program_are_noticed() {
    let mut random = Random::new(99);
    let module = recurrences(&mut random, 20, 0);
    let function = &module.functions[0];
    let (program, _) = roll(function).expect("equal");
    let statements = Statements::new(function);
    let differs = |program: &RolledProgram| unroll::unroll(program, function, &statements).is_err();
    assert!(!differs(&program));
    let shift = |place: &mut SpaceElement| place.column.base += 1;
    let mut changed = 0;
    for position in 0..program.codes.len() {
        for leaf in 0..program.codes[position].sources.len() {
            let mut mutant = program.clone();
            if let LeafSource::Place(place) = &mut mutant.codes[position].sources[leaf] {
                shift(place);
                assert!(differs(&mutant), "leaf {leaf} of {position}");
                changed += 1;
            }
        }
        let mut mutant = program.clone();
        if let Some(LeafSource::Position(other)) = mutant.codes[position].sources.first_mut()
            && *other > 0
        {
            *other -= 1;
            assert!(differs(&mutant), "first leaf of {position}");
            changed += 1;
        }
    }
    for number in 0..program.loops.len() {
        let mut mutant = program.clone();
        mutant.loops[number].count.base -= 1;
        assert!(differs(&mutant), "loop {number}");
        changed += 1;
    }
    assert!(changed > 20, "{changed}");
}

#[test]
fn functions_without_statements_are_written_too() {
    let mut module = Module::new();
    let symbols = &mut module.tables.symbols;
    let mut function = Function::new("empty", Level::Equations);
    function.add_input(symbols.intern("q"), Shape::Vector(3));
    function.add_output(symbols.intern("c"), Shape::Vector(3));
    module.functions.push(function);
    let view = View {
        tables: &module.tables,
        function: &module.functions[0],
    };
    let rolled = rolled_files(view, Options::default()).expect("equal");
    assert_eq!((rolled.summary.operations, rolled.summary.loops), (0, 0));
    assert!(
        rolled.files[0]
            .1
            .contains("void empty(const double *q, double *c)")
    );
}

/// Compiled without contraction, rolled C gives the evaluator's bits.
#[test]
fn compiled_loops_give_the_bits_of_the_evaluator() {
    let mut random = Random::new(7);
    let joints = 17u32;
    let module = recurrences(&mut random, joints, 40);
    let function = &module.functions[0];
    let view = View {
        tables: &module.tables,
        function,
    };
    let options = Options {
        circular: RolledCircular::Library,
        ..Options::default()
    };
    let rolled = rolled_files(view, options).expect("equal");
    let inputs: Vec<f64> = (0..4 * joints)
        .map(|_| random.below(1000) as f64 / 1000.0 + 0.25)
        .collect();
    let trial = TrialState::new(view, inputs, 0.0);
    let main = trial_main(view, &c::Options::plain(Real::Double), &["f"], &trial);
    let mut files = rolled.files.to_vec();
    files.push(("main.c".to_owned(), main));
    for level in ["-O0", "-O3"] {
        let flags = [level, "-ffp-contract=off", "-fno-builtin"];
        // It fails: what is not finite is infinitely far from itself.
        let Some((text, _)) = compiled_output(&files, &flags, &["print"]) else {
            return;
        };
        let mut finite = 0;
        for (line, &expected) in text.lines().zip(&trial.expected) {
            if expected.is_finite() {
                finite += 1;
                let found = line.split(' ').nth(2).expect("name, element and number");
                let found: f64 = found.parse().expect("a number");
                assert_eq!(found.to_bits(), expected.to_bits(), "{level}: {line}");
            }
        }
        assert!(finite > 100, "{finite}");
    }
}
