//! Formulations of a function that may be the shortest one.
//!
//! The length of a program is known after passes, which take far longer over a
//! long function than its generation. No pass halves one formulation and does
//! nothing for another, so a formulation more than twice as long as the
//! shortest when it is written is excluded. The elimination of a dense mass
//! matrix is excluded before it is written: its number of operations is known.

use super::{Formulation, GenerateError, GenerationRequest, Options, factor, generate};
use robovec_framework::manager::{self, Config};
use robovec_ir::count::Counts;
use robovec_ir::{Machine, Module, print};
use robovec_model::Model;
use robovec_passes::registry::REGISTRY;
use robovec_robotran::FunctionKind;

/// Maximum length relative to the shortest one.
const LONGEST: usize = 2;

/// A formulation that may be the shortest one of a function.
#[derive(Clone, Debug)]
pub struct Contender {
    /// The formulation.
    pub formulation: Formulation,
    /// The function, alone in its module.
    pub module: Module,
    /// Its operations as generated.
    pub operations: usize,
}

/// Formulations that came into question.
#[derive(Clone, Default, Debug)]
pub struct Contenders {
    /// Those that may be the shortest, in order; of equal ones the first.
    pub possible: Vec<Contender>,
    /// Those that the generator does not give for the model, and why.
    pub refused: Vec<(Formulation, GenerateError)>,
}

/// The formulation of a function with the fewest operations after the preset
/// `$cpu`, of equal ones the first, among those for the model.
pub fn fewest(model: &Model, function: FunctionKind, options: &Options) -> Formulation {
    let cpu = REGISTRY.pipeline("$cpu").expect("a preset is a pipeline");
    let machine = Machine::built_in("thesis").expect("it ships");
    let found = contenders(model, function, &Formulation::ALL, options);
    let lengths = found.possible.into_iter().filter_map(|contender| {
        let mut module = contender.module;
        let mut log = std::io::sink();
        manager::run(&mut module, &cpu, Config::new(&machine, &mut log)).ok()?;
        let lengths = module.functions.iter().map(Counts::of);
        let operations: usize = lengths.map(|counts| counts.operations).sum();
        Some((operations, contender.formulation))
    });
    let shortest = lengths.min_by_key(|(operations, _)| *operations);
    shortest.map_or_else(Formulation::default, |(_, formulation)| formulation)
}

/// Writes a function in those of some formulations that may be the shortest.
pub fn contenders(
    model: &Model,
    function: FunctionKind,
    formulations: &[Formulation],
    options: &Options,
) -> Contenders {
    let mut all = Contenders::default();
    let mut shortest = usize::MAX;
    let mut ordered: Vec<(usize, Formulation)> = (0..).zip(formulations.iter().copied()).collect();
    // What eliminates nothing comes first, and may save writing the others.
    ordered.sort_by_key(|&(place, formulation)| (eliminates(formulation), place));
    let mut written: Vec<(usize, Contender)> = Vec::new();
    for (place, formulation) in ordered {
        let least = least_operations(model, function, formulation);
        if !formulation.gives(function) || least > shortest.saturating_mul(LONGEST) {
            continue;
        }
        let request = GenerationRequest {
            function,
            formulation,
            options: options.clone(),
        };
        match generate(model, &request) {
            Ok(module) => {
                let operations = operations(&module);
                shortest = shortest.min(operations);
                let contender = Contender {
                    formulation,
                    module,
                    operations,
                };
                written.push((place, contender));
            }
            Err(error) => all.refused.push((formulation, error)),
        }
    }
    written.sort_by_key(|(place, _)| *place);
    for (_, contender) in written {
        let is_known = |known: &Contender| is_same(known, &contender);
        if contender.operations <= LONGEST * shortest && !all.possible.iter().any(is_known) {
            all.possible.push(contender);
        }
    }
    all
}

/// Tests whether accelerations come from a mass matrix.
fn eliminates(formulation: Formulation) -> bool {
    formulation != Formulation::Articulated
}

/// Minimum number of operations of a function: the elimination of the mass
/// matrix, where each product is subtracted. Loops change its size.
fn least_operations(model: &Model, function: FunctionKind, formulation: Formulation) -> usize {
    let is_known = function == FunctionKind::Accelred && model.cuts.is_empty();
    if is_known && eliminates(formulation) {
        factor::products(model).saturating_mul(2)
    } else {
        0
    }
}

fn operations(module: &Module) -> usize {
    let counts = module.functions.iter().map(Counts::of);
    counts.map(|counts| counts.operations).sum()
}

/// True for the same equations, from any formulations.
fn is_same(one: &Contender, other: &Contender) -> bool {
    let text = |contender: &Contender| {
        let mut module = contender.module.clone();
        module
            .functions
            .iter_mut()
            .for_each(|function| function.metadata.clear());
        print::print_module(&module)
    };
    one.operations == other.operations && text(one) == text(other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_model::family;

    fn found(model: &Model, function: FunctionKind) -> Contenders {
        contenders(model, function, &Formulation::ALL, &Options::default())
    }

    /// No formulation left out has a shorter path than those kept, as
    /// generated.
    #[test]
    fn the_shortest_as_generated_is_among_them() {
        for joints in [3, 12] {
            for model in [family::serial(joints, 1), family::random_tree(2, joints)] {
                for function in [FunctionKind::Dirdyna, FunctionKind::Accelred] {
                    let kept = found(&model, function).possible;
                    let all = Formulation::ALL.into_iter().filter_map(|formulation| {
                        let request = GenerationRequest {
                            formulation,
                            ..GenerationRequest::new(function)
                        };
                        generate(&model, &request)
                            .ok()
                            .map(|module| operations(&module))
                    });
                    let shortest = all.min();
                    assert!(shortest.is_some());
                    let kept = kept.iter().map(|contender| contender.operations);
                    assert_eq!(kept.min(), shortest, "{} {}", model.name, function.name());
                }
            }
        }
    }

    #[test]
    fn of_a_long_chain_only_articulated_bodies_are_left() {
        let model = family::serial(130, 1);
        let kept = found(&model, FunctionKind::Accelred);
        let kept: Vec<&str> = kept
            .possible
            .iter()
            .map(|kept| kept.formulation.name())
            .collect();
        assert_eq!(kept, ["articulated"]);
    }

    #[test]
    fn what_does_not_close_loops_is_refused_with_the_reason() {
        let model = robovec_model::family::ModelFamily::from_name("four-bar");
        let model = model.expect("a family").build(0, 1);
        let kept = found(&model, FunctionKind::Accelred);
        assert!(!kept.possible.is_empty());
        let refused: Vec<&str> = kept.refused.iter().map(|(one, _)| one.name()).collect();
        assert_eq!(refused, ["articulated"]);
    }
}
