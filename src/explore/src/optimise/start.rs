//! Starts of a search: the equations as they came, and other formulations.

use super::OptimisationQuestion;
use crate::program::{ExplorationError, transformed_by, view};
use robovec_analysis::class::NumericClass;
use robovec_dynamics::generate::{
    Formulation, GenerationRequest, MomentOrigin, Options, PrefixNetwork, generate,
};
use robovec_error::yardstick::input_names;
use robovec_framework::check::{CheckVerdict, Specialised, check, check_specialised};
use robovec_framework::rewrite::remove_dead;
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_framework::scene::Scene;
use robovec_ir::print::print_output;
use robovec_ir::states::States;
use robovec_ir::{Assignment, Level, Module, Output, SourceSet, View};
use robovec_model::Model;
use robovec_passes::optimise::steps::StartForm;
use robovec_robotran::FunctionKind;
use robovec_robotran::align;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Equations that programs are made from.
#[derive(Clone, Debug)]
pub struct OptimisationStart {
    /// Its name: empty for the equations as they came, else the formulation.
    pub name: String,
    /// Form of the start.
    pub form: StartForm,
    /// One function.
    pub module: Arc<Module>,
    /// Options of `robovec gen` that give these equations, without the model.
    pub recipe: String,
}

/// The formulations that are tried where there is a model: the fewest
/// operations for trees and for chains, and the shortest paths.
pub const FORMULATIONS: [Formulation; 4] = [
    Formulation::Composite,
    Formulation::CompositeBase,
    Formulation::prefix(PrefixNetwork::BrentKung, MomentOrigin::Body),
    Formulation::prefix(PrefixNetwork::Sklansky, MomentOrigin::Body),
];

/// Points of the check whether a formulation is equal to the input function.
const POINTS: u32 = 4;

impl OptimisationStart {
    /// The equations as they came.
    pub fn given(module: Module) -> OptimisationStart {
        OptimisationStart {
            name: String::new(),
            form: StartForm::Printed,
            module: Arc::new(module),
            recipe: String::new(),
        }
    }

    /// Equations in a formulation.
    pub fn formulation(
        formulation: Formulation,
        module: Module,
        recipe: String,
    ) -> OptimisationStart {
        OptimisationStart {
            name: formulation.name().to_owned(),
            form: match formulation {
                Formulation::Composite | Formulation::CompositeBase => StartForm::Formulation,
                _ => StartForm::Printed,
            },
            module: Arc::new(module),
            recipe,
        }
    }
}

/// Equations as they came, and the same function in other formulations.
pub fn starts(
    given: Module,
    others: impl IntoIterator<Item = (Formulation, Module)>,
) -> Vec<OptimisationStart> {
    let others = others.into_iter();
    let others = others.map(|(formulation, module)| {
        OptimisationStart::formulation(formulation, module, String::new())
    });
    [OptimisationStart::given(given)]
        .into_iter()
        .chain(others)
        .collect()
}

/// The formulations of a model that are the function that came in, at the
/// numbers that a scene binds; for others the reason why they are not.
pub fn formulations(
    given: &Module,
    model: &Model,
    kind: FunctionKind,
    scene: Option<&Scene>,
) -> (Vec<OptimisationStart>, Vec<(String, String)>) {
    let mut found = Vec::new();
    let mut left = Vec::new();
    for formulation in FORMULATIONS {
        if !formulation.gives(kind) {
            continue;
        }
        // Files differ in what their generator was told to leave out.
        let mut reason = None;
        let start = ways().into_iter().find_map(|(options, words)| {
            let request = GenerationRequest {
                function: kind,
                formulation,
                options,
            };
            let name = formulation.name();
            let recipe = format!("--function {} --formulation {name}{words}", kind.name());
            let same = generate(model, &request)
                .map_err(|error| error.to_string())
                .and_then(|module| same_function(given, module, scene));
            match same {
                Ok((module, is_changed)) => {
                    // No command makes what was changed here.
                    let recipe = if is_changed { String::new() } else { recipe };
                    Some(OptimisationStart::formulation(formulation, module, recipe))
                }
                Err(difference) => {
                    reason.get_or_insert(difference);
                    None
                }
            }
        });
        match (start, reason) {
            (Some(start), _) => found.push(start),
            (None, reason) => left.push((
                formulation.name().to_owned(),
                reason.expect("what is not taken differs"),
            )),
        }
    }
    (found, left)
}

/// Options of the generator, with the flags of `robovec gen` for them.
fn ways() -> [(Options, String); 4] {
    [(true, false), (false, false), (true, true), (false, true)].map(|(forces, all)| {
        let options = Options {
            external_forces: forces,
            all_parameters: all,
            ..Options::default()
        };
        let bare = if forces { "" } else { " --no-forces" };
        let all = if all { " --all-parameters" } else { "" };
        (options, format!("{bare}{all}"))
    })
}

/// The function of a module that is equal to the input, alone in it, with the
/// same outputs; and a flag: true when outputs were changed for that.
fn same_function(
    given: &Module,
    mut module: Module,
    scene: Option<&Scene>,
) -> Result<(Module, bool), String> {
    let name = &given.functions[0].name;
    module.functions.retain(|function| function.name == *name);
    if module.functions.len() != 1 {
        return Err(format!("the model gives no function '{name}'"));
    }
    let verdict = aligned(given, &module, |before, after| {
        let (class, states) = (NumericClass::RealTrig, States::new(1));
        if scene.is_none() {
            return check(before, after, class, &states, POINTS);
        }
        // A factorisation has its poles at masses that no model has.
        let subject = Specialised {
            before,
            witness: after,
            after,
            scene,
        };
        check_specialised(subject, class, &states, POINTS)
    });
    if !verdict.holds() {
        return Err(format!("the model's equations are different: {verdict}"));
    }
    let known: BTreeSet<String> = input_names(view(given)).into_iter().collect();
    let reads = input_names(view(&module));
    if let Some(other) = reads.iter().find(|name| !known.contains(*name)) {
        return Err(format!(
            "the model's equations read '{other}', which the input does not have"
        ));
    }
    let is_changed = with_outputs(given, &mut module)?;
    Ok((module, is_changed))
}

/// Gives a function the input function's outputs: additional ones are zero.
fn with_outputs(given: &Module, module: &mut Module) -> Result<bool, String> {
    let names = |view: View<'_>| -> Vec<String> {
        let set = view.function.assignments.iter();
        set.map(|set| print_output(view, set.output)).collect()
    };
    let wanted: BTreeSet<String> = names(view(given)).into_iter().collect();
    let there = names(view(module));
    let mut added = Vec::new();
    for assignment in &given.functions[0].assignments {
        let name = print_output(view(given), assignment.output);
        if there.contains(&name) {
            continue;
        }
        let (array, indices, rank) = given.functions[0].output_element(assignment.output);
        let symbol = module
            .tables
            .symbols
            .find(given.tables.symbols.text(array.name));
        let arrays = module.functions[0].outputs().iter();
        let place = arrays
            .filter(|own| Some(own.name) == symbol)
            .find_map(|own| Some(own.offset + own.shape.offset(&indices[..rank])?));
        let place = place.ok_or_else(|| format!("the model's equations have no '{name}'"))?;
        added.push(Output(place));
    }
    let function = &mut module.functions[0];
    let before = function.assignments.len();
    let mut kept = there.iter().map(|name| wanted.contains(name));
    function
        .assignments
        .retain(|_| kept.next().expect("every assignment has a name"));
    let is_changed = !added.is_empty() || function.assignments.len() != before;
    if !is_changed {
        return Ok(false);
    }
    // An expression without a name belongs to what is set to it.
    if let Some((live, _)) = remove_dead(function, &RewriteLimit::default()) {
        *function = live;
    }
    let zero = function.constant(0.0);
    function
        .assignments
        .extend(added.into_iter().map(|output| Assignment {
            output,
            operand: zero.into(),
            sources: SourceSet::EMPTY,
        }));
    function.sort_assignments();
    Ok(true)
}

/// Two modules of one function each, compared over all arrays of either.
pub(super) fn compared(
    before: &Module,
    after: &Module,
    class: NumericClass,
    states: &States,
    points: u32,
) -> CheckVerdict {
    aligned(before, after, |before, after| {
        check(before, after, class, states, points)
    })
}

/// The verdict on two modules of one function each, with all arrays of either.
fn aligned(
    before: &Module,
    after: &Module,
    judge: impl Fn(View<'_>, View<'_>) -> CheckVerdict,
) -> CheckVerdict {
    let mut tables = [before.tables.clone(), after.tables.clone()];
    let [first, second] = &mut tables;
    let (one, other) = align::align((&before.functions[0], first), (&after.functions[0], second));
    let views = [(&tables[0], &one), (&tables[1], &other)];
    let [before, after] = views.map(|(tables, function)| View { tables, function });
    judge(before, after)
}

/// Starts at the level atomic, specialised to a scene.
pub struct PreparedStarts {
    /// The passes that prepared them; none for equations that were atomic.
    prelude: &'static str,
    /// One for each start.
    pub modules: Vec<Arc<Module>>,
    /// The starts themselves, unchanged; the first is the input.
    pub starts: Vec<Arc<Module>>,
}

impl PreparedStarts {
    /// The passes from the start itself on.
    pub fn passes(&self, passes: &str) -> String {
        match self.prelude {
            "" => passes.to_owned(),
            prelude => format!("{prelude},{passes}"),
        }
    }
}

pub(super) fn prepared(
    starts: &[OptimisationStart],
    question: &OptimisationQuestion<'_>,
) -> Result<PreparedStarts, ExplorationError> {
    let prelude = match (view(&starts[0].module).function.level, question.scene) {
        (Level::Equations, None) => "atomise",
        (Level::Equations, Some(_)) => "atomise,specialise",
        (_, None) => "",
        (_, Some(_)) => "specialise",
    };
    let mut modules = Vec::new();
    for start in starts {
        modules.push(match prelude {
            "" => start.module.clone(),
            passes => Arc::new(transformed_by(
                &start.module,
                passes,
                question.machine,
                question.scene,
            )?),
        });
    }
    Ok(PreparedStarts {
        prelude,
        starts: starts.iter().map(|start| start.module.clone()).collect(),
        modules,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::parse::parse_module;

    #[test]
    fn a_pole_beyond_the_numbers_of_a_scene_is_no_difference() {
        let module = |output: &str| {
            let text =
                format!("function f equations {{\n  in x\n  in m\n  out o\n\n  o = {output}\n}}\n");
            parse_module("f.rvir", &text).expect("well formed")
        };
        let (given, other) = (module("x + m"), module("(x*m + m*m)/m"));
        let reason = same_function(&given, other.clone(), None).expect_err("it has a pole");
        assert!(reason.contains("o is not defined everywhere"), "{reason}");
        let mut scene = Scene::default();
        scene.bound.set("m", [0, 0], 2.0);
        same_function(&given, other, Some(&scene)).expect("it is the same where m = 2");
        let reason = same_function(&given, module("x*m"), Some(&scene));
        let reason = reason.expect_err("it is another function");
        assert!(reason.contains("o is another function"), "{reason}");
    }

    #[test]
    fn an_output_that_is_left_out_takes_its_expression_with_it() {
        let text = |outputs: &str| {
            format!("function f equations {{\n  in x\n  out o[1..2]\n\n{outputs}}}\n")
        };
        let given = text("  o[1] = sin(x)\n");
        let given = parse_module("given.rvir", &given).expect("well formed");
        let other = text("  o[1] = sin(x)\n  o[2] = x*x - x*x\n");
        let other = parse_module("other.rvir", &other).expect("well formed");
        let (module, is_changed) = same_function(&given, other, None).expect("it is the same");
        assert!(is_changed);
        let thesis = robovec_ir::Machine::built_in("thesis").expect("it ships");
        let atomic = transformed_by(&module, "atomise", &thesis, None).expect("nothing is dead");
        assert_eq!(atomic.functions[0].nodes().len(), 1);
    }
}
