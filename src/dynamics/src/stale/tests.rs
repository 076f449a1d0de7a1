use super::*;
use crate::generate::generate_into;
use robovec_model::JointKind;
use robovec_model::family::{built_in, random_tree};

fn equations(model: &Model, kinds: &[FunctionKind]) -> Module {
    let mut module = Module::new();
    for &kind in kinds {
        generate_into(&mut module, model, &GenerationRequest::new(kind)).expect("every model can");
    }
    module
}

const KINDS: [FunctionKind; 7] = [
    FunctionKind::Dirdyna,
    FunctionKind::Invdyna,
    FunctionKind::ConsHJ,
    FunctionKind::ConsJdqd,
    FunctionKind::Link,
    FunctionKind::Extforces,
    FunctionKind::Sensor,
];

fn messages(comparison: &Comparison) -> String {
    let findings = comparison.findings.iter();
    findings
        .map(|finding| format!("{}: {}\n", finding.stale, finding.message))
        .collect()
}

#[test]
fn equations_of_the_model_itself_are_fresh() {
    let trees = (0..10).map(|seed| random_tree(seed, 8));
    let systems = [
        built_in("quarter-car").expect("a family"),
        built_in("four-bar").expect("a family"),
        built_in("slider-crank").expect("a family"),
    ];
    for model in trees.chain(systems) {
        let kinds: Vec<FunctionKind> = KINDS
            .into_iter()
            .filter(|kind| !model.sensors.is_empty() || *kind != FunctionKind::Sensor)
            .collect();
        let module = equations(&model, &kinds);
        let comparison = compare(&model, &module);
        assert_eq!(messages(&comparison), "");
        let all = module.functions.iter();
        let all = all.filter(|function| !function.assignments.is_empty());
        assert_eq!(comparison.equal.len(), all.count());
    }
}

#[test]
fn a_zero_that_was_filled_in_is_named() {
    let model = built_in("quarter-car").expect("a family");
    let module = equations(&model, &[FunctionKind::Dirdyna]);
    let mut changed = model.clone();
    changed.points[3].coordinates[2] = 0.02;
    let said = messages(&compare(&changed, &module));
    let named = "true: 'dirdyna' does not use dpt[3,4] (point Ball of Lower_wishbone)";
    assert!(said.contains(named), "{said}");
    // Along the axis of all hinges it means nothing to the equations.
    let mut harmless = model;
    harmless.points[6].coordinates[0] = 0.02;
    assert_eq!(messages(&compare(&harmless, &module)), "");
}

#[test]
fn a_value_that_became_zero_is_only_a_remark() {
    let mut model = built_in("quarter-car").expect("a family");
    model.bodies[1].center[2] = 0.01;
    let module = equations(&model, &[FunctionKind::Dirdyna]);
    let comparison = compare(&built_in("quarter-car").expect("a family"), &module);
    let said = messages(&comparison);
    assert!(!comparison.is_stale(), "{said}");
    assert!(
        said.contains("longer than needed: it uses l[3,2] (body Lower_wishbone)"),
        "{said}"
    );
}

#[test]
fn other_values_are_no_reason() {
    let module = equations(&built_in("quarter-car").expect("a family"), &KINDS);
    let mut changed = built_in("quarter-car").expect("a family");
    changed.bodies[0].mass = 400.0;
    changed.points[0].coordinates[1] = 0.31;
    assert_eq!(messages(&compare(&changed, &module)), "");
}

#[test]
fn changes_of_the_tree_are_found() {
    let model = built_in("quarter-car").expect("a family");
    let module = equations(&model, &[FunctionKind::Dirdyna]);
    let mut turned = model.clone();
    turned.joints[4].kind = JointKind::ALL[3];
    let said = messages(&compare(&turned, &module));
    assert!(
        said.contains("true: 'dirdyna' is not the model's"),
        "{said}"
    );
    let mut moved = model.clone();
    moved.bodies[3].point = Some(0);
    moved.connect();
    assert!(
        !compare(&moved, &equations(&model, &[FunctionKind::ConsHJ]))
            .equal
            .contains(&"cons_hJ".to_owned())
    );
    let said = messages(&compare(&built_in("four-bar").expect("a family"), &module));
    assert!(
        said.contains("true: the file is for 5 joints, the model has 3"),
        "{said}"
    );
    assert!(
        said.contains("false: the file belongs to project 'suspension'"),
        "{said}"
    );
}

#[test]
fn ids_beyond_the_model_and_lost_sensors_are_found() {
    let model = built_in("quarter-car").expect("a family");
    let mut fewer = model.clone();
    fewer.points.pop();
    fewer.sensors.pop();
    fewer.forces.pop();
    let said = messages(&compare(
        &fewer,
        &equations(&model, &[FunctionKind::Sensor]),
    ));
    assert!(said.contains("no equations for 'sensor_2'"), "{said}");
    let said = messages(&compare(
        &model,
        &equations(&fewer, &[FunctionKind::Sensor]),
    ));
    assert!(said.contains("sensors, the model"), "{said}");
    let mut no_loop = model.clone();
    no_loop.points.truncate(5);
    no_loop.cuts.clear();
    no_loop.bodies[4].point = None;
    (no_loop.sensors, no_loop.forces) = (Vec::new(), Vec::new());
    no_loop.connect();
    let said = messages(&compare(
        &no_loop,
        &equations(&model, &[FunctionKind::ConsHJ]),
    ));
    assert!(
        said.contains("uses point 8 in dpt, but the model has 5"),
        "{said}"
    );
}
