//! A format for every value, at a price for errors.

use super::FormatSearch;
use crate::accurate::profile::{LANES, SensitivityProfile, StateLanes};
use robovec_framework::scene::Allowed;
use robovec_ir::cost::OperationWork;
use robovec_ir::{Format, Function, Node, Operation, Value, ValueFormats};
use robovec_num::soft_float::FormatArithmetic;

/// Exponents of the price of errors: two to this many.
pub(super) const PRICES: (i32, i32) = (-40, 160);

/// Profiles of [`LANES`] states each that shares in the error come from.
const PROFILES: u32 = 2;

/// The range of a format must hold values this many times as large as any
/// that were seen.
const MARGIN: f64 = 4.0;

/// The available formats.
pub(super) struct Choices {
    /// By node and format: cost, and share in the squared error.
    options: Vec<(f64, f64)>,
    formats: usize,
}

/// One format, by its number, for every value.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct FormatAssignment {
    chosen: Vec<u8>,
    pub(super) cost: f64,
}

impl FormatAssignment {
    /// All values in one format.
    pub(super) fn all(count: usize, format: usize) -> FormatAssignment {
        assert!(u8::try_from(format).is_ok(), "formats are counted in bytes");
        FormatAssignment {
            chosen: vec![format as u8; count],
            cost: 0.0,
        }
    }

    /// The formats of a function.
    pub(super) fn formats(&self, formats: &[Format]) -> ValueFormats {
        let mut all = ValueFormats::new(self.chosen.len());
        for (index, &chosen) in self.chosen.iter().enumerate() {
            all.set(Value(index as u32), Some(formats[usize::from(chosen)]));
        }
        all
    }

    /// The number of values of each format.
    pub(super) fn counts(&self, formats: usize) -> Vec<u64> {
        let mut counts = vec![0; formats];
        for &chosen in &self.chosen {
            counts[usize::from(chosen)] += 1;
        }
        counts
    }
}

pub(super) fn cost_of(
    function: &Function,
    assignment: &FormatAssignment,
    formats: &[Format],
) -> f64 {
    assert_eq!(
        assignment.chosen.len(),
        function.nodes().len(),
        "every value has a format"
    );
    let nodes = function.nodes().iter().zip(&assignment.chosen);
    nodes
        .map(|(node, &chosen)| cost(node.operation, formats[usize::from(chosen)]))
        .sum()
}

pub(super) fn uniform_cost(function: &Function, format: Format) -> f64 {
    OperationWork::of(function).cost(format)
}

fn cost(operation: Operation, format: Format) -> f64 {
    OperationWork::of_operation(operation).cost(format)
}

impl Choices {
    /// Costs and shares of all values in all formats.
    pub(super) fn new(search: &FormatSearch<'_>) -> Choices {
        let function = search.view.function;
        let formats = &search.formats;
        assert!(
            formats.len() <= 1 << u8::BITS,
            "a byte distinguishes the formats"
        );
        let arithmetics: Vec<FormatArithmetic> = formats
            .iter()
            .map(|&format| FormatArithmetic::mixed(format))
            .collect();
        let count = function.nodes().len();
        let mut options = vec![(0.0, 0.0); count * formats.len()];
        for part in 0..PROFILES {
            let seeds = |profile: &SensitivityProfile| {
                seeds(function, profile, search.allowed, &search.weights)
            };
            let first = part * LANES as u32;
            let profile = SensitivityProfile::with_seeds(search.view, &search.states, first, seeds);
            for (value, node) in function.values() {
                let index = value.index();
                let partials = profile.partials(function, index);
                for (place, arithmetic) in arithmetics.iter().enumerate() {
                    let (_, share) = &mut options[index * formats.len() + place];
                    let own = |lane: usize| {
                        let value = profile.value(index)[lane];
                        let rounded = constants(function, node, &partials, lane, arithmetic);
                        let error = rounding(formats[place], value).hypot(rounded);
                        let moved = profile.adjoint(index)[lane] * error;
                        match error == f64::INFINITY {
                            true => f64::INFINITY,
                            false if moved.is_nan() => 0.0,
                            false => moved * moved,
                        }
                    };
                    *share += (0..LANES).map(own).sum::<f64>() / f64::from(PROFILES * LANES as u32);
                }
            }
        }
        for (index, node) in function.nodes().iter().enumerate() {
            for (place, &format) in formats.iter().enumerate() {
                options[index * formats.len() + place].0 = cost(node.operation, format);
            }
        }
        Choices {
            options,
            formats: formats.len(),
        }
    }

    /// For every value the format with the smallest cost plus price times
    /// share; of equals the narrower.
    pub(super) fn at(&self, price: i32) -> FormatAssignment {
        let price = 2f64.powi(price);
        let mut total = 0.0;
        let chosen = self.options.chunks(self.formats).map(|options| {
            let mut best = (f64::INFINITY, options.len() - 1);
            for (place, (cost, share)) in options.iter().enumerate() {
                // No price makes up for a range that is too small.
                let sum = if *share == 0.0 {
                    *cost
                } else {
                    cost + price * share
                };
                if sum < best.0 {
                    best = (sum, place);
                }
            }
            total += options[best.1].0;
            best.1 as u8
        });
        let chosen = chosen.collect();
        FormatAssignment {
            chosen,
            cost: total,
        }
    }
}

/// The weights of the outputs: errors count in units of the allowed ones.
fn seeds(
    function: &Function,
    profile: &SensitivityProfile,
    allowed: &Allowed,
    weights: &[f64],
) -> Vec<StateLanes> {
    let outputs: Vec<StateLanes> = function
        .assignments
        .iter()
        .map(|assignment| profile.operand(function, assignment.operand))
        .collect();
    let mut seeds = vec![[0.0; LANES]; outputs.len()];
    for lane in 0..LANES {
        let values: Vec<f64> = outputs.iter().map(|output| output[lane]).collect();
        for ((seed, allowed), weight) in seeds.iter_mut().zip(allowed.of(&values)).zip(weights) {
            seed[lane] = weight / allowed;
        }
    }
    seeds
}

/// The error that the constants of an operation bring, rounded to the format
/// of its result.
fn constants(
    function: &Function,
    node: &Node,
    partials: &[StateLanes],
    lane: usize,
    arithmetic: &FormatArithmetic,
) -> f64 {
    let operands = node.operands().iter().zip(partials);
    let errors = operands.filter_map(|(&operand, partial)| {
        let number = function.number(operand)?;
        Some(partial[lane] * (arithmetic.convert(number) - number))
    });
    errors.sum()
}

/// The largest rounding error of a number in a format; infinite where the
/// format may not hold it.
fn rounding(format: Format, number: f64) -> f64 {
    let size = number.abs();
    match format {
        Format::Float(float) => {
            let most = 2f64.powi(float.largest_exponent());
            if size * MARGIN >= most && size.is_finite() {
                return f64::INFINITY;
            }
            let least = 2f64.powi(float.smallest_exponent());
            match (size < least, float.subnormals) {
                (true, false) => size,
                (true, true) => least * format.unit_roundoff(),
                (false, _) => size * format.unit_roundoff(),
            }
        }
        Format::Fixed(fixed) => {
            if size * MARGIN >= 2f64.powi(fixed.integer as i32) {
                f64::INFINITY
            } else {
                format.unit_roundoff()
            }
        }
    }
}
