//! Saturation with associativity and commutativity by rule.
//!
//! Operations enter as they are, on two operands, and every order and every
//! parenthesis is a form of its own: 3^n of them for a sum of n terms. That is
//! for small windows, for questions about rules, and for the proof that bags
//! merged earliest first lose nothing against it.

use super::form::{Form, Knowledge};
use super::saturate::Limits;
use egg::{
    Applier, EGraph, ENodeOrVar, FromOp, FromOpError, Id, Pattern, RecExpr, Rewrite, Runner,
    Searcher, SimpleScheduler, StopReason,
};
use robovec_ir::Operation;
use std::fmt;
use std::sync::LazyLock;
use std::time::Duration;

/// A rewrite of plain terms.
pub(crate) type PlainRule = Rewrite<Form, Knowledge>;

/// The word of an operation in terms.
fn word(operation: Operation) -> &'static str {
    match operation {
        Operation::Copy => "copy",
        Operation::Neg => "neg",
        Operation::Add => "+",
        Operation::Sub => "-",
        Operation::Mul => "*",
        Operation::Div => "/",
        Operation::Sin => "sin",
        Operation::Cos => "cos",
        Operation::Sqrt => "sqrt",
        Operation::Fma => "fma",
        Operation::Fms => "fms",
        Operation::Fnma => "fnma",
    }
}

impl fmt::Display for Form {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Form::Leaf(number) => write!(formatter, "x{number}"),
            Form::Number(bits) => write!(formatter, "{}", f64::from_bits(*bits)),
            Form::Sum(..) => formatter.write_str("sum"),
            Form::Product(_) => formatter.write_str("product"),
            Form::Other(operation, _) => formatter.write_str(word(*operation)),
        }
    }
}

impl FromOp for Form {
    type Error = FromOpError;

    fn from_op(op: &str, children: Vec<Id>) -> Result<Form, FromOpError> {
        let operation = Operation::ALL
            .into_iter()
            .find(|&operation| word(operation) == op && operation.arity() == children.len());
        if let Some(operation) = operation {
            return Ok(Form::Other(operation, children.into()));
        }
        let leaf = op.strip_prefix('x').and_then(|number| number.parse().ok());
        match (leaf, op.parse::<f64>(), children.is_empty()) {
            (Some(number), _, true) => Ok(Form::Leaf(number)),
            (None, Ok(number), true) => Ok(Form::Number(number.to_bits())),
            _ => Err(FromOpError::new(op, children)),
        }
    }
}

/// The rules bags do without: order, parentheses, signs, zeros and ones.
pub(crate) const STRUCTURAL: [(&str, &str, &str); 20] = [
    ("comm-add", "(+ ?a ?b)", "(+ ?b ?a)"),
    ("comm-mul", "(* ?a ?b)", "(* ?b ?a)"),
    ("assoc-add", "(+ ?a (+ ?b ?c))", "(+ (+ ?a ?b) ?c)"),
    ("assoc-mul", "(* ?a (* ?b ?c))", "(* (* ?a ?b) ?c)"),
    ("sub-to-neg", "(- ?a ?b)", "(+ ?a (neg ?b))"),
    ("neg-to-sub", "(+ ?a (neg ?b))", "(- ?a ?b)"),
    ("neg-neg", "(neg (neg ?a))", "?a"),
    ("neg-of-sum", "(neg (+ ?a ?b))", "(+ (neg ?a) (neg ?b))"),
    ("sum-of-neg", "(+ (neg ?a) (neg ?b))", "(neg (+ ?a ?b))"),
    ("neg-of-product", "(neg (* ?a ?b))", "(* (neg ?a) ?b)"),
    ("product-of-neg", "(* (neg ?a) ?b)", "(neg (* ?a ?b))"),
    ("zero-sub", "(- 0 ?a)", "(neg ?a)"),
    ("sub-zero", "(- ?a 0)", "?a"),
    ("add-zero", "(+ ?a 0)", "?a"),
    ("neg-zero", "(neg 0)", "0"),
    ("mul-zero", "(* ?a 0)", "0"),
    ("mul-one", "(* ?a 1)", "?a"),
    ("neg-of-quotient", "(neg (/ ?a ?b))", "(/ (neg ?a) ?b)"),
    ("quotient-of-neg", "(/ (neg ?a) ?b)", "(neg (/ ?a ?b))"),
    ("sin-of-neg", "(sin (neg ?a))", "(neg (sin ?a))"),
];

static STRUCTURAL_RULES: LazyLock<Vec<PlainRule>> = LazyLock::new(|| {
    let pattern = |text: &str| text.parse::<Pattern<Form>>().expect("a pattern of ours");
    let rule = |&(name, left, right): &(&str, &str, &str)| {
        Rewrite::new(name, pattern(left), pattern(right)).expect("its variables are bound")
    };
    STRUCTURAL.iter().map(rule).collect()
});

/// The structural rules, ready to run.
pub(crate) fn structural() -> Vec<PlainRule> {
    STRUCTURAL_RULES.clone()
}

/// A rule between two patterns; `None` when the right side has a variable
/// that the left has not.
pub(crate) fn rule(
    name: &str,
    left: RecExpr<ENodeOrVar<Form>>,
    right: RecExpr<ENodeOrVar<Form>>,
) -> Option<PlainRule> {
    let (left, right) = (Pattern::new(left), Pattern::new(right));
    let bound = Searcher::<Form, Knowledge>::vars(&left);
    let free = Applier::<Form, Knowledge>::vars(&right);
    if free.iter().any(|variable| !bound.contains(variable)) {
        return None;
    }
    Rewrite::new(name, left, right).ok()
}

/// Saturates an e-graph of plain terms; true when nothing new is left to find.
pub(crate) fn saturate(
    egraph: EGraph<Form, Knowledge>,
    rules: &[PlainRule],
    limits: Limits,
) -> (EGraph<Form, Knowledge>, bool) {
    let runner = Runner::default()
        .with_egraph(egraph)
        .with_scheduler(SimpleScheduler)
        .with_node_limit(limits.nodes)
        .with_iter_limit(limits.iterations as usize)
        // Never by the clock: what is found must not depend on the load.
        .with_time_limit(Duration::from_secs(u64::from(u32::MAX)))
        .run(rules);
    let saturated = matches!(runner.stop_reason, Some(StopReason::Saturated));
    (runner.egraph, saturated)
}
