//! Inputs and outputs of a function as a bench sees them: by name.

use super::BenchQuestion;
use robovec_error::yardstick::{ErrorSpread, Yardstick};
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Input, View};
use robovec_model::Model;
use robovec_num::arithmetic::Binary64;
use std::collections::BTreeMap;
use std::fmt;

/// The inputs that differ from state to state; all others are parameters.
const VARYING: [&str; 6] = ["q", "qd", "qdd", "Qq", "frc", "trq"];

const LOADS: [&str; 2] = ["frc", "trq"];

/// An output element: array and indices from 1, 0 where there is none.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct OutputKey {
    /// The array.
    pub array: String,
    /// Indices.
    pub indices: [u32; 2],
}

impl fmt::Display for OutputKey {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.indices {
            [0, 0] => formatter.write_str(&self.array),
            [one, 0] => write!(formatter, "{}[{one}]", self.array),
            [row, column] => write!(formatter, "{}[{row},{column}]", self.array),
        }
    }
}

/// True when the array differs from state to state.
pub(super) fn is_varying(name: &str) -> bool {
    VARYING.contains(&name)
}

/// The inputs of a function in a state; functions of a question share numbers.
pub(super) fn inputs(question: &BenchQuestion<'_>, view: View<'_>, state: u32) -> Vec<f64> {
    let mut numbers = question.states.draw(view, state);
    let parameters = question.states.draw(view, 0);
    for (index, number) in numbers.iter_mut().enumerate() {
        let (array, indices, rank) = view.function.input_element(Input(index as u32));
        let name = view.tables.symbols.text(array.name);
        if !is_varying(name) {
            *number = parameters[index];
        }
        let Some(model) = question.model else {
            continue;
        };
        let known = robovec_dynamics::kinematics::parameter(model, name, &indices[..rank]);
        if let Some(known) = known {
            *number = known;
        }
        if LOADS.contains(&name) && !(question.has_loads && is_loaded(model, indices[1])) {
            *number = 0.0;
        }
    }
    numbers
}

/// True for the last joint of a body, counted from 1. A file with all
/// parameters as symbols has loads of others, unknown to its model.
fn is_loaded(model: &Model, joint: u32) -> bool {
    let place = (joint as usize).checked_sub(1);
    place.is_some_and(|place| place < model.joints.len() && model.body_of(place).is_some())
}

/// The elements that a function sets, in order of its assignments.
pub(super) fn outputs(view: View<'_>) -> Vec<OutputKey> {
    let assignments = view.function.assignments.iter();
    assignments
        .map(|assignment| {
            let (array, indices, rank) = view.function.output_element(assignment.output);
            let mut key = OutputKey {
                array: view.tables.symbols.text(array.name).to_owned(),
                indices: [0; 2],
            };
            key.indices[..rank].copy_from_slice(&indices[..rank]);
            key
        })
        .collect()
}

pub(super) struct ReferenceResults<'a> {
    view: View<'a>,
    keys: Vec<OutputKey>,
    states: Vec<Vec<f64>>,
    /// The exact results at the same states.
    yardstick: Yardstick,
}

impl<'a> ReferenceResults<'a> {
    /// Evaluates the function as it came, in binary64 and exactly.
    pub(super) fn new(question: &BenchQuestion<'a>) -> ReferenceResults<'a> {
        let view = question.view;
        let drawn: Vec<Vec<f64>> = (0..question.count)
            .map(|state| inputs(question, view, state))
            .collect();
        let evaluated = |inputs: &Vec<f64>| evaluate(view.function, &Binary64, inputs);
        ReferenceResults {
            view,
            keys: outputs(view),
            states: drawn.iter().map(evaluated).collect(),
            yardstick: Yardstick::at(view, drawn),
        }
    }

    /// The errors of results, relative to the largest element of an array.
    pub(super) fn errors(&self, keys: &[OutputKey], results: &[Vec<f64>]) -> ErrorSpread {
        let places = self.places(keys);
        let rows = results.iter().map(|found| {
            let results = places.iter().map(|&place| result(place, found));
            results.collect()
        });
        let rows: Vec<Vec<f64>> = rows.collect();
        let measured = self.yardstick.judge(self.view, &rows);
        let measured = measured.expect("the yardstick is of this function");
        measured.normwise
    }

    /// Places of outputs in the results of another tool, perhaps transposed.
    fn places(&self, keys: &[OutputKey]) -> Vec<Option<usize>> {
        let places: BTreeMap<&OutputKey, usize> = keys.iter().zip(0..).collect();
        assert_eq!(places.len(), keys.len(), "nobody sets an output twice");
        let find = |key: &OutputKey| {
            let [row, column] = key.indices;
            let turned = OutputKey {
                array: key.array.clone(),
                indices: [column, row],
            };
            let other = || places.get(&turned).filter(|_| column != 0).copied();
            places.get(key).copied().or_else(other)
        };
        self.keys.iter().map(find).collect()
    }

    pub(super) fn states(&self) -> usize {
        self.states.len()
    }

    /// The largest difference of some results, relative to the largest element
    /// of its array in its state, and its place. An element that a contestant
    /// does not set is zero, or is in the other half of a matrix.
    pub(super) fn difference(
        &self,
        keys: &[OutputKey],
        results: &[Vec<f64>],
    ) -> Result<(f64, Option<OutputKey>), String> {
        let places = self.places(keys);
        if !self.keys.is_empty() && places.iter().all(Option::is_none) {
            return Err("it sets none of the outputs".to_owned());
        }
        assert_eq!(
            results.len(),
            self.states.len(),
            "a contestant has results for every state"
        );
        let mut worst = (0.0, None);
        for (expected, found) in self.states.iter().zip(results) {
            let mut largest: BTreeMap<&str, f64> = BTreeMap::new();
            for (key, number) in self.keys.iter().zip(expected) {
                let most = largest.entry(&key.array).or_default();
                *most = most.max(number.abs());
            }
            for ((key, place), number) in self.keys.iter().zip(&places).zip(expected) {
                let result = result(*place, found);
                let scale = largest[key.array.as_str()];
                let distance = (result - number).abs();
                let difference = if distance == 0.0 {
                    0.0
                } else {
                    distance / scale
                };
                // A NaN must not pass for a small difference.
                if difference.is_nan() || difference > worst.0 {
                    worst = (difference, Some(key.clone()));
                    if difference.is_nan() {
                        return Ok((f64::INFINITY, Some(key.clone())));
                    }
                }
            }
        }
        Ok(worst)
    }
}

/// A result of a function, zero where it has none.
fn result(place: Option<usize>, found: &[f64]) -> f64 {
    place.map_or(0.0, |place| found[place])
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_dynamics::generate::{GenerationRequest, Options, generate};
    use robovec_ir::states::States;
    use robovec_model::family;
    use robovec_robotran::FunctionKind;

    /// The numbers of a load's elements in two states.
    fn loads(has_loads: bool, all_parameters: bool) -> Vec<(u32, [f64; 2])> {
        let model = family::random_tree(2, 6);
        let request = GenerationRequest {
            options: Options {
                all_parameters,
                ..Options::default()
            },
            ..GenerationRequest::new(FunctionKind::Dirdyna)
        };
        let module = generate(&model, &request).expect("a tree has direct dynamics");
        let view = module.tables.view(&module.functions[0]);
        let question = BenchQuestion {
            name: String::new(),
            view,
            model: Some(&model),
            has_loads,
            states: &States::new(1),
            count: 16,
            flags: None,
        };
        let [one, other] = [0, 1].map(|state| inputs(&question, view, state));
        let mut found = Vec::new();
        for (index, numbers) in one.into_iter().zip(other).enumerate() {
            let (array, indices, _) = view.function.input_element(Input(index as u32));
            if LOADS.contains(&view.tables.symbols.text(array.name)) {
                let numbers = <[f64; 2]>::from(numbers);
                // Only the last joint of a body is loaded.
                if model.body_of(indices[1] as usize - 1).is_none() {
                    assert_eq!(numbers, [0.0; 2]);
                }
                found.push((indices[1], numbers));
            }
        }
        assert!(!found.is_empty());
        found
    }

    #[test]
    fn loads_are_drawn_where_they_are_asked_for() {
        for all_parameters in [false, true] {
            let none = loads(false, all_parameters);
            assert!(none.iter().all(|(_, numbers)| *numbers == [0.0; 2]));
            let drawn = loads(true, all_parameters);
            assert!(drawn.iter().any(|(_, [one, other])| one != other));
        }
    }
}
