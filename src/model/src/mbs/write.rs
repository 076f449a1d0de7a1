//! The canonical text of a model.

use super::scope::{BASE, ORIGIN};
use crate::{Anchor, Asks, Body, CutKind, Joint, Link, Model, Nature, Sensor};

/// A model as compact `.mbs` text: no drawings, and nothing that is zero or
/// false. [`read_mbs`](super::read_mbs) reads an equal model back, provided
/// that names are not empty and hold neither line breaks nor blanks at their
/// ends, and that the model is one that such files can state ([`unsayable`]).
pub fn write_mbs(model: &Model) -> String {
    let mut writer = ModelWriter {
        text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(),
        depth: 0,
    };
    writer.open("mbsDescR7");
    writer.leaf("mbsname", &model.name);
    writer.open("base");
    let gravity = coordinates(model.gravity);
    writer.line(&format!("<gravity>{gravity}</gravity>"));
    writer.points(model, None);
    writer.close("base");
    writer.open("bodytree");
    for (index, body) in model.bodies.iter().enumerate() {
        writer.body(model, index, body);
    }
    writer.close("bodytree");
    writer.cuts(model);
    if !(model.links.is_empty() && model.links3d.is_empty()) {
        writer.open("links");
        writer.links(model, "link", &model.links);
        writer.links(model, "link3D", &model.links3d);
        writer.close("links");
    }
    writer.user_models(model);
    writer.close("mbsDescR7");
    writer.text
}

/// First property of a model that `.mbs` files cannot express, with the nearest
/// that they can; `None` for a model that they can express.
pub fn unsayable(model: &Model) -> Option<String> {
    let joint = |name: &str, what: &str| Some(format!("joint '{name}' {what}"));
    if model.bodies.is_empty() {
        return Some("nothing moves, and such a file has a body".to_owned());
    }
    if model.bodies.iter().any(|body| body.name == BASE) {
        return Some(format!(
            "a body is called '{BASE}', which is the name of what does not move"
        ));
    }
    for one in &model.joints {
        if !one.mounting.turns.is_empty() {
            return joint(
                &one.name,
                "is turned in the frame before it, and joints of a `.mbs` file move along the \
                 axes of that frame",
            );
        }
        if one.mounting.reversed {
            return joint(
                &one.name,
                "moves against its axis, and `.mbs` joints move along theirs",
            );
        }
    }
    model.cuts.iter().find_map(|cut| match cut.kind {
        CutKind::Coupling(coupling) => joint(
            &model.joints[coupling.joint].name,
            "follows another joint, which is a user constraint in Robotran and not part of the file",
        ),
        CutKind::Solid if cut.rotation.is_some() => Some(format!(
            "the frames of cut '{}' are turned against each other, and those of a `.mbs` file \
             coincide",
            cut.name
        )),
        CutKind::Ball | CutKind::Rod(_) | CutKind::Solid => None,
    })
}

struct ModelWriter {
    text: String,
    depth: usize,
}

fn escaped(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => result.push_str("&amp;"),
            '<' => result.push_str("&lt;"),
            '>' => result.push_str("&gt;"),
            '"' => result.push_str("&quot;"),
            // A line break as such would be read as a blank of the layout.
            control if control.is_control() => {
                result.push_str(&format!("&#{};", u32::from(control)));
            }
            other => result.push(other),
        }
    }
    result
}

fn coordinates([x, y, z]: [f64; 3]) -> String {
    format!("<coordinates><x>{x:?}</x><y>{y:?}</y><z>{z:?}</z></coordinates>")
}

/// The numbers that are not zero; empty when all are zero.
fn numbers(element: &str, names: &[&str], values: &[f64]) -> String {
    assert_eq!(names.len(), values.len(), "every number has a name");
    let given = names.iter().zip(values).filter(|(_, value)| **value != 0.0);
    let inner: String = given
        .map(|(name, value)| format!("<{name}>{value:?}</{name}>"))
        .collect();
    if inner.is_empty() {
        return inner;
    }
    format!("<{element}>{inner}</{element}>")
}

/// The sensors, or external forces, at a point.
fn sensors(element: &str, sensors: &[Sensor], point: usize) -> String {
    let mut text = String::new();
    debug_assert!(
        sensors.is_sorted_by_key(|sensor| sensor.point),
        "sensors are in the order of their points"
    );
    let start = sensors.partition_point(|sensor| sensor.point < point);
    for sensor in sensors[start..].iter().take_while(|s| s.point == point) {
        let mut asks = sensor.asks;
        text += &format!("<{element} name=\"{}\"", escaped(&sensor.name));
        for name in Asks::NAMES {
            if asks.field(name).is_some_and(|asked| *asked) {
                text += &format!(" {name}=\"true\"");
            }
        }
        text += "/>";
    }
    text
}

impl ModelWriter {
    fn line(&mut self, line: &str) {
        self.text.extend(std::iter::repeat_n("  ", self.depth));
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn open(&mut self, name: &str) {
        self.line(&format!("<{name}>"));
        self.depth += 1;
    }

    fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.line(&format!("</{name}>"));
    }

    fn leaf(&mut self, name: &str, content: &str) {
        self.line(&format!("<{name}>{}</{name}>", escaped(content)));
    }

    fn anchor(&mut self, model: &Model, element: &str, anchor: Anchor) {
        let body = model.body_name(anchor.body);
        let point = anchor
            .point
            .map_or(ORIGIN, |point| &model.points[point].name);
        self.line(&format!(
            "<{element}><bodyname>{}</bodyname><pointname>{}</pointname></{element}>",
            escaped(body),
            escaped(point)
        ));
    }

    fn body(&mut self, model: &Model, index: usize, body: &Body) {
        self.open("body");
        self.leaf("bodyname", &body.name);
        let parent = Anchor {
            body: body.parent,
            point: body.point,
        };
        self.anchor(model, "parent", parent);
        for joint in &model.joints[body.joints.clone()] {
            self.joint(joint);
        }
        if body.mass != 0.0 || body.center != [0.0; 3] || body.inertia != [0.0; 6] {
            self.leaf("mass", &format!("{:?}", body.mass));
        }
        if body.center != [0.0; 3] {
            self.line(&format!("<com>{}</com>", coordinates(body.center)));
        }
        let names = ["Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];
        if body.inertia != [0.0; 6] {
            self.line(&numbers("inertia", &names, &body.inertia));
        }
        self.points(model, Some(index));
        self.close("body");
    }

    fn joint(&mut self, joint: &Joint) {
        let mut line = format!(
            "<joint><jointname>{}</jointname><type>{}</type><nature>{}</nature>",
            escaped(&joint.name),
            joint.kind.name(),
            joint.nature.name()
        );
        if joint.nature == Nature::Driven {
            let velocity = if joint.has_velocity { "<qd/>" } else { "" };
            let acceleration = if joint.has_acceleration { "<qdd/>" } else { "" };
            line += &format!("<symbols><q/>{velocity}{acceleration}</symbols>");
        }
        line += &numbers("initialvalue", &["q", "qd", "qdd"], &joint.initial);
        if joint.actuated {
            line += "<actuated/>";
        }
        self.line(&(line + "</joint>"));
    }

    fn points(&mut self, model: &Model, body: Option<usize>) {
        // They are in the order of their bodies.
        let start = model.points.partition_point(|point| point.body < body);
        let points = model.points.iter().enumerate().skip(start);
        for (index, point) in points.take_while(|(_, point)| point.body == body) {
            let measured = sensors("sensor", &model.sensors, index);
            let forces = sensors("extforce", &model.forces, index);
            self.line(&format!(
                "<point><pointname>{}</pointname>{}{measured}{forces}</point>",
                escaped(&point.name),
                coordinates(point.coordinates)
            ));
        }
    }

    fn cuts(&mut self, model: &Model) {
        if model.cuts.is_empty() {
            return;
        }
        self.open("cuts");
        for cut in &model.cuts {
            let kind = match cut.kind {
                CutKind::Coupling(_) => continue,
                CutKind::Ball => "ball",
                CutKind::Rod(_) => "rod",
                CutKind::Solid => "solid",
            };
            self.open(kind);
            self.leaf("name", &cut.name);
            self.anchor(model, "endpoint1", cut.ends[0]);
            self.anchor(model, "endpoint2", cut.ends[1]);
            if let CutKind::Rod(length) = cut.kind {
                self.leaf("length", &format!("{length:?}"));
            }
            if cut.ignore != [false; 3] {
                let axes = ["<x/>", "<y/>", "<z/>"].into_iter().zip(cut.ignore);
                let axes: String = axes.filter(|(_, set)| *set).map(|(axis, _)| axis).collect();
                self.line(&format!("<ignore>{axes}</ignore>"));
            }
            self.close(kind);
        }
        self.close("cuts");
    }

    fn links(&mut self, model: &Model, element: &str, links: &[Link]) {
        for link in links {
            self.open(element);
            self.leaf("name", &link.name);
            self.anchor(model, "endpoint1", link.ends[0]);
            self.anchor(model, "endpoint2", link.ends[1]);
            self.close(element);
        }
    }

    fn user_models(&mut self, model: &Model) {
        if model.user_models.is_empty() {
            return;
        }
        self.open("user_models");
        for user_model in &model.user_models {
            self.open("user_model");
            self.leaf("name", &user_model.name);
            for (name, kind, values) in &user_model.parameters {
                self.open("parameter");
                self.leaf("name", name);
                self.leaf("type", kind);
                for value in values {
                    self.leaf("value", &format!("{value:?}"));
                }
                self.close("parameter");
            }
            self.close("user_model");
        }
        self.close("user_models");
    }
}
