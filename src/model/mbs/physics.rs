//! Remarks on models that can be read but hardly be meant.

use super::fields::Messages;
use super::scope::{Scope, body_title};
use crate::model::{Body, Model, Nature};

/// Warns of massless ends of the tree and of impossible inertias.
pub(super) fn remark(model: &Model, scope: &Scope, messages: &mut Messages) {
    massless(model, scope, messages);
    for (body, place) in model.bodies.iter().zip(&scope.body_places) {
        if !is_positive(&body.inertia) {
            messages.warn(
                place.clone(),
                &format!("the inertia of {} is impossible", body_title(&body.name)),
                "its matrix has a negative principal moment",
                "check signs and units: Ixy is an entry of the matrix, the negative of the \
                 integral of xy",
            );
        }
    }
}

fn is_massless(body: &Body) -> bool {
    body.mass == 0.0 && body.inertia == [0.0; 6]
}

/// A body that carries no mass, directly or on bodies that hang on it, makes
/// the rows of its joints in `M` zero. Only the first such body of a branch is
/// named.
fn massless(model: &Model, scope: &Scope, messages: &mut Messages) {
    let mut carries: Vec<bool> = model.bodies.iter().map(|body| !is_massless(body)).collect();
    for (index, body) in model.bodies.iter().enumerate().rev() {
        if let Some(parent) = body.parent {
            carries[parent] |= carries[index];
        }
    }
    for (index, body) in model.bodies.iter().enumerate() {
        let named = !carries[index] && body.parent.is_none_or(|parent| carries[parent]);
        let driven = |joint: usize| model.joints[joint].nature == Nature::Driven;
        if named && !body.joints.clone().all(driven) {
            let joint = &model.joints[body.joints.end - 1].name;
            messages.warn(
                scope.body_places[index].clone(),
                &format!("{} moves no mass", body_title(&body.name)),
                &format!("the row of joint '{joint}' in the mass matrix is zero"),
                "give it a mass, or do not solve for this joint's acceleration",
            );
        }
    }
}

/// True when no principal moment is negative beyond rounding.
fn is_positive(&[xx, xy, xz, yy, yz, zz]: &[f64; 6]) -> bool {
    let scale = [xx, yy, zz]
        .into_iter()
        .fold(0.0_f64, |a, b| a.max(b.abs()));
    let minor = |a: f64, b: f64, c: f64| a * b - c * c >= -1e-12 * scale * scale;
    let determinant =
        xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    [xx, yy, zz].into_iter().all(|moment| moment >= 0.0)
        && minor(xx, yy, xy)
        && minor(xx, zz, xz)
        && minor(yy, zz, yz)
        && determinant >= -1e-12 * scale.powi(3)
}
