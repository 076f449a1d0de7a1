//! Domain of the right side of a rule against that of the left side.
//!
//! Every divisor of the right side must be nonzero there, and every radicand
//! nonnegative: by its bounds, as a multiple of a known number, or because all
//! its factors are factors of divisors of the left side or of other nonzero
//! numbers. A point where that fails is looked for elsewhere
//! ([`super::counterexample`]); without a proof a rule is not proved even when
//! none is found.

use super::super::pattern::PatternNode;
use super::facts::NodeFacts;
use super::line::Lines;
use robovec_analysis::range::Range;
use robovec_ir::Operation;

/// Proves that the right side is defined wherever the left side is. Properties
/// found for its nodes are added to the facts. The error is the first operand
/// of which it could not be proved.
pub(super) fn prove(facts: &mut NodeFacts<'_>) -> Result<(), usize> {
    let nodes = facts.joined.left..facts.joined.pattern.nodes.len();
    let mut lines = None;
    for node in nodes {
        facts.defined = node;
        if let PatternNode::Operation(operation, [a, b]) = facts.joined.pattern.nodes[node] {
            let (a, b) = (a as usize, b as usize);
            if matches!(operation, Operation::Div | Operation::Sqrt) {
                facts.propagate();
            }
            if operation == Operation::Div && !facts.ranges[b].nonzero {
                let lines = lines.get_or_insert_with(|| Lines::of(facts));
                if !lines.is_nonzero(facts, b) {
                    return Err(b);
                }
                facts.add(b, Range::NONZERO);
            }
            if operation == Operation::Sqrt && facts.ranges[a].low < 0.0 {
                return Err(a);
            }
        }
    }
    facts.defined = facts.joined.pattern.nodes.len();
    facts.propagate();
    Ok(())
}
