//! The definition of a value as a sum of products and values.

use crate::adjoint::Tape;
use robovec_ir::Operation;

/// A term of a sum.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct NormTerm {
    pub negative: bool,
    pub kind: NormTermKind,
}

/// The form of a term; operands are slots.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum NormTermKind {
    Plain(usize),
    Product(usize, usize),
    Quotient(usize, usize),
}

/// The definition of a value.
#[derive(Clone, Debug)]
pub(super) struct SumDefinition {
    pub terms: Vec<NormTerm>,
    /// The nodes it consists of, that of the value included.
    pub nodes: Vec<usize>,
}

/// The number of times every slot is read.
pub(super) fn uses(tape: &Tape) -> Vec<u32> {
    let mut uses = vec![0; tape.slots()];
    for node in 0..tape.nodes() {
        for &slot in &tape.operands(node)[..tape.operation(node).arity()] {
            uses[slot] += 1;
        }
    }
    for output in 0..tape.outputs() {
        uses[tape.output_slot(output)] += 1;
    }
    uses
}

impl SumDefinition {
    /// The definition of a node; `None` for a sine, a cosine, a root or a
    /// leaf. Sums and products that are read once belong to the sum that reads
    /// them.
    pub(super) fn of(tape: &Tape, uses: &[u32], node: usize) -> Option<SumDefinition> {
        if node >= tape.nodes() || is_atom(tape.operation(node)) {
            return None;
        }
        let mut definition = SumDefinition {
            terms: Vec::new(),
            nodes: Vec::new(),
        };
        let mut open = vec![(node, false)];
        while let Some((slot, negative)) = open.pop() {
            let inside = slot == node
                || slot < tape.nodes() && uses[slot] == 1 && !is_atom(tape.operation(slot));
            if !inside {
                let kind = NormTermKind::Plain(slot);
                definition.terms.push(NormTerm { negative, kind });
                continue;
            }
            definition.nodes.push(slot);
            let [a, b, c] = tape.operands(slot);
            let mut term = |negative, kind| definition.terms.push(NormTerm { negative, kind });
            match tape.operation(slot) {
                Operation::Copy => open.push((a, negative)),
                Operation::Neg => open.push((a, !negative)),
                Operation::Add => open.extend([(b, negative), (a, negative)]),
                Operation::Sub => open.extend([(b, !negative), (a, negative)]),
                Operation::Mul => term(negative, NormTermKind::Product(a, b)),
                Operation::Div => term(negative, NormTermKind::Quotient(a, b)),
                Operation::Fma => {
                    term(negative, NormTermKind::Product(a, b));
                    open.push((c, negative));
                }
                Operation::Fms => {
                    term(negative, NormTermKind::Product(a, b));
                    open.push((c, !negative));
                }
                Operation::Fnma => {
                    term(!negative, NormTermKind::Product(a, b));
                    open.push((c, negative));
                }
                Operation::Sin | Operation::Cos | Operation::Sqrt => {
                    unreachable!("atoms are not inside a sum")
                }
            }
        }
        Some(definition)
    }

    /// The number of the latest node that it reads, plus one; 0 if it reads
    /// leaves alone.
    pub(super) fn after(&self, tape: &Tape) -> usize {
        let slots = self.terms.iter().flat_map(|term| match term.kind {
            NormTermKind::Plain(a) => [a, a],
            NormTermKind::Product(a, b) | NormTermKind::Quotient(a, b) => [a, b],
        });
        let nodes = slots.filter(|&slot| slot < tape.nodes());
        nodes.map(|slot| slot + 1).max().unwrap_or(0)
    }
}

/// True for operations that are no sum of products.
pub(super) fn is_atom(operation: Operation) -> bool {
    matches!(operation, Operation::Sin | Operation::Cos | Operation::Sqrt)
}
