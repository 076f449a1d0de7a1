//! From equations to single operations (thesis 2.1, equation 2.2).

use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::{Rewriter, owners};
use robovec_ir::{Function, Level, Node, Operand, Operation};

declare_pass! {
    /// Splits every equation into operations on two operands, left to right.
    ///
    /// The tree is the one the equation is written as: sums and products
    /// associate to the left, parentheses are kept. A minus becomes `0 - x`,
    /// which an adder can compute; `zero-removal` removes nearly all of them.
    /// Copies disappear into their users. An inner operation is named after its
    /// equation (`CF323.1`, `CF323.2` …), an operation made for an output after
    /// the output's element (`c_6`).
    pub struct Atomise("atomise") {}
    takes: [Equations, Atomic],
    gives: Gives::Level(Level::Atomic),
    class: Exact,
    destroys: [Timed, ZeroFree],
}

impl Pass for Atomise {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        if function.level == Level::Atomic {
            return Ok(());
        }
        let owners = owners(context.tables, function);
        let mut names = function.fresh_names();
        let mut rewriter = Rewriter::new(function, Level::Atomic);
        let mut minuses = 0;
        for (value, node) in function.values() {
            let mut operands = rewriter.translate_operands(node);
            let operation = match node.operation {
                Operation::Copy => {
                    rewriter.record(operands[0]);
                    continue;
                }
                Operation::Neg => {
                    if let Some(number) = rewriter.new.number(operands[0]) {
                        let negated = rewriter.new.constant(-number);
                        rewriter.record(negated.into());
                        continue;
                    }
                    minuses += 1;
                    let zero = Operand::from(rewriter.new.constant(0.0));
                    operands = Operand::list([zero, operands[0]]);
                    Operation::Sub
                }
                other => other,
            };
            let name = if node.name.is_none() {
                names.fresh(owners[value.index()])
            } else {
                node.name
            };
            rewriter.keep(Node {
                name,
                operands,
                operation,
                ..*node
            });
        }
        *function = rewriter.finish();
        context.count("minuses written as 0 - x", minuses);
        Ok(())
    }
}
