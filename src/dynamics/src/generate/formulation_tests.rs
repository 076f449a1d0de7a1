//! Formulations against each other, on random trees.

use super::tests::serial;
use super::*;
use robovec_ir::Shape;
use robovec_ir::count::Counts;
use robovec_ir::evaluate::evaluate;
use robovec_model::{Body, Joint, JointKind, JointMounting, ModelPoint, Nature};
use robovec_num::field::{Field, PrimeField};
use robovec_num::random::Random;

/// A number of one decimal between -0.9 and 0.9, often zero.
fn length(random: &mut Random) -> f64 {
    if random.below(3) == 0 {
        0.0
    } else {
        (random.below(19) as f64 - 9.0) / 10.0
    }
}

/// A random tree: joints of all six kinds, fictitious bodies, now and then a
/// body without mass or a driven joint at rest.
pub(super) fn tree(seed: u64, bodies: usize) -> Model {
    let mut random = Random::new(seed);
    let mut model = Model::new("tree");
    for index in 0..bodies {
        // Mostly chains, so that paths become long.
        let parent = match random.below(4) {
            0 if index > 0 => Some(random.below(index)),
            0 => None,
            _ => index.checked_sub(1),
        };
        model.points.push(ModelPoint {
            name: format!("point{index}"),
            body: parent,
            coordinates: [
                length(&mut random),
                length(&mut random),
                length(&mut random),
            ],
        });
        let first = model.joints.len();
        let joints = 1 + random.below(3);
        for joint in first..first + joints {
            let before = parent.map(|parent| model.bodies[parent].joints.end - 1);
            let driven = random.below(8) == 0;
            model.joints.push(Joint {
                name: format!("joint{joint}"),
                kind: JointKind::ALL[random.below(6)],
                nature: if driven {
                    Nature::Driven
                } else {
                    Nature::Independent
                },
                body: index,
                parent: if joint == first {
                    before
                } else {
                    Some(joint - 1)
                },
                point: (joint == first).then_some(index),
                has_velocity: !driven,
                has_acceleration: !driven,
                actuated: false,
                initial: [0.0; 3],
                mounting: JointMounting::default(),
                limits: None,
                law: Default::default(),
                armature: [0.0, 0.0, 0.7][random.below(3)],
            });
        }
        let massless = random.below(6) == 0;
        let diagonal = random.below(2) == 0;
        let mut product = || {
            if diagonal {
                0.0
            } else {
                length(&mut random) / 100.0
            }
        };
        let inertia = [0.3, product(), product(), 0.4, product(), 0.5];
        model.bodies.push(Body {
            name: format!("body{index}"),
            parent,
            point: Some(index),
            joints: first..first + joints,
            mass: if massless { 0.0 } else { 1.5 },
            center: [
                length(&mut random),
                length(&mut random),
                length(&mut random),
            ],
            inertia: if massless { [0.0; 6] } else { inertia },
        });
    }
    sort_points(&mut model);
    model
}

/// Points are in the order of their bodies, as in files.
fn sort_points(model: &mut Model) {
    let mut order: Vec<usize> = (0..model.points.len()).collect();
    order.sort_by_key(|&point| model.points[point].body);
    let place = |point: usize| order.iter().position(|&old| old == point);
    for body in &mut model.bodies {
        body.point = body.point.and_then(place);
        model.joints[body.joints.start].point = body.point;
    }
    model.points = order
        .iter()
        .map(|&point| model.points[point].clone())
        .collect();
}

pub(super) fn make(model: &Model, function: FunctionKind, formulation: Formulation) -> Module {
    let mut request = GenerationRequest::new(function);
    request.formulation = formulation;
    generate(model, &request).expect("the formulation gives the function")
}

/// The elements of an input array at a random point of the prime field.
pub(super) fn input_point(name: &str, seed: u64, array: &robovec_ir::Array) -> Vec<u64> {
    let salt = name
        .bytes()
        .fold(seed, |hash, byte| hash * 31 + u64::from(byte));
    let field = PrimeField {
        seed: salt,
        ..point_field(seed, false)
    };
    let Shape::Matrix(rows, columns) = array.shape else {
        return field.point(array.shape.len());
    };
    // Formulations that need fewer points have narrower matrices of the same
    // elements.
    const WIDEST: usize = 100;
    let all = field.point(rows as usize * WIDEST);
    let rows = all.chunks(WIDEST);
    rows.flat_map(|row| &row[..columns as usize])
        .copied()
        .collect()
}

/// The prime field of a seed.
pub(super) fn point_field(seed: u64, circle: bool) -> PrimeField {
    PrimeField::pair(seed, circle)[0]
}

/// The output arrays of the first function at a random point of the prime
/// field; sines and cosines are on the circle on request. Elements that are not
/// set are zero.
pub(super) fn at_point(module: &Module, seed: u64, circle: bool) -> Vec<(String, Vec<u64>)> {
    let function = &module.functions[0];
    let name = |array: &robovec_ir::Array| module.tables.symbols.text(array.name);
    let inputs: Vec<u64> = function
        .inputs()
        .iter()
        .flat_map(|array| input_point(name(array), seed, array))
        .collect();
    let values = evaluate(function, &point_field(seed, circle), &inputs);
    let mut flat = vec![0; function.output_len()];
    for (assignment, value) in function.assignments.iter().zip(values) {
        flat[assignment.output.index()] = value;
    }
    let outputs = function.outputs().iter().map(|array| {
        let start = array.offset as usize;
        let values = flat[start..start + array.shape.len()].to_vec();
        (name(array).to_owned(), values)
    });
    outputs.collect()
}

/// Asserts that every formulation gives the function that the recursive one
/// gives, as polynomials of the inputs and of points of the circle.
fn assert_equal_to_recursive(function: FunctionKind) {
    for seed in 0..40 {
        let model = tree(seed, 1 + seed as usize % 9);
        assert!(model.check());
        let recursive = make(&model, function, Formulation::Recursive);
        for formulation in Formulation::ALL {
            if !formulation.gives(function) {
                continue;
            }
            let circle = formulation.requirements(function).true_sin_cos;
            let found = make(&model, function, formulation);
            assert_eq!(
                at_point(&found, seed, circle),
                at_point(&recursive, seed, circle),
                "{} of tree {seed}",
                formulation.name(),
            );
        }
    }
}

#[test]
fn formulations_are_equal_as_polynomials() {
    assert_equal_to_recursive(FunctionKind::Dirdyna);
    assert_equal_to_recursive(FunctionKind::Invdyna);
}

#[test]
fn operations_of_the_serial_chain_stay_low() {
    let model = serial(23);
    let operations = |formulation| {
        let mut request = GenerationRequest::new(FunctionKind::Dirdyna);
        request.formulation = formulation;
        request.options.external_forces = false;
        let module = generate(&model, &request).expect("the model is consistent");
        Counts::of(&module.functions[0]).operations
    };
    for (name, most) in [
        ("composite", 6353),
        ("composite-base", 6345),
        ("prefix-serial", 9056),
        ("prefix-brent-kung", 9857),
        ("prefix-sklansky", 10247),
        ("prefix-sklansky-base", 10767),
    ] {
        let formulation = Formulation::from_name(name).expect("it exists");
        let operations = operations(formulation);
        assert!(operations <= most, "{}: {operations}", formulation.name());
    }
}
