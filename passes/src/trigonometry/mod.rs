//! Sines and cosines by operations of the processing elements.
//!
//! The thesis' machine adds and multiplies; sines and cosines are computed
//! before the run, or the thesis cuts their series off (1.2.2). This pass
//! writes them as polynomials ([`robovec_num::trigonometry`]) whose error on
//! the range of each angle is proved, and reports the proved bounds.

mod builder;
mod choose;
mod emit;
mod host;
mod options;
mod ranges;
mod recipe;
mod remarks;
mod rounding;
mod scheme;

use choose::{PolynomialChoice, Wish};
use emit::{Emitter, Treatment, circular};
pub use options::{AngleOption, CircularMethod, CircularPlace, FormatTolerance, Scheme};
use ranges::Angles;
pub use recipe::Recipe;
use robovec_analysis::class::NumericClass;
use robovec_analysis::slice::slice;
use robovec_framework::check::Promise;
use robovec_framework::declare_pass;
use robovec_framework::options::OptionValue;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::scene::Scene;
use robovec_ir::states::Ranges;
use robovec_ir::{Function, Input, Machine, Operand, SourceSet, Tables};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::interval::Interval;
use robovec_num::limits::NumberLimit;
use robovec_num::trigonometry::halving::MAX_HALVINGS;
use robovec_num::trigonometry::{Halved, LARGEST_RANGE, MAX_ORDER};
use std::array;
use std::collections::BTreeMap;
use std::sync::Arc;

declare_pass! {
    /// Computes sines and cosines by sums and products, with a proved error.
    ///
    /// `method=taylor` cuts the series of Taylor off after the power `order`
    /// of the angle: order 1 is `sin x = x` and `cos x = 1`, order 3 is
    /// `x - x^3/6` and `1 - x^2/2`, as in the thesis (1.2.2).
    /// `method=minimax` takes the polynomials of the same powers whose largest
    /// error on the range of the angle is smallest: 2^order times smaller.
    /// `method=true` leaves sines and cosines to the host.
    ///
    /// The range of an angle follows from the ranges of its inputs (those of the scene, else
    /// `range` for each of them) by interval arithmetic: the sum of two joints has twice the range
    /// of one. Without an order the smallest one is taken whose proved error on that range is at
    /// most `error`. `halvings` divides angles by a power of two first and doubles them back with
    /// `sin 2y = 2 sin y cos y` and `cos 2y = 1 - 2 sin² y`, so that large angles need no large
    /// orders.
    ///
    /// For every range a remark gives the proved bounds: the largest error of
    /// sine and cosine with the rounded coefficients, and the most that
    /// rounding in the machine's format adds. Angles without a known range stay
    /// with the host. Equal angles share their square. Follow it by `fold` to
    /// get rid of the cosines that are 1.
    ///
    /// With `on=host` sines and cosines are computed before the run, where
    /// there are comparisons, shifts and tables, for angles of any size:
    /// `method=polynomial` on an eighth of a turn, `method=table` with a table
    /// of `entries` and polynomials of `degree`, `method=cordic` with
    /// `iterations` rotations, all in integers with `bits` after the point.
    /// The function keeps its sines and cosines; what computes them is
    /// recorded in its metadata, and evaluation in a format, memory images and
    /// the simulator compute them so, bit by bit.
    pub struct Trigonometry("trigonometry") {
        /// Way in which sines and cosines are computed.
        pub method: CircularMethod = CircularMethod::Minimax,
        /// The largest power of the angle; 0 for what `error` needs.
        pub order: u32 = 0 => NumberLimit::whole(
            0, MAX_ORDER as u64, "coefficients of higher powers are below the rounding of binary64"),
        /// The largest error allowed where no order is given; `machine` is
        /// the rounding of the machine's number format.
        pub error: FormatTolerance = FormatTolerance(None) => NumberLimit::real(
            1e-30, 1e3, "no number format has a smaller error, and sines are never larger than 1"),
        /// The size that inputs of angles do not exceed, in radians.
        pub range: AngleOption = AngleOption(std::f64::consts::PI) => NumberLimit::real(
            1e-12, 1e6, "smaller angles are practically zero, and no series is accurate for larger ones"),
        /// Number of times angles are halved.
        pub halvings: u32 = 0 => NumberLimit::whole(
            0, MAX_HALVINGS as u64, "every halving doubles the rounding error and adds operations"),
        /// The order of evaluation.
        pub scheme: Scheme = Scheme::Shortest,
        /// Coefficients are numbers of the machine's format.
        pub round: bool = true,
        /// By processing elements or before the run.
        pub on: CircularPlace = CircularPlace::Elements,
        /// Of a table: entries for an eighth of a turn, a power of two.
        pub entries: u32 = 64 => NumberLimit::whole(
            1, 65_536, "the table is kept in memory and in every manifest"),
        /// Of a table: the largest power of the rest of the angle.
        pub degree: u32 = 3 => NumberLimit::whole(
            1, MAX_ORDER as u64, "coefficients of higher powers are below the rounding of binary64"),
        /// Of `cordic`: rotations.
        pub iterations: u32 = 24 => NumberLimit::whole(
            1, 60, "later rotations are smaller than any number of 64 bits"),
        /// On the host: bits after the point.
        pub bits: u32 = 32 => NumberLimit::whole(
            8, 50, "products must fit into 128 bits, and results into binary64"),
    }
    takes: [Equations, Atomic],
    gives: Gives::Same,
    class: Approximating,
    destroys: [Timed, ZeroFree, Shared, Live],
}

impl Pass for Trigonometry {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        if self.method == CircularMethod::True {
            return Ok(());
        }
        self.check()?;
        if self.on == CircularPlace::Host {
            return self.record(function, context);
        }
        let bounds = self.input_bounds(function, context);
        let input = |input: Input| bounds[input.index()];
        let angles = Angles::new(function, &input);
        let occurrences = occurrences(function, &angles, &input);
        let decided = self.decide(&occurrences, context)?;
        let Decided {
            treatments,
            choices,
            recipes,
        } = decided;
        *context.promise = Some(promise(function, context.tables, &bounds, &choices));
        let before = function.nodes().len();
        let rule = self.rule();
        let (new, replaced) = Emitter::run(function, &angles, &treatments, &recipes, rule, context);
        let after = new.nodes().len();
        *function = new;
        remarks::tell(&choices, &recipes, &treatments, &occurrences, context);
        let added = (after + replaced as usize).saturating_sub(before);
        context.statistics.extend([
            ("sines and cosines replaced", replaced),
            ("angles", treatments.len() as u64),
            ("operations added", added as u64),
        ]);
        Ok(())
    }

    fn class(&self, declared: NumericClass) -> NumericClass {
        match self.method {
            CircularMethod::True => NumericClass::Exact,
            _ => declared,
        }
    }
}

/// The promise that is proved of the function: errors of sines and cosines,
/// while the inputs that angles depend on lie within their bounds.
fn promise(
    function: &Function,
    tables: &Tables,
    bounds: &[Interval],
    choices: &[(f64, PolynomialChoice)],
) -> Promise {
    let angles: Vec<Operand> = function
        .nodes()
        .iter()
        .filter(|node| circular(node).is_some())
        .map(|node| node.operands[0])
        .collect();
    let values = slice(function, &angles);
    let read = values
        .iter()
        .flat_map(|&value| function.node(value).operands());
    let mut ranges = Ranges::default();
    for input in read.chain(&angles).filter_map(|operand| operand.input()) {
        let (array, indices, _) = function.input_element(input);
        let Interval { low, high } = bounds[input.index()];
        ranges.set(tables.symbols.text(array.name), indices, low, high);
    }
    // Angles that are numbers are rounded once.
    let errors = choices
        .iter()
        .fold([f64::EPSILON; 2], |worst, (_, choice)| {
            array::from_fn(|of| worst[of].max(choice.errors[of]))
        });
    Promise::Waves {
        ranges: Arc::new(ranges),
        errors,
    }
}

/// One angle with all its sines and cosines.
struct CircularAngle {
    /// Between these bounds it lies.
    bounds: Option<Interval>,
    /// The number, if known.
    known: Option<f64>,
    /// For the sine and for the cosine a flag: true when it occurs.
    wanted: [bool; 2],
    /// The sources of the place of its first occurrence.
    sources: SourceSet,
}

/// The angles of a function, by their keys.
fn occurrences(
    function: &Function,
    angles: &Angles,
    input: &dyn Fn(Input) -> Interval,
) -> BTreeMap<u64, CircularAngle> {
    let mut found: BTreeMap<u64, CircularAngle> = BTreeMap::new();
    for node in function.nodes() {
        let Some(of) = circular(node) else { continue };
        let operand = node.operands[0];
        let occurrence = found
            .entry(angles.key(operand))
            .or_insert_with(|| CircularAngle {
                bounds: angles.bounds(function, operand, input),
                known: function.number(operand),
                wanted: [false; 2],
                sources: node.sources,
            });
        occurrence.wanted[recipe::place(of)] = true;
    }
    found
}

/// The decisions for every angle.
struct Decided {
    treatments: BTreeMap<u64, Treatment>,
    /// One per recipe: its range and the chosen polynomials.
    choices: Vec<(f64, PolynomialChoice)>,
    recipes: Vec<Recipe>,
}

impl Trigonometry {
    /// The rule noted for values.
    fn rule(&self) -> &'static str {
        match self.method {
            CircularMethod::Taylor => "taylor",
            _ => "minimax",
        }
    }

    fn check(&self) -> Result<(), PassError> {
        let (method, place) = (self.method.print(), self.on.print());
        let elsewhere = match self.method {
            CircularMethod::Taylor | CircularMethod::Minimax => CircularPlace::Elements,
            _ => CircularPlace::Host,
        };
        if self.on != elsewhere {
            let help = match elsewhere {
                CircularPlace::Elements => "on the host: polynomial, table or cordic",
                CircularPlace::Host => {
                    "the elements neither compare nor shift: set on=host, or take taylor or minimax"
                }
            };
            let message = format!("method={method} is not for on={place}");
            return Err(PassError::new(message).help(help));
        }
        if self.order > MAX_ORDER {
            return Err(PassError::new(format!(
                "order={} is beyond the largest order, {MAX_ORDER}",
                self.order
            ))
            .help("halvings=2 or more brings large angles within reach of low orders"));
        }
        if self.halvings > MAX_HALVINGS {
            return Err(PassError::new(format!(
                "halvings={} is more than {MAX_HALVINGS}",
                self.halvings
            )));
        }
        Ok(())
    }

    /// The bounds of every input element: those of the scene, if it has any,
    /// else `range`.
    fn input_bounds(&self, function: &Function, context: &Context<'_>) -> Vec<Interval> {
        let known = context.scene.map(Scene::known_inputs);
        let bounds = |index: usize| {
            let (array, indices, _) = function.input_element(Input(index as u32));
            let name = context.tables.symbols.text(array.name);
            let range = known.as_ref().and_then(|known| known.get(name, indices));
            range.map_or(Interval::within(self.range.0), |[low, high]| Interval {
                low,
                high,
            })
        };
        (0..function.input_len()).map(bounds).collect()
    }

    fn wish(&self, machine: &Machine) -> Wish {
        let format = machine.number;
        Wish {
            method: self.method,
            order: self.order,
            error: self.error.0.unwrap_or(format.unit_roundoff()),
            halvings: self.halvings,
            format: self.round.then_some(format),
        }
    }

    /// The polynomials that angles of at most `range` radians get on a machine,
    /// and the proved absolute errors of the sine and the cosine they give;
    /// `None` when no order keeps the error that is requested.
    pub fn polynomials(&self, machine: &Machine, range: f64) -> Option<(Halved, [f64; 2])> {
        let choice = self.wish(machine).choose(range, [true; 2])?;
        Some((choice.halved, choice.errors))
    }

    fn decide(
        &self,
        occurrences: &BTreeMap<u64, CircularAngle>,
        context: &Context<'_>,
    ) -> Result<Decided, PassError> {
        let wish = self.wish(context.machine);
        let mut decided = Decided {
            treatments: BTreeMap::new(),
            choices: Vec::new(),
            recipes: Vec::new(),
        };
        let mut known: BTreeMap<(u64, [bool; 2]), usize> = BTreeMap::new();
        for (&key, occurrence) in occurrences {
            let range = occurrence.bounds.map(Interval::magnitude);
            let treatment = match (occurrence.known, range) {
                (Some(number), _) if number.abs() <= LARGEST_RANGE => {
                    let angle = Double::from(number);
                    let exact = [DoubleDouble.sin(angle), DoubleDouble.cos(angle)];
                    Treatment::Known(exact.map(|number| number.high))
                }
                (_, Some(range)) if range <= LARGEST_RANGE => {
                    let wanted = occurrence.wanted;
                    let index = match known.get(&(range.to_bits(), wanted)) {
                        Some(&index) => index,
                        None => {
                            let choice = wish
                                .choose(range, wanted)
                                .ok_or_else(|| self.beyond(range, wish.error, occurrence))?;
                            let recipe =
                                Recipe::new(&choice.halved, wanted, context.machine, self.scheme);
                            decided.choices.push((range, choice));
                            decided.recipes.push(recipe);
                            let index = decided.recipes.len() - 1;
                            known.insert((range.to_bits(), wanted), index);
                            index
                        }
                    };
                    Treatment::Computed(index)
                }
                _ => Treatment::Left,
            };
            decided.treatments.insert(key, treatment);
        }
        Ok(decided)
    }

    fn beyond(&self, range: f64, error: f64, occurrence: &CircularAngle) -> PassError {
        PassError::new(format!(
            "no polynomial up to order {MAX_ORDER} has an error below {error:.1e} for angles \
             of ±{range:.4}"
        ))
        .at(occurrence.sources)
        .help("set halvings=2 or more, a smaller range, a larger error, or round=false")
    }
}
