//! Every value in the cheapest format that the outputs allow.

mod assign;
mod measure;

use crate::accurate::SEED;
use assign::{Choices, FormatAssignment};
use measure::AccuracyCheck;
use robovec_analysis::rounding::usual_states;
use robovec_framework::check::Promise;
use robovec_framework::declare_pass;
use robovec_framework::options::OptionValue;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::scene::{Allowed, ArraySizes};
use robovec_ir::states::States;
use robovec_ir::{Format, Function, ValueFormats, View};
use robovec_num::NumberFormat;
use robovec_num::limits::{Amount, NumberLimit};

/// An error that outputs may have, relative.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Bound(pub f64);

impl OptionValue for Bound {
    const IS_NUMBER: bool = true;
    fn type_name() -> String {
        "number".to_owned()
    }
    fn parse(text: &str) -> Result<Bound, String> {
        text.parse()
            .map(Bound)
            .map_err(|_| format!("'{text}' is not a number"))
    }
    fn print(&self) -> String {
        format!("{:e}", self.0)
    }
    fn amount(&self) -> Option<Amount> {
        Some(Amount::Real(self.0))
    }
}

declare_pass! {
    /// Gives every value the cheapest number format that the outputs allow.
    ///
    /// Of the formats from `narrow` to `wide` every value gets one, so that no
    /// output is further from the exact one than `error` times the largest
    /// element of its array (or than the scene allows, where it does) in any of
    /// the random states that are tried. The cost of a format is counted in
    /// bits: a product or a quotient costs the square of the bits of the
    /// significand, as a multiplier does, a sum and a value that is only stored
    /// cost the bits.
    ///
    /// A rounding moves the outputs by its size times their derivative, so each
    /// value has, for each format, a share in the error; a value gets the
    /// format with the smallest sum of its cost and a price times its share,
    /// and the price is the lowest at which the measured errors are within what
    /// is allowed. Outputs with errors to spare then count for less, those
    /// without for more, and the search is repeated. Formats whose range does
    /// not hold a value with a margin of 4 are not given to it. The result is
    /// measured at fresh states, and the price raised until these agree.
    ///
    /// The pass works in both directions: with `wide=f64` and a small error it
    /// finds the few values that binary32 is too narrow for, with formats
    /// below binary32 the many that need less. The function with all values
    /// in `wide` must meet the error.
    ///
    /// Formats are kept by few passes, so this is one of the last.
    pub struct Mixed("mixed") {
        /// The largest error of an output, relative to the largest element of
        /// its array.
        pub error: Bound = Bound(1e-6) => NumberLimit::real(
            1e-30, 1e3, "no number format has a smaller error, and a larger one is useless"),
        /// The widest format.
        pub wide: Format = Format::BINARY64,
        /// The narrowest format.
        pub narrow: Format = Format::BINARY32,
        /// Number of formats between the two: their mantissas are
        /// equally far apart, their exponent is that of the wide one.
        pub between: u32 = 0 => NumberLimit::whole(
            0, 50, "there are no more mantissas between the narrowest and the widest"),
        /// Random states at which errors are measured, for choosing and again
        /// for checking; 0 for as many as the size of the function suggests.
        pub states: u32 = 0 => NumberLimit::whole(
            0, 10_000, "the function is measured at every state, and all results are kept"),
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Approximating,
}

/// The numbers of the first states for choosing and for checking.
const FIRST_CHOSEN: u32 = 2000;
const FIRST_CHECKED: u32 = 1_000_000;

/// The number of times that outputs are weighted again.
const ROUNDS: usize = 3;

/// Functions of more operations have one round.
const LARGEST_REPEATED: usize = 100_000;

/// The largest number of states for choosing; checking has twice as many.
const MAX_STATES: u32 = 64;

impl Pass for Mixed {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let formats = self.formats()?;
        if function.nodes().is_empty() {
            return Ok(());
        }
        let states = match context.scene {
            Some(scene) => scene.states(SEED),
            None => States::new(SEED),
        };
        let count = match self.states {
            0 => (usual_states(function.nodes().len()) / 4).clamp(8, MAX_STATES),
            states => states,
        };
        let view = context.tables.view(function);
        let sizes = ArraySizes::of(view, context.scene);
        let allowed = Allowed::new(view, context.scene, self.error.0, &sizes);
        let choosing = AccuracyCheck::new(view, &states, [FIRST_CHOSEN, count], &allowed);
        let checking = AccuracyCheck::new(view, &states, [FIRST_CHECKED, 2 * count], &allowed);
        let mut search = FormatSearch {
            view,
            states: states.clone(),
            allowed: &allowed,
            choosing,
            formats,
            weights: vec![1.0; function.assignments.len()],
        };
        let found = search.run().and_then(|(choices, price)| {
            let (assignment, ratio) = search.settle(&choices, price, &checking);
            (ratio <= 1.0).then_some((assignment, ratio)).ok_or(ratio)
        });
        let (assignment, ratio) = found.map_err(|ratio| self.unreachable(ratio))?;
        let formats = search.formats;
        tell(function, &assignment, &formats, ratio, context);
        function.formats = Some(assignment.formats(&formats));
        *context.promise = Some(Promise::Outputs {
            allowed,
            states,
            numbers: [FIRST_CHECKED, FIRST_CHECKED + 2 * count],
        });
        Ok(())
    }
}

impl Mixed {
    /// The formats to choose from, the narrowest first.
    fn formats(&self) -> Result<Vec<Format>, PassError> {
        let [low, high] = [self.narrow.significand(), self.wide.significand()];
        let steps = self.between + 1;
        let mut formats = vec![self.narrow];
        for step in 1..steps {
            let Format::Float(wide) = self.wide else {
                return Err(PassError::new(
                    "formats between two need a wide one that floats",
                ));
            };
            let bits = low
                + (u64::from(high.saturating_sub(low)) * u64::from(step) / u64::from(steps)) as u32;
            formats.push(Format::Float(NumberFormat {
                mantissa: bits.saturating_sub(1).max(1),
                ..wide
            }));
        }
        formats.push(self.wide);
        formats.dedup();
        if low <= high {
            Ok(formats)
        } else {
            let (narrow, wide) = (self.narrow, self.wide);
            let message = format!("the narrow format {narrow} has more digits than {wide}");
            Err(PassError::new(message).help("exchange 'narrow' and 'wide'"))
        }
    }

    fn unreachable(&self, ratio: f64) -> PassError {
        let (error, wide) = (self.error.print(), self.wide);
        let message = format!(
            "even with all values in {wide} an output has {ratio:.2} times the error allowed, \
             {error} of its array's largest element or the scene's limit"
        );
        PassError::new(message).help("allow a larger error or a wider format")
    }
}

/// The state of the search for formats.
struct FormatSearch<'a> {
    view: View<'a>,
    states: States,
    allowed: &'a Allowed,
    choosing: AccuracyCheck,
    formats: Vec<Format>,
    /// The weight of each output.
    weights: Vec<f64>,
}

impl FormatSearch<'_> {
    /// The choices and the price at which the cheapest assignment was found;
    /// the ratio of the error to the allowed one when even the widest format
    /// alone exceeds it.
    fn run(&mut self) -> Result<(Choices, i32), f64> {
        let widest = self.choosing.worst(self.view.function, &self.widest());
        if widest > 1.0 {
            return Err(widest);
        }
        let mut best: Option<(f64, Choices, i32)> = None;
        let large = self.view.function.nodes().len() > LARGEST_REPEATED;
        for _ in 0..if large { 1 } else { ROUNDS } {
            let choices = Choices::new(self);
            let price = self.cheapest(&choices);
            let assignment = choices.at(price);
            let ratios = self
                .choosing
                .ratios(self.view.function, &assignment.formats(&self.formats));
            let largest = ratios.iter().copied().fold(0.0, f64::max);
            if best
                .as_ref()
                .is_none_or(|(cost, ..)| assignment.cost < *cost)
            {
                best = Some((assignment.cost, choices, price));
            }
            if largest == 0.0 {
                break;
            }
            for (weight, ratio) in self.weights.iter_mut().zip(&ratios) {
                // By the root, and not to nothing: ratios are measured at a
                // few states and weights are to settle.
                *weight *= (ratio / largest).clamp(0.01, 1.0).sqrt();
            }
        }
        best.map(|(_, choices, price)| (choices, price))
            .ok_or(widest)
    }

    /// The lowest price that the chosen states accept.
    fn cheapest(&self, choices: &Choices) -> i32 {
        let (mut low, mut high) = assign::PRICES;
        while low < high {
            let middle = low + (high - low).div_euclid(2);
            let formats = choices.at(middle).formats(&self.formats);
            if self.choosing.worst(self.view.function, &formats) <= 1.0 {
                high = middle
            } else {
                low = middle + 1
            }
        }
        high
    }

    /// The assignment at the lowest price from this one on that fresh states
    /// accept as well; the widest format for all values when there is none.
    fn settle(
        &self,
        choices: &Choices,
        price: i32,
        checking: &AccuracyCheck,
    ) -> (FormatAssignment, f64) {
        let (mut price, mut step) = (price, 1);
        while price <= assign::PRICES.1 {
            let assignment = choices.at(price);
            let formats = assignment.formats(&self.formats);
            let function = self.view.function;
            let ratio = checking.worst(function, &formats);
            if ratio <= 1.0 && self.choosing.worst(function, &formats) <= 1.0 {
                return (assignment, ratio);
            }
            price += step;
            step += 1;
        }
        let count = self.view.function.nodes().len();
        let widest = FormatAssignment::all(count, self.formats.len() - 1);
        let ratio = checking.worst(self.view.function, &self.widest());
        (widest, ratio)
    }

    fn widest(&self) -> ValueFormats {
        let count = self.view.function.nodes().len();
        FormatAssignment::all(count, self.formats.len() - 1).formats(&self.formats)
    }
}

/// Statistics and one line on the result.
fn tell(
    function: &Function,
    assignment: &FormatAssignment,
    formats: &[Format],
    ratio: f64,
    context: &mut Context<'_>,
) {
    let counts = assignment.counts(formats.len());
    let parts: Vec<String> = formats
        .iter()
        .zip(&counts)
        .map(|(format, count)| format!("{count} in {format}"))
        .collect();
    let widest = assign::uniform_cost(function, formats[formats.len() - 1]);
    let part = assign::cost_of(function, assignment, formats) / widest * 100.0;
    context.remark(format!(
        "values {}; {part:.1} % of the cost of the widest format alone, largest error {:.2} of \
         what is allowed",
        parts.join(", "),
        ratio
    ));
    let narrow = counts[0];
    let total: u64 = counts.iter().sum();
    context.count("values in the narrow format", narrow);
    context.count("values in wider formats", total - narrow);
}
