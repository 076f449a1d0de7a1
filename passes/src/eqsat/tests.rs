//! Proofs by test: bags against saturated associativity and commutativity,
//! and extraction against trying everything.

use super::alternatives::{Alternatives, RequiredResult, SurroundingTimes};
use super::exact::ExactExtractor;
use super::extract::extract;
use super::form::{ClassAnalysis, ClassReference, EquivalentForm};
use super::graph::EquivalenceGraph;
use super::pattern::BagRule;
use super::plain;
use super::saturate::{SaturationEnd, SaturationLimits, saturate};
use crate::reassociate::{TreeShape, reassociate};
use crate::sums::groups::GroupReach;
use egg::{EGraph, Id};
use robovec_analysis::class::NumericClass;
use robovec_analysis::critical_path::{Weights, arrivals};
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_ir::{
    Function, Input, Level, Machine, Name, Node, Operand, Operation, Output, Shape, SourceSet,
    Tables,
};
use robovec_num::random::Random;
use robovec_rules::RuleSet;

fn below(random: &mut Random, bound: u32) -> u32 {
    random.below(bound as usize) as u32
}

fn thesis() -> Weights {
    Weights::cycles(&Machine::built_in("thesis").expect("it ships"))
}

/// A random signed expression, as a function and as a plain term.
struct Case {
    function: Function,
    tables: Tables,
    egraph: EGraph<EquivalentForm, ClassAnalysis>,
    leaves: Vec<(Operand, Id)>,
    times: Vec<u32>,
}

impl Case {
    /// Leaves that arrive after 0 to 8 multiplications; each is an output
    /// too, so that it stays a leaf for `balance`.
    fn new(count: u32, random: &mut Random) -> Case {
        let mut case = Case {
            function: Function::new("case", Level::Atomic),
            tables: Tables::default(),
            egraph: EGraph::new(ClassAnalysis),
            leaves: Vec::new(),
            times: Vec::new(),
        };
        let symbols = &mut case.tables.symbols;
        let (x, o) = (symbols.intern("x"), symbols.intern("o"));
        case.function.add_input(x, Shape::Vector(count));
        case.function.add_output(o, Shape::Vector(count + 1));
        for leaf in 0..count {
            let mut operand = Operand::from(Input(leaf));
            let squares = below(random, 9);
            for _ in 0..squares {
                operand = case.push(Operation::Mul, [operand, operand]);
            }
            case.assign(leaf, operand);
            let id = case.egraph.add(EquivalentForm::Leaf(leaf));
            case.leaves.push((operand, id));
            case.times.push(7 * squares);
        }
        case
    }

    fn push(&mut self, operation: Operation, operands: [Operand; 2]) -> Operand {
        let base = self.tables.symbols.intern("v");
        let name = Name {
            base,
            suffix: self.function.nodes().len() as u32 + 1,
        };
        let value = self.function.push(Node {
            name,
            sources: SourceSet::EMPTY,
            operands: Operand::list(operands),
            operation,
        });
        value.into()
    }

    fn assign(&mut self, output: u32, operand: Operand) {
        self.function
            .assign(Output(output), operand, SourceSet::EMPTY);
    }

    fn operation(
        &mut self,
        operation: Operation,
        a: (Operand, Id),
        b: (Operand, Id),
    ) -> (Operand, Id) {
        let operand = self.push(operation, [a.0, b.0]);
        let id = self
            .egraph
            .add(EquivalentForm::Other(operation, [a.1, b.1].into()));
        (operand, id)
    }

    /// A random tree over these leaves, each used once.
    fn tree(&mut self, leaves: &[(Operand, Id)], random: &mut Random) -> (Operand, Id) {
        let tree = if let [leaf] = leaves {
            *leaf
        } else {
            let (left, right) =
                leaves.split_at(1 + below(random, leaves.len() as u32 - 1) as usize);
            let operation = match below(random, 8) {
                0..=2 => Operation::Add,
                3..=5 => Operation::Sub,
                _ => Operation::Mul,
            };
            let (left, right) = (self.tree(left, random), self.tree(right, random));
            self.operation(operation, left, right)
        };
        if below(random, 6) > 0 {
            return tree;
        }
        let zero = Operand::from(self.function.constant(0.0));
        let zero = (zero, self.egraph.add(EquivalentForm::Number(0)));
        self.operation(Operation::Sub, zero, tree)
    }
}

/// Time of the result of `balance`, and of the best of all trees; `None` when
/// there were too many trees.
fn both(case: Case, result: (Operand, Id), weights: &Weights) -> Option<(u32, u32)> {
    let Case {
        mut function,
        mut tables,
        egraph,
        times,
        leaves,
    } = case;
    function.assign(Output(leaves.len() as u32), result.0, SourceSet::EMPTY);
    let mut balanced = function;
    let rewrites = &RewriteLimit::default();
    for (reach, shape) in [
        (GroupReach::Operation, TreeShape::Written),
        (GroupReach::Maximal, TreeShape::Earliest),
    ] {
        balanced = reassociate(&balanced, &mut tables, weights, reach, shape, rewrites);
    }
    let last = balanced.assignments.last().expect("just pushed").operand;
    let merged = last
        .value()
        .map_or(0, |value| arrivals(&balanced, weights)[value.index()]);
    let limits = SaturationLimits {
        nodes: 30_000,
        iterations: 40,
        steps: 0,
    };
    let (egraph, end) = plain::saturate(egraph, &plain::structural(), limits);
    if end != SaturationEnd::Complete {
        return None;
    }
    let graph = EquivalenceGraph::from(egraph);
    let (alternatives, roots) = Alternatives::of(&graph, &[result.1]);
    let times = SurroundingTimes {
        weights,
        leaves: &times,
    };
    let demand = RequiredResult {
        class: roots[0],
        required: 0,
    };
    let cover = extract(&alternatives, times, &[demand]).expect("it ends in leaves");
    Some((merged, cover.arrivals[0]))
}

/// Merging the two earliest first is as early as the best of all orders and
/// parentheses, with signs, zeros and arrival times.
#[test]
fn balance_is_the_optimum_of_saturated_ac() {
    let weights = thesis();
    let mut random = Random::new(1);
    let (mut proved, mut unfinished) = (0, 0);
    for round in 0..3000 {
        let count = 2 + round % 5;
        let mut case = Case::new(count, &mut random);
        let leaves = case.leaves.clone();
        let result = case.tree(&leaves, &mut random);
        let text = format!("round {round}: {:?}", case.function.nodes());
        match both(case, result, &weights) {
            Some((merged, best)) => {
                assert_eq!(merged, best, "{text}");
                proved += 1;
            }
            None => unfinished += 1,
        }
    }
    println!("{proved} equal to the optimum of saturated AC, {unfinished} not saturated");
    assert!(proved >= 2500, "only {proved} saturated");
}

/// Distribution and factoring.
fn distribution() -> Vec<BagRule> {
    let text = "rule distribute: a*(b + c) <=> a*b + a*c class=real;";
    let rules = RuleSet::parse(text, "distribution.rules").expect("well formed");
    BagRule::all(&rules, NumericClass::Real)
}

/// A random e-graph with one to three results, saturated by distribution and
/// factoring within limits.
fn random_graph(
    operations: u32,
    nodes: usize,
    random: &mut Random,
) -> (EquivalenceGraph, Vec<Id>, Vec<u32>) {
    let mut graph = EquivalenceGraph::new();
    let mut times = Vec::new();
    let mut terms: Vec<ClassReference> = Vec::new();
    for leaf in 0..3 + below(random, 3) {
        terms.push(graph.leaf(leaf).into());
        times.push(below(random, 40));
    }
    for _ in 0..operations {
        let pick = |random: &mut Random| {
            let place = below(random, terms.len() as u32) as usize;
            terms[place].signed(below(random, 4) == 0)
        };
        let chosen = [pick(random), pick(random), pick(random)];
        let chosen = &chosen[..2 + below(random, 2) as usize];
        let made = match below(random, 2) {
            0 => graph.sum(chosen),
            _ => graph.product(chosen),
        };
        terms.extend(made);
    }
    let results = 1 + below(random, 3) as usize;
    let roots: Vec<Id> = terms
        .iter()
        .rev()
        .take(results)
        .map(|&term| graph.value(term))
        .collect();
    graph.egraph.rebuild();
    let limits = SaturationLimits {
        nodes,
        iterations: 3,
        steps: 300,
    };
    saturate(&mut graph, &distribution(), limits);
    (graph, roots, times)
}

/// Demands on classes: as early as possible, or some time later.
fn demands(
    alternatives: &Alternatives,
    times: SurroundingTimes<'_>,
    classes: &[u32],
    random: &mut Random,
) -> Vec<RequiredResult> {
    let mut demands: Vec<RequiredResult> = classes
        .iter()
        .map(|&class| RequiredResult { class, required: 0 })
        .collect();
    let earliest = extract(alternatives, times, &demands).expect("it ends in leaves");
    for (demand, arrival) in demands.iter_mut().zip(&earliest.arrivals) {
        demand.required = arrival + [0, 7, 20, 100][below(random, 4) as usize];
    }
    demands
}

/// Extracts from a random e-graph; gives the operations found, the fewest there
/// are, and the number of classes. `None` when a complete search takes too
/// long.
fn gap(operations: u32, nodes: usize, random: &mut Random) -> Option<(u32, u32, Alternatives)> {
    let weights = thesis();
    let (graph, roots, times) = random_graph(operations, nodes, random);
    let (alternatives, places) = Alternatives::of(&graph, &roots);
    let times = SurroundingTimes {
        weights: &weights,
        leaves: &times,
    };
    let demands = demands(&alternatives, times, &places, random);
    let cover = extract(&alternatives, times, &demands).expect("it ends in leaves");
    for (demand, &arrival) in demands.iter().zip(&cover.arrivals) {
        assert!(arrival <= demand.required);
    }
    let (fewer, complete) =
        ExactExtractor::search(&alternatives, times, &demands, cover.operations, 300_000);
    let fewest = match fewer {
        Some(choice) => count(&alternatives, &demands, &choice),
        None => cover.operations,
    };
    complete.then_some((cover.operations, fewest, alternatives))
}

/// The operations of a choice, each class once.
fn count(alternatives: &Alternatives, demands: &[RequiredResult], choice: &[u32]) -> u32 {
    let mut open: Vec<u32> = demands.iter().map(|demand| demand.class).collect();
    let mut seen = vec![false; choice.len()];
    let mut operations = 0;
    while let Some(class) = open.pop() {
        if !std::mem::replace(&mut seen[class as usize], true) {
            let form = &alternatives.classes[class as usize][choice[class as usize] as usize];
            operations += form.operations();
            open.extend(&form.children);
        }
    }
    operations
}

/// The fewest operations by going through every combination of forms, without
/// any bound; the solver that the search with bounds is compared with.
fn enumerate(
    alternatives: &Alternatives,
    times: SurroundingTimes<'_>,
    demands: &[RequiredResult],
) -> u32 {
    let mut choice = vec![0u32; alternatives.classes.len()];
    let mut fewest = u32::MAX;
    loop {
        let mut arrivals: Vec<Option<u32>> = vec![None; choice.len()];
        for _ in 0..choice.len() {
            for class in 0..choice.len() {
                let form = &alternatives.classes[class][choice[class] as usize];
                let known: Option<Vec<u32>> = form
                    .children
                    .iter()
                    .map(|&child| arrivals[child as usize])
                    .collect();
                arrivals[class] = known.map(|known| form.arrival_of(&times, &known));
            }
        }
        if demands.iter().all(|demand| {
            arrivals[demand.class as usize].is_some_and(|arrival| arrival <= demand.required)
        }) {
            fewest = fewest.min(count(alternatives, demands, &choice));
        }
        // The next combination, as a counter counts.
        let Some(place) = (0..choice.len())
            .find(|&place| (choice[place] as usize) + 1 < alternatives.classes[place].len())
        else {
            return fewest;
        };
        choice[place] += 1;
        choice[..place].fill(0);
    }
}

/// A case with its demands: the operations extracted, and the fewest.
#[test]
fn extraction_equals_every_combination_of_small_graphs() {
    let weights = thesis();
    let mut random = Random::new(4);
    let mut compared = 0;
    for round in 0..4000 {
        let (graph, roots, leaves) = random_graph(2 + round % 3, 30, &mut random);
        let (alternatives, places) = Alternatives::of(&graph, &roots);
        let combinations = alternatives
            .classes
            .iter()
            .try_fold(1u32, |product, forms| {
                product.checked_mul(forms.len() as u32)
            });
        if !(2..=3000).contains(&combinations.unwrap_or(u32::MAX)) {
            continue;
        }
        let times = SurroundingTimes {
            weights: &weights,
            leaves: &leaves,
        };
        let demands = demands(&alternatives, times, &places, &mut random);
        let cover = extract(&alternatives, times, &demands).expect("it ends in leaves");
        assert_eq!(
            cover.operations,
            enumerate(&alternatives, times, &demands),
            "round {round}"
        );
        compared += 1;
    }
    println!("{compared} extractions equal to the best of all combinations");
    assert!(compared >= 1000, "only {compared} graphs were small");
}

/// On larger e-graphs the search ends early; the loss is printed and bounded.
#[test]
fn the_gap_on_larger_graphs_is_small() {
    let mut random = Random::new(3);
    let (mut compared, mut exact, mut found_all, mut fewest_all, mut classes) = (0, 0, 0, 0, 0);
    for _ in 0..400 {
        if let Some((found, fewest, alternatives)) = gap(6, 120, &mut random) {
            compared += 1;
            exact += u32::from(found == fewest);
            found_all += found;
            fewest_all += fewest;
            classes += alternatives.classes.len();
        }
    }
    println!(
        "{exact} of {compared} exact, {found_all} operations where {fewest_all} suffice, \
         {} classes on average",
        classes / compared.max(1)
    );
    assert!(compared > 300);
    assert!(found_all * 100 <= fewest_all * 102);
}

#[test]
fn rules_that_make_what_cannot_be_placed_are_left_out() {
    let text = "rule angles: sin(a)*cos(b) + cos(a)*sin(b) => sin(a + b) class=real-trig;
                rule pythagoras: 1 - sin(a)*sin(a) => cos(a)*cos(a) class=real-trig;
                rule norm: a*a => sqrt(a*a)*sqrt(a*a);
                rule halves: a + b <=> (2*a + 2*b)/2;
                rule roots: sqrt(a*a) <=> sqrt(a)*sqrt(a);";
    let rules = RuleSet::parse(text, "own.rules").expect("well-formed rules");
    let left_out = |machine: &str| {
        let machine = Machine::built_in(machine).expect("it ships");
        super::placeable(&rules, &machine).1
    };
    assert_eq!(left_out("thesis"), ["angles", "norm", "halves"]);
    assert_eq!(left_out("solver"), ["angles", "norm"]);
}
