//! Names, and the places they tell.

use super::fields::{ElementFields, Messages, place};
use crate::model::{Anchor, Model};
use robovec_ir::diagnostic::{clip, did_you_mean};
use rustc_hash::FxHashMap;
use std::ops::Range;

/// The name of the base as a parent and at the ends of cuts and links.
pub(super) const BASE: &str = "base";
/// The name of a body's own frame, unless the body has a point of this name.
pub(super) const ORIGIN: &str = "origin";

/// The names of a model, for what refers to them.
#[derive(Default)]
pub(super) struct ModelScope {
    pub(super) bodies: FxHashMap<String, usize>,
    pub(super) points: FxHashMap<(Option<usize>, String), usize>,
    /// Where each body's name is written.
    pub(super) body_places: Vec<Range<usize>>,
}

/// How messages call a body.
pub(super) fn body_title(name: &str) -> String {
    format!("body '{}'", clip(name))
}

impl ModelScope {
    /// The place that `bodyname` and `pointname` of an element tell; `None`,
    /// with an error, when there is no such place.
    pub(super) fn anchor(
        &self,
        fields: &ElementFields<'_>,
        owner: &str,
        model: &Model,
        messages: &mut Messages,
    ) -> Option<Anchor> {
        let body_name = fields.name("bodyname", owner, messages);
        let point_name = fields.name("pointname", owner, messages);
        if body_name.is_empty() || point_name.is_empty() {
            return None;
        }
        let body = (body_name != BASE).then(|| self.bodies.get(&body_name).copied());
        let body = match body {
            Some(None) => {
                no_body(fields, owner, &body_name, model, messages);
                return None;
            }
            Some(known) => known,
            None => None,
        };
        let point = self.points.get(&(body, point_name.clone())).copied();
        if point.is_none() && point_name != ORIGIN {
            no_point(fields, owner, body, &point_name, model, messages);
            return None;
        }
        Some(Anchor { body, point })
    }
}

fn no_body(
    fields: &ElementFields<'_>,
    owner: &str,
    name: &str,
    model: &Model,
    messages: &mut Messages,
) {
    // The search for similar names takes time.
    if !messages.has_room() {
        return messages.count_error();
    }
    let names = model.bodies.iter().map(|body| body.name.as_str());
    let help = match did_you_mean(name, names.chain([BASE])) {
        Some(near) => format!("did you mean '{near}'?"),
        None => "name one of the bodies, or base".to_owned(),
    };
    messages.error(
        fields.one("bodyname").map_or(0..0, place),
        &format!(
            "{owner} names a body '{}', which does not exist",
            clip(name)
        ),
        "no body has this name",
        &help,
    );
}

fn no_point(
    fields: &ElementFields<'_>,
    owner: &str,
    body: Option<usize>,
    name: &str,
    model: &Model,
    messages: &mut Messages,
) {
    // As above.
    if !messages.has_room() {
        return messages.count_error();
    }
    let title = body.map_or("the base".to_owned(), |body| {
        body_title(&model.bodies[body].name)
    });
    let names = model.points.iter().filter(|point| point.body == body);
    let names = names.map(|point| point.name.as_str());
    let help = match did_you_mean(name, names.clone().chain([ORIGIN])) {
        Some(near) => format!("did you mean '{near}'?"),
        None => {
            let all: Vec<&str> = names.chain([ORIGIN]).take(8).collect();
            format!("the points of {title} are: {}", all.join(", "))
        }
    };
    messages.error(
        fields.one("pointname").map_or(0..0, place),
        &format!(
            "{owner} names a point '{}', which {title} does not have",
            clip(name)
        ),
        "no point of that body has this name",
        &help,
    );
}
