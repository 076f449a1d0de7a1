use super::*;
use crate::family::ModelFamily;
use crate::mbs::{read_mbs, write_mbs};
use crate::{Anchor, CutKind, Model};

/// Where an anchor is in the base frame at the initial position of a planar or
/// any other model: the joints' motions one by one, from the anchor to the base.
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
    for model in [four_bar(), slider_crank(), quarter_car(), wishbone_car()] {
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
        assert_eq!(ModelFamily::from_name(family.name()), Some(family));
    }
}

#[test]
fn the_wheels_of_the_bogie_stand_on_the_rails() {
    let model = bogie();
    assert_eq!(model.forces.len(), 4);
    for force in &model.forces {
        let place = Anchor {
            body: model.points[force.point].body,
            point: Some(force.point),
        };
        assert!((position(&model, place)[2] - 0.45).abs() < 1e-12);
    }
}
