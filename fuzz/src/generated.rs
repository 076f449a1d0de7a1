//! Whatever model is given, its equations are well formed, hold in every
//! formulation, and survive Robotran's languages.

use crate::text::check_sound;
use arbitrary::{Result, Unstructured};
use robovec::align::align;
use robovec::generate::{
    Formulation, GenerateError, GenerationRequest, Options, ParameterBinding, TermOrder, generate,
};
use robovec::model::family::random_tree;
use robovec::model::{Anchor, Asks, Cut, CutKind, Link, Model, Nature, Sensor};
use robovec::robotran::FunctionKind;
use robovec::robotran::write::{WriteOptions, write};
use robovec::robotran::{Language, read};
use robovec_analysis::class::NumericClass;
use robovec_framework::check::check;
use robovec_ir::print::print_module;
use robovec_ir::states::States;
use robovec_ir::{Module, View, same_equations};

/// Generates a random function of a random model.
///
/// # Panics
///
/// Panics when it is not well formed, differs from the recursive formulation,
/// or reads back as another function.
pub fn generated_functions_hold(data: &[u8]) {
    // Too few bytes for a model are no finding.
    let bytes = &mut Unstructured::new(data);
    if let Ok((model, request, language)) = input(bytes) {
        holds(&model, &request, language);
    }
}

fn input(bytes: &mut Unstructured<'_>) -> Result<(Model, GenerationRequest, Language)> {
    let mut model = random_tree(bytes.arbitrary()?, bytes.int_in_range(1..=7)?);
    decorate(&mut model, bytes)?;
    let request = GenerationRequest {
        function: *bytes.choose(&FunctionKind::ALL)?,
        formulation: *bytes.choose(&Formulation::ALL)?,
        options: Options {
            order: *bytes.choose(&[TermOrder::OwnFirst, TermOrder::ChildFirst])?,
            all_parameters: bytes.arbitrary()?,
            parameters: *bytes.choose(&[ParameterBinding::Symbols, ParameterBinding::Numbers])?,
            external_forces: bytes.arbitrary()?,
            leading_signs: bytes.arbitrary()?,
            expanded: bytes.arbitrary()?,
            true_angles: bytes.arbitrary()?,
            small_angles: Vec::new(),
            multipliers: bytes.arbitrary()?,
            user_constraints: bytes.int_in_range(0..=2)?,
            growth: bytes.arbitrary()?,
            quaternion: false,
            base_columns: Vec::new(),
        },
    };
    Ok((model, request, *bytes.choose(&Language::ALL)?))
}

/// Adds zeros, joints at rest, points, loops, links, sensors and forces.
pub(crate) fn decorate(model: &mut Model, bytes: &mut Unstructured<'_>) -> Result<()> {
    for body in &mut model.bodies {
        let numbers = body.center.iter_mut().chain(&mut body.inertia);
        for number in numbers {
            if bytes.ratio(1, 3)? {
                *number = 0.0;
            }
        }
    }
    for joint in &mut model.joints {
        if bytes.ratio(1, 8)? {
            joint.nature = Nature::Driven;
            joint.has_velocity = false;
            joint.has_acceleration = false;
        }
    }
    let anchor = |model: &Model, bytes: &mut Unstructured<'_>| -> Result<Anchor> {
        let point = bytes.choose_index(model.points.len() + 1)?;
        Ok(match model.points.get(point) {
            Some(place) => Anchor {
                body: place.body,
                point: Some(point),
            },
            None => Anchor {
                body: Some(bytes.choose_index(model.bodies.len())?),
                point: None,
            },
        })
    };
    for number in 0..bytes.int_in_range(0..=2)? {
        let ends = [anchor(model, bytes)?, anchor(model, bytes)?];
        let kind = *bytes.choose(&[CutKind::Ball, CutKind::Rod(0.75), CutKind::Solid])?;
        model.cuts.push(Cut {
            name: format!("cut{number}"),
            kind,
            ends,
            ignore: [bytes.arbitrary()?, false, false],
            rotation: None,
        });
        let ends = [anchor(model, bytes)?, anchor(model, bytes)?];
        // A link from a point to itself has no direction.
        if ends[0] != ends[1] {
            model.links.push(Link {
                name: format!("link{number}"),
                ends,
            });
        }
        if model.points.is_empty() {
            continue;
        }
        let sensor = Sensor {
            name: format!("sensor{number}"),
            point: bytes.choose_index(model.points.len())?,
            asks: Asks {
                position: true,
                rotation: bytes.arbitrary()?,
                velocity: bytes.arbitrary()?,
                angular_velocity: bytes.arbitrary()?,
                acceleration: bytes.arbitrary()?,
                angular_acceleration: bytes.arbitrary()?,
                jacobian: bytes.arbitrary()?,
            },
        };
        if bytes.arbitrary()? {
            model.sensors.push(sensor);
        } else {
            model.forces.push(sensor);
        }
    }
    model.sensors.sort_by_key(|sensor| sensor.point);
    model.forces.sort_by_key(|force| force.point);
    Ok(())
}

fn holds(model: &Model, request: &GenerationRequest, language: Language) {
    assert!(model.check());
    let module = match generate(model, request) {
        Ok(module) => module,
        // What is impossible for the formulation, the options or the model is
        // said; that lists do not fit together would be a lie.
        Err(GenerateError::Inconsistent(name)) => panic!("{name} is not inconsistent"),
        Err(error) => {
            assert!(!error.to_string().is_empty());
            let plain = request.formulation == Formulation::Recursive;
            assert!(!plain || request.function.is_special(), "{error}");
            return;
        }
    };
    check_sound(&module);
    if request.function == FunctionKind::Dirdyna {
        same_dynamics(model, request, &module);
    }
    if !module.functions.is_empty() {
        reads_back(&module, language);
    }
}

/// The formulation and the recursive one, on the circle.
fn same_dynamics(model: &Model, request: &GenerationRequest, module: &Module) {
    let plain = GenerationRequest {
        formulation: Formulation::Recursive,
        options: Options {
            true_angles: false,
            ..request.options.clone()
        },
        ..request.clone()
    };
    // Numbers of a model are rounded, so that only symbols can be compared.
    if request.options.parameters == ParameterBinding::Numbers {
        return;
    }
    let mut reference = match generate(model, &plain) {
        Ok(reference) => reference,
        Err(error) => panic!("{error}"),
    };
    // An entry that is zero only on the circle is set in one of them alone.
    let mut module = module.clone();
    let (before, after) = align(
        (&reference.functions[0], &mut reference.tables),
        (&module.functions[0], &mut module.tables),
    );
    let before = reference.tables.view(&before);
    let after = module.tables.view(&after);
    let verdict = check(before, after, NumericClass::RealTrig, &States::new(1), 2);
    assert!(verdict.holds(), "{request:?}: {verdict}");
}

/// True when the functions compute the same and only declare their inputs in
/// another order (the reader declares the results of user calls in the order of
/// their first read).
fn same_in_another_order(before: View<'_>, after: View<'_>) -> bool {
    let names = |view: View<'_>| -> Vec<String> {
        let inputs = view.function.inputs().iter();
        inputs
            .map(|array| format!("{} {:?}", view.tables.symbols.text(array.name), array.shape))
            .collect()
    };
    let (mut first, mut second) = (names(before), names(after));
    let reordered = first != second;
    first.sort();
    second.sort();
    if !reordered || first != second {
        return false;
    }
    let (mut tables, mut others) = (before.tables.clone(), after.tables.clone());
    let (one, other) = align(
        (before.function, &mut tables),
        (after.function, &mut others),
    );
    let before = tables.view(&one);
    let after = others.view(&other);
    check(before, after, NumericClass::Real, &States::new(1), 2).holds()
}

fn reads_back(module: &Module, language: Language) {
    let files = match write(module, language, &WriteOptions::default()) {
        Ok(files) => files,
        Err(error) => panic!("{error}"),
    };
    let (name, text) = &files[0];
    let again = match read(name, text.as_bytes(), None) {
        Ok(read) => read.module,
        Err(error) => panic!("{}\n{text}", error.report.render_plain()),
    };
    assert_eq!(again.functions.len(), module.functions.len(), "{text}");
    // Python's file of joint frames and Matlab's user functions have other
    // names; what is computed is compared where nothing is renamed.
    let renamed = |module: &Module| {
        let functions = &module.functions;
        functions
            .iter()
            .any(|f| !f.boundaries.is_empty() || f.name.starts_with("gensensor"))
    };
    if renamed(module) && language != Language::C {
        return;
    }
    for (before, after) in module.functions.iter().zip(&again.functions) {
        let (before, after) = (module.tables.view(before), again.tables.view(after));
        let same = same_equations(before, after) || same_in_another_order(before, after);
        assert!(
            same,
            "{} reads back as another function:\n{text}\n{}\n{}",
            before.function.name,
            print_module(module),
            print_module(&again)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn random_models() {
        cases::of_sizes(1500, 4000, |bytes| {
            let (model, request, language) = input(bytes)?;
            holds(&model, &request, language);
            Ok(())
        });
    }
}
