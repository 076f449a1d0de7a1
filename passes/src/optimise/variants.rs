//! The variants that are tried.
//!
//! A variant is what a pipeline makes of the function as it came, or of
//! another variant, so that common work is done once. Variants stand in the
//! order in which they are made: those most often best first among equals.

use robovec_analysis::class::NumericClass;
use robovec_framework::pass::Registry;
use robovec_framework::pipeline::Pipeline;

/// One way to write the function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Variant {
    /// Its name in the table.
    pub(super) name: &'static str,
    /// The variant it starts from; the function as it came, if none.
    pub(super) from: Option<&'static str>,
    /// The pipeline that is run.
    pub(super) pipeline: &'static str,
    /// The same with fewer operations allowed: where that one already has too
    /// many for the elements, this one is not tried.
    pub(super) beyond: Option<&'static str>,
    /// How often the operations of the function count against the budget.
    pub(super) weight: usize,
}

const fn variant(
    name: &'static str,
    from: Option<&'static str>,
    pipeline: &'static str,
) -> Variant {
    Variant {
        name,
        from,
        pipeline,
        beyond: None,
        weight: 1,
    }
}

/// A look-ahead along many more frontiers, of forms twice as wide.
const fn far(name: &'static str, from: Option<&'static str>) -> Variant {
    let pipeline = "lookahead{growth=100 width=24 grid=5 frontiers=80},balance,cse,dce";
    Variant {
        weight: 4,
        ..variant(name, from, pipeline)
    }
}

const fn beyond(
    name: &'static str,
    from: Option<&'static str>,
    pipeline: &'static str,
    beyond: &'static str,
) -> Variant {
    Variant {
        beyond: Some(beyond),
        ..variant(name, from, pipeline)
    }
}

const REASSOCIATED: Option<&str> = Some("reassociated");
const COMPOSITE: Option<&str> = Some("composite");

/// All variants, each behind the one it starts from.
pub(super) const VARIANTS: &[Variant] = &[
    variant("reassociated", None, "fold,zero-removal,balance,cse,dce"),
    variant(
        "composite",
        None,
        "fold,zero-removal,composite,factor-trig{path=free},balance,cse,dce",
    ),
    variant("swapped", None, "fold,zero-removal,swap,cse,dce"),
    variant("as printed", None, "fold,cse,dce"),
    variant("factored", None, "fold,zero-removal,factor,balance,cse,dce"),
    variant("saturated", REASSOCIATED, "eqsat,cse,dce"),
    variant("composite, saturated", COMPOSITE, "eqsat,cse,dce"),
    variant(
        "composite, look-ahead 100 %",
        COMPOSITE,
        "lookahead{growth=100},balance,cse,dce",
    ),
    far("composite, far look-ahead 100 %", COMPOSITE),
    beyond(
        "composite, look-ahead 120 %",
        COMPOSITE,
        "lookahead{growth=120},balance,cse,dce",
        "composite, look-ahead 100 %",
    ),
    beyond(
        "composite, look-ahead 150 %",
        COMPOSITE,
        "lookahead{growth=150},balance,cse,dce",
        "composite, look-ahead 120 %",
    ),
    beyond(
        "composite, look-ahead 200 %",
        COMPOSITE,
        "lookahead{growth=200},balance,cse,dce",
        "composite, look-ahead 150 %",
    ),
    beyond(
        "composite, prefix",
        COMPOSITE,
        "recurrence,balance,cse,dce",
        "composite, look-ahead 150 %",
    ),
    variant(
        "look-ahead 100 %",
        REASSOCIATED,
        "lookahead{growth=100},balance,cse,dce",
    ),
    far("far look-ahead 100 %", REASSOCIATED),
    beyond(
        "look-ahead 110 %",
        REASSOCIATED,
        "lookahead{growth=110},balance,cse,dce",
        "look-ahead 100 %",
    ),
    beyond(
        "look-ahead 120 %",
        REASSOCIATED,
        "lookahead{growth=120},balance,cse,dce",
        "look-ahead 110 %",
    ),
    beyond(
        "look-ahead 150 %",
        REASSOCIATED,
        "lookahead{growth=150},balance,cse,dce",
        "look-ahead 120 %",
    ),
    beyond(
        "look-ahead 200 %",
        REASSOCIATED,
        "lookahead{growth=200},balance,cse,dce",
        "look-ahead 150 %",
    ),
    beyond(
        "prefix",
        REASSOCIATED,
        "recurrence,balance,cse,dce",
        "look-ahead 150 %",
    ),
];

/// The variants with products and sums in one, on machines that have elements
/// for it: names and pipelines.
pub(super) const FUSED: [(&str, &str); 2] =
    [("fused", "fma"), ("fused in part", "fma{share=true}")];

/// The weakest class of the passes of a pipeline: what its result may differ
/// in from the function.
pub(super) fn class(pipeline: &Pipeline) -> NumericClass {
    let classes = pipeline.passes().map(|step| step.info.class);
    classes.max().unwrap_or(NumericClass::Exact)
}

impl Variant {
    /// Its pipeline; `None` when the registry lacks a pass of it.
    pub(super) fn pipeline(&self, registry: &'static Registry) -> Option<Pipeline> {
        let known = self
            .pipeline
            .split(',')
            .map(|step| step.split('{').next().unwrap_or(step))
            .all(|name| registry.find(name).is_some());
        known.then(|| {
            let pipeline = registry.pipeline(self.pipeline);
            pipeline.expect("the pipelines of variants are well formed")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::REGISTRY;

    #[test]
    fn variants_start_from_earlier_ones_and_change_no_function() {
        for (index, variant) in VARIANTS.iter().enumerate() {
            let earlier = |name: &str| VARIANTS[..index].iter().any(|other| other.name == name);
            assert!(variant.from.is_none_or(earlier), "{}", variant.name);
            assert!(variant.beyond.is_none_or(earlier), "{}", variant.name);
            let Some(pipeline) = variant.pipeline(&REGISTRY) else {
                let names = variant.pipeline.split(',');
                let known = names.map(|step| step.split('{').next().unwrap_or(step));
                let missing = known.filter(|name| REGISTRY.find(name).is_none());
                assert!(missing.count() > 0, "{} does not parse", variant.pipeline);
                continue;
            };
            let class = class(&pipeline);
            assert!(
                class <= NumericClass::RealTrig,
                "{} is {class}",
                variant.name
            );
        }
    }
}
