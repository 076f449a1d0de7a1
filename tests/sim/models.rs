//! Small models for simulations.

use robovec::model::{
    Anchor, Asks, Body, Cut, CutKind, Joint, JointKind, JointMounting, Link, Model, ModelPoint,
    Nature, Sensor,
};
use robovec::motion::{
    EVENT_TOLERANCE, EquationSetting, IntegrationMethod, Laws, MultibodySystem, SimulationPlan,
    SimulationRun, simulate,
};

/// A builder of models body by body.
pub(crate) struct Builder {
    pub(crate) model: Model,
}

/// A body's mass, centre of mass, diagonal of the inertia, and points.
pub(crate) struct Solid<'a> {
    pub(crate) mass: f64,
    pub(crate) center: [f64; 3],
    pub(crate) inertia: [f64; 3],
    pub(crate) points: &'a [[f64; 3]],
}

impl Builder {
    /// A base with points.
    pub(crate) fn new(points: &[[f64; 3]]) -> Builder {
        let mut builder = Builder {
            model: Model::new("test"),
        };
        builder.points(None, points);
        builder
    }

    fn points(&mut self, body: Option<usize>, points: &[[f64; 3]]) {
        for (number, &coordinates) in points.iter().enumerate() {
            self.model.points.push(ModelPoint {
                name: format!("p{number}"),
                body,
                coordinates,
            });
        }
    }

    /// The place of a point, by its number on the body.
    pub(crate) fn anchor(&self, body: Option<usize>, number: usize) -> Anchor {
        let mut points = self.model.points.iter().enumerate();
        let point =
            points.find(|(_, point)| point.body == body && point.name == format!("p{number}"));
        Anchor {
            body,
            point: point.map(|(index, _)| index),
        }
    }

    /// A body on a point of another, beyond joints of kinds and natures that
    /// start at the given positions.
    pub(crate) fn body(
        &mut self,
        on: Anchor,
        joints: &[(&str, Nature, f64)],
        solid: &Solid<'_>,
    ) -> usize {
        let body = self.model.bodies.len();
        let start = self.model.joints.len();
        for (place, &(kind, nature, initial)) in joints.iter().enumerate() {
            self.model.joints.push(Joint {
                name: format!("{kind}_{}", start + place + 1),
                kind: JointKind::from_name(kind).expect("a kind"),
                nature,
                body,
                parent: match place {
                    0 => self.model.last_joint(on.body),
                    _ => Some(start + place - 1),
                },
                point: if place == 0 { on.point } else { None },
                has_velocity: true,
                has_acceleration: true,
                actuated: false,
                initial: [initial, 0.0, 0.0],
                mounting: JointMounting::default(),
                limits: None,
                law: Default::default(),
                armature: 0.0,
            });
        }
        let [xx, yy, zz] = solid.inertia;
        self.model.bodies.push(Body {
            name: format!("body{}", body + 1),
            parent: on.body,
            point: on.point,
            joints: start..self.model.joints.len(),
            mass: solid.mass,
            center: solid.center,
            inertia: [xx, 0.0, 0.0, yy, 0.0, zz],
        });
        self.points(Some(body), solid.points);
        assert!(self.model.check());
        body
    }

    /// A cut between two places.
    pub(crate) fn cut(&mut self, kind: CutKind, ends: [Anchor; 2]) {
        self.model.cuts.push(Cut {
            name: format!("cut{}", self.model.cuts.len() + 1),
            kind,
            ends,
            ignore: [false; 3],
            rotation: None,
        });
    }
    /// A link between two places.
    pub(crate) fn link(&mut self, ends: [Anchor; 2]) {
        self.model.links.push(Link {
            name: format!("link{}", self.model.links.len() + 1),
            ends,
        });
    }
}

/// A pendulum beyond a slide, with a link to the base and a force on its tip,
/// and laws for them.
pub(crate) fn spring_mechanism() -> (Model, &'static str) {
    let mut builder = Builder::new(&[[0.0; 3], [0.7, -0.6, -0.9]]);
    let base = builder.anchor(None, 0);
    let solid = Solid {
        mass: 2.0,
        center: [0.2, 0.1, -0.4],
        inertia: [0.2, 0.3, 0.25],
        points: &[[0.1, 0.2, -0.7]],
    };
    let joints = [
        ("T1", Independent, 0.2),
        ("R2", Independent, 0.3),
        ("R1", Independent, -0.2),
    ];
    let body = builder.body(base, &joints, &solid);
    let ends = [builder.anchor(Some(body), 0), builder.anchor(None, 1)];
    builder.link(ends);
    let mut model = builder.model;
    let point = ends[0].point.expect("the point is there");
    model.forces.push(Sensor {
        name: "push".to_owned(),
        point,
        asks: Asks::default(),
    });
    assert!(model.check());
    let laws = "[[link]]\nname = 'link1'\nstiffness = 40.0\ndamping = 1.0\nneutral = 0.5\n\
                force = 2.0\n\
                [[force]]\nname = 'push'\nforce = [1.0, -2.0, 3.0]\ntorque = [0.3, 0.2, -0.1]\n\
                stiffness = [5.0, 0.0, 9.0]\ndamping = [0.0, 0.4, 0.2]\n";
    (model, laws)
}

/// A rod along x with a point at its end.
fn rod(length: f64, points: &[[f64; 3]]) -> Solid<'_> {
    let inertia = length * length / 12.0;
    Solid {
        mass: 1.0,
        center: [length / 2.0, 0.0, 0.0],
        inertia: [1e-3, inertia, inertia],
        points,
    }
}

use Nature::{Dependent, Independent};

/// Two rods that swing in a plane.
pub(crate) fn double_pendulum() -> Model {
    let mut builder = Builder::new(&[]);
    let base = builder.anchor(None, 0);
    let end = [[1.0, 0.0, 0.0]];
    let first = builder.body(base, &[("R2", Independent, 0.3)], &rod(1.0, &end));
    let on = builder.anchor(Some(first), 0);
    builder.body(on, &[("R2", Independent, 0.8)], &rod(1.0, &end));
    builder.model
}

/// A chain of bodies in space, with all six kinds of joints.
pub(crate) fn spatial_chain() -> Model {
    let mut builder = Builder::new(&[[0.1, -0.2, 0.3]]);
    let mut on = builder.anchor(None, 0);
    let solid = Solid {
        mass: 1.5,
        center: [0.1, 0.2, -0.3],
        inertia: [0.4, 0.5, 0.6],
        points: &[[0.3, -0.2, -0.4]],
    };
    let free = |kind, initial| (kind, Independent, initial);
    for joints in [
        &[free("R1", 0.4), free("R2", -0.3)][..],
        &[free("R3", 0.7)],
        &[free("T1", 0.1), free("T2", 0.2), free("T3", -0.1)],
        &[free("R2", 0.5)],
    ] {
        let body = builder.body(on, joints, &solid);
        on = builder.anchor(Some(body), 0);
    }
    // Sliding bodies fall without end; a little is enough.
    for joint in &mut builder.model.joints {
        joint.initial[1] = 0.5;
    }
    builder.model
}

/// Crank, coupler and rocker in a plane, the loop cut by a ball; the initial
/// positions of coupler and rocker are only near those that close it.
pub(crate) fn four_bar() -> Model {
    let mut builder = Builder::new(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    let (left, right) = (builder.anchor(None, 0), builder.anchor(None, 1));
    let crank = builder.body(
        left,
        &[("R2", Independent, -1.0)],
        &rod(0.4, &[[0.4, 0.0, 0.0]]),
    );
    let on = builder.anchor(Some(crank), 0);
    let coupler = builder.body(on, &[("R2", Dependent, 0.4)], &rod(1.0, &[[1.0, 0.0, 0.0]]));
    let rocker = builder.body(
        right,
        &[("R2", Dependent, -1.2)],
        &rod(0.8, &[[0.8, 0.0, 0.0]]),
    );
    let ends = [
        builder.anchor(Some(coupler), 0),
        builder.anchor(Some(rocker), 0),
    ];
    builder.cut(CutKind::Ball, ends);
    builder.model
}

/// A run of a model in its default equations.
pub(crate) fn run(model: &Model, duration: f64, method: IntegrationMethod) -> SimulationRun {
    run_with(
        model,
        Laws::of_model(model),
        &EquationSetting::default(),
        duration,
        method,
    )
}

/// A run with laws and a setting.
pub(crate) fn run_with(
    model: &Model,
    laws: Laws,
    setting: &EquationSetting<'_>,
    duration: f64,
    method: IntegrationMethod,
) -> SimulationRun {
    let plan = SimulationPlan {
        duration,
        samples: 20,
        method,
        step_limit: 1_000_000,
        event_tolerance: EVENT_TOLERANCE,
    };
    let (mut system, initial) = MultibodySystem::new(model, laws, setting).expect("a system");
    simulate(&mut system, &initial, &plan, &mut |_| {}).expect("a run")
}

/// Runge-Kutta with a step.
pub(crate) fn runge_kutta(step: f64) -> IntegrationMethod {
    IntegrationMethod::RungeKutta { step }
}
