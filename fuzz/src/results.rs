//! Random programs with hostile constants through random pipelines, pass by
//! pass, judged by a referee of their own ([`crate::referee`]).
//!
//! What a pass gives is compared with what it took: over the real numbers for
//! every class that promises them, with constants off by one rounding where a
//! pass computes them, with sines off by what a series claims; and in binary64
//! and binary32, bit by bit, for passes that promise that. The check of the
//! compiler runs as well: it must refuse what the referee refuses, and nothing
//! else.

use crate::equations::{Contents, equations};
use crate::generate::{Kind, module};
use crate::referee::{self, BITS, Leniency, Opinion, Real, Referee};
use crate::{hostile, passes};
use arbitrary::{Result, Unstructured};
use robovec_analysis::class::NumericClass;
use robovec_framework::instances::Instances;
use robovec_framework::manager::{self, Config, RunError};
use robovec_framework::pipeline::PassStep;
use robovec_ir::evaluate::evaluate_mixed_nodes;
use robovec_ir::states::States;
use robovec_ir::{Array, Format, Function, Machine, Module, OperandKind, View, print};
use robovec_passes::registry::REGISTRY;
use std::collections::BTreeMap;
use std::fmt;

/// Points at which versions are compared.
const POINTS: u32 = 3;
/// Programs that passes made larger are not followed any further.
const LARGEST: usize = 2000;
/// Passes of a pipeline.
const PASSES: u32 = 5;

/// What came of some programs.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Tally {
    /// Programs.
    pub programs: u64,
    /// Passes that ran.
    pub passes: u64,
    /// Passes that refused a program.
    pub refused: u64,
    /// Outputs that were compared and are the same.
    pub same: u64,
    /// Outputs that overlap in a stretch wide enough to hide a difference.
    pub vague: u64,
    /// Outputs that are no number before a pass, or not known to be.
    pub nothing: u64,
    /// Outputs that were compared bit by bit.
    pub bits: u64,
}

impl Tally {
    /// Adds another one.
    pub fn add(&mut self, other: &Tally) {
        self.programs += other.programs;
        self.passes += other.passes;
        self.refused += other.refused;
        self.same += other.same;
        self.vague += other.vague;
        self.nothing += other.nothing;
        self.bits += other.bits;
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{} programs, {} passes and {} that refused; outputs over the reals: {} the same, \
             {} vague, {} no number before; bit by bit: {}",
            self.programs,
            self.passes,
            self.refused,
            self.same,
            self.vague,
            self.nothing,
            self.bits
        )
    }
}

/// A pass that did what its class forbids, or was accused of it wrongly.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The pass with its options.
    pub pass: String,
    /// What is wrong.
    pub what: String,
    /// The program it was given.
    pub program: String,
    /// What it made of it.
    pub result: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Finding {
            pass,
            what,
            program,
            result,
        } = self;
        write!(formatter, "{pass}: {what}\non\n{program}gave\n{result}")
    }
}

/// Runs a random pipeline over a random program with hostile constants.
///
/// # Panics
///
/// When a pass changes a value beyond its class.
pub fn results_stay_in_class(data: &[u8]) {
    // Bytes that run out make a smaller case, never a failure.
    if let Ok(Err(finding)) = examine(&mut Unstructured::new(data), &[]) {
        panic!("{finding}");
    }
}

/// As [`results_stay_in_class`], without some passes; gives what was found.
///
/// # Errors
///
/// When the bytes run out; and the finding, if there is one.
pub fn examine(
    bytes: &mut Unstructured<'_>,
    without: &[String],
) -> Result<std::result::Result<Tally, Box<Finding>>> {
    let Case {
        steps,
        machine,
        seed,
        mut module,
    } = Case::draw(bytes, without)?;
    let mut tally = Tally {
        programs: 1,
        ..Tally::default()
    };
    for step in &steps {
        match follow(&mut module, step, &machine, seed, &mut tally) {
            Ok(true) => {}
            Ok(false) => break,
            Err(finding) => return Ok(Err(finding)),
        }
    }
    Ok(Ok(tally))
}

/// The pipeline and the program of some bytes, as text: what to look at when
/// a case ends the process.
///
/// # Errors
///
/// When the bytes run out.
pub fn describe_case(bytes: &mut Unstructured<'_>) -> Result<String> {
    let case = Case::draw(bytes, &[])?;
    let program = print::print_module(&case.module);
    Ok(format!("// RUN: {}\n{program}", case.steps.join(",")))
}

/// A program and what is done to it.
struct Case {
    steps: Vec<String>,
    machine: Machine,
    seed: u64,
    module: Module,
}

impl Case {
    fn draw(bytes: &mut Unstructured<'_>, without: &[String]) -> Result<Case> {
        let mut steps: Vec<String> = Vec::new();
        for step in passes::steps(bytes, PASSES)? {
            let name = step.split('{').next().unwrap_or_default();
            if without.iter().any(|other| other == name) {
                // What follows may need another level than the program's.
                break;
            }
            steps.push(match name {
                // Its claim is known where the error is asked for; fitting
                // polynomials takes longer than all other passes together.
                "trigonometry" => {
                    let method = bytes.choose(&["taylor", "taylor", "taylor", "minimax"])?;
                    let range = bytes.choose(&["0.5", "2", "3"])?;
                    let error = bytes.choose(&["1e-2", "1e-5", "1e-9"])?;
                    format!("trigonometry{{method={method} range={range} error={error}}}")
                }
                _ => step,
            });
        }
        let machine = bytes.choose(&["ideal", "thesis", "fused"])?;
        Ok(Case {
            steps,
            machine: Machine::built_in(machine).expect("it ships"),
            seed: bytes.arbitrary()?,
            module: match bytes.int_in_range(0..=3)? {
                0 => module(bytes, Kind::Hostile)?,
                _ => equations(bytes, CONTENTS)?,
            },
        })
    }
}

const CONTENTS: Contents = Contents {
    definitions: 8,
    divisions: true,
    hostile: true,
};

/// Runs one pass and judges it; false when the pipeline ends with it.
fn follow(
    module: &mut Module,
    step: &str,
    machine: &Machine,
    seed: u64,
    tally: &mut Tally,
) -> std::result::Result<bool, Box<Finding>> {
    let before = module.clone();
    let accused = match execute(module, step, machine, Some(2), seed) {
        Ok(()) => None,
        Err(RunError::Pass { .. }) => {
            tally.refused += 1;
            return Ok(false);
        }
        // What the pass made is left in the module.
        Err(RunError::Check { reason, .. }) => {
            *module = before.clone();
            match execute(module, step, machine, None, seed) {
                Ok(()) => Some(reason),
                Err(error) => {
                    return Err(finding(
                        step,
                        format!("without the check: {error}"),
                        &before,
                        module,
                    ));
                }
            }
        }
        Err(error) => return Err(finding(step, error.to_string(), &before, module)),
    };
    tally.passes += 1;
    let judged = judge(&before, module, step, seed, tally);
    match (judged, accused) {
        (Ok(()), None) => {}
        (Ok(()), Some(reason)) => {
            let what = format!("the check refuses what the referee finds right: {reason}");
            return Err(finding(step, what, &before, module));
        }
        (Err(what), None) => {
            let what = format!("{what}\nand the check saw nothing");
            return Err(finding(step, what, &before, module));
        }
        (Err(what), Some(reason)) => {
            let what = format!("{what}\nthe check: {reason}");
            return Err(finding(step, what, &before, module));
        }
    }
    Ok(module
        .functions
        .iter()
        .all(|function| function.nodes().len() <= LARGEST))
}

fn finding(step: &str, what: String, before: &Module, after: &Module) -> Box<Finding> {
    Box::new(Finding {
        pass: step.to_owned(),
        what,
        program: print::print_module(before),
        result: print::print_module(after),
    })
}

fn execute(
    module: &mut Module,
    step: &str,
    machine: &Machine,
    check_each: Option<u32>,
    seed: u64,
) -> std::result::Result<(), RunError> {
    let pipeline = REGISTRY.pipeline(step).expect("made of known passes");
    let mut log = std::io::sink();
    let config = Config {
        check_each,
        states: States::new(seed),
        ..Config::new(machine, &mut log)
    };
    manager::run(module, &pipeline, config).map(|_| ())
}

/// What a step promises.
struct Promise {
    class: NumericClass,
    instances: Option<Instances>,
    leniency: Leniency,
    /// How large inputs may be.
    range: f64,
}

impl Promise {
    fn of(step: &PassStep) -> Promise {
        let pass = (step.info.build)(&step.options).expect("its options are its own");
        let option = |name: &str| {
            let mut options = step.options.iter();
            let found = options.find(|(option, _)| option == name);
            found.and_then(|(_, value)| value.parse::<f64>().ok())
        };
        // Series say how far they are off for angles within their range.
        let series = step.info.name == "trigonometry";
        Promise {
            class: pass.class(step.info.class),
            instances: pass.instances(),
            leniency: Leniency {
                // It replaces expressions of constants by their values.
                rounded_literals: matches!(step.info.name, "specialise" | "trigonometry"),
                circular: match series {
                    true => option("error").unwrap_or(0.0),
                    false => 0.0,
                },
            },
            range: match series {
                true => option("range").unwrap_or(f64::INFINITY),
                false => f64::INFINITY,
            },
        }
    }
}

/// Compares all functions with what they were; what is wrong first.
fn judge(
    before: &Module,
    after: &Module,
    step: &str,
    seed: u64,
    tally: &mut Tally,
) -> std::result::Result<(), String> {
    let pipeline = REGISTRY.pipeline(step).expect("made of known passes");
    let promise = Promise::of(pipeline.passes().next().expect("it is a pass"));
    for (old, new) in before.functions.iter().zip(&after.functions) {
        let old = View {
            tables: &before.tables,
            function: old,
        };
        let new = View {
            tables: &after.tables,
            function: new,
        };
        let count = promise
            .instances
            .as_ref()
            .map_or(1, |instances| instances.count);
        for instance in 1..=count {
            let pairing = Pairing {
                promise: &promise,
                instance,
                seed,
            };
            for point in 0..POINTS {
                pairing.compare(old, new, point, tally)?;
            }
        }
    }
    Ok(())
}

/// How the arrays of two versions belong together.
struct Pairing<'a> {
    promise: &'a Promise,
    /// The instance of a program with several, counted from 1.
    instance: u32,
    seed: u64,
}

impl Pairing<'_> {
    fn compare(
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
    fn pairs(
        &self,
        old: View<'_>,
        new: View<'_>,
    ) -> std::result::Result<Vec<(usize, usize)>, String> {
        let mut found = BTreeMap::new();
        for (place, assignment) in new.function.assignments.iter().enumerate() {
            found.insert(
                element(new, new.function.outputs(), assignment.output.0),
                place,
            );
        }
        let assignments = old.function.assignments.iter().enumerate();
        assignments
            .map(|(place, assignment)| {
                let (name, offset) = element(old, old.function.outputs(), assignment.output.0);
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
    fn inputs(&self, view: View<'_>, point: u32, after: bool) -> Vec<f64> {
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
                inputs.push(match number.abs() <= self.promise.range {
                    true => number,
                    false => self.promise.range * (number / (1.0 + number.abs())),
                });
            }
        }
        inputs
    }
}

/// A step of SplitMix64.
fn mix(state: u64) -> u64 {
    let state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let state = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let state = (state ^ state >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    state ^ state >> 31
}

/// The array and the place in it of a flattened element.
fn element(view: View<'_>, arrays: &[Array], index: u32) -> (String, u32) {
    let after = arrays.partition_point(|array| array.offset <= index);
    // Arrays without elements begin where the next one does.
    let array = arrays[..after]
        .iter()
        .rev()
        .find(|array| !array.shape.is_empty())
        .expect("an element lies in an array");
    let name = view.tables.symbols.text(array.name);
    (name.to_owned(), index - array.offset)
}

fn bit_by_bit(
    old: View<'_>,
    new: View<'_>,
    pairs: &[(usize, usize)],
    inputs: &[Vec<f64>; 2],
    tally: &mut Tally,
) -> std::result::Result<(), String> {
    if old.function.formats.is_some() {
        return in_formats(old, new, pairs, inputs, tally);
    }
    for single in [false, true] {
        let before = referee::in_hardware(old.function, &inputs[0], single);
        let after = referee::in_hardware(new.function, &inputs[1], single);
        for &(first, second) in pairs {
            let Some(number) = before[first] else {
                continue;
            };
            tally.bits += 1;
            // Zeros of either sign are equal.
            if after[second] != Some(number) {
                let format = if single { "binary32" } else { "binary64" };
                return Err(format!(
                    "{} in {format} is {number:?} before and {:?} after",
                    print::print_output(old, old.function.assignments[first].output),
                    after[second]
                ));
            }
        }
    }
    Ok(())
}

/// Each value in its own format.
fn in_formats(
    old: View<'_>,
    new: View<'_>,
    pairs: &[(usize, usize)],
    inputs: &[Vec<f64>; 2],
    tally: &mut Tally,
) -> std::result::Result<(), String> {
    let evaluate = |function: &Function, inputs: &[f64]| -> Vec<Option<f64>> {
        let values = evaluate_mixed_nodes(function, Format::BINARY64, inputs);
        let whole = values.iter().all(|value| value.is_finite());
        let assignments = function.assignments.iter();
        assignments
            .map(|assignment| match assignment.operand.kind() {
                OperandKind::Value(value) => Some(values[value.index()]).filter(|_| whole),
                _ => None,
            })
            .collect()
    };
    let before = evaluate(old.function, &inputs[0]);
    let after = evaluate(new.function, &inputs[1]);
    for &(first, second) in pairs {
        let (Some(before), Some(after)) = (before[first], after[second]) else {
            continue;
        };
        tally.bits += 1;
        if before != after {
            return Err(format!(
                "{} in formats of values is {before:?} before and {after:?} after",
                print::print_output(old, old.function.assignments[first].output)
            ));
        }
    }
    Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_constants_do_not_mislead_a_pass() {
        let mut tally = Tally::default();
        for case in 0..60u64 {
            arbtest::arbtest(|bytes| {
                match examine(bytes, &[])? {
                    Ok(one) => tally.add(&one),
                    Err(finding) => panic!("{finding}"),
                }
                Ok(())
            })
            .seed(case << 32 | 6000);
        }
        assert!(tally.programs > 40 && tally.same > 500, "{tally}");
        assert!(tally.vague + tally.nothing < tally.same, "{tally}");
    }
}
