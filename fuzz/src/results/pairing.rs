//! Two versions of a function, compared at one point.

use super::Tally;
use super::bits::bit_by_bit;
use super::promise::Promise;
use crate::hostile;
use crate::referee::{self, BITS, Leniency, Opinion, Real, Referee};
use robovec_analysis::class::NumericClass;
use robovec_ir::{Output, View, print};
use robovec_num::random::mix;
use std::collections::BTreeMap;

/// Pairs of the arrays of two versions.
pub(super) struct Pairing<'a> {
    pub(super) promise: &'a Promise,
    /// The instance of a program with several, counted from 1.
    pub(super) instance: u32,
    pub(super) seed: u64,
}

impl Pairing<'_> {
    pub(super) fn compare(
        &self,
        old: View<'_>,
        new: View<'_>,
        point: u32,
        tally: &mut Tally,
    ) -> std::result::Result<(), String> {
        let pairs = self.pairs(old, new)?;
        let inputs = [
            self.inputs(old, point, false),
            self.inputs(new, point, true),
        ];
        self.over_the_reals(old, new, &pairs, &inputs, tally)
            .and_then(|()| match self.promise.class {
                NumericClass::Exact => bit_by_bit(old, new, &pairs, &inputs, tally),
                _ => Ok(()),
            })
            .map_err(|what| format!("{what}\nat {}", describe(old, &inputs[0])))
    }

    fn over_the_reals(
        &self,
        old: View<'_>,
        new: View<'_>,
        pairs: &[(usize, usize)],
        inputs: &[Vec<f64>; 2],
        tally: &mut Tally,
    ) -> std::result::Result<(), String> {
        let mut open: Vec<(usize, usize)> = pairs.to_vec();
        for (attempt, bits) in BITS.into_iter().enumerate() {
            let mut referee = Referee::new(bits);
            // A series is beside the truth, which the function before is.
            let Leniency {
                circular,
                rounded_literals,
            } = self.promise.leniency;
            let before = Leniency {
                circular,
                rounded_literals: false,
            };
            let after = Leniency {
                circular: 0.0,
                rounded_literals,
            };
            let before = referee.evaluate(old.function, &inputs[0], before);
            let after = referee.evaluate(new.function, &inputs[1], after);
            let last = attempt + 1 == BITS.len();
            let mut unsettled = Vec::new();
            for &(first, second) in &open {
                let (before, after) = (&before[first], &after[second]);
                let opinion = referee::compare(before, after);
                match opinion {
                    Opinion::Same => tally.same += 1,
                    Opinion::Nothing if last || matches!(before, Real::Undefined) => {
                        tally.nothing += 1;
                    }
                    // No program computes with numbers beyond binary64, and
                    // constants that are computed ahead are rounded into it.
                    Opinion::Different if rounded_literals && before.is_beyond_binary64() => {
                        tally.nothing += 1;
                    }
                    Opinion::Open if last && before.is_beyond_binary64() => tally.nothing += 1,
                    // An approximation may bring a divisor to where its bits
                    // do not tell it from zero, and so may constants that are
                    // known only to a rounding.
                    Opinion::Open
                        if last
                            && (rounded_literals
                                || self.promise.class == NumericClass::Approximating) =>
                    {
                        tally.vague += 1;
                    }
                    Opinion::Vague if last => tally.vague += 1,
                    Opinion::Open | Opinion::Nothing | Opinion::Vague if !last => {
                        unsettled.push((first, second));
                    }
                    _ => {
                        let output = old.function.assignments[first].output;
                        return Err(format!(
                            "{}, {} by class, is {} before and {} after",
                            print::print_output(old, output),
                            self.promise.class,
                            before.describe(),
                            after.describe()
                        ));
                    }
                }
            }
            open = unsettled;
            if open.is_empty() {
                break;
            }
        }
        Ok(())
    }

    /// The assignments that belong together.
    pub(super) fn pairs(
        &self,
        old: View<'_>,
        new: View<'_>,
    ) -> std::result::Result<Vec<(usize, usize)>, String> {
        let mut found = BTreeMap::new();
        for (place, assignment) in new.function.assignments.iter().enumerate() {
            found.insert(element(new, assignment.output), place);
        }
        let assignments = old.function.assignments.iter().enumerate();
        assignments
            .map(|(place, assignment)| {
                let (name, offset) = element(old, assignment.output);
                let name = match &self.promise.instances {
                    Some(instances) => instances.array(&name, self.instance, false),
                    None => name,
                };
                let other = found.get(&(name.clone(), offset));
                let other = other.ok_or_else(|| format!("output {name} {offset} is gone"))?;
                Ok((place, *other))
            })
            .collect()
    }

    /// The inputs of a version, drawn by name, so that both have the same.
    pub(super) fn inputs(&self, view: View<'_>, point: u32, after: bool) -> Vec<f64> {
        let mut inputs = Vec::with_capacity(view.function.input_len());
        for array in view.function.inputs() {
            let name = view.tables.symbols.text(array.name);
            let original = match &self.promise.instances {
                Some(instances) if after && !instances.shared.contains(name) => {
                    let own = format!("_{}", self.instance);
                    // Those of other instances are drawn by their longer names.
                    name.strip_suffix(own.as_str()).unwrap_or(name)
                }
                _ => name,
            };
            for offset in 0..array.shape.len() {
                let mut state = self.seed ^ u64::from(point) << 40 ^ (offset as u64) << 20;
                for byte in original.bytes() {
                    state = mix(state ^ u64::from(byte));
                }
                let number = hostile::input(mix(state));
                inputs.push(if number.abs() <= self.promise.range {
                    number
                } else {
                    self.promise.range * (number / (1.0 + number.abs()))
                });
            }
        }
        inputs
    }
}

/// The array and the place in it of a flattened element.
fn element(view: View<'_>, output: Output) -> (String, u32) {
    let array = &view.function.outputs()[view.function.output_array(output)];
    let name = view.tables.symbols.text(array.name);
    (name.to_owned(), output.0 - array.offset)
}

fn describe(view: View<'_>, inputs: &[f64]) -> String {
    let mut text = String::new();
    for array in view.function.inputs() {
        let start = array.offset as usize;
        let numbers = &inputs[start..start + array.shape.len()];
        text += &format!("{} = {numbers:?} ", view.tables.symbols.text(array.name));
    }
    text
}
