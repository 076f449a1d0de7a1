//! One form for all terms that differ by the order and grouping of sums and
//! products only, and one name for all candidates that differ by the names of
//! their variables.

use super::super::pattern::{Pattern, PatternNode};
use robovec_ir::Operation;

/// A flat sum or product, or any other operation.
enum FlatForm {
    Other(String),
    /// Terms with their signs: true is minus.
    Sum(Vec<(String, bool)>),
    Product(Vec<String>),
}

impl FlatForm {
    fn text(&self) -> String {
        match self {
            FlatForm::Other(text) => text.clone(),
            FlatForm::Sum(terms) => {
                let mut terms: Vec<String> = terms
                    .iter()
                    .map(|(term, minus)| format!("{}{term}", if *minus { '-' } else { '+' }))
                    .collect();
                terms.sort_unstable();
                format!("({})", terms.concat())
            }
            FlatForm::Product(factors) => {
                let mut factors = factors.clone();
                factors.sort_unstable();
                format!("({})", factors.join("*"))
            }
        }
    }

    fn terms(self) -> Vec<(String, bool)> {
        match self {
            FlatForm::Sum(terms) => terms,
            other => vec![(other.text(), false)],
        }
    }

    fn factors(self) -> Vec<String> {
        match self {
            FlatForm::Product(factors) => factors,
            other => vec![other.text()],
        }
    }
}

fn negated(mut terms: Vec<(String, bool)>) -> Vec<(String, bool)> {
    for (_, minus) in &mut terms {
        *minus = !*minus;
    }
    terms
}

/// The text of a pattern that is equal for all orders and groupings of its
/// sums and products, with its variables renumbered.
pub(super) fn normal(pattern: &Pattern, number: &[u32]) -> String {
    let mut forms: Vec<Option<FlatForm>> = Vec::with_capacity(pattern.nodes.len());
    for node in &pattern.nodes {
        let form = match *node {
            PatternNode::Variable(variable) => {
                FlatForm::Other(format!("x{}", number[variable as usize]))
            }
            PatternNode::Number(number) => FlatForm::Other(number.to_string()),
            PatternNode::Operation(operation, [a, b]) => {
                let mut take = |index: u32| {
                    let form = forms[index as usize].take();
                    form.expect("every node of a pattern is used once")
                };
                let first = take(a);
                match operation {
                    Operation::Add | Operation::Sub => {
                        let mut terms = first.terms();
                        let second = take(b).terms();
                        terms.extend(match operation {
                            Operation::Sub => negated(second),
                            _ => second,
                        });
                        FlatForm::Sum(terms)
                    }
                    Operation::Neg => FlatForm::Sum(negated(first.terms())),
                    Operation::Mul => {
                        let mut factors = first.factors();
                        factors.extend(take(b).factors());
                        FlatForm::Product(factors)
                    }
                    Operation::Div => {
                        FlatForm::Other(format!("({}/{})", first.text(), take(b).text()))
                    }
                    other => FlatForm::Other(format!("{}({})", other.name(), first.text())),
                }
            }
        };
        forms.push(Some(form));
    }
    let root = forms.pop().flatten().expect("a pattern has a root");
    root.text()
}

/// The name of a pair of patterns, equal for all pairs that differ in the
/// names of variables and the order of operands only. An angle, the last
/// variable, keeps its place.
pub(super) fn name(left: &Pattern, right: &Pattern, variables: u32, angle: bool) -> String {
    let mut order: Vec<u32> = (0..variables + u32::from(angle)).collect();
    let mut least: Option<String> = None;
    loop {
        let text = format!("{} = {}", normal(left, &order), normal(right, &order));
        if least.as_ref().is_none_or(|least| text < *least) {
            least = Some(text);
        }
        if !next_permutation(&mut order[..variables as usize]) {
            return least.expect("the first order has a text");
        }
    }
}

/// The next order in the dictionary; false after the last.
fn next_permutation(order: &mut [u32]) -> bool {
    let Some(pivot) = (1..order.len()).rev().find(|&i| order[i - 1] < order[i]) else {
        return false;
    };
    let swap = (pivot..order.len())
        .rev()
        .find(|&i| order[i] > order[pivot - 1])
        .expect("the number at the pivot is larger");
    order.swap(pivot - 1, swap);
    order[pivot..].reverse();
    true
}
