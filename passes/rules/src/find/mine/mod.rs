//! Rules mined from functions.
//!
//! Left sides are the shapes that functions have: windows of a few operations,
//! on longest chains, or of which some operations would go with their root and
//! some leaf is there twice (without that, no term has fewer operations). For
//! the most frequent ones right sides are looked for that have fewer operations
//! than would go, or are earlier with the times that the leaves have at the
//! places where the shape was met. Results that differ from earlier ones only
//! in the order of operands are left out.

mod shape;
mod solve;
mod window;

use super::super::RuleSet;
use super::super::graph::GraphBudget;
use super::super::pattern::{Pattern, PatternNode};
use super::super::profile::{earliest_of, operations};
use super::enumerate::RuleCandidate;
use super::normal::normal;
use super::rank::Timed;
use super::{Letters, RuleSearch, Sieve};
use hashbrown::{HashMap, HashSet};
use robovec_analysis::critical_path::Weights;
use robovec_ir::{Function, Machine, Operand, Value};
use shape::{VARIABLES, WindowTerm};
use solve::RightSides;

/// Space of mining.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct MiningSpace {
    /// Operations of a window, at most.
    pub window: usize,
    /// Maximum number of shapes for which right sides are searched, the most
    /// frequent ones: this number to save operations, and the same number to
    /// shorten chains.
    pub shapes: usize,
    /// Values looked up for one shape, at most.
    pub work: usize,
}

/// The outcome of mining.
#[derive(Clone, PartialEq, Debug)]
pub struct MinedRules {
    /// Windows considered.
    pub windows: usize,
    /// False when a value had more windows than are considered.
    pub all_windows: bool,
    /// Different shapes of windows that could be rewritten with a gain.
    pub shapes: usize,
    /// The rules; `tried` is the number of values looked up, `different` the
    /// number of shapes for which right sides were searched.
    pub search: RuleSearch,
}

/// Operations of a window on a longest chain, at most: right sides have more.
const LATE_WINDOW: usize = 5;

/// Operations that a right side may have more, to be earlier.
const GROWTH: i64 = 2;

/// Times at which the leaves of one shape come that are considered.
const PROFILES: usize = 4;

/// Places below which a shape is of no interest.
const PLACES: u64 = 2;

/// Reads of a value inside a window that is no part of a longest chain.
const READS: u32 = 2;

/// The limits of a derivation. Sides are larger than those of enumerated
/// terms, and so are the graphs.
const DERIVATION: GraphBudget = GraphBudget {
    nodes: 2_000,
    iterations: 6,
};

/// A shape and where it was met.
struct MinedShape {
    pattern: Pattern,
    /// Operations that would go, at most and over all places.
    freed: i64,
    all_freed: u64,
    /// Places where operations would go.
    places: u64,
    /// Places on longest chains.
    late_places: u64,
    /// Times of its variables and its angle, at some of these.
    profiles: Vec<Vec<i64>>,
}

/// Mines rules from functions at the atomic level and ranks them by their gain
/// on others. `progress` is called with shapes and candidates done and all.
pub fn mine(
    space: MiningSpace,
    known: &RuleSet,
    from: &[&Function],
    on: &[&Function],
    machine: &Machine,
    progress: &mut dyn FnMut(usize, usize),
) -> MinedRules {
    let weights = Weights::cycles(machine);
    let mut gathered = Gathered::default();
    for function in from {
        gathered.function(&Timed::new(function, &weights), space.window);
    }
    let shapes = gathered.shapes.len();
    let chosen = gathered.chosen(space.shapes);
    let mut solver = ShapeSolver {
        weights: &weights,
        work: space.work,
        right_sides: RightSides::default(),
        candidates: Vec::new(),
        texts: HashSet::new(),
        looked_up: 0,
        complete: true,
    };
    for (index, &(shape, late)) in chosen.iter().enumerate() {
        progress(index, chosen.len());
        if late {
            solver.earlier(&gathered.shapes[shape])
        } else {
            solver.fewer(&gathered.shapes[shape])
        }
    }
    let mut candidates = solver.candidates;
    candidates.sort_by_key(|candidate| candidate.left.nodes.len() + candidate.right.nodes.len());
    let count = candidates.len();
    let sieve = Sieve {
        known,
        derivation: DERIVATION,
        letters: Letters {
            count: VARIABLES,
            angle: VARIABLES,
        },
    };
    let (found, derived) = sieve.keep(candidates, on, machine, progress);
    MinedRules {
        windows: gathered.windows,
        all_windows: gathered.all_windows,
        shapes,
        search: RuleSearch {
            tried: solver.looked_up,
            different: chosen.len(),
            complete: solver.complete && gathered.all_windows,
            candidates: count,
            derived,
            found,
        },
    }
}

/// All shapes so far.
struct Gathered {
    windows: usize,
    all_windows: bool,
    shapes: Vec<MinedShape>,
    /// By the bytes of the pattern.
    known: HashMap<Vec<u8>, usize>,
}

impl Default for Gathered {
    fn default() -> Gathered {
        Gathered {
            windows: 0,
            all_windows: true,
            shapes: Vec::new(),
            known: HashMap::new(),
        }
    }
}

impl Gathered {
    fn function(&mut self, timed: &Timed<'_>, largest: usize) {
        let function = timed.function;
        for (root, node) in function.values() {
            if !window::belongs(node.operation) || node.operation.arity() == 1 {
                continue;
            }
            let critical = timed.critical[root.index()];
            let eligible = |value: Value| critical || timed.uses[value.index()] <= READS;
            let all = window::each(function, root, largest, &eligible, &mut |window| {
                self.windows += 1;
                self.window(timed, window);
            });
            self.all_windows &= all;
        }
    }

    fn window(&mut self, timed: &Timed<'_>, window: &[Value]) {
        let freed = timed.freed(window).len() as i64;
        let late = timed.critical[window[0].index()] && window.len() <= LATE_WINDOW;
        if !late && (freed < 2 || !has_repeated_leaf(timed.function, window)) {
            return;
        }
        let Some(term) = WindowTerm::of(timed.function, window) else {
            return;
        };
        let saves = freed > fewest(&term.pattern);
        if !late && !saves {
            return;
        }
        let next = self.shapes.len();
        let place = *self.known.entry(bytes(&term.pattern)).or_insert(next);
        if place == next {
            self.shapes.push(MinedShape {
                pattern: term.pattern.clone(),
                freed: 0,
                all_freed: 0,
                places: 0,
                late_places: 0,
                profiles: Vec::new(),
            });
        }
        let shape = &mut self.shapes[place];
        if saves {
            shape.freed = shape.freed.max(freed);
            shape.all_freed += freed as u64;
            shape.places += 1;
        }
        if late {
            shape.late_places += 1;
            let profile = profile(&term, timed, window[0]);
            if shape.profiles.len() < PROFILES && !shape.profiles.contains(&profile) {
                shape.profiles.push(profile);
            }
        }
    }

    /// The shapes that are considered, and a flag for those to be made earlier:
    /// those with most removable operations, then those at most late places.
    fn chosen(&self, most: usize) -> Vec<(usize, bool)> {
        let mut chosen = Vec::new();
        for late in [false, true] {
            let weight = |shape: &MinedShape| {
                if late {
                    (shape.late_places, shape.late_places)
                } else {
                    (shape.places, shape.all_freed)
                }
            };
            let shapes = self.shapes.iter().enumerate();
            let mut ranked: Vec<(u64, usize)> = shapes
                .filter(|(_, shape)| weight(shape).0 >= PLACES)
                .map(|(index, shape)| (weight(shape).1, index))
                .collect();
            // Of equal ones the first.
            ranked.sort_by_key(|&(weight, _)| std::cmp::Reverse(weight));
            let kept = ranked.into_iter().take(most);
            chosen.extend(kept.map(|(_, index)| (index, late)));
        }
        chosen
    }
}

/// The pattern in a few bytes.
fn bytes(pattern: &Pattern) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(2 * pattern.nodes.len());
    for node in &pattern.nodes {
        match *node {
            PatternNode::Variable(variable) => bytes.extend([0, variable as u8]),
            PatternNode::Number(number) => {
                bytes.push(1);
                bytes.extend(number.to_bits().to_le_bytes());
            }
            // Operands are always the last terms before it.
            PatternNode::Operation(operation, _) => bytes.extend([2, operation as u8]),
        }
    }
    bytes
}

/// Tests whether some leaf could be there once instead of twice: an operand
/// that is in a window again, a number, or sine and cosine of one angle.
fn has_repeated_leaf(function: &Function, window: &[Value]) -> bool {
    let mut leaves: Vec<Operand> = Vec::with_capacity(window.len() + 1);
    for &value in window {
        for &operand in function.node(value).operands() {
            let inner = operand.value();
            if inner.is_some_and(|inner| window.contains(&inner)) {
                continue;
            }
            let turn = inner.map(|inner| function.node(inner));
            let turn = turn.filter(|node| node.operation.is_trigonometric());
            let leaf = turn.map_or(operand, |node| node.operands[0]);
            if operand.constant().is_some() || leaves.contains(&leaf) {
                return true;
            }
            leaves.push(leaf);
        }
    }
    false
}

/// Operations that every equal term has: a variable that occurs once cannot
/// vanish, but by a product with zero.
fn fewest(pattern: &Pattern) -> i64 {
    let mut count = [0u32; VARIABLES as usize + 1];
    for node in &pattern.nodes {
        if let PatternNode::Variable(variable) = node {
            count[*variable as usize] += 1;
        }
    }
    let single = count[..VARIABLES as usize].iter();
    (single.filter(|&&count| count == 1).count() as i64 - 1).max(0)
}

/// Times of the variables and the angle of a window, before its result.
fn profile(term: &WindowTerm, timed: &Timed<'_>, root: Value) -> Vec<i64> {
    let result = i64::from(timed.arrivals[root.index()]);
    let mut times = vec![-result; VARIABLES as usize + 1];
    let angle = term.angle.map(|angle| (VARIABLES as usize, angle));
    let variables = term.variables.iter().copied().enumerate();
    for (variable, operand) in variables.chain(angle) {
        if let Some(value) = operand.value() {
            times[variable] = i64::from(timed.arrivals[value.index()]) - result;
        }
    }
    times
}

/// Looks for right sides.
struct ShapeSolver<'a> {
    weights: &'a Weights,
    work: usize,
    right_sides: RightSides,
    candidates: Vec<RuleCandidate>,
    /// Both sides of the candidates in normal form.
    texts: HashSet<(String, String)>,
    looked_up: usize,
    complete: bool,
}

impl ShapeSolver<'_> {
    /// The right side with the fewest operations, if these are fewer than
    /// would go.
    fn fewer(&mut self, shape: &MinedShape) {
        let mut best: Option<(i64, Pattern)> = None;
        // One more at a time: each takes many times longer than the last.
        for operations_allowed in 1..shape.freed {
            let looked_up = self.right_sides.each(
                &shape.pattern,
                operations_allowed as usize,
                self.work,
                &mut |right| {
                    let count = operations(&right);
                    if count < shape.freed && best.as_ref().is_none_or(|best| count < best.0) {
                        best = Some((count, right));
                    }
                },
            );
            self.looked_up += looked_up;
            self.complete &= looked_up < self.work;
            if best.is_some() {
                break;
            }
        }
        if let Some((_, right)) = best {
            self.add(&shape.pattern, right);
        }
    }

    /// For each order of arrival of the variables, the right side with the
    /// earliest result, if it is earlier.
    fn earlier(&mut self, shape: &MinedShape) {
        let time = |side: &Pattern, profile: &[i64]| {
            let arrival = |variable: u32| Some(profile[variable as usize]);
            earliest_of(side, self.weights, &arrival).unwrap_or(i64::MIN)
        };
        let most = operations(&shape.pattern) + GROWTH;
        let mut best: Vec<(i64, i64, Option<Pattern>)> = shape
            .profiles
            .iter()
            .map(|profile| (time(&shape.pattern, profile).min(0), 0, None))
            .collect();
        let looked_up =
            self.right_sides
                .each(&shape.pattern, most as usize, self.work, &mut |right| {
                    let count = operations(&right);
                    if count > most {
                        return;
                    }
                    for (best, profile) in best.iter_mut().zip(&shape.profiles) {
                        let time = time(&right, profile);
                        if (time, count) < (best.0, best.1) {
                            *best = (time, count, Some(right.clone()));
                        }
                    }
                });
        self.looked_up += looked_up;
        self.complete &= looked_up < self.work;
        for (.., right) in best {
            if let Some(right) = right {
                self.add(&shape.pattern, right);
            }
        }
    }

    fn add(&mut self, left: &Pattern, right: Pattern) {
        let same: Vec<u32> = (0..=VARIABLES).collect();
        let texts = (normal(left, &same), normal(&right, &same));
        if texts.0 != texts.1 && self.texts.insert(texts) {
            self.candidates.push(RuleCandidate {
                left: left.clone(),
                right,
            });
        }
    }
}
