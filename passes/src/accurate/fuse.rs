//! Products and sums in one operation, for the rounding that it saves.
//!
//! The pass `fma` counts cycles and operations; here every product with a
//! single reading sum is fused with it if the result is in time: to first order
//! one rounding less is always better. Of two products the one is taken in
//! whose rounding harms more. Computations of rounding errors
//! (`super::compensate`) are unchanged without special treatment: a product
//! whose error is computed is read more than once.

use super::profile::SensitivityProfile;
use crate::sums::fused::contraction;
use crate::sums::groups::single_product;
use crate::sums::writer::ArrivalTimes;
use robovec_analysis::critical_path::{Weights, tails};
use robovec_framework::pass::Context;
use robovec_framework::rewrite::Rewriter;
use robovec_ir::{Function, Node, Operand, Operation, Value};

/// The function with products fused, and their number; `None` where there are
/// none.
pub(super) fn fuse(
    function: &Function,
    profile: &SensitivityProfile,
    limit: u32,
    context: &mut Context<'_>,
) -> Option<(Function, u64)> {
    let weights = Weights::cycles(context.machine);
    let uses = function.use_counts();
    let tails = tails(function, &weights);
    let mut times = ArrivalTimes::new(weights, uses.len());
    let mut taken = vec![false; uses.len()];
    let mut forms: Vec<Option<(Operation, [Operand; Operand::MAX_COUNT])>> = vec![None; uses.len()];
    let mut count = 0;
    for (value, node) in function.values() {
        let mut arrival = times.finish(node.operation, node.operands());
        let required = limit.saturating_sub(tails[value.index()]);
        let mut best: Option<(f64, Value, usize)> = None;
        for side in 0..2 {
            let product = product(function, node, side, &uses);
            let harm = product.map(|product| profile.blame(product.index()));
            if let (Some(product), Some(harm)) = (product, harm)
                && best.is_none_or(|(most, ..)| harm > most)
            {
                best = Some((harm, product, side));
            }
        }
        if let Some((_, product, side)) = best {
            let (operation, operands) = contraction(function, node, side);
            let late = times.finish(operation, &operands);
            let performed = context.machine.kind_of(operation).is_some();
            if performed && late <= required && context.allow_rewrite(node.name, "contract") {
                arrival = late;
                taken[product.index()] = true;
                forms[value.index()] = Some((operation, operands));
                count += 1;
            }
        }
        times.note(arrival);
    }
    (count > 0).then(|| (write(function, &taken, &forms, context), count))
}

/// The product on one side of a sum, if it has no other reader.
fn product(function: &Function, node: &Node, side: usize, uses: &[u32]) -> Option<Value> {
    if !matches!(node.operation, Operation::Add | Operation::Sub) {
        return None;
    }
    single_product(function, uses, node.operands[side])
}

fn write(
    function: &Function,
    taken: &[bool],
    forms: &[Option<(Operation, [Operand; Operand::MAX_COUNT])>],
    context: &mut Context<'_>,
) -> Function {
    let mut rewriter = Rewriter::new(function, function.level);
    for (value, node) in function.values() {
        let index = value.index();
        if taken[index] {
            rewriter.record(Operand::NONE);
            continue;
        }
        let Some((operation, operands)) = forms[index] else {
            let operands = rewriter.translate_operands(node);
            rewriter.keep(Node { operands, ..*node });
            continue;
        };
        let products = node.operands().iter().filter_map(|operand| operand.value());
        let products = products.filter(|product| taken[product.index()]);
        let mut sets = vec![node.sources];
        sets.extend(products.map(|product| function.node(product).sources));
        let sources = context.tables.sources.union(&sets);
        let operands = operands.map(|operand| rewriter.translate(operand));
        rewriter.keep(Node {
            operation,
            operands,
            sources,
            ..*node
        });
        context.note(node.name, "contract");
    }
    rewriter.finish()
}
