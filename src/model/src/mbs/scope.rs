//! The names of bodies and points in a model file, and the anchors (a point of
//! a body or of the base) that other elements name by them.

use super::fields::{ElementFields, Messages};
pub(super) use crate::physics::body_title;
use crate::{Anchor, Model};
use robovec_ir::diagnostic::{clip, suggestion};
use rustc_hash::FxHashMap;
use std::ops::Range;

/// The name of the base as a parent and at the ends of cuts and links.
pub(super) const BASE: &str = "base";
/// The name of a body's own frame, unless the body has a point of this name.
pub(super) const ORIGIN: &str = "origin";

/// The maximum number of points that a message lists.
const MAX_NAMED: usize = 8;

/// The names of a model, for the resolution of references. Indices are into
/// [`Model::bodies`] and [`Model::points`], from 0.
#[derive(Default)]
pub(super) struct ModelScope {
    /// The index of the body of each name.
    pub(super) bodies: FxHashMap<String, usize>,
    /// The index of the point of each name of a body, or of the base where the
    /// body is `None`. A body's own origin is no point and not in here.
    pub(super) points: FxHashMap<(Option<usize>, String), usize>,
    /// Place of each body's name, in bytes of the file, by the body's index.
    pub(super) body_places: Vec<Range<usize>>,
}

impl ModelScope {
    /// The anchor that the children `bodyname` and `pointname` of an element
    /// (`owner` in messages) name; `None`, with an error, without one.
    pub(super) fn anchor(
        &self,
        fields: &ElementFields<'_>,
        owner: &str,
        model: &Model,
        messages: &mut Messages,
    ) -> Option<Anchor> {
        let body_name = fields.name("bodyname", owner, messages);
        let point_name = fields.name("pointname", owner, messages);
        // A name that is missing is empty, and has had its error.
        if body_name.is_empty() || point_name.is_empty() {
            return None;
        }
        let body = if body_name == BASE {
            None
        } else if let Some(&body) = self.bodies.get(&body_name) {
            Some(body)
        } else {
            unknown_body(fields, owner, &body_name, model, messages);
            return None;
        };
        let point = self.points.get(&(body, point_name.clone())).copied();
        if point.is_none() && point_name != ORIGIN {
            unknown_point(fields, owner, body, &point_name, model, messages);
            return None;
        }
        // No point and no error: the origin.
        Some(Anchor { body, point })
    }
}

/// Adds the error that an element names a body that does not exist.
fn unknown_body(
    fields: &ElementFields<'_>,
    owner: &str,
    name: &str,
    model: &Model,
    messages: &mut Messages,
) {
    // The search for similar names takes time, and an error beyond the limit
    // is only counted.
    if !messages.has_room() {
        return messages.count_error();
    }
    let names = model.bodies.iter().map(|body| body.name.as_str());
    let help = suggestion(name, names.chain([BASE]))
        .unwrap_or_else(|| "name one of the bodies, or base".to_owned());
    messages.error(
        fields.place_of("bodyname"),
        &format!(
            "{owner} refers to a body '{}', which does not exist",
            clip(name)
        ),
        "no body has this name",
        &help,
    );
}

/// Adds the error for a point that its body, or the base, does not have.
fn unknown_point(
    fields: &ElementFields<'_>,
    owner: &str,
    body: Option<usize>,
    name: &str,
    model: &Model,
    messages: &mut Messages,
) {
    // As in `unknown_body`.
    if !messages.has_room() {
        return messages.count_error();
    }
    let title = body.map_or("the base".to_owned(), |body| {
        body_title(&model.bodies[body].name)
    });
    let names = model.points.iter().filter(|point| point.body == body);
    let names = names.map(|point| point.name.as_str());
    let help = suggestion(name, names.clone().chain([ORIGIN])).unwrap_or_else(|| {
        let all: Vec<&str> = names.chain([ORIGIN]).take(MAX_NAMED).collect();
        format!("the points of {title} are: {}", all.join(", "))
    });
    messages.error(
        fields.place_of("pointname"),
        &format!(
            "{owner} refers to a point '{}', which {title} does not have",
            clip(name)
        ),
        "no point of that body has this name",
        &help,
    );
}
