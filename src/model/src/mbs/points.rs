//! Points, and the sensors and external forces on them.

use super::fields::{ElementFields, Messages, coordinates, place};
use super::scope::ModelScope;
use crate::{Asks, Model, ModelPoint, Sensor};
use robovec_ir::diagnostic::{clip, did_you_mean};
use roxmltree::Node;

/// Reads a point of a body, or of the base, with its attachments.
pub(super) fn read_point(
    node: Node<'_, '_>,
    body: Option<usize>,
    owner: &str,
    scope: &mut ModelScope,
    model: &mut Model,
    messages: &mut Messages,
) {
    let one = ["pointname", "coordinates"];
    let fields = ElementFields::of(node, &one, &["sensor", "extforce"], messages);
    let name = fields.name("pointname", &format!("a point of {owner}"), messages);
    let title = format!("point '{}' of {owner}", clip(&name));
    let coordinates = coordinates(&fields, &title, messages);
    let index = model.points.len();
    if !name.is_empty() && scope.points.insert((body, name.clone()), index).is_some() {
        messages.error(
            fields.place_of("pointname"),
            &format!("{owner} has two points '{}'", clip(&name)),
            "the second one",
            "give one of them another name",
        );
    }
    model.points.push(ModelPoint {
        name,
        body,
        coordinates,
    });
    for sensor in fields.all() {
        let list = match sensor.tag_name().name() {
            "sensor" => &mut model.sensors,
            "extforce" => &mut model.forces,
            _ => continue,
        };
        list.push(read_sensor(sensor, index, &title, messages));
    }
}

fn read_sensor(node: Node<'_, '_>, point: usize, owner: &str, messages: &mut Messages) -> Sensor {
    let kind = node.tag_name().name();
    let mut sensor = Sensor {
        name: String::new(),
        point,
        asks: Asks::default(),
    };
    for attribute in node.attributes() {
        let value = attribute.value().trim();
        if attribute.name() == "name" {
            value.clone_into(&mut sensor.name);
            continue;
        }
        let Some(asked) = sensor.asks.field(attribute.name()) else {
            let known = Asks::NAMES.iter().copied().chain(["name"]);
            let help = match did_you_mean(attribute.name(), known.clone()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("it may have: {}", known.collect::<Vec<_>>().join(", ")),
            };
            messages.warn(
                attribute.range(),
                &format!(
                    "the {kind} at {owner} has the unknown attribute `{}`",
                    clip(attribute.name())
                ),
                "passed over",
                &help,
            );
            continue;
        };
        match value {
            "true" => *asked = true,
            "false" => *asked = false,
            _ => messages.error(
                attribute.range_value(),
                &format!(
                    "the attribute `{}` of the {kind} at {owner} is '{}'",
                    attribute.name(),
                    clip(value)
                ),
                "neither true nor false",
                "write true or false",
            ),
        }
    }
    if sensor.name.is_empty() || sensor.name.chars().any(char::is_control) {
        messages.error(
            place(node),
            &format!("the {kind} at {owner} has no name"),
            "this element",
            "add the attribute name=\"…\"",
        );
    }
    sensor
}
