//! Which output of one version belongs to which of the other.

use super::failure::{Failure, FailureKind};
use crate::scene::Scene;
use robovec_ir::arithmetic::Arithmetic;
use robovec_ir::field::PrimeField;
use robovec_ir::print::print_output;
use robovec_ir::states::States;
use robovec_ir::{Array, Input, Output, View};
use std::collections::BTreeMap;

/// The same output element in both versions.
pub(super) struct Pair {
    pub(super) output: Output,
    /// Index into the assignments of the version before.
    pub(super) before: usize,
    /// Index into the assignments of the version after.
    pub(super) after: usize,
}

/// Two versions of a function with the same signature and the same outputs.
pub(super) struct Pairs<'a> {
    pub(super) before: View<'a>,
    pub(super) after: View<'a>,
    /// In order of the output elements.
    pub(super) list: Vec<Pair>,
    /// How the inputs differ, if they do.
    scene: Option<SceneInputs>,
}

/// Inputs of a function made for a scene.
struct SceneInputs {
    /// The numbers of the inputs before.
    bound: Vec<Option<f64>>,
    /// For every input after the one before.
    places: Vec<usize>,
}

/// Why two functions cannot be compared, for people.
pub(super) struct Unpaired {
    /// The output that only one of them sets, if it is that.
    pub(super) output: Option<Output>,
    pub(super) reason: String,
}

impl<'a> Pairs<'a> {
    pub(super) fn new(before: View<'a>, after: View<'a>) -> Result<Pairs<'a>, Unpaired> {
        same_arrays(
            "input",
            before,
            before.function.inputs(),
            after,
            after.function.inputs(),
        )?;
        same_arrays(
            "output",
            before,
            before.function.outputs(),
            after,
            after.function.outputs(),
        )?;
        let (first, second) = (by_output(before)?, by_output(after)?);
        let mut list = Vec::with_capacity(before.function.assignments.len());
        for (index, indices) in first.into_iter().zip(second).enumerate() {
            let output = Output(index as u32);
            match indices {
                (Some(before), Some(after)) => list.push(Pair {
                    output,
                    before,
                    after,
                }),
                (None, None) => {}
                (Some(_), None) => return Err(one_sided(before, output, "no longer set")),
                (None, Some(_)) => {
                    return Err(one_sided(before, output, "set, and was not before"));
                }
            }
        }
        Ok(Pairs {
            before,
            after,
            list,
            scene: None,
        })
    }

    /// The version before, and one made for a scene: what the scene does not
    /// need may be gone, but nothing else, and nothing may be new.
    pub(super) fn within(
        before: View<'a>,
        after: View<'a>,
        scene: &Scene,
    ) -> Result<Pairs<'a>, Unpaired> {
        let elements: BTreeMap<(&str, [u32; 2]), usize> = (0..before.function.input_len())
            .map(|index| (input_key(before, index), index))
            .collect();
        let mut places = Vec::with_capacity(after.function.input_len());
        for index in 0..after.function.input_len() {
            let key = input_key(after, index);
            let Some(&place) = elements.get(&key) else {
                let reason = format!("the input array {} is new", key.0);
                return Err(Unpaired {
                    output: None,
                    reason,
                });
            };
            places.push(place);
        }
        let mut sets: BTreeMap<(&str, [u32; 2]), usize> = BTreeMap::new();
        for (index, assignment) in after.function.assignments.iter().enumerate() {
            sets.insert(output_key(after, assignment.output), index);
        }
        let mut list = Vec::with_capacity(sets.len());
        for (index, assignment) in before.function.assignments.iter().enumerate() {
            let output = assignment.output;
            match sets.remove(&output_key(before, output)) {
                Some(after) => list.push(Pair {
                    output,
                    before: index,
                    after,
                }),
                None if scene.needs(before, output) => {
                    return Err(one_sided(before, output, "needed, and no longer set"));
                }
                None => {}
            }
        }
        if let Some((name, _)) = sets.keys().next() {
            let reason = format!("something of {name} is set, and was not before");
            return Err(Unpaired {
                output: None,
                reason,
            });
        }
        list.sort_by_key(|pair| pair.output);
        Ok(Pairs {
            before,
            after,
            list,
            scene: Some(SceneInputs {
                bound: scene.bound.of(before),
                places,
            }),
        })
    }

    /// The inputs of both versions at a point of the field.
    pub(super) fn point(&self, field: &PrimeField) -> [Vec<u64>; 2] {
        let inputs = field.point(self.before.function.input_len());
        self.both(inputs, |number| field.literal(number))
    }

    /// The inputs of both versions in a random state.
    pub(super) fn state(&self, source: &States, state: u32) -> [Vec<f64>; 2] {
        self.both(source.draw(self.before, state), |number| number)
    }

    fn both<T: Copy>(&self, mut before: Vec<T>, number: impl Fn(f64) -> T) -> [Vec<T>; 2] {
        let Some(scene) = &self.scene else {
            return [before.clone(), before];
        };
        for (input, bound) in before.iter_mut().zip(&scene.bound) {
            if let Some(bound) = *bound {
                *input = number(bound);
            }
        }
        let after = scene.places.iter().map(|&place| before[place]).collect();
        [before, after]
    }
}

impl Unpaired {
    /// As the failure of a check.
    pub(super) fn failure(self, before: View<'_>, after: View<'_>) -> Failure {
        let kind = FailureKind::Signature {
            reason: self.reason,
        };
        let mut failure = Failure::about(kind, after);
        failure.output = self.output;
        if let Some(output) = self.output {
            failure.name = print_output(before, output);
        }
        failure
    }
}

fn input_key(view: View<'_>, index: usize) -> (&str, [u32; 2]) {
    let (array, indices, _) = view.function.input_element(Input(index as u32));
    (view.tables.symbols.text(array.name), indices)
}

fn output_key(view: View<'_>, output: Output) -> (&str, [u32; 2]) {
    let (array, indices, _) = view.function.output_element(output);
    (view.tables.symbols.text(array.name), indices)
}

fn one_sided(view: View<'_>, output: Output, what: &str) -> Unpaired {
    Unpaired {
        output: Some(output),
        reason: format!("{} is {what}", print_output(view, output)),
    }
}

/// For each output element the assignment that sets it.
fn by_output(view: View<'_>) -> Result<Vec<Option<usize>>, Unpaired> {
    let mut found = vec![None; view.function.output_len()];
    for (index, assignment) in view.function.assignments.iter().enumerate() {
        let entry = &mut found[assignment.output.index()];
        if entry.replace(index).is_some() {
            return Err(one_sided(view, assignment.output, "set twice"));
        }
    }
    Ok(found)
}

fn same_arrays(
    what: &str,
    before: View<'_>,
    left: &[Array],
    after: View<'_>,
    right: &[Array],
) -> Result<(), Unpaired> {
    let describe = |view: View<'_>, array: &Array| {
        let name = view.tables.symbols.text(array.name).to_owned();
        (name, array.shape)
    };
    let left: Vec<_> = left.iter().map(|array| describe(before, array)).collect();
    let right: Vec<_> = right.iter().map(|array| describe(after, array)).collect();
    if left == right {
        return Ok(());
    }
    let odd = left.iter().find(|array| !right.contains(array));
    let odd = odd.or_else(|| right.iter().find(|array| !left.contains(array)));
    Err(Unpaired {
        output: None,
        reason: match odd {
            Some((name, _)) => format!("the {what} array {name} is not the same in both versions"),
            None => format!("the {what} arrays stand in another order"),
        },
    })
}
