//! Growing an e-graph by rules and by the steps for bags.

use super::form::{ClassReference, EquivalentForm, terms};
use super::graph::{EquivalenceGraph, FormMaker};
use super::matching::{Matcher, RuleMatch, VariableBinding};
use super::pattern::{Bag, BagRule, SignedPattern};
use egg::{Id, Language};

/// The limits of saturation. Everything is counted in work, so that results
/// do not depend on the speed of the machine.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct SaturationLimits {
    /// Forms made.
    pub(crate) nodes: usize,
    /// Rounds of matching and applying.
    pub(crate) iterations: u32,
    /// Steps of matching, per rule and round.
    pub(crate) steps: u32,
}

/// The steps that are no rules, by which rules match inside bags.
pub(crate) const STRUCTURE: [&str; 3] = ["normal form", "flattening", "shared part"];

/// Reason why an e-graph grew no further.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum SaturationEnd {
    /// No new form exists.
    Complete,
    /// There was no room for more forms.
    Nodes,
    /// The rounds were used up.
    Iterations,
}

/// Grows the e-graph until no new form is found or a limit is met.
pub(crate) fn saturate(
    graph: &mut EquivalenceGraph,
    rules: &[BagRule],
    limits: SaturationLimits,
) -> SaturationEnd {
    for _ in 0..limits.iterations {
        let before = (graph.size(), graph.egraph.number_of_classes());
        let classes = graph.classes();
        let mut found: Vec<(usize, Vec<RuleMatch>)> = Vec::new();
        for (index, rule) in rules.iter().enumerate() {
            let matcher = Matcher::new(graph, rule.variables, limits.steps);
            let (matches, _) = matcher.run(&rule.left, &classes);
            found.push((index, matches));
        }
        let structure = StructuralForms::find(graph, &classes, limits.steps as usize);
        let mut room = true;
        let first = rules.len() as FormMaker;
        room &= structure.apply(graph, first, limits.nodes);
        // In turns, so that no rule uses up the room of the others.
        let lengths = found.iter().map(|(_, matches)| matches.len());
        'all: for turn in 0..lengths.fold(0, usize::max) {
            for (index, matches) in &found {
                let Some(found) = matches.get(turn) else {
                    continue;
                };
                if graph.size() >= limits.nodes {
                    room = false;
                    break 'all;
                }
                graph.maker = Some(*index as FormMaker);
                apply(graph, &rules[*index], found);
            }
        }
        graph.maker = Some(first);
        graph.egraph.rebuild();
        if !room {
            return SaturationEnd::Nodes;
        }
        if before == (graph.size(), graph.egraph.number_of_classes()) {
            return SaturationEnd::Complete;
        }
    }
    SaturationEnd::Iterations
}

/// True when the operands of the variables are known to meet the conditions.
fn is_allowed(graph: &EquivalenceGraph, rule: &BagRule, found: &RuleMatch) -> bool {
    rule.conditions.iter().all(|condition| {
        let bound = found.bindings[condition.variable as usize].as_ref();
        let Some(VariableBinding::Term(term)) = bound else {
            return false;
        };
        let number = graph.number_of(term.class);
        number.is_some_and(|magnitude| {
            let number = if term.negative { -magnitude } else { magnitude };
            condition.requirement.holds_for(number)
        })
    })
}

/// Writes the right side of a rule where its left side was found.
fn apply(graph: &mut EquivalenceGraph, rule: &BagRule, found: &RuleMatch) -> Option<()> {
    if !is_allowed(graph, rule, found) {
        return None;
    }
    let right = instantiate(graph, &rule.right, &found.bindings)?;
    let right = right.signed(found.negative);
    let whole = match rule.left.bag {
        Bag::Product(_) if !found.rest.is_empty() => {
            let mut factors = found.rest.clone();
            factors.push(right);
            graph.product(&factors)?
        }
        _ if !found.rest.is_empty() => {
            let mut summands = found.rest.clone();
            summands.push(right);
            graph.sum(&summands)?
        }
        _ => right,
    };
    graph.equate(found.class, whole);
    Some(())
}

/// The value of a pattern whose variables are bound.
fn instantiate(
    graph: &mut EquivalenceGraph,
    pattern: &SignedPattern,
    bound: &[Option<VariableBinding>],
) -> Option<ClassReference> {
    let term = match &pattern.bag {
        Bag::Variable(variable) => match bound[*variable as usize].as_ref()? {
            VariableBinding::Term(term) => *term,
            VariableBinding::Sum(summands) => graph.sum(summands)?,
            VariableBinding::Product(factors, negative) => {
                let factors: Vec<ClassReference> =
                    factors.iter().map(|&id| ClassReference::from(id)).collect();
                graph.product(&factors)?.signed(*negative)
            }
        },
        Bag::Number(bits) => graph.number(f64::from_bits(*bits)),
        Bag::Sum(summands) => {
            let mut values = Vec::with_capacity(summands.len());
            for summand in summands {
                values.push(instantiate(graph, summand, bound)?);
            }
            graph.sum(&values)?
        }
        Bag::Product(factors) => {
            let mut values = Vec::with_capacity(factors.len());
            for factor in factors {
                values.push(instantiate(graph, &factor.clone().into(), bound)?);
            }
            graph.product(&values)?
        }
        Bag::Other(operation, operands) => {
            let mut values = Vec::with_capacity(operands.len());
            for operand in operands {
                values.push(instantiate(graph, operand, bound)?);
            }
            graph.other(*operation, &values)
        }
    };
    Some(term.signed(pattern.negative))
}

/// Forms to be added: their class and their children.
#[derive(Default)]
struct StructuralForms {
    /// Sums and products whose normal form has changed.
    normal: Vec<(Id, EquivalentForm)>,
    sums: Vec<(Id, Vec<ClassReference>)>,
    products: Vec<(Id, Vec<Id>)>,
    /// A part of a sum, and the rest of it.
    shared_sums: Vec<(Id, Vec<ClassReference>, Vec<ClassReference>)>,
    shared_products: Vec<(Id, Vec<Id>, Vec<Id>)>,
}

impl StructuralForms {
    fn find(graph: &EquivalenceGraph, classes: &[Id], most: usize) -> StructuralForms {
        let mut structure = StructuralForms::default();
        let mut sums: Vec<(Id, Vec<ClassReference>)> = Vec::new();
        let mut products: Vec<(Id, Vec<Id>)> = Vec::new();
        for &class in classes {
            for form in graph.forms(class) {
                if !is_normal(graph, form) {
                    structure.normal.push((class, form.clone()));
                }
                match form {
                    EquivalentForm::Sum(signs, children) if children.len() > 1 => {
                        sums.push((class, terms(*signs, children).collect()));
                    }
                    EquivalentForm::Product(children) => products.push((class, children.to_vec())),
                    _ => {}
                }
            }
        }
        structure.flatten(graph, &sums, &products, most);
        structure.share(&sums, &products, most);
        structure
    }

    /// Sums of sums and products of products, as one.
    fn flatten(
        &mut self,
        graph: &EquivalenceGraph,
        sums: &[(Id, Vec<ClassReference>)],
        products: &[(Id, Vec<Id>)],
        most: usize,
    ) {
        for (class, summands) in sums {
            for (place, &term) in summands.iter().enumerate() {
                for inner in graph.sums(graph.find(term.class)) {
                    if self.sums.len() >= most {
                        break;
                    }
                    let mut flat = summands.clone();
                    flat.remove(place);
                    flat.extend(inner.iter().map(|inner| inner.signed(term.negative)));
                    self.sums.push((*class, flat));
                }
            }
        }
        for (class, factors) in products {
            for (place, &factor) in factors.iter().enumerate() {
                for form in graph.forms(graph.find(factor)) {
                    if let EquivalentForm::Product(inner) = form
                        && self.products.len() < most
                    {
                        let mut flat = factors.clone();
                        flat.remove(place);
                        flat.extend(inner.iter().copied());
                        self.products.push((*class, flat));
                    }
                }
            }
        }
    }

    /// Parts that two sums, or two products, have in common.
    fn share(
        &mut self,
        sums: &[(Id, Vec<ClassReference>)],
        products: &[(Id, Vec<Id>)],
        most: usize,
    ) {
        let mut steps = 0;
        for (index, (class, summands)) in sums.iter().enumerate() {
            for (other_class, others) in &sums[..index] {
                steps += 1;
                if steps > most {
                    break;
                }
                if class == other_class {
                    continue;
                }
                for turned in [false, true] {
                    let others: Vec<ClassReference> =
                        others.iter().map(|o| o.signed(turned)).collect();
                    let (part, rest, other_rest) = common(summands, &others);
                    if part.len() < 2 {
                        continue;
                    }
                    if !other_rest.is_empty() {
                        let back = |terms: &[ClassReference]| {
                            terms.iter().map(|t| t.signed(turned)).collect()
                        };
                        self.shared_sums
                            .push((*other_class, back(&part), back(&other_rest)));
                    }
                    if !rest.is_empty() {
                        self.shared_sums.push((*class, part, rest));
                    }
                }
            }
        }
        steps = 0;
        for (index, (class, factors)) in products.iter().enumerate() {
            for (other_class, others) in &products[..index] {
                steps += 1;
                if steps > most {
                    break;
                }
                let (part, rest, other_rest) = common(factors, others);
                if class == other_class || part.len() < 2 {
                    continue;
                }
                if !rest.is_empty() {
                    self.shared_products.push((*class, part.clone(), rest));
                }
                if !other_rest.is_empty() {
                    self.shared_products.push((*other_class, part, other_rest));
                }
            }
        }
    }

    /// Adds the forms found; false when the graph was full.
    fn apply(self, graph: &mut EquivalenceGraph, first: FormMaker, most: usize) -> bool {
        graph.maker = Some(first);
        for (class, form) in &self.normal {
            if let Some(term) = normalise(graph, form) {
                graph.equate(*class, term);
            }
        }
        graph.maker = Some(first + 2);
        for (class, part, mut rest) in self.shared_sums {
            if graph.size() >= most {
                return false;
            }
            if let Some(sum) = graph.sum(&part) {
                rest.push(sum);
                if let Some(sum) = graph.sum(&rest) {
                    graph.equate(class, sum);
                }
            }
        }
        for (class, part, rest) in self.shared_products {
            if graph.size() >= most {
                return false;
            }
            let part: Vec<ClassReference> = part.into_iter().map(ClassReference::from).collect();
            let mut rest: Vec<ClassReference> =
                rest.into_iter().map(ClassReference::from).collect();
            if let Some(product) = graph.product(&part) {
                rest.push(product);
                if let Some(product) = graph.product(&rest) {
                    graph.equate(class, product);
                }
            }
        }
        graph.maker = Some(first + 1);
        for (class, summands) in self.sums {
            if graph.size() >= most {
                return false;
            }
            if let Some(sum) = graph.sum(&summands) {
                graph.equate(class, sum);
            }
        }
        for (class, factors) in self.products {
            if graph.size() >= most {
                return false;
            }
            let factors: Vec<ClassReference> =
                factors.into_iter().map(ClassReference::from).collect();
            if let Some(product) = graph.product(&factors) {
                graph.equate(class, product);
            }
        }
        true
    }
}

/// True when unions have not disturbed the normal form.
fn is_normal(graph: &EquivalenceGraph, form: &EquivalentForm) -> bool {
    let children = form.children();
    let sorted = children.is_sorted();
    let plain = |&child: &Id| {
        let facts = graph.egraph[graph.find(child)].data;
        facts.minus.is_none()
            && match form {
                EquivalentForm::Sum(..) => facts.number.map(f64::from_bits) != Some(0.0),
                _ => facts
                    .number
                    .is_none_or(|bits| ![0.0, 1.0].contains(&f64::from_bits(bits))),
            }
    };
    match form {
        EquivalentForm::Sum(signs, _) if children.len() > 1 => {
            let opposite = terms(*signs, children)
                .collect::<Vec<ClassReference>>()
                .windows(2)
                .any(|pair| pair[0] == pair[1].negated());
            sorted && !opposite && children.iter().all(plain)
        }
        EquivalentForm::Product(_) => sorted && children.iter().all(plain),
        _ => true,
    }
}

fn normalise(graph: &mut EquivalenceGraph, form: &EquivalentForm) -> Option<ClassReference> {
    match form {
        EquivalentForm::Sum(signs, children) => {
            let summands: Vec<ClassReference> = terms(*signs, children).collect();
            graph.sum(&summands)
        }
        EquivalentForm::Product(children) => {
            let factors: Vec<ClassReference> = children
                .iter()
                .map(|&child| ClassReference::from(child))
                .collect();
            graph.product(&factors)
        }
        _ => None,
    }
}

/// The common part of two bags, and the rest of each.
fn common<T: Copy + PartialEq>(factors: &[T], others: &[T]) -> (Vec<T>, Vec<T>, Vec<T>) {
    let mut other_rest = others.to_vec();
    let (mut part, mut rest) = (Vec::new(), Vec::new());
    for &factor in factors {
        match other_rest.iter().position(|&other| other == factor) {
            Some(place) => {
                other_rest.remove(place);
                part.push(factor);
            }
            None => rest.push(factor),
        }
    }
    (part, rest, other_rest)
}
