//! Derivation of one term from another by rules, with its steps.

use super::form::{ClassAnalysis, EquivalentForm};
use super::plain;
use super::saturate::{SaturationEnd, SaturationLimits};
use egg::{EGraph, FlatTerm, Id, Language, RecExpr};
use robovec_analysis::class::NumericClass;
use robovec_rules::{Pattern, PatternNode, RuleSet};

/// A step of a derivation: a rule, and the whole term after it.
#[derive(Clone, PartialEq, Debug)]
pub struct DerivationStep {
    /// The rule.
    pub rule: String,
    /// The rule was used from right to left.
    pub backwards: bool,
    /// The term it leads to.
    pub term: Pattern,
}

/// The outcome of looking for a derivation.
#[derive(Clone, PartialEq, Debug)]
pub enum Derivation {
    /// The steps from the left to the right term.
    Found(Vec<DerivationStep>),
    /// The right term was not reached.
    Nearest {
        /// Of the terms equal to the left one, that nearest to the right one:
        /// the fewest operations and values are different.
        term: Pattern,
        /// The steps that reached it.
        steps: Vec<DerivationStep>,
        /// Everything the rules lead to was reached; otherwise the budget
        /// ended first.
        complete: bool,
        /// Nodes in the graph of equal terms.
        nodes: usize,
    },
}

/// The limits of the search for a derivation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct DerivationEffort {
    /// Nodes in the graph of equal terms.
    pub nodes: usize,
    /// Maximum number of rounds in which all rules are applied.
    pub iterations: u32,
}

/// Looks for a derivation of one term from another by rules up to a class
/// and those of order, grouping, signs, zeros and ones, which are always on.
/// Variables represent the same values in both terms.
pub fn derive(
    left: &Pattern,
    right: &Pattern,
    rules: &RuleSet,
    weakest: NumericClass,
    effort: DerivationEffort,
) -> Derivation {
    let rules = plain::all(rules, weakest);
    let [from, to] = [left, right].map(|side| plain::term(side, EquivalentForm::Leaf, |form| form));
    let mut egraph = EGraph::new(ClassAnalysis).with_explanations_enabled();
    let (start, goal) = (egraph.add_expr(&from), egraph.add_expr(&to));
    egraph.rebuild();
    let mut complete = false;
    // Round by round: the fewer nodes, the shorter the explanation.
    for _ in 0..effort.iterations {
        if complete || egraph.find(start) == egraph.find(goal) {
            break;
        }
        let limits = SaturationLimits {
            nodes: effort.nodes,
            iterations: 1,
            steps: 0,
        };
        let before = (egraph.total_number_of_nodes(), egraph.number_of_classes());
        let end;
        (egraph, end) = plain::saturate(egraph, &rules, limits);
        let after = (egraph.total_number_of_nodes(), egraph.number_of_classes());
        complete = end == SaturationEnd::Complete;
        // Without room for a form rounds change nothing.
        if before == after {
            break;
        }
    }
    let nodes = egraph.total_number_of_nodes();
    if egraph.find(start) == egraph.find(goal) {
        return Derivation::Found(steps(&mut egraph, &from, &to));
    }
    let nearest = nearest(&egraph, start, &to);
    Derivation::Nearest {
        term: pattern(&nearest),
        steps: steps(&mut egraph, &from, &nearest),
        complete,
        nodes,
    }
}

fn pattern(term: &RecExpr<EquivalentForm>) -> Pattern {
    let mut pattern = Pattern::default();
    for form in term.as_ref() {
        match form {
            EquivalentForm::Leaf(variable) => pattern.push(PatternNode::Variable(*variable)),
            EquivalentForm::Number(bits) => {
                pattern.push(PatternNode::Number(f64::from_bits(*bits)))
            }
            EquivalentForm::Other(operation, children) => {
                let operands: Vec<u32> =
                    children.iter().map(|&id| usize::from(id) as u32).collect();
                pattern.operation(*operation, &operands)
            }
            // Plain terms hold no bags.
            EquivalentForm::Sum(..) | EquivalentForm::Product(_) => {
                pattern.push(PatternNode::Number(0.0))
            }
        };
    }
    pattern
}

fn steps(
    egraph: &mut EGraph<EquivalentForm, ClassAnalysis>,
    from: &RecExpr<EquivalentForm>,
    to: &RecExpr<EquivalentForm>,
) -> Vec<DerivationStep> {
    let mut explanation = egraph.explain_equivalence(from, to);
    let flat = explanation.make_flat_explanation();
    let steps = flat.iter().filter_map(|flat| {
        let (rule, backwards) = applied(flat)?;
        Some(DerivationStep {
            rule,
            backwards,
            term: pattern(&flat.get_recexpr()),
        })
    });
    steps.collect()
}

/// The rule that led to a term of an explanation: it is at the place in
/// the term where it was used.
fn applied(term: &FlatTerm<EquivalentForm>) -> Option<(String, bool)> {
    let mut open = vec![term];
    while let Some(term) = open.pop() {
        if let Some(rule) = term.forward_rule {
            return Some((rule.to_string(), false));
        }
        if let Some(rule) = term.backward_rule {
            return Some((rule.to_string(), true));
        }
        open.extend(&term.children);
    }
    None
}

/// The smallest term of every class, as the form of its root and its size.
fn smallest(
    egraph: &EGraph<EquivalentForm, ClassAnalysis>,
    classes: &[Id],
) -> Vec<Option<(usize, EquivalentForm)>> {
    let place = |id: Id| classes.binary_search(&egraph.find(id)).ok();
    let mut best: Vec<Option<(usize, EquivalentForm)>> = vec![None; classes.len()];
    loop {
        let mut changed = false;
        for (index, &class) in classes.iter().enumerate() {
            for form in &egraph[class].nodes {
                let size = form.children().iter().try_fold(1usize, |sum, &child| {
                    let (size, _) = best[place(child)?].as_ref()?;
                    Some(sum.saturating_add(*size))
                });
                if let Some(size) = size
                    && best[index].as_ref().is_none_or(|(known, _)| size < *known)
                {
                    best[index] = Some((size, form.clone()));
                    changed = true;
                }
            }
        }
        if !changed {
            return best;
        }
    }
}

/// The term of a class that has most in common with another term: for every
/// class and every part of that term, the fewest nodes that differ, part by
/// part from the leaves up.
fn nearest(
    egraph: &EGraph<EquivalentForm, ClassAnalysis>,
    start: Id,
    goal: &RecExpr<EquivalentForm>,
) -> RecExpr<EquivalentForm> {
    let mut classes: Vec<Id> = egraph.classes().map(|class| class.id).collect();
    classes.sort_unstable();
    let place = |id: Id| place_of(egraph, &classes, id);
    let smallest = smallest(egraph, &classes);
    let parts = goal.as_ref();
    // Per part and class the distance, and the form that has it; without a
    // form, the smallest term of the class stands against the part.
    let mut table: Vec<Vec<(usize, Option<EquivalentForm>)>> = Vec::with_capacity(parts.len());
    let mut sizes: Vec<usize> = Vec::with_capacity(parts.len());
    for part in parts {
        let size = 1 + part
            .children()
            .iter()
            .map(|&c| sizes[usize::from(c)])
            .sum::<usize>();
        let mut row = Vec::with_capacity(classes.len());
        for (index, &class) in classes.iter().enumerate() {
            let own = smallest[index]
                .as_ref()
                .map_or(usize::MAX / 4, |(own, _)| *own);
            let mut best = (own + size, None);
            for form in egraph[class].nodes.iter().filter(|form| form.matches(part)) {
                let pairs = form.children().iter().zip(part.children());
                let distance: usize = pairs
                    .map(|(&child, &goal)| table[usize::from(goal)][place(child)].0)
                    .sum();
                if distance < best.0 {
                    best = (distance, Some(form.clone()));
                }
            }
            row.push(best);
        }
        table.push(row);
        sizes.push(size);
    }
    let mut term = RecExpr::default();
    build(
        &DerivationTables {
            egraph,
            table: &table,
            smallest: &smallest,
            classes: &classes,
            parts,
        },
        start,
        Some(parts.len() - 1),
        &mut term,
    );
    term
}

struct DerivationTables<'a> {
    egraph: &'a EGraph<EquivalentForm, ClassAnalysis>,
    table: &'a [Vec<(usize, Option<EquivalentForm>)>],
    smallest: &'a [Option<(usize, EquivalentForm)>],
    classes: &'a [Id],
    parts: &'a [EquivalentForm],
}

/// The place of an id's class among the classes of its e-graph, in order.
fn place_of(egraph: &EGraph<EquivalentForm, ClassAnalysis>, classes: &[Id], id: Id) -> usize {
    let place = classes.binary_search(&egraph.find(id));
    place.expect("the classes are all of the e-graph")
}

/// Writes the chosen term. Depth is bounded by that of the goal and of the
/// smallest terms, and those by the size of a pattern.
fn build(
    tables: &DerivationTables<'_>,
    class: Id,
    part: Option<usize>,
    term: &mut RecExpr<EquivalentForm>,
) -> Id {
    let place = place_of(tables.egraph, tables.classes, class);
    let chosen = part.and_then(|part| Some((part, tables.table[part][place].1.as_ref()?)));
    let (form, goals) = match chosen {
        Some((part, form)) => (form.clone(), Some(tables.parts[part].children())),
        None => match &tables.smallest[place] {
            Some((_, form)) => (form.clone(), None),
            None => (EquivalentForm::Number(0), None),
        },
    };
    let mut written = form.clone();
    for (index, &child) in form.children().iter().enumerate() {
        let goal = goals.map(|goals| usize::from(goals[index]));
        written.children_mut()[index] = build(tables, child, goal, term);
    }
    term.add(written)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(question: &str, effort: DerivationEffort) -> Derivation {
        let text = format!("rule question: {question} class=real;");
        let set = RuleSet::parse(&text, "question.rules").expect("well formed");
        let rules = RuleSet::built_in();
        let rule = &set.rules[0];
        derive(&rule.left, &rule.right, &rules, NumericClass::Real, effort)
    }

    const EFFORT: DerivationEffort = DerivationEffort {
        nodes: 5_000,
        iterations: 8,
    };

    #[test]
    fn a_derivation_ends_at_the_goal() {
        let Derivation::Found(steps) = answer("x*a - b*x => x*(a - b)", EFFORT) else {
            panic!("derivable");
        };
        let last = steps.last().expect("not the same term");
        let names = ["x", "a", "b"].map(str::to_owned);
        assert_eq!(last.term.to_text(&names), "x*(a - b)");
        assert!(
            steps
                .iter()
                .any(|step| step.rule.contains("factor") || step.rule.contains("distribute"))
        );
    }

    #[test]
    fn the_budget_is_kept_and_its_end_is_not_completeness() {
        for nodes in [10, 50, 100] {
            let effort = DerivationEffort { nodes, ..EFFORT };
            let question = "a*x*x + b*x*y + c*x*z => x*(a*x + b*y + c*z)";
            let Derivation::Nearest {
                complete,
                nodes: made,
                ..
            } = answer(question, effort)
            else {
                panic!("there is no room for it");
            };
            // The two terms take 20 themselves.
            assert!(!complete && made <= nodes.max(20), "{made} of {nodes}");
        }
    }

    #[test]
    fn what_is_not_reached_has_a_nearest_term() {
        let Derivation::Nearest { term, .. } = answer("a*x + b => (a + b)*x", EFFORT) else {
            panic!("the sides are different functions");
        };
        let names = ["a", "x", "b"].map(str::to_owned);
        assert!(term.to_text(&names).contains('x'));
    }
}
