//! Sums that cancel, written in forms that do not: the passes
//! `accurate-roots` and `accurate-trig`.
//!
//! Both search for a form of a sum ([`forms`]) that is equal wherever the sum
//! is defined, and use it where the ranges of the scene prove that it is
//! better: the error that the operations after it can make together, bounded
//! over all states in the ranges ([`robovec_analysis::interval`]), is at most
//! half the error before. Without ranges there is no proof and no rewrite.

mod cancelling_sum;
mod forms;
#[cfg(test)]
mod tests;
mod trial;

use cancelling_sum::CancellingSum;
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::{Rewriter, without_dead};
use robovec_ir::{Format, FreshNames, Function, Node, Operand, Operation, Value};
use robovec_num::limits::NumberLimit;
use std::collections::BTreeMap;
use trial::Trial;

declare_pass! {
    /// Writes sums with square roots and quotients without cancellation.
    ///
    /// `sqrt(a) - sqrt(b)` becomes `(a - b)/(sqrt(a) + sqrt(b))`, in which
    /// terms that `a` and `b` have in common are left out: of
    /// `sqrt(x + 1) - sqrt(x)` remains `1/(sqrt(x + 1) + sqrt(x))`. Likewise
    /// `p + sqrt(q)` becomes `(p*p - q)/(p - sqrt(q))` where terms of the
    /// numerator cancel, with either sign, as in the roots of a quadratic
    /// equation. Sums of quotients get a common denominator where terms of the
    /// numerator cancel: `1/(x + 1) - 1/x` becomes `-1/((x + 1)*x)`.
    ///
    /// Two conditions are proved. The new divisor has no zero in the ranges; of
    /// a difference of roots, `a - b` is a number other than zero, or bounds
    /// show that `a` or `b` is positive for all inputs. And the ranges of the
    /// scene prove that the largest error in `format` at any state in them is
    /// at most half the error before. A remark has both bounds. Inputs without
    /// a range in the scene prove nothing, so values that depend on them are
    /// unchanged.
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
    destroys: [Timed, Shared, ZeroFree],
}

declare_pass! {
    /// Writes `1 - cos(x)` and differences of sines and of cosines without
    /// cancellation.
    ///
    /// `1 - cos(x)` becomes `2*s*s` with `s = sin(0.5*x)`, and `cos(x) - 1`
    /// its negation. `sin(a) - sin(b)` becomes `2*cos(h)*sin(d)` and
    /// `cos(a) - cos(b)` becomes `-2*sin(h)*sin(d)`, with `h = 0.5*(a + b)` and
    /// `d = 0.5*(a - b)`, without the terms that `a` and `b` have in common.
    /// This holds for every angle. The condition that is
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
    destroys: [Timed, Shared, ZeroFree],
}

/// The seed of the scene's states; only their ranges count.
const SEED: u64 = 0;

/// Maximum work of a pass, in values of the function times differences.
const WORK: usize = 1 << 24;

/// A form of a sum that need not cancel.
#[derive(Clone, PartialEq, Debug)]
enum BetterForm {
    Operand(Operand),
    Number(f64),
    Sum(CancellingSum),
    /// An operation on other forms.
    Apply(Operation, Vec<BetterForm>),
}

impl BetterForm {
    fn apply<const N: usize>(operation: Operation, operands: [BetterForm; N]) -> BetterForm {
        BetterForm::Apply(operation, operands.into())
    }
}

/// Finds a form of a sum or a difference that is equal to it.
type FormFinder = fn(&Function, &Node) -> Option<BetterForm>;

impl Pass for AccurateRoots {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let settings = (self.format, self.boxes as usize);
        rewrite(
            function,
            context,
            settings,
            ("roots", forms::without_cancellation),
        );
        Ok(())
    }
}

impl Pass for AccurateTrig {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let settings = (self.format, self.boxes as usize);
        rewrite(
            function,
            context,
            settings,
            ("half angle", forms::of_angles),
        );
        Ok(())
    }
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
        context.remark(remark.to_owned());
        return;
    };
    let most = WORK / function.nodes().len().max(1);
    let differences = function
        .values()
        .filter(|(_, node)| matches!(node.operation, Operation::Add | Operation::Sub));
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
    context.count("differences rewritten", better.len() as u64);
    context.remarks.append(&mut remarks);
    if let Some((&last, _)) = better.last_key_value() {
        let (version, _) = written(function, &better, last);
        *function = without_dead(version);
    }
}

/// The function with differences in other forms, and the new form of one of
/// them.
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

/// Writes a form in place of a sum; the result has the name of the sum.
fn write(
    form: &BetterForm,
    rewriter: &mut Rewriter<'_>,
    node: Node,
    names: &mut FreshNames,
) -> Operand {
    let BetterForm::Apply(operation, operands) = form else {
        unreachable!("a form is an operation");
    };
    let operands = write_operands(operands, rewriter, node, names);
    let result = Node {
        operation: *operation,
        operands: listed(&operands),
        ..node
    };
    rewriter.new.push(result).into()
}

fn listed(operands: &[Operand]) -> [Operand; 3] {
    match *operands {
        [a] => Operand::list([a]),
        [a, b] => Operand::list([a, b]),
        _ => unreachable!("operations of forms have one or two operands"),
    }
}

/// Writes operands, one that occurs twice once.
fn write_operands(
    forms: &[BetterForm],
    rewriter: &mut Rewriter<'_>,
    node: Node,
    names: &mut FreshNames,
) -> Vec<Operand> {
    if let [a, b] = forms
        && a == b
    {
        return vec![write_part(a, rewriter, node, names); 2];
    }
    let write = |form| write_part(form, rewriter, node, names);
    forms.iter().map(write).collect()
}

/// Writes a part of a form.
fn write_part(
    form: &BetterForm,
    rewriter: &mut Rewriter<'_>,
    node: Node,
    names: &mut FreshNames,
) -> Operand {
    let mut push = |rewriter: &mut Rewriter<'_>, operation, operands: &[Operand]| {
        let new = Node {
            name: names.fresh(node.name.base),
            operands: listed(operands),
            operation,
            ..node
        };
        Operand::from(rewriter.new.push(new))
    };
    match form {
        BetterForm::Operand(operand) => rewriter.translate(*operand),
        BetterForm::Number(number) => rewriter.new.constant(*number).into(),
        BetterForm::Apply(operation, operands) => {
            let operands = write_operands(operands, rewriter, node, names);
            let new = Node {
                name: names.fresh(node.name.base),
                operands: listed(&operands),
                operation: *operation,
                ..node
            };
            rewriter.new.push(new).into()
        }
        BetterForm::Sum(terms) => {
            let mut sum: Option<Operand> = None;
            for (product, number) in terms.ordered() {
                let is_subtracted = number == -1.0 && !product.is_empty();
                let factor = (number.abs() != 1.0 || product.is_empty())
                    .then(|| Operand::from(rewriter.new.constant(number)));
                let operands = product.iter().map(|operand| rewriter.translate(*operand));
                let operands: Vec<Operand> = operands.chain(factor).collect();
                let mut term = operands[0];
                for &operand in &operands[1..] {
                    term = push(rewriter, Operation::Mul, &[term, operand]);
                }
                sum = Some(match (sum, is_subtracted) {
                    (Some(sum), true) => push(rewriter, Operation::Sub, &[sum, term]),
                    (Some(sum), false) => push(rewriter, Operation::Add, &[sum, term]),
                    (None, true) => push(rewriter, Operation::Neg, &[term]),
                    (None, false) => term,
                });
            }
            sum.unwrap_or_else(|| rewriter.new.constant(0.0).into())
        }
    }
}
