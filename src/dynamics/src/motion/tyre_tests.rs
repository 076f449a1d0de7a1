//! Forces of tyres in single states.

use super::*;
use crate::motion::energy::dot;

const PRESSURE: f64 = 3e3;
const SUNK: f64 = 0.015;
const RADIUS: f64 = 0.3;

const BAKKER: SlipLaw = SlipLaw::Bakker {
    longitudinal: MagicFormula {
        stiffness: 12.0,
        shape: 1.65,
        peak: 1.1,
        curvature: 0.3,
    },
    lateral: MagicFormula {
        stiffness: 9.0,
        shape: 1.3,
        peak: 0.9,
        curvature: -1.2,
    },
};

const LINEAR: SlipLaw = SlipLaw::Linear {
    friction: 0.8,
    longitudinal: 8e4,
    lateral: 6e4,
};

fn tyre(law: SlipLaw) -> Tyre {
    Tyre {
        contact: Contact {
            stiffness: PRESSURE / SUNK,
            ..Contact::default()
        },
        radius: RADIUS,
        axis: [0.0, 2.0, 0.0],
        law,
        slip: Some(1e-3),
    }
}

/// An upright wheel that presses the ground, rolls along the first axis at a
/// velocity and has the slips.
fn rolling(velocity: f64, [along, across]: [f64; 2]) -> PointMotion {
    PointMotion {
        place: [0.4, -0.2, RADIUS - SUNK],
        velocity: [velocity, -across * velocity, 0.0],
        spin: [0.0, (1.0 + along) * velocity / RADIUS, 0.0],
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    }
}

/// Force and torque.
fn force(law: SlipLaw, motion: &PointMotion) -> [[f64; 3]; 2] {
    let found = tyre(law).force(&motion.fixed());
    [found.force, found.torque].map(|vector| vector.map(|part| part.value))
}

#[test]
fn small_slips_give_slopes_times_slip() {
    for (law, slopes) in [
        (LINEAR, [8e4, 6e4]),
        (
            BAKKER,
            [12.0 * 1.65 * 1.1 * PRESSURE, 9.0 * 1.3 * 0.9 * PRESSURE],
        ),
    ] {
        for slips in [[1e-5, 0.0], [0.0, 1e-5], [-2e-5, 1e-5], [0.0; 2]] {
            let [force, torque] = force(law, &rolling(20.0, slips));
            for place in 0..2 {
                let expected = slopes[place] * slips[place];
                assert!((force[place] - expected).abs() < 1e-5, "{force:?}");
            }
            assert!((force[2] - PRESSURE).abs() < 1e-9);
            let about = [RADIUS * force[1], -RADIUS * force[0], 0.0];
            for (found, expected) in torque.iter().zip(about) {
                assert!((found - expected).abs() < 1e-9, "{torque:?}");
            }
        }
    }
}

#[test]
fn one_slip_alone_gives_the_magic_formula() {
    let curve = |[b, c, d, e]: [f64; 4], k: f64| {
        d * (c * (b * k - e * (b * k - (b * k).atan())).atan()).sin()
    };
    for slip in [-1.0, -0.3, -0.05, 0.02, 0.08, 0.15, 0.7, 3.0] {
        let along = force(BAKKER, &rolling(30.0, [slip, 0.0]))[0][0];
        let across = force(BAKKER, &rolling(30.0, [0.0, slip]))[0][1];
        let expected = [
            PRESSURE * curve([12.0, 1.65, 1.1, 0.3], slip),
            PRESSURE * curve([9.0, 1.3, 0.9, -1.2], slip),
        ];
        assert!((along - expected[0]).abs() < 1e-4, "{along} {expected:?}");
        assert!((across - expected[1]).abs() < 1e-4, "{across} {expected:?}");
    }
}

/// States of slipping wheels on a grid, from standstill to fast.
fn states() -> impl Iterator<Item = PointMotion> {
    let numbers = [-4.0, -0.6, -0.04, 0.0, 0.01, 0.2, 1.5];
    let velocities = [-30.0, 0.0, 1e-3, 2.0, 50.0];
    velocities.into_iter().flat_map(move |velocity| {
        let pairs = numbers.into_iter().flat_map(move |along| {
            numbers.into_iter().map(move |across| {
                let mut motion = rolling(velocity, [along, across]);
                // At standstill too it slides.
                motion.velocity[0] += along * 1e-3;
                motion.velocity[1] += across;
                motion
            })
        });
        pairs.collect::<Vec<_>>()
    })
}

#[test]
fn forces_stay_in_the_ellipse_and_take_energy() {
    for (law, peaks) in [(LINEAR, [0.8, 0.8]), (BAKKER, [1.1, 0.9])] {
        let mut most = 0.0f64;
        for motion in states() {
            let found = tyre(law).force(&motion.fixed());
            let force = found.force.map(|part| part.value);
            let share = [0, 1].map(|k| force[k] / (peaks[k] * PRESSURE));
            let size = share[0].hypot(share[1]);
            assert!(size <= 1.0 + 1e-12, "{size} {motion:?}");
            assert!(found.power <= 0.0, "{} {motion:?}", found.power);
            most = most.max(size);
        }
        assert!(most > 0.99, "{most}");
    }
}

/// A wheel that does not turn slides, and the force of equal curves is opposite
/// to its velocity.
#[test]
fn a_locked_wheel_is_slowed_against_its_velocity() {
    let curve = MagicFormula {
        stiffness: 10.0,
        shape: 1.5,
        peak: 0.9,
        curvature: 0.2,
    };
    let law = SlipLaw::Bakker {
        longitudinal: curve,
        lateral: curve,
    };
    let mut motion = rolling(10.0, [-1.0, 0.4]);
    motion.spin = [0.0; 3];
    for law in [law, LINEAR] {
        let force = force(law, &motion)[0];
        let slopes = match law {
            SlipLaw::Linear { .. } => [8e4, 6e4],
            SlipLaw::Bakker { .. } => [1.0, 1.0],
        };
        let turned =
            force[0] * motion.velocity[1] / slopes[0] - force[1] * motion.velocity[0] / slopes[1];
        assert!(turned.abs() < 1e-9, "{force:?}");
        assert!(force[0] < 0.0 && force[1] > 0.0, "{force:?}");
    }
}

/// A wheel in general position, on a plane that is not level.
fn general() -> (PointMotion, PointMotion) {
    let (sine, cosine) = 0.3f64.sin_cos();
    let motion = PointMotion {
        place: [0.4, -0.2, 0.2],
        velocity: [12.0, -0.4, 0.3],
        spin: [0.2, 38.0, -0.5],
        axes: [
            [cosine, 0.0, -sine],
            [0.36 * sine, 0.8, 0.48 * cosine],
            [0.8 * sine, -0.6, 0.8 * cosine],
        ],
    };
    let slope = PointMotion {
        place: [0.3, -0.7, 0.2],
        velocity: [-0.4, 0.5, 0.9],
        spin: [0.8, -0.6, 0.1],
        axes: [[0.1, -0.3, 0.2], [0.4, 0.2, -0.1], [-0.2, 0.3, 0.5]],
    };
    (motion, slope)
}

#[test]
fn slopes_are_those_of_differences() {
    let (motion, slope) = general();
    for law in [LINEAR, BAKKER] {
        let mut tyre = tyre(law);
        tyre.contact.normal = [0.1, -0.2, 2.0];
        tyre.contact.damping = 300.0;
        let found = tyre.force(&motion.along(&slope));
        assert!(found.force[2].value > 1e3, "it touches");
        let step = 1e-6;
        let at = |t: f64| {
            let moved = |values: [f64; 3], slopes: [f64; 3]| {
                let numbers: [f64; 3] = from_fn(|k| values[k] + t * slopes[k]);
                numbers
            };
            let state = PointMotion {
                place: moved(motion.place, slope.place),
                velocity: moved(motion.velocity, slope.velocity),
                spin: moved(motion.spin, slope.spin),
                axes: from_fn(|axis| moved(motion.axes[axis], slope.axes[axis])),
            };
            let force = tyre.force(&state.fixed());
            [force.force, force.torque]
        };
        let (before, after) = (at(-step), at(step));
        let both = [found.force, found.torque];
        for (place, found) in both.iter().flatten().enumerate() {
            let ends = [before, after].map(|both| both[place / 3][place % 3].value);
            let difference = (ends[1] - ends[0]) / (2.0 * step);
            let error = (found.slope - difference).abs();
            assert!(error < 1e-6 * (1e4 + difference.abs()), "{place}: {error}");
        }
    }
}

/// Force times velocity at the ground is the power of force and torque.
#[test]
fn power_is_that_of_force_and_torque() {
    let (motion, _) = general();
    for law in [LINEAR, BAKKER] {
        let mut tyre = tyre(law);
        tyre.contact.normal = [0.1, -0.2, 2.0];
        tyre.contact.damping = 300.0;
        let found = tyre.force(&motion.fixed());
        let [force, torque] = [found.force, found.torque].map(|v| v.map(|part| part.value));
        let [gap, rate] = tyre.gap(&motion.fixed());
        assert!(gap.value < 0.0, "it touches");
        let spring = -tyre.contact.stiffness * gap.value * rate.value;
        let power = dot(force, motion.velocity) + dot(torque, motion.spin) - spring;
        assert!((power - found.power).abs() < 1e-9 * spring.abs().max(1e5));
    }
}

#[test]
fn a_wheel_that_lies_flat_has_no_slip() {
    let mut motion = rolling(3.0, [0.1, 0.2]);
    motion.place[2] = -0.01;
    motion.axes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];
    let tyre = tyre(LINEAR);
    assert!(tyre.lies_flat(&motion));
    let force = tyre.force(&motion.fixed()).force.map(|part| part.value);
    assert_eq!(force[..2], [0.0, 0.0]);
    assert!(force[2] > 0.0);
}
