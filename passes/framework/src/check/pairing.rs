//! The pairing of the inputs and outputs of two versions.

use crate::instances::Instances;
use crate::scene::Scene;
use robovec_ir::print::print_output;
use robovec_ir::states::States;
use robovec_ir::{Array, Function, Input, Operation, Output, Shape, View};
use robovec_num::field::{Field, Prime};
use robovec_num::random::mix;
use std::collections::BTreeMap;

/// The same output element in both versions.
pub(super) struct OutputPair {
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
    pub(super) list: Vec<OutputPair>,
    inputs: Inputs,
    /// Of the constants of both versions.
    sizes: Vec<f64>,
}

/// The pairing of the inputs of the versions.
enum Inputs {
    /// They are the same.
    Same,
    /// The version after is made for a scene.
    Scene(SceneInputs),
    /// The version after holds several instances, of which one is considered.
    Instance(InstanceInputs),
}

/// Inputs of several instances of a function.
struct InstanceInputs {
    /// The instance considered, from 1.
    instance: u32,
    /// Their number.
    count: u32,
    /// For every input after its instance, or 0 for a shared one, and the input
    /// before.
    places: Vec<(u32, usize)>,
}

/// Inputs of a function made for a scene.
struct SceneInputs {
    /// The numbers of the inputs before.
    bound: Vec<Option<f64>>,
    places: Vec<usize>,
}

/// The reason why two functions cannot be compared, for users.
pub(super) struct Unpaired {
    /// The output, if only one version sets it.
    pub(super) output: Option<Output>,
    pub(super) reason: String,
}

impl<'a> Pairs<'a> {
    pub(super) fn new(before: View<'a>, after: View<'a>) -> Result<Pairs<'a>, Unpaired> {
        let [old, new] = [before, after].map(|view| {
            let function = view.function;
            [function.inputs(), function.outputs()].map(|arrays| described(view, arrays))
        });
        for (what, (old, new)) in ["input", "output"].into_iter().zip(old.iter().zip(&new)) {
            same_arrays(what, old, new, "is not the same in both versions")?;
        }
        let (first, second) = (by_output(before)?, by_output(after)?);
        let mut list = Vec::with_capacity(before.function.assignments.len());
        for (index, indices) in first.into_iter().zip(second).enumerate() {
            let output = Output(index as u32);
            match indices {
                (Some(before), Some(after)) => list.push(OutputPair {
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
            inputs: Inputs::Same,
            sizes: sizes([before.function, after.function]),
        })
    }

    /// Pairs a version with one made for a scene: outputs that the scene does
    /// not need may be absent, but no others, and none may be new.
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
                Some(after) => list.push(OutputPair {
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
            let reason = format!("elements of {name} are set that were not set before");
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
            inputs: Inputs::Scene(SceneInputs {
                bound: scene.bound.of(before),
                places,
            }),
            sizes: sizes([before.function, after.function]),
        })
    }

    /// The version before, and one of several instances in the version
    /// after, by the names of its arrays: there must be an array of every
    /// instance for each array before, of the same shape, and no other.
    pub(super) fn instance(
        before: View<'a>,
        after: View<'a>,
        instances: &Instances,
        instance: u32,
    ) -> Result<Pairs<'a>, Unpaired> {
        let inputs = owners(before, after, instances, true)?;
        let outputs = owners(before, after, instances, false)?;
        let mut list = Vec::with_capacity(before.function.assignments.len());
        let (first, second) = (by_output(before)?, by_output(after)?);
        for (&(owner, output), &set) in outputs.iter().zip(&second) {
            if owner != instance {
                continue;
            }
            let element = Output(output as u32);
            match (first[output], set) {
                (Some(before), Some(after)) => list.push(OutputPair {
                    output: element,
                    before,
                    after,
                }),
                (None, None) => {}
                (Some(_), None) => return Err(one_sided(before, element, "no longer set")),
                (None, Some(_)) => {
                    return Err(one_sided(before, element, "set, and was not before"));
                }
            }
        }
        list.sort_by_key(|pair| pair.output);
        Ok(Pairs {
            before,
            after,
            list,
            inputs: Inputs::Instance(InstanceInputs {
                instance,
                count: instances.count,
                places: inputs,
            }),
            sizes: sizes([before.function, after.function]),
        })
    }

    /// The inputs of both versions at a point of a field.
    pub(super) fn point<F: Field>(&self, field: &F) -> [Vec<F::Number>; 2] {
        let count = self.before.function.input_len() as u64;
        let other = |instance: u32| {
            let first = mix(u64::from(instance));
            (0..count)
                .map(|index| field.input(first.wrapping_add(index)))
                .collect()
        };
        let own = (0..count).map(|index| field.input(index)).collect();
        self.both(own, |number| field.literal(number), other)
    }

    /// The sizes of the constants of both versions, in order.
    pub(super) fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// True when a version takes roots.
    pub(super) fn take_roots(&self) -> bool {
        let roots = |view: View<'_>| {
            let mut nodes = view.function.nodes().iter();
            nodes.any(|node| node.operation == Operation::Sqrt)
        };
        roots(self.before) || roots(self.after)
    }

    /// True when the inputs of the versions are the same.
    pub(super) fn have_same_inputs(&self) -> bool {
        matches!(self.inputs, Inputs::Same)
    }

    /// Two primes for both versions ([`primes`]).
    pub(super) fn primes(&self, seed: u64) -> [Prime; 2] {
        let versions = [self.before.function, self.after.function];
        primes(versions, &self.sizes, seed)
    }

    /// The inputs of both versions in a random state.
    pub(super) fn state(&self, source: &States, state: u32) -> [Vec<f64>; 2] {
        self.beside(source.draw(self.before, state), source, state)
    }

    /// The inputs of both versions, those of other instances in random states.
    pub(super) fn beside(&self, own: Vec<f64>, source: &States, state: u32) -> [Vec<f64>; 2] {
        let other = |instance: u32| {
            source.draw(
                self.before,
                state.wrapping_add(instance.wrapping_mul(0x9e37_79b9)),
            )
        };
        self.both(own, |number| number, other)
    }

    pub(super) fn both<T: Copy>(
        &self,
        mut before: Vec<T>,
        number: impl Fn(f64) -> T,
        other: impl Fn(u32) -> Vec<T>,
    ) -> [Vec<T>; 2] {
        assert_eq!(
            before.len(),
            self.before.function.input_len(),
            "one number per input element"
        );
        match &self.inputs {
            Inputs::Same => [before.clone(), before],
            Inputs::Scene(scene) => {
                for (input, bound) in before.iter_mut().zip(&scene.bound) {
                    if let Some(bound) = *bound {
                        *input = number(bound);
                    }
                }
                let after = scene.places.iter().map(|&place| before[place]).collect();
                [before, after]
            }
            Inputs::Instance(inputs) => {
                let others: Vec<Vec<T>> = (1..=inputs.count).map(other).collect();
                let after = inputs.places.iter().map(|&(owner, place)| match owner {
                    0 => before[place],
                    owner if owner == inputs.instance => before[place],
                    owner => others[owner as usize - 1][place],
                });
                let after = after.collect();
                [before, after]
            }
        }
    }
}

/// Two primes, modulo which the first constants under roots have roots. They
/// are drawn from the given seed and the sizes of the constants of both
/// versions, so that a constant is a multiple of a prime only by accident.
pub(super) fn primes(versions: [&Function; 2], sizes: &[f64], seed: u64) -> [Prime; 2] {
    let mut radicands: Vec<f64> = versions.into_iter().flat_map(under_roots).collect();
    radicands.sort_by(f64::total_cmp);
    radicands.dedup();
    let mixed = |seed, size: &f64| mix(seed ^ size.to_bits());
    Prime::pair_for(sizes.iter().fold(mix(seed), mixed), &radicands)
}

/// For every element of the inputs (or outputs) after, its instance, or 0 for a
/// shared one, and the element before.
fn owners<'b>(
    before: View<'b>,
    after: View<'b>,
    instances: &Instances,
    is_input: bool,
) -> Result<Vec<(u32, usize)>, Unpaired> {
    let arrays = |view: View<'b>| {
        if is_input {
            view.function.inputs()
        } else {
            view.function.outputs()
        }
    };
    let fail = |reason: String| {
        Err(Unpaired {
            output: None,
            reason,
        })
    };
    let mut expected: BTreeMap<String, (u32, &Array)> = BTreeMap::new();
    for array in arrays(before) {
        let name = before.tables.symbols.text(array.name);
        for instance in 1..=instances.count {
            let own = instances.array(name, instance, is_input);
            let owner = if own == name { 0 } else { instance };
            expected.insert(own, (owner, array));
        }
    }
    let mut owners = Vec::new();
    for array in arrays(after) {
        let name = after.tables.symbols.text(array.name);
        match expected.remove(name) {
            Some((owner, old)) if old.shape == array.shape => {
                let first = old.offset as usize;
                owners.extend((first..first + old.shape.len()).map(|element| (owner, element)));
            }
            Some(_) => return fail(format!("the array {name} has another extent than before")),
            None => return fail(format!("the array {name} belongs to no instance")),
        }
    }
    match expected.first_key_value() {
        Some((name, _)) => fail(format!("there is no array {name}")),
        None => Ok(owners),
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
pub(super) fn by_output(view: View<'_>) -> Result<Vec<Option<usize>>, Unpaired> {
    let mut found = vec![None; view.function.output_len()];
    for (index, assignment) in view.function.assignments.iter().enumerate() {
        let entry = &mut found[assignment.output.index()];
        if entry.replace(index).is_some() {
            return Err(one_sided(view, assignment.output, "set twice"));
        }
    }
    Ok(found)
}

/// The names and extents of arrays.
pub(super) fn described(view: View<'_>, arrays: &[Array]) -> Vec<(String, Shape)> {
    let text = |array: &Array| view.tables.symbols.text(array.name).to_owned();
    arrays
        .iter()
        .map(|array| (text(array), array.shape))
        .collect()
}

/// Refuses arrays that are not these, in this order. `otherwise` completes the
/// message about the first array that differs.
pub(super) fn same_arrays(
    what: &str,
    wanted: &[(String, Shape)],
    found: &[(String, Shape)],
    otherwise: &str,
) -> Result<(), Unpaired> {
    if wanted == found {
        return Ok(());
    }
    let odd = wanted.iter().find(|array| !found.contains(array));
    let odd = odd.or_else(|| found.iter().find(|array| !wanted.contains(array)));
    Err(Unpaired {
        output: None,
        reason: match odd {
            Some((name, _)) => format!("the {what} array {name} {otherwise}"),
            None => format!("the {what} arrays are in another order"),
        },
    })
}

/// The sizes of constants that are under roots, alone or as factors: the
/// root of a square is the size of its base only where that is a square.
fn under_roots(function: &Function) -> Vec<f64> {
    let mut is_factor = vec![false; function.nodes().len()];
    let mut found = Vec::new();
    for (index, node) in function.nodes().iter().enumerate().rev() {
        let passes_on = match node.operation {
            Operation::Sqrt => true,
            Operation::Mul | Operation::Div | Operation::Neg | Operation::Copy => is_factor[index],
            _ => false,
        };
        if !passes_on {
            continue;
        }
        for operand in node.operands() {
            if let Some(value) = operand.value() {
                is_factor[value.index()] = true;
            }
            let constant = operand.constant().map(|it| function.constant_number(it));
            found.extend(constant.map(f64::abs).filter(|&size| size > 0.0));
        }
    }
    found
}

/// The sizes of the constants of functions, each once, in order.
pub(super) fn sizes<'a>(functions: impl IntoIterator<Item = &'a Function>) -> Vec<f64> {
    let mut sizes: Vec<f64> = functions
        .into_iter()
        .flat_map(|function| function.reads().filter_map(|read| function.number(read)))
        .map(f64::abs)
        .filter(|size| size.is_finite() && *size > 0.0)
        .collect();
    sizes.sort_unstable_by(f64::total_cmp);
    sizes.dedup();
    sizes
}
