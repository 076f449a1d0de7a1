//! The sums and products of a network as polynomials with integer
//! coefficients.
//!
//! A sum or product that only one other reads is taken into it as long as no
//! product of two sums has to be multiplied out, so a polynomial has no more
//! terms than the function has operands. A product with several readers can be
//! absorbed into each of them: expanded polynomials mostly share the beginnings
//! of their products, in the order in which they were written. All other nodes
//! are variables: quotients, roots, sines, sums with several readers, and
//! literals that are no small integers (products of others round).
//!
//! **Invariant.** A polynomial has the value of its node, and its variables
//! are at lower positions.

use super::super::network::{Edge, FactorKind, FactorNetwork};
use robovec_framework::rewrite_limit::RewriteLimit;
use smallvec::SmallVec;

/// A larger sum is written over its unexpanded terms.
const MAX_TERMS: usize = 1 << 17;
/// Maximum degree of a product: exponents are kept in bytes.
const MAX_DEGREE: u32 = 255;
/// Larger integers are variables: sums of products of smaller ones stay exact.
const MAX_INTEGER: f64 = (1u64 << 31) as f64;
/// No coefficient is larger, so that it is exact as a literal.
const MAX_COEFFICIENT: u64 = 1 << 53;

/// An integer times powers of variables.
#[derive(Clone, Debug)]
pub(super) struct PolynomialTerm {
    pub(super) coefficient: i64,
    /// The nodes of variables and their exponents, by node.
    pub(super) powers: SmallVec<[(u32, u32); 6]>,
}

pub(super) struct NetworkPolynomials {
    /// By node; `None` for nodes other than sums and products, and for nodes
    /// that only the polynomials that absorbed them read.
    pub(super) terms: Vec<Option<Vec<PolynomialTerm>>>,
    /// By node: true for those that still have to be computed.
    pub(super) needed: Vec<bool>,
    /// By node: the node that absorbed it, or itself.
    pub(super) heirs: Vec<u32>,
    dissolving: bool,
}

impl NetworkPolynomials {
    /// Reads a network with its live nodes in order. A node that must not be
    /// rewritten stays a variable without a polynomial. When not `dissolving`,
    /// products with several readers are variables too.
    pub(super) fn read(
        network: &FactorNetwork,
        order: &[u32],
        dissolving: bool,
        rewrites: &RewriteLimit,
    ) -> NetworkPolynomials {
        let count = network.nodes.len();
        let mut polynomials = NetworkPolynomials {
            terms: vec![None; count],
            needed: vec![false; count],
            heirs: (0..count as u32).collect(),
            dissolving,
        };
        for &node in order {
            let kind = network.nodes[node as usize].kind;
            if matches!(kind, FactorKind::Sum | FactorKind::Product)
                && rewrites.allow(network.nodes[node as usize].name, "horner")
            {
                polynomials.terms[node as usize] = Some(polynomials.of_node(network, node));
            }
        }
        polynomials.mark_needed(network, order);
        polynomials
    }

    /// The polynomial of a sum or product whose operands have theirs.
    fn of_node(&mut self, network: &FactorNetwork, node: u32) -> Vec<PolynomialTerm> {
        let operands = &network.nodes[node as usize].operands;
        let product = network.nodes[node as usize].kind == FactorKind::Product;
        let taken = self.taken(network, operands, product);
        let terms = if product {
            self.multiply(network, operands, &taken)
        } else {
            self.add(network, operands, &taken)
        };
        match terms {
            Some(terms) => {
                for (edge, _) in operands.iter().zip(&taken).filter(|(_, taken)| **taken) {
                    self.heirs[edge.node()] = node;
                }
                terms
            }
            // Over its operands as they are it is small.
            None => if product {
                self.multiply(network, operands, &vec![false; operands.len()])
            } else {
                self.add(network, operands, &vec![false; operands.len()])
            }
            .expect("a sum or product of variables is a polynomial of its operands"),
        }
    }

    /// For each operand, a flag: true when its polynomial is absorbed into that
    /// of the user; of the factors of a product at most one that is a sum.
    fn taken(&self, network: &FactorNetwork, operands: &[Edge], product: bool) -> Vec<bool> {
        let size = |edge: &Edge| self.terms[edge.node()].as_ref().map_or(0, Vec::len);
        let largest = operands
            .iter()
            .filter(|edge| network.nodes[edge.node()].uses == 1)
            .max_by_key(|edge| size(edge));
        let able = |edge: &Edge| match size(edge) {
            0 => false,
            1 => self.dissolving || network.nodes[edge.node()].uses == 1,
            _ if product => Some(edge) == largest,
            _ => network.nodes[edge.node()].uses == 1,
        };
        operands.iter().map(able).collect()
    }

    /// The terms of an operand: of its polynomial if that is taken.
    fn operand(&self, network: &FactorNetwork, edge: Edge, taken: bool) -> Vec<PolynomialTerm> {
        let sign = if edge.negative() { -1 } else { 1 };
        let variable = |coefficient, powers| {
            vec![PolynomialTerm {
                coefficient,
                powers,
            }]
        };
        match network.nodes[edge.node()].kind {
            FactorKind::Constant(number) if number.fract() == 0.0 && number.abs() < MAX_INTEGER => {
                variable(sign * number as i64, SmallVec::new())
            }
            _ if taken => {
                let terms = self.terms[edge.node()].as_ref();
                let mut terms = terms.expect("what is taken is a polynomial").clone();
                for term in &mut terms {
                    term.coefficient *= sign;
                }
                terms
            }
            _ => variable(sign, SmallVec::from_slice(&[(edge.node() as u32, 1)])),
        }
    }

    /// `None` when the sum is too large, or none at all.
    fn add(
        &self,
        network: &FactorNetwork,
        operands: &[Edge],
        taken: &[bool],
    ) -> Option<Vec<PolynomialTerm>> {
        let mut terms = Vec::new();
        for (&edge, &taken) in operands.iter().zip(taken) {
            terms.extend(self.operand(network, edge, taken));
            if terms.len() > MAX_TERMS {
                return None;
            }
        }
        collect(&mut terms)?;
        (!terms.is_empty()).then_some(terms)
    }

    /// `None` when the product is of too high a degree, or its coefficients
    /// are too large.
    fn multiply(
        &self,
        network: &FactorNetwork,
        operands: &[Edge],
        taken: &[bool],
    ) -> Option<Vec<PolynomialTerm>> {
        let mut common = PolynomialTerm {
            coefficient: 1,
            powers: SmallVec::new(),
        };
        let mut sum = None;
        for (&edge, &taken) in operands.iter().zip(taken) {
            let terms = self.operand(network, edge, taken);
            match &terms[..] {
                [single] => {
                    common.coefficient = common.coefficient.checked_mul(single.coefficient)?;
                    common.powers.extend_from_slice(&single.powers);
                }
                _ => sum = Some(terms),
            }
        }
        let mut terms = match sum {
            None => vec![common],
            Some(mut terms) => {
                for term in &mut terms {
                    term.coefficient = term.coefficient.checked_mul(common.coefficient)?;
                    term.powers.extend_from_slice(&common.powers);
                }
                terms
            }
        };
        for term in &mut terms {
            let degree: u32 = term.powers.iter().map(|&(_, exponent)| exponent).sum();
            if degree > MAX_DEGREE {
                return None;
            }
            merge_powers(&mut term.powers);
        }
        collect(&mut terms)?;
        Some(terms)
    }

    /// Marks the nodes that the outputs need after many were absorbed into
    /// polynomials, and drops the polynomials of the others.
    fn mark_needed(&mut self, network: &FactorNetwork, order: &[u32]) {
        for edge in &network.outputs {
            self.needed[edge.node()] = true;
        }
        for &node in order.iter().rev() {
            let node = node as usize;
            if !self.needed[node] {
                self.terms[node] = None;
                continue;
            }
            match &self.terms[node] {
                Some(terms) => {
                    for &(variable, _) in terms.iter().flat_map(|term| &term.powers) {
                        self.needed[variable as usize] = true;
                    }
                }
                None => {
                    for edge in &network.nodes[node].operands {
                        self.needed[edge.node()] = true;
                    }
                }
            }
        }
    }
}

/// Sorts powers and adds the exponents of one variable.
fn merge_powers(powers: &mut SmallVec<[(u32, u32); 6]>) {
    powers.sort_unstable();
    powers.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
}

/// Sorts terms and adds those that are similar; `None` when a coefficient is
/// too large.
fn collect(terms: &mut Vec<PolynomialTerm>) -> Option<()> {
    terms.sort_unstable_by(|a, b| a.powers.cmp(&b.powers));
    let mut exact = true;
    terms.dedup_by(|next, kept| {
        let same = next.powers == kept.powers;
        if same {
            let sum = kept.coefficient.checked_add(next.coefficient);
            exact &= sum.is_some();
            kept.coefficient = sum.unwrap_or(0);
        }
        same
    });
    terms.retain(|term| term.coefficient != 0);
    exact &= terms
        .iter()
        .all(|term| term.coefficient.unsigned_abs() <= MAX_COEFFICIENT);
    exact.then_some(())
}
