//! The growth of graphs under rules.
//!
//! Terms of growing size from several families are saturated; where the numbers
//! of nodes follow a formula exactly, it is the growth of the rule. The family
//! with the worst growth decides. Budgets are in nodes: a term of four
//! operations that needs more than the budget allows will not do better in a
//! program.

use super::super::RuleSet;
use super::super::graph::{GraphBudget, GraphTerm, grow, rewrites, term};
use super::super::rule::Rule;
use super::family::TermFamily;
use super::fit::{Growth, estimate, formula};
use egg::Rewrite;

/// The growth of a graph.
#[derive(Clone, PartialEq, Debug)]
pub struct Growing {
    /// Its class.
    pub growth: Growth,
    /// True when a formula goes through all numbers of nodes; else the class
    /// is an estimate.
    pub exact: bool,
    /// Nodes as a function of n, or some numbers when no formula was found.
    pub formula: String,
    /// The family with this growth.
    pub family: String,
}

/// Two rules that grow more together than each alone.
#[derive(Clone, PartialEq, Debug)]
pub struct PairGrowth {
    /// Their names.
    pub names: [String; 2],
    /// The growth under both together.
    pub growing: Growing,
}

/// Sizes of the terms.
const SIZES: std::ops::RangeInclusive<u32> = 1..=7;

const ALONE: GraphBudget = GraphBudget {
    nodes: 6_000,
    iterations: 40,
};

/// The growth of a graph under a rule and those that are always on: the order
/// of operands, and the rules of zeros, ones and signs that shorten a term,
/// without which hardly any set of rules comes to an end.
pub fn alone(rule: &Rule) -> Growing {
    worst(&[rule], &always(), ALONE)
}

/// The rule that causes unbounded growth together with this one: itself, or one
/// of those that are always active.
pub fn partner(rule: &Rule) -> Option<String> {
    if explodes(worst(&[rule], &[], ALONE).growth) {
        return Some(rule.name.clone());
    }
    let found = always().into_iter().find(|other| {
        let pair = [rule.clone(), other.clone()];
        let pair: Vec<&Rule> = pair.iter().collect();
        other.name != rule.name && explodes(worst(&pair, &[], ALONE).growth)
    });
    found.map(|other| other.name)
}

fn always() -> Vec<Rule> {
    let order = RuleSet::named("commutativity").expect("commutativity ships");
    let signs = RuleSet::named("signs").expect("the rules of signs ship");
    let shortens = |rule: &Rule| !rule.both_ways && rule.right.nodes.len() < rule.left.nodes.len();
    let signs = signs.rules.into_iter().filter(shortens);
    order.rules.into_iter().chain(signs).collect()
}

/// The pairs among some rules and others that grow exponentially or without
/// end although none of the two does alone, in order of the rules.
/// `progress` is called with pairs done and all.
pub fn pairs(
    rules: &[&Rule],
    others: &[&Rule],
    progress: &mut dyn FnMut(usize, usize),
) -> Vec<PairGrowth> {
    let always = always();
    let calm = |rule: &&&Rule| {
        let growing = worst(&[rule], &always, ALONE);
        // What adds nothing to any family blows nothing up.
        growing.growth != Growth::Constant && !explodes(growing.growth)
    };
    let firsts: Vec<&&Rule> = rules.iter().filter(calm).collect();
    let seconds: Vec<&&Rule> = others.iter().filter(calm).collect();
    let mut found = Vec::new();
    let total = firsts.len() * seconds.len();
    for (done, (i, j)) in (0..firsts.len())
        .flat_map(|i| (0..seconds.len()).map(move |j| (i, j)))
        .enumerate()
    {
        progress(done, total);
        let (one, other) = (firsts[i], seconds[j]);
        // A pair of two of the first ones is met twice.
        let again = firsts[..i].iter().any(|first| first.name == other.name);
        if one.name == other.name || again {
            continue;
        }
        let growing = worst(&[one, other], &always, ALONE);
        if explodes(growing.growth) {
            found.push(PairGrowth {
                names: [one.name.clone(), other.name.clone()],
                growing,
            });
        }
    }
    found
}

fn explodes(growth: Growth) -> bool {
    matches!(growth, Growth::Exponential(_) | Growth::Endless)
}

/// The worst growth over all families, with some rules beside.
fn worst(rules: &[&Rule], beside: &[Rule], budget: GraphBudget) -> Growing {
    // A rule that is always on is compared with the others.
    let is_new = |rule: &&Rule| !rules.iter().any(|known| known.left == rule.left);
    let beside: Vec<&Rule> = beside.iter().filter(is_new).collect();
    let all = beside.iter().chain(rules).copied();
    let rewrites: Vec<Rewrite<GraphTerm, ()>> = all.flat_map(rewrites).collect();
    let base: Vec<Rewrite<GraphTerm, ()>> = beside.into_iter().flat_map(self::rewrites).collect();
    let mut families = TermFamily::FIXED.to_vec();
    families.extend(rules.iter().map(|rule| TermFamily::Nested(&rule.name)));
    let mut worst: Option<Growing> = None;
    for family in families {
        let found = on_family(family, rules, (&rewrites, &base), budget);
        let Some(found) = found else { continue };
        let worse = worst
            .as_ref()
            .is_none_or(|worst| rank(found.growth) > rank(worst.growth));
        if worse {
            worst = Some(found);
        }
    }
    worst.unwrap_or(Growing {
        growth: Growth::Constant,
        exact: true,
        formula: String::new(),
        family: String::new(),
    })
}

/// An order of growths.
fn rank(growth: Growth) -> (u32, f64) {
    match growth {
        Growth::Constant => (0, 0.0),
        Growth::Polynomial(degree) => (1, f64::from(degree)),
        Growth::Exponential(base) => (2, base),
        Growth::Endless => (3, 0.0),
    }
}

/// Rules in the form of the e-graph.
type GraphRewrites = [Rewrite<GraphTerm, ()>];

/// The growth on a family; `None` when the rules add no forms to it.
fn on_family(
    family: TermFamily<'_>,
    rules: &[&Rule],
    (rewrites, base): (&GraphRewrites, &GraphRewrites),
    budget: GraphBudget,
) -> Option<Growing> {
    let mut points: Vec<(u32, u64)> = Vec::new();
    let mut adds = false;
    for size in SIZES {
        let start = [term(&family.term(size, rules))];
        let grown = grow(&start, rewrites, budget);
        if !grown.saturated {
            // Small terms that never end, or large ones that are too large.
            if points.len() < 3 && grown.graph.total_number_of_nodes() < budget.nodes {
                return Some(endless(family, "still growing after all iterations"));
            }
            if points.len() < 3 {
                return Some(endless(family, "more nodes than the budget"));
            }
            break;
        }
        let nodes = grown.graph.total_number_of_nodes() as u64;
        points.push((size, nodes));
        if !adds && size >= 2 {
            let bare = grow(&start, base, budget);
            adds = bare.graph.total_number_of_nodes() as u64 != nodes
                || bare.graph.number_of_classes() != grown.graph.number_of_classes();
        }
        if size >= 3 && !adds {
            return None;
        }
    }
    // The smallest terms have none of the structure of the others.
    let tail = &points[1..];
    let fitted = formula(tail).or_else(|| formula(&points[2..]));
    let exact = fitted.is_some();
    let (growth, formula) = match fitted {
        Some(found) => found,
        None => {
            let numbers: Vec<String> = tail.iter().map(|(_, nodes)| nodes.to_string()).collect();
            (estimate(tail), numbers.join(", "))
        }
    };
    Some(Growing {
        growth,
        exact,
        formula,
        family: family.name(),
    })
}

fn endless(family: TermFamily<'_>, formula: &str) -> Growing {
    Growing {
        growth: Growth::Endless,
        exact: true,
        formula: formula.to_owned(),
        family: family.name(),
    }
}
