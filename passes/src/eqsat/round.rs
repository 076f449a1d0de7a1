//! One round over a function: windows in program order, each with the times
//! that the windows before it have reached.

use super::alternatives::{Alternatives, RequiredResult, SurroundingTimes};
use super::extract::{Cover, extract};
use super::graph::{EquivalenceGraph, FormMaker};
use super::pattern::BagRule;
use super::plain::{self, PlainRule};
use super::saturate::{SaturationEnd, SaturationLimits, saturate};
use super::window::{RewriteWindow, Surroundings, is_one_bag};
use robovec_analysis::critical_path::{Weights, arrivals, tails};
use robovec_ir::{Function, Value};

pub(crate) struct Settings<'a> {
    pub(crate) rules: &'a [BagRule],
    /// Instead: associativity and commutativity by rule.
    pub(crate) plain: Option<&'a [PlainRule]>,
    pub(crate) weights: &'a Weights,
    /// Operations per window.
    pub(crate) size: usize,
    /// The limits of one window.
    pub(crate) limits: SaturationLimits,
    /// Sines and cosines lie on the circle.
    pub(crate) trig: bool,
    /// True when the rules that made each form are recorded.
    pub(crate) trail: bool,
}

/// The budget that is left.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct RoundBudget {
    /// Forms made in all windows together.
    pub(crate) nodes: usize,
    /// Operations the function may have more than now.
    pub(crate) operations: i64,
}

/// A window that is rewritten.
pub(crate) struct Rewriting {
    pub(crate) root: Value,
    pub(crate) window: RewriteWindow,
    pub(crate) alternatives: Alternatives,
    pub(crate) class: u32,
    pub(crate) cover: Cover,
    /// The maker of the chosen form of each class of the cover, in its order;
    /// empty without a trail.
    pub(crate) makers: Vec<Option<FormMaker>>,
}

/// The result of a round.
#[derive(Default)]
pub(crate) struct RewritingRound {
    /// In program order of their roots.
    pub(crate) rewritings: Vec<Rewriting>,
    /// Windows considered.
    pub(crate) windows: u64,
    /// Of them those whose e-graph had no room for more forms.
    pub(crate) out_of_nodes: u64,
    /// Number of those whose rounds of rules were used up.
    pub(crate) out_of_iterations: u64,
    /// Forms made.
    pub(crate) nodes: usize,
}

/// Searches for windows whose results are too late for a target, and rewrites
/// those that can be earlier.
pub(crate) fn run(
    function: &Function,
    settings: &Settings<'_>,
    target: u32,
    budget: &mut RoundBudget,
) -> RewritingRound {
    let tails = tails(function, settings.weights);
    let uses = function.use_counts();
    let absorbed = absorbed(function, &uses);
    let late = late(function, &tails, settings.weights, target, &absorbed);
    // Every window gets its share: what the windows at one end of a chain
    // gain is worth nothing without those at the other.
    let share = budget.nodes / late.max(1);
    if share < SMALLEST {
        return RewritingRound::default();
    }
    let limits = SaturationLimits {
        nodes: settings.limits.nodes.min(share),
        ..settings.limits
    };
    let mut times: Vec<u32> = Vec::with_capacity(function.nodes().len());
    let mut round = RewritingRound::default();
    for (value, node) in function.values() {
        let ready = node.operands().iter();
        let ready = ready.map(|operand| operand.entry_or_default(&times));
        let ready = ready.fold(0, u32::max);
        let time = ready.saturating_add(settings.weights.of(node.operation));
        times.push(time);
        let late = time.saturating_add(tails[value.index()]) > target;
        if !late || absorbed[value.index()] || budget.nodes == 0 {
            continue;
        }
        let around = Surroundings {
            function,
            times: &times,
            uses: &uses,
            trig: settings.trig,
            plain: settings.plain.is_some(),
        };
        let required = target.saturating_sub(tails[value.index()]);
        round.windows += 1;
        let tried = rewrite(
            &around,
            settings,
            limits,
            value,
            required,
            budget.operations,
        );
        budget.nodes = budget.nodes.saturating_sub(tried.nodes);
        round.nodes += tried.nodes;
        round.out_of_nodes += u64::from(tried.end == SaturationEnd::Nodes);
        round.out_of_iterations += u64::from(tried.end == SaturationEnd::Iterations);
        if let Some(rewriting) = tried.found {
            budget.operations -=
                i64::from(rewriting.cover.operations) - i64::from(rewriting.window.own);
            times[value.index()] = rewriting.cover.arrivals[0];
            round.rewritings.push(rewriting);
        }
    }
    round
}

/// Number of forms below which a window is skipped.
const SMALLEST: usize = 60;

/// The largest number of windows.
fn late(
    function: &Function,
    tails: &[u32],
    weights: &Weights,
    target: u32,
    absorbed: &[bool],
) -> usize {
    let times = arrivals(function, weights);
    let late = |&place: &usize| !absorbed[place] && times[place] + tails[place] > target;
    (0..times.len()).filter(late).count()
}

/// For each value whether it is inside a bag of its only user.
fn absorbed(function: &Function, uses: &[u32]) -> Vec<bool> {
    let mut absorbed = vec![false; function.nodes().len()];
    for node in function.nodes() {
        for operand in node.operands().iter().filter_map(|operand| operand.value()) {
            if uses[operand.index()] == 1 {
                let inner = function.node(operand).operation;
                absorbed[operand.index()] = is_one_bag(inner, node.operation);
            }
        }
    }
    absorbed
}

/// Outcome of one window.
struct TriedWindow {
    nodes: usize,
    end: SaturationEnd,
    found: Option<Rewriting>,
}

fn rewrite(
    around: &Surroundings<'_>,
    settings: &Settings<'_>,
    limits: SaturationLimits,
    root: Value,
    required: u32,
    room: i64,
) -> TriedWindow {
    let interior = RewriteWindow::grow(around, root, settings.size);
    if interior.len() < 2 {
        return TriedWindow {
            nodes: 0,
            end: SaturationEnd::Complete,
            found: None,
        };
    }
    let mut graph = EquivalenceGraph::new();
    let (window, class) = RewriteWindow::enter(around, interior, &mut graph);
    let end = match settings.plain {
        None => saturate(&mut graph, settings.rules, limits),
        Some(rules) => {
            let (saturated, end) = plain::saturate(graph.egraph, rules, limits);
            graph = saturated.into();
            end
        }
    };
    let (alternatives, classes) = Alternatives::of(&graph, &[class]);
    let times = SurroundingTimes {
        weights: settings.weights,
        leaves: &window.times,
    };
    let before = around.times[root.index()];
    let demand = RequiredResult {
        class: classes[0],
        required,
    };
    let tried = |found| TriedWindow {
        nodes: graph.size(),
        end,
        found,
    };
    let Some(cover) = extract(&alternatives, times, &[demand]) else {
        return tried(None);
    };
    let growth = i64::from(cover.operations) - i64::from(window.own);
    let gain = before.saturating_sub(cover.arrivals[0]);
    if gain == 0 || growth > room.max(0) {
        return tried(None);
    }
    let makers = if settings.trail {
        makers(&graph, &alternatives, &cover)
    } else {
        Vec::new()
    };
    tried(Some(Rewriting {
        root,
        window,
        alternatives,
        class: classes[0],
        cover,
        makers,
    }))
}

fn makers(
    graph: &EquivalenceGraph,
    alternatives: &Alternatives,
    cover: &Cover,
) -> Vec<Option<FormMaker>> {
    let chosen = cover.order.iter().map(|&class| {
        let index = cover.choice[class as usize] as usize;
        let form = alternatives.origins[class as usize][index].as_ref();
        form.and_then(|form| graph.maker_of(form))
    });
    chosen.collect()
}
