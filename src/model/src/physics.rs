//! Remarks on models that can be read but hardly be meant.

use super::xml::Messages;
use super::{Body, CutKind, Joint, JointKind, Model, Nature};
use robovec_ir::diagnostic::clip;
use std::ops::Range;

/// Warns of bodies without mass and of impossible inertias at names' `places`.
pub(super) fn remark(model: &Model, places: &[Range<usize>], messages: &mut Messages) {
    assert_eq!(
        places.len(),
        model.bodies.len(),
        "the name of every body has a place"
    );
    massless(model, places, messages);
    for (body, place) in model.bodies.iter().zip(places) {
        impossible(&body_title(&body.name), &body.inertia, place, messages);
    }
}

/// Warns of an inertia that no real body can have.
pub(super) fn impossible(
    title: &str,
    inertia: &[f64; 6],
    place: &Range<usize>,
    messages: &mut Messages,
) {
    let scale = scale(inertia);
    let label = if !is_positive(inertia, scale) {
        "its matrix has a negative principal moment"
    } else if !is_positive(&spread(inertia), scale) {
        "one of its principal moments is larger than the sum of the other two"
    } else {
        return;
    };
    messages.warn(
        place.clone(),
        &format!("the inertia of {title} is impossible"),
        label,
        "check signs and units: Ixy is an entry of the matrix, the negative of the integral of xy",
    );
}

pub(super) fn body_title(name: &str) -> String {
    format!("body '{}'", clip(name))
}

fn is_massless(body: &Body) -> bool {
    body.mass == 0.0 && body.inertia == [0.0; 6]
}

/// Warns of bodies that carry no mass, directly or on bodies attached to them:
/// the rows of their joints in `M` are zero. Only the first such body of a
/// branch is named; none where a cut closes a loop through the branch, which
/// determines its joints, or where they are driven or turn rotors.
pub(super) fn massless(model: &Model, places: &[Range<usize>], messages: &mut Messages) {
    let mut carries: Vec<bool> = model.bodies.iter().map(|body| !is_massless(body)).collect();
    let mut bound = vec![false; model.bodies.len()];
    let ends = model.cuts.iter().flat_map(|cut| cut.ends);
    ends.filter_map(|end| end.body)
        .for_each(|body| bound[body] = true);
    for (index, body) in model.bodies.iter().enumerate().rev() {
        if let Some(parent) = body.parent {
            carries[parent] |= carries[index];
            bound[parent] |= bound[index];
        }
    }
    massless_bases(model, &carries, places, messages);
    let driven = |joint: usize| is_driven(&model.joints[joint]);
    let bodies = model.bodies.iter().enumerate().filter(|(index, body)| {
        let first = !carries[*index] && body.parent.is_none_or(|parent| carries[parent]);
        first && !bound[*index] && !body.joints.clone().all(driven)
    });
    let named: Vec<(usize, &str)> = bodies
        .map(|(index, body)| (index, model.joints[body.joints.end - 1].name.as_str()))
        .collect();
    let Some((&(first, joint), others)) = named.split_first() else {
        return;
    };
    let title = body_title(&model.bodies[first].name);
    let (message, label) = match others {
        [] => (
            format!("{title} moves no mass"),
            format!("the row of joint '{joint}' in the mass matrix is zero"),
        ),
        _ => {
            let more = others.iter().map(|(_, joint)| format!(", '{joint}'"));
            (
                format!("{title} and {} more move no mass", others.len()),
                format!(
                    "the rows of joints '{joint}'{} in the mass matrix are zero",
                    more.collect::<String>()
                ),
            )
        }
    };
    messages.warn(
        places[first].clone(),
        &message,
        &label,
        "give it a mass, drive it (--driven), hold it (--hold), or bind it by constraints of the \
         project (--user-constraints)",
    );
}

fn is_driven(joint: &Joint) -> bool {
    joint.nature == Nature::Driven || joint.armature != 0.0
}

/// Warns of free bodies without mass that one other body is attached to: such a
/// body moves without mass, so the mass matrix is singular. None where a cut
/// holds one of them, or joints are driven or turn rotors.
fn massless_bases(
    model: &Model,
    carries: &[bool],
    places: &[Range<usize>],
    messages: &mut Messages,
) {
    for (index, body) in model.bodies.iter().enumerate() {
        let moves = |kind: JointKind| {
            let mut joints = model.joints[body.joints.clone()].iter();
            joints.any(|joint| joint.kind == kind && !is_driven(joint))
        };
        let is_free = body.parent.is_none() && JointKind::ALL.into_iter().all(moves);
        if !is_free || !is_massless(body) || !carries[index] {
            continue;
        }
        let mut attached = model.bodies.iter().filter(|one| one.parent == Some(index));
        let (Some(other), None) = (attached.next(), attached.next()) else {
            continue;
        };
        let is_held = |joint: usize| {
            let mut cuts = model.cuts.iter();
            is_driven(&model.joints[joint])
                || cuts.any(|cut| match cut.kind {
                    CutKind::Coupling(of) => joint == of.joint || joint == of.leader,
                    _ => cut.ends.iter().any(|end| end.body == Some(index)),
                })
        };
        let Some(joint) = other.joints.clone().find(|&joint| !is_held(joint)) else {
            continue;
        };
        let joint = &model.joints[joint].name;
        messages.warn(
            places[index].clone(),
            &format!("{} moves freely without mass", body_title(&body.name)),
            &format!("it and joint '{joint}' can move while no mass does: `M` is singular"),
            "give it a mass and an inertia, or drive (--driven) or hold (--hold) the joint",
        );
    }
}

/// The share of the largest entry that counts as rounding.
const ROUNDING: f64 = 1e-12;

/// The largest moment about an axis, kg m^2, against which rounding is measured.
fn scale(&[xx, _, _, yy, _, zz]: &[f64; 6]) -> f64 {
    [xx, yy, zz]
        .into_iter()
        .fold(0.0_f64, |a, b| a.max(b.abs()))
}

/// The integrals of xx, xy, xz, yy, yz and zz over the mass: half the trace
/// less the inertia. Its principal values are negative exactly when a
/// principal moment is larger than the sum of the other two.
fn spread(&[xx, xy, xz, yy, yz, zz]: &[f64; 6]) -> [f64; 6] {
    let half = |a: f64, b: f64, c: f64| (a + b - c) / 2.0;
    [
        half(yy, zz, xx),
        -xy,
        -xz,
        half(xx, zz, yy),
        -yz,
        half(xx, yy, zz),
    ]
}

/// True when no principal value is negative beyond rounding at this scale.
fn is_positive(&[xx, xy, xz, yy, yz, zz]: &[f64; 6], scale: f64) -> bool {
    let minor = |a: f64, b: f64, c: f64| a * b - c * c >= -ROUNDING * scale * scale;
    let determinant =
        xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    [xx, yy, zz]
        .into_iter()
        .all(|moment| moment >= -ROUNDING * scale)
        && minor(xx, yy, xy)
        && minor(xx, zz, xz)
        && minor(yy, zz, yz)
        && determinant >= -ROUNDING * scale.powi(3)
}
