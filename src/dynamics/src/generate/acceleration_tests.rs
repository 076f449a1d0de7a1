//! Accelerations against `M qdd + c = Qq`, and functions that cannot be
//! generated.

use super::formulation_tests::{at_point, make, point_field, tree};
use super::tests::serial;
use super::*;
use robovec_ir::count::Counts;
use robovec_model::family::built_in;
use robovec_model::{JointKind, Nature};
use robovec_num::arithmetic::Arithmetic;

/// A random tree without the causes of a singular mass matrix: bodies without
/// mass, and joints of one kind in a row.
fn regular_tree(seed: u64) -> Model {
    let mut model = tree(seed, 1 + seed as usize % 6);
    for body in &mut model.bodies {
        body.mass = 1.5;
        body.inertia = [0.3, 0.0, 0.02, 0.4, 0.0, 0.5];
        body.center = [0.1, 0.2, -0.3];
    }
    for point in &mut model.points {
        point.coordinates = [0.5, 0.25, -0.75];
    }
    for joint in 1..model.joints.len() {
        let place = |kind| JointKind::ALL.iter().position(|&one| one == kind);
        while place(model.joints[joint].kind) == place(model.joints[joint - 1].kind)
            || joint >= 2 && model.joints[joint].kind == model.joints[joint - 2].kind
        {
            let next = place(model.joints[joint].kind).map_or(0, |place| (place + 1) % 6);
            model.joints[joint].kind = JointKind::ALL[next];
        }
    }
    model
}

fn array<'a>(outputs: &'a [(String, Vec<u64>)], name: &str) -> &'a [u64] {
    let found = outputs.iter().find(|(array, _)| array == name);
    found.map_or(&[], |(_, values)| values)
}

#[test]
fn accelerations_solve_the_equations_of_motion_exactly() {
    for seed in 0..24 {
        let model = regular_tree(seed);
        let count = model.joints.len();
        let field = point_field(seed, true);
        let dynamics = make(&model, FunctionKind::Dirdyna, Formulation::Composite);
        let dynamics = at_point(&dynamics, seed, true);
        let (mass, bias) = (array(&dynamics, "M"), array(&dynamics, "c"));
        for formulation in Formulation::ALL {
            let module = make(&model, FunctionKind::Accelred, formulation);
            let function = &module.functions[0];
            let outputs = at_point(&module, seed, true);
            let accelerations = array(&outputs, "qdd");
            // The joint forces are the inputs of the same point.
            let inputs = function.inputs().iter();
            let forces = inputs
                .filter(|array| module.tables.symbols.text(array.name) == "Qq")
                .flat_map(|array| super::formulation_tests::input_point("Qq", seed, array))
                .collect::<Vec<u64>>();
            for (joint, state) in model.joints.iter().enumerate() {
                if state.nature == Nature::Driven {
                    continue;
                }
                let row = &mass[joint * count..(joint + 1) * count];
                let mut sum = bias[joint];
                for (&entry, &acceleration) in row.iter().zip(accelerations) {
                    sum = field.add(sum, field.mul(entry, acceleration));
                }
                assert_eq!(
                    sum,
                    forces[joint],
                    "{}, tree {seed}, joint {joint}",
                    formulation.name()
                );
            }
        }
    }
}

/// Refusal instead of a function.
fn refusal(model: &Model, request: &GenerationRequest) -> String {
    match generate(model, request) {
        Ok(_) => panic!("{request:?} is given"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn what_cannot_be_given_says_what_can() {
    let mut request = GenerationRequest::new(FunctionKind::Dirdyna);
    request.formulation = Formulation::Articulated;
    let refused = refusal(&serial(3), &request);
    assert!(
        refused.contains("'articulated' does not give dirdyna"),
        "{refused}"
    );
    assert!(refused.contains("composite-base"), "{refused}");
    request.function = FunctionKind::Accelred;
    let refused = refusal(&built_in("four-bar").expect("a family"), &request);
    assert!(
        refused.contains("does not support constraints"),
        "{refused}"
    );
    request.options.true_angles = false;
    let refused = refusal(&serial(3), &request);
    assert!(refused.contains("sin^2 + cos^2 = 1"), "{refused}");
    request.options.true_angles = true;
    let mut model = serial(2);
    model.bodies[1].mass = 0.0;
    model.bodies[1].inertia = [0.0; 6];
    for formulation in [Formulation::Articulated, Formulation::Composite] {
        request.formulation = formulation;
        let refused = refusal(&model, &request);
        assert!(refused.contains("'joint1'"), "{refused}");
    }
}

#[test]
fn a_long_chain_is_not_eliminated() {
    let mut request = GenerationRequest::new(FunctionKind::Accelred);
    request.formulation = Formulation::CompositeBase;
    let refused = refusal(&serial(360), &request);
    assert!(refused.contains("'articulated'"), "{refused}");
    request.formulation = Formulation::Articulated;
    assert!(generate(&serial(360), &request).is_ok());
}

#[test]
fn operations_for_accelerations_stay_low() {
    let operations = |joints, formulation| {
        let mut request = GenerationRequest::new(FunctionKind::Accelred);
        request.formulation = formulation;
        request.options.external_forces = false;
        let module = generate(&serial(joints), &request).expect("the chain is regular");
        Counts::of(&module.functions[0]).operations
    };
    for (joints, formulation, most) in [
        (23, Formulation::Articulated, 5_885),
        (50, Formulation::Articulated, 14_000),
        (23, Formulation::Composite, 11_735),
    ] {
        let operations = operations(joints, formulation);
        assert!(operations <= most, "{}: {operations}", formulation.name());
    }
}
