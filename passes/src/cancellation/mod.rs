//! Differences that cancel, written in forms that do not: the passes
//! `accurate-roots` and `accurate-trig`.
//!
//! Both look for a form of a difference that is equal wherever the difference
//! is defined, and take it where the ranges of the scene prove that it is
//! better: the error that the operations after it can lose together, bounded
//! over all states in the ranges ([`robovec_analysis::interval`]), is at most
//! half of what it was. Without ranges nothing is proved, and nothing is
//! rewritten.

mod difference;
#[cfg(test)]
mod tests;
mod trial;

use difference::Difference;
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::{Rewriter, without_dead};
use robovec_ir::{Format, FreshNames, Function, Node, Operand, Operation, Value};
use robovec_num::limits::NumberLimit;
use std::collections::BTreeMap;
use trial::Trial;

declare_pass! {
    /// Writes differences of square roots without cancellation.
    ///
    /// `sqrt(a) - sqrt(b)` becomes `(a - b)/(sqrt(a) + sqrt(b))`, in which
    /// terms that `a` and `b` have in common are left out: of
    /// `sqrt(x + 1) - sqrt(x)` remains `1/(sqrt(x + 1) + sqrt(x))`.
    ///
    /// Two conditions are proved. The new divisor has no zero: `a - b` is a
    /// number other than zero, or bounds show that `a` or `b` is positive
    /// whatever the inputs. And the ranges of the scene show that the largest
    /// error in `format` of any state in them is at most half of what it was.
    /// A remark has both bounds. Inputs without a range in the scene prove
    /// nothing, so what depends on them stays as it is.
    pub struct AccurateRoots("accurate-roots") {
        /// The number format whose rounding counts.
        pub format: Format = Format::BINARY32,
        /// Boxes into which ranges are cut for a bound.
        pub boxes: u32 = 200 => NumberLimit::whole(
            1, 100_000, "every operation before the difference is enclosed in every box"),
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Real,
    requires: [],
    sets: [],
    destroys: [Timed, Shared, ZeroFree],
}

declare_pass! {
    /// Writes `1 - cos(x)` without cancellation.
    ///
    /// `1 - cos(x)` becomes `2*s*s` with `s = sin(0.5*x)`, and `cos(x) - 1`
    /// its negation, which holds for every angle. The condition that is
    /// proved from the ranges of the scene is that the largest error in
    /// `format` of any state in them is at most half of what it was; a remark
    /// has both bounds. Inputs without a range in the scene prove nothing.
    ///
    /// The sine is of half an angle, which a host that prepares sines and
    /// cosines of joints may not offer.
    pub struct AccurateTrig("accurate-trig") {
        /// The number format whose rounding counts.
        pub format: Format = Format::BINARY32,
        /// Boxes into which ranges are cut for a bound.
        pub boxes: u32 = 200 => NumberLimit::whole(
            1, 100_000, "every operation before the difference is enclosed in every box"),
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: RealTrig,
    requires: [],
    sets: [],
    destroys: [Timed, Shared, ZeroFree],
}

/// The seed of the scene's states; only their ranges count.
const SEED: u64 = 0;

/// Maximum work of a pass, in values of the function times differences.
const WORK: usize = 1 << 24;

/// A form of a difference that need not cancel.
#[derive(Clone, Debug)]
enum BetterForm {
    /// A numerator over the sum of two roots.
    Conjugate {
        numerator: Difference,
        roots: [Operand; 2],
    },
    /// Twice the square of the sine of half an angle, times a sign.
    HalfAngle { angle: Operand, factor: f64 },
}

/// Finds a form of a difference that is equal to it.
type FormFinder = fn(&Function, &Node) -> Option<BetterForm>;

impl Pass for AccurateRoots {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let settings = (self.format, self.boxes as usize);
        rewrite(function, context, settings, ("roots", conjugate));
        Ok(())
    }
}

impl Pass for AccurateTrig {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let settings = (self.format, self.boxes as usize);
        rewrite(function, context, settings, ("half angle", half_angle));
        Ok(())
    }
}

/// The operand of the operation of this kind that gives an operand.
fn argument(function: &Function, operand: Operand, operation: Operation) -> Option<Operand> {
    let node = function.node(operand.value()?);
    (node.operation == operation).then_some(node.operands[0])
}

fn conjugate(function: &Function, node: &Node) -> Option<BetterForm> {
    let roots = [node.operands[0], node.operands[1]];
    let root = |operand| argument(function, operand, Operation::Sqrt);
    let (a, b) = (root(roots[0])?, root(roots[1])?);
    let numerator = Difference::new(function, a, b);
    let positive = || trial::is_positive(function, a) || trial::is_positive(function, b);
    let safe = numerator.number().is_some_and(|number| number != 0.0) || positive();
    safe.then_some(BetterForm::Conjugate { numerator, roots })
}

fn half_angle(function: &Function, node: &Node) -> Option<BetterForm> {
    let [a, b, _] = node.operands;
    let cosine = |operand| argument(function, operand, Operation::Cos);
    let one = |operand| function.number(operand) == Some(1.0);
    let (angle, factor) = match (cosine(a), cosine(b)) {
        (None, Some(angle)) if one(a) => (angle, 2.0),
        (Some(angle), None) if one(b) => (angle, -2.0),
        _ => return None,
    };
    Some(BetterForm::HalfAngle { angle, factor })
}

/// Rewrites every difference that a form is proved better for.
fn rewrite(
    function: &mut Function,
    context: &mut Context<'_>,
    settings: (Format, usize),
    (rule, form): (&str, FormFinder),
) {
    let Some(scene) = context.scene else {
        let remark = "no scene gives ranges, so nothing is proved and nothing rewritten";
        context.remarks.push(remark.to_owned());
        return;
    };
    let most = WORK / function.nodes().len().max(1);
    let differences = function
        .values()
        .filter(|(_, node)| node.operation == Operation::Sub);
    let found = differences.filter_map(|(value, node)| Some((value, form(function, node)?)));
    let found: Vec<(Value, BetterForm)> = found.take(most).collect();
    let trial = Trial::new(context.tables, scene, settings);
    let mut better = BTreeMap::new();
    let mut remarks = Vec::new();
    for (value, form) in found {
        let Some(old) = trial.bound(function, value.into()) else {
            continue;
        };
        let alone = BTreeMap::from([(value, form.clone())]);
        let (version, operand) = written(function, &alone, value);
        let Some(new) = trial
            .bound(&version, operand)
            .filter(|new| 2.0 * new <= old)
        else {
            continue;
        };
        let name = function.node(value).name;
        if !context.allow_rewrite(name, rule) {
            continue;
        }
        context.notes.note(name, rule);
        let name = name.display(&context.tables.symbols);
        remarks.push(format!(
            "%{name} is off by {new:.2e} at most in the scene's ranges, instead of {old:.2e}"
        ));
        better.insert(value, form);
    }
    context
        .statistics
        .push(("differences rewritten", better.len() as u64));
    context.remarks.append(&mut remarks);
    if let Some((&last, _)) = better.last_key_value() {
        let (version, _) = written(function, &better, last);
        *function = without_dead(version);
    }
}

/// The function with differences in other forms, and what one of them has
/// become.
fn written(
    function: &Function,
    forms: &BTreeMap<Value, BetterForm>,
    wanted: Value,
) -> (Function, Operand) {
    let mut rewriter = Rewriter::new(function, function.level);
    let mut names = function.fresh_names();
    for (value, node) in function.values() {
        let operands = rewriter.translate_operands(node);
        let node = Node { operands, ..*node };
        match forms.get(&value) {
            None => {
                rewriter.keep(node);
            }
            Some(form) => {
                let operand = write(form, &mut rewriter, node, &mut names);
                rewriter.record(operand);
            }
        }
    }
    let operand = rewriter.known(wanted);
    (rewriter.finish(), operand)
}

/// Writes a form instead of a difference, whose name the result has.
fn write(
    form: &BetterForm,
    rewriter: &mut Rewriter<'_>,
    node: Node,
    names: &mut FreshNames,
) -> Operand {
    let mut push = |rewriter: &mut Rewriter<'_>, operation, operands: [Operand; 2]| {
        let new = Node {
            name: names.fresh(node.name.base),
            operands: match operation {
                Operation::Sin => Operand::list([operands[0]]),
                _ => Operand::list(operands),
            },
            operation,
            ..node
        };
        Operand::from(rewriter.new.push(new))
    };
    let (operation, operands) = match form {
        BetterForm::Conjugate { numerator, roots } => {
            let roots = roots.map(|root| rewriter.translate(root));
            let above = numerator.write(rewriter, &mut push);
            let below = push(rewriter, Operation::Add, roots);
            (Operation::Div, [above, below])
        }
        BetterForm::HalfAngle { angle, factor } => {
            let angle = rewriter.translate(*angle);
            let [half, factor] = [0.5, *factor].map(|number| rewriter.new.constant(number).into());
            let half = push(rewriter, Operation::Mul, [half, angle]);
            let sine = push(rewriter, Operation::Sin, [half, half]);
            let square = push(rewriter, Operation::Mul, [sine, sine]);
            (Operation::Mul, [factor, square])
        }
    };
    let result = Node {
        operation,
        operands: Operand::list(operands),
        ..node
    };
    rewriter.new.push(result).into()
}
