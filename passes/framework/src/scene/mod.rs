//! Scenes: the intended use of a program.
//!
//! A function of a model answers every question for every parameter and every
//! state. A scene describes the use of a program: the outputs that are needed
//! and the error each may have, the inputs whose numbers are known when the
//! program is compiled, the joints that do not move or move as prescribed, the
//! possible size of the state, and the time of an evaluation. Passes read it
//! from their context (`specialise` first of all), measurements draw their
//! states from it.
//!
//! A scene is data and belongs to no function: arrays go by name, elements by
//! their indices from 1 (0 for those an array does not have). An entry for an
//! array that a function does not have has no effect on that function, so that
//! one scene serves every formulation.
//!
//! **Invariants** (upheld by the readers of scenes): numbers are finite, the
//! low end of a range is not above the high end, no element is both bound and
//! ranged, and of locked joints position, velocity and acceleration are bound.

mod allowed;
mod pattern;

pub use allowed::{Allowed, ArraySizes};
pub use pattern::{ElementPattern, IndexPattern};
use robovec_ir::states::{Ranges, States};
use robovec_ir::{Input, Output, View};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// The use that a program is needed for.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// One line for users.
    pub description: String,
    /// The outputs that are needed; all when empty.
    pub outputs: Vec<NeededOutputs>,
    /// The numbers of inputs that are known when the program is compiled.
    pub bound: Bindings,
    /// Joints that are no degrees of freedom here.
    pub joints: Vec<HeldJoint>,
    /// Joints whose angles are small, by number from 1: in the equations their
    /// sine is the angle and their cosine one.
    pub small: Vec<u32>,
    /// The ranges of the other inputs; those it does not name are free.
    pub ranges: Ranges,
    /// Sines and cosines are computed by the elements, as series; otherwise a
    /// host prepares them before the run.
    pub series: bool,
    /// The longest time of one evaluation, µs.
    pub deadline: Option<f64>,
    /// The machine compiled for: a name or a file beside the scene.
    pub machine: Option<String>,
    /// The function wished for (`dirdyna`, `accelred`, …).
    pub function: Option<String>,
    /// The formulation wished for (`recursive`, `articulated`, …).
    pub formulation: Option<String>,
}

/// Outputs that are needed, and how well.
#[derive(Clone, PartialEq, Debug)]
pub struct NeededOutputs {
    /// Elements that are meant.
    pub pattern: ElementPattern,
    /// The allowed error; `None` for any error of the number format.
    pub tolerance: Option<OutputTolerance>,
}

/// An allowed error.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct OutputTolerance {
    /// The measure the error is compared with.
    pub measure: Measure,
    /// The largest that is allowed.
    pub bound: f64,
    /// Least size by which the error is measured, in the unit of the output.
    /// `None`: the usual size of the array for [`Measure::Norm`], a small part
    /// of that of the element for [`Measure::Relative`] ([`ArraySizes`]).
    pub scale: Option<f64>,
}

robovec_num::named! {
    /// The measure an error is compared with.
    #[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
    pub enum Measure {
        /// The largest element of the output's array, or the tolerance's scale
        /// where that is larger.
        #[default]
        Norm = "norm",
        /// The element itself, or the tolerance's scale where that is larger.
        Relative = "relative",
        /// No reference: the error has the unit of the output.
        Absolute = "absolute",
    }
}

impl fmt::Display for OutputTolerance {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = match self.measure {
            Measure::Norm => " of its array's largest element",
            Measure::Relative => " of itself",
            Measure::Absolute => "",
        };
        write!(formatter, "{:e}{of}", self.bound)?;
        match self.scale {
            Some(scale) => write!(formatter, ", at least {scale}"),
            None => Ok(()),
        }
    }
}

/// A joint that is no degree of freedom in a scene.
#[derive(Clone, PartialEq, Debug)]
pub struct HeldJoint {
    /// Its number, from 1.
    pub number: u32,
    /// Its name in the model; its number as text where there is no model.
    pub name: String,
    /// The way it is held.
    pub hold: Hold,
}

/// The source of the motion of a joint that is no degree of freedom.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Hold {
    /// It stays at a position, m or rad; its velocity and its acceleration
    /// are zero.
    Locked(f64),
    /// It moves as prescribed: position, velocity and acceleration are
    /// inputs.
    Driven,
}

/// Input elements and their numbers.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Bindings {
    elements: BTreeMap<(String, [u32; 2]), f64>,
}

impl Bindings {
    /// Records the value of an element of an array, by its indices from 1 (0
    /// for absent ones), in SI units.
    pub fn set(&mut self, array: &str, indices: [u32; 2], number: f64) {
        self.elements.insert((array.to_owned(), indices), number);
    }

    /// The number of an element.
    pub fn get(&self, array: &str, indices: [u32; 2]) -> Option<f64> {
        if self.elements.is_empty() {
            return None;
        }
        self.elements.get(&(array.to_owned(), indices)).copied()
    }

    /// All bound elements, in order of their names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, [u32; 2], f64)> + '_ {
        let elements = self.elements.iter();
        elements.map(|((array, indices), number)| (array.as_str(), *indices, *number))
    }

    /// The number of bound elements.
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// True when nothing is bound.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// The number of every input element of a function, by their places;
    /// `None` for those that are not bound.
    pub fn of(&self, view: View<'_>) -> Vec<Option<f64>> {
        (0..view.function.input_len() as u32)
            .map(|index| {
                let (array, indices, _) = view.function.input_element(Input(index));
                self.get(view.tables.symbols.text(array.name), indices)
            })
            .collect()
    }
}

impl Scene {
    /// True when an output element of a function is needed.
    pub fn needs(&self, view: View<'_>, output: Output) -> bool {
        self.outputs.is_empty()
            || self
                .outputs
                .iter()
                .any(|need| need.pattern.matches_output(view, output))
    }

    /// The allowed errors of an output element, all that were given.
    pub fn tolerances(&self, view: View<'_>, output: Output) -> Vec<OutputTolerance> {
        let meant = |need: &&NeededOutputs| need.pattern.matches_output(view, output);
        let needs = self.outputs.iter().filter(meant);
        needs.filter_map(|need| need.tolerance).collect()
    }

    /// The known ranges of inputs: those given, and bound elements as ranges of
    /// one number.
    pub fn known_inputs(&self) -> Ranges {
        let mut ranges = self.ranges.clone();
        for (array, indices, number) in self.bound.iter() {
            ranges.set(array, indices, number, number);
        }
        ranges
    }

    /// Random states of the scene.
    pub fn states(&self, seed: u64) -> States {
        States::new(seed).within(Arc::new(self.known_inputs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::{Function, Level, Shape, Tables};

    #[test]
    fn states_of_a_scene_keep_ranges_and_bound_numbers() {
        let mut tables = Tables::default();
        let mut function = Function::new("sample", Level::Equations);
        function.add_input(tables.symbols.intern("q"), Shape::Vector(3));
        function.add_input(tables.symbols.intern("g"), Shape::Vector(3));
        let view = tables.view(&function);
        let mut scene = Scene::default();
        scene.ranges.set("q", [2, 0], -0.05, 0.05);
        scene.bound.set("g", [3, 0], -9.81);
        scene.bound.set("unknown", [1, 1], 1.0);
        let states = scene.states(1);
        for index in 0..20 {
            let state = states.draw(view, index);
            assert!(state[1].abs() <= 0.05 && state[5] == -9.81, "{state:?}");
        }
        let mut known = vec![None; 6];
        known[5] = Some(-9.81);
        assert_eq!(scene.bound.of(view), known);
    }
}
