//! Choosing one form per class: the critical path first, then operations.
//!
//! Depth alone is easy: the earliest arrival of every class is found as
//! Dijkstra finds distances (Knuth 1977), and all classes can have theirs in
//! one cover. Operations are counted once however many results share them,
//! which makes their number hard to minimise. So the times the surroundings
//! need are kept as bounds, small fronts of (arrival, operations) are built
//! bottom up, a cover is chosen top down, and single choices are then changed
//! as long as the whole cover gets smaller. Everything is linear in the number
//! of alternatives: fronts have a fixed size, and changes a fixed budget. At
//! the end all covers are tried, as far as a fixed number of steps reaches.

use super::alternatives::{Alternatives, RequiredResult, SurroundingTimes};
use super::exact::ExactExtractor;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// One form for every class that is needed.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Cover {
    /// For each class its alternative; unneeded classes have one too, which has
    /// no meaning.
    pub(crate) choice: Vec<u32>,
    /// The classes needed, operands before their users.
    pub(crate) order: Vec<u32>,
    /// Time at which each demanded result is ready.
    pub(crate) arrivals: Vec<u32>,
    /// Operations, each counted once.
    pub(crate) operations: u32,
}

/// Points kept per class.
const FRONT: usize = 6;
/// The number of changes that may be tried per needed class and alternative.
const CHANGES: usize = 20_000;

/// Steps of the search at the end, which small e-graphs do not use up.
pub(crate) const SEARCH: u32 = 4000;

/// A class that cannot be computed.
const NEVER: u32 = u32::MAX;

/// The best cover that was found; `None` when a demanded class has no form
/// that ends in leaves.
pub(crate) fn extract(
    alternatives: &Alternatives,
    times: SurroundingTimes<'_>,
    demands: &[RequiredResult],
) -> Option<Cover> {
    let depth = Depth::find(alternatives, times);
    if demands
        .iter()
        .any(|demand| depth.arrivals[demand.class as usize] == NEVER)
    {
        return None;
    }
    let demands: Vec<RequiredResult> = demands
        .iter()
        .map(|&demand| RequiredResult {
            required: demand.required.max(depth.arrivals[demand.class as usize]),
            ..demand
        })
        .collect();
    let mut extractor = Extractor {
        alternatives,
        times,
        demands: &demands,
        fronts: Vec::new(),
        depth,
    };
    extractor.fronts = extractor.fronts();
    let first = extractor.depth.choice.clone();
    let top_down = extractor.top_down();
    let cheapest = extractor.cheapest();
    let mut best: Option<Cover> = None;
    for start in [top_down, first] {
        let Some(cover) = extractor.evaluate(&start) else {
            continue;
        };
        let cover = extractor.improve(cover, &cheapest);
        if best
            .as_ref()
            .is_none_or(|best| cover.operations < best.operations)
        {
            best = Some(cover);
        }
    }
    let mut best = best?;
    let (fewer, _) = ExactExtractor::search(alternatives, times, &demands, best.operations, SEARCH);
    if let Some(cover) = fewer.and_then(|choice| extractor.evaluate(&choice)) {
        best = cover;
    }
    Some(best)
}

/// The earliest arrival of every class.
struct Depth {
    arrivals: Vec<u32>,
    choice: Vec<u32>,
    /// Classes in the order they are settled, and the place of each.
    order: Vec<u32>,
    rank: Vec<u32>,
}

impl Depth {
    fn find(alternatives: &Alternatives, times: SurroundingTimes<'_>) -> Depth {
        let count = alternatives.classes.len();
        let mut depth = Depth {
            arrivals: vec![NEVER; count],
            choice: vec![0; count],
            order: Vec::with_capacity(count),
            rank: vec![NEVER; count],
        };
        // For each class the alternatives it takes part in.
        let mut users: Vec<Vec<(u32, u32)>> = vec![Vec::new(); count];
        let mut waiting: Vec<Vec<u32>> = Vec::with_capacity(count);
        let mut heap = BinaryHeap::new();
        let mut trees = vec![0u32; count];
        for (class, forms) in alternatives.classes.iter().enumerate() {
            let mut counts = Vec::with_capacity(forms.len());
            for (index, form) in forms.iter().enumerate() {
                let place = (class as u32, index as u32);
                for &child in &form.children {
                    users[child as usize].push(place);
                }
                counts.push(form.children.len() as u32);
                if form.children.is_empty() {
                    let arrival = form.arrival(&times, |_| 0);
                    heap.push(Reverse((arrival, 0, place.0, place.1)));
                }
            }
            waiting.push(counts);
        }
        while let Some(Reverse((arrival, tree, class, index))) = heap.pop() {
            let place = class as usize;
            if depth.arrivals[place] != NEVER {
                continue;
            }
            depth.arrivals[place] = arrival;
            depth.choice[place] = index;
            depth.rank[place] = depth.order.len() as u32;
            depth.order.push(class);
            trees[place] = tree;
            for &(user, form) in &users[place] {
                let left = &mut waiting[user as usize][form as usize];
                *left -= 1;
                if *left > 0 || depth.arrivals[user as usize] != NEVER {
                    continue;
                }
                let alternative = &alternatives.classes[user as usize][form as usize];
                let arrival = alternative.arrival(&times, |child| depth.arrivals[child as usize]);
                let tree = alternative
                    .children
                    .iter()
                    .fold(alternative.operations(), |sum, &child| {
                        sum.saturating_add(trees[child as usize])
                    });
                heap.push(Reverse((arrival, tree, user, form)));
            }
        }
        depth
    }
}

/// A point of a front: time and cost, as a tree, of a class.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
struct ArrivalPoint {
    arrival: u32,
    operations: u32,
    choice: u32,
}

struct Extractor<'a> {
    alternatives: &'a Alternatives,
    times: SurroundingTimes<'a>,
    demands: &'a [RequiredResult],
    depth: Depth,
    fronts: Vec<Vec<ArrivalPoint>>,
}

impl Extractor<'_> {
    /// Alternatives whose children are settled before the class: choosing
    /// among these alone cannot close a circle.
    fn is_descending(&self, class: u32, children: &[u32]) -> bool {
        let rank = self.depth.rank[class as usize];
        children
            .iter()
            .all(|&child| self.depth.rank[child as usize] < rank)
    }

    fn fronts(&self) -> Vec<Vec<ArrivalPoint>> {
        let mut fronts: Vec<Vec<ArrivalPoint>> = vec![Vec::new(); self.alternatives.classes.len()];
        let mut thresholds = Vec::new();
        for position in 0..self.depth.order.len() {
            let class = self.depth.order[position];
            let mut points = Vec::new();
            for (index, form) in self.alternatives.classes[class as usize].iter().enumerate() {
                if !self.is_descending(class, &form.children) {
                    continue;
                }
                thresholds.clear();
                let of_children = form
                    .children
                    .iter()
                    .flat_map(|&child| &fronts[child as usize]);
                thresholds.extend(of_children.map(|point| point.arrival));
                thresholds.sort_unstable();
                thresholds.dedup();
                if thresholds.is_empty() {
                    thresholds.push(0);
                }
                for &threshold in &thresholds {
                    let pick = |child: u32| within(&fronts[child as usize], threshold);
                    let arrival = form.arrival(&self.times, |child| pick(child).arrival);
                    let operations = form.children.iter().fold(form.operations(), |sum, &child| {
                        sum.saturating_add(pick(child).operations)
                    });
                    points.push(ArrivalPoint {
                        arrival,
                        operations,
                        choice: index as u32,
                    });
                }
            }
            fronts[class as usize] = front(points);
        }
        fronts
    }

    /// For each class the form with the fewest operations as a tree.
    fn cheapest(&self) -> Vec<u32> {
        let last = |points: &Vec<ArrivalPoint>| points.last().map_or(0, |point| point.choice);
        self.fronts.iter().map(last).collect()
    }

    /// A choice that keeps the required times, estimated operation by
    /// operation from the results down.
    fn top_down(&self) -> Vec<u32> {
        let mut choice = self.depth.choice.clone();
        let mut required = vec![NEVER; choice.len()];
        let mut needed = vec![false; choice.len()];
        for demand in self.demands {
            let place = demand.class as usize;
            needed[place] = true;
            required[place] = required[place].min(demand.required);
        }
        let mut bounds = Vec::new();
        for position in (0..self.depth.order.len()).rev() {
            let class = self.depth.order[position];
            if !needed[class as usize] {
                continue;
            }
            let limit = required[class as usize];
            let mut best: Option<((u32, u32), u32)> = None;
            for (index, form) in self.alternatives.classes[class as usize].iter().enumerate() {
                if !self.is_descending(class, &form.children) {
                    continue;
                }
                let arrivals = &self.depth.arrivals;
                let arrival = form.arrival(&self.times, |c| arrivals[c as usize]);
                if arrival > limit {
                    continue;
                }
                self.bounds(class, index, limit, &mut bounds);
                let mut cost = form.operations();
                for (&child, &bound) in form.children.iter().zip(&bounds) {
                    if !needed[child as usize] || required[child as usize] > bound {
                        let point = within(&self.fronts[child as usize], bound);
                        cost = cost.saturating_add(point.operations);
                    }
                }
                let key = (cost, arrival);
                if best.is_none_or(|(known, _)| key < known) {
                    best = Some((key, index as u32));
                }
            }
            let Some((_, index)) = best else {
                continue;
            };
            choice[class as usize] = index;
            self.bounds(class, index as usize, limit, &mut bounds);
            let form = &self.alternatives.classes[class as usize][index as usize];
            for (&child, &bound) in form.children.iter().zip(&bounds) {
                needed[child as usize] = true;
                let known = &mut required[child as usize];
                *known = (*known).min(bound);
            }
        }
        choice
    }

    /// The latest time of each child of a form with which the form is in time:
    /// the children in sequence use up the time left.
    fn bounds(&self, class: u32, index: usize, limit: u32, bounds: &mut Vec<u32>) {
        let form = &self.alternatives.classes[class as usize][index];
        bounds.clear();
        bounds.extend(
            form.children
                .iter()
                .map(|&child| self.depth.arrivals[child as usize]),
        );
        for place in 0..bounds.len() {
            let latest = self.fronts[form.children[place] as usize].iter().rev();
            for point in latest {
                let known = bounds[place];
                if point.arrival <= known {
                    break;
                }
                bounds[place] = point.arrival;
                let arrival = form.arrival_of(&self.times, bounds);
                if arrival <= limit {
                    break;
                }
                bounds[place] = known;
            }
        }
    }

    /// The cover that a choice means; `None` when it goes in a circle or is
    /// late.
    fn evaluate(&self, choice: &[u32]) -> Option<Cover> {
        const OPEN: u32 = NEVER - 1;
        let mut arrivals = vec![NEVER; choice.len()];
        let mut cover = Cover {
            choice: Vec::new(),
            order: Vec::new(),
            arrivals: Vec::new(),
            operations: 0,
        };
        let mut open: Vec<u32> = self.demands.iter().map(|demand| demand.class).collect();
        open.reverse();
        while let Some(&class) = open.last() {
            let place = class as usize;
            let form = &self.alternatives.classes[place][choice[place] as usize];
            match arrivals[place] {
                NEVER => {
                    arrivals[place] = OPEN;
                    for &child in &form.children {
                        match arrivals[child as usize] {
                            NEVER => open.push(child),
                            OPEN => return None,
                            _ => {}
                        }
                    }
                }
                OPEN => {
                    open.pop();
                    if form.children.iter().any(|&c| arrivals[c as usize] >= OPEN) {
                        return None;
                    }
                    let ready = |child: u32| arrivals[child as usize];
                    let arrival = form.arrival(&self.times, ready);
                    arrivals[place] = arrival;
                    cover.operations += form.operations();
                    cover.order.push(class);
                }
                _ => {
                    open.pop();
                }
            }
        }
        for demand in self.demands {
            let arrival = arrivals[demand.class as usize];
            if arrival > demand.required {
                return None;
            }
            cover.arrivals.push(arrival);
        }
        cover.choice = choice.to_vec();
        Some(cover)
    }

    /// Changes single choices as long as the cover gets smaller.
    fn improve(&self, start: Cover, cheapest: &[u32]) -> Cover {
        let mut best = start;
        let mut budget = CHANGES;
        loop {
            let before = best.operations;
            let mut position = best.order.len();
            while position > 0 {
                position -= 1;
                let class = best.order[position] as usize;
                for index in 0..self.alternatives.classes[class].len() as u32 {
                    if index == best.choice[class] {
                        continue;
                    }
                    for cheap in [false, true] {
                        let work = best.order.len() + 1;
                        if budget < work {
                            return best;
                        }
                        budget -= work;
                        let mut choice = best.choice.clone();
                        if cheap {
                            self.cheapen(&best, &mut choice, cheapest);
                        }
                        choice[class] = index;
                        if let Some(cover) = self.evaluate(&choice)
                            && cover.operations < best.operations
                        {
                            best = cover;
                            position = position.min(best.order.len());
                            break;
                        }
                    }
                    if position >= best.order.len() || best.order[position] as usize != class {
                        break;
                    }
                }
            }
            if best.operations == before {
                return best;
            }
        }
    }

    /// Gives the classes that are not needed yet their cheapest form.
    fn cheapen(&self, cover: &Cover, choice: &mut [u32], cheapest: &[u32]) {
        choice.copy_from_slice(cheapest);
        for &class in &cover.order {
            choice[class as usize] = cover.choice[class as usize];
        }
    }
}

/// The cheapest point that is in time, or the earliest.
fn within(front: &[ArrivalPoint], limit: u32) -> ArrivalPoint {
    let after = front.partition_point(|point| point.arrival <= limit);
    let point = front.get(after.saturating_sub(1));
    *point.expect("a class that can be computed has a point")
}

/// The points no other is better than, earliest first; of too many, the ends
/// and some between.
fn front(mut points: Vec<ArrivalPoint>) -> Vec<ArrivalPoint> {
    points.sort_unstable();
    let mut kept: Vec<ArrivalPoint> = Vec::new();
    for point in points {
        if kept
            .last()
            .is_none_or(|last| point.operations < last.operations)
        {
            kept.push(point);
        }
    }
    if kept.len() > FRONT {
        let last = kept.len() - 1;
        kept = (0..FRONT)
            .map(|place| kept[place * last / (FRONT - 1)])
            .collect();
    }
    kept
}
