//! The first superwords: elements of inputs that look alike.
//!
//! Joints are numbered limb by limb, or the same joint of all limbs in turn, and
//! arrays of joints have one order. So the elements of a superword are taken a
//! constant step apart; the steps whose elements look most alike are tried, and
//! the one that needs the fewest instructions is kept. Further limbs follow in
//! the same way, then inputs in another order, such as the points of
//! a model.

use super::colours::{ItemColours, ROUNDS};
use super::graph::DataGraph;
use super::{Superword, Superwords, growth, worth};
use robovec_ir::{Input, Operand, Shape};
use std::cmp::Reverse;

/// Maximum number of steps that are tried for a limb.
const TRIALS: usize = 6;

/// Maximum number of groups of limbs.
const GROUPS: usize = 4;

/// Radius of the smallest neighbourhood that makes other inputs alike.
const LEAST: usize = 2;

/// Maximum number of refinements of colours for other inputs.
const REFINEMENTS: usize = 8;

/// Share of the instructions that further seeds must save.
const SAVED: f64 = 0.005;

/// Superwords grown from some seeds.
struct SeededWords {
    seeds: Vec<Vec<Operand>>,
    words: Superwords,
    instructions: usize,
}

impl SeededWords {
    /// Superwords of a number of lanes from seeds.
    fn new(
        graph: &DataGraph<'_>,
        colours: &ItemColours,
        lanes: usize,
        seeds: Vec<Vec<Operand>>,
    ) -> SeededWords {
        let mut words = Superwords::of_inputs(graph, lanes, &seeds);
        growth::grow(graph, colours, &mut words);
        worth::prune(graph, &mut words);
        SeededWords {
            instructions: worth::instructions(graph, &words),
            seeds,
            words,
        }
    }

    /// The superwords with the best of some further seeds, if they save enough.
    fn improved(
        &self,
        graph: &DataGraph<'_>,
        colours: &ItemColours,
        further: Vec<Vec<Vec<Operand>>>,
    ) -> Option<SeededWords> {
        let seeded = further.into_iter().map(|more| {
            let seeds = [&self.seeds[..], &more].concat();
            SeededWords::new(graph, colours, self.words.lanes, seeds)
        });
        let best = seeded.min_by_key(|seeded| seeded.instructions)?;
        let most = self.instructions as f64 * (1.0 - SAVED);
        (best.instructions as f64 <= most).then_some(best)
    }
}

/// The superwords of a number of lanes, and the instructions with them.
pub(super) fn superwords(graph: &DataGraph<'_>, lanes: usize) -> (usize, Superwords) {
    let none = Superwords::of_inputs(graph, lanes, &[]);
    let colours = ItemColours::new(graph, &none);
    let mut best = SeededWords::new(graph, &colours, lanes, Vec::new());
    let arrays = joint_arrays(graph);
    for _ in 0..GROUPS {
        let further = limbs(graph, &colours, &best.words, &arrays);
        let Some(better) = best.improved(graph, &colours, further) else {
            break;
        };
        best = better;
    }
    for _ in 0..REFINEMENTS {
        let seeds = Superwords::of_inputs(graph, lanes, &best.seeds);
        let refined = ItemColours::new(graph, &seeds);
        let further = vec![others(graph, &best.words, &refined)];
        let Some(better) = best.improved(graph, &refined, further) else {
            break;
        };
        best = better;
    }
    (best.instructions, best.words)
}

/// An input array with an element, or column, for every joint.
struct JointArray {
    offset: u32,
    rows: u32,
    joints: u32,
}

impl JointArray {
    fn element(&self, row: u32, joint: u32) -> Operand {
        Input(self.offset + row * self.joints + joint).into()
    }
}

/// The input arrays that have as many elements or columns as most vectors of
/// inputs.
fn joint_arrays(graph: &DataGraph<'_>) -> Vec<JointArray> {
    let arrays = graph.function.inputs().iter().map(|array| {
        let (rows, joints) = match array.shape {
            Shape::Scalar => (0, 0),
            Shape::Vector(joints) => (1, joints),
            Shape::Matrix(rows, columns) => (rows, columns),
        };
        JointArray {
            offset: array.offset,
            rows,
            joints,
        }
    });
    let mut arrays: Vec<JointArray> = arrays.collect();
    let count = |joints: u32| {
        let alike = arrays
            .iter()
            .filter(|array| array.rows == 1 && array.joints == joints);
        alike.count()
    };
    let joints = arrays.iter().map(|array| array.joints);
    let most = joints.max_by_key(|&joints| (count(joints), joints));
    arrays.retain(|array| Some(array.joints) == most && array.joints > 0);
    arrays
}

/// Seeds of limbs whose joints look most alike, the best first.
fn limbs(
    graph: &DataGraph<'_>,
    colours: &ItemColours,
    words: &Superwords,
    arrays: &[JointArray],
) -> Vec<Vec<Vec<Operand>>> {
    let lanes = words.lanes as u32;
    let joints = arrays.first().map_or(0, |array| array.joints);
    let mut rated: Vec<(Reverse<usize>, u32, u32, bool)> = Vec::new();
    let mut rate = |first: u32, length: u32, is_in_turn: bool| {
        let limb = limb(graph, arrays, lanes, first, length, is_in_turn);
        let is_new = limb
            .iter()
            .flatten()
            .all(|&item| words.place(item).is_none());
        if let Some(likeness) = likeness(graph, colours, &limb)
            && is_new
        {
            rated.push((Reverse(likeness), first, length, is_in_turn));
        }
    };
    for first in 0..joints {
        for length in 1..=(joints - first) / lanes {
            rate(first, length, false);
            if length > 1 {
                rate(first, length, true);
            }
        }
    }
    rated.sort_unstable();
    rated.truncate(TRIALS);
    let seeds = rated.into_iter().map(|(_, first, length, is_in_turn)| {
        limb(graph, arrays, lanes, first, length, is_in_turn)
    });
    seeds.collect()
}

/// The elements of limbs that are used, lane by lane: limbs of some length one
/// after the other, or the same joint of all limbs in turn.
fn limb(
    graph: &DataGraph<'_>,
    arrays: &[JointArray],
    lanes: u32,
    first: u32,
    length: u32,
    is_in_turn: bool,
) -> Vec<Vec<Operand>> {
    let mut seeds = Vec::new();
    for array in arrays {
        for row in 0..array.rows {
            for place in 0..length {
                let joint = |lane: u32| {
                    if is_in_turn {
                        first + place * lanes + lane
                    } else {
                        first + place + lane * length
                    }
                };
                let items: Vec<Operand> = (0..lanes)
                    .map(|lane| array.element(row, joint(lane)))
                    .collect();
                if items.iter().any(|&item| graph.is_read(item)) {
                    seeds.push(items);
                }
            }
        }
    }
    seeds
}

/// The likeness of seeds: the sum of the squares of the radii to which their
/// lanes look alike; `None` if that is 0, or some lane is not read.
fn likeness(graph: &DataGraph<'_>, colours: &ItemColours, seeds: &[Vec<Operand>]) -> Option<usize> {
    let mut sum = 0;
    for items in seeds {
        if !items.iter().all(|&item| graph.is_read(item)) {
            return None;
        }
        let items: Vec<usize> = items.iter().filter_map(|&item| graph.item(item)).collect();
        let radii = items.iter().map(|&item| colours.likeness(items[0], item));
        let least = radii.min().expect("a superword has lanes");
        sum += least * least;
    }
    (sum > 0).then_some(sum)
}

/// Seeds of all other inputs that look alike with the largest radius.
fn others(graph: &DataGraph<'_>, words: &Superwords, colours: &ItemColours) -> Vec<Vec<Operand>> {
    let mut rounds = (LEAST..=ROUNDS)
        .rev()
        .map(|round| alike(graph, words, colours, round));
    rounds.find(|found| !found.is_empty()).unwrap_or_default()
}

/// Inputs without a superword that look alike after a round, as many as there
/// are lanes, in order of elements.
fn alike(
    graph: &DataGraph<'_>,
    words: &Superwords,
    colours: &ItemColours,
    round: usize,
) -> Vec<Vec<Operand>> {
    let inputs = (0..graph.function.input_len() as u32).map(|input| Operand::from(Input(input)));
    let mut open: Vec<(u64, Operand)> = inputs
        .filter(|&input| words.place(input).is_none() && graph.is_read(input))
        .map(|input| {
            (
                colours.of(graph.item(input).expect("an input"), round),
                input,
            )
        })
        .collect();
    open.sort_unstable();
    let mut found: Vec<Vec<Operand>> = open
        .chunk_by(|a, b| a.0 == b.0)
        .flat_map(|class| class.chunks_exact(words.lanes))
        .map(|items| items.iter().map(|&(_, item)| item).collect())
        .collect();
    found.sort_unstable();
    found
}

/// A superword that is read from memory.
pub(super) fn gathered(items: Vec<Operand>) -> Superword {
    Superword {
        items,
        operation: None,
        negative: 0,
        operands: Vec::new(),
    }
}
