//! Random models and states, the same for the same seed.

use super::State;
use robovec::model::{
    Anchor, Asks, Axis, Body, ConstantTurn, Cut, CutKind, Joint, JointCoupling, JointKind,
    JointMounting, Link, Model, ModelPoint, Nature, Sensor,
};
use robovec_num::random::Random;

/// Random draws for models.
pub(crate) trait ModelDraw {
    /// Uniform in a range.
    fn between(&mut self, low: f64, high: f64) -> f64;
    /// True with a probability.
    fn chance(&mut self, probability: f64) -> bool;
    /// Three numbers in -1 to 1, some of them zero.
    fn vector(&mut self, zeros: f64) -> [f64; 3];
}

/// Ingredients of a random model.
#[derive(Clone, Copy)]
pub(crate) struct Recipe {
    /// Number of bodies.
    pub(crate) bodies: usize,
    /// Number of times a parameter is a structural zero, 0 to 1.
    pub(crate) zeros: f64,
    /// True when some inner bodies have no mass; the mass matrix may then be
    /// singular.
    pub(crate) massless: bool,
    /// True when some joints are driven, with and without symbols for
    /// velocity and acceleration.
    pub(crate) driven: bool,
    /// True when some joints have general positions, move against their axis
    /// or turn rotors.
    pub(crate) placed: bool,
    /// Number of cuts of each kind.
    pub(crate) cuts: usize,
    /// Number of sensors, external forces and links each.
    pub(crate) devices: usize,
}

impl ModelDraw for Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn chance(&mut self, probability: f64) -> bool {
        self.signed() < 2.0 * probability - 1.0
    }

    fn vector(&mut self, zeros: f64) -> [f64; 3] {
        [(); 3].map(|()| {
            let number = self.signed();
            if self.chance(zeros) { 0.0 } else { number }
        })
    }
}

/// Points on the base and on each body.
const POINTS: usize = 2;

/// A random model.
pub(crate) fn model(random: &mut Random, recipe: &Recipe) -> Model {
    let mut model = Model::new("random");
    model.gravity = random.vector(recipe.zeros);
    model.gravity[2] -= 9.81;
    let owners = std::iter::once(None).chain((0..recipe.bodies).map(Some));
    for body in owners {
        for number in 0..POINTS {
            model.points.push(ModelPoint {
                name: format!("p{number}"),
                body,
                coordinates: random.vector(recipe.zeros),
            });
        }
    }
    for index in 0..recipe.bodies {
        add_body(random, recipe, &mut model, index);
    }
    for index in 0..recipe.bodies {
        let leaf = model.bodies.iter().all(|body| body.parent != Some(index));
        if recipe.massless && !leaf && random.chance(0.3) {
            model.bodies[index].mass = 0.0;
            model.bodies[index].inertia = [0.0; 6];
        }
    }
    add_devices(random, recipe, &mut model);
    model.sensors.sort_by_key(|sensor| sensor.point);
    model.forces.sort_by_key(|force| force.point);
    assert!(model.check(), "random models are well formed");
    model
}

fn add_body(random: &mut Random, recipe: &Recipe, model: &mut Model, index: usize) {
    // Half of the bodies continue the chain, so that depth grows too.
    let parent = match random.below(index + 1) {
        _ if index > 0 && random.chance(0.5) => Some(index - 1),
        0 => None,
        before => Some(before - 1),
    };
    let point = random
        .chance(0.8)
        .then(|| parent.map_or(0, |parent| POINTS * (parent + 1)) + random.below(POINTS));
    let start = model.joints.len();
    // Kinds are distinct within a body: two parallel slides in a row would
    // make the mass matrix singular.
    let mut kinds = JointKind::ALL.to_vec();
    for place in 0..[1, 1, 1, 2, 3][random.below(5)] {
        let driven = recipe.driven && random.chance(0.3);
        let has_velocity = !driven || random.chance(0.5);
        model.joints.push(Joint {
            name: format!("j{}", start + place + 1),
            kind: kinds.remove(random.below(kinds.len())),
            nature: if driven {
                Nature::Driven
            } else {
                Nature::Independent
            },
            body: index,
            parent: match place {
                0 => model.last_joint(parent),
                _ => Some(start + place - 1),
            },
            point: if place == 0 { point } else { None },
            has_velocity,
            has_acceleration: has_velocity,
            actuated: false,
            initial: [0.0; 3],
            mounting: if recipe.placed {
                mounting(random, place == 0)
            } else {
                JointMounting::default()
            },
            limits: None,
            law: Default::default(),
            armature: rotor(random.clone(), recipe),
        });
    }
    let mut product = || {
        let number = 0.2 * random.signed();
        if random.chance(recipe.zeros) {
            0.0
        } else {
            number
        }
    };
    let [xy, xz, yz] = [product(), product(), product()];
    let [xx, yy, zz] = [(); 3].map(|()| random.between(0.5, 2.0));
    model.bodies.push(Body {
        name: format!("b{}", index + 1),
        parent,
        point,
        joints: start..model.joints.len(),
        mass: random.between(0.5, 5.0),
        center: random.vector(recipe.zeros),
        inertia: [xx, xy, xz, yy, yz, zz],
    });
}

/// The rotor of a joint, from a copy of the draws: what follows stays the same.
fn rotor(mut random: Random, recipe: &Recipe) -> f64 {
    match recipe.placed && random.chance(0.3) {
        true => random.between(0.1, 2.0),
        false => 0.0,
    }
}

/// Mounting of a joint. Quarters of a turn only where no joint of the same body
/// comes before: they would make axes parallel, and the mass matrix singular.
fn mounting(random: &mut Random, first: bool) -> JointMounting {
    const QUARTER: f64 = std::f64::consts::FRAC_PI_2;
    let turns = (0..random.below(4)).map(|_| ConstantTurn {
        axis: Axis::ALL[random.below(3)],
        angle: if first && random.chance(0.5) {
            QUARTER * [-2.0, -1.0, 1.0, 2.0][random.below(4)]
        } else {
            3.1 * random.signed()
        },
    });
    JointMounting {
        turns: turns.collect(),
        reversed: random.chance(0.4),
    }
}

/// Binds two joints that are not driven, so that a state keeps the rule.
pub(crate) fn add_coupling(random: &mut Random, model: &mut Model, q: &[f64]) {
    let free = |&joint: &usize| model.joints[joint].nature != Nature::Driven;
    let free: Vec<usize> = (0..model.joints.len()).filter(free).collect();
    if free.len() < 2 {
        return;
    }
    let joint = random.below(free.len());
    let leader = (joint + 1 + random.below(free.len() - 1)) % free.len();
    let (joint, leader) = (free[joint], free[leader]);
    let factor = random.signed();
    model.cuts.push(Cut {
        name: format!("coupling{}", model.cuts.len() + 1),
        kind: CutKind::Coupling(JointCoupling {
            joint,
            leader,
            factor,
            offset: q[joint] - factor * q[leader],
        }),
        ends: [joint, leader].map(|joint| Anchor {
            body: Some(model.joints[joint].body),
            point: None,
        }),
        ignore: [false; 3],
        rotation: None,
    });
}

/// A random place: a point or an origin.
fn place(random: &mut Random, bodies: usize) -> Anchor {
    let number = random.below(bodies + 1);
    let body = number.checked_sub(1);
    Anchor {
        body,
        point: random
            .chance(0.8)
            .then(|| POINTS * number + random.below(POINTS)),
    }
}

/// Two random places on two bodies.
fn places(random: &mut Random, bodies: usize) -> [Anchor; 2] {
    loop {
        let ends = [place(random, bodies), place(random, bodies)];
        if ends[0].body != ends[1].body {
            return ends;
        }
    }
}

fn add_devices(random: &mut Random, recipe: &Recipe, model: &mut Model) {
    if recipe.placed && recipe.cuts > 0 {
        let origin = vec![0.0; model.joints.len()];
        add_coupling(random, model, &origin);
    }
    for _ in 0..recipe.cuts {
        let length = random.between(0.3, 1.5);
        for kind in [CutKind::Ball, CutKind::Rod(length), CutKind::Solid] {
            model.cuts.push(Cut {
                name: format!("cut{}", model.cuts.len() + 1),
                kind,
                ends: places(random, recipe.bodies),
                ignore: [false; 3],
                rotation: None,
            });
        }
    }
    for number in 1..=recipe.devices {
        let mut device = |name: &str| Sensor {
            name: format!("{name}{number}"),
            // On a body: external forces on the base have no effect.
            point: POINTS + random.below(POINTS * recipe.bodies),
            asks: Asks {
                position: true,
                rotation: true,
                velocity: true,
                angular_velocity: true,
                acceleration: true,
                angular_acceleration: true,
                jacobian: true,
            },
        };
        model.sensors.push(device("sensor"));
        model.forces.push(device("force"));
        // Two different points keep a link from having no length.
        let ends = loop {
            let ends = places(random, recipe.bodies);
            if ends.iter().all(|end| end.point.is_some()) {
                break ends;
            }
        };
        model.links.push(Link {
            name: format!("link{number}"),
            ends,
        });
    }
}

/// A random state of a model, as its equations see it.
pub(crate) fn state(random: &mut Random, model: &Model) -> State<f64> {
    let n = model.joints.len();
    let mut list = |bound: f64| {
        (0..n)
            .map(|_| bound * random.signed())
            .collect::<Vec<f64>>()
    };
    let (q, qd, qdd) = (list(3.1), list(3.0), list(10.0));
    let mut vectors = || {
        (0..n)
            .map(|_| random.vector(0.0).map(|x| 20.0 * x))
            .collect::<Vec<[f64; 3]>>()
    };
    let (frc, trq) = (vectors(), vectors());
    State {
        q,
        qd,
        qdd,
        frc,
        trq,
    }
    .seen_by(model)
}
