//! Random states: inputs drawn with physical scales.
//!
//! Rounding errors depend on the sizes of the numbers, so the numeric checks
//! draw every array of Robotran with the scale of its quantity, in SI units:
//!
//! | array | meaning | drawn from |
//! |---|---|---|
//! | `q` | joint positions | uniform, ±π |
//! | `qd` | joint velocities | uniform, ±5 |
//! | `qdd` | joint accelerations | uniform, ±20 |
//! | `m` | masses | per octave uniform, 1/8 to 128 |
//! | `In` | inertia tensors, 9 rows per body | diagonal per octave uniform, 1/128 to 8; the others uniform, ±0.005, symmetric |
//! | `l`, `dpt` | centres of mass, points | uniform, ±1 |
//! | `lrod` | lengths of rods | per octave uniform, 1/8 to 2 |
//! | `g` | gravity | third component uniform, −10 to −9.6; the others ±0.5 |
//! | `frc`, `trq`, `SWr…`, `Qq` | forces and torques | uniform, ±100 |
//! | `Flink…`, `Flnk…` | forces of links | uniform, ±1000 |
//! | `tsim` | time | uniform, 0 to 10 |
//! | any other | | uniform, ±1 |
//!
//! Where the range of an element is given ([`Ranges`], from a scene), it is
//! drawn uniformly from that range instead.
//!
//! No component is drawn as zero on purpose: a zero would hide the terms it
//! multiplies. Every number that is drawn is rounded to binary32, so that narrow
//! and wide arithmetics start from the same state. An element depends on the seed, the
//! number of the state, the array's name and the place in the array alone:
//! two versions of a function see the same states.

use crate::function::{Array, Shape};
use crate::module::View;
use robovec_num::random::{mix, unit};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// A seeded source of random states.
#[derive(Clone, PartialEq, Debug)]
pub struct States {
    seed: u64,
    ranges: Arc<Ranges>,
}

/// The ranges of some input elements.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Ranges {
    /// By the name of the array, so that a state looks each name up once.
    arrays: BTreeMap<String, ElementRanges>,
}

/// The ranges of the elements of an array, by their indices.
type ElementRanges = BTreeMap<[u32; 2], [f64; 2]>;

impl Ranges {
    /// Records the range of an element of an array, by its indices from 1 (0
    /// for absent ones), in SI units; equal ends give its value.
    pub fn set(&mut self, array: &str, indices: [u32; 2], low: f64, high: f64) {
        assert!(
            low <= high,
            "the low end of a range is not above the high one"
        );
        let elements = self.arrays.entry(array.to_owned()).or_default();
        elements.insert(indices, [low, high]);
    }

    /// The range of an element, where one is known.
    pub fn get(&self, array: &str, indices: [u32; 2]) -> Option<[f64; 2]> {
        self.arrays.get(array)?.get(&indices).copied()
    }

    /// Adds the ranges of elements of which nothing is known here.
    pub fn add_missing(&mut self, others: &Ranges) {
        for (array, indices, [low, high]) in others.iter() {
            if self.get(array, indices).is_none() {
                self.set(array, indices, low, high);
            }
        }
    }

    /// True when nothing is known of any element.
    pub fn is_empty(&self) -> bool {
        self.arrays.is_empty()
    }

    /// All elements that something is known of, in order of their names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, [u32; 2], [f64; 2])> + '_ {
        self.arrays.iter().flat_map(|(array, elements)| {
            let elements = elements.iter();
            elements.map(|(indices, range)| (array.as_str(), *indices, *range))
        })
    }
}

/// The distribution of an array's elements.
#[derive(Clone, Copy)]
enum Scale {
    Uniform(f64, f64),
    /// The low end, and the number of equally likely octaves above it; inside
    /// an octave numbers are uniform, so that no logarithm of the platform's
    /// library decides a bit.
    Octaves(f64, u32),
}

impl Scale {
    /// The number at a place of the distribution, counted from 0 to 1.
    fn at(self, place: f64) -> f64 {
        match self {
            Scale::Uniform(low, high) => low + (high - low) * place,
            Scale::Octaves(low, count) => {
                let octaves = place * f64::from(count);
                low * 2f64.powi(octaves as i32) * (1.0 + octaves.fract())
            }
        }
    }
}

impl States {
    /// The states of a seed.
    pub fn new(seed: u64) -> States {
        States {
            seed,
            ranges: Arc::default(),
        }
    }

    /// The same states, except for elements whose range is known. The random
    /// number that chooses inside a range is the one that would have chosen
    /// without it.
    #[must_use]
    pub fn within(self, ranges: Arc<Ranges>) -> States {
        States { ranges, ..self }
    }

    /// The seed they come from.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The known ranges of the inputs.
    pub fn ranges(&self) -> &Ranges {
        &self.ranges
    }

    /// The bounds between which an element of an input array is drawn, by its
    /// place in the array counted from 0, row by row.
    pub fn bounds(&self, name: &str, array: &Array, offset: u32) -> [f64; 2] {
        let (indices, _) = array.shape.indices(offset);
        self.ranges.get(name, indices).unwrap_or_else(|| {
            let (scale, _) = distribution(name, array, offset);
            [scale.at(0.0), scale.at(1.0)]
        })
    }

    /// The flattened inputs of a function in the state of a number.
    pub fn draw(&self, view: View<'_>, index: u32) -> Vec<f64> {
        let mut inputs = Vec::with_capacity(view.function.input_len());
        for array in view.function.inputs() {
            let name = view.tables.symbols.text(array.name);
            let salt = name
                .bytes()
                .fold(mix(self.seed ^ u64::from(index) << 32), |hash, byte| {
                    mix(hash ^ u64::from(byte))
                });
            let ranges = self.ranges.arrays.get(name);
            for offset in 0..array.shape.len() as u32 {
                let (scale, place) = distribution(name, array, offset);
                let random = mix(salt.wrapping_add(u64::from(place)));
                let unit = unit(random);
                let (indices, _) = array.shape.indices(offset);
                let range = ranges.and_then(|elements| elements.get(&indices).copied());
                inputs.push(match range {
                    Some(range) => inside(range, unit),
                    None => f64::from(scale.at(unit) as f32),
                });
            }
        }
        inputs
    }
}

/// The binary32 number at a place of a range; outside it only when it holds
/// none. A range of one number gives the value of the element with exactly its
/// bits, since a program into which it was compiled contains it so.
fn inside([low, high]: [f64; 2], place: f64) -> f64 {
    if low == high {
        return low;
    }
    let number = (low + (high - low) * place) as f32;
    let inner = if f64::from(number) > high {
        number.next_down()
    } else if f64::from(number) < low {
        number.next_up()
    } else {
        number
    };
    let kept = (low..=high).contains(&f64::from(inner));
    f64::from(if kept { inner } else { number })
}

/// The distribution of an element and the place whose random number it takes
/// (its own, save that an inertia tensor is symmetric).
fn distribution(name: &str, array: &Array, offset: u32) -> (Scale, u32) {
    let symmetric = |bound: f64| Scale::Uniform(-bound, bound);
    let scale = match name {
        "q" => symmetric(PI),
        "qd" => symmetric(5.0),
        "qdd" => symmetric(20.0),
        "m" => Scale::Octaves(0.125, 10),
        "In" => return inertia(array, offset),
        "lrod" => Scale::Octaves(0.125, 4),
        "g" if offset == 2 => Scale::Uniform(-10.0, -9.6),
        "g" => symmetric(0.5),
        "frc" | "trq" | "Qq" => symmetric(100.0),
        "tsim" => Scale::Uniform(0.0, 10.0),
        name if name.starts_with("SWr") => symmetric(100.0),
        name if name.starts_with("Flink") || name.starts_with("Flnk") => symmetric(1000.0),
        _ => symmetric(1.0),
    };
    (scale, offset)
}

/// `In[k,i]` is entry `k` of the tensor of body `i`, row by row.
fn inertia(array: &Array, offset: u32) -> (Scale, u32) {
    let columns = match array.shape {
        Shape::Matrix(_, columns) => columns,
        Shape::Scalar | Shape::Vector(_) => 1,
    };
    let (entry, body) = (offset / columns, offset % columns);
    match entry {
        0 | 4 | 8 => (Scale::Octaves(0.0078125, 10), offset),
        _ => {
            let mirrored = entry % 3 * 3 + entry / 3;
            let place = if entry < 9 {
                entry.min(mirrored)
            } else {
                entry
            };
            (Scale::Uniform(-0.005, 0.005), place * columns + body)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::function::{Function, Level};
    use crate::module::Tables;

    fn sample() -> (Tables, Function) {
        let mut tables = Tables::default();
        let mut function = Function::new("sample", Level::Equations);
        for (name, shape) in [
            ("q", Shape::Vector(50)),
            ("m", Shape::Vector(50)),
            ("In", Shape::Matrix(9, 4)),
            ("g", Shape::Vector(3)),
        ] {
            function.add_input(tables.symbols.intern(name), shape);
        }
        (tables, function)
    }

    #[test]
    fn states_are_reproducible_physical_and_representable_in_binary32() {
        let (tables, function) = sample();
        let view = tables.view(&function);
        let states = States::new(1);
        let state = states.draw(view, 0);
        assert_eq!(state, states.draw(view, 0));
        assert_ne!(state, states.draw(view, 1));
        assert_ne!(state, States::new(2).draw(view, 0));
        assert!(state.iter().all(|&x| f64::from(x as f32) == x && x != 0.0));
        let (q, rest) = state.split_at(50);
        let (m, rest) = rest.split_at(50);
        let (tensor, g) = rest.split_at(36);
        assert!(q.iter().all(|x| x.abs() <= f64::from(PI as f32)) && q.iter().any(|x| *x < -1.0));
        assert!(m.iter().all(|x| (0.125..=128.0).contains(x)));
        for (row, mirrored) in [(1, 3), (2, 6), (5, 7)] {
            assert_eq!(tensor[row * 4..][..4], tensor[mirrored * 4..][..4]);
        }
        assert_ne!(tensor[4..8], tensor[8..12]);
        assert!(g[2] < -9.5);
    }

    #[test]
    fn known_ranges_are_kept_and_leave_the_rest_alone() {
        let (tables, function) = sample();
        let view = tables.view(&function);
        let mut ranges = Ranges::default();
        ranges.set("q", [3, 0], -0.05, 0.05);
        ranges.set("In", [5, 2], 0.1, 0.1);
        let free = States::new(1);
        let bounded = free.clone().within(Arc::new(ranges));
        for index in 0..50 {
            let (before, after) = (free.draw(view, index), bounded.draw(view, index));
            let changed = before.iter().zip(&after).enumerate();
            let changed: Vec<usize> = changed
                .filter(|(_, (a, b))| a != b)
                .map(|(i, _)| i)
                .collect();
            assert_eq!(changed, [2, 100 + 4 * 4 + 1]);
            assert!(after[2].abs() <= 0.05 && f64::from(after[2] as f32) == after[2]);
            assert_eq!(after[117], 0.1);
        }
        assert_eq!(bounded.bounds("q", &function.inputs()[0], 2), [-0.05, 0.05]);
        assert_eq!(bounded.bounds("q", &function.inputs()[0], 3), [-PI, PI]);
    }
}
