//! Rules in numbers of 2,000 bits.

use crate::referee::{Leniency, Opinion, Referee, compare};
use crate::rewriting::instance;
use robovec_ir::{Function, Input, Level, Operand, Output, Shape, SourceSet, Tables};
use robovec_num::random::Random;
use robovec_rules::{PatternNode, Rule};

const BITS: usize = 2_048;

/// Places at which a rule is tried before it counts as true.
const PLACES: usize = 24;

/// One of the places at which rules are tried.
fn place(rule: &Rule, number: usize) -> Vec<f64> {
    let mut random = Random::new(number as u64 + 1);
    let mut next = |limit: u64| random.bits() % limit;
    let nodes = rule.left.nodes.iter().chain(&rule.right.nodes);
    let numbers: Vec<f64> = nodes
        .filter_map(|node| match *node {
            PatternNode::Number(number) if number.abs() > 1e-200 && number.abs() < 1e200 => {
                Some(number)
            }
            _ => None,
        })
        .collect();
    let mut draw = || match next(6) {
        0 => next(9) as f64 - 4.0,
        1 => next(4001) as f64 / 8.0 - 250.0,
        2 if !numbers.is_empty() => numbers[next(numbers.len() as u64) as usize],
        3 if !numbers.is_empty() => {
            let near = numbers[next(numbers.len() as u64) as usize];
            near * (1.0 + (next(2001) as f64 - 1000.0) / 1024.0)
        }
        _ => (next(2_000_001) as f64 - 1e6) / 65536.0,
    };
    (0..rule.variables.len() as u32)
        .map(|variable| {
            let value: f64 = draw();
            let holds = rule
                .requirements(variable)
                .all(|needed| needed.holds_for(value));
            if holds { value } else { value.abs() + 1.5 }
        })
        .collect()
}

/// True when numbers show that a rule is false.
pub(super) fn is_false(rule: &Rule) -> bool {
    let sides = sides(rule);
    let mut referee = Referee::new(BITS);
    (0..PLACES).any(|number| {
        let values = referee.evaluate(&sides, &place(rule, number), Leniency::default());
        let opinion = compare(&values[0], &values[1]);
        matches!(opinion, Opinion::Different | Opinion::Lost)
    })
}

/// A function of the variables of a rule whose outputs are its two sides.
fn sides(rule: &Rule) -> Function {
    let symbols = &mut Tables::default().symbols;
    let mut function = Function::new("rule", Level::Equations);
    let count = rule.variables.len() as u32;
    function.add_input(symbols.intern("x"), Shape::Vector(count));
    function.add_output(symbols.intern("y"), Shape::Vector(2));
    let variables: Vec<Operand> = (0..count).map(|index| Input(index).into()).collect();
    for (output, side) in (0..).zip([&rule.left, &rule.right]) {
        let root = instance(side, &variables, &mut function);
        function.assign(Output(output), root, SourceSet::EMPTY);
    }
    function
}
