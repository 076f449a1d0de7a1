use super::*;
use robovec_ir::count::Counts;
use robovec_model::{Axis, Body, Joint, JointKind, JointMounting, ModelPoint, Nature};

/// The serial chain of the study: rotations about the first and second axis in
/// turn, full inertias, one component for attachments and centres.
pub(super) fn serial(joints: usize) -> Model {
    let mut model = Model::new("serial");
    for index in 0..joints {
        let axis = if index % 2 == 0 { Axis::X } else { Axis::Y };
        let parent = index.checked_sub(1);
        model.bodies.push(Body {
            name: format!("body{index}"),
            parent,
            point: parent,
            joints: index..index + 1,
            mass: 1.0,
            center: [0.1, 0.0, 0.0],
            inertia: [0.3, 0.01, 0.02, 0.4, 0.03, 0.5],
        });
        model.joints.push(Joint {
            name: format!("joint{index}"),
            kind: JointKind::Revolute(axis),
            nature: Nature::Independent,
            body: index,
            parent,
            point: parent,
            has_velocity: true,
            has_acceleration: true,
            actuated: false,
            initial: [0.0; 3],
            mounting: JointMounting::default(),
            limits: None,
            law: Default::default(),
            armature: 0.0,
        });
        model.points.push(ModelPoint {
            name: "next".to_owned(),
            body: Some(index),
            coordinates: [0.0, 0.0, 0.2],
        });
    }
    model
}

#[test]
fn the_serial_chain_has_the_operations_of_the_study() {
    let model = serial(23);
    let mut request = GenerationRequest::new(FunctionKind::Dirdyna);
    request.options.order = TermOrder::ChildFirst;
    request.options.external_forces = false;
    request.options.leading_signs = true;
    request.options.expanded = true;
    let count = |request: &GenerationRequest| {
        let module = generate(&model, request).expect("the model is consistent");
        Counts::of(&module.functions[0])
    };
    let printed = count(&request);
    // Thesis, Table 3.1: 19970 operations.
    assert_eq!(printed.operations, 19726);
    assert_eq!(printed.equations, 4137 + printed.sin_cos);
    assert_eq!(printed.vectors, 69);
    request.options.leading_signs = false;
    let moved = count(&request);
    assert_eq!(moved.negations, 0);
    assert_eq!(moved.operations, printed.operations - printed.negations);
}
