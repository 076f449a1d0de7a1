//! Base parameters of known arms, and forces from them.

use super::read;
use crate::support::files::tree;
use crate::support::programs::{robovec, said, stderr, unfolded};
use robovec::generate::{
    BaseParameters, GenerationRequest, Options, ParameterBinding, generate, parameter_name,
};
use robovec::model::robot::RobotBase;
use robovec::model::{Model, family};
use robovec::robotran::FunctionKind;
use robovec_ir::evaluate::evaluate;
use robovec_num::arithmetic::Binary64;
use robovec_num::random::Random;
use std::fs;

/// A chain of revolute joints: axis and place of each, after a rotation about x.
fn chain(joints: &[(&str, &str, &str)]) -> String {
    let mut text = "<robot name='chain'><link name='l0'/>".to_owned();
    for (index, (axis, place, roll)) in joints.iter().enumerate() {
        let next = index + 1;
        text += &format!(
            "<joint name='j{next}' type='continuous'><parent link='l{index}'/>\
             <child link='l{next}'/><origin xyz='{place}' rpy='{roll} 0 0'/><axis xyz='{axis}'/>\
             </joint><link name='l{next}'><inertial><origin xyz='0.1 0.02 0.03'/>\
             <mass value='2'/><inertia ixx='0.1' iyy='0.2' izz='0.15' ixy='0.01' ixz='0.02' \
             iyz='0.03'/></inertial></link>"
        );
    }
    text + "</robot>"
}

fn shipped(file: &str, base: RobotBase) -> Model {
    let path = tree(&format!("examples/robots/{file}"));
    read(file, &fs::read_to_string(path).expect("it ships"), base)
}

fn found(model: &Model, options: &Options) -> BaseParameters {
    BaseParameters::new(model, options).expect("they are found")
}

#[test]
fn known_arms_have_as_many_base_parameters_as_in_the_literature() {
    let puma = [
        ("0 0 1", "0 0 0", "0"),
        ("0 1 0", "0 0 0", "0"),
        ("0 1 0", "0.43 0.15 0", "0"),
        ("1 0 0", "0.43 0 0.02", "0"),
        ("0 1 0", "0 0 0", "0"),
        ("1 0 0", "0 0 0", "0"),
    ];
    let flat = [("0 0 1", "0 0 0", "0"), ("0 0 1", "0.5 0 0", "0")];
    let upright = [("0 1 0", "0 0 0", "0"), ("0 1 0", "0.5 0 0", "0")];
    let fixed = |joints: &[_]| read("chain", &chain(joints), RobotBase::Fixed);
    let free = |joints: &[_]| read("chain", &chain(joints), RobotBase::Floating);
    for (model, count) in [
        (fixed(&puma), 36),
        (free(&puma), 10 + 7 * 6),
        (fixed(&flat), 4),
        (fixed(&upright), 6),
        (family::built_in("double-pendulum").expect("it ships"), 6),
        (shipped("arm.urdf", RobotBase::Fixed), 43),
        (shipped("quadruped.urdf", RobotBase::Fixed), 68),
        (shipped("quadruped.urdf", RobotBase::Floating), 10 + 7 * 12),
    ] {
        let found = found(&model, &Options::default());
        assert_eq!(found.parameters.len(), count, "{}", model.name);
    }
    // The moments and the first moments of both links in their plane.
    let found = found(&fixed(&upright), &Options::default());
    let sums = found.parameters.iter().map(|base| {
        let terms = base.terms.iter();
        let terms = terms.map(|&(at, factor)| format!("{factor} {}", parameter_name(at)));
        terms.collect::<Vec<_>>().join(" + ")
    });
    assert_eq!(
        sums.collect::<Vec<_>>(),
        [
            "1 mx[1] + 0.5 m[2]",
            "1 mz[1]",
            "1 Iyy[1] + 0.25 m[2]",
            "1 mx[2]",
            "1 mz[2]",
            "1 Iyy[2]"
        ]
    );
}

#[test]
fn the_reduced_regressor_gives_the_forces_of_inverse_dynamics() {
    for (file, base, quaternion) in [
        ("arm.urdf", RobotBase::Fixed, false),
        ("quadruped.urdf", RobotBase::Floating, false),
        ("quadruped.urdf", RobotBase::Floating, true),
    ] {
        let model = shipped(file, base);
        let mut options = Options {
            parameters: ParameterBinding::Numbers,
            external_forces: false,
            quaternion,
            ..Options::default()
        };
        let found = found(&model, &options);
        options.base_columns = found.columns();
        let values = |function| {
            let mut request = GenerationRequest::new(function);
            request.options = options.clone();
            let module = generate(&model, &request).expect("it is generated");
            let function = &module.functions[0];
            let mut random = Random::new(3);
            let mut inputs = vec![0.0; function.input_len()];
            for name in ["q", "qd", "qdd", "quat"] {
                let symbols = &module.tables.symbols;
                let mut arrays = function.inputs().iter();
                if let Some(array) = arrays.find(|array| symbols.text(array.name) == name) {
                    let elements = &mut inputs[array.offset as usize..][..array.shape.len()];
                    elements.fill_with(|| random.signed());
                }
            }
            let mut outputs = vec![0.0; function.output_len()];
            let numbers = evaluate(function, &Binary64, &inputs);
            for (set, number) in function.assignments.iter().zip(numbers) {
                outputs[set.output.index()] = number;
            }
            outputs
        };
        let forces = values(FunctionKind::Invdyna);
        let regressor = values(FunctionKind::Regressor);
        let count = found.parameters.len();
        assert_eq!(regressor.len(), forces.len() * count);
        let size = forces
            .iter()
            .fold(0.0f64, |most, force| most.max(force.abs()));
        for (row, force) in regressor.chunks(count).zip(&forces) {
            let products = row.iter().zip(&found.parameters);
            let sum: f64 = products.map(|(entry, base)| entry * base.value).sum();
            assert!((sum - force).abs() <= 1e-12 * size, "{file}: {sum} {force}");
        }
    }
}

#[test]
fn effects_between_rounding_and_measurement_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("tilted.urdf");
    let joints = [("0 0 1", "0 0 0", "1e-9"), ("0 0 1", "0.5 0 0", "0")];
    fs::write(&path, chain(&joints)).expect("written");
    let path = path.to_str().expect("a plain name");
    let refused = robovec(&["model", path, "--base-parameters"]);
    let message = unfolded(&stderr(&refused));
    assert!(!refused.status.success() && refused.stdout.is_empty());
    assert!(message.contains("has almost no effect"), "{message}");
    assert!(message.contains("--right-angles 1e-5"), "{message}");
    let taken = ["model", path, "--base-parameters", "--right-angles", "1e-5"];
    assert!(said(&robovec(&taken)).starts_with("4 base parameters of 20 (15 without effect"));
    let other = robovec(&["gen", path, "--base-parameters"]);
    assert!(unfolded(&stderr(&other)).contains("add --function regressor"));
}
