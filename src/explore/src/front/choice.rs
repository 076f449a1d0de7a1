//! Choices that are compared: those the thesis could make, and ours.
//!
//! The thesis takes Robotran's equations as printed, or with the trees of the
//! longest path balanced by hand (2.4.3); computes in binary32 (1.1); and puts
//! `sin x = x`, `cos x = 1` into the memories before the run (Taylor order 1,
//! 1.2.2), or true sines and cosines from a host. Everything else is ours.

use robovec_dynamics::generate::Formulation;
use robovec_ir::Format;
use robovec_passes::optimise::steps;

/// A way to compute a function.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct FrontChoice {
    /// Its name in tables.
    pub name: String,
    /// True for what the thesis could choose.
    pub thesis: bool,
    /// Another formulation of the equations, made from the model; the
    /// equations as they came for `None`.
    pub formulation: Option<Formulation>,
    /// Passes, in stages that other choices may share from the start on.
    pub stages: Vec<String>,
    /// The formats it is measured in.
    pub formats: Vec<Format>,
}

/// Balanced by arrival times: what the thesis does by hand, done everywhere.
const BALANCED: &str = "atomise,zero-removal,balance,cse,dce";
/// Order 1 of the Taylor series.
const ORDER_1: &str = "trigonometry{method=taylor order=1}";
/// The form that rounds least, with neither more cycles nor more operations.
const ACCURATE: &str = "accurate";

/// Functions with more operations get fewer variants: look-ahead takes a
/// quarter of a millisecond per operation.
const LARGE: usize = 30_000;

/// A format with 27 bits of significand: the multipliers of Cyclone V are 27
/// bits wide, so that it costs no more of them than binary32.
pub(super) const FULL_MULTIPLIER: &str = "float(8,26)";

/// Binary32, and [`FULL_MULTIPLIER`].
fn wide() -> Vec<Format> {
    let full = FULL_MULTIPLIER.parse().expect("it is a format");
    vec![Format::BINARY32, full]
}

fn choice(name: &str, stages: &[&str]) -> FrontChoice {
    FrontChoice {
        name: name.to_owned(),
        thesis: false,
        formulation: None,
        stages: stages.iter().map(|&stage| stage.to_owned()).collect(),
        formats: vec![Format::BINARY32],
    }
}

/// All that the thesis could choose.
pub(super) fn of_the_thesis() -> Vec<FrontChoice> {
    let thesis = |name, stages: &[&str]| FrontChoice {
        thesis: true,
        ..choice(name, stages)
    };
    vec![
        thesis("printed, order 1", &["atomise", ORDER_1]),
        thesis("balanced, order 1", &[BALANCED, ORDER_1]),
        // Products with cos x = 1 need not be computed, though the thesis does.
        thesis(
            "balanced, order 1, folded",
            &["atomise", ORDER_1, "fold,zero-removal,balance,cse,dce"],
        ),
        thesis("printed, true sin and cos", &["atomise"]),
        thesis("balanced, true sin and cos", &[BALANCED]),
    ]
}

/// Our choices for a function of so many operations: from the equations, and,
/// where there is a model, from its other formulations. Angles up to `angle`
/// (rad) are covered by the series that the elements compute.
pub(super) fn ours(
    operations: usize,
    formulations: &[Formulation],
    angle: f64,
) -> Vec<FrontChoice> {
    let composite = format!("atomise,{}", steps::COMPOSITE);
    let ahead = |growth: u32| format!("lookahead{{growth={growth}}},balance,cse,dce");
    let growths: &[u32] = if operations > LARGE {
        &[100]
    } else {
        &[100, 120, 150]
    };
    let mut choices = Vec::new();
    let mut add = |name: String, formulation: Option<Formulation>, stages: &[&str]| {
        choices.push(FrontChoice {
            formulation,
            formats: wide(),
            ..choice(&name, stages)
        });
    };
    let from = [("", BALANCED), ("composite", &composite)];
    for (name, start) in from {
        if !name.is_empty() {
            add(name.to_owned(), None, &[start]);
        }
        for &growth in growths {
            let name = format!(
                "{name}{}look-ahead {growth} %",
                if name.is_empty() { "" } else { ", " }
            );
            add(name, None, &[start, &ahead(growth)]);
        }
    }
    // In the form that rounds least, at no cost.
    add("balanced, accurate".to_owned(), None, &[BALANCED, ACCURATE]);
    if operations <= LARGE {
        add(
            "look-ahead 120 %, accurate".to_owned(),
            None,
            &[BALANCED, &ahead(120), ACCURATE],
        );
        add(
            "composite, look-ahead 120 %, accurate".to_owned(),
            None,
            &[&composite, &ahead(120), ACCURATE],
        );
    }
    // Without a host: the elements compute the sines and cosines as well.
    let series = format!("atomise,trigonometry{{method=minimax order=7 range={angle}}}");
    let growth = growths.last().copied().unwrap_or(100);
    add(
        format!("series on the elements, look-ahead {growth} %"),
        None,
        &[&series, "zero-removal,balance,cse,dce", &ahead(growth)],
    );
    for &formulation in formulations {
        let name = format!("formulation {}", formulation.name());
        add(name.clone(), Some(formulation), &[BALANCED]);
        if operations <= LARGE {
            add(
                format!("{name}, look-ahead 100 %"),
                Some(formulation),
                &[BALANCED, &ahead(100)],
            );
        }
    }
    choices
}

/// Choice that a search found for the numbers of elements asked for.
pub(super) fn found(name: &str, formulation: Option<Formulation>, passes: &str) -> FrontChoice {
    FrontChoice {
        formulation,
        formats: wide(),
        ..choice(&format!("found: {name}"), &[passes])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_passes::registry::REGISTRY;

    #[test]
    fn all_stages_are_pipelines_of_this_build() {
        let mut choices = of_the_thesis();
        choices.extend(ours(1000, &Formulation::ALL, 0.1));
        for choice in choices {
            for stage in &choice.stages {
                assert!(REGISTRY.pipeline(stage).is_ok(), "{}: {stage}", choice.name);
            }
        }
    }
}
