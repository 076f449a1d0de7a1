//! Outputs of few operations, given to the prover of rules.
//!
//! An output before and after is a rule: its left side may become its right
//! side where the left side is defined. The prover follows factors and signs
//! further than the check of whole functions, and finds points next to zeros.

use super::failure::{Failed, Values};
use super::pairing::Pairs;
use super::states::{StatePlace, StateScale};
use robovec_ir::print::print_operand;
use robovec_ir::states::States;
use robovec_ir::{Function, Input, Operand, OperandKind, Operation};
use robovec_rules::check::{RuleVerdict, decide};
use robovec_rules::{Pattern, PatternNode, Rule};

/// The finding about one output.
pub(super) enum SmallVerdict {
    /// Defined at the same points as before.
    Proved,
    /// Inputs at which there is a number before, and after none or another.
    Refuted(Failed),
    /// Neither, or too large.
    Open,
}

/// Terms of a side as text: shared ones are written out every time.
const MAX_TERMS: u64 = 400;

/// Proves or refutes that the output of a pair is defined where it was before.
pub(super) fn decided(pairs: &Pairs<'_>, pair: usize, states: &States) -> SmallVerdict {
    let count = pairs.before.function.input_len() as u32;
    let variables = |first: u32| (first..first + count).map(PatternNode::Variable).collect();
    let leaves = pairs.both(variables(0), PatternNode::Number, |instance| {
        variables(count * instance)
    });
    let sides = [
        (pairs.before.function, pairs.list[pair].before),
        (pairs.after.function, pairs.list[pair].after),
    ];
    let [Some(left), Some(right)] = [0, 1].map(|version| {
        let (function, assignment) = sides[version];
        pattern(
            function,
            function.assignments[assignment].operand,
            &leaves[version],
        )
    }) else {
        return SmallVerdict::Open;
    };
    let mut used = left.variables();
    used.extend(right.variables());
    used.sort_unstable();
    used.dedup();
    let number = |variable: u32| {
        used.binary_search(&variable)
            .expect("every variable is used") as u32
    };
    let input = |variable: u32| Input(variable % count);
    let name = |&variable: &u32| print_operand(pairs.before, input(variable).into());
    let names = used.iter().map(name).collect();
    let rule = Rule::new(names, left.renamed(number), right.renamed(number));
    match decide(&rule) {
        RuleVerdict::Proved(_) => SmallVerdict::Proved,
        RuleVerdict::Unproved(_) => SmallVerdict::Open,
        RuleVerdict::False(found) => {
            let mut inputs = vec![0.0; count as usize];
            for (&variable, (_, value)) in used.iter().zip(&found.values) {
                inputs[input(variable).index()] = *value;
            }
            if !within(pairs, states, &inputs) {
                return SmallVerdict::Open;
            }
            SmallVerdict::Refuted(Failed {
                pair,
                values: Values {
                    state: StatePlace {
                        scale: StateScale::Found,
                        number: u32::from(found.near),
                    },
                    before: found.left,
                    after: found.right,
                    allowed: 0.0,
                },
                inputs: Some(inputs),
            })
        }
    }
}

/// True when inputs lie within the ranges of a scene.
fn within(pairs: &Pairs<'_>, states: &States, inputs: &[f64]) -> bool {
    inputs.iter().enumerate().all(|(index, &number)| {
        let (array, indices, _) = pairs.before.function.input_element(Input(index as u32));
        let name = pairs.before.tables.symbols.text(array.name);
        let range = states.ranges().get(name, indices);
        range.is_none_or(|[low, high]| (low..=high).contains(&number))
    })
}

/// An operand with its dependences; `None` when they are too large.
fn pattern(function: &Function, root: Operand, leaves: &[PatternNode]) -> Option<Pattern> {
    let slice = robovec_analysis::slice::slice(function, &[root]);
    if slice.len() > Pattern::LARGEST {
        return None;
    }
    let mut pattern = Pattern::default();
    let mut places: Vec<u32> = Vec::with_capacity(slice.len());
    let mut terms: Vec<u64> = Vec::new();
    let mut push = |pattern: &mut Pattern, node: PatternNode| {
        terms.push(match node {
            PatternNode::Operation(_, [a, b]) => terms[a as usize]
                .saturating_add(terms[b as usize])
                .saturating_add(1),
            PatternNode::Variable(_) | PatternNode::Number(_) => 1,
        });
        (terms[terms.len() - 1] <= MAX_TERMS).then(|| pattern.push(node))
    };
    for &value in &slice {
        let node = function.node(value);
        let mut operands = [0; 3];
        for (place, operand) in operands.iter_mut().zip(node.operands()) {
            *place = match leaf(function, *operand, leaves)? {
                Ok(leaf) => push(&mut pattern, leaf)?,
                Err(value) => places[slice.binary_search(&value).expect("a slice is whole")],
            };
        }
        let [a, b, c] = operands;
        let place = match node.operation {
            Operation::Fma | Operation::Fms | Operation::Fnma => {
                let product = push(&mut pattern, PatternNode::Operation(Operation::Mul, [a, b]))?;
                let (operation, operands) = match node.operation {
                    Operation::Fma => (Operation::Add, [product, c]),
                    Operation::Fms => (Operation::Sub, [product, c]),
                    _ => (Operation::Sub, [c, product]),
                };
                push(&mut pattern, PatternNode::Operation(operation, operands))?
            }
            operation if operation.arity() == 1 => {
                push(&mut pattern, PatternNode::Operation(operation, [a, a]))?
            }
            operation => push(&mut pattern, PatternNode::Operation(operation, [a, b]))?,
        };
        places.push(place);
    }
    if slice.is_empty() {
        let leaf = leaf(function, root, leaves)?.ok()?;
        pattern.push(leaf);
    }
    Some(pattern)
}

/// The leaf that an operand is, or the value; `None` for operands that no
/// pattern has.
fn leaf(
    function: &Function,
    operand: Operand,
    leaves: &[PatternNode],
) -> Option<Result<PatternNode, robovec_ir::Value>> {
    match operand.kind() {
        OperandKind::Value(value) => Some(Err(value)),
        OperandKind::Input(input) => Some(Ok(leaves[input.index()])),
        OperandKind::Constant(constant) => {
            let number = function.constant_number(constant);
            number
                .is_finite()
                .then_some(Ok(PatternNode::Number(number)))
        }
        OperandKind::None => None,
    }
}
