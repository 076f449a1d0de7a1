//! Saturation with associativity and commutativity by rule.
//!
//! Operations have two operands, as in the function, and every order and every
//! parenthesis is its own form: 3^n of them for a sum of n terms. This mode is
//! for small windows, for questions about rules, and for the test that the
//! order of bags (earliest first) loses nothing.

use super::form::{ClassAnalysis, EquivalentForm};
use super::saturate::{SaturationEnd, SaturationLimits};
use egg::{
    Applier, ConditionalApplier, EGraph, ENodeOrVar, FromOp, FromOpError, Id, Language, Pattern,
    RecExpr, Rewrite, RewriteScheduler, Runner, SearchMatches, Searcher, StopReason, Subst, Var,
};
use robovec_analysis::class::NumericClass;
use robovec_ir::Operation;
use robovec_rules::{Pattern as RulePattern, PatternNode, Rule, RuleSet};
use std::fmt;
use std::sync::LazyLock;
use std::time::Duration;

/// A rewrite of plain terms.
pub(crate) type PlainRule = Rewrite<EquivalentForm, ClassAnalysis>;

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

impl fmt::Display for EquivalentForm {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EquivalentForm::Leaf(number) => write!(formatter, "x{number}"),
            EquivalentForm::Number(bits) => write!(formatter, "{}", f64::from_bits(*bits)),
            EquivalentForm::Sum(..) => formatter.write_str("sum"),
            EquivalentForm::Product(_) => formatter.write_str("product"),
            EquivalentForm::Other(operation, _) => formatter.write_str(word(*operation)),
        }
    }
}

impl FromOp for EquivalentForm {
    type Error = FromOpError;

    fn from_op(op: &str, children: Vec<Id>) -> Result<EquivalentForm, FromOpError> {
        let operation = Operation::ALL
            .into_iter()
            .find(|&operation| word(operation) == op && operation.arity() == children.len());
        if let Some(operation) = operation {
            return Ok(EquivalentForm::Other(operation, children.into()));
        }
        let leaf = op.strip_prefix('x').and_then(|number| number.parse().ok());
        match (leaf, op.parse::<f64>(), children.is_empty()) {
            (Some(number), _, true) => Ok(EquivalentForm::Leaf(number)),
            (None, Ok(number), true) => Ok(EquivalentForm::Number(number.to_bits())),
            _ => Err(FromOpError::new(op, children)),
        }
    }
}

/// The files of rules that bags do without: order, parentheses, signs, zeros
/// and ones.
const STRUCTURAL: [&str; 3] = ["signs", "commutativity", "associativity"];

static STRUCTURAL_RULES: LazyLock<Vec<PlainRule>> = LazyLock::new(|| {
    let sets = STRUCTURAL.map(|name| RuleSet::named(name).expect("a file that ships"));
    let rules = sets.iter().flat_map(|set| &set.rules);
    let directed = rules.flat_map(Rule::directed);
    directed.filter_map(|rule| from_rule(&rule)).collect()
});

/// The structural rules, ready to run.
pub(crate) fn structural() -> Vec<PlainRule> {
    STRUCTURAL_RULES.clone()
}

/// The rules of a set as rewrites of plain terms, in one direction each, after
/// the structural rules. Conditions are on numbers and are looked up there.
pub(crate) fn all(rules: &RuleSet, weakest: NumericClass) -> Vec<PlainRule> {
    let mut all = structural();
    for rule in rules.rules.iter().flat_map(Rule::directed) {
        let is_new = all.iter().all(|known| known.name.as_str() != rule.name);
        if rule.class <= weakest && !rule.left.is_variable() && is_new {
            all.extend(from_rule(&rule));
        }
    }
    all
}

/// A rule as a rewrite; `None` when its right side has a variable more.
pub(crate) fn from_rule(rule: &Rule) -> Option<PlainRule> {
    let (left, right) = (pattern(&rule.left), pattern(&rule.right));
    let bound = Searcher::<EquivalentForm, ClassAnalysis>::vars(&left);
    let free = Applier::<EquivalentForm, ClassAnalysis>::vars(&right);
    if free.iter().any(|variable| !bound.contains(variable)) {
        return None;
    }
    if rule.conditions.is_empty() {
        return Rewrite::new(rule.name.as_str(), left, right).ok();
    }
    let conditions = rule.conditions.clone();
    let holds = move |egraph: &mut EGraph<EquivalentForm, ClassAnalysis>, _: Id, subst: &Subst| {
        conditions.iter().all(|condition| {
            let class = subst.get(Var::from_u32(condition.variable));
            let number = class.and_then(|&class| egraph[class].data.number);
            number.is_some_and(|bits| condition.requirement.holds_for(f64::from_bits(bits)))
        })
    };
    let applier = ConditionalApplier {
        condition: holds,
        applier: right,
    };
    Rewrite::new(rule.name.as_str(), left, applier).ok()
}

/// A side of a rule as a pattern of plain terms.
fn pattern(side: &RulePattern) -> Pattern<EquivalentForm> {
    let variable = |number| ENodeOrVar::Var(Var::from_u32(number));
    Pattern::new(term(side, variable, ENodeOrVar::ENode))
}

/// A side of a rule as a term of a language that has variables and plain forms.
pub(super) fn term<L: Language>(
    side: &RulePattern,
    variable: impl Fn(u32) -> L,
    plain: impl Fn(EquivalentForm) -> L,
) -> RecExpr<L> {
    let mut term = RecExpr::default();
    let mut ids: Vec<Id> = Vec::with_capacity(side.nodes.len());
    for node in &side.nodes {
        let node = match *node {
            PatternNode::Variable(number) => variable(number),
            PatternNode::Number(number) => plain(plain_number(number)),
            PatternNode::Operation(operation, places) => {
                let operands = places[..operation.arity()].iter();
                let operands = operands.map(|&place| ids[place as usize]).collect();
                plain(EquivalentForm::Other(operation, operands))
            }
        };
        ids.push(term.add(node));
    }
    term
}

/// A number as a plain term; zero has no sign.
pub(crate) fn plain_number(number: f64) -> EquivalentForm {
    EquivalentForm::Number(if number == 0.0 { 0 } else { number.to_bits() })
}

/// Matches of one rule that a round keeps, per form that there is room for:
/// with associativity a graph has many more places than forms, and all of them
/// are kept before the first one makes a form.
const MATCHES_PER_NODE: usize = 4;

/// Uses at most this number of matches of a rule in a round, and makes no more
/// forms than the limit.
struct BoundedMatches {
    most: usize,
    nodes: usize,
    /// Some matches were left out.
    cut: bool,
}

impl RewriteScheduler<EquivalentForm, ClassAnalysis> for BoundedMatches {
    fn can_stop(&mut self, _iteration: usize) -> bool {
        !self.cut
    }

    fn search_rewrite<'a>(
        &mut self,
        _iteration: usize,
        egraph: &EGraph<EquivalentForm, ClassAnalysis>,
        rewrite: &'a PlainRule,
    ) -> Vec<SearchMatches<'a, EquivalentForm>> {
        let matches = rewrite.searcher.search_with_limit(egraph, self.most);
        let count: usize = matches.iter().map(|found| found.substs.len()).sum();
        self.cut |= count >= self.most;
        matches
    }

    fn apply_rewrite(
        &mut self,
        _iteration: usize,
        egraph: &mut EGraph<EquivalentForm, ClassAnalysis>,
        rewrite: &PlainRule,
        matches: Vec<SearchMatches<'_, EquivalentForm>>,
    ) -> usize {
        let right = rewrite.applier.get_pattern_ast();
        let size = right.map_or(1, |ast| ast.len());
        let mut applied = 0;
        for found in matches {
            for subst in found.substs {
                if egraph.total_size() + size > self.nodes {
                    self.cut = true;
                    return applied;
                }
                let one = SearchMatches {
                    eclass: found.eclass,
                    substs: vec![subst],
                    ast: found.ast.clone(),
                };
                applied += rewrite.apply(egraph, &[one]).len();
            }
        }
        applied
    }
}

/// Saturates an e-graph of plain terms.
pub(crate) fn saturate(
    egraph: EGraph<EquivalentForm, ClassAnalysis>,
    rules: &[PlainRule],
    limits: SaturationLimits,
) -> (EGraph<EquivalentForm, ClassAnalysis>, SaturationEnd) {
    let runner = Runner::default()
        .with_egraph(egraph)
        .with_scheduler(BoundedMatches {
            most: MATCHES_PER_NODE.saturating_mul(limits.nodes),
            nodes: limits.nodes,
            cut: false,
        })
        .with_node_limit(limits.nodes)
        .with_iter_limit(limits.iterations as usize)
        // Never by the clock: what is found must not depend on the load.
        .with_time_limit(Duration::from_secs(u64::from(u32::MAX)))
        .run(rules);
    let end = match runner.stop_reason {
        Some(StopReason::Saturated) => SaturationEnd::Complete,
        Some(StopReason::NodeLimit(_)) => SaturationEnd::Nodes,
        _ => SaturationEnd::Iterations,
    };
    (runner.egraph, end)
}
