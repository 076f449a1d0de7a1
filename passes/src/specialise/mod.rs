//! A function specialised to a scene: `specialise`.
//!
//! Slicing keeps the outputs that are needed, partial evaluation ([`evaluate`])
//! propagates known values through the function once. A value is a number, an
//! operand, or a *form*: a number plus operands times numbers. Forms of values
//! that are read once are not computed but passed on to their reader, where
//! numbers meet: `(a*x)*b` becomes `(a*b)*x`, `a*x + b*x` becomes `(a+b)*x`,
//! and `a*x + a*y` becomes `a*(x+y)`.
//!
//! Numbers are combined in double-double and rounded once. The proof is about
//! the function before that: the pass leaves a *witness* in its context, in
//! which numbers are still expressions ([`mod@write`]), and the semantic check
//! shows that it equals the input wherever the bound inputs have their numbers,
//! and that the result differs from it only in rounded constants.

pub(crate) mod constants;
mod evaluate;
mod form;
pub(crate) mod slice;
pub mod support;
pub(crate) mod write;

use constants::KnownNumbers;
use evaluate::{OperationTally, PartialEvaluator};
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::{lay_out, without_dead};
use robovec_framework::scene::Scene;
use robovec_ir::{Function, Level};
use slice::SliceSignature;

declare_pass! {
    /// Keeps only the parts of a function that a scene needs (`--scene FILE`).
    ///
    /// Outputs the scene does not need are dropped with all that only they
    /// depended on; inputs it binds become numbers, and what depends on
    /// numbers alone is computed now. Zeros and ones vanish, numbers in
    /// products and sums meet (`(a*x)*b` becomes `(a*b)*x`, `a*x + b*x`
    /// becomes `(a+b)*x`), and terms with the same number are summed before
    /// they are multiplied. Sines and cosines of known angles are numbers.
    /// Numbers are combined in double-double and rounded once, to binary64.
    ///
    /// Inputs that the outputs do not depend on, though they are read, become
    /// numbers as well: each is drawn anew at points of two prime fields, and
    /// no output changes.
    ///
    /// Arrays of which nothing is read or set any more are dropped. Without a
    /// scene nothing is bound, and only numbers that occur in the function are
    /// known. The check sets bound inputs to their numbers and proves the
    /// function exactly in its form before constants are rounded.
    pub struct Specialise("specialise") {}
    takes: [Equations, Atomic],
    gives: Gives::Same,
    class: Real,
    sets: [Live],
    destroys: [Timed],
}

impl Pass for Specialise {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let empty = Scene::default();
        let scene = context.scene.unwrap_or(&empty);
        let view = context.tables.view(function);
        let (sliced, [outputs, unneeded]) = slice::needed(view, scene);
        let view = context.tables.view(&sliced);
        let mut bound = scene.bound.of(view);
        let known = count(&bound);
        match support::without_influence(view, &bound, scene) {
            None => context.remark(support::TOO_LARGE.to_owned()),
            Some(idle) => {
                context.remarks.extend(support::remark(view, &idle));
                for (place, number) in idle {
                    bound[place] = Some(number);
                }
            }
        }
        let made = specialised(&sliced, context, &bound, KnownNumbers::new());
        let SpecialisedFunction {
            numbered,
            tally,
            written: (result, witness),
        } = if write::is_kept(&made.written, context.tables, context.scene) {
            made
        } else {
            context.remark(write::NOT_ROUNDED.to_owned());
            specialised(&sliced, context, &bound, KnownNumbers::exact())
        };
        let inputs = function.inputs().len() - result.inputs().len();
        context.statistics.extend([
            ("outputs not needed", outputs),
            ("operations not needed", unneeded),
            ("input elements bound", known),
            ("input elements without influence", count(&bound) - known),
            ("input arrays dropped", inputs as u64),
            ("operations on numbers", tally.known),
            ("operations absorbed", tally.absorbed),
            ("operations merged", tally.merged),
            ("constants", evaluate::constants_read(&numbered)),
        ]);
        *context.witness = Some(witness);
        *function = result;
        Ok(())
    }
}

/// A function made for a scene.
struct SpecialisedFunction {
    /// The constants in it are indices of known numbers.
    numbered: Function,
    tally: OperationTally,
    /// With constants, and their witness.
    written: (Function, Function),
}

fn specialised(
    sliced: &Function,
    context: &mut Context<'_>,
    bound: &[Option<f64>],
    mut constants: KnownNumbers,
) -> SpecialisedFunction {
    let evaluator = PartialEvaluator::new(
        sliced,
        context.tables,
        context.rewrites,
        &mut constants,
        bound,
    );
    let (mut numbered, tally) = evaluator.run();
    numbered = without_dead(numbered);
    if numbered.level == Level::Equations {
        numbered = lay_out(&numbered);
    }
    let view = context.tables.view(&numbered);
    let signature = SliceSignature::of(view);
    SpecialisedFunction {
        written: write::write(view, &signature, &constants),
        numbered,
        tally,
    }
}

fn count(bound: &[Option<f64>]) -> u64 {
    bound.iter().flatten().count() as u64
}
