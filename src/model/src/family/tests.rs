use super::*;
use crate::mbs::write_mbs;
use crate::{Anchor, CutKind};
use rustc_hash::FxHashSet;

/// Moments that are positive and of which none exceeds the sum of the others,
/// in any axes: the matrix `trace/2 E - I` of second moments is positive.
fn assert_possible(inertia: [f64; 6]) {
    let [xx, xy, xz, yy, yz, zz] = inertia;
    let half = (xx + yy + zz) / 2.0;
    let (a, b, c) = (half - xx, half - yy, half - zz);
    assert!(a > 0.0 && a * b - xy * xy > 0.0, "{inertia:?}");
    let determinant = a * (b * c - yz * yz) + xy * (-xy * c - yz * xz) - xz * (xy * yz + b * xz);
    assert!(determinant > 0.0, "{inertia:?}");
}

#[test]
fn known_topologies_have_the_joints_and_operations_of_the_thesis() {
    // Operations of Table 3.1 at 72.5 for each pair.
    let table = [
        (TrunkTree::semi_serial(23), 23, 9150.0),
        (TrunkTree::parallel(23), 23, 6410.0),
        (TrunkTree::semi_serial(50), 50, 40348.0),
        (TrunkTree::parallel(50), 50, 15187.0),
        (TrunkTree::thesis_70(), 70, 100_143.0),
        (TrunkTree::semi_serial(70), 70, 37847.0),
        (TrunkTree::parallel(70), 70, 19444.0),
        (TrunkTree::semi_serial(100), 100, 66960.0),
        (TrunkTree::parallel(100), 100, 42676.0),
        (TrunkTree::semi_serial(130), 130, 140_783.0),
        (TrunkTree::parallel(130), 130, 68844.0),
    ];
    for (topology, joints, operations) in table {
        assert_eq!(topology.joints(), joints);
        assert_eq!(tree("t", &topology, 1).pairs(), topology.pairs());
        let ratio = topology.pairs() as f64 * 72.5 / operations;
        // A body on the base costs less than a pair on average.
        let allowed = if topology.trunk == 0 { 0.08 } else { 0.03 };
        assert!((ratio - 1.0).abs() < allowed, "{joints}: {ratio}");
    }
}

#[test]
fn every_number_of_joints_has_its_trees() {
    for joints in 1..200 {
        for topology in [TrunkTree::semi_serial(joints), TrunkTree::parallel(joints)] {
            assert_eq!(topology.joints(), joints, "{topology:?}");
            assert!(!topology.branches.contains(&0), "{topology:?}");
        }
    }
}

#[test]
fn the_serial_model_is_the_frozen_one() {
    let model = serial(23, 1);
    assert!(model.check());
    for (index, body) in model.bodies.iter().enumerate() {
        let kind = model.joints[index].kind.name();
        assert_eq!(kind, if index % 2 == 0 { "R1" } else { "R2" });
        assert!(body.mass > 0.0 && body.center[0] != 0.0);
        assert_eq!(body.center[1..], [0.0, 0.0]);
        assert!(!body.inertia.contains(&0.0));
        assert_possible(body.inertia);
        assert_eq!(body.point, index.checked_sub(1));
    }
    for point in &model.points {
        assert_eq!(point.coordinates[..2], [0.0, 0.0]);
        assert!(point.coordinates[2] != 0.0);
    }
    assert_eq!(model.points.len(), 22);
    assert_eq!(model, serial(23, 1));
    assert_ne!(model, serial(23, 2));
}

#[test]
fn axes_of_successive_joints_differ_on_every_path() {
    let model = tree("t", &TrunkTree::semi_serial(50), 3);
    for joint in &model.joints {
        if let Some(parent) = joint.parent {
            assert_ne!(joint.kind, model.joints[parent].kind);
        }
    }
}

#[test]
fn random_trees_are_sound_and_have_all_types() {
    for seed in 0..200 {
        let joints = 1 + seed as usize % 40;
        let model = random_tree(seed, joints);
        assert!(model.check());
        assert_eq!(model.joints.len(), joints);
        let kinds: FxHashSet<_> = model.joints.iter().map(|joint| joint.kind).collect();
        assert_eq!(kinds.len(), joints.min(6));
        for body in &model.bodies {
            assert_possible(body.inertia);
            let kinds: FxHashSet<_> = model.joints[body.joints.clone()]
                .iter()
                .map(|joint| joint.kind)
                .collect();
            assert_eq!(kinds.len(), body.joints.len());
        }
    }
}

/// Place where an anchor is in the base frame at the initial position of a
/// planar or any other model: the joints' motions one by one, from the anchor
/// to the base.
fn position(model: &Model, anchor: Anchor) -> [f64; 3] {
    let mut at = anchor
        .point
        .map_or([0.0; 3], |point| model.points[point].coordinates);
    for joint in model.path(model.last_joint(anchor.body)) {
        let joint = &model.joints[joint];
        let axis = joint.kind.axis().index();
        let (q, next, last) = (joint.initial[0], (axis + 1) % 3, (axis + 2) % 3);
        if joint.kind.is_revolute() {
            let (y, z) = (at[next], at[last]);
            at[next] = q.cos() * y - q.sin() * z;
            at[last] = q.sin() * y + q.cos() * z;
        } else {
            at[axis] += q;
        }
        if let Some(point) = joint.point {
            for (to, by) in at.iter_mut().zip(model.points[point].coordinates) {
                *to += by;
            }
        }
    }
    at
}

#[test]
fn loops_are_closed_at_the_initial_positions() {
    for name in ["four-bar", "slider-crank", "quarter-car", "wishbone-car"] {
        let model = built_in(name).expect("a family");
        for cut in &model.cuts {
            let [a, b] = cut.ends.map(|end| position(&model, end));
            let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
            let distance = match cut.kind {
                CutKind::Rod(length) => square.sqrt() - length,
                _ => square.sqrt(),
            };
            assert!(distance.abs() < 2e-6, "{}: {distance}", model.name);
        }
    }
}

#[test]
fn systems_have_their_joints_and_survive_their_files() {
    for family in ModelFamily::ALL {
        let joints = family.joints().unwrap_or(12);
        let model = family.build(joints, 5);
        assert_eq!(model.joints.len(), joints, "{}", model.name);
        let read = read_mbs("m.mbs", write_mbs(&model).as_bytes()).expect("ours");
        assert_eq!(read.model, model);
        assert_eq!(read.warnings.render_plain(), "");
        let named = ModelFamily::from_name(family.name()).expect("a family");
        assert_eq!(named.name(), family.name());
    }
}

#[test]
fn the_wheels_of_the_bogie_stand_on_the_rails() {
    let model = built_in("bogie").expect("a family");
    assert_eq!(model.forces.len(), 4);
    for force in &model.forces {
        let place = Anchor {
            body: model.points[force.point].body,
            point: Some(force.point),
        };
        assert!((position(&model, place)[2] - 0.45).abs() < 1e-12);
    }
}
