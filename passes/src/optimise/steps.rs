//! The steps a search is made of: data, in the order in which they are tried.
//!
//! Every start goes through a *preparation* first; a program may go through a
//! *move* after it, and again after another move. Those most often best are
//! first, so that they are preferred among equals.

use robovec_analysis::class::NumericClass;
use robovec_framework::pass::Registry;
use robovec_framework::pipeline::Pipeline;

/// Form of a start, so that no step to the same form is tried.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StartForm {
    /// Equations of any kind, as a user's file has them, or in which composite
    /// bodies can still be found.
    Printed,
    /// Equations made from the model as composite bodies: there are none left
    /// to find.
    Formulation,
}

/// One step of a search.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SearchStep {
    /// Its name, which steps of one kind share; their pipelines differ.
    pub name: &'static str,
    /// The passes it represents.
    pub pipeline: &'static str,
    /// Its work per operation of the program it starts from, in the work of
    /// reassociating one: rounded from processor times at 4,000 operations;
    /// look-ahead costs two to three times as much at 30,000 and more.
    pub weight: u64,
    /// Limit of the operations, in percent of those of the start: a step is not
    /// tried if that number cannot be scheduled faster than the best.
    pub growth: u64,
    /// True when it applies to printed equations alone.
    pub printed_only: bool,
    /// True when it finds composite bodies in equations, which saves more than
    /// any other step.
    pub finds_bodies: bool,
    /// True for the preparation of every start: its result decides whether the
    /// others are promising.
    pub is_first: bool,
}

/// Text between the kinds of steps in a name.
const KINDS: &str = " + ";
/// Text before the number of steps of a kind, where there are several.
const TIMES: &str = " x";

const fn step(name: &'static str, pipeline: &'static str) -> SearchStep {
    SearchStep {
        name,
        pipeline,
        weight: 1,
        growth: 100,
        printed_only: false,
        finds_bodies: false,
        is_first: false,
    }
}

const fn first(step: SearchStep) -> SearchStep {
    SearchStep {
        is_first: true,
        ..step
    }
}

const fn printed(name: &'static str, pipeline: &'static str) -> SearchStep {
    SearchStep {
        printed_only: true,
        ..step(name, pipeline)
    }
}

const fn bodies(name: &'static str, pipeline: &'static str) -> SearchStep {
    SearchStep {
        finds_bodies: true,
        ..printed(name, pipeline)
    }
}

const fn heavy(name: &'static str, pipeline: &'static str, weight: u64, growth: u64) -> SearchStep {
    SearchStep {
        weight,
        growth,
        ..step(name, pipeline)
    }
}

/// Short paths by sums and products in other order.
pub const REASSOCIATED: &str = "dce{order=outputs},fold,zero-removal,balance,cse,dce";

/// The fewest operations of printed equations, in short paths.
pub const COMPOSITE: &str =
    "dce{order=outputs},fold,zero-removal,composite,factor-trig{path=free},balance,cse,dce";

/// Preparations of all starts. The order of the equations is discarded, so that
/// it has no effect.
pub const PREPARATIONS: &[SearchStep] = &[
    first(step("balanced", REASSOCIATED)),
    first(bodies("composite", COMPOSITE)),
    step(
        "factored",
        "dce{order=outputs},fold,zero-removal,factor,balance,cse,dce",
    ),
    step(
        "factored",
        "dce{order=outputs},fold,zero-removal,factor-trig{path=free},balance,cse,dce",
    ),
    bodies(
        "composite",
        "dce{order=outputs},fold,cse,composite,factor-trig{path=free},cse,dce",
    ),
    step(
        "factored",
        "dce{order=outputs},fold,cse,factor-trig{path=free},cse,dce",
    ),
    printed(
        "swapped",
        "dce{order=outputs},fold,zero-removal,swap,cse,dce",
    ),
    step("as printed", "dce{order=outputs},fold,cse,dce"),
];

/// The name of the step that is the preset of that name: equations stay in
/// the order given, which leaves compilers more registers in some files.
pub const PRESET: &str = "$cpu";

/// More preparations where nothing but operations counts: schemes of
/// polynomials make paths long.
pub const FEWEST: &[SearchStep] = &[
    bodies(PRESET, "fold,cse,composite,factor-trig{path=free},cse,dce"),
    step("as given", "fold,cse,dce"),
    heavy(
        "horner",
        "dce{order=outputs},fold,zero-removal,factor{path=free horner=occurrences},cse,dce",
        5,
        100,
    ),
    SearchStep {
        finds_bodies: true,
        printed_only: true,
        ..heavy(
            "composite",
            "dce{order=outputs},fold,zero-removal,composite,\
             factor-trig{path=free horner=occurrences},cse,dce",
            3,
            100,
        )
    },
];

/// Moves after them where only operations count. Look-ahead that may not spend
/// finds values that are equal, and is paid for by factors.
pub const FEWEST_MOVES: &[SearchStep] = &[heavy(
    "look-ahead",
    "lookahead{growth=95},factor{path=free horner=occurrences},cse,dce",
    15,
    100,
)];

/// Moves after the preparations.
pub const MOVES: &[SearchStep] = &[
    heavy(
        "look-ahead",
        "lookahead{growth=100},balance,cse,dce",
        8,
        100,
    ),
    heavy(
        "look-ahead",
        "lookahead{growth=120},balance,cse,dce",
        10,
        115,
    ),
    heavy(
        "look-ahead",
        "lookahead{growth=100 width=24 grid=5 frontiers=80},balance,cse,dce",
        22,
        100,
    ),
    heavy(
        "look-ahead",
        "lookahead{growth=120 width=24 grid=5 frontiers=80},balance,cse,dce",
        26,
        115,
    ),
    heavy(
        "look-ahead",
        "lookahead{growth=135 width=24 grid=5 frontiers=80},balance,cse,dce",
        28,
        125,
    ),
    heavy("prefix", "recurrence,balance,cse,dce", 4, 140),
    step("factored", "factor-trig,balance,cse,dce"),
    step("factored", "factor-trig{path=free},balance,cse,dce"),
    SearchStep {
        finds_bodies: true,
        ..heavy("composite", "composite,balance,cse,dce", 3, 100)
    },
    heavy(
        "look-ahead",
        "lookahead{growth=150 width=24 grid=5 frontiers=80},balance,cse,dce",
        32,
        140,
    ),
    heavy(
        "look-ahead",
        "lookahead{growth=200},balance,cse,dce",
        12,
        180,
    ),
];

/// Moves of the best program alone, since they take as long as all other moves
/// together, and only when it is small or the other moves do not improve it.
pub const SATURATED: &[SearchStep] = &[heavy("saturated", "eqsat,cse,dce", 200, 105)];

/// Fused products and sums, on machines that have elements for them.
pub const FUSED: &[SearchStep] = &[step("fused", "fma"), step("fused", "fma{share=true}")];

impl SearchStep {
    /// Name of a program after this further step: every kind of step once, with
    /// its number of uses.
    pub(super) fn after(&self, name: &str) -> String {
        let mut kinds: Vec<String> = Vec::new();
        let mut is_known = false;
        for kind in name.split(KINDS).filter(|kind| !kind.is_empty()) {
            let (kind, times) = kind.rsplit_once(TIMES).unwrap_or((kind, "1"));
            let mut times: u32 = times.parse().expect("names count their steps");
            if kind == self.name {
                is_known = true;
                times += 1;
            }
            kinds.push(match times {
                1 => kind.to_owned(),
                times => format!("{kind}{TIMES}{times}"),
            });
        }
        if !is_known {
            kinds.push(self.name.to_owned());
        }
        kinds.join(KINDS)
    }

    /// True when it puts sums and products into another order.
    pub fn balances(&self) -> bool {
        self.pipeline.split(',').any(|step| step == "balance")
    }

    /// Its pipeline; `None` when the registry lacks one of its passes.
    pub fn pipeline(&self, registry: &'static Registry) -> Option<Pipeline> {
        let known = self
            .pipeline
            .split(',')
            .map(|step| step.split('{').next().expect("a text has a first part"))
            .all(|name| registry.find(name).is_some());
        known.then(|| {
            let pipeline = registry.pipeline(self.pipeline);
            pipeline.expect("the pipelines of steps are well formed")
        })
    }
}

/// The weakest class of the passes of a pipeline: the permitted difference of
/// its result from the function.
pub(super) fn class(pipeline: &Pipeline) -> NumericClass {
    let classes = pipeline.passes().map(|step| step.info.class);
    classes.fold(NumericClass::Exact, NumericClass::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::REGISTRY;

    #[test]
    fn names_count_steps_of_a_kind() {
        let [first, second] = [MOVES[0], MOVES[6]];
        assert_eq!([first.name, second.name], ["look-ahead", "factored"]);
        let mut name = "composite".to_owned();
        for step in [first, second, first, first] {
            name = step.after(&name);
        }
        assert_eq!(name, "composite + look-ahead x3 + factored");
        assert_eq!(first.after(""), "look-ahead");
    }

    #[test]
    fn the_preset_is_a_step() {
        let step = FEWEST.iter().find(|step| step.name == PRESET);
        let pipeline = step.expect("it is one").pipeline;
        let preset = REGISTRY.pipeline(PRESET).expect("it is a preset");
        assert_eq!(preset.to_string(), format!("atomise,{pipeline}"));
    }

    #[test]
    fn steps_are_pipelines_that_change_no_function() {
        for step in [PREPARATIONS, FEWEST, FEWEST_MOVES, MOVES, SATURATED, FUSED].concat() {
            let pipeline = step.pipeline(&REGISTRY).expect("all passes are there");
            let class = class(&pipeline);
            assert!(class <= NumericClass::RealTrig, "{} is {class}", step.name);
            assert!(step.weight > 0 && step.growth >= 100, "{}", step.name);
            let mut passes = pipeline.passes();
            let has_composite = passes.any(|pass| pass.info.name == "composite");
            assert_eq!(step.finds_bodies, has_composite, "{}", step.name);
        }
    }
}
