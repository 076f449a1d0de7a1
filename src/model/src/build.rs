//! Building models in a program.
//!
//! Robotran numbers points and sensors in the order of the bodies they are on,
//! which a program that adds a point to an early body late would break. The
//! builder therefore collects, and [`ModelBuilder::finish`] numbers.
//!
//! ```
//! use robovec_model::build::{BASE, ModelBuilder};
//! use robovec_model::{Axis, JointKind};
//!
//! let mut builder = ModelBuilder::new("pendulum");
//! let hinge = [JointKind::Revolute(Axis::X)];
//! let upper = builder.body("Upper", BASE.origin(), &hinge);
//! builder.mass(upper, 2.0, [0.0, 0.0, -0.5], [0.2, 0.2, 0.0, 0.0, 0.0, 0.0]);
//! let end = builder.point(upper, "End", [0.0, 0.0, -1.0]);
//! let lower = builder.body("Lower", end, &hinge);
//! builder.mass(lower, 1.0, [0.0, 0.0, -0.5], [0.1, 0.1, 0.0, 0.0, 0.0, 0.0]);
//! let model = builder.finish();
//! assert_eq!(model.joints.len(), 2);
//! ```

use super::{
    Anchor, Asks, Body, Cut, CutKind, Joint, JointKind, JointMounting, Link, Model, ModelPoint,
    Nature, Sensor,
};

/// A body of a [`ModelBuilder`], or the base.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct BodyRef(Option<usize>);

/// The base.
pub const BASE: BodyRef = BodyRef(None);

/// A place on a body of a [`ModelBuilder`]: a point, or the origin of its frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct BodyPlace {
    body: Option<usize>,
    /// The point in order of making.
    point: Option<usize>,
}

impl BodyRef {
    /// The origin of the body's frame.
    pub fn origin(self) -> BodyPlace {
        BodyPlace {
            body: self.0,
            point: None,
        }
    }
}

/// A model in the making.
#[derive(Clone, Debug)]
pub struct ModelBuilder {
    model: Model,
}

impl ModelBuilder {
    /// A model of nothing, with gravity against the third axis of the base.
    pub fn new(name: &str) -> ModelBuilder {
        ModelBuilder {
            model: Model::new(name),
        }
    }

    /// Adds a body attached to a place by joints in series, the parent's first.
    /// They are independent, start at zero and are called after their kind and
    /// the body, `R1_Arm`, with a number where a body has two of a kind.
    ///
    /// # Panics
    ///
    /// Panics when there is no joint.
    pub fn body(&mut self, name: &str, on: BodyPlace, joints: &[JointKind]) -> BodyRef {
        assert!(!joints.is_empty(), "a body hangs on at least one joint");
        let index = self.model.bodies.len();
        let start = self.model.joints.len();
        for (number, &kind) in joints.iter().enumerate() {
            let before = joints[..number].iter().filter(|&&other| other == kind);
            let suffix = match before.count() {
                0 => String::new(),
                count => format!("_{}", count + 1),
            };
            self.model.joints.push(Joint {
                name: format!("{}_{name}{suffix}", kind.name()),
                kind,
                nature: Nature::Independent,
                body: index,
                parent: None,
                point: None,
                has_velocity: true,
                has_acceleration: true,
                actuated: false,
                initial: [0.0; 3],
                mounting: JointMounting::default(),
                limits: None,
                law: Default::default(),
                armature: 0.0,
            });
        }
        self.model.bodies.push(Body {
            name: name.to_owned(),
            parent: on.body,
            point: on.point,
            joints: start..self.model.joints.len(),
            mass: 0.0,
            center: [0.0; 3],
            inertia: [0.0; 6],
        });
        BodyRef(Some(index))
    }

    /// Gives a body its mass (kg), centre of mass (m) and inertia about it
    /// (kg m^2), in the order of [`Body::inertia`].
    ///
    /// # Panics
    ///
    /// Panics when the body is the base.
    pub fn mass(&mut self, body: BodyRef, mass: f64, center: [f64; 3], inertia: [f64; 6]) {
        let index = body.0.expect("the base has no mass");
        let body = &mut self.model.bodies[index];
        (body.mass, body.center, body.inertia) = (mass, center, inertia);
    }

    /// Adds a point to a body or to the base.
    pub fn point(&mut self, body: BodyRef, name: &str, coordinates: [f64; 3]) -> BodyPlace {
        self.model.points.push(ModelPoint {
            name: name.to_owned(),
            body: body.0,
            coordinates,
        });
        BodyPlace {
            body: body.0,
            point: Some(self.model.points.len() - 1),
        }
    }

    /// A joint of a body, from 0, to change its nature, initial values or name.
    ///
    /// # Panics
    ///
    /// Panics when the body has no such joint.
    pub fn joint(&mut self, body: BodyRef, number: usize) -> &mut Joint {
        let index = body.0.expect("the base has no joint");
        let joint = self.model.bodies[index].joints.start + number;
        assert_eq!(self.model.joints[joint].body, index, "no such joint");
        &mut self.model.joints[joint]
    }

    /// Sets the gravity, m/s^2.
    pub fn gravity(&mut self, gravity: [f64; 3]) {
        self.model.gravity = gravity;
    }

    /// Adds a sensor at a point.
    ///
    /// # Panics
    ///
    /// Panics when the place is an origin: sensors sit on points.
    pub fn sensor(&mut self, name: &str, at: BodyPlace, asks: Asks) {
        let sensor = sensor(name, at, asks);
        self.model.sensors.push(sensor);
    }

    /// Adds an external force at a point; its law gets the requested arguments.
    ///
    /// # Panics
    ///
    /// As [`ModelBuilder::sensor`].
    pub fn force(&mut self, name: &str, at: BodyPlace, asks: Asks) {
        let force = sensor(name, at, asks);
        self.model.forces.push(force);
    }

    /// Cuts a loop.
    pub fn cut(&mut self, name: &str, kind: CutKind, ends: [BodyPlace; 2]) {
        self.model.cuts.push(Cut {
            name: name.to_owned(),
            kind,
            ends: ends.map(anchor),
            ignore: [false; 3],
            rotation: None,
        });
    }

    /// Adds a force between two places, along their line.
    pub fn link(&mut self, name: &str, ends: [BodyPlace; 2]) {
        self.model.links.push(Link {
            name: name.to_owned(),
            ends: ends.map(anchor),
        });
    }

    /// Adds a force and a torque between two places.
    pub fn link3d(&mut self, name: &str, ends: [BodyPlace; 2]) {
        self.model.links3d.push(Link {
            name: name.to_owned(),
            ends: ends.map(anchor),
        });
    }

    /// The model, with points and sensors numbered.
    ///
    /// # Panics
    ///
    /// Panics when a number that was given is not finite.
    pub fn finish(self) -> Model {
        let mut model = self.model;
        model.number_points();
        model.connect();
        assert!(model.check(), "a number of the model is not finite");
        model
    }
}

fn sensor(name: &str, at: BodyPlace, asks: Asks) -> Sensor {
    Sensor {
        name: name.to_owned(),
        point: at.point.expect("sensors and forces are at points"),
        asks,
    }
}

fn anchor(place: BodyPlace) -> Anchor {
    Anchor {
        body: place.body,
        point: place.point,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Axis;

    #[test]
    fn points_and_sensors_are_numbered_in_the_order_of_bodies() {
        let mut builder = ModelBuilder::new("late");
        let hinge = [JointKind::Revolute(Axis::X), JointKind::Revolute(Axis::X)];
        let first = builder.body("First", BASE.origin(), &hinge[..1]);
        let tip = builder.point(first, "tip", [0.0, 0.0, 1.0]);
        let second = builder.body("Second", tip, &hinge);
        let end = builder.point(second, "end", [0.0, 0.0, 2.0]);
        let late = builder.point(first, "late", [0.0, 1.0, 0.0]);
        let ground = builder.point(BASE, "ground", [3.0, 0.0, 0.0]);
        builder.sensor("at end", end, Asks::default());
        builder.sensor("at late", late, Asks::default());
        builder.cut("loop", CutKind::Ball, [end, ground]);
        builder.joint(second, 1).nature = Nature::Dependent;
        let model = builder.finish();
        let names: Vec<&str> = model.points.iter().map(|point| &*point.name).collect();
        assert_eq!(names, ["ground", "tip", "late", "end"]);
        assert_eq!(model.bodies[1].point, Some(1));
        assert_eq!(model.cuts[0].ends.map(|end| end.point), [Some(3), Some(0)]);
        assert_eq!(model.sensors[0].name, "at late");
        assert_eq!(model.joints[2].name, "R1_Second_2");
        assert_eq!(model.joints[2].nature, Nature::Dependent);
        assert_eq!(model.joints[1].parent, Some(0));
        assert_eq!(model.joints[1].point, Some(1));
        assert_eq!(model.joints[2].point, None);
    }
}
