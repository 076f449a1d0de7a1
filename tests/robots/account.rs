//! Mass matrix and forces of a robot, straight from the numbers of its file:
//! every link in the frame of the world, Rodrigues' rotations, geometric
//! Jacobians of the centres of mass. No code of the reader is used.

use super::draw::{DrawnJoint, DrawnLink, DrawnPlace, DrawnRobot};
use std::array::from_fn;
use std::collections::BTreeMap;

type Vector = [f64; 3];
type Matrix = [[f64; 3]; 3];

/// Position and velocity of a freedom.
pub(super) type Motion = (f64, f64);

/// Freedom of a link: a direction in the world, and for a turn a point on it.
#[derive(Clone)]
pub(super) struct Freedom {
    pub(super) name: String,
    axis: Vector,
    point: Option<Vector>,
}

/// A frame in the world: its pose and its motion without accelerations of the
/// joints.
#[derive(Clone)]
pub(super) struct WorldFrame {
    pub(super) rotation: Matrix,
    pub(super) origin: Vector,
    pub(super) spin: Vector,
    /// Of the spin.
    pub(super) rate: Vector,
    /// Of the origin.
    pub(super) acceleration: Vector,
    pub(super) freedoms: Vec<Freedom>,
}

/// The mass matrix and the forces at rest and in motion, by names of freedoms.
#[derive(Default)]
pub(super) struct Account {
    pub(super) mass: BTreeMap<(String, String), f64>,
    pub(super) bias: BTreeMap<String, f64>,
    /// The frame of every link.
    pub(super) frames: Vec<WorldFrame>,
}

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const GRAVITY: Vector = [0.0, 0.0, -9.81];

pub(super) fn add(a: Vector, b: Vector) -> Vector {
    from_fn(|i| a[i] + b[i])
}

pub(super) fn scaled(a: Vector, s: f64) -> Vector {
    a.map(|x| x * s)
}

fn dot(a: Vector, b: Vector) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross(a: Vector, b: Vector) -> Vector {
    from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

fn times(m: &Matrix, v: Vector) -> Vector {
    m.map(|row| dot(row, v))
}

pub(super) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    from_fn(|i| from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Rodrigues' formula: the rotation about a direction of length one.
fn rotation(axis: Vector, angle: f64) -> Matrix {
    let (sine, cosine) = angle.sin_cos();
    from_fn(|row| {
        let mut unit = [0.0; 3];
        unit[row] = 1.0;
        // The row of the matrix is what its transpose makes of the unit.
        let across = cross(unit, axis);
        let along = axis[row] * (1.0 - cosine);
        from_fn(|column| cosine * unit[column] + sine * across[column] + along * axis[column])
    })
}

pub(super) fn unit(v: Vector) -> Vector {
    scaled(v, 1.0 / dot(v, v).sqrt())
}

/// Fixed axes: roll about x, pitch about y, yaw about z.
pub(super) fn of_angles([roll, pitch, yaw]: Vector) -> Matrix {
    let turned = product(
        &rotation([0.0, 1.0, 0.0], pitch),
        &rotation([1.0, 0.0, 0.0], roll),
    );
    product(&rotation([0.0, 0.0, 1.0], yaw), &turned)
}

/// The shortest rotation that takes z to a direction.
fn of_normal(normal: Vector) -> Matrix {
    let aside = cross([0.0, 0.0, 1.0], normal);
    let size = dot(aside, aside).sqrt();
    if size == 0.0 {
        let half = if normal[2] < 0.0 {
            std::f64::consts::PI
        } else {
            0.0
        };
        return rotation([1.0, 0.0, 0.0], half);
    }
    rotation(scaled(aside, 1.0 / size), size.atan2(normal[2]))
}

impl WorldFrame {
    fn base() -> WorldFrame {
        WorldFrame {
            rotation: IDENTITY,
            origin: [0.0; 3],
            spin: [0.0; 3],
            rate: [0.0; 3],
            acceleration: [0.0; 3],
            freedoms: Vec::new(),
        }
    }

    /// Velocity of the origin and angular velocity for a unit of each freedom.
    pub(super) fn columns(&self) -> Vec<(Vector, Vector)> {
        let freedoms = self.freedoms.iter();
        let column = |freedom: &Freedom| match freedom.point {
            None => (freedom.axis, [0.0; 3]),
            Some(point) => {
                let arm = add(self.origin, scaled(point, -1.0));
                (cross(freedom.axis, arm), freedom.axis)
            }
        };
        freedoms.map(column).collect()
    }

    /// Moved by an offset in the world that is fixed to the frame.
    fn moved(&self, offset: Vector) -> WorldFrame {
        let swing = cross(self.spin, cross(self.spin, offset));
        WorldFrame {
            origin: add(self.origin, offset),
            acceleration: add(self.acceleration, add(cross(self.rate, offset), swing)),
            ..self.clone()
        }
    }

    fn placed(&self, place: &DrawnPlace) -> WorldFrame {
        let moved = self.moved(times(&self.rotation, place.offset));
        WorldFrame {
            rotation: product(&self.rotation, &of_angles(place.angles)),
            ..moved
        }
    }

    /// Turned about a direction of the frame.
    fn turned(&self, name: String, axis: Vector, (q, rate): Motion) -> WorldFrame {
        let world = times(&self.rotation, axis);
        let mut next = self.clone();
        next.rotation = product(&self.rotation, &rotation(axis, q));
        next.rate = add(self.rate, scaled(cross(self.spin, world), rate));
        next.spin = add(self.spin, scaled(world, rate));
        next.freedoms.push(Freedom {
            name,
            axis: world,
            point: Some(self.origin),
        });
        next
    }

    /// Slid along a direction of the frame.
    fn slid(&self, name: String, axis: Vector, (q, rate): Motion) -> WorldFrame {
        let world = times(&self.rotation, axis);
        let mut next = self.moved(scaled(world, q));
        let sideways = scaled(cross(self.spin, world), 2.0 * rate);
        next.acceleration = add(next.acceleration, sideways);
        next.freedoms.push(Freedom {
            name,
            axis: world,
            point: None,
        });
        next
    }

    /// Behind three slides, yaw, pitch and roll.
    fn freed(&self, name: &str, motion: &dyn Fn(&str) -> Motion) -> WorldFrame {
        let mut frame = self.clone();
        for (place, suffix) in ["x", "y", "z"].into_iter().enumerate() {
            let full = format!("{name}_{suffix}");
            let value = motion(&full);
            frame = frame.slid(full, IDENTITY[place], value);
        }
        for (place, suffix) in [(2, "yaw"), (1, "pitch"), (0, "roll")] {
            let full = format!("{name}_{suffix}");
            let value = motion(&full);
            frame = frame.turned(full, IDENTITY[place], value);
        }
        frame
    }
}

/// The frame of the link beyond a joint.
fn behind(
    joint: &DrawnJoint,
    name: String,
    parent: &WorldFrame,
    motion: &dyn Fn(&str) -> Motion,
) -> WorldFrame {
    let frame = parent.placed(&joint.place);
    let axis = unit(joint.axis);
    match joint.kind {
        "fixed" => frame,
        "floating" => frame.freed(&name, motion),
        "planar" => {
            // In the plane and back to the axes of the link.
            let turn = of_normal(axis);
            let column = |k: usize| turn.map(|row| row[k]);
            let [x, y, angle] = ["x", "y", "angle"].map(|suffix| format!("{name}_{suffix}"));
            let values = [&x, &y, &angle].map(|name| motion(name));
            let across = frame
                .slid(x, column(0), values[0])
                .slid(y, column(1), values[1]);
            across.turned(angle, axis, values[2])
        }
        "prismatic" => {
            let value = motion(&name);
            frame.slid(name, axis, value)
        }
        _ => {
            let value = motion(&name);
            frame.turned(name, axis, value)
        }
    }
}

impl Account {
    /// The account of a robot in a state, on a fixed or a free base.
    pub(super) fn new(robot: &DrawnRobot, free: bool, motion: &dyn Fn(&str) -> Motion) -> Account {
        let base = WorldFrame::base();
        let mut frames = vec![if free {
            base.freed("base", motion)
        } else {
            base
        }];
        let mut account = Account::default();
        account.weigh(&robot.links[0], &frames[0]);
        for (index, joint) in robot.joints.iter().enumerate() {
            let frame = behind(joint, format!("j{index}"), &frames[joint.parent], motion);
            account.weigh(&robot.links[index + 1], &frame);
            frames.push(frame);
        }
        account.frames = frames;
        account
    }

    fn weigh(&mut self, link: &DrawnLink, frame: &WorldFrame) {
        let frame = frame.placed(&link.center);
        let [xx, xy, xz, yy, yz, zz] = link.inertia;
        let local = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let transposed: Matrix = from_fn(|i| from_fn(|j| frame.rotation[j][i]));
        let inertia = product(&frame.rotation, &product(&local, &transposed));
        let push = scaled(add(frame.acceleration, scaled(GRAVITY, -1.0)), link.mass);
        let gyration = cross(frame.spin, times(&inertia, frame.spin));
        let twist = add(times(&inertia, frame.rate), gyration);
        let columns = frame.columns();
        for (one, (velocity, spin)) in frame.freedoms.iter().zip(&columns) {
            *self.bias.entry(one.name.clone()).or_default() +=
                dot(*velocity, push) + dot(*spin, twist);
            for (other, (second, turning)) in frame.freedoms.iter().zip(&columns) {
                let key = (one.name.clone(), other.name.clone());
                *self.mass.entry(key).or_default() +=
                    link.mass * dot(*velocity, *second) + dot(*spin, times(&inertia, *turning));
            }
        }
    }
}
