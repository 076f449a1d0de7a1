//! The remarks of the pass: errors that were proved, operations and cycles.

use super::choose::PolynomialChoice;
use super::recipe::Recipe;
use super::{CircularAngle, Treatment};
use robovec_analysis::critical_path::critical_path;
use robovec_framework::pass::Context;
use robovec_num::trigonometry::Circular;
use std::collections::BTreeMap;
use std::fmt::Write;

/// One remark per recipe, and one for the angles that were left.
pub(super) fn tell(
    choices: &[(f64, PolynomialChoice)],
    recipes: &[Recipe],
    treatments: &BTreeMap<u64, Treatment>,
    occurrences: &BTreeMap<u64, CircularAngle>,
    context: &mut Context<'_>,
) {
    let format = context.machine.number;
    let count = |wanted: &dyn Fn(&Treatment) -> bool| {
        let found = treatments.values().filter(|treatment| wanted(treatment));
        found.count()
    };
    for (index, ((range, choice), recipe)) in choices.iter().zip(recipes).enumerate() {
        let angles =
            count(&|treatment| matches!(treatment, Treatment::Computed(used) if *used == index));
        let rounding = recipe.rounding_errors(*range, format);
        let mut text = format!("{} within ±{range:.4}: ", plural(angles, "angle"));
        let mut first = true;
        for (which, of) in Circular::BOTH.into_iter().enumerate() {
            if recipe.results[which].is_none() {
                continue;
            }
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "{}{} of order {} with an error of at most {:.2e}, rounding in {format} adds {:.1e}",
                if first { "" } else { "; " },
                of.name(),
                choice.orders[which],
                choice.errors[which],
                rounding[which],
            );
            first = false;
        }
        let cycles = critical_path(&recipe.function, context.machine).asap_cycle;
        let _ = write!(
            text,
            "; {} and {cycles} cycles each",
            plural(recipe.operations(), "operation")
        );
        context.remark(text);
    }
    for (reason, known) in [
        ("of unknown range", false),
        ("beyond the largest range", true),
    ] {
        let left = treatments.iter().filter(|(key, treatment)| {
            let bounds = occurrences.get(key).and_then(|angle| angle.bounds);
            matches!(treatment, Treatment::Left) && bounds.is_some() == known
        });
        let left = left.count();
        if left > 0 {
            let angles = plural(left, "angle");
            context.remark(format!("{angles} {reason} left to the host"));
        }
    }
}

fn plural(count: usize, thing: &str) -> String {
    match count {
        1 => format!("1 {thing}"),
        _ => format!("{count} {thing}s"),
    }
}
