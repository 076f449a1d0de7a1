//! A pass that applies every rule unchecked, to show the effect of a false
//! rule.

#![allow(unreachable_pub, reason = "the macro declares public passes")]

use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError, PassInfo};
use robovec_framework::rewrite::{Rewriter, owners};
use robovec_ir::{FreshNames, Function, Node, Operand, Operation, Symbol, Tables};
use robovec_rules::{Pattern, PatternNode, Rule};

declare_pass! {
    /// Applies the rules unchecked wherever they match, the first match first.
    pub struct Believe("believe") {}
    takes: [Atomic],
    gives: Gives::Same,
    class: Real,
    destroys: [Timed, ZeroFree, Shared, Live],
}

/// The entry that the registry has not.
pub static BELIEVE: PassInfo = Believe::INFO;

impl Pass for Believe {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let rules = context.rules.directed();
        let owners = owners(context.tables, function);
        let mut rewriter = Rewriter::new(function, function.level);
        let mut names = function.fresh_names();
        for (value, node) in function.values() {
            let found = rules.iter().find_map(|rule| {
                let bound = fits(&rule.left, function, value.into(), rule.variables.len())?;
                context
                    .allow_rewrite(node.name, &rule.name)
                    .then_some((rule, bound))
            });
            let Some((rule, bound)) = found else {
                let operands = rewriter.translate_operands(node);
                rewriter.keep(Node { operands, ..*node });
                continue;
            };
            let origin = (node, owners[value.index()]);
            let operand = write(rule, &bound, &mut rewriter, &mut names, origin);
            rewriter.record(operand);
        }
        *function = rewriter.finish();
        Ok(())
    }
}

/// Operands in the place of the variables where a pattern fits.
fn fits(
    pattern: &Pattern,
    function: &Function,
    root: Operand,
    variables: usize,
) -> Option<Vec<Operand>> {
    let mut bound: Vec<Option<Operand>> = vec![None; variables];
    let mut open = vec![(pattern.root() as u32, root)];
    while let Some((place, operand)) = open.pop() {
        match pattern.nodes[place as usize] {
            PatternNode::Variable(variable) => {
                let known = bound[variable as usize].get_or_insert(operand);
                if *known != operand {
                    return None;
                }
            }
            PatternNode::Number(number) => {
                if function.number(operand) != Some(number) {
                    return None;
                }
            }
            PatternNode::Operation(operation, [a, b]) => {
                let node = function.node(operand.value()?);
                let [x, y, _] = node.operands;
                let minus = node.operation == Operation::Sub && function.number(x) == Some(0.0);
                match operation {
                    Operation::Neg if minus => open.push((a, y)),
                    _ if operation != node.operation => return None,
                    _ if operation.arity() == 1 => open.push((a, x)),
                    _ => open.extend([(a, x), (b, y)]),
                }
            }
        }
    }
    // Variables of the rule that only the right side has do not occur.
    Some(
        bound
            .into_iter()
            .map(|operand| operand.unwrap_or(Operand::NONE))
            .collect(),
    )
}

/// Writes the right side.
fn write(
    rule: &Rule,
    bound: &[Operand],
    rewriter: &mut Rewriter<'_>,
    names: &mut FreshNames,
    (node, owner): (&Node, Symbol),
) -> Operand {
    let mut written: Vec<Operand> = Vec::new();
    for (place, step) in rule.right.nodes.iter().enumerate() {
        let operand = match *step {
            PatternNode::Variable(variable) => rewriter.translate(bound[variable as usize]),
            PatternNode::Number(number) => rewriter.new.constant(number).into(),
            PatternNode::Operation(operation, [a, b]) => {
                let [a, b] = [a, b].map(|place| written[place as usize]);
                let (operation, operands) = match operation {
                    Operation::Neg => {
                        let zero = Operand::from(rewriter.new.constant(0.0));
                        (Operation::Sub, [zero, a, Operand::NONE])
                    }
                    other if other.arity() == 1 => (other, [a, Operand::NONE, Operand::NONE]),
                    other => (other, [a, b, Operand::NONE]),
                };
                let last = place == rule.right.root();
                let value = rewriter.new.push(Node {
                    name: if last { node.name } else { names.fresh(owner) },
                    sources: node.sources,
                    operands,
                    operation,
                });
                value.into()
            }
        };
        written.push(operand);
    }
    written.last().copied().unwrap_or(Operand::NONE)
}

/// The left side of a rule as an equation of a function at the equations
/// level; the root, without a name.
pub(crate) fn instance(pattern: &Pattern, bound: &[Operand], function: &mut Function) -> Operand {
    let mut written: Vec<Operand> = Vec::new();
    for step in &pattern.nodes {
        let operand = match *step {
            PatternNode::Variable(variable) => bound[variable as usize],
            PatternNode::Number(number) => function.constant(number).into(),
            PatternNode::Operation(operation, [a, b]) => {
                let second = match operation.arity() {
                    1 => Operand::NONE,
                    _ => written[b as usize],
                };
                let value = function.push(Node {
                    name: robovec_ir::Name::NONE,
                    sources: robovec_ir::SourceSet::EMPTY,
                    operands: [written[a as usize], second, Operand::NONE],
                    operation,
                });
                value.into()
            }
        };
        written.push(operand);
    }
    written.last().copied().unwrap_or(Operand::NONE)
}

/// A fresh plain name, for an equation.
pub(crate) fn plain(text: &str, tables: &mut Tables) -> robovec_ir::Name {
    robovec_ir::Name::plain(tables.symbols.intern(text))
}
